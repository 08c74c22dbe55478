"""Collects the results of a call into one structured array and checks that none is missing."""

import enum

import numpy as np

# One element a point. Scalars in the caller's length unit as the contract has them; NaN where `status` is not OK and
# where a quantity was not asked for.
RESULT_DTYPE = np.dtype(
    [
        ("mean_curvature", np.float32),
        ("gaussian_curvature", np.float32),
        ("k1", np.float32),
        ("k2", np.float32),
        ("d1", np.float32, (3,)),
        ("d2", np.float32, (3,)),
        ("radius", np.float32),
        ("status", np.uint8),
    ]
)


class PointStatus(enum.IntEnum):
    """What became of a point; the values of `status` in the result."""

    OK = 1
    TOO_FEW_NEIGHBORS = 2
    DEGENERATE_AREA = 3
    INVALID_INPUT = 4
    INCONSISTENT_NORMALS = 5
    SINGULAR_FIT = 6


class ResultCollector:
    """Takes ResultChunks in order. Raises ValueError, saying what is wrong, if a server breaks the protocol."""

    def __init__(self, point_count):
        self.points = np.zeros(point_count, RESULT_DTYPE)
        for name in RESULT_DTYPE.names[:-1]:
            self.points[name] = np.nan
        self._received = 0

    def add(self, chunk):
        begin, end = chunk.first_index, chunk.first_index + chunk.point_count
        if begin != self._received or end == begin:
            raise ValueError(f"a result chunk of {chunk.point_count} points starts at {begin}, not {self._received}")
        if end > len(self.points):
            raise ValueError(f"results up to point {end} for a cloud of {len(self.points)} points")
        for name in RESULT_DTYPE.names:
            packed = getattr(chunk, name)
            if packed or name == "status":
                self._store(name, packed, begin, end)
        self._received = end

    def _store(self, name, packed, begin, end):
        field_type, _ = RESULT_DTYPE.fields[name]
        if len(packed) != (end - begin) * field_type.itemsize:
            raise ValueError(f"{name} of {end - begin} points has {len(packed)} bytes")
        self.points[name][begin:end] = np.frombuffer(packed, field_type.base.newbyteorder("<")).reshape(
            (end - begin, *field_type.shape)
        )

    def finish(self, summary):
        """Checks that every point has its result. `summary` is the stream's Summary, or None if none came."""
        if summary is None:
            raise ValueError("the stream ended without a summary")
        if summary.point_count != len(self.points) or self._received != len(self.points):
            raise ValueError(
                f"{self._received} results and a summary of {summary.point_count} points "
                f"for a cloud of {len(self.points)} points"
            )
