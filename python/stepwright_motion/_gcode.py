"""G-code jobs, on paper and on a virtual board."""

from __future__ import annotations

import html
import json
import os
from dataclasses import dataclass
from typing import Any, Optional, Union

from ._errors import Refused
from ._native import Job
from ._quantity import Quantity, real
from ._run import Run, checked
from ._scales import Pace, Paced, paces


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
        steps_per_mm: Paced[float] = 80.0,
        speed: Paced[Quantity] = "200mm/s",
        accel: Paced[Quantity] = "1000mm/s2",
        jump: Paced[Quantity] = "5mm/s",
        jerk: Paced[Optional[Quantity]] = None,
        laser: Optional[float] = None,
        tolerance: float = 0.0,
    ) -> JobPlan:
        """Plans the whole job for axes that can do this; ``{"x": …, "y": …, "z": …}`` says it of each.

        Bare numbers are mm/s, mm/s² and mm/s³. ``jump`` is by how much a speed may change at once, as at
        a corner; ``jerk`` by how much an acceleration may in a second, without a limit if it is ``None``.
        ``laser`` is S of full power of a laser, which goes on and off along the path by M3, M4 and S;
        ``None`` is a spindle, which rests for each. The path may be off its lines by ``tolerance``, in mm,
        until the job orders ``G61`` or ``G64``. Raises ``ValueError`` with the line of the first mistake.
        """
        return JobPlan(self._job(paces(steps_per_mm, speed, accel, jump, jerk), laser, tolerance))

    def run(
        self,
        *,
        fast: bool = True,
        steps_per_mm: Paced[float] = 80.0,
        speed: Paced[Quantity] = "200mm/s",
        accel: Paced[Quantity] = "1000mm/s2",
        jump: Paced[Quantity] = "5mm/s",
        jerk: Paced[Optional[Quantity]] = None,
        laser: Optional[float] = None,
        tolerance: float = 0.0,
    ) -> Run:
        """Runs it on a virtual Uno of its own, and says when each axis made each step, and what a laser
        did.

        Its time passes as fast as it can, or as ours does if it is not ``fast``. Ctrl-C brakes along
        the path. All the rest is as for ``plan``. Raises ``Refused`` where an Uno could not
        follow. No real board takes a job.
        """
        job = self._job(paces(steps_per_mm, speed, accel, jump, jerk), laser, tolerance)
        if job.refused is not None:
            raise Refused(job.refused, remedy="give a lower speed of this axis, or fewer steps_per_mm")
        return checked(job.run(fast))

    def _job(self, axes: list[Pace], laser: Optional[float], tolerance: float) -> Job:
        if laser is not None:
            laser = real("laser", laser, "S of full power, or None")
            if not 0.001 <= laser <= 1e6:
                raise ValueError(f"laser is {laser!r}: S of full power may be 0.001 to 1000000")
        near = real("tolerance", tolerance, "a number of mm")
        return Job(self.path, axes, laser, near)

    def __repr__(self) -> str:
        return f"<Gcode {self.path}>"


def gcode(path: Union[str, os.PathLike[str]]) -> Gcode:
    """A file of G-code: ``sw.gcode("part.nc").plan().duration``."""
    return Gcode(path)
