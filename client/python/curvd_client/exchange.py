"""The two sides of one call's stream, without a connection: what is sent, and what becomes of the answers."""

from __future__ import annotations

import typing
import warnings

import grpc
import numpy.typing as npt

from curvd_client import curvature_pb2
from curvd_client.clouds import Cloud, pack_cloud
from curvd_client.errors import CurvdError, CurvdWarning, broken_protocol
from curvd_client.options import Vectors
from curvd_client.progress import Progress, ProgressCallback, progress_of
from curvd_client.results import Estimate, ResultCollector

SERVICE = "curvature.v1.CurvatureService"
_CHUNK_BYTES = 1 << 20


class Request(typing.NamedTuple):
    """A cloud, ready to be sent as often as it takes."""

    header: curvature_pb2.CloudHeader
    cloud: Cloud

    def messages(self) -> typing.Iterator[curvature_pb2.EstimateCurvatureRequest]:
        """The client's side of the stream."""
        yield curvature_pb2.EstimateCurvatureRequest(header=self.header)
        step = _CHUNK_BYTES // (len(self.cloud) * 3 * self.cloud["positions"].itemsize)
        for first in range(0, self.header.point_count, step):
            part = slice(first, first + step)
            arrays: dict[str, typing.Any] = {name: array[part].tobytes() for name, array in self.cloud.items()}
            chunk = curvature_pb2.PointChunk(first_index=first, **arrays)
            yield curvature_pb2.EstimateCurvatureRequest(chunk=chunk)


def make_request(
    header_and_vectors: tuple[curvature_pb2.CloudHeader, Vectors],
    positions: npt.ArrayLike,
    normals: npt.ArrayLike | None,
) -> Request:
    """The header completed with what the arrays say. Raises ValueError if they make no cloud."""
    header, vectors = header_and_vectors
    cloud = pack_cloud(positions, normals, vectors)
    header.point_count = len(cloud["positions"])
    is_double = cloud["positions"].itemsize == 8
    header.scalar_type = curvature_pb2.SCALAR_TYPE_FLOAT64 if is_double else curvature_pb2.SCALAR_TYPE_FLOAT32
    return Request(header, cloud)


class Answers:
    """Takes the server's side of the stream, message by message."""

    def __init__(self, request: Request, on_progress: ProgressCallback | None) -> None:
        self._header = request.header
        self._on_progress = on_progress
        self._collector = ResultCollector(
            request.header.point_count,
            request.header.quantities,
            request.header.normals.source != curvature_pb2.NORMAL_SOURCE_GIVEN,
            request.header.options.neighbor_counts,
        )
        self._summary: curvature_pb2.Summary | None = None
        self.any = False

    def take(self, response: curvature_pb2.EstimateCurvatureResponse) -> object:
        """Returns what the function for progress returned, None where it was not called.

        Raises CurvdError if the message breaks the protocol, or the server is too old for the call.
        """
        self.any = True
        kind = response.WhichOneof("message")
        if kind == "accepted":
            _check_accepted(response.accepted, self._header)
        elif kind == "progress" and self._on_progress is not None:
            return self._on_progress(progress_of(response.progress, self._header.point_count))
        elif kind == "result":
            try:
                self._collector.add(response.result)
            except ValueError as error:
                raise broken_protocol(error) from None
        elif kind == "summary":
            self._summary = response.summary
            if self._on_progress is not None:
                return self._on_progress(Progress.of_all(self._header.point_count))
        return None

    def estimate(self) -> Estimate:
        """What came, after the stream's end. Raises CurvdError if anything is missing."""
        try:
            return Estimate(self._collector.points, self._collector.finish(self._summary))
        except ValueError as error:
            raise broken_protocol(error) from None


def warn(estimate: Estimate, stacklevel: int) -> None:
    """Issues the summary's warnings as CurvdWarnings, as from the caller so many frames up."""
    for warning in estimate.summary.warnings:
        value = curvature_pb2.WarningCode.DESCRIPTOR.values_by_number.get(warning.code)
        code = str(warning.code) if value is None else value.name.removeprefix("WARNING_CODE_")
        warnings.warn(CurvdWarning(code, warning.message), stacklevel=stacklevel + 1)


def _check_accepted(accepted: curvature_pb2.Accepted, header: curvature_pb2.CloudHeader) -> None:
    """Raises CurvdError if the server takes normals as given that it was to make or orient, or chooses no scale,
    or estimates one of several."""
    if list(header.options.neighbor_counts) != list(accepted.options.neighbor_counts):
        raise CurvdError(grpc.StatusCode.UNIMPLEMENTED, "the server is too old to take several neighbor counts")
    if header.options.HasField("automatic_scale") and not accepted.options.HasField("automatic_scale"):
        raise CurvdError(grpc.StatusCode.UNIMPLEMENTED, "the server is too old to choose a scale")
    given, asked = curvature_pb2.NORMAL_SOURCE_GIVEN, header.normals.source
    if asked not in (given, accepted.normals.source):
        raise CurvdError(grpc.StatusCode.UNIMPLEMENTED, "the server is too old to make or orient normals")
