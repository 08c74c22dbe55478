"""The blocking client: a cloud goes out in chunks, its curvature or normals come back."""

from __future__ import annotations

import contextlib
import itertools
import random
import threading
import types
import typing

import grpc
import numpy.typing as npt

from curvd_client import rpc
from curvd_client.addresses import DEFAULT_SERVER, split_servers
from curvd_client.cancelling import Cancel
from curvd_client.errors import CurvdError, from_rpc_error
from curvd_client.exchange import Answers, Request, make_request, warn
from curvd_client.fields import shown
from curvd_client.options import CurvatureOptions, NormalsOptions, curvature_header, normals_header
from curvd_client.progress import ProgressCallback, ProgressFailed, reporter
from curvd_client.results import Estimate
from curvd_client.retries import DEFAULT_ATTEMPTS, DEFAULT_CONNECT_SECONDS, Schedule
from curvd_client.security import Security, require_security

if typing.TYPE_CHECKING:
    from typing_extensions import Unpack

_Result = typing.TypeVar("_Result")
_Attempt = typing.Callable[[typing.Any, typing.Optional[float], Cancel], _Result]
_NO_SECURITY = Security()


class CurvatureClient:
    """Calls one server, or several replicas, over connections that it keeps. Thread-safe; not for use after a fork.

    with CurvatureClient("curvd.example", security=Security(tls=True)) as client:
        points, summary = client.estimate(positions, normals)

    server, security: as estimate_curvature has them.
    channel:          a grpc.Channel of your own instead of `server`, which close leaves open; security's token is not
                      checked for plain text then.
    """

    def __init__(
        self,
        server: str = DEFAULT_SERVER,
        *,
        security: Security = _NO_SECURITY,
        channel: grpc.Channel | None = None,
    ) -> None:
        require_security(security)
        rpc.require_channel(channel, grpc.Channel, "grpc.Channel")
        self._metadata = security.metadata()
        self._opened = contextlib.ExitStack()
        self._channels = [channel]
        if channel is None:
            # Closed again if one of several cannot be opened.
            with contextlib.ExitStack() as opened:
                self._channels = [
                    opened.enter_context(security.open_channel(target, rpc.CHANNEL_OPTIONS))
                    for target in split_servers(server)
                ]
                self._opened = opened.pop_all()
        self._turns = itertools.count(random.randrange(len(self._channels)))
        self._reached = False
        self._closed = False
        self._lock = threading.Lock()
        self._running: set[Cancel] = set()

    def __enter__(self) -> CurvatureClient:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: types.TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Ends the calls that run, each with CurvdError CANCELLED, and closes the connections. May be called again."""
        with self._lock:
            self._closed = True
            running = list(self._running)
        for each in running:
            each.cancel()
        self._opened.close()

    def estimate(
        self,
        positions: npt.ArrayLike,
        normals: npt.ArrayLike | None = None,
        *,
        timeout: float | None = None,
        max_attempts: int = DEFAULT_ATTEMPTS,
        connect_timeout: float = DEFAULT_CONNECT_SECONDS,
        cancel: Cancel | None = None,
        progress: ProgressCallback | bool = False,
        **options: Unpack[CurvatureOptions],
    ) -> Estimate:
        """Estimates the curvature at every point of a cloud; all as estimate_curvature explains it."""
        request = make_request(curvature_header(normals is not None, **options), positions, normals)
        estimate = self._estimate(request, timeout, max_attempts, connect_timeout, cancel, progress)
        warn(estimate, stacklevel=2)
        return estimate

    def normals(
        self,
        positions: npt.ArrayLike,
        normals: npt.ArrayLike | None = None,
        *,
        timeout: float | None = None,
        max_attempts: int = DEFAULT_ATTEMPTS,
        connect_timeout: float = DEFAULT_CONNECT_SECONDS,
        cancel: Cancel | None = None,
        progress: ProgressCallback | bool = False,
        **options: Unpack[NormalsOptions],
    ) -> Estimate:
        """Estimates, or turns, the normal at every point of a cloud; all as estimate_normals explains it."""
        request = make_request(normals_header(normals is not None, **options), positions, normals)
        estimate = self._estimate(request, timeout, max_attempts, connect_timeout, cancel, progress)
        warn(estimate, stacklevel=2)
        return estimate

    def info(
        self,
        *,
        timeout: float | None = None,
        max_attempts: int = DEFAULT_ATTEMPTS,
        connect_timeout: float = DEFAULT_CONNECT_SECONDS,
    ) -> rpc.ServerInfo:
        """What the server is and accepts. Raises CurvdError."""
        return typing.cast(rpc.ServerInfo, self._ask(rpc.info_method, timeout, max_attempts, connect_timeout))

    def health(
        self,
        *,
        timeout: float | None = None,
        max_attempts: int = DEFAULT_ATTEMPTS,
        connect_timeout: float = DEFAULT_CONNECT_SECONDS,
    ) -> str:
        """ "SERVING", or "NOT_SERVING" where the server drains, as grpc.health.v1 has it. Raises CurvdError."""
        return str(self._ask(rpc.health_method, timeout, max_attempts, connect_timeout))

    def _estimate(
        self,
        request: Request,
        timeout: float | None,
        max_attempts: int,
        connect_timeout: float,
        cancel: Cancel | None,
        progress: ProgressCallback | bool,
    ) -> Estimate:
        if not isinstance(cancel, (Cancel, type(None))):
            raise TypeError(f"cancel is {shown(cancel)}; it must be a Cancel")
        on_progress, end_of_progress = reporter(progress, awaits=False)

        def attempt(channel: typing.Any, time_left: float | None, stop: Cancel) -> Estimate:
            answers = Answers(request, on_progress)
            method = rpc.estimate_method(channel)
            failure = _exchange(method(request.messages(), timeout=time_left, metadata=self._metadata), answers, stop)
            if failure is not None:
                try:
                    raise failure
                finally:
                    del failure  # whose traceback holds this frame: the two would keep each other
            return answers.estimate()

        try:
            return self._with_retries(attempt, timeout, max_attempts, connect_timeout, cancel)
        except ProgressFailed as failed:
            raise failed.error from failed.error.__cause__
        finally:
            end_of_progress()

    def _ask(
        self,
        method: typing.Callable[[typing.Any], typing.Any],
        timeout: float | None,
        max_attempts: int,
        connect_timeout: float,
    ) -> object:
        def attempt(channel: typing.Any, time_left: float | None, stop: Cancel) -> object:
            answer = _answer(method(channel).future(None, timeout=time_left, metadata=self._metadata), stop)
            if isinstance(answer, CurvdError):
                try:
                    raise answer
                finally:
                    del answer
            return answer

        return self._with_retries(attempt, timeout, max_attempts, connect_timeout, None)

    def _with_retries(
        self,
        attempt: _Attempt[_Result],
        timeout: float | None,
        max_attempts: int,
        connect_timeout: float,
        cancel: Cancel | None,
    ) -> _Result:
        """The result of the first attempt that succeeds. Raises CurvdError as Schedule says, or when cancelled."""
        schedule = Schedule(
            len(self._channels),
            next(self._turns),
            reached=self._reached,
            timeout=timeout,
            max_attempts=max_attempts,
            connect_seconds=connect_timeout,
        )
        with self._runs(cancel) as stop:
            while True:
                if stop.cancelled:
                    raise _cancelled()
                try:
                    result = self._attempt_once(attempt, schedule, stop)
                    self._reached = True
                    return result
                except CurvdError as error:
                    if stop.cancelled:
                        raise _cancelled() from None
                    self._reached = self._reached or error.answered
                    pause = schedule.pause_after(error)
                stop.wait(pause)

    def _attempt_once(self, attempt: _Attempt[_Result], schedule: Schedule, stop: Cancel) -> _Result:
        channel = self._channels[schedule.replica]
        try:
            if schedule.connect_seconds > 0:
                _await_connection(channel, schedule.connect_seconds)
            return attempt(channel, schedule.time_left, stop)
        except ValueError:
            # gRPC's word for a channel that was closed meanwhile.
            if stop.cancelled:
                raise _cancelled() from None
            raise

    @contextlib.contextmanager
    def _runs(self, cancel: Cancel | None) -> typing.Iterator[Cancel]:
        """What ends the call within the block: the caller's handle, or close."""
        stop = Cancel()
        with self._lock:
            if self._closed:
                raise ValueError("the client is closed")
            self._running.add(stop)
        try:
            with (cancel or Cancel()).watched(stop.cancel):
                yield stop
        finally:
            with self._lock:
                self._running.discard(stop)


# gRPC for Python raises the call itself, whose traceback then holds the call. As such a pair goes only when Python collects
# garbage, its finalizer may run as the interpreter ends, and waits there for a lock that a thread held when it was stopped:
# one program in some hundreds never ended. So these functions return an error, which does not know the call.


def _exchange(call: typing.Any, answers: Answers, stop: Cancel) -> CurvdError | None:
    """Takes each answer of a call to EstimateCurvature. Returns how the call failed, None where it did not."""
    try:
        with stop.watched(call.cancel):
            for response in call:
                answers.take(response)
    except grpc.RpcError as error:
        return from_rpc_error(error.with_traceback(None), rpc.was_answered(error, answers.any))
    finally:
        call.cancel()
    return None


def _answer(call: typing.Any, stop: Cancel) -> object:
    """The answer of a call that has one, or the CurvdError that it failed with."""
    try:
        with stop.watched(call.cancel):
            return call.result()
    except grpc.FutureCancelledError:
        return _cancelled()
    except grpc.RpcError as error:
        return from_rpc_error(error.with_traceback(None), rpc.was_answered(error, False))


def _cancelled() -> CurvdError:
    return CurvdError(grpc.StatusCode.CANCELLED, "the caller cancelled the call")


def _await_connection(channel: grpc.Channel, seconds: float) -> None:
    """Gives a server that may have come back the time to take a connection: a call of its own would fail at once."""
    ready = grpc.channel_ready_future(channel)
    with contextlib.suppress(grpc.FutureTimeoutError):
        ready.result(seconds)
    ready.cancel()  # else it would watch the channel for as long as that is open, and complain at its end
