"""A TCP proxy that can break: cut connections, stop to forward, and be cut at a chosen byte."""

import contextlib
import socket
import struct
import threading

_PIECE = 64 << 10


class Proxy:
    """Forwards connections on `address` to `target` (HOST:PORT). Usable with `with`. Thread-safe."""

    def __init__(self, target):
        host, _, port = target.rpartition(":")
        self._target = (host, int(port))
        self._lock = threading.Lock()
        self._sockets = []
        self._forwarding = threading.Event()
        self._forwarding.set()
        self._cut_in = None  # bytes until the cut, both directions together
        self.cut_happened = threading.Event()
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.address = f"127.0.0.1:{self._listener.getsockname()[1]}"
        threading.Thread(target=self._accept, daemon=True).start()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        with contextlib.suppress(OSError):
            self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()
        self._forwarding.set()
        self.cut()

    def cut(self):
        """Resets every connection; new ones are served."""
        with self._lock:
            sockets, self._sockets = self._sockets, []
            self._cut_in = None
        for one in sockets:
            with contextlib.suppress(OSError):
                one.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
                one.shutdown(socket.SHUT_RD)  # wakes its pump, which closes it
        self.cut_happened.set()

    def cut_after(self, byte_count):
        """Cuts once so many bytes have passed."""
        with self._lock:
            self._cut_in = byte_count

    def freeze(self):
        """From now on nothing passes, and nobody is told: what a cable that was pulled looks like."""
        self._forwarding.clear()

    def _accept(self):
        while True:
            try:
                client, _ = self._listener.accept()
                server = socket.create_connection(self._target)
            except OSError:
                if self._listener.fileno() < 0:
                    return
                with contextlib.suppress(OSError, UnboundLocalError):
                    client.close()  # nobody listens behind
                continue
            with self._lock:
                self._sockets += [client, server]
            for source, sink in ((client, server), (server, client)):
                threading.Thread(target=self._pump, args=(source, sink), daemon=True).start()

    def _pump(self, source, sink):
        with contextlib.suppress(OSError):
            while piece := source.recv(_PIECE):
                self._forwarding.wait()
                if self._reaches_the_cut(len(piece)):
                    self.cut()
                    break
                sink.sendall(piece)
        # A side that ended ends the other; after cut() this is a reset.
        for one in (source, sink):
            with contextlib.suppress(OSError):
                one.shutdown(socket.SHUT_RD)
            one.close()

    def _reaches_the_cut(self, byte_count):
        with self._lock:
            if self._cut_in is None:
                return False
            self._cut_in -= byte_count
            return self._cut_in < 0
