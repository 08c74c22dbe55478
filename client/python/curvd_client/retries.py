"""Tries a call again, on another replica where there is one, while that may help."""

import random
import time

from curvd_client.errors import CurvdError

_FIRST_PAUSE_SECONDS = 0.25
_DOUBLINGS = 5


def call_with_retries(targets, attempt, *, await_connection, timeout, max_attempts):
    """Returns attempt(target, timeout) of the first try that succeeds.

    targets:          replicas, each call starting with any of them and going on to the next.
    await_connection: is called with the target before each try but the first.
    timeout:          seconds for all tries together, None: no limit; each try is told what is left.
    max_attempts:     tries at most.

    Raises the last CurvdError when it is not transient, after max_attempts, or when no time is left for another try.
    """
    deadline = None if timeout is None else time.monotonic() + timeout
    first = random.randrange(len(targets))
    for number in range(1, max_attempts + 1):
        target = targets[(first + number - 1) % len(targets)]
        if number > 1:
            await_connection(target)
        try:
            return attempt(target, _time_left(deadline))
        except CurvdError as error:
            pause = _pause_after(number, error.retry_after or 0.0, len(targets) > 1)
            out_of_time = deadline is not None and pause >= _time_left(deadline)
            if not error.transient or number == max_attempts or out_of_time:
                raise
        time.sleep(pause)


def _time_left(deadline):
    return None if deadline is None else max(0.0, deadline - time.monotonic())


def _pause_after(number, asked, another):
    """At once on another replica, then doubling, up to a quarter less so that clients do not come in step."""
    if number == 1 and another:
        return asked
    return max(asked, random.uniform(0.75, 1.0) * _FIRST_PAUSE_SECONDS * 2 ** min(number - 1, _DOUBLINGS))
