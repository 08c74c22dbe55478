"""One call: a cloud goes out in chunks, its curvature comes back."""

import contextlib
import typing
import warnings

import grpc
import numpy as np

from curvature.v1 import curvature_pb2, curvature_pb2_grpc
from curvd_client.errors import CurvdError, CurvdWarning, from_rpc_error
from curvd_client.results import ResultCollector, quantity_number
from curvd_client.retries import call_with_retries
from curvd_client.security import Security

_CHUNK_BYTES = 1 << 20
_CONNECT_SECONDS = 1.0
_CHANNEL_OPTIONS = [
    # A peer that died without a word is found in seconds.
    ("grpc.keepalive_time_ms", 10_000),
    ("grpc.keepalive_timeout_ms", 5_000),
    # One that came back is found by the next try, one that drops packets is given up.
    ("grpc.initial_reconnect_backoff_ms", 250),
    ("grpc.max_reconnect_backoff_ms", 2_000),
    ("grpc.min_reconnect_backoff_ms", 5_000),
    ("grpc.max_receive_message_length", 256 << 20),
]


# Two estimators have shorter names than the contract gives them.
_SHORT_NAMES = {"jet-fitting": "jet", "algebraic-shape-operator": "aso"}


def _estimators_of_the_contract():
    """Every estimator by the name that people use: that of the contract without prefix, in small letters, - for _."""
    estimators = {}
    for value in curvature_pb2.Estimator.DESCRIPTOR.values:
        if value.number == curvature_pb2.ESTIMATOR_UNSPECIFIED:
            continue
        name = value.name[len("ESTIMATOR_") :].lower().replace("_", "-")
        estimators[_SHORT_NAMES.get(name, name)] = value.number
    return estimators


_ESTIMATORS = _estimators_of_the_contract()

_PRIORITIES = {
    None: curvature_pb2.PRIORITY_UNSPECIFIED,
    "interactive": curvature_pb2.PRIORITY_INTERACTIVE,
    "batch": curvature_pb2.PRIORITY_BATCH,
}


class Estimate(typing.NamedTuple):
    """points: structured array, one element a point, of RESULT_DTYPE or the fields of it that were asked for.
    summary: the stream's Summary message."""

    points: np.ndarray
    summary: curvature_pb2.Summary


def estimate_curvature(
    positions,
    normals,
    *,
    server="localhost:50061",
    estimator="avg-hexagram",
    neighbor_count=None,
    radius=None,
    triangle_count=0,
    rotation_count=0,
    jet_degree=0,
    even_weights=False,
    seed=0,
    average_normal_weight=None,
    quantities=None,
    skip_invalid=False,
    reject_opposed_normals=False,
    priority=None,
    request_tag="",
    timeout=None,
    max_attempts=6,
    security=Security(),
    channel=None,
):
    """Estimates the curvature at every point of an oriented cloud.

    positions, normals:    arrays of shape (N, 3). float64 positions are sent as such, which keeps georeferenced scans
                           exact; everything else is sent as float32. Normals point outward, of any length above zero.
    server:                HOST:PORT, or several with commas between: replicas, each call starting with any of them.
    estimator:             "avg-hexagram", "hexagram", "uniform", "independent", "delaunay", "jet" or "aso".
    neighbor_count:        the K nearest points, the point itself included. DEFAULT: 50, if there is no radius.
    radius:                all points at most this far away, instead of neighbor_count.
    triangle_count, seed:  of the random strategies. DEFAULT: 100 triangles, seed 0.
    rotation_count:        hexagrams that avg-hexagram averages over, 1 to 4. DEFAULT: 2.
    jet_degree:            of the polynomial that jet fits, 2 to 4; 4 for exact positions only. DEFAULT: 2.
    even_weights:          count all triangles of delaunay alike, as the paper does.
    average_normal_weight: share of the neighborhood's mean normal, in [0, 1]. DEFAULT: 0.5.
    quantities:            names of QUANTITIES that the result shall have, beside `status`; none, or [], for all.
                           DEFAULT: all.
    skip_invalid:          give an unusable point a status instead of failing the call.
    reject_opposed_normals: fail the call if normals point to opposite sides of one surface, instead of giving the points
                           around such places a status, and warning.
    priority:              "interactive" if somebody waits, "batch" if it can wait. DEFAULT: interactive up to 100,000
                           points, batch above.
    request_tag:           free text for the server's log.
    timeout:               seconds for the whole call with its retries. DEFAULT: no limit.
    max_attempts:          times the cloud is sent at most, while servers are unavailable or ask to wait: at once to the
                           next replica, then with growing pauses. DEFAULT: 6, over about 8 seconds.
    security:              TLS and token, see Security. DEFAULT: plain text, no token.
    channel:               a channel of your own instead of `server`; security's token is not checked for plain text then.

    Returns an Estimate. Raises CurvdError if the call fails, ValueError if the arguments make no request. What the server
    finds wrong with a cloud that it estimates nevertheless (summary.warnings) is issued as a CurvdWarning. Thread-safe.
    """
    positions, normals = _packed_arrays(positions, normals)
    options = _estimator_options(
        estimator,
        neighbor_count,
        radius,
        triangle_count=triangle_count,
        rotation_count=rotation_count,
        jet_degree=jet_degree,
        even_weights=even_weights,
        seed=seed,
        average_normal_weight=average_normal_weight,
    )
    header = curvature_pb2.CloudHeader(
        point_count=len(positions),
        scalar_type=(
            curvature_pb2.SCALAR_TYPE_FLOAT64 if positions.itemsize == 8 else curvature_pb2.SCALAR_TYPE_FLOAT32
        ),
        options=options,
        quantities=_quantity_numbers(quantities),
        invalid_point_policy=(
            curvature_pb2.INVALID_POINT_POLICY_SKIP if skip_invalid else curvature_pb2.INVALID_POINT_POLICY_REJECT
        ),
        opposed_normals_policy=(
            curvature_pb2.OPPOSED_NORMALS_POLICY_REJECT
            if reject_opposed_normals
            else curvature_pb2.OPPOSED_NORMALS_POLICY_MARK
        ),
        priority=_priority(priority),
        request_tag=request_tag,
    )
    with contextlib.ExitStack() as opened:
        channels = [channel]
        if channel is None:
            addresses = [address.strip() for address in server.split(",")]
            channels = [opened.enter_context(security.open_channel(each, _CHANNEL_OPTIONS)) for each in addresses]
        estimate = call_with_retries(
            channels,
            lambda target, time_left: _call(target, header, positions, normals, time_left, security.metadata()),
            await_connection=_await_connection,
            timeout=timeout,
            max_attempts=max_attempts,
        )
    for warning in estimate.summary.warnings:
        warnings.warn(CurvdWarning(_warning_code(warning.code), warning.message), stacklevel=2)
    return estimate


def _warning_code(number):
    """Its name in the contract without prefix; the number, if the contract has gained it since."""
    value = curvature_pb2.WarningCode.DESCRIPTOR.values_by_number.get(number)
    return str(number) if value is None else value.name.removeprefix("WARNING_CODE_")


def _packed_arrays(positions, normals):
    positions, normals = np.asarray(positions), np.asarray(normals)
    for name, array in (("positions", positions), ("normals", normals)):
        if array.ndim != 2 or array.shape[1] != 3:
            raise ValueError(f"{name} has shape {array.shape}; it must be (N, 3)")
    if len(positions) != len(normals):
        raise ValueError(f"{len(positions)} positions but {len(normals)} normals")
    scalar = "<f8" if positions.dtype == np.float64 else "<f4"
    return np.ascontiguousarray(positions, scalar), np.ascontiguousarray(normals, scalar)


def _quantity_numbers(names):
    if names is None:
        return []
    if isinstance(names, str):
        raise ValueError(f"quantities is {names!r}; it must be a list of names")
    numbers = [quantity_number(name) for name in names]
    if len(set(numbers)) != len(numbers):
        raise ValueError(f"quantities is {list(names)}; it must have each name at most once")
    return numbers


def _priority(name):
    if name not in _PRIORITIES:
        raise ValueError(f"priority is {name!r}; it must be interactive, batch or None")
    return _PRIORITIES[name]


def _estimator_options(estimator, neighbor_count, radius, **others):
    if estimator not in _ESTIMATORS:
        raise ValueError(f"estimator is {estimator!r}; it must be one of {', '.join(_ESTIMATORS)}")
    if neighbor_count is not None and radius is not None:
        raise ValueError("neighbor_count and radius exclude each other")
    options = curvature_pb2.EstimatorOptions(estimator=_ESTIMATORS[estimator], **others)
    if radius is not None:
        options.radius = radius
    elif neighbor_count is not None:
        options.neighbor_count = neighbor_count
    return options


def _requests(header, positions, normals):
    yield curvature_pb2.EstimateCurvatureRequest(header=header)
    step = _CHUNK_BYTES // (6 * positions.itemsize)
    for first in range(0, len(positions), step):
        yield curvature_pb2.EstimateCurvatureRequest(
            chunk=curvature_pb2.PointChunk(
                first_index=first,
                positions=positions[first : first + step].tobytes(),
                normals=normals[first : first + step].tobytes(),
            )
        )


def _await_connection(channel):
    """Gives a server that may have come back the time to take a connection: a call of its own would fail at once."""
    with contextlib.suppress(grpc.FutureTimeoutError):
        grpc.channel_ready_future(channel).result(_CONNECT_SECONDS)


def _call(channel, header, positions, normals, timeout, metadata):
    stub = curvature_pb2_grpc.CurvatureServiceStub(channel)
    call = stub.EstimateCurvature(_requests(header, positions, normals), timeout=timeout, metadata=metadata)
    collector = ResultCollector(len(positions), header.quantities)
    summary = None
    try:
        for response in call:
            kind = response.WhichOneof("message")
            if kind == "result":
                collector.add(response.result)
            elif kind == "summary":
                summary = response.summary
        collector.finish(summary)
    except grpc.RpcError as error:
        raise from_rpc_error(error) from None
    except ValueError as error:
        raise CurvdError(grpc.StatusCode.INTERNAL, f"the server broke the protocol: {error}") from None
    finally:
        call.cancel()
    return Estimate(collector.points, summary)
