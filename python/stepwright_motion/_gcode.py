"""G-code jobs, planned or run on a virtual board or a real one."""

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
    """A place where a job slows down and speeds up again."""

    line: int
    """The line of the move that ends there."""
    place: tuple[float, ...]
    """X, Y and Z in mm."""
    speed: float
    """The speed there in mm/s."""
    cost: float
    """The lost time in s."""


class JobPlan:
    """A planned job with its time."""

    def __init__(self, job: Job):
        self._job = job
        self.duration = job.duration
        """Seconds from the start to the end."""
        self.lines = job.lines
        """The lines of the file."""
        names = ("x", "y", "z")
        self.extents = {n: e for n, e in zip(names, job.extents) if e is not None}
        """The extents of the moves in mm: ``{"x": (0.0, 80.0), …}``."""
        self.refused = job.refused
        """Why an Uno can't follow; ``None`` if it can."""

    @property
    def corners(self) -> list[Corner]:
        """The corners that cost most time, the most expensive first."""
        return [Corner(line, tuple(at), v, cost) for line, at, v, cost in self._job.corners]

    def facts(self) -> dict[str, Any]:
        """The whole plan, as ``stepwright gcode FILE --plan --format json`` prints it."""
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
        """Plans the whole job for axes with these limits; ``{"x": …, "y": …, "z": …}`` sets them per axis.

        Bare numbers are mm/s, mm/s² and mm/s³. ``jump`` is the largest change of speed at once, as at a
        corner; ``jerk`` is the largest change of acceleration per second, ``None`` for no limit.
        ``laser`` is the S of full power of a laser, which M3, M4 and S turn on and off along the path;
        ``None`` is a spindle, and the path rests for each of its changes. The path may be off its lines
        by ``tolerance``, in mm, until the job orders ``G61`` or ``G64``. Raises ``ValueError`` with the
        line of the first error.
        """
        return JobPlan(self._job(paces(steps_per_mm, speed, accel, jump, jerk), laser, tolerance))

    def run(
        self,
        port: Optional[Union[str, os.PathLike[str]]] = None,
        *,
        baud: int = 115_200,
        fast: bool = True,
        steps_per_mm: Paced[float] = 80.0,
        speed: Paced[Quantity] = "200mm/s",
        accel: Paced[Quantity] = "1000mm/s2",
        jump: Paced[Quantity] = "5mm/s",
        jerk: Paced[Optional[Quantity]] = None,
        laser: Optional[float] = None,
        tolerance: float = 0.0,
    ) -> Run:
        """Runs the job on a separate virtual Uno, or on the board at a port, which needs the program
        ``stream`` (``stepwright flash uno --program stream``). Returns the time of each step of each
        axis, and the power of a laser.

        The time of the virtual board passes as fast as possible, or is real time without ``fast``.
        Ctrl-C brakes along the path. The ways of a real board have about fifty looks a second; its
        axes stand at the machine's zero. The other parameters are those of ``plan``. Raises
        ``Refused`` if the board can't follow, or if a real board did not get to the end;
        ``ConnectionError`` if there is no board.
        """
        job = self._job(paces(steps_per_mm, speed, accel, jump, jerk), laser, tolerance)
        if job.refused is not None and port is None:
            raise Refused(job.refused, remedy="give a lower speed of this axis, or fewer steps_per_mm")
        return checked(job.run(None if port is None else os.fspath(port), baud, fast))

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
