"""One call: a cloud goes out in chunks, its curvature or normals come back."""

import contextlib
import operator
import typing
import warnings

import grpc
import numpy as np

from curvature.v1 import curvature_pb2, curvature_pb2_grpc
from curvd_client.errors import CurvdError, CurvdWarning, from_rpc_error
from curvd_client.normals import normal_options
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
    """points: structured array, one element a point: the fields of RESULT_DTYPE that were asked for, and those of normals.
    summary: the stream's Summary message."""

    points: np.ndarray
    summary: curvature_pb2.Summary


def estimate_curvature(
    positions,
    normals=None,
    *,
    server="localhost:50061",
    estimator="avg-hexagram",
    neighbor_count=None,
    radius=None,
    neighbor_count_range=None,
    max_radius=None,
    scale_per_cloud=False,
    triangle_count=0,
    rotation_count=0,
    jet_degree=0,
    even_weights=False,
    seed=0,
    average_normal_weight=None,
    orientation=None,
    viewpoint=None,
    direction=None,
    normal_method=None,
    normal_neighbor_count=None,
    normal_radius=None,
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
    """Estimates the curvature at every point of a cloud.

    positions, normals:    arrays of shape (N, 3). float64 positions are sent as such, which keeps georeferenced scans
                           exact; everything else is sent as float32. Normals point outward, of any length above zero.
                           Without normals (None), the server estimates and orients them, and the result has them as
                           `normal`.
    server:                HOST:PORT, or several with commas between: replicas, each call starting with any of them.
    estimator:             "avg-hexagram", "hexagram", "uniform", "independent", "delaunay", "jet", "aso",
                           "normal-regression", or "auto": what suits the cloud, averaged; summary.scale tells what was
                           chosen, and why.
    neighbor_count:        the K nearest points, the point itself included; or "auto": as noise and detail ask for, at each
                           point, for "auto" and the estimators that it chooses among. DEFAULT: 50, if there is no radius;
                           with the estimator "auto", "auto".
    radius:                all points at most this far away, instead of neighbor_count.
    neighbor_count_range:  of neighbor_count "auto": the fewest and the most points. DEFAULT: (16, 2048), the widest there
                           is, or up to what the server allows.
    max_radius:            of neighbor_count "auto": how far an estimate looks at most. DEFAULT: any distance.
    scale_per_cloud:       of neighbor_count "auto": the same choice for all points.
    triangle_count, seed:  of the random strategies. DEFAULT: 100 triangles, seed 0.
    rotation_count:        hexagrams that avg-hexagram averages over, 1 to 4. DEFAULT: 2.
    jet_degree:            of the polynomial that jet fits, 2 to 4; 4 for exact positions only. DEFAULT: 2; with neighbor_count
                           "auto" 4, and no other.
    even_weights:          count all triangles of delaunay alike, as the paper does.
    average_normal_weight: share of the neighborhood's mean normal, in [0, 1]. DEFAULT: 0.5.
    orientation:           which side is out: "consistent" (neighbors agree, closed pieces are seen from outside) or
                           "closed" (the same for closed surfaces with holes). Normals that are given are then turned, as
                           with viewpoint and direction. DEFAULT: given normals stay; estimated ones are consistent.
    viewpoint:             instead: where the surface was seen from, shape (3,), or where each point was, (N, 3).
    direction:             instead: no normal points against it, shape (3,).
    normal_method:         of estimated normals: "pca", "jet-1", "jet-2" or "jet-4". DEFAULT: jet-2 or jet-4, as the points
                           ask for.
    normal_neighbor_count, normal_radius: of which points normals are estimated. DEFAULT: as many as the noise of the
                           points asks for.
    quantities:            names of QUANTITIES that the result shall have, beside `status`. DEFAULT (none, or []): all of
                           curvature but "shape_index" and "curvedness", which follow from it, and "normals" unless they stay as they are given.
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
    normals_from, viewpoints = normal_options(
        normals is not None,
        orientation=orientation,
        viewpoint=viewpoint,
        direction=direction,
        method=normal_method,
        neighbor_count=normal_neighbor_count,
        radius=normal_radius,
    )
    options = _estimator_options(
        estimator,
        neighbor_count,
        radius,
        automatic_scale=_automatic_scale(
            estimator, neighbor_count, radius, neighbor_count_range, max_radius, scale_per_cloud
        ),
        triangle_count=triangle_count,
        rotation_count=rotation_count,
        jet_degree=jet_degree,
        even_weights=even_weights,
        seed=seed,
        average_normal_weight=average_normal_weight,
    )
    header = curvature_pb2.CloudHeader(
        normals=normals_from,
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
    return _run(header, positions, normals, viewpoints, server, timeout, max_attempts, security, channel)


def estimate_normals(
    positions,
    normals=None,
    *,
    server="localhost:50061",
    orientation=None,
    viewpoint=None,
    direction=None,
    method=None,
    neighbor_count=None,
    radius=None,
    skip_invalid=False,
    priority=None,
    request_tag="",
    timeout=None,
    max_attempts=6,
    security=Security(),
    channel=None,
):
    """Estimates the normal at every point of a cloud; or turns those that are given, as orientation, viewpoint or
    direction says.

    method, neighbor_count, radius: as estimate_curvature has them for normals.
    All others:                     as there.

    Returns an Estimate whose points have `normal`, of unit length, `normal_residual`, `normal_variance_ratio` (both NaN for
    normals that were given) and `status`, which says why there is no normal where it is not PointStatus.OK.
    summary.normals tells how they were made, and whether their sides can be trusted. Raises and warns as
    estimate_curvature. Thread-safe.
    """
    normals_from, viewpoints = normal_options(
        normals is not None,
        orientation=orientation,
        viewpoint=viewpoint,
        direction=direction,
        method=method,
        neighbor_count=neighbor_count,
        radius=radius,
    )
    header = curvature_pb2.CloudHeader(
        normals=normals_from,
        quantities=[curvature_pb2.QUANTITY_NORMALS, curvature_pb2.QUANTITY_NORMAL_QUALITY],
        invalid_point_policy=(
            curvature_pb2.INVALID_POINT_POLICY_SKIP if skip_invalid else curvature_pb2.INVALID_POINT_POLICY_REJECT
        ),
        priority=_priority(priority),
        request_tag=request_tag,
    )
    return _run(header, positions, normals, viewpoints, server, timeout, max_attempts, security, channel)


def _run(header, positions, normals, viewpoints, server, timeout, max_attempts, security, channel):
    """Sends the cloud under the header, and warns two frames up."""
    cloud = _packed_arrays(positions, normals, viewpoints)
    header.point_count = len(cloud["positions"])
    is_double = cloud["positions"].itemsize == 8
    header.scalar_type = curvature_pb2.SCALAR_TYPE_FLOAT64 if is_double else curvature_pb2.SCALAR_TYPE_FLOAT32
    with contextlib.ExitStack() as opened:
        channels = [channel]
        if channel is None:
            addresses = [address.strip() for address in server.split(",")]
            channels = [opened.enter_context(security.open_channel(each, _CHANNEL_OPTIONS)) for each in addresses]
        estimate = call_with_retries(
            channels,
            lambda target, time_left: _call(target, header, cloud, time_left, security.metadata()),
            await_connection=_await_connection,
            timeout=timeout,
            max_attempts=max_attempts,
        )
    for warning in estimate.summary.warnings:
        warnings.warn(CurvdWarning(_warning_code(warning.code), warning.message), stacklevel=3)
    return estimate


def _warning_code(number):
    """Its name in the contract without prefix; the number, if the contract has gained it since."""
    value = curvature_pb2.WarningCode.DESCRIPTOR.values_by_number.get(number)
    return str(number) if value is None else value.name.removeprefix("WARNING_CODE_")


def _packed_arrays(positions, normals, viewpoints):
    """The arrays of PointChunk that there are, by their names."""
    given = {"positions": positions, "normals": normals, "viewpoints": viewpoints}
    cloud = {name: np.asarray(array) for name, array in given.items() if array is not None}
    for name, array in cloud.items():
        if array.ndim != 2 or array.shape[1] != 3:
            raise ValueError(f"{name} has shape {array.shape}; it must be (N, 3)")
        if len(array) != len(cloud["positions"]):
            raise ValueError(f"{len(cloud['positions'])} positions but {len(array)} {name}")
    scalar = "<f8" if cloud["positions"].dtype == np.float64 else "<f4"
    return {name: np.ascontiguousarray(array, scalar) for name, array in cloud.items()}


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


def _automatic_scale(estimator, neighbor_count, radius, neighbor_count_range, max_radius, per_cloud):
    """The contract's AutomaticScale, or None where the caller says how large neighborhoods are."""
    if radius is not None and "auto" in (estimator, neighbor_count):
        raise ValueError('radius does not go with "auto"; max_radius says how far an estimate looks at most')
    leaves_open = estimator == "auto" and neighbor_count is None
    if neighbor_count != "auto" and not leaves_open:
        if neighbor_count_range is not None or max_radius is not None or per_cloud:
            raise ValueError('neighbor_count_range, max_radius and scale_per_cloud need neighbor_count="auto"')
        return None
    scale = curvature_pb2.AutomaticScale(max_radius=max_radius or 0.0, per_cloud=per_cloud)
    if neighbor_count_range is not None:
        try:
            scale.least_neighbor_count, scale.most_neighbor_count = map(operator.index, neighbor_count_range)
        except (TypeError, ValueError):
            raise ValueError(
                f"neighbor_count_range is {neighbor_count_range!r}; it must be (fewest, most) points, as (16, 2048)"
            ) from None
    return scale


def _estimator_options(estimator, neighbor_count, radius, automatic_scale, **others):
    if estimator not in _ESTIMATORS:
        raise ValueError(f"estimator is {estimator!r}; it must be one of {', '.join(_ESTIMATORS)}")
    if neighbor_count is not None and radius is not None:
        raise ValueError("neighbor_count and radius exclude each other")
    if isinstance(neighbor_count, str) and neighbor_count != "auto":
        raise ValueError(f"neighbor_count is {neighbor_count!r}; it must be a number or 'auto'")
    options = curvature_pb2.EstimatorOptions(estimator=_ESTIMATORS[estimator], **others)
    if automatic_scale is not None:
        options.automatic_scale.CopyFrom(automatic_scale)
    elif radius is not None:
        options.radius = radius
    elif neighbor_count is not None:
        options.neighbor_count = neighbor_count
    return options


def _requests(header, cloud):
    yield curvature_pb2.EstimateCurvatureRequest(header=header)
    step = _CHUNK_BYTES // (len(cloud) * 3 * cloud["positions"].itemsize)
    for first in range(0, header.point_count, step):
        arrays = {name: array[first : first + step].tobytes() for name, array in cloud.items()}
        yield curvature_pb2.EstimateCurvatureRequest(chunk=curvature_pb2.PointChunk(first_index=first, **arrays))


def _await_connection(channel):
    """Gives a server that may have come back the time to take a connection: a call of its own would fail at once."""
    with contextlib.suppress(grpc.FutureTimeoutError):
        grpc.channel_ready_future(channel).result(_CONNECT_SECONDS)


def _check_accepted(accepted, header):
    """Raises CurvdError if the server takes normals as given that it was to make or orient, or chooses no scale."""
    if header.options.HasField("automatic_scale") and not accepted.options.HasField("automatic_scale"):
        raise CurvdError(grpc.StatusCode.UNIMPLEMENTED, "the server is too old to choose a scale")
    given, asked = curvature_pb2.NORMAL_SOURCE_GIVEN, header.normals.source
    if asked not in (given, accepted.normals.source):
        raise CurvdError(grpc.StatusCode.UNIMPLEMENTED, "the server is too old to make or orient normals")


def _call(channel, header, cloud, timeout, metadata):
    stub = curvature_pb2_grpc.CurvatureServiceStub(channel)
    call = stub.EstimateCurvature(_requests(header, cloud), timeout=timeout, metadata=metadata)
    collector = ResultCollector(
        header.point_count, header.quantities, header.normals.source != curvature_pb2.NORMAL_SOURCE_GIVEN
    )
    summary = None
    try:
        for response in call:
            kind = response.WhichOneof("message")
            if kind == "accepted":
                _check_accepted(response.accepted, header)
            elif kind == "result":
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
