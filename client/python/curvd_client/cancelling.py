"""Ends calls from another thread."""

from __future__ import annotations

import contextlib
import threading
import typing


class Cancel:
    """A handle that ends every call it was given to. Thread-safe.

    cancel = Cancel()
    threading.Timer(5, cancel.cancel).start()
    client.estimate(positions, cancel=cancel)  # raises CurvdError with code CANCELLED

    Once cancelled it stays so: a call that starts with it afterwards fails at once.
    """

    def __init__(self) -> None:
        self._cancelled = threading.Event()
        self._lock = threading.Lock()
        self._watchers: dict[object, typing.Callable[[], object]] = {}

    @property
    def cancelled(self) -> bool:
        """Whether cancel was called."""
        return self._cancelled.is_set()

    def cancel(self) -> None:
        """Ends the calls. Returns at once; each raises in its own thread."""
        with self._lock:
            self._cancelled.set()
            watchers = list(self._watchers.values())
        for each in watchers:
            each()

    def wait(self, seconds: float) -> bool:
        """Sleeps so long, less if cancelled meanwhile. Returns whether it is cancelled."""
        return self._cancelled.wait(seconds)

    @contextlib.contextmanager
    def watched(self, on_cancel: typing.Callable[[], object]) -> typing.Iterator[None]:
        """Within the block, cancel calls on_cancel; at once if it was called before."""
        key = object()
        with self._lock:
            self._watchers[key] = on_cancel
        try:
            if self.cancelled:
                on_cancel()
            yield
        finally:
            with self._lock:
                del self._watchers[key]
