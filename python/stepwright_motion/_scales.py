"""What the axes of a job or a path can do, in mm."""

from __future__ import annotations

from typing import Any, Mapping, Optional, TypeVar, Union

from ._native import Scale
from ._quantity import Quantity, text

Value = TypeVar("Value")
Paced = Union[Value, Mapping[str, Value]]
"""One value for all axes, or ``{"x": …, "y": …, "z": …}``."""

Pace = tuple[float, float, float, float]


def _of(value: Any, axis: str) -> Any:
    if not isinstance(value, Mapping):
        return value
    if axis not in value:
        raise ValueError(f"{dict(value)} says nothing of {axis}")
    return value[axis]


def scale_of(steps_per_rev: Optional[int], mm_per_rev: Optional[float]) -> Scale:
    """How the steps of an axis relate to the world."""
    if steps_per_rev is not None and not 1 <= steps_per_rev <= 10_000_000:
        raise ValueError(f"steps_per_rev is {steps_per_rev!r}: it may be 1 to 10000000 steps")
    return Scale(steps_per_rev, mm_per_rev)


def scale_of_mm(steps: float) -> Scale:
    """Of this many steps a millimetre. A turn has whole steps, and is about a metre: its length, to a
    nanometre, has the fraction."""
    turn = round(steps * 1000)
    return Scale(turn, turn / steps)


def speed_of(name: str, value: Quantity, steps: float = 1000.0) -> float:
    """A speed in mm/s."""
    return scale_of_mm(steps).speed(name, text(name, value, None, "mm/s")) / steps


def paces(
    steps_per_mm: Paced[float],
    speed: Paced[Quantity],
    accel: Paced[Quantity],
    jump: Paced[Quantity],
) -> list[Pace]:
    """Of each axis a step, a speed, an acceleration and a jump in speed."""
    axes = []
    for name in ("x", "y", "z"):
        steps = float(_of(steps_per_mm, name))
        if not 0.001 <= steps <= 10_000:
            raise ValueError(f"steps_per_mm is {steps}: it may be 0.001 to 10000")
        scale = scale_of_mm(steps)
        slope = scale.accel("accel", text("accel", _of(accel, name), None, "mm/s2")) / steps
        top, at_once = (
            speed_of(what, _of(value, name), steps) for what, value in (("speed", speed), ("jump", jump))
        )
        axes.append((1.0 / steps, top, slope, at_once))
    return axes
