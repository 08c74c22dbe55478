"""Bytes that are no call, or a call that is meant to do harm."""

import contextlib
import os
import socket
import time

from curvd_client import curvature_pb2 as pb
from fault import Fault
from raw_calls import Call, chunk, cloud_requests, header, sphere

_POINTS = 2_000
_REFUSED = {"INVALID_ARGUMENT", "RESOURCE_EXHAUSTED"}
# Damage may leave a message that says something else and still makes sense.
_ANSWERED = _REFUSED | {"OK"}
_PREFACE = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"


def hostile_protobuf(site, times):
    """Streams of damaged, nested, contradicting and oversized messages; each is answered, and a good call follows."""
    with site.server() as server:
        for _ in range(times):
            for what, messages, allowed in _hostile_streams(site.random):
                with Call(server.address, timeout=60) as call:
                    call.send(messages)
                    code = call.status().name
                    assert code in allowed, f"{what} was answered with {code}"
            yield _recovery(site, server)


def garbage_on_the_port(site, times):
    """Connections that do not speak gRPC, some of which are left open."""
    with site.server() as server, contextlib.ExitStack() as opened:
        host, _, port = server.address.rpartition(":")
        for _ in range(times):
            for greeting in _greetings(site.random):
                connection = opened.enter_context(socket.create_connection((host, int(port)), timeout=10))
                with contextlib.suppress(OSError):  # the server may hang up while we still speak
                    connection.sendall(greeting)
            yield _recovery(site, server)


def _recovery(site, server):
    began = time.monotonic()
    assert server.alive(), "curvd has ended"
    site.check(site.estimate(server.address))
    server.wait_until_idle()
    assert server.metric('curvd_failures_total{reason="INTERNAL"}') == 0, "an INTERNAL error"
    return time.monotonic() - began


def _hostile_streams(rng):
    """(what it is, its messages, the statuses that may answer it), many."""
    good = list(cloud_requests(_POINTS))
    open_ended = [header(0).SerializeToString(), *good[1:]]
    points = sphere(_POINTS)
    yield "nothing", [], _REFUSED
    yield "random bytes", [rng.randbytes(rng.randrange(1, 5_000)) for _ in range(3)], _ANSWERED
    yield "a damaged header", [_flip(rng, good[0]), *good[1:]], _ANSWERED
    yield "a damaged chunk", [good[0], _flip(rng, good[1])], _ANSWERED
    yield "a truncated header", [good[0][: rng.randrange(1, len(good[0]))], *good[1:]], _ANSWERED
    yield "a truncated chunk", [good[0], good[1][: rng.randrange(1, len(good[1]))]], _REFUSED
    # Without a point_count nothing but the message itself can tell that points are missing.
    yield "a truncated chunk of an open cloud", [open_ended[0], open_ended[1][: rng.randrange(8, len(good[1]))]], _REFUSED
    yield "nested groups", [b"\x0b" * rng.randrange(1_000, 200_000)], _REFUSED
    yield "an endless varint", [b"\x08" + b"\xff" * 1_000], _REFUSED
    yield "a length beyond the message", [b"\x0a\xff\xff\xff\xff\x07"], _REFUSED
    yield "two headers", [good[0], *good], _REFUSED
    yield "a chunk first", good[1:], _REFUSED
    yield "all the points there are", [header(2**64 - 1).SerializeToString()], _REFUSED
    yield "more points than announced", [header(7).SerializeToString(), *good[1:]], _REFUSED
    yield "fewer points than announced", [header(_POINTS + 1).SerializeToString(), *good[1:]], _REFUSED
    yield "the same chunk twice", [*good, good[-1]], _REFUSED
    yield "a chunk at the end of the numbers", [good[0], chunk(2**64 - 1, points).SerializeToString()], _REFUSED
    yield "half a point", [good[0], _uneven(points)], _REFUSED
    yield "a huge chunk", [header(0).SerializeToString(), chunk(0, sphere(1_000_000)).SerializeToString()], _REFUSED
    yield "no numbers", [good[0], chunk(0, points * float("nan")).SerializeToString()], _REFUSED
    for options in ({"radius": float("nan")}, {"radius": -1.0}, {"neighbor_count": 2**32 - 1}, {"seed": 2**64 - 1}):
        allowed = {"OK"} if "seed" in options else _REFUSED
        yield f"options {options}", list(cloud_requests(_POINTS, **options)), allowed
    # Everybody is everybody's neighbor.
    yield "a radius around all", list(cloud_requests(20_000, radius=1e30)), _REFUSED
    yield "one point many times", [header(_POINTS).SerializeToString(), _one_point()], {"OK"}


def _one_point():
    return chunk(0, sphere(1).repeat(_POINTS, axis=0)).SerializeToString()


def _uneven(points):
    packed = points.tobytes()[:-5]
    return pb.EstimateCurvatureRequest(chunk=pb.PointChunk(positions=packed, normals=packed)).SerializeToString()


def _flip(rng, message):
    damaged = bytearray(message)
    for _ in range(rng.randrange(1, 9)):
        damaged[rng.randrange(len(damaged))] ^= 1 << rng.randrange(8)
    return bytes(damaged)


def _greetings(rng):
    yield rng.randbytes(rng.randrange(1, 100_000))
    yield b"GET / HTTP/1.1\r\nHost: curvd\r\n\r\n"
    yield b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + os.urandom(32)  # TLS
    yield _PREFACE[: rng.randrange(1, len(_PREFACE))]
    yield _PREFACE
    yield _PREFACE + rng.randbytes(rng.randrange(1, 10_000))
    # SETTINGS, then a HEADERS frame that promises 16 MiB.
    yield _PREFACE + b"\x00\x00\x00\x04\x00\x00\x00\x00\x00" + b"\xff\xff\xff\x01\x04\x00\x00\x00\x01" + bytes(100)


FAULTS = [
    Fault("malformed and hostile protobuf", hostile_protobuf),
    Fault("garbage on the port", garbage_on_the_port),
]
