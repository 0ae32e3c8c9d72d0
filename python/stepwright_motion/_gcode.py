"""G-code jobs on paper."""

from __future__ import annotations

import html
import json
import os
from dataclasses import dataclass
from typing import Any, Mapping, Union

from ._native import Job, Scale
from ._quantity import Quantity, text


@dataclass(frozen=True)
class Corner:
    """Where a job becomes slower, and faster again."""

    line: int
    """The line of the move that ends there."""
    place: tuple[float, ...]
    """X, Y and Z, in mm."""
    speed: float
    """The speed there, in mm/s."""
    cost: float
    """What it costs, in s."""


class JobPlan:
    """A job that was planned, with its time."""

    def __init__(self, job: Job):
        self._job = job
        self.duration = job.duration
        """Seconds from the start to the end."""
        self.lines = job.lines
        """Lines of the file."""
        names = ("x", "y", "z")
        self.extents = {n: e for n, e in zip(names, job.extents) if e is not None}
        """Where moves lead, in mm: ``{"x": (0.0, 80.0), …}``."""
        self.refused = job.refused
        """Why an Uno could not follow, if it could not."""

    @property
    def corners(self) -> list[Corner]:
        """The corners that cost most time, the dearest first."""
        return [Corner(line, tuple(at), v, cost) for line, at, v, cost in self._job.corners]

    def facts(self) -> dict[str, Any]:
        """All of it, as ``stepwright gcode FILE --plan --format json`` says it."""
        facts: dict[str, Any] = json.loads(self._job.sheet(True))
        return facts

    def __str__(self) -> str:
        return self._job.sheet(False)

    def __repr__(self) -> str:
        return f"<JobPlan of {self.lines} lines, {self.duration:.6g} s>"

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(str(self))}</pre>"


class Gcode:
    """A file of G-code."""

    def __init__(self, path: Union[str, os.PathLike[str]]):
        self.path = os.fspath(path)

    def plan(
        self,
        *,
        steps_per_mm: Union[float, Mapping[str, float]] = 80.0,
        speed: Union[Quantity, Mapping[str, Quantity]] = "200mm/s",
        accel: Union[Quantity, Mapping[str, Quantity]] = "1000mm/s2",
        jump: Union[Quantity, Mapping[str, Quantity]] = "5mm/s",
    ) -> JobPlan:
        """Plans the whole job for axes that can do this; ``{"x": …, "y": …, "z": …}`` says it of each.

        Bare numbers are mm/s and mm/s². ``jump`` is by how much a speed may change at once, as at
        a corner. Raises ``ValueError`` with the line of the first mistake.
        """
        axes = []
        for name in ("x", "y", "z"):
            steps = float(_of(steps_per_mm, name))
            scale = Scale(round(steps * 1000), 1000.0)
            rates = [
                scale.speed(what, text(_of(value, name), None, "mm/s")) / steps
                for what, value in (("speed", speed), ("jump", jump))
            ]
            slope = scale.accel("accel", text(_of(accel, name), None, "mm/s2")) / steps
            axes.append((1.0 / steps, rates[0], slope, rates[1]))
        return JobPlan(Job(self.path, axes))

    def __repr__(self) -> str:
        return f"<Gcode {self.path}>"


def _of(value: Any, axis: str) -> Any:
    return value[axis] if isinstance(value, Mapping) else value


def gcode(path: Union[str, os.PathLike[str]]) -> Gcode:
    """A file of G-code: ``sw.gcode("part.nc").plan().duration``."""
    return Gcode(path)
