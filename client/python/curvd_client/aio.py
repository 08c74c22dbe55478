"""The same client for asyncio: same arguments, same results, same errors; a call ends where its task is cancelled.

async with curvd_client.aio.CurvatureClient("localhost") as client:
    points, summary = await client.estimate(positions, normals)
"""

from __future__ import annotations

import asyncio
import contextlib
import inspect
import itertools
import random
import types
import typing

import grpc
import grpc.aio
import numpy.typing as npt

from curvd_client import rpc
from curvd_client.addresses import DEFAULT_SERVER, split_servers
from curvd_client.errors import CurvdError, from_rpc_error
from curvd_client.exchange import Answers, Request, make_request, warn
from curvd_client.options import CurvatureOptions, NormalsOptions, curvature_header, normals_header
from curvd_client.progress import ProgressCallback, ProgressFailed, reporter
from curvd_client.results import Estimate
from curvd_client.retries import DEFAULT_ATTEMPTS, DEFAULT_CONNECT_SECONDS, Schedule
from curvd_client.security import Security, require_security

if typing.TYPE_CHECKING:
    from typing_extensions import Unpack

__all__ = ["CurvatureClient", "estimate_curvature", "estimate_normals"]

_Result = typing.TypeVar("_Result")
_Attempt = typing.Callable[[typing.Any, typing.Optional[float]], typing.Awaitable[_Result]]
_NO_SECURITY = Security()


class CurvatureClient:
    """Calls one server, or several replicas, over connections that it keeps, in one event loop: that of its first call.

    It may be made anywhere, also where no event loop runs. A call in another event loop raises RuntimeError.

    server, security: as curvd_client.estimate_curvature has them.
    channel:          a grpc.aio.Channel of your own instead of `server`, which close leaves open.
    """

    def __init__(
        self,
        server: str = DEFAULT_SERVER,
        *,
        security: Security = _NO_SECURITY,
        channel: grpc.aio.Channel | None = None,
    ) -> None:
        require_security(security)
        rpc.require_channel(channel, grpc.aio.Channel, "grpc.aio.Channel")
        self._metadata = security.metadata()
        self._owns_channels = channel is None
        self._openers: list[typing.Callable[[], typing.Any]] = [lambda: channel]
        if channel is None:
            self._openers = [security.aio_opener(target, rpc.CHANNEL_OPTIONS) for target in split_servers(server)]
        self._channels: list[typing.Any] = []
        self._loop: asyncio.AbstractEventLoop | None = None
        self._turns = itertools.count(random.randrange(len(self._openers)))
        self._reached = False
        self._closed = False
        self._running: set[typing.Any] = set()

    async def __aenter__(self) -> CurvatureClient:
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: types.TracebackType | None,
    ) -> None:
        await self.close()

    async def close(self) -> None:
        """Ends the calls that run, each with CurvdError CANCELLED, and closes the connections. May be called again."""
        self._closed = True
        for call in list(self._running):
            call.cancel()
        for channel in self._channels if self._owns_channels else ():
            await channel.close()

    async def estimate(
        self,
        positions: npt.ArrayLike,
        normals: npt.ArrayLike | None = None,
        *,
        timeout: float | None = None,
        max_attempts: int = DEFAULT_ATTEMPTS,
        connect_timeout: float = DEFAULT_CONNECT_SECONDS,
        progress: ProgressCallback | bool = False,
        **options: Unpack[CurvatureOptions],
    ) -> Estimate:
        """Estimates the curvature at every point of a cloud; all as curvd_client.estimate_curvature explains it."""
        request = make_request(curvature_header(normals is not None, **options), positions, normals)
        estimate = await self._estimate(request, timeout, max_attempts, connect_timeout, progress)
        warn(estimate, stacklevel=2)
        return estimate

    async def normals(
        self,
        positions: npt.ArrayLike,
        normals: npt.ArrayLike | None = None,
        *,
        timeout: float | None = None,
        max_attempts: int = DEFAULT_ATTEMPTS,
        connect_timeout: float = DEFAULT_CONNECT_SECONDS,
        progress: ProgressCallback | bool = False,
        **options: Unpack[NormalsOptions],
    ) -> Estimate:
        """Estimates, or turns, the normal at every point; all as curvd_client.estimate_normals explains it."""
        request = make_request(normals_header(normals is not None, **options), positions, normals)
        estimate = await self._estimate(request, timeout, max_attempts, connect_timeout, progress)
        warn(estimate, stacklevel=2)
        return estimate

    async def info(
        self,
        *,
        timeout: float | None = None,
        max_attempts: int = DEFAULT_ATTEMPTS,
        connect_timeout: float = DEFAULT_CONNECT_SECONDS,
    ) -> rpc.ServerInfo:
        """What the server is and accepts. Raises CurvdError."""
        return typing.cast(rpc.ServerInfo, await self._ask(rpc.info_method, timeout, max_attempts, connect_timeout))

    async def health(
        self,
        *,
        timeout: float | None = None,
        max_attempts: int = DEFAULT_ATTEMPTS,
        connect_timeout: float = DEFAULT_CONNECT_SECONDS,
    ) -> str:
        """ "SERVING", or "NOT_SERVING" where the server drains, as grpc.health.v1 has it. Raises CurvdError."""
        return str(await self._ask(rpc.health_method, timeout, max_attempts, connect_timeout))

    async def _estimate(
        self,
        request: Request,
        timeout: float | None,
        max_attempts: int,
        connect_timeout: float,
        progress: ProgressCallback | bool,
    ) -> Estimate:
        on_progress, end_of_progress = reporter(progress, awaits=True)

        async def attempt(channel: typing.Any, time_left: float | None) -> Estimate:
            answers = Answers(request, on_progress)
            call = rpc.estimate_method(channel)(request.messages(), timeout=time_left, metadata=self._metadata)
            self._running.add(call)
            try:
                async for response in call:
                    told = answers.take(response)
                    if inspect.isawaitable(told):
                        await _await_beside(call, told)
            except grpc.RpcError as error:
                raise from_rpc_error(error, rpc.was_answered(error, answers.any)) from None
            finally:
                self._running.discard(call)
                call.cancel()
            return answers.estimate()

        try:
            return await self._with_retries(attempt, timeout, max_attempts, connect_timeout)
        except ProgressFailed as failed:
            raise failed.error from failed.error.__cause__
        finally:
            end_of_progress()

    async def _ask(
        self,
        method: typing.Callable[[typing.Any], typing.Any],
        timeout: float | None,
        max_attempts: int,
        connect_timeout: float,
    ) -> object:
        async def attempt(channel: typing.Any, time_left: float | None) -> object:
            call = method(channel)(None, timeout=time_left, metadata=self._metadata)
            self._running.add(call)
            try:
                return await call
            except grpc.RpcError as error:
                raise from_rpc_error(error, rpc.was_answered(error, False)) from None
            finally:
                self._running.discard(call)

        return await self._with_retries(attempt, timeout, max_attempts, connect_timeout)

    async def _with_retries(
        self,
        attempt: _Attempt[_Result],
        timeout: float | None,
        max_attempts: int,
        connect_timeout: float,
    ) -> _Result:
        """The result of the first attempt that succeeds. Raises CurvdError as Schedule says, or when closed."""
        if self._closed:
            raise ValueError("the client is closed")
        self._open_channels()
        schedule = Schedule(
            len(self._channels),
            next(self._turns),
            reached=self._reached,
            timeout=timeout,
            max_attempts=max_attempts,
            connect_seconds=connect_timeout,
        )
        while True:
            try:
                result = await self._attempt_once(attempt, schedule)
                self._reached = True
                return result
            except CurvdError as error:
                self._reached = self._reached or error.answered
                pause = schedule.pause_after(error)
            await asyncio.sleep(pause)
            if self._closed:
                raise CurvdError(grpc.StatusCode.CANCELLED, "the client was closed")

    def _open_channels(self) -> None:
        """Opens them for the first call: a channel belongs to the event loop that it is opened in."""
        loop = asyncio.get_running_loop()
        if self._loop is None:
            self._channels = [open_channel() for open_channel in self._openers]
            self._loop = loop
        if self._loop is not loop:
            raise RuntimeError("the client was used in another event loop before; make a client for each event loop")

    async def _attempt_once(self, attempt: _Attempt[_Result], schedule: Schedule) -> _Result:
        channel = self._channels[schedule.replica]
        try:
            if schedule.connect_seconds > 0:
                with contextlib.suppress(asyncio.TimeoutError):
                    await asyncio.wait_for(channel.channel_ready(), schedule.connect_seconds)
            return await attempt(channel, schedule.time_left)
        except (asyncio.CancelledError, grpc.aio.UsageError, ValueError) as error:
            # What gRPC raises where its channel is closed; a task that somebody cancels ends as tasks do.
            if self._closed and not _task_is_cancelled():
                raise CurvdError(grpc.StatusCode.CANCELLED, "the client was closed") from error
            raise


async def _await_beside(call: typing.Any, told: typing.Awaitable[object]) -> None:
    """Awaits what a function for progress returned; cancels it where the call fails meanwhile, as by its timeout.

    Raises ProgressFailed for what it raises.
    """
    task, end = asyncio.ensure_future(told), asyncio.ensure_future(call.code())
    try:
        await asyncio.wait({task, end}, return_when=asyncio.FIRST_COMPLETED)
        if not task.done() and end.result() == grpc.StatusCode.OK:
            await asyncio.wait({task})
        if task.done() and not task.cancelled() and (error := task.exception()) is not None:
            raise ProgressFailed(error)
    finally:
        task.cancel()
        end.cancel()


async def estimate_curvature(
    positions: npt.ArrayLike,
    normals: npt.ArrayLike | None = None,
    *,
    server: str = DEFAULT_SERVER,
    security: Security = _NO_SECURITY,
    channel: grpc.aio.Channel | None = None,
    timeout: float | None = None,
    max_attempts: int = DEFAULT_ATTEMPTS,
    connect_timeout: float = DEFAULT_CONNECT_SECONDS,
    progress: ProgressCallback | bool = False,
    **options: Unpack[CurvatureOptions],
) -> Estimate:
    """One call over a connection of its own; all as curvd_client.estimate_curvature explains it."""
    request = make_request(curvature_header(normals is not None, **options), positions, normals)
    async with CurvatureClient(server, security=security, channel=channel) as client:
        estimate = await client._estimate(request, timeout, max_attempts, connect_timeout, progress)
    warn(estimate, stacklevel=2)
    return estimate


async def estimate_normals(
    positions: npt.ArrayLike,
    normals: npt.ArrayLike | None = None,
    *,
    server: str = DEFAULT_SERVER,
    security: Security = _NO_SECURITY,
    channel: grpc.aio.Channel | None = None,
    timeout: float | None = None,
    max_attempts: int = DEFAULT_ATTEMPTS,
    connect_timeout: float = DEFAULT_CONNECT_SECONDS,
    progress: ProgressCallback | bool = False,
    **options: Unpack[NormalsOptions],
) -> Estimate:
    """One call over a connection of its own; all as curvd_client.estimate_normals explains it."""
    request = make_request(normals_header(normals is not None, **options), positions, normals)
    async with CurvatureClient(server, security=security, channel=channel) as client:
        estimate = await client._estimate(request, timeout, max_attempts, connect_timeout, progress)
    warn(estimate, stacklevel=2)
    return estimate


def _task_is_cancelled() -> bool:
    task = asyncio.current_task()
    cancelling = getattr(task, "cancelling", None)  # from Python 3.11 on
    return cancelling is not None and cancelling() > 0
