"""Turns the arguments of a call into the contract's CloudHeader, and says what is wrong with those that make none."""

from __future__ import annotations

import difflib
import functools
import inspect
import typing

import numpy as np
import numpy.typing as npt

from curvd_client.fields import (
    chosen,
    count,
    count_or_default,
    listed,
    positive_number_or_default,
    real_number,
    seed_number,
    shown,
)
from curvd_client import curvature_pb2
from curvd_client.normals import normal_options, vector_or_vectors
from curvd_client.results import quantity_number

# Vectors of the points beside their normals, by their names in PointChunk.
Vectors = typing.Dict[str, npt.ArrayLike]

# Two estimators have shorter names than the contract gives them.
_SHORT_NAMES = {"jet-fitting": "jet", "algebraic-shape-operator": "aso"}


def _estimators_of_the_contract() -> dict[str, typing.Any]:
    """Every estimator by the name that people use: that of the contract without prefix, in small letters, - for _."""
    estimators: dict[str, typing.Any] = {}
    for value in curvature_pb2.Estimator.DESCRIPTOR.values:
        if value.number == curvature_pb2.ESTIMATOR_UNSPECIFIED:
            continue
        name = value.name[len("ESTIMATOR_") :].lower().replace("_", "-")
        estimators[_SHORT_NAMES.get(name, name)] = value.number
    return estimators


ESTIMATORS = _estimators_of_the_contract()

_PRIORITIES: dict[str, curvature_pb2.Priority] = {
    "interactive": curvature_pb2.PRIORITY_INTERACTIVE,
    "batch": curvature_pb2.PRIORITY_BATCH,
}


class NormalsOptions(typing.TypedDict, total=False):
    """The options of a call for normals, which curvd_client.estimate_normals explains."""

    orientation: str | None
    viewpoint: npt.ArrayLike | None
    direction: npt.ArrayLike | None
    method: str | None
    neighbor_count: int | None
    radius: float | None
    skip_invalid: bool
    priority: str | None
    request_tag: str


class CurvatureOptions(typing.TypedDict, total=False):
    """The options of a call for curvature, which curvd_client.estimate_curvature explains."""

    estimator: str
    neighbor_count: int | str | None
    neighbor_counts: typing.Sequence[int] | None
    radius: float | None
    neighbor_count_range: tuple[int, int] | None
    max_radius: float | None
    scale_per_cloud: bool
    triangle_count: int | None
    rotation_count: int | None
    jet_degree: int | None
    regression_degree: int | None
    even_weights: bool
    project: bool
    seed: int
    average_normal_weight: float | None
    orientation: str | None
    viewpoint: npt.ArrayLike | None
    direction: npt.ArrayLike | None
    normal_method: str | None
    normal_neighbor_count: int | None
    normal_radius: float | None
    quantities: typing.Sequence[str] | None
    curvature_direction: npt.ArrayLike | None
    skip_invalid: bool
    reject_opposed_normals: bool
    priority: str | None
    request_tag: str


_Header = typing.TypeVar("_Header", bound=typing.Callable[..., typing.Any])


def _checks_options(make_header: _Header) -> _Header:
    """Has `make_header` raise TypeError for options that do not exist, and ValueError for what is no truth value or text."""
    parameters = inspect.signature(make_header).parameters

    @functools.wraps(make_header)
    def checked(has_normals: bool, **options: typing.Any) -> typing.Any:
        for name, value in options.items():
            if name not in parameters:
                near = difflib.get_close_matches(name, parameters, n=1)
                raise TypeError(f"there is no option {name}" + (f"; did you mean {near[0]}?" if near else ""))
            default = parameters[name].default
            if isinstance(default, bool):
                if not isinstance(value, (bool, np.bool_)):
                    raise ValueError(f"{name} is {shown(value)}; it must be True or False")
                options[name] = bool(value)  # protobuf takes no other kind of truth value
            if default == "" and not isinstance(value, str):
                raise ValueError(f"{name} is {shown(value)}; it must be text")
        return make_header(has_normals, **options)

    return typing.cast(_Header, checked)


@_checks_options
def curvature_header(
    has_normals: bool,
    *,
    estimator: str = "avg-hexagram",
    neighbor_count: int | str | None = None,
    neighbor_counts: typing.Sequence[int] | None = None,
    radius: float | None = None,
    neighbor_count_range: tuple[int, int] | None = None,
    max_radius: float | None = None,
    scale_per_cloud: bool = False,
    triangle_count: int | None = None,
    rotation_count: int | None = None,
    jet_degree: int | None = None,
    regression_degree: int | None = None,
    even_weights: bool = False,
    project: bool = False,
    seed: int = 0,
    average_normal_weight: float | None = None,
    orientation: str | None = None,
    viewpoint: npt.ArrayLike | None = None,
    direction: npt.ArrayLike | None = None,
    normal_method: str | None = None,
    normal_neighbor_count: int | None = None,
    normal_radius: float | None = None,
    quantities: typing.Sequence[str] | None = None,
    curvature_direction: npt.ArrayLike | None = None,
    skip_invalid: bool = False,
    reject_opposed_normals: bool = False,
    priority: str | None = None,
    request_tag: str = "",
) -> tuple[curvature_pb2.CloudHeader, Vectors]:
    """The header of a call for curvature, without what the cloud's arrays say, and the vectors of points that it needs.

    The arguments are those of estimate_curvature. Raises ValueError, naming the argument, for those that make no
    request.
    """
    normals_from, viewpoints = normal_options(
        has_normals,
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
        regression_degree=regression_degree,
        even_weights=even_weights,
        project=project,
        seed=seed,
        average_normal_weight=average_normal_weight,
    )
    if neighbor_counts is not None:
        if options.WhichOneof("neighborhood") is not None:
            raise ValueError("neighbor_counts exclude neighbor_count, radius and the estimator auto")
        options.neighbor_counts.extend(_counts(neighbor_counts))
    header = curvature_pb2.CloudHeader(
        normals=normals_from,
        options=options,
        quantities=_quantity_numbers(quantities),
        invalid_point_policy=_invalid_point_policy(skip_invalid),
        opposed_normals_policy=(
            curvature_pb2.OPPOSED_NORMALS_POLICY_REJECT
            if reject_opposed_normals
            else curvature_pb2.OPPOSED_NORMALS_POLICY_MARK
        ),
        priority=_priority(priority),
        request_tag=request_tag,
    )
    vectors = _vectors(viewpoints)
    if curvature_direction is not None:
        if curvature_pb2.QUANTITY_NORMAL_CURVATURE not in header.quantities:
            raise ValueError('curvature_direction needs "normal_curvature" among the quantities')
        one, each = vector_or_vectors("curvature_direction", curvature_direction)
        if one is not None:
            header.curvature_direction.x, header.curvature_direction.y, header.curvature_direction.z = one
        if each is not None:
            vectors["curvature_directions"] = each
    elif curvature_pb2.QUANTITY_NORMAL_CURVATURE in header.quantities:
        raise ValueError('the quantity "normal_curvature" needs a curvature_direction')
    return header, vectors


@_checks_options
def normals_header(
    has_normals: bool,
    *,
    orientation: str | None = None,
    viewpoint: npt.ArrayLike | None = None,
    direction: npt.ArrayLike | None = None,
    method: str | None = None,
    neighbor_count: int | None = None,
    radius: float | None = None,
    skip_invalid: bool = False,
    priority: str | None = None,
    request_tag: str = "",
) -> tuple[curvature_pb2.CloudHeader, Vectors]:
    """The same for a call for normals alone; the arguments are those of estimate_normals."""
    normals_from, viewpoints = normal_options(
        has_normals,
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
        invalid_point_policy=_invalid_point_policy(skip_invalid),
        priority=_priority(priority),
        request_tag=request_tag,
    )
    return header, _vectors(viewpoints)


def estimator_name(number: int) -> str:
    """The name that people use for the contract's number of an estimator; the number, if it is of a later contract."""
    return next((name for name, each in ESTIMATORS.items() if each == number), str(number))


def _vectors(viewpoints: npt.ArrayLike | None) -> Vectors:
    return {} if viewpoints is None else {"viewpoints": viewpoints}


def _invalid_point_policy(skip: bool) -> curvature_pb2.InvalidPointPolicy:
    return curvature_pb2.INVALID_POINT_POLICY_SKIP if skip else curvature_pb2.INVALID_POINT_POLICY_REJECT


def _quantity_numbers(names: typing.Sequence[str] | None) -> list[typing.Any]:
    if names is None:
        return []
    each_name = listed(tuple(names) if isinstance(names, typing.AbstractSet) else names)
    if each_name is None:
        raise ValueError(f"quantities is {shown(names)}; it must be a list of names")
    numbers = [quantity_number(name) for name in each_name]
    if len(set(numbers)) != len(numbers):
        raise ValueError(f"quantities is {shown(each_name)}; it must have each name at most once")
    return numbers


def _priority(name: str | None) -> curvature_pb2.Priority:
    return curvature_pb2.PRIORITY_UNSPECIFIED if name is None else chosen("priority", name, _PRIORITIES)


def _counts(neighbor_counts: typing.Sequence[int]) -> list[int]:
    """Raises ValueError if they are no numbers that ascend."""
    counts = [count(f"neighbor_counts[{i}]", each) for i, each in enumerate(listed(neighbor_counts) or ())]
    if not counts or counts != sorted(set(counts)):
        raise ValueError(f"neighbor_counts is {shown(neighbor_counts)}; it must be a list of numbers that ascend")
    return counts


def _is_auto(value: object) -> bool:
    """An array would compare each of its elements."""
    return isinstance(value, str) and value == "auto"


def _automatic_scale(
    estimator: str,
    neighbor_count: int | str | None,
    radius: float | None,
    neighbor_count_range: tuple[int, int] | None,
    max_radius: float | None,
    per_cloud: bool,
) -> curvature_pb2.AutomaticScale | None:
    """The contract's AutomaticScale, or None where the caller says how large neighborhoods are."""
    if radius is not None and (_is_auto(estimator) or _is_auto(neighbor_count)):
        raise ValueError('radius does not go with "auto"; max_radius says how far an estimate looks at most')
    leaves_open = _is_auto(estimator) and neighbor_count is None
    if not _is_auto(neighbor_count) and not leaves_open:
        if neighbor_count_range is not None or max_radius is not None or per_cloud:
            raise ValueError('neighbor_count_range, max_radius and scale_per_cloud need neighbor_count="auto"')
        return None
    scale = curvature_pb2.AutomaticScale(
        max_radius=positive_number_or_default("max_radius", max_radius), per_cloud=per_cloud
    )
    if neighbor_count_range is not None:
        try:
            fewest, most = listed(neighbor_count_range) or []
            scale.least_neighbor_count, scale.most_neighbor_count = (
                count("neighbor_count_range", each) for each in (fewest, most)
            )
        except ValueError:
            raise ValueError(
                f"neighbor_count_range is {shown(neighbor_count_range)}; it must be (fewest, most) points, as (16, 2048)"
            ) from None
    return scale


def _estimator_options(
    estimator: str,
    neighbor_count: int | str | None,
    radius: float | None,
    automatic_scale: curvature_pb2.AutomaticScale | None,
    **others: typing.Any,
) -> curvature_pb2.EstimatorOptions:
    estimator_number = chosen("estimator", estimator, ESTIMATORS)
    if neighbor_count is not None and radius is not None:
        raise ValueError("neighbor_count and radius exclude each other")
    if isinstance(neighbor_count, str) and neighbor_count != "auto":
        raise ValueError(f"neighbor_count is {shown(neighbor_count)}; it must be a number or 'auto'")
    for name in ("triangle_count", "rotation_count", "jet_degree", "regression_degree"):
        others[name] = count_or_default(name, others[name])
    others["seed"] = seed_number("seed", others["seed"])
    if others["average_normal_weight"] is not None:
        others["average_normal_weight"] = real_number("average_normal_weight", others["average_normal_weight"])
    options = curvature_pb2.EstimatorOptions(estimator=estimator_number, **others)
    if automatic_scale is not None:
        options.automatic_scale.CopyFrom(automatic_scale)
    elif radius is not None:
        options.radius = real_number("radius", radius)
    elif neighbor_count is not None:
        options.neighbor_count = count("neighbor_count", neighbor_count)  # a name would have made a scale
    return options
