"""Tells how far a call is: to a function of the caller, or as a line on a terminal."""

from __future__ import annotations

import inspect
import os
import sys
import time
import typing

from curvd_client import curvature_pb2
from curvd_client.fields import shown


class Progress(typing.NamedTuple):
    """How far a call is. Counts never decrease within a phase; a call that is tried again starts anew.

    phase:            "receiving", "queued", "indexing", "estimating_normals", "orienting", "estimating" or "sending".
    points_received:  points that the server has.
    points_estimated: points whose curvature, or normal, is estimated.
    point_count:      points of the cloud.
    """

    phase: str
    points_received: int
    points_estimated: int
    point_count: int

    @classmethod
    def of_all(cls, point_count: int) -> Progress:
        """That of a call that has its last result."""
        return cls("sending", point_count, point_count, point_count)

    @property
    def fraction(self) -> float:
        """Share of the points that the present phase is done with, from 0 to 1; 0 where the phase counts none."""
        return min(1.0, (self._done() or 0) / self.point_count) if self.point_count else 1.0

    def counted(self) -> str:
        """How many points the phase is done with, as "1,000 of 2,000 points"; where it counts none, how many there are."""
        done = self._done()
        points = f"{self.point_count:,} {'point' if self.point_count == 1 else 'points'}"
        return points if done is None else f"{done:,} of {points}"

    def _done(self) -> int | None:
        return {
            "receiving": self.points_received,
            "estimating": self.points_estimated,
            "sending": self.point_count,
        }.get(self.phase)


class ProgressFailed(Exception):
    """What the caller's function for progress raised, on its way past those who judge errors of the call."""

    def __init__(self, error: BaseException) -> None:
        super().__init__(error)
        self.error = error


# What it returns to the client of asyncio is awaited there, if it can be.
ProgressCallback = typing.Callable[[Progress], object]


def progress_of(message: curvature_pb2.Progress, point_count: int) -> Progress:
    """The message in words; a phase that a later contract has is named by its number."""
    value = curvature_pb2.Progress.Phase.DESCRIPTOR.values_by_number.get(message.phase)
    phase = str(message.phase) if value is None else value.name.removeprefix("PHASE_").lower()
    return Progress(phase, message.points_received, message.points_estimated, point_count)


def reporter(
    progress: ProgressCallback | bool, *, awaits: bool
) -> tuple[ProgressCallback | None, typing.Callable[[], None]]:
    """What to call with each Progress, or None, and what to call at the end.

    progress: a function; True: a line on stderr if that is a terminal, else nothing; False: nothing.
    awaits:   whether the caller awaits what the function returns.

    What is called raises ProgressFailed where the function raises. Raises TypeError for what is none of these, and for a
    coroutine function that nobody would await.
    """
    if callable(progress):
        if not awaits and _is_coroutine_function(progress):
            raise TypeError(
                f"progress is {shown(progress)}, which only curvd_client.aio awaits; it must be a function that is not async"
            )
        return _guarded(progress), lambda: None
    if not isinstance(progress, bool):
        raise TypeError(f"progress is {shown(progress)}; it must be True, False or a function of a Progress")
    if not progress or not sys.stderr.isatty() or os.environ.get("TERM", "dumb") == "dumb":
        return None, lambda: None
    line = TerminalLine(sys.stderr)
    return line.show, line.end


def _guarded(progress: ProgressCallback) -> ProgressCallback:
    def tell(how_far: Progress) -> object:
        try:
            return progress(how_far)
        except Exception as error:
            raise ProgressFailed(error) from None

    return tell


def _is_coroutine_function(function: typing.Callable[..., object]) -> bool:
    """Also of an object that is called as one."""
    return inspect.iscoroutinefunction(function) or inspect.iscoroutinefunction(getattr(function, "__call__", None))


class TerminalLine:
    """One line that is written again and again: phase, share, bar, points, seconds."""

    _BAR = 24
    _LEAST_SECONDS = 0.05

    def __init__(self, stream: typing.TextIO) -> None:
        self._stream = stream
        self._began = time.monotonic()
        self._written = -1.0
        self._phase = ""

    def show(self, progress: Progress) -> None:
        """Writes the line, unless the same phase was written a moment ago and has points left."""
        now = time.monotonic()
        is_done = progress.fraction == 1.0
        if not is_done and progress.phase == self._phase and now - self._written < self._LEAST_SECONDS:
            return
        self._phase, self._written = progress.phase, now
        bar = "#" * round(self._BAR * progress.fraction)
        self._stream.write(
            f"\r\x1b[K{progress.phase.replace('_', ' ')} {progress.fraction:4.0%} |{bar:<{self._BAR}}| "
            f"{progress.counted()}, {now - self._began:.1f} s"
        )
        self._stream.flush()

    def end(self) -> None:
        """Leaves the line, if there is one."""
        if self._phase:
            self._stream.write("\n")
            self._stream.flush()
