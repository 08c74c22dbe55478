"""The same attacks by HTTP/2 on Debian's HAProxy, which stands before the server as deploy/haproxy.cfg says."""

import contextlib
import pathlib
import shutil
import socket
import subprocess

from fault import Fault
from guarded_door import Door

_CONFIGURATION = pathlib.Path(__file__).parents[2] / "deploy" / "haproxy.cfg"
_PROGRAM = shutil.which("haproxy") or shutil.which("haproxy", path="/usr/sbin")
# All callers come from HAProxy's address.
_FLAGS = ["--max-connections-per-peer=2000"]


def _free_port():
    with socket.create_server(("127.0.0.1", 0)) as probe:
        return probe.getsockname()[1]


@contextlib.contextmanager
def _haproxy(folder, door, port):
    """HAProxy at `port`, before the server of `door`. What the file says of addresses is replaced, and nothing else."""
    text = _CONFIGURATION.read_text(encoding="utf-8")
    for shown, meant in (("127.0.0.1:50071", f"127.0.0.1:{port}"), ("127.0.0.1:50061", door.server.address),
                         ("connect port 50062", f"connect port {door.health_address.rpartition(':')[2]}")):
        assert shown in text, f"{_CONFIGURATION} has no {shown}"
        text = text.replace(shown, meant)
    configuration = folder / f"haproxy-{port}.cfg"
    configuration.write_text(text, encoding="utf-8")
    process = subprocess.Popen([_PROGRAM, "-db", "-f", configuration], stdout=subprocess.DEVNULL,
                               stderr=subprocess.DEVNULL)
    try:
        yield
    finally:
        process.kill()
        process.wait()


def _behind_haproxy(name, *flags):
    """Trials of an attack. HAProxy may keep the attacker's connection, and let nothing of the attack through."""

    def trials(site, times):
        with contextlib.ExitStack() as opened:
            port = _free_port()

            def front(door):
                opened.enter_context(_haproxy(site.scratch, door, port))
                return f"127.0.0.1:{port}"

            door = Door(site, opened, flags=_FLAGS, front=front)
            for _ in range(times):
                yield door.attack(name, "--linger=3", *flags, may_stay=True, counts=False)[1]

    return trials


_ROWS = {
    "references": "references to a header",
    "long_string": "a header of 63 MiB",
    "rapid_reset": "rapid reset",
    "half_messages": "200 half messages",
    "many_streams": "30,000 calls",
}

FAULTS = [
    Fault(f"behind HAProxy: {title}", _behind_haproxy(name), slow=True, guard=True,
          needs=lambda: "" if _PROGRAM else "haproxy is not installed")
    for name, title in _ROWS.items()
]
