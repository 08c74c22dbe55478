"""Says which argument does not fit into its field of the contract, where protobuf would say "Value out of range"."""

from __future__ import annotations

import operator
import typing

_MOST_32, _MOST_64 = 2**32 - 1, 2**64 - 1


def whole_number(name: str, value: typing.Any, most: int = _MOST_32) -> int:
    """The value of a field of type uint32. Raises ValueError, naming the argument, if it is no such number."""
    try:
        number = operator.index(value)
    except TypeError:
        number = -1
    if isinstance(value, bool) or not 0 <= number <= most:
        raise ValueError(f"{name} is {value!r}; it must be a whole number from 0 to {most}")
    return number


def seed_number(name: str, value: typing.Any) -> int:
    """The same for a field of type uint64."""
    return whole_number(name, value, _MOST_64)


def real_number(name: str, value: typing.Any) -> float:
    """The same for a field of type double. Text is no number."""
    try:
        if not isinstance(value, (str, bytes)):
            return float(value)
    except (OverflowError, TypeError, ValueError):
        pass
    raise ValueError(f"{name} is {value!r}; it must be a number")
