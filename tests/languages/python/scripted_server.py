"""Servers that play a script, and what they say."""

import concurrent.futures
import contextlib

import grpc
from google.protobuf import any_pb2

from curvd_client import curvature_pb2 as pb
from curvd_client import errors


@contextlib.contextmanager
def scripted(script):
    """The address of a server that reads the whole cloud, then plays script(context)."""

    def estimate(request_iterator, context):
        for _ in request_iterator:
            pass
        yield from script(context)

    handler = grpc.stream_stream_rpc_method_handler(
        estimate,
        request_deserializer=pb.EstimateCurvatureRequest.FromString,
        response_serializer=pb.EstimateCurvatureResponse.SerializeToString,
    )
    server = grpc.server(concurrent.futures.ThreadPoolExecutor(2))
    server.add_generic_rpc_handlers(
        (grpc.method_handlers_generic_handler("curvature.v1.CurvatureService", {"EstimateCurvature": handler}),)
    )
    port = server.add_insecure_port("127.0.0.1:0")
    server.start()
    yield f"127.0.0.1:{port}"
    server.stop(0)


def result(first, count, status_bytes=None):
    status = b"\1" * (count if status_bytes is None else status_bytes)
    return pb.EstimateCurvatureResponse(result=pb.ResultChunk(first_index=first, point_count=count, status=status))


def summary(count):
    return pb.EstimateCurvatureResponse(summary=pb.Summary(point_count=count))


def packed_details(*only):
    """A google.rpc.Status with an ErrorInfo, a RetryInfo and a detail that nobody knows, or `only` some of them."""
    messages = errors._MESSAGES
    info = messages["google.rpc.ErrorInfo"](reason="MEMORY_LIMIT", domain="curvd", metadata={"limit": "8"})
    retry = messages["google.rpc.RetryInfo"]()
    retry.retry_delay.seconds, retry.retry_delay.nanos = 1, 500_000_000
    status = messages["google.rpc.Status"](code=8)
    for name, value in [
        ("ErrorInfo", info.SerializeToString()),
        ("RetryInfo", retry.SerializeToString()),
        ("Unknown", b"?"),
    ]:
        if only and name not in only:
            continue
        detail = any_pb2.Any(type_url=f"type.googleapis.com/google.rpc.{name}", value=value)
        status.details.add().MergeFromString(detail.SerializeToString())
    return status.SerializeToString()
