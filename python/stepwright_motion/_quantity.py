"""Numbers with units, in the form that the native half reads."""

from __future__ import annotations

import math
import operator
from decimal import Decimal
from typing import Any, Optional, Union

DECIMALS = 18
"""The most decimals that the native half reads."""

Quantity = Union[int, float, str]
"""A number in the unit of the axis, as text too, or a text with its unit: ``"25mm"``, ``"40mm/s"``."""


def text(name: str, value: Any, unit: Optional[str], usual: str) -> str:
    """A quantity as text. A bare number gets the usual unit, whether it is a number or a text."""
    if isinstance(value, str):
        if unit is None and is_bare(value):
            unit = usual
        return value if unit is None else f"{value.strip()}{unit}"
    return f"{number(name, value)}{usual if unit is None else unit}"


def is_bare(value: str) -> bool:
    """Whether a text is a number without a unit."""
    try:
        float(value.replace("\u2212", "-"))
    except ValueError:
        return False
    return True


def number(name: str, value: Any) -> str:
    """A number with all its digits. Accepts numbers of numpy too."""
    try:
        return str(operator.index(value))
    except TypeError:
        pass
    given = real(name, value, "a number, or a text with its unit")
    if not math.isfinite(given):
        raise ValueError(f"{name} is {value!r}: give a finite number")
    if given.is_integer() and abs(given) < 1e15:
        return str(int(given))
    # The command reads no more decimals. They are less than a step in any unit.
    digits = repr(given)
    fine = Decimal(digits).as_tuple().exponent
    return digits if int(fine) >= -DECIMALS else f"{given:.{DECIMALS}f}"


def seconds(name: str, value: Any) -> float:
    """A time in s, not negative and not NaN."""
    time = real(name, value, "a number of seconds")
    if not 0 <= time < 1e9:
        raise ValueError(f"{name} is {value!r}: it may be 0 to 1e9 s")
    return time


def real(name: str, value: Any, wanted: str) -> float:
    """A number. An error names the argument that is no number."""
    if not isinstance(value, (bytes, bytearray)):
        try:
            return float(value)
        except TypeError:
            pass
        except ValueError:
            raise ValueError(f"{name} is {value!r}: give {wanted}") from None
    raise TypeError(f"{name} is {value!r}: give {wanted}")
