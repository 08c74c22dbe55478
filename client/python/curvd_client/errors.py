"""Turns a failed call into one exception with what a program and a person need to know."""

from __future__ import annotations

import typing

import grpc
from google.protobuf.message import DecodeError

from curvd_client.contract import message_class

_DETAILS_KEY = "grpc-status-details-bin"


class CurvdError(Exception):
    """A call failed; nothing of its result is valid.

    code:        grpc.StatusCode.
    message:     what is wrong, for a person: names field, value and limit.
    reason:      the cause for a program, such as "CHUNK_OUT_OF_ORDER"; "" where the server gave none.
    metadata:    what the reason refers to, a dict of strings.
    retry_after: seconds after which the same call may succeed; None where waiting does not help.
    answered:    whether a server took part, rather than being out of reach.
    transient:   whether the same call may succeed on another try: waiting helps, or the server is or became
                 unreachable.
    """

    def __init__(
        self,
        code: grpc.StatusCode,
        message: str,
        reason: str = "",
        metadata: dict[str, str] | None = None,
        retry_after: float | None = None,
        transient: bool = False,
    ) -> None:
        super().__init__(f"{code.name}: {message}")
        self.code = code
        self.message = message
        self.reason = reason
        self.metadata = metadata or {}
        self.retry_after = retry_after
        self.transient = transient
        self.answered = True

    def __reduce__(self) -> tuple[typing.Any, ...]:
        # Pools of processes hand errors on as pickles, which would call the class with the text of the error alone.
        return type(self), (self.code, self.message), self.__dict__


class CurvdWarning(UserWarning):
    """A call succeeded, but something is wrong with its cloud; `code` is the contract's WarningCode, such as "NO_RESULTS"."""

    def __init__(self, code: str, message: str) -> None:
        super().__init__(message)
        self.code = code

    def __reduce__(self) -> tuple[typing.Any, ...]:
        return type(self), (self.code, str(self)), self.__dict__


def from_rpc_error(error: typing.Any, answered: bool = True) -> CurvdError:
    """The CurvdError for a grpc.RpcError that a call raised. Details that cannot be decoded are left out."""
    curvd_error = CurvdError(error.code(), error.details() or "")
    curvd_error.answered = answered
    try:
        details = list(_details(error))
    except DecodeError:
        details = []
    for detail in details:
        if detail.DESCRIPTOR.name == "ErrorInfo":
            curvd_error.reason = detail.reason
            curvd_error.metadata = dict(detail.metadata)
        elif detail.DESCRIPTOR.name == "RetryInfo":
            curvd_error.retry_after = detail.retry_delay.seconds + detail.retry_delay.nanos * 1e-9
    curvd_error.transient = curvd_error.retry_after is not None or _server_is_gone(curvd_error)
    return curvd_error


def broken_protocol(fault: object) -> CurvdError:
    """The error for a server whose answers do not fit the contract."""
    return CurvdError(grpc.StatusCode.INTERNAL, f"the server broke the protocol: {fault}")


def _server_is_gone(error: CurvdError) -> bool:
    # Proxies make UNKNOWN or INTERNAL of a server that died; curvd gives each of its own errors a reason.
    if error.code in (grpc.StatusCode.UNKNOWN, grpc.StatusCode.INTERNAL):
        return not error.reason
    return bool(error.code == grpc.StatusCode.UNAVAILABLE)


def _details(error: typing.Any) -> typing.Iterator[typing.Any]:
    packed = {key: value for key, value in error.trailing_metadata() or ()}.get(_DETAILS_KEY)
    if packed is None:
        return
    for any_message in _MESSAGES["google.rpc.Status"].FromString(packed).details:
        message_class = _MESSAGES.get(any_message.type_url.rpartition("/")[2])
        if message_class is not None:
            yield message_class.FromString(any_message.value)


_MESSAGES = {
    name: message_class(name)
    for name in ("google.rpc.Status", "google.rpc.ErrorInfo", "google.rpc.RetryInfo")
}
