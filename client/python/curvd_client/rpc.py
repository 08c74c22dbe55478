"""What both clients, blocking and asyncio, know of the service: its methods, how a channel is set up, what answers
mean."""

from __future__ import annotations

import typing

import grpc

from curvd_client import curvature_pb2
from curvd_client.exchange import SERVICE
from curvd_client.options import estimator_name

CHANNEL_OPTIONS = [
    # What fails is tried again by retries.py. gRPC 1.51 may leave a call open for good, whatever its deadline, that it tried
    # again by itself after the server was drained.
    ("grpc.enable_retries", 0),
    # A name with several addresses is a set of replicas.
    ("grpc.lb_policy_name", "round_robin"),
    # A peer that died without a word is found within 30 s. On a slow line the question waits behind points that are on their
    # way, for some seconds.
    ("grpc.keepalive_time_ms", 10_000),
    ("grpc.keepalive_timeout_ms", 20_000),
    # One that came back is found by the next try, one that drops packets is given up.
    ("grpc.initial_reconnect_backoff_ms", 250),
    ("grpc.max_reconnect_backoff_ms", 2_000),
    ("grpc.min_reconnect_backoff_ms", 5_000),
    ("grpc.max_receive_message_length", 256 << 20),
]

_HEALTH = ("UNKNOWN", "SERVING", "NOT_SERVING", "SERVICE_UNKNOWN")


class ServerLimits(typing.NamedTuple):
    """What one call, and all together, may ask of a server."""

    max_points: int  # points in one cloud
    max_chunk_bytes: int  # bytes of one PointChunk's arrays together
    max_neighbor_count: int  # points in one neighborhood
    memory_bytes: int  # that all calls together may hold; 0 if not limited
    max_streams: int  # calls that may be open at a time


class ServerInfo(typing.NamedTuple):
    """What a server is, and what it accepts."""

    version: str  # of curvd, as MAJOR.MINOR.PATCH
    cpu_kind: str  # instruction set that its kernels run on, such as "AVX2"
    worker_threads: int  # that all calls share
    estimators: tuple[str, ...]  # as estimate_curvature names them
    limits: ServerLimits


def require_channel(value: object, kind: type, kind_name: str) -> None:
    """Raises TypeError for what is given as channel and is none of that kind: asyncio has one of its own."""
    if not isinstance(value, (kind, type(None))):
        given = f"{type(value).__module__}.{type(value).__name__}"
        raise TypeError(f"channel is of type {given}; it must be a {kind_name}, or None")


def estimate_method(channel: typing.Any) -> typing.Any:
    """EstimateCurvature on that channel."""
    return channel.stream_stream(
        f"/{SERVICE}/EstimateCurvature",
        request_serializer=curvature_pb2.EstimateCurvatureRequest.SerializeToString,
        response_deserializer=curvature_pb2.EstimateCurvatureResponse.FromString,
    )


def info_method(channel: typing.Any) -> typing.Any:
    """GetServerInfo, from nothing to ServerInfo."""
    return channel.unary_unary(
        f"/{SERVICE}/GetServerInfo", request_serializer=lambda _: b"", response_deserializer=_server_info
    )


def health_method(channel: typing.Any) -> typing.Any:
    """Check of grpc.health.v1, from nothing to the name of a ServingStatus."""
    service = SERVICE.encode()
    return channel.unary_unary(
        "/grpc.health.v1.Health/Check",
        # HealthCheckRequest has one field, number 1: the service's name.
        request_serializer=lambda _: b"\n" + bytes([len(service)]) + service,
        response_deserializer=_health,
    )


def was_answered(error: grpc.RpcError, any_message: bool) -> bool:
    """Whether a server took part in a call that failed, rather than being out of reach."""
    # Nobody but the client's own gRPC fails a call without metadata or a message in this way.
    return any_message or error.code() != grpc.StatusCode.UNAVAILABLE or bool(error.trailing_metadata())


def _server_info(packed: bytes) -> ServerInfo:
    message = curvature_pb2.GetServerInfoResponse.FromString(packed)
    limits = ServerLimits(*(getattr(message.limits, name) for name in ServerLimits._fields))
    estimators = tuple(estimator_name(number) for number in message.estimators)
    return ServerInfo(message.version, message.cpu_kind, message.worker_threads, estimators, limits)


def _health(packed: bytes) -> str:
    # HealthCheckResponse has one field, number 1: the status; absent where that is 0.
    number = packed[1] if len(packed) == 2 and packed[0] == 8 else 0
    return _HEALTH[number] if number < len(_HEALTH) else _HEALTH[0]
