"""Connections that nobody uses for long."""

import time

import grpc
from fault import Fault

# curvd's default of --idle-timeout, and some seconds.
_IDLE_SECONDS = 605
_CHANNELS_A_TRIAL = 5
_METHOD = "/curvature.v1.CurvatureService/GetServerInfo"


def _ask(channel):
    began = time.monotonic()
    channel.unary_unary(_METHOD)(b"", timeout=20)
    return time.monotonic() - began


def idle_channels(site, times):
    """Channels of one process without a call for --idle-timeout: their first calls after that must succeed. All at once."""
    with site.server() as server:
        alone = [("grpc.use_local_subchannel_pool", 1)]
        channels = [grpc.insecure_channel(server.address, alone) for _ in range(times * _CHANNELS_A_TRIAL)]
        for channel in channels:
            _ask(channel)
        open_count = server.metric("curvd_connections_open")
        assert open_count == len(channels), f"{open_count} of {len(channels)} channels are connected"
        time.sleep(30)  # twice what keepalive takes
        left = server.metric("curvd_connections_open")
        assert left == len(channels), f"{left} of {len(channels)} connections are left after 30 s"
        time.sleep(_IDLE_SECONDS - 30)
        for trial in range(times):
            yield max(_ask(channel) for channel in channels[trial::times])
        for channel in channels:
            channel.close()


FAULTS = [
    Fault("idle channels", idle_channels, slow=True),
]
