"""Makes the arrays of a cloud what the contract sends, and says what is wrong with those that make none."""

from __future__ import annotations

import typing
import warnings

import numpy as np
import numpy.typing as npt

# float32 holds each value of these exactly; all other numbers are sent as float64.
_EXACT_IN_FLOAT32 = {"f2", "f4", "i1", "i2", "u1", "u2"}

Cloud = typing.Dict[str, npt.NDArray[typing.Any]]


def pack_cloud(
    positions: npt.ArrayLike, normals: npt.ArrayLike | None, vectors: typing.Mapping[str, npt.ArrayLike] | None = None
) -> Cloud:
    """The arrays of PointChunk that there are, by their names: little-endian, contiguous, all float32 or all float64.

    Positions decide which: float64 unless float32 holds each of their values. `vectors` are those of the points beside
    their normals. Raises ValueError, naming the array, for shapes other than (N, 3), and for what is no real number.
    """
    given = {"positions": positions, "normals": normals, **(vectors or {})}
    arrays = {name: real_array(name, array) for name, array in given.items() if array is not None}
    if not arrays or "positions" not in arrays:
        raise ValueError("positions is None; it must be an array of shape (N, 3)")
    for name, array in arrays.items():
        if array.ndim != 2 or array.shape[1] != 3:
            raise ValueError(f"{name} has shape {array.shape}; it must be (N, 3){_remedy(array)}")
        if len(array) != len(arrays["positions"]):
            raise ValueError(f"{len(arrays['positions'])} positions but {len(array)} {name}")
    kind = arrays["positions"].dtype
    scalar = "<f4" if f"{kind.kind}{kind.itemsize}" in _EXACT_IN_FLOAT32 else "<f8"
    return {name: _converted(name, array, scalar) for name, array in arrays.items()}


def real_array(name: str, values: npt.ArrayLike) -> npt.NDArray[typing.Any]:
    """The values as an array of real numbers. Raises ValueError, naming the argument, if they are none."""
    if isinstance(values, np.ma.MaskedArray) and np.any(values.mask):
        raise ValueError(f"{name} has masked elements; fill them, or leave those points out")
    try:
        with warnings.catch_warnings():
            # numpy before 1.24 warns of ragged lists, and makes objects of them.
            warnings.simplefilter("error")
            array = np.asarray(values)
    except (ValueError, TypeError, RuntimeError, Warning) as error:  # what a tensor's __array__ raises as well
        raise ValueError(f"{name} cannot be made an array of shape (N, 3): {error}") from None
    if array.dtype.kind not in "fiu":
        if array.ndim == 0:  # a generator, a path, a dict: all in one
            raise ValueError(f"{name} has the type {type(values).__name__}; it must be an array of numbers, or a list of such")
        # pandas makes objects of its nullable dtypes, such as Float64.
        is_of_pandas = array.dtype.kind == "O" and hasattr(values, "to_numpy")
        remedy = ", as .to_numpy(dtype=float, na_value=numpy.nan) makes of them" if is_of_pandas else ""
        raise ValueError(f"{name} has dtype {array.dtype}; it must be real numbers: floats or integers{remedy}")
    return array


def _remedy(array: npt.NDArray[typing.Any]) -> str:
    if array.ndim == 2 and array.shape[0] == 3:
        return f"; its transpose .T has shape {array.shape[::-1]}"
    if array.ndim == 1 and array.size % 3 == 0 and array.size:
        return f"; .reshape(-1, 3) would be {(array.size // 3, 3)}"
    return ""


def _converted(name: str, array: npt.NDArray[typing.Any], scalar: str) -> npt.NDArray[typing.Any]:
    with np.errstate(over="ignore", under="ignore"):
        converted = np.ascontiguousarray(array, scalar)
    if converted.itemsize < array.dtype.itemsize and np.any(np.isinf(converted) & np.isfinite(array)):
        raise ValueError(f"{name} has values beyond what {converted.dtype} holds; positions as float64 would keep them")
    return converted
