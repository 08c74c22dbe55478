"""Networks that break between client and server."""

import contextlib
import time

from fault import Fault
from proxy import Proxy

# What the server's keepalive takes to find a peer that is silent: 10 s to ask and 5 s to wait, and a second for the rest.
_SILENCE_SECONDS = 16
_POINT_BYTES = 24 + 45  # up and down


def network_cut(site, times):
    """The connection is reset at any byte of the call, or at any moment; the client finds the same server again."""
    with site.server() as server, Proxy(server.address) as proxy:
        for trial in range(times):
            process = site.start_estimate(proxy.address)
            proxy.cut_happened.clear()
            if trial % 2 == 0:
                proxy.cut_after(site.random.randrange(_POINT_BYTES * site.points))
                proxy.cut_happened.wait(60)
            else:
                time.sleep(site.random_moment())
                proxy.cut()
            cut = time.monotonic()
            site.check(site.finish(process))
            yield time.monotonic() - cut
            server.wait_until_idle()


def half_open(site, times):
    """The network goes silent, so that each side believes in a connection that is gone. All trials at once."""
    with site.server() as silent, site.server() as other, contextlib.ExitStack() as opened:
        proxies = [opened.enter_context(Proxy(silent.address)) for _ in range(times)]
        calls = []
        for proxy in proxies:
            # A frozen connection before the only other way: whichever is tried first, the call must not hang.
            calls.append((proxy, site.start_estimate(f"{proxy.address},{other.address}")))
            time.sleep(site.random_moment())
            proxy.freeze()
            calls[-1][1].frozen = time.monotonic()
        for _, process in calls:
            run = site.finish(process)
            site.check(run)
            yield max(0.0, process.began + run.seconds - process.frozen)
        silent.wait_until_idle(4 * _SILENCE_SECONDS)


FAULTS = [
    Fault("network cut", network_cut),
    Fault("half-open connection", half_open, slow=True),
]
