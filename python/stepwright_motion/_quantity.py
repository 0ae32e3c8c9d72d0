"""Numbers with units, as the native half reads them."""

from __future__ import annotations

import operator
from typing import Any, Optional, Union

Quantity = Union[int, float, str]
"""A number in the unit of the axis, or a text with its unit: ``"25mm"``, ``"40mm/s"``."""


def text(value: Any, unit: Optional[str], usual: str) -> str:
    """A quantity as text: a bare number has the usual unit."""
    if isinstance(value, str):
        return value if unit is None else f"{value}{unit}"
    return f"{number(value)}{usual if unit is None else unit}"


def number(value: Any) -> str:
    """A number with all its digits; numpy's are numbers, too."""
    try:
        return str(operator.index(value))
    except TypeError:
        pass
    real = float(value)
    return str(int(real)) if real.is_integer() and abs(real) < 1e15 else repr(real)


def seconds(name: str, value: Any) -> float:
    """A time in s: no negative one, and no NaN."""
    time = float(value)
    if not 0 <= time < 1e9:
        raise ValueError(f"{name} is {value!r}: it may be 0 to 1e9 s")
    return time
