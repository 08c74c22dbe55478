"""Clouds in files of numpy and of text."""

from __future__ import annotations

import pathlib
import typing
import warnings

import numpy as np
import numpy.typing as npt

from curvd_client.text_files import read_text

_Array = npt.NDArray[typing.Any]
_POSITIONS = ("positions", "points", "xyz")
_AXES = ("x", "y", "z")
_NORMALS = ("nx", "ny", "nz")
_TEXT = (".xyz", ".txt", ".csv", ".pts", ".asc")
_LENGTH_SLACK = 0.1  # by which a normal that was written with few digits may be off 1


def read_cloud(file: pathlib.Path) -> tuple[_Array, _Array | None]:
    """Positions of shape (N, 3), and normals of the same or None.

    .npy:             an array of 3 or 6 columns; or, as `curv` writes it, a structured
                      array with the fields x y z and, if there, nx ny nz.
    .npz:             `positions` (or `points`, `xyz`) and, if there, `normals`; or x y z and nx ny nz, as `curv` writes them.
    .xyz .txt .csv .pts .asc: a line a point, as curvd_client.text_files reads them; without names, columns 1 to 3 are
                      x y z.

    Columns 4 to 6 without names, of an array or of text, are normals if they hold unit vectors, as for `curv`; what is
    neither normals nor colors of 8 bits is warned of. Raises ValueError, saying what is wrong, for files that hold no cloud, and OSError for those that cannot be read.
    """
    if file.is_dir():
        raise ValueError("it is a directory; name the file of a cloud")
    kind = file.suffix.lower()
    if kind not in (".npy", ".npz", *_TEXT):
        raise ValueError(f"it is of no kind that is read here: .npy, .npz or text ({', '.join(_TEXT)})")
    if file.exists() and not file.is_file():
        raise ValueError("it is no regular file")
    if file.exists() and file.stat().st_size == 0:
        raise ValueError("the file is empty: it holds no points")
    positions, normals = _from_text(file) if kind in _TEXT else _from_numpy(file)
    for name, values in (("positions", positions), ("normals", normals)):
        if values is None:
            continue
        if values.dtype.kind not in "fiu" or values.ndim != 2 or values.shape != (len(positions), 3):
            raise ValueError(f"its {name} are {values.dtype} of shape {values.shape}; they must be numbers of shape (N, 3)")
    if len(positions) == 0:
        raise ValueError("it holds no points")
    return positions, normals


def write_points(file: pathlib.Path, positions: _Array, points: _Array) -> None:
    """Writes positions and every column of points into one .npz, which is complete or not there."""
    partial = file.with_name(file.name + ".partial")
    try:
        with open(partial, "wb") as stream:
            np.savez(stream, positions=positions, **{name: points[name] for name in points.dtype.names or ()})
        partial.replace(file)
    finally:
        partial.unlink(missing_ok=True)


def _from_text(file: pathlib.Path) -> tuple[_Array, _Array | None]:
    columns, values = read_text(file)
    if columns is not None:
        return _from_columns(columns, columns)
    if values.shape[1] < 3:
        raise ValueError(f"its shape is {values.shape}; it must be (N, 3), or (N, 6) with normals")
    return _by_places(file, values, 'put the line "# x y z nx ny nz" before the points, with a name for each further column')


def _from_numpy(file: pathlib.Path) -> tuple[_Array, _Array | None]:
    try:
        loaded = np.load(file, allow_pickle=False)
        if isinstance(loaded, np.lib.npyio.NpzFile):
            with loaded:
                return _from_archive(loaded)
    except (OSError, ValueError):
        raise
    except Exception as error:  # of zipfile, zlib and ast, by what is damaged
        raise ValueError(f"numpy cannot read it ({type(error).__name__}: {str(error)[:200]})") from error
    return _from_columns(loaded, loaded.dtype.names) if loaded.dtype.names else _split(file, loaded)


def _from_archive(archive: typing.Any) -> tuple[_Array, _Array | None]:
    name = next((each for each in _POSITIONS if each in archive), None)
    if name is None:
        return _from_columns(archive, archive.files)
    return archive[name], archive["normals"] if "normals" in archive else None


def _from_columns(columns: typing.Any, names: typing.Collection[str]) -> tuple[_Array, _Array | None]:
    if not {"x", "y", "z"} <= set(names):
        raise ValueError(f"it has {', '.join(names) or 'no array'}; there must be {' or '.join(_POSITIONS)}, or x and y and z")
    shapes = {name: columns[name].shape for name in (*_AXES, *_NORMALS) if name in names}
    if len(set(shapes.values())) != 1 or len(shapes["x"]) != 1:
        raise ValueError(f"its columns have the shapes {shapes}; all must be (N,)")
    positions = np.stack([columns[name] for name in _AXES], axis=1)
    has_normals = set(_NORMALS) <= set(names)
    return positions, np.stack([columns[name] for name in _NORMALS], axis=1) if has_normals else None


def _by_places(file: pathlib.Path, columns: _Array, remedy: str) -> tuple[_Array, _Array | None]:
    positions, vectors = columns[:, :3], columns[:, 3:6]
    if vectors.shape[1] < 3 or (columns.shape[1] == 6 and _hold_colors(vectors)):
        return positions, None
    lengths = np.linalg.norm(vectors.astype(np.float64), axis=1)
    has_length = lengths > 0  # of 0 and NaN the server tells more
    wrong = has_length & (np.abs(lengths - 1) > _LENGTH_SLACK)
    if not np.any(wrong) and (np.any(has_length) or columns.shape[1] == 6):
        return positions, vectors
    point = int(np.argmax(wrong))
    why = f"the vector of point {point} has the length {lengths[point]:g}" if np.any(wrong) else "no point has a vector there"
    warnings.warn(f"{file}: columns 4 to 6 are no normals: {why}. If they are, {remedy}", stacklevel=2)
    return positions, None


def _hold_colors(vectors: _Array) -> bool:
    are_bytes = bool(np.all((vectors >= 0) & (vectors <= 255) & (vectors == np.floor(vectors))))
    return are_bytes and bool(np.any(vectors > 1))


def _split(file: pathlib.Path, columns: _Array) -> tuple[_Array, _Array | None]:
    if columns.ndim != 2 or columns.shape[1] not in (3, 6):
        raise ValueError(f"its shape is {columns.shape}; it must be (N, 3), or (N, 6) with normals")
    if columns.dtype.kind not in "fiu":
        return columns[:, :3], None
    return _by_places(file, columns, "save them as the array normals of an .npz")
