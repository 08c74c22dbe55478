"""Collects the results of a call into one structured array and checks that none is missing."""

from __future__ import annotations

import enum
import typing

import numpy as np
import numpy.typing as npt

from curvd_client import curvature_pb2
from curvd_client.contract import result_columns
from curvd_client.fields import shown

Points = npt.NDArray[typing.Any]

_SCALARS: dict[int, type] = {curvature_pb2.COLUMN_TYPE_UINT8: np.uint8}  # by the column's type; all others are float32
_PREFIX = "QUANTITY_"

# Names of the quantities that a call may ask for: "mean_curvature", "gaussian_curvature", "principal_curvatures", ...
QUANTITIES = tuple(
    name.removeprefix(_PREFIX).lower() for name, number in curvature_pb2.Quantity.items() if number != 0
)


def _quantity_name(number: int) -> str:
    return str(curvature_pb2.Quantity.Name(number)).removeprefix(_PREFIX).lower()


# Those of curvature that come without being asked for.
DEFAULT_QUANTITIES = tuple(
    dict.fromkeys(
        _quantity_name(column.quantity)
        for _, column in result_columns()
        if column.quantity != curvature_pb2.QUANTITY_UNSPECIFIED and not column.on_request
    )
)


def quantity_number(name: str) -> int:
    """The contract's number of a quantity. Raises ValueError if there is none of that name."""
    if not isinstance(name, str) or name not in QUANTITIES:
        owner = next((column.quantity for column_name, column in result_columns() if column_name == name and column.quantity), None)
        if owner is not None:
            raise ValueError(f"quantity {shown(name)} is unknown; the column comes with {_quantity_name(owner)!r}")
        raise ValueError(f"quantity {shown(name)} is unknown; it must be one of {', '.join(QUANTITIES)}")
    return int(curvature_pb2.Quantity.Value(_PREFIX + name.upper()))


# Those of the point itself, which are the same for each of several neighbor counts.
_OF_NORMALS = (curvature_pb2.QUANTITY_NORMALS, curvature_pb2.QUANTITY_NORMAL_QUALITY)


def result_dtype(
    quantities: typing.Collection[int] | None = None,
    made_normals: bool = False,
    neighbor_counts: typing.Sequence[int] = (),
) -> np.dtype[typing.Any]:
    """The type of a result: the columns of those quantities (numbers), as the contract has them, and status.

    No quantities: all of curvature that comes without being asked for, and normals if the server makes or orients them.
    With neighbor_counts, there is a column for each of them: mean_curvature_k16, ..., status_k16, mean_curvature_k32, ...
    """
    columns = _columns(quantities, made_normals)
    if not neighbor_counts:
        return np.dtype([field for field, _ in columns])
    fields = [field for field, is_shared in columns if is_shared]
    for count in neighbor_counts:
        fields += [(column_name(name, count), *rest) for (name, *rest), is_shared in columns if not is_shared]
    return np.dtype(fields)


def column_name(name: str, neighbor_count: int) -> str:
    """What a column of the contract is called in a result with several neighbor counts."""
    return f"{name}_k{neighbor_count}"


def _columns(quantities: typing.Collection[int] | None, made_normals: bool) -> list[tuple[typing.Any, bool]]:
    """The fields of a result with one neighbor count, status last, and whether they are the same for each count."""
    made = {curvature_pb2.QUANTITY_NORMALS} if made_normals else set()
    fields: list[tuple[typing.Any, bool]] = []
    status: list[tuple[typing.Any, bool]] = []
    for name, column in result_columns():
        scalar, shape = _SCALARS.get(column.type, np.float32), (column.width,) if column.width > 1 else ()
        if column.quantity == curvature_pb2.QUANTITY_UNSPECIFIED:
            status.append(((name, scalar, shape), False))
        elif column.quantity in quantities if quantities else not column.on_request or column.quantity in made:
            fields.append(((name, scalar, shape), column.quantity in _OF_NORMALS))
    return fields + status


# One element a point, with all quantities of curvature. Scalars in the caller's length unit as the contract has them;
# NaN where `status` is not OK.
RESULT_DTYPE = result_dtype()


class PointStatus(enum.IntEnum):
    """What became of a point; the values of `status` in the result."""

    OK = 1
    TOO_FEW_NEIGHBORS = 2
    DEGENERATE_AREA = 3
    INVALID_INPUT = 4
    INCONSISTENT_NORMALS = 5
    SINGULAR_FIT = 6
    OPPOSED_NORMALS = 7
    OUTLIER = 8


class Estimate(typing.NamedTuple):
    """points: structured array, one element a point: the fields of RESULT_DTYPE that were asked for, and those of
    normals; with neighbor_counts, those of curvature for each count, as mean_curvature_k16.
    summary: the stream's Summary message."""

    points: Points
    summary: curvature_pb2.Summary

    def to_dataframe(self) -> typing.Any:
        """The points as a pandas.DataFrame, one row a point; vectors as three columns, d1_x, d1_y, d1_z for d1.

        `status` is a categorical of the names in PointStatus. Raises ImportError if pandas is not installed.
        """
        try:
            import pandas
        except ImportError as error:
            raise ImportError("to_dataframe needs pandas, which is not installed; .points is a numpy array") from error
        columns: dict[str, typing.Any] = {}
        for name in self.points.dtype.names or ():
            values = self.points[name]
            if name == "status" or name.startswith("status_k"):
                names = {int(status): status.name for status in PointStatus}
                columns[name] = pandas.Categorical([names.get(int(value), str(value)) for value in values])
            elif values.ndim == 2:
                columns.update({f"{name}_{axis}": values[:, i] for i, axis in enumerate("xyz")})
            else:
                columns[name] = values
        return pandas.DataFrame(columns)


class ResultCollector:
    """Takes ResultChunks in order. Raises ValueError, saying what is wrong, if a server breaks the protocol."""

    def __init__(
        self,
        point_count: int,
        quantities: typing.Collection[int] | None = None,
        made_normals: bool = False,
        neighbor_counts: typing.Sequence[int] = (),
    ) -> None:
        self._asked = bool(quantities)
        self.points: Points = np.zeros(point_count, result_dtype(quantities, made_normals, neighbor_counts))
        for name in self.points.dtype.names or ():
            if self.points.dtype[name].base.kind == "f":
                self.points[name] = np.nan
        self._received = 0
        # The scales, from the one whose results come now on; 0: there is but one, which has no number.
        self._counts = list(neighbor_counts) or [0]
        # Of the contract, and of the result at the first of these scales.
        self._names = {name: is_shared for (name, *_), is_shared in _columns(quantities, made_normals)}

    def _field(self, name: str) -> str:
        return name if self._counts[0] == 0 or self._names[name] else column_name(name, self._counts[0])

    def add(self, chunk: curvature_pb2.ResultChunk) -> None:
        if self._received == len(self.points) and len(self._counts) > 1:
            del self._counts[0]
            self._received = 0
        if chunk.neighbor_count != self._counts[0]:
            raise ValueError(f"results of {chunk.neighbor_count} neighbors came, not of {self._counts[0]}")
        begin, end = chunk.first_index, chunk.first_index + chunk.point_count
        if begin != self._received or end == begin:
            raise ValueError(f"a result chunk of {chunk.point_count} points starts at {begin}, not {self._received}")
        if end > len(self.points):
            raise ValueError(f"results up to point {end} for a cloud of {len(self.points)} points")
        for name in self._names:
            packed = getattr(chunk, name)
            # Where all quantities are wanted, an older server may not know one of them.
            if packed or self._asked or name == "status":
                self._store(name, packed, begin, end)
        self._received = end

    def _store(self, name: str, packed: bytes, begin: int, end: int) -> None:
        field = self._field(name)
        field_type = self.points.dtype[field]
        if len(packed) != (end - begin) * field_type.itemsize:
            raise ValueError(f"{name} of {end - begin} points has {len(packed)} bytes")
        self.points[field][begin:end] = np.frombuffer(packed, field_type.base.newbyteorder("<")).reshape(
            (end - begin, *field_type.shape)
        )

    def finish(self, summary: curvature_pb2.Summary | None) -> curvature_pb2.Summary:
        """Checks that every point has its result, and returns the summary. `summary` is the stream's Summary, or None
        if none came."""
        if summary is None:
            raise ValueError("the stream ended without a summary")
        if len(self._counts) > 1 and len(self.points) > 0:
            raise ValueError(f"no results of {self._counts[1]} neighbors came")
        if summary.point_count != len(self.points) or self._received != len(self.points):
            raise ValueError(
                f"{self._received} results and a summary of {summary.point_count} points "
                f"for a cloud of {len(self.points)} points"
            )
        return summary
