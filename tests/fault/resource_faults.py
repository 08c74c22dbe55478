"""Machines that run out of memory, and clocks that jump."""

import contextlib
import os
import pathlib
import resource
import time

from curvd_process import wait_for
from fault import Fault

_CONTAINER_BYTES = 256 << 20
_CLIENTS = 8
_LEFT_TO_LIBRARIES = 32 << 20  # core/base/page_pool.h
_TRIES = 50
_LARGE_CLOUD_POINTS = 4_000_000
_WORKERS = (1, 2, 8)
_CALL_SECONDS = 300
_REFUSALS = ("OUT_OF_MEMORY", "NEIGHBORHOOD_TOO_LARGE", "MEMORY_LIMIT")
_OUT_OF_MEMORY = 'curvd_failures_total{reason="OUT_OF_MEMORY"}'


class MemoryGroup:
    """A control group with a limit on memory, as a container is. Usable with `with`."""

    _V1 = pathlib.Path("/sys/fs/cgroup/memory")
    _V2 = pathlib.Path("/sys/fs/cgroup")

    def __init__(self, limit_bytes):
        self._is_v1 = self._V1.is_dir()
        self.path = (self._V1 if self._is_v1 else self._V2) / f"curvd-fault-{os.getpid()}"
        self.path.mkdir()
        self._file("memory.limit_in_bytes", "memory.max").write_text(str(limit_bytes))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        # The processes have been waited for; the kernel takes a moment to let go of them.
        wait_for(self._removed, 10, f"{self.path} cannot be removed")

    def _removed(self):
        with contextlib.suppress(OSError):
            self.path.rmdir()
        return not self.path.exists()

    def _file(self, v1, v2):
        return self.path / (v1 if self._is_v1 else v2)

    def enter(self):
        """Takes the calling process in."""
        (self.path / "cgroup.procs").write_text("0")

    def killed(self):
        """Processes that the kernel killed for want of memory."""
        events = self._file("memory.oom_control", "memory.events").read_text().split()
        return int(events[events.index("oom_kill") + 1])


def _no_group():
    try:
        with MemoryGroup(_CONTAINER_BYTES) as group:
            group.killed()
    except (OSError, ValueError) as error:
        return f"no control group may be made ({error})"
    return ""


def memory_of_the_container(site, times):
    """Clients ask for several times the container's memory at once. All are served in turn; nobody is killed."""
    with MemoryGroup(_CONTAINER_BYTES) as group, site.server(before_exec=group.enter) as server:
        limit = server.metric("curvd_memory_limit_bytes")
        assert 0 < limit < _CONTAINER_BYTES, f"curvd took {limit} for the container's memory"
        for _ in range(times):
            began = time.monotonic()
            for process in [site.start_estimate(server.address) for _ in range(_CLIENTS)]:
                site.check(site.finish(process))
            server.wait_until_idle()
            assert group.killed() == 0 and server.alive(), "the kernel killed curvd"
            yield time.monotonic() - began


def memory_refused(site, times):
    """The system gives a server no more memory for clouds. Its calls end up on the other replica."""
    for _ in range(times):
        with site.server() as poor, site.server() as other:  # new ones: they keep pages for the next call
            memory = _mapped_bytes(poor.process.pid) + _LEFT_TO_LIBRARIES + site.random.randrange(24 * site.points)
            resource.prlimit(poor.process.pid, resource.RLIMIT_AS, (memory, resource.RLIM_INFINITY))
            for _ in range(_TRIES):  # a call may begin at the other replica
                began = time.monotonic()
                site.check(site.estimate(f"{poor.address},{other.address}"))
                assert poor.alive(), "curvd has ended"
                if poor.metric(_OUT_OF_MEMORY) > 0:
                    break
            else:
                raise AssertionError(f"curvd refused none of {_TRIES} calls")
            resource.prlimit(poor.process.pid, resource.RLIMIT_AS, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
            site.check(site.estimate(poor.address))
            yield time.monotonic() - began


def neighborhoods_larger_than_the_memory(site, times):
    """A radius takes in a whole cloud, on servers with less and less memory. The call fails; the server serves on.

    Every limit and number of workers is tried once, whatever `times` is.
    """
    del times
    large = site.cloud_of(_LARGE_CLOUD_POINTS)
    for threads in _WORKERS:
        for megabytes in range(300, 2001, 50):
            limit = megabytes * 1_000_000
            with site.server(f"--threads={threads}", before_exec=lambda: _limit_memory(limit)) as server:
                # With many threads the stacks of an idle server fill the least limits: nothing can be served there.
                serves = site.estimate(server.address, "--max-attempts=1").exit_code == 0
                began = time.monotonic()
                process = site.start_estimate(
                    server.address, "--radius=100", "--estimator=uniform", "--max-attempts=1", cloud=large
                )
                answer = process.communicate(timeout=_CALL_SECONDS)[0]
                what = f"{megabytes} MB, {threads} threads"
                assert server.alive(), f"curvd has ended ({what})"
                refused = any(reason in answer for reason in _REFUSALS)
                assert process.returncode == 0 or refused, f"the call failed otherwise ({what}): {answer}"
                run = site.estimate(server.address)
                assert server.alive(), f"curvd has ended after a small call ({what})"
                if serves:
                    site.check(run)
                yield time.monotonic() - began


def _limit_memory(limit_bytes):
    resource.setrlimit(resource.RLIMIT_AS, (limit_bytes, limit_bytes))


def _mapped_bytes(pid):
    return int(pathlib.Path(f"/proc/{pid}/statm").read_text().split()[0]) * os.sysconf("SC_PAGE_SIZE")


def clock_jumps(site, times):
    """The machine's time is set back or forth by up to a month, for client and server, at any moment of a call."""
    setting = site.scratch / "time"
    setting.write_text("+0s")
    environment = {
        "LD_PRELOAD": str(_faketime_library()),
        "FAKETIME_TIMESTAMP_FILE": str(setting),
        "FAKETIME_NO_CACHE": "1",
        "FAKETIME_DONT_FAKE_MONOTONIC": "1",  # what a machine keeps when its time is set
    }
    with site.server(environment=environment) as server:
        for _ in range(times):
            process = site.start_estimate(server.address, "--timeout=100", env={**os.environ, **environment})
            time.sleep(site.random_moment())
            _replace(setting, f"{site.random.choice('+-')}{site.random.randrange(30 * 86_400)}s")
            jumped = time.monotonic()
            site.check(site.finish(process))
            yield time.monotonic() - jumped
            server.wait_until_idle()
        negative = [line for line in server.lines if '":-' in line]
        assert not negative, f"a duration is negative: {negative[0]}"


def _replace(file, text):
    fresh = file.with_suffix(".fresh")
    fresh.write_text(text)
    fresh.rename(file)


def _faketime_library():
    found = sorted(pathlib.Path("/usr/lib").glob("*/faketime/libfaketimeMT.so.1"))
    return found[0] if found else None


FAULTS = [
    Fault("more asked for than the container has", memory_of_the_container, needs=_no_group),
    Fault("the system gives no memory", memory_refused),
    Fault("neighborhoods larger than the memory", neighborhoods_larger_than_the_memory, slow=True),
    Fault("clock jumps", clock_jumps, needs=lambda: "" if _faketime_library() else "libfaketime is not installed"),
]
