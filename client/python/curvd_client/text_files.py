"""Tables in text: what stands between the values, and what the columns are called."""

from __future__ import annotations

import array
import functools
import operator
import pathlib
import re
import typing

import numpy as np
import numpy.typing as npt

COORDINATES = ("x", "y", "z", "nx", "ny", "nz")
_OTHER_NAMES = {f"{start}{axis}": f"n{axis}" for start in ("n_", "normal_", "normal") for axis in "xyz"}
_COMMENTS = ("#", "//")


class _Layout(typing.NamedTuple):
    names: list[str] | None  # of the columns
    delimiter: str | None  # between values; None: blanks
    first: int  # lines before those of values
    width: int  # values in a line
    has_comments: bool  # where the names are the first line, # is a character as any other
    declared: int | None  # how many points a line before them says there are


def read_text(file: pathlib.Path) -> tuple[dict[str, npt.NDArray[typing.Any]] | None, npt.NDArray[typing.Any]]:
    """The columns among COORDINATES by their names, of shape (N,), or None; and all columns, (N, columns), if without names.

    Names are the first line, if it begins with a word; or the last comment before the values, if it has a name for each
    and begins with x y z, or has commas between them. Raises ValueError, naming the line, for what is
    no table, as text in UTF-16.
    """
    with _open(file) as lines:
        layout = _layout_of(lines)
    if layout.names is None:
        values = _all_values(file, layout)
        return None, _checked(values, layout)
    if not {"x", "y", "z"} <= set(layout.names):
        raise ValueError(f"it has {_shown(layout.names)}; there must be x and y and z")
    wanted = [name for name in COORDINATES if name in layout.names]
    values = _checked(_values(file, layout, [layout.names.index(name) for name in wanted]), layout)
    return dict(zip(wanted, values.T)), values


def _shown(names: list[str]) -> str:
    more = f" and {len(names) - 30} more" if len(names) > 30 else ""
    return ", ".join(name[:40] for name in names[:30]) + more


def _open(file: pathlib.Path) -> typing.TextIO:
    # Comments and names of other columns may be in any encoding.
    return open(file, encoding="utf-8-sig", errors="replace")


def _checked(values: npt.NDArray[typing.Any], layout: _Layout) -> npt.NDArray[typing.Any]:
    if layout.declared is not None and layout.declared != len(values):
        raise ValueError(f"its first line declares {layout.declared} points, and it holds {len(values)}")
    if len(values) == 0:
        raise ValueError("it holds no points")
    return values


def _layout_of(lines: typing.Iterable[str]) -> _Layout:
    comment, declared = "", None
    for number, line in enumerate(lines):
        if "\0" in line:
            raise ValueError(f"line {number + 1} has bytes of 0, as text in UTF-16 has: save it as UTF-8, if it is text")
        text = line.strip()
        if text.startswith(_COMMENTS):
            comment = text.removeprefix("#").removeprefix("//")
        elif text:
            unquoted = re.sub('"[^"]*"', "", text)
            delimiter = next((each for each in ",;" if each in unquoted), None)
            cells = _cells(text, delimiter)
            if not _is_number(cells[0]):
                delimiter = delimiter or ("\t" if "\t" in text else None)
                names = _names(_cells(line.rstrip("\r\n") if delimiter else text, delimiter))
                _refuse_twins(names)
                return _Layout(names, delimiter, number + 1, len(names), False, declared)
            cells = _cells(_without_comment(text), delimiter)
            if len(cells) == 1 and cells[0].isdigit() and declared is None:
                declared = int(cells[0])
                continue
            named = _names_in(comment, delimiter, len(cells))
            return _Layout(named, delimiter, number, len(cells), True, declared)
    raise ValueError("it holds no points")


def _without_comment(text: str) -> str:
    return re.split("|".join(_COMMENTS), text, maxsplit=1)[0].strip()


def _cells(text: str, delimiter: str | None) -> list[str]:
    """Without the quotes around them, between which there may be delimiters, and quotes as two."""
    if delimiter is None or '"' not in text:
        return [cell.strip().removeprefix('"').removesuffix('"').strip() for cell in text.split(delimiter)]
    return [match[1].replace('""', '"').strip() if match[1] is not None else match[2].strip() for match in _cell_pattern(delimiter).finditer(text)]


@functools.lru_cache
def _cell_pattern(delimiter: str) -> re.Pattern[str]:
    end = re.escape(delimiter)
    blank = f"[^\\S{end}]*"
    return re.compile(f'(?:^|(?<={end}))(?:{blank}"((?:[^"]|"")*)"{blank}(?={end}|$)|([^{end}]*))')


def _names(words: typing.Iterable[str]) -> list[str]:
    lower = ((word, word.lower()) for word in words)
    return [_OTHER_NAMES.get(small, small) if small in COORDINATES or small in _OTHER_NAMES else word for word, small in lower]


def _names_in(comment: str, delimiter: str | None, count: int) -> list[str] | None:
    is_delimited = delimiter is not None and delimiter in comment
    names = _names(_cells(comment, delimiter) if is_delimited else re.split(r"[\s,;]+", comment.strip()))
    if len(names) != count or len(set(names)) != count:
        return None
    if not {"x", "y", "z"} <= set(names):
        return None
    if not is_delimited and names[:3] != ["x", "y", "z"]:  # prose, or a header by which other columns are x y z
        raise ValueError(
            f'the comment "{comment.strip()[:60]}" has a word for each column, x, y and z among them, but does not begin with '
            "x y z: write the names as the first line, without #, or leave it out if the first columns are x y z"
        )
    return names


def _refuse_twins(names: list[str]) -> None:
    twin = next((name for name in names if name and names.count(name) > 1), None)
    if twin is not None:
        raise ValueError(f"two columns have the name {twin}")


def _all_values(file: pathlib.Path, layout: _Layout) -> npt.NDArray[typing.Any]:
    try:
        return np.loadtxt(
            file, delimiter=layout.delimiter, skiprows=layout.first, ndmin=2, encoding="utf-8-sig"
        )
    except ValueError:  # of which this says what is wrong in which line; it knows other comments, too
        return _values(file, layout, list(range(layout.width)))


def _values(file: pathlib.Path, layout: _Layout, wanted: list[int]) -> npt.NDArray[typing.Any]:
    """The values in some columns of each line. Every line has as many: else columns would get the values of others."""
    if len(wanted) < 2:
        wanted = [*wanted, *([0] * (2 - len(wanted)))]
    pick, values = operator.itemgetter(*wanted), array.array("d")
    with _open(file) as lines:
        for number, line in enumerate(lines):
            text = line.rstrip("\r\n") if layout.delimiter == "\t" else line.strip()
            if layout.has_comments and ("#" in text or "//" in text):
                text = _without_comment(text)
            if number < layout.first or not text.strip():
                continue
            cells = _cells(text, layout.delimiter) if '"' in text else text.split(layout.delimiter)
            if len(cells) != layout.width:
                raise ValueError(f"line {number + 1} has {len(cells)} values, and there are {layout.width} columns")
            parse: typing.Callable[[str], float] = _number
            if text.isascii() and "_" not in text:
                parse = float
            try:
                values.extend(map(parse, pick(cells)))
            except ValueError:
                wrong = next(cell for cell in pick(cells) if not _is_number(cell))
                raise ValueError(f'line {number + 1}: "{wrong.strip()[:40]}" is no number') from None
    return np.frombuffer(values, dtype=np.float64).reshape(-1, len(wanted))


def _number(text: str) -> float:
    """Python's float, but for numbers that no other program writes: 1_000, and digits of other alphabets."""
    if "_" in text or not text.isascii():
        raise ValueError(text)
    return float(text)


def _is_number(text: str) -> bool:
    try:
        _number(text)
    except ValueError:
        return False
    return True
