"""What gRPC's HTTP/2 lets strangers do: memory stays bounded, a caller with a token is served, the connection ends."""

import contextlib
import hashlib
import json
import pathlib
import statistics
import subprocess
import sys
import time

import grpc
from curvd_process import wait_for
from fault import Fault
from raw_calls import cloud_requests
from stranger_faults import Authority

_TOKEN = "curvd_friend_" + "7" * 52
_INSIDERS_TOKEN = "curvd_insider_" + "7" * 51
_ESTIMATE = "/curvature.v1.CurvatureService/EstimateCurvature"
_CHECK = "/grpc.health.v1.Health/Check"
_MIB = 1 << 20
_MEMORY_LIMIT_MIB = 256
_MOST_MIB = _MEMORY_LIMIT_MIB + 64
_MOST_TIMES_IDLE = 10
_REASONS = ("unaccounted_bytes", "too_much_metadata", "memory_short")


class _Door:
    """A curvd that asks for a token, over TLS or not, with a health port; and a caller who has the token."""

    def __init__(self, site, opened, tls):
        folder = pathlib.Path(site.scratch) / f"door-{time.monotonic_ns()}"
        folder.mkdir()
        tokens = folder / "tokens"
        tokens.write_text("".join(
            f"{name} sha256:{hashlib.sha256(token.encode()).hexdigest()}\n"
            for name, token in (("the-friend", _TOKEN), ("the-insider", _INSIDERS_TOKEN))), encoding="utf-8")
        flags, self.ca = [], None
        if tls:
            authority = Authority(folder / "authority")
            certificate, key = authority.issue("localhost")
            flags, self.ca = [f"--tls-cert={certificate}", f"--tls-key={key}"], authority.certificate
        self.server = opened.enter_context(site.server(
            f"--memory-limit={_MEMORY_LIMIT_MIB}MiB", f"--token-file={tokens}", "--health-listen=127.0.0.1:0", *flags))
        self.health_address = self.server.lines_field("health_listen")
        self._channel = opened.enter_context(
            grpc.secure_channel(self.server.address, grpc.ssl_channel_credentials(self.ca.read_bytes()))
            if tls else grpc.insecure_channel(self.server.address))
        self._messages = list(cloud_requests(1_000))

    def call(self):
        """The friend has 1,000 points estimated; returns the seconds that it took."""
        began = time.monotonic()
        metadata = [("authorization", f"Bearer {_TOKEN}")]
        assert list(self._channel.stream_stream(_ESTIMATE)(iter(self._messages), metadata=metadata, timeout=60))
        return time.monotonic() - began

    def idle_seconds(self):
        for _ in range(20):
            self.call()
        return statistics.median(self.call() for _ in range(50))

    def ended(self):
        """Connections that the guard has ended."""
        return sum(self.server.metric(f'curvd_strangers_total{{reason="{reason}"}}') for reason in _REASONS)


def _strangers(lines):
    return sum('"event":"stranger"' in line for line in lines)


def _attack(name, *flags, tls=False, health=False, with_token=False, connections=1):
    """Trials of an attack of http2_attacks.py."""

    def trials(site, times):
        with contextlib.ExitStack() as opened:
            door = _Door(site, opened, tls)
            idle = door.idle_seconds()
            for _ in range(times):
                yield _try(door, idle)
            peak = door.server.peak_resident_bytes()
            assert peak < _MOST_MIB * _MIB, f"the process had {peak / _MIB:.0f} MiB"

    def _try(door, idle):
        ended, logged = door.ended(), len(door.server.lines)
        began = time.monotonic()
        attack = subprocess.Popen(
            [sys.executable, pathlib.Path(__file__).parent / "http2_attacks.py", name,
             door.health_address if health else door.server.address, f"--connections={connections}",
             *(["--tls", door.ca] if tls else []), *(["--token", _INSIDERS_TOKEN] if with_token else []), *flags],
            stdout=subprocess.PIPE, text=True)
        beside = [door.call()]
        while attack.poll() is None:
            beside.append(door.call())
        seconds = time.monotonic() - began
        result = json.loads(attack.communicate()[0])
        left = result["tried"] - result["closed"]
        assert left == 0, f"{left} connections were left open"
        if not health:  # where gRPC itself may be the first to end a connection, which nobody counts
            wait_for(lambda: door.ended() > ended, 30, "nothing was counted")
            wait_for(lambda: _strangers(door.server.lines[logged:]) > 0, 30, "nothing was logged")
        lines = _strangers(door.server.lines[logged:])
        assert lines <= 20 * (seconds + 2), f"{lines} lines were logged in {seconds} s"
        median = statistics.median(beside)
        assert median < _MOST_TIMES_IDLE * idle, f"the friend's calls took {median} s, {idle} s when idle"
        peak = door.server.peak_resident_bytes()
        assert peak < _MOST_MIB * _MIB, f"the process had {peak / _MIB:.0f} MiB"
        print(f"{name} {' '.join(flags)}: peak {peak / _MIB:.0f} MiB; calls beside {median * 1e3:.1f} ms, longest "
              f"{max(beside) * 1e3:.0f} ms, idle {idle * 1e3:.1f} ms; ended after {result['longest']} s", file=sys.stderr)
        return result["longest"]

    return trials


_NAMES = {
    "references": "references to a header, no SETTINGS ACK",
    "long_string": "a header of 63 MiB in small frames",
    "rapid_reset": "rapid reset",
    "half_messages": "200 half messages",
    "many_streams": "30,000 calls on a connection",
}

# They judge times, which a machine that is busy with other tests does not keep.
FAULTS = [
    *(Fault(title, _attack(name), slow=True) for name, title in _NAMES.items()),
    *(Fault(f"{title}, TLS", _attack(name, tls=True), slow=True) for name, title in _NAMES.items()),
    *(Fault(f"{title}, health port", _attack(name, *(["--path", _CHECK] if name == "half_messages" else []), health=True),
            slow=True)
      for name, title in _NAMES.items()),
    *(Fault(f"{title}, by a caller with a token", _attack(name, "--path", _ESTIMATE, with_token=True), slow=True)
      for name, title in _NAMES.items() if name in ("references", "half_messages")),
    *(Fault(f"{_NAMES[name]}, 100 connections for 10 s", _attack(name, "--repeat=10", connections=100), slow=True)
      for name in ("references", "rapid_reset", "long_string")),
]
