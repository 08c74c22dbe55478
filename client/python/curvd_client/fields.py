"""Says which argument does not fit into its field of the contract, where protobuf would say "Value out of range"."""

from __future__ import annotations

import operator
import reprlib
import typing

import numpy as np

_Chosen = typing.TypeVar("_Chosen")

_MOST_32, _MOST_64 = 2**32 - 1, 2**64 - 1
_MOST_BITS_SHOWN = 128
_MOST_CHARACTERS_SHOWN = 200


class _ShortRepr(reprlib.Repr):
    def __init__(self) -> None:
        super().__init__()
        self.maxstring = self.maxother = _MOST_CHARACTERS_SHOWN
        self.maxlist = self.maxtuple = 20
        self.maxlevel = 3

    def repr_int(self, x: int, level: int) -> str:
        """Python itself refuses to write a number of thousands of digits."""
        return repr(x) if x.bit_length() <= _MOST_BITS_SHOWN else f"an int of {x.bit_length()} bits"


def shown(value: object) -> str:
    """The value as a message has it: its repr, with dots for most of what is long."""
    text = _ShortRepr().repr(value)
    return text if len(text) <= _MOST_CHARACTERS_SHOWN else text[: _MOST_CHARACTERS_SHOWN - 3] + "..."


def count(name: str, value: typing.Any) -> int:
    """The value of a field of type uint32 whose 0 stands for a default. Raises ValueError, naming the argument, for others.

    Who leaves the default to the server gives no number, so that a 0 that somebody has computed is not taken for it.
    """
    return _whole_number(name, value, 1, _MOST_32)


def count_or_default(name: str, value: typing.Any) -> int:
    """The same of an argument that may be None; the contract's default, 0, for that."""
    return 0 if value is None else count(name, value)


def seed_number(name: str, value: typing.Any) -> int:
    """The same for a field of type uint64, of which 0 is a number like others."""
    return _whole_number(name, value, 0, _MOST_64)


def real_number(name: str, value: typing.Any) -> float:
    """The same for a field of type double. Text, a truth value and an array are no numbers."""
    try:
        if not isinstance(value, (str, bytes, bool, np.bool_)) and getattr(value, "ndim", 0) == 0:
            return float(value)
    except (OverflowError, TypeError, ValueError):
        pass
    raise ValueError(f"{name} is {shown(value)}; it must be a number")


def positive_number_or_default(name: str, value: typing.Any) -> float:
    """The same of an argument above 0, or None for the contract's default, 0."""
    number = 0.0 if value is None else real_number(name, value)
    if value is not None and not number > 0.0:
        raise ValueError(f"{name} is {shown(value)}; it must be a number above 0")
    return number


def chosen(name: str, value: object, choices: typing.Mapping[str, _Chosen]) -> _Chosen:
    """What the choices have under the name that the value is. Raises ValueError, naming the argument, for others."""
    if not isinstance(value, str) or value not in choices:
        raise ValueError(f"{name} is {shown(value)}; it must be one of {', '.join(choices)}")
    return choices[value]


def listed(values: typing.Any) -> list[typing.Any] | None:
    """The elements of a list, of whatever kind. None for what has none, for text, and for what has no order, as a set."""
    if isinstance(values, (str, bytes, typing.AbstractSet, typing.Mapping)):
        return None
    try:
        return list(values)
    except TypeError:
        return None


def _whole_number(name: str, value: typing.Any, least: int, most: int) -> int:
    try:
        number = operator.index(value)
    except TypeError:
        number = -1
    if isinstance(value, bool) or not least <= number <= most:
        raise ValueError(f"{name} is {shown(value)}; it must be a whole number from {least} to {most}")
    return number
