"""Reads where servers are: HOST, HOST:PORT, a gRPC target, or several with commas between."""

from __future__ import annotations

import ipaddress
import random
import re
import socket

from curvd_client.fields import shown

DEFAULT_PORT = 50061
DEFAULT_SERVER = f"localhost:{DEFAULT_PORT}"

# Targets of gRPC. Those of the first kind are themselves lists with commas between.
_LISTS = ("ipv4:", "ipv6:")
_PATHS = ("unix:", "unix-abstract:", "vsock:", "xds:")

# What people paste from a browser, and any other scheme that gRPC would look up as a part of a name.
_URL = re.compile(r"(?!(?:dns|ipv4|ipv6|unix|unix-abstract|vsock|xds):)([A-Za-z][A-Za-z\d+.-]{0,20})://")


def split_servers(server: str) -> list[str]:
    """The targets of the channels to open, each with a port. Raises ValueError if one is empty, a URL that is no target of gRPC, or has a
    port that is none.

    A list with commas between gives one target each; "ipv4:A:1,B:2" is one target, with two addresses.
    """
    require_server(server)
    targets: list[str] = []
    for part in (each.strip() for each in server.split(",")):
        is_bare = not part.startswith((*_LISTS, *_PATHS, "dns:"))
        is_continued = is_bare and bool(targets) and targets[-1].startswith(_LISTS)
        if is_continued:
            targets[-1] += "," + _with_port(part)
        else:
            targets.append(_target(part))
    return targets


def require_server(value: object) -> None:
    """Raises TypeError for what is given as server and is no text, such as a list."""
    if not isinstance(value, str):
        raise TypeError(
            f"server is {shown(value)}; it must be a str such as {DEFAULT_SERVER!r}, or several with commas between"
        )


def drawn(server: str) -> tuple[str, str | None]:
    """For a program that makes one call: the addresses of a name with several, in an order that is drawn, with commas
    between, and the name, which a certificate is for.

    gRPC sends the first call of a channel to the address that is connected first, so that programs of one call would all
    come to the same replica. What is no name, "localhost", and a name with one address or none come back as they are, with
    None.
    """
    targets = split_servers(server)
    if len(targets) != 1 or targets[0].startswith((*_LISTS, *_PATHS, "dns:")):
        return server, None
    host, _, port = targets[0].rpartition(":")
    if host == "localhost" or host.startswith("["):
        return server, None
    try:
        found = socket.getaddrinfo(host, int(port), type=socket.SOCK_STREAM)
    except OSError:
        return server, None
    addresses = sorted({str(address[0]) for *_, address in found})
    if len(addresses) < 2:
        return server, None
    random.shuffle(addresses)
    return ",".join(f"[{each}]:{port}" if ":" in each else f"{each}:{port}" for each in addresses), host


def is_local(target: str) -> bool:
    """Whether all that the target names is this machine, by what is written there alone."""
    if target.startswith(("unix:", "unix-abstract:")):
        return True
    if target.startswith(_LISTS):
        return all(_is_local_host(each) for each in target.partition(":")[2].split(","))
    return _is_local_host(target.removeprefix("dns:///").removeprefix("dns:"))


def _is_local_host(address: str) -> bool:
    host = address.rpartition(":")[0].strip("[]")
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def _target(text: str) -> str:
    if text.startswith(_PATHS):
        return text
    if url := _URL.match(text):
        hint = ": TLS has an option of its own" if url[1].lower() in ("https", "grpcs") else ""
        raise ValueError(
            f"server {shown(text)} is a URL; it must be HOST or HOST:PORT, as {DEFAULT_SERVER!r}, without {url[0]}{hint}"
        )
    for scheme in (*_LISTS, "dns:"):
        if text.startswith(scheme):
            rest = text[len(scheme) :]
            # dns://AUTHORITY/NAME asks a name server of one's own.
            head, slash, name = rest.rpartition("/")
            return f"{scheme}{head}{slash}{_with_port(name)}"
    return _with_port(text)


def _with_port(address: str) -> str:
    try:
        if ipaddress.ip_address(address.strip("[]")).version == 6:
            return f"[{address.strip('[]')}]:{DEFAULT_PORT}"
    except ValueError:
        pass
    if not address or address.startswith(":"):
        raise ValueError(f"server {shown(address)} names no host; it must be HOST or HOST:PORT, as {DEFAULT_SERVER!r}")
    port = re.search(r":([^:\]]*)$", address)
    if port is None:
        return f"{address}:{DEFAULT_PORT}"
    if not (port[1].isascii() and port[1].isdigit() and 1 <= int(port[1]) <= 65535):
        raise ValueError(f"server {shown(address)} has port {shown(port[1])}; it must be from 1 to 65535")
    return address
