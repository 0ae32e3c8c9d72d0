"""Planned travels: every step of a ramp law, before anything moves."""

from __future__ import annotations

import json
import os
from functools import cached_property
from typing import Any, Optional, Sequence, Union

from ._arrays import array, cumulated, gradient, scaled
from ._native import PHASES, Planned
from ._quantity import Quantity, text
from ._scales import scale_of


class Plan:
    """A travel by a law, with arrays of values for each of its pulses.

    The first pulse is at time 0, and its delay is 0. Each array is computed at its first use.
    """

    def __init__(self, law: str, planned: Planned, unit: tuple[str, float]):
        self.law = law
        """The name of the law."""
        self.unit, self._per_unit = unit
        self._planned = planned
        self.pulses, self.timer_hz, self._peak, self.braking = planned.facts()

    @property
    def peak(self) -> float:
        """The highest speed in units/s."""
        return self._peak / self._per_unit

    @cached_property
    def _survey(self) -> tuple[float, float]:
        return self._planned.survey()

    @property
    def duration(self) -> float:
        """Seconds from the first pulse to the last."""
        return self._survey[0]

    @property
    def worst_error(self) -> float:
        """The largest deviation of a pulse from the law, in ticks of the timer."""
        return self._survey[1]

    @cached_property
    def delays(self) -> Any:
        """The ticks of the chip's timer before each pulse."""
        return array(self._planned.delays(), "I")

    @cached_property
    def ticks(self) -> Any:
        """Ticks from the first pulse to each."""
        return cumulated(self.delays)

    @cached_property
    def times(self) -> Any:
        """Seconds from the first pulse to each."""
        return scaled(self.ticks, 1.0 / self.timer_hz)

    @cached_property
    def positions(self) -> Any:
        """The position of the axis after each pulse, in its unit."""
        return scaled(range(1, self.pulses + 1), 1.0 / self._per_unit)

    @cached_property
    def speeds(self) -> Any:
        """The speed by the delay before each pulse, in units/s; the start speed for the first pulse."""
        return scaled(array(self._planned.speeds(), "d"), 1.0 / self._per_unit)

    @cached_property
    def phases(self) -> Any:
        """The phase of each pulse, as an index of ``PHASES``."""
        return array(self._planned.phases(), "B")

    @cached_property
    def ideal_times(self) -> Any:
        """The time of each pulse by the law in s, not rounded to whole ticks."""
        return array(self._planned.ideal(), "d")

    @cached_property
    def accelerations(self) -> Any:
        """The acceleration at each pulse by the law, in units/s². Needs numpy."""
        return gradient(self._ideal_speeds, self.ideal_times)

    @cached_property
    def jerks(self) -> Any:
        """The jerk at each pulse by the law, in units/s³. Needs numpy."""
        return gradient(self.accelerations, self.ideal_times)

    @cached_property
    def _ideal_speeds(self) -> Any:
        return gradient(self.positions, self.ideal_times)

    def plot(self, path: Optional[Union[str, os.PathLike[str]]] = None) -> Any:
        """Draws speed and acceleration with matplotlib, and returns its figure.

        With a path (``.svg``, ``.png``, ``.html``) it draws a file as the command does, without
        matplotlib.
        """
        if path is not None:
            self._planned.save(os.fspath(path))
            return None
        from ._plot import draw

        return draw(self)

    def _repr_svg_(self) -> str:
        return self._planned.svg()

    def _repr_png_(self) -> Optional[bytes]:
        from ._plot import png

        return png(self.plot)

    def __len__(self) -> int:
        return int(self.pulses)

    def __repr__(self) -> str:
        return f"<Plan {self.law}, {self.pulses} steps, {self.duration:.6g} s>"


_RATES = ("accel", "speed", "decel")

_TAKES: dict[str, tuple[str, ...]] = {
    "trapezoid": (*_RATES, "start_speed"),
    "s-curve": (*_RATES, "start_speed", "jerk"),
    "austin": (*_RATES, "first", "divisor", "changes"),
    "linear-factor": (*_RATES, "first", "knee"),
    "power": (*_RATES, "first", "power"),
    "piecewise": (*_RATES, "first", "breaks"),
    "ramp": ("speed", "start_speed", "ramp"),
    "austin-fixed": ("c0", "c_min"),
}
"""The parameters of each law."""


def plan(
    law: str,
    steps: Quantity,
    *,
    accel: Optional[Quantity] = None,
    speed: Optional[Quantity] = None,
    decel: Optional[Quantity] = None,
    start_speed: Optional[Quantity] = None,
    jerk: Optional[Quantity] = None,
    ramp: Optional[int] = None,
    first: Optional[str] = None,
    divisor: Optional[str] = None,
    changes: Optional[Sequence[tuple[int, Quantity]]] = None,
    knee: Optional[float] = None,
    power: Optional[int] = None,
    breaks: Optional[int] = None,
    c0: Optional[int] = None,
    c_min: Optional[int] = None,
    timer_hz: int = 1_000_000,
    steps_per_rev: Optional[int] = None,
    mm_per_rev: Optional[float] = None,
) -> Plan:
    """Plans a travel as ``stepwright plan LAW`` does, with the same options.

    Laws: ``trapezoid``, ``s-curve`` (``jerk``), ``ramp`` (its length in steps), ``austin`` (``first``,
    ``divisor``, ``changes``), ``linear-factor`` (``knee``), ``power``, ``piecewise`` (``breaks``),
    ``austin-fixed`` (``c0``, ``c_min``). Bare numbers are steps, steps/s and steps/s²; texts may
    have any unit. Raises ``ValueError``, also for a parameter that the law does not have.
    """
    scale = scale_of(steps_per_rev, mm_per_rev)
    asked: dict[str, Any] = {"law": str(law), "steps": text("steps", steps, None, "")}
    numbers = {
        "accel": accel,
        "decel": decel,
        "speed": speed,
        "start_speed": start_speed,
        "jerk": jerk,
        "ramp": ramp,
        "knee": knee,
        "power": power,
        "breaks": breaks,
        "c0": c0,
        "c_min": c_min,
    }
    asked.update({k: text(k, v, None, "") for k, v in numbers.items() if v is not None})
    names = {"first": first, "divisor": divisor}
    asked.update({k: str(v) for k, v in names.items() if v is not None})
    if changes is not None:
        asked["changes"] = [
            [text("changes", after, None, ""), text("changes", value, None, "")]
            for after, value in changes
        ]
    takes = _TAKES.get(law)
    others = [name for name in asked if takes and name not in ("law", "steps", *takes)]
    if takes and others:
        raise ValueError(f"the law {law} has no {others[0]}: it takes {', '.join(takes)}")
    unit = scale.unit if steps_per_rev or mm_per_rev else ("steps", 1.0)
    asked["timer_hz"] = text("timer_hz", timer_hz, None, "")
    return Plan(law, Planned(json.dumps(asked), scale), unit)


__all__ = ["PHASES", "Plan", "plan"]
