"""Calls that no decent client would make: messages as bytes, sent in any order, answers left unread."""

import contextlib

import grpc
import numpy as np

from curvd_client import curvature_pb2 as pb
from curvd_client.errors import from_rpc_error

_METHOD = "/curvature.v1.CurvatureService/EstimateCurvature"
_CHUNK_POINTS = 20_000


class Call:
    """One EstimateCurvature call on a connection of its own, on raw bytes. Usable with `with`."""

    def __init__(self, address, timeout=None):
        self._channel = grpc.insecure_channel(address, [("grpc.use_local_subchannel_pool", 1)])
        self._method = self._channel.stream_stream(_METHOD, lambda message: message, lambda message: message)
        self._timeout = timeout
        self._call = None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self._call is not None:
            self._call.cancel()
        self._channel.close()

    def send(self, messages):
        """Starts the call: sends `messages`, then half-closes. Reads nothing."""
        self._call = self._method(iter(messages), timeout=self._timeout)

    def cancel(self):
        self._call.cancel()

    def status(self):
        """Reads to the end; returns the status code."""
        with contextlib.suppress(grpc.RpcError):
            for _ in self._call:
                pass
        return self._call.code()

    def reason(self):
        """Of the error that the call ended with. REQUIRES: status() was called."""
        return from_rpc_error(self._call).reason


def is_serving(address):
    """What health says of the service; None if nobody answers."""
    with grpc.insecure_channel(address, [("grpc.use_local_subchannel_pool", 1)]) as channel:
        check = channel.unary_unary("/grpc.health.v1.Health/Check", lambda message: message, lambda message: message)
        name = b"curvature.v1.CurvatureService"
        try:
            return check(b"\x0a" + bytes([len(name)]) + name, timeout=5) == b"\x08\x01"
        except grpc.RpcError:
            return None


def sphere(point_count):
    """Positions on the unit sphere along a spiral, which are their own normals: bytes of float32."""
    i = np.arange(point_count)
    height = 1 - (2 * i + 1) / max(point_count, 1)
    angle = np.pi * (3 - np.sqrt(5)) * i
    ring = np.sqrt(1 - height**2)
    return np.stack([ring * np.cos(angle), ring * np.sin(angle), height], axis=1).astype("<f4")


def header(point_count, **options):
    return pb.EstimateCurvatureRequest(
        header=pb.CloudHeader(point_count=point_count, options=pb.EstimatorOptions(**options))
    )


def chunk(first, points):
    packed = points.tobytes()
    return pb.EstimateCurvatureRequest(chunk=pb.PointChunk(first_index=first, positions=packed, normals=packed))


def cloud_requests(point_count, **options):
    """The messages of a good call, serialized."""
    yield header(point_count, **options).SerializeToString()
    points = sphere(point_count)
    for first in range(0, point_count, _CHUNK_POINTS):
        yield chunk(first, points[first : first + _CHUNK_POINTS]).SerializeToString()
