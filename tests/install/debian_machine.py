"""A copy of this Debian machine that may be changed, for debian_trial.py."""

import contextlib
import fcntl
import os
import pathlib
import signal
import socket
import struct
import subprocess
import time

START_SECONDS = 30
DRAIN_SECONDS = 60


def mount(kind, source, target, *options):
    subprocess.run(["mount", "-t", kind, *options, source, str(target)], check=True)


def raise_loopback():
    """Brings up the interface lo of this network namespace; see netdevice(7)."""
    siocgifflags, siocsifflags, iff_up = 0x8913, 0x8914, 0x1
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as any_socket:
        request = struct.pack("16sh14x", b"lo", 0)
        flags = struct.unpack("16sh14x", fcntl.ioctl(any_socket, siocgifflags, request))[1]
        fcntl.ioctl(any_socket, siocsifflags, struct.pack("16sh14x", b"lo", flags | iff_up))


def enter(packages):
    """Makes this process see the machine's files with an overlay in memory, and the folder of packages in /mnt.

    REQUIRES: the process is root in mount and network namespaces of its own, which take all of it away with them.
    """
    memory = pathlib.Path("/tmp")
    packages = os.open(packages, os.O_PATH)  # /tmp is hidden next
    mount("tmpfs", "curvd-trial", memory)
    root = memory / "root"
    for folder in ("upper", "work", "root"):
        (memory / folder).mkdir()
    mount("overlay", "curvd-trial", root, "-o", f"lowerdir=/,upperdir={memory}/upper,workdir={memory}/work")
    mount("proc", "proc", root / "proc")
    mount("tmpfs", "tmpfs", root / "tmp", "-o", "mode=1777")
    subprocess.run(["mount", "--rbind", "/dev", str(root / "dev")], check=True)
    subprocess.run(["mount", "--bind", f"/proc/self/fd/{packages}", str(root / "mnt")], check=True, pass_fds=[packages])
    os.chroot(root)
    os.chdir("/")
    os.environ.update(PATH="/usr/sbin:/usr/bin:/sbin:/bin", DEBIAN_FRONTEND="noninteractive")
    raise_loopback()


def free_ports():
    with socket.socket() as first, socket.socket() as second:
        first.bind(("127.0.0.1", 0))
        second.bind(("127.0.0.1", 0))
        return str(first.getsockname()[1]), str(second.getsockname()[1])


def wait_until_serving(process, environment):
    server = environment.get("CURVD_LISTEN", "127.0.0.1:50061")
    give_up = time.monotonic() + START_SECONDS
    while time.monotonic() < give_up:
        assert process.poll() is None, f"curvd ended with {process.returncode}"
        asked = ["curv", "info", "--health", f"--server={server}"]
        if subprocess.run(asked, env=environment, capture_output=True, check=False).returncode == 0:
            return
    raise AssertionError(f"curvd did not serve within {START_SECONDS} s")


@contextlib.contextmanager
def serving(command, user, environment):
    """A curvd of `user` (None: this one), which must end with 0 at SIGTERM."""
    identity = {"user": user, "group": user, "extra_groups": []} if user else {}
    process = subprocess.Popen(command, env=environment, cwd="/", **identity)
    try:
        wait_until_serving(process, environment)
        yield
    finally:
        process.send_signal(signal.SIGTERM)
        status = process.wait(DRAIN_SECONDS)
    assert status == 0, f"curvd ended with {status} after SIGTERM"
