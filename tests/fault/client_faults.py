"""Clients that die, stop reading, or have no room for what they asked for."""

import contextlib
import os
import resource
import signal
import subprocess
import time

from curvd_process import wait_for
from fault import Fault
from raw_calls import Call, cloud_requests


# Their results fill every buffer on the way.
_UNREAD_POINTS = 600_000


def client_killed(site, times):
    """kill -9 at any moment of a call, while another client is served."""
    with site.server() as server:
        for _ in range(times):
            victim, other = site.start_estimate(server.address), site.start_estimate(server.address)
            time.sleep(2 * site.random_moment() * site.random.random())
            victim.kill()
            killed = time.monotonic()
            victim.wait()
            site.check(site.finish(other))
            server.wait_until_idle()
            yield time.monotonic() - killed
            assert not victim.result.exists() or victim.result.read_bytes() == site.expected, "half a file"
            _forget(victim.result)


def _forget(result):
    for file in result.parent.glob(result.name + "*"):
        file.unlink()


def reader_stalled(site, times):
    """A client sends its cloud and never reads. The server ends the call, and serves others meanwhile."""
    with site.server("--stall-timeout=500ms") as server:
        for trial in range(1, times + 1):
            with Call(server.address) as call:
                call.send(cloud_requests(_UNREAD_POINTS))
                began = time.monotonic()
                site.check(site.estimate(server.address))
                wait_for(
                    lambda: server.metric('curvd_failures_total{reason="STALLED"}') == trial, 30, "the stalled call lives"
                )
                server.wait_until_idle()
                yield time.monotonic() - began


def disk_full(site, times):
    """The disk under curv's output fills up. What was there before stays, and a run with room succeeds."""
    with site.server() as server, _small_disk(site) as disk:
        output = (disk or site.scratch) / "result.ply"
        for _ in range(times):
            output.write_bytes(b"the result of yesterday")
            room = site.random.randrange(1, len(site.expected))
            options = {} if disk else {"preexec_fn": _limit_file_size(room), "restore_signals": False}
            ballast = output.parent / "ballast"
            if disk:
                ballast.write_bytes(bytes(max(0, _free_bytes(disk) - room)))
            run = site.estimate(server.address, output=output, **options)
            assert run.exit_code == 4, f"curv ended with {run.exit_code}: {run.message}"
            assert run.bytes() == b"the result of yesterday", "the file of before is gone"
            ballast.unlink(missing_ok=True)
            left = [file.name for file in output.parent.iterdir() if file.name.startswith("result.ply")]
            assert left == ["result.ply"], f"left over: {left}"
            began = time.monotonic()
            site.check(site.estimate(server.address, output=output))
            yield time.monotonic() - began


@contextlib.contextmanager
def _small_disk(site):
    """A disk with room for one result, or None where none may be mounted: a limit on file sizes does then."""
    disk = site.scratch / "disk"
    disk.mkdir()
    size = len(site.expected) + (1 << 20)
    mount = ["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(disk)]
    mounted = os.getuid() == 0 and subprocess.run(mount, capture_output=True, check=False).returncode == 0
    try:
        yield disk if mounted else None
    finally:
        if mounted:
            subprocess.run(["umount", "--lazy", str(disk)], check=True)


def _free_bytes(disk):
    about = os.statvfs(disk)
    return about.f_bavail * about.f_frsize


def _limit_file_size(room):
    def limit():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)  # the write fails, as on a full disk
        resource.setrlimit(resource.RLIMIT_FSIZE, (room, room))

    return limit


FAULTS = [
    Fault("client killed", client_killed),
    Fault("reader stalled", reader_stalled),
    Fault("disk full under the output", disk_full),
]
