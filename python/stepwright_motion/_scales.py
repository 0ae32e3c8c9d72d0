"""The limits of the axes of a job or a path, in mm."""

from __future__ import annotations

import math
import re
from typing import Any, Mapping, Optional, TypeVar, Union

from ._native import Scale
from ._quantity import Quantity, real, text

Value = TypeVar("Value")
Paced = Union[Value, Mapping[str, Value]]
"""One value for all axes, or ``{"x": …, "y": …, "z": …}``."""

Pace = tuple[float, float, float, float, float]


def _of(value: Any, axis: str) -> Any:
    if not isinstance(value, Mapping):
        return value
    if axis not in value:
        raise ValueError(f"{dict(value)} says nothing of {axis}")
    return value[axis]


def scale_of(steps_per_rev: Optional[int], mm_per_rev: Optional[float]) -> Scale:
    """The scale of an axis: its steps and its millimetres per turn."""
    if steps_per_rev is not None and not 1 <= steps_per_rev <= 10_000_000:
        raise ValueError(f"steps_per_rev is {steps_per_rev!r}: it may be 1 to 10000000 steps")
    return Scale(steps_per_rev, mm_per_rev)


class MmScale:
    """A scale with a number of steps per millimetre, but without turns."""

    def __init__(self, steps_per_mm: Any):
        steps = real("steps_per_mm", steps_per_mm, "a number")
        if not 0.001 <= steps <= 10_000:
            raise ValueError(f"steps_per_mm is {steps_per_mm!r}: it may be 0.001 to 10000")
        self.steps = steps
        # A turn has whole steps. Its length has the fraction, to a nanometre, so the turn is as long as
        # possible: then no position within 10^9 steps is rounded to another position.
        turn = min(int(steps * 4294), 10_000_000)
        self._scale = Scale(turn, turn / steps)

    @property
    def unit(self) -> tuple[str, float]:
        """The unit of the axis, and its steps."""
        return ("mm", self.steps)

    def distance(self, name: str, text: str) -> int:
        """A distance in whole steps."""
        return self._scale.distance(name, _without_turns(name, text))

    def speed(self, name: str, text: str) -> float:
        """A speed without a sign, in steps/s."""
        return self._scale.speed(name, _without_turns(name, text))

    def accel(self, name: str, text: str) -> float:
        """An acceleration in steps/s²."""
        return self._scale.accel(name, _without_turns(name, text))

    def jerk(self, name: str, text: str) -> float:
        """A jerk in steps/s³."""
        return self._scale.jerk(name, _without_turns(name, text))


_TURNS = re.compile("turn|rev|rpm|deg|°|rad", re.IGNORECASE)


def _without_turns(name: str, text: str) -> str:
    if _TURNS.search(text):
        raise ValueError(f"{name} {text}: steps_per_mm says nothing of turns: give mm or steps")
    return text


def speed_of(name: str, value: Quantity, steps: float = 1000.0) -> float:
    """A speed in mm/s, above 0."""
    speed = MmScale(steps).speed(name, text(name, value, None, "mm/s")) / steps
    if speed == 0:
        raise ValueError(f"{name} is {value!r}: give 0.001 steps/s or more")
    return speed


def paces(
    steps_per_mm: Paced[float],
    speed: Paced[Quantity],
    accel: Paced[Quantity],
    jump: Paced[Quantity],
    jerk: Paced[Optional[Quantity]],
) -> list[Pace]:
    """A step, a speed, an acceleration, a jump in speed and a jerk for each axis."""
    axes = []
    for name in ("x", "y", "z"):
        scale = MmScale(_of(steps_per_mm, name))
        steps = scale.steps
        slope = scale.accel("accel", text("accel", _of(accel, name), None, "mm/s2")) / steps
        top, at_once = (
            speed_of(what, _of(value, name), steps) for what, value in (("speed", speed), ("jump", jump))
        )
        limit = _of(jerk, name)
        bend = math.inf if limit is None else scale.jerk("jerk", text("jerk", limit, None, "mm/s3")) / steps
        axes.append((1.0 / steps, top, slope, at_once, bend))
    return axes
