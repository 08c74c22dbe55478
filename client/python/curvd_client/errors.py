"""Turns a failed call into one exception with what a program and a person need to know."""

import pathlib

import grpc
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from google.protobuf.message import DecodeError

_DETAILS_KEY = "grpc-status-details-bin"


class CurvdError(Exception):
    """A call failed; nothing of its result is valid.

    code:        grpc.StatusCode.
    message:     what is wrong, for a person: names field, value and limit.
    reason:      the cause for a program, such as "CHUNK_OUT_OF_ORDER"; "" where the server gave none.
    metadata:    what the reason refers to, a dict of strings.
    retry_after: seconds after which the same call may succeed; None where waiting does not help.
    transient:   whether the same call may succeed on another try: waiting helps, or the server is or became unreachable.
    """

    def __init__(self, code, message, reason="", metadata=None, retry_after=None, transient=False):
        super().__init__(f"{code.name}: {message}")
        self.code = code
        self.message = message
        self.reason = reason
        self.metadata = metadata or {}
        self.retry_after = retry_after
        self.transient = transient


class CurvdWarning(UserWarning):
    """A call succeeded, but something is wrong with its cloud; `code` says what for a program: "OPPOSED_NORMALS"."""

    def __init__(self, code, message):
        super().__init__(message)
        self.code = code


def from_rpc_error(error):
    """The CurvdError for a grpc.RpcError that a call raised. Details that cannot be decoded are left out."""
    curvd_error = CurvdError(error.code(), error.details() or "")
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


def _server_is_gone(error):
    # Proxies make UNKNOWN or INTERNAL of a server that died; curvd gives each of its own errors a reason.
    if error.code in (grpc.StatusCode.UNKNOWN, grpc.StatusCode.INTERNAL):
        return not error.reason
    return error.code == grpc.StatusCode.UNAVAILABLE


def _details(error):
    packed = dict(error.trailing_metadata() or ()).get(_DETAILS_KEY)
    if packed is None:
        return
    for any_message in _MESSAGES["google.rpc.Status"].FromString(packed).details:
        message_class = _MESSAGES.get(any_message.type_url.rpartition("/")[2])
        if message_class is not None:
            yield message_class.FromString(any_message.value)


def _load_messages():
    # A pool of our own: the default one may hold another copy of google.rpc.
    files = descriptor_pb2.FileDescriptorSet.FromString(
        pathlib.Path(__file__).with_name("error_details.binpb").read_bytes()
    )
    pool = descriptor_pool.DescriptorPool()
    for file in files.file:
        pool.Add(file)
    get_class = getattr(message_factory, "GetMessageClass", None) or message_factory.MessageFactory(pool).GetPrototype
    names = ["google.rpc.Status", "google.rpc.ErrorInfo", "google.rpc.RetryInfo"]
    return {name: get_class(pool.FindMessageTypeByName(name)) for name in names}


_MESSAGES = _load_messages()
