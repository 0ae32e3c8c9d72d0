"""Arrays: numpy arrays, or memory views of the same numbers without numpy."""

from __future__ import annotations

from typing import Any

try:
    import numpy
except ImportError:  # pragma: no cover
    numpy = None  # type: ignore[assignment]

_NUMPY = {"d": "float64", "I": "uint32", "Q": "uint64", "q": "int64", "B": "uint8"}


def array(data: bytearray, kind: str) -> Any:
    """These bytes as an array of a kind: ``d`` for doubles, … (the letters of the module ``array``)."""
    if numpy is None:
        # A kind that is only known at run time is not accepted by pyright.
        return memoryview(data).cast(kind)  # pyright: ignore
    return numpy.frombuffer(data, dtype=_NUMPY[kind])


def cumulated(values: Any) -> Any:
    """The cumulated sums, as whole numbers."""
    if numpy is None:
        from array import array as plain
        from itertools import accumulate

        return plain("Q", accumulate(values))
    return numpy.cumsum(values, dtype="uint64")


def scaled(values: Any, factor: float) -> Any:
    """These numbers times a factor, as doubles."""
    if numpy is None:
        from array import array as plain

        return plain("d", (value * factor for value in values))
    return numpy.asarray(values) * factor


def gradient(values: Any, over: Any) -> Any:
    """The slope at each value, by numpy."""
    if numpy is None:
        raise ImportError("this takes numpy: python3 -m pip install numpy")
    if len(values) < 2:
        return numpy.zeros(len(values))
    # If a position is redefined at the time of a step, the slope there is not defined.
    with numpy.errstate(divide="ignore", invalid="ignore"):
        return numpy.gradient(values, over)
