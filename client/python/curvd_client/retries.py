"""Says whether a call is tried again, on which replica and after what pause. Waits for nothing and calls nobody."""

from __future__ import annotations

import math
import random
import time

from curvd_client.errors import CurvdError
from curvd_client.fields import count, real_number, shown

DEFAULT_ATTEMPTS = 6
# No server was ever there: long enough for a replica that is just being started, short enough for a wrong address.
DEFAULT_CONNECT_SECONDS = 1.5
_FIRST_PAUSE_SECONDS = 0.25
_DOUBLINGS = 5
# How long a try waits for the connection to a server that may have come back.
_MOST_CONNECT_SECONDS = 1.0
# A century.
_MOST_SECONDS = 100 * 365 * 86_400.0


def _timeout(value: float) -> float:
    seconds = real_number("timeout", value)
    if not seconds > 0.0:
        raise ValueError(f"timeout is {shown(value)}; it must be a number of seconds above 0")
    return seconds


def _connect_timeout(value: float) -> float:
    seconds = real_number("connect_timeout", value)
    if not seconds >= 0.0:
        raise ValueError(f"connect_timeout is {shown(value)}; it must be a number of seconds from 0")
    return seconds


class Schedule:
    """The tries of one call, each on the next of several replicas. Not thread-safe.

    replica_count:   replicas; the first try goes to number `first` modulo this.
    reached:         whether a server has ever answered the client: if not, the call gives up connect_seconds, 0 or
                     more, after it began, and when each replica was tried.
    timeout:         seconds for all tries together, above 0; None: no limit; centuries are none either.
    max_attempts:    tries at most, 1 or more.

    Raises ValueError, naming the argument, for a timeout, connect_seconds or max_attempts that is no such number.
    """

    def __init__(
        self,
        replica_count: int,
        first: int,
        *,
        reached: bool,
        timeout: float | None,
        max_attempts: int,
        connect_seconds: float,
    ) -> None:
        now = time.monotonic()
        limit = math.inf if timeout is None else _timeout(timeout)
        # What gRPC's clock cannot count to would be over at once.
        self._deadline = math.inf if limit > _MOST_SECONDS else now + limit
        self._reach_before = now + _connect_timeout(connect_seconds)
        self._reached = reached
        self._replica_count = replica_count
        self._next = first
        self._tries = 0
        self._connect_seconds = 0.0
        self._max_attempts = count("max_attempts", max_attempts)

    @property
    def replica(self) -> int:
        """Which one the present try goes to."""
        return self._next % self._replica_count

    @property
    def time_left(self) -> float | None:
        """Seconds that the present try has, None: as many as it likes."""
        return None if math.isinf(self._deadline) else max(0.0, self._deadline - time.monotonic())

    @property
    def connect_seconds(self) -> float:
        """How long the present try may wait for a connection; 0 for the first, which connects as it calls."""
        end = self._deadline if self._reached else min(self._deadline, self._reach_before)
        return max(0.0, min(self._connect_seconds, end - time.monotonic()))

    def pause_after(self, error: CurvdError) -> float:
        """Seconds to wait before the next try, which `replica` then names. Raises the error if there shall be none."""
        self._tries += 1
        self._reached = self._reached or error.answered
        self._next += 1
        pause = self._pause(error.retry_after or 0.0)
        # Another replica has its turn, however long the first kept silent.
        goes_on = self._reached or self._tries < self._replica_count
        end = self._deadline if goes_on else min(self._deadline, self._reach_before)
        if not error.transient or self._tries >= self._max_attempts or time.monotonic() + pause >= end:
            raise error
        if error.answered or pause == 0:
            self._connect_seconds = _MOST_CONNECT_SECONDS
            return pause
        # A part of the pause is spent waiting for the connection: a server that is gone is not reported any later for
        # it.
        self._connect_seconds = min(_MOST_CONNECT_SECONDS, pause / 2)
        return pause - self._connect_seconds

    def _pause(self, asked: float) -> float:
        """At once on another replica, then doubling, up to a quarter less so that clients do not come in step."""
        if self._tries == 1 and self._replica_count > 1:
            return asked
        doubled = _FIRST_PAUSE_SECONDS * float(2 ** min(self._tries - 1, _DOUBLINGS))
        return max(asked, random.uniform(0.75, 1.0) * doubled)
