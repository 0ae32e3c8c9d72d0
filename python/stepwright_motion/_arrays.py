"""Arrays: numpy's where it is there, memory views of the same numbers where it is not."""

from __future__ import annotations

from typing import Any

try:
    import numpy
except ImportError:  # pragma: no cover
    numpy = None  # type: ignore[assignment]

_NUMPY = {"d": "float64", "I": "uint32", "Q": "uint64", "q": "int64", "B": "uint8"}


def array(data: bytearray, kind: str) -> Any:
    """These bytes as an array of doubles (``d``), … (the letters of the module ``array``)."""
    if numpy is None:
        return memoryview(data).cast(kind)
    return numpy.frombuffer(data, dtype=_NUMPY[kind])
