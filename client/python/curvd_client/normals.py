"""Where the normals of a cloud come from, and which side of its surface is out."""

from __future__ import annotations

import typing

import numpy as np
import numpy.typing as npt

from curvd_client.clouds import real_array
from curvd_client import curvature_pb2
from curvd_client.fields import chosen, count, real_number

_METHODS = {
    "pca": curvature_pb2.NORMAL_METHOD_PCA,
    "jet-1": curvature_pb2.NORMAL_METHOD_JET_1,
    "jet-2": curvature_pb2.NORMAL_METHOD_JET_2,
    "jet-4": curvature_pb2.NORMAL_METHOD_JET_4,
}
_ORIENTATIONS = {
    "consistent": curvature_pb2.ORIENTATION_CONSISTENT,
    "closed": curvature_pb2.ORIENTATION_CLOSED,
}


def normal_options(
    has_normals: bool,
    *,
    orientation: str | None,
    viewpoint: npt.ArrayLike | None,
    direction: npt.ArrayLike | None,
    method: str | None,
    neighbor_count: int | None,
    radius: float | None,
) -> tuple[curvature_pb2.NormalOptions, npt.NDArray[typing.Any] | None]:
    """Returns the contract's NormalOptions and the viewpoints of points, None if there are none.

    Normals that are given stay as they are unless orientation, viewpoint or direction says which side is out; those
    that are not are estimated. Raises ValueError, naming the argument, for arguments that make no sense together.
    """
    if sum(side is not None for side in (orientation, viewpoint, direction)) > 1:
        raise ValueError("orientation, viewpoint and direction exclude each other")
    options = curvature_pb2.NormalOptions(source=_source(has_normals, (orientation, viewpoint, direction)))
    viewpoints = _set_side(options, orientation, viewpoint, direction)
    _set_method(options, has_normals, method, neighbor_count, radius)
    return options, viewpoints


def _source(has_normals: bool, sides: tuple[object, ...]) -> curvature_pb2.NormalSource:
    if not has_normals:
        return curvature_pb2.NORMAL_SOURCE_ESTIMATE
    if all(side is None for side in sides):
        return curvature_pb2.NORMAL_SOURCE_GIVEN
    return curvature_pb2.NORMAL_SOURCE_ORIENT


def _set_side(
    options: curvature_pb2.NormalOptions,
    orientation: str | None,
    viewpoint: npt.ArrayLike | None,
    direction: npt.ArrayLike | None,
) -> npt.NDArray[typing.Any] | None:
    if orientation is not None:
        options.orientation = chosen("orientation", orientation, _ORIENTATIONS)
    if direction is not None:
        options.orientation = curvature_pb2.ORIENTATION_DIRECTION
        options.direction.x, options.direction.y, options.direction.z = _vector("direction", direction)
    if viewpoint is None:
        return None
    one, each = vector_or_vectors("viewpoint", viewpoint)
    if one is None:
        options.orientation = curvature_pb2.ORIENTATION_POINT_VIEWPOINTS
        return each
    options.orientation = curvature_pb2.ORIENTATION_VIEWPOINT
    options.viewpoint.x, options.viewpoint.y, options.viewpoint.z = one
    return None


def vector_or_vectors(
    name: str, value: npt.ArrayLike
) -> tuple[list[float] | None, npt.NDArray[typing.Any] | None]:
    """One vector for all points, of shape (3,), or one for each, which the cloud's arrays check; the other is None."""
    array = real_array(name, value)
    return (None, array) if array.ndim == 2 else (_vector(name, value), None)


def _vector(name: str, value: npt.ArrayLike) -> list[float]:
    vector = real_array(name, value).astype(np.float64)
    if vector.shape != (3,):
        raise ValueError(f"{name} has shape {vector.shape}; it must be (3,)")
    return [float(each) for each in vector]


def _set_method(
    options: curvature_pb2.NormalOptions,
    has_normals: bool,
    method: str | None,
    neighbor_count: int | None,
    radius: float | None,
) -> None:
    if has_normals and (method is not None or neighbor_count is not None or radius is not None):
        raise ValueError("normals are given: a method, neighbor_count or radius for them goes with normals=None")
    if neighbor_count is not None and radius is not None:
        raise ValueError("neighbor_count and radius of normals exclude each other")
    if method is not None:
        options.method = chosen("the method of normals", method, _METHODS)
    if radius is not None:
        options.radius = real_number("the radius of normals", radius)
    elif neighbor_count is not None:
        options.neighbor_count = count("the neighbor_count of normals", neighbor_count)
