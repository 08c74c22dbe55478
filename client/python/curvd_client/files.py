"""Clouds in files of numpy and of text."""

from __future__ import annotations

import pathlib
import typing

import numpy as np
import numpy.typing as npt

_Array = npt.NDArray[typing.Any]
_POSITIONS = ("positions", "points", "xyz")
_AXES = ("x", "y", "z")
_NORMALS = ("nx", "ny", "nz")
_TEXT = (".xyz", ".txt", ".csv", ".pts", ".asc")


def read_cloud(file: pathlib.Path) -> tuple[_Array, _Array | None]:
    """Positions of shape (N, 3), and normals of the same or None.

    .npy:             an array of 3 or 6 columns, the latter positions and normals; or, as `curv` writes it, a structured
                      array with the fields x y z and, if there, nx ny nz.
    .npz:             `positions` (or `points`, `xyz`) and, if there, `normals`; or x y z and nx ny nz, as `curv` writes them.
    .xyz .txt .csv .pts .asc: a line a point with blanks or commas between its numbers; # begins a comment. The first
                      line, or the last comment before the points, may name the columns: x y z and, if there, nx ny nz
                      among others, as `curv` writes them. Without names there must be 3 or 6 numbers a line.

    Raises ValueError, saying what is wrong, for files that hold no cloud, and OSError for those that cannot be read.
    """
    kind = file.suffix.lower()
    if kind == ".npz":
        return _from_archive(file)
    if kind == ".npy":
        array = np.load(file, allow_pickle=False)
        return _from_columns(file, array, array.dtype.names) if array.dtype.names else _split(file, array)
    if kind in _TEXT:
        return _from_text(file)
    raise ValueError(f"{file} is of no kind that is read here: .npy, .npz or text ({', '.join(_TEXT)})")


def write_points(file: pathlib.Path, positions: _Array, points: _Array) -> None:
    """Writes positions and every column of points into one .npz, which is complete or not there."""
    partial = file.with_name(file.name + ".partial")
    try:
        with open(partial, "wb") as stream:
            np.savez(stream, positions=positions, **{name: points[name] for name in points.dtype.names or ()})
        partial.replace(file)
    finally:
        partial.unlink(missing_ok=True)


def _from_archive(file: pathlib.Path) -> tuple[_Array, _Array | None]:
    with np.load(file, allow_pickle=False) as archive:
        if not isinstance(archive, np.lib.npyio.NpzFile):
            raise ValueError(f"{file} is no archive of arrays")
        name = next((each for each in _POSITIONS if each in archive), None)
        if name is None:
            return _from_columns(file, archive, archive.files)
        return archive[name], archive["normals"] if "normals" in archive else None


def _from_columns(
    file: pathlib.Path, columns: typing.Any, names: typing.Sequence[str]
) -> tuple[_Array, _Array | None]:
    if not {"x", "y", "z"} <= set(names):
        raise ValueError(f"{file} has {', '.join(names)}; there must be {' or '.join(_POSITIONS)}, or x and y and z")
    shapes = {name: columns[name].shape for name in (*_AXES, *_NORMALS) if name in names}
    if len(set(shapes.values())) != 1 or len(shapes["x"]) != 1:
        raise ValueError(f"{file} has columns of shapes {shapes}; all must be (N,)")
    positions = np.stack([columns[name] for name in _AXES], axis=1)
    has_normals = set(_NORMALS) <= set(names)
    return positions, np.stack([columns[name] for name in _NORMALS], axis=1) if has_normals else None


def _from_text(file: pathlib.Path) -> tuple[_Array, _Array | None]:
    with open(file, encoding="utf-8-sig") as lines:
        names, first, delimiter = _layout(lines)
    if names is None:
        return _split(file, np.loadtxt(file, delimiter=delimiter, ndmin=2, encoding="utf-8-sig"))
    wanted = [name for name in (*_AXES, *_NORMALS) if name in names]
    with open(file, encoding="utf-8-sig") as lines:
        rows = list(_rows(lines, first, delimiter, len(names)))
    values = np.empty((0, len(wanted)))
    if rows:
        values = np.loadtxt(rows, delimiter=delimiter, usecols=[names.index(name) for name in wanted], ndmin=2)
    return _from_columns(file, dict(zip(wanted, values.T)), names)


def _layout(lines: typing.Iterable[str]) -> tuple[list[str] | None, int, str | None]:
    """Names of the columns or None, the number of the first line of values from 0 on, and what is between values.

    Names are the first line, if it begins with a word, or the last comment before the values, if it has a word for each.
    """
    comment: list[str] = []
    for number, line in enumerate(lines):
        text = line.strip()
        if text.startswith("#"):
            comment = text.lstrip("#").split()
        elif text:
            delimiter = "," if "," in text.partition("#")[0] else None
            cells = [cell.strip().strip('"').strip() for cell in text.split(delimiter)]
            if not _is_number(cells[0]):
                return _names(cells), number + 1, delimiter
            return (_names(comment) if len(comment) == len(cells) else None), number, delimiter
    raise ValueError("it holds no points, nor the names of columns")


def _names(words: typing.Sequence[str]) -> list[str]:
    names = [word.lower() if word.lower() in (*_AXES, *_NORMALS) else word for word in words]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise ValueError(f"two columns have the name {twice}")
    return names


def _rows(lines: typing.Iterable[str], first: int, delimiter: str | None, count: int) -> typing.Iterator[str]:
    """The lines of values, which must have `count` each: one that had more would give columns the values of others."""
    for number, line in enumerate(lines):
        text = line.partition("#")[0].replace('"', "").strip()
        if number < first or not text:
            continue
        cells = text.count(delimiter) + 1 if delimiter else len(text.split())
        if cells != count:
            raise ValueError(f"line {number + 1} has {cells} values, and {count} columns have names")
        yield text


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _split(file: pathlib.Path, columns: _Array) -> tuple[_Array, _Array | None]:
    if columns.ndim != 2 or columns.shape[1] not in (3, 6):
        raise ValueError(f"{file} has shape {columns.shape}; it must be (N, 3), or (N, 6) with normals")
    return columns[:, :3], columns[:, 3:] if columns.shape[1] == 6 else None
