"""Servers that die, stand still, or are told to stop."""

import signal
import time

from curvd_process import wait_for
from fault import Fault
from raw_calls import Call, cloud_requests, is_serving

_REPLICAS = 2
# Minutes of work, so that a call is open for as long as a trial wants it to be.
_ENDLESS = {"estimator": "ESTIMATOR_UNIFORM", "neighbor_count": 5_000, "triangle_count": 10_000}
_DRAINED = 0
_ENDED_AT_ONCE = 3


class Replicas:
    """Servers that do the same work, one of which can be brought back where it was."""

    def __init__(self, site, *flags):
        self._site = site
        self._flags = flags
        self.servers = [site.server(*flags) for _ in range(_REPLICAS)]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for server in self.servers:
            server.kill()

    @property
    def addresses(self):
        return ",".join(server.address for server in self.servers)

    def busy(self):
        """The server that has the call, or None."""
        return next((server for server in self.servers if server.metric("curvd_streams_open") > 0), None)

    def restart(self, server):
        self.servers[self.servers.index(server)] = self._site.server(*self._flags, like=server)


def server_killed(site, times):
    """kill -9 of the replica that has the call, in each phase of it; the other finishes it."""
    with Replicas(site) as replicas:
        for _ in range(times):
            process = site.start_estimate(replicas.addresses)
            time.sleep(site.random_moment())
            victim = replicas.busy() or site.random.choice(replicas.servers)
            victim.kill()
            killed = time.monotonic()
            site.check(site.finish(process))
            yield time.monotonic() - killed
            replicas.restart(victim)


def only_server_killed(site, times):
    """kill -9 of the only server there is, which comes back on its port a moment later."""
    server = site.server()
    try:
        for _ in range(times):
            # A busy machine may take longer to start a server than a client waits that has never reached one.
            process = site.start_estimate(server.address, "--connect-timeout=60")
            time.sleep(site.random_moment())
            server.kill()
            time.sleep(site.random.random())
            server = site.server(like=server)
            back = time.monotonic()
            site.check(site.finish(process))
            yield time.monotonic() - back
    finally:
        server.kill()


def slow_worker(site, times):
    """The server's process is not run for up to two seconds, as on a machine that is short of CPU."""
    with site.server() as server:
        for _ in range(times):
            process = site.start_estimate(server.address)
            time.sleep(site.random_moment())
            server.signal(signal.SIGSTOP)
            time.sleep(2 * site.random.random())
            server.signal(signal.SIGCONT)
            continued = time.monotonic()
            site.check(site.finish(process))
            yield time.monotonic() - continued


def server_frozen(site, times):
    """A replica stops for good without closing anything; calls end up on the other. All trials at once."""
    with Replicas(site) as replicas:
        frozen, other = replicas.servers
        calls = [site.start_estimate(frozen.address + "," + other.address) for _ in range(times)]
        time.sleep(site.random_moment())
        frozen.signal(signal.SIGSTOP)
        stopped = time.monotonic()
        for process in calls:
            run = site.finish(process)
            site.check(run)
            yield max(0.0, process.began + run.seconds - stopped)


def drain(site, times):
    """SIGTERM during a call: it is finished, new ones go to the other replica, and the process ends with 0."""
    with Replicas(site, "--drain-timeout=30s") as replicas:
        for _ in range(times):
            process = site.start_estimate(replicas.addresses)
            time.sleep(site.random_moment())
            leaving = replicas.busy() or site.random.choice(replicas.servers)
            leaving.signal(signal.SIGTERM)
            told = time.monotonic()
            if leaving.metric_or_none("curvd_draining") == 1:
                assert is_serving(leaving.address) is not True, "health says SERVING while draining"
            site.check(site.estimate(replicas.addresses))
            site.check(site.finish(process))
            assert leaving.process.wait(60) == _DRAINED
            yield time.monotonic() - told
            replicas.restart(leaving)


def drain_timeout(site, times):
    """SIGTERM while a call runs that does not end in time: it is told so, and the process ends with 0."""
    for _ in range(times):
        with site.server("--drain-timeout=200ms") as server, Call(server.address) as call:
            call.send(cloud_requests(site.points, **_ENDLESS))
            wait_for(lambda: server.metric("curvd_workers_busy") > 0, 60, "no estimate has started")
            server.signal(signal.SIGTERM)
            told = time.monotonic()
            assert call.status().name == "UNAVAILABLE", call.status()
            assert call.reason() == "DRAIN_TIMEOUT", call.reason()
            assert server.process.wait(60) == _DRAINED
            yield time.monotonic() - told


def second_signal(site, times):
    """Two signals end the process at once, whatever runs; a client with another replica loses nothing."""
    with Replicas(site, "--drain-timeout=10m") as replicas:
        for _ in range(times):
            process = site.start_estimate(replicas.addresses)
            time.sleep(site.random_moment())
            leaving = replicas.busy() or replicas.servers[0]
            with Call(leaving.address) as endless:
                endless.send(cloud_requests(site.points, **_ENDLESS))
                wait_for(lambda: leaving.metric("curvd_streams_open") > 0, 60, "the call is not open")
                leaving.signal(signal.SIGTERM)
                leaving.wait_for_line('"event":"draining"')
                leaving.signal(signal.SIGTERM)
                told = time.monotonic()
                assert leaving.process.wait(5) == _ENDED_AT_ONCE
                ended = time.monotonic() - told
            site.check(site.finish(process))
            yield ended
            replicas.restart(leaving)


FAULTS = [
    Fault("server killed, two replicas", server_killed),
    Fault("server killed, restarted", only_server_killed),
    Fault("slow worker", slow_worker),
    Fault("server frozen for good", server_frozen, slow=True),
    Fault("drain", drain),
    Fault("drain timeout", drain_timeout),
    Fault("second signal", second_signal),
]
