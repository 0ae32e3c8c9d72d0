"""Runs of motors by a file or along a path."""

from __future__ import annotations

import json
import math
import os
from functools import cached_property
from typing import Any, Iterator, Optional, Sequence, Union

from ._arrays import array, gradient
from ._errors import Refused
from ._native import Run as _Run
from ._native import play_cycles, walk
from ._quantity import Quantity, real
from ._scales import Paced, paces, speed_of


class Way:
    """The way of a motor: a time and a position for its start and for each of its steps."""

    def __init__(self, columns: list[bytearray], unit: str):
        self.times: Any = array(columns[0], "d")
        """Seconds since the start."""
        self.positions: Any = array(columns[1], "d")
        """The position from this time on, in ``unit``."""
        self.unit = unit
        """The unit of the positions."""

    @cached_property
    def speeds(self) -> Any:
        """The speed at each step, in units/s. Needs numpy."""
        return gradient(self.positions, self.times)

    def __len__(self) -> int:
        return len(self.times)


class Power:
    """The power of a laser: off at first, then the power from each time on."""

    def __init__(self, columns: list[bytearray]):
        self.times: Any = array(columns[0], "d")
        """Seconds since the start. The first is 0."""
        self.powers: Any = array(columns[1], "d")
        """From 0, off, to 1."""

    def __len__(self) -> int:
        return len(self.times)


class Run:
    """A job, a cycle file or a path, step by step: ``run.x.times``, ``run["motor"].positions``."""

    def __init__(self, run: _Run):
        self._run = run
        self.duration = run.seconds
        """Seconds from the start to the end."""
        self.names = run.names
        """The names of the motors."""
        self.unit = run.unit
        """The unit of the positions."""
        self.late = run.late
        """The number of steps that came later than planned."""
        self.braked = run.braked
        """Whether the run was braked before its end."""
        self._ways: dict[int, Way] = {}

    def __getitem__(self, motor: Union[int, str]) -> Way:
        """The way of a motor, by its name or its number from 1."""
        if isinstance(motor, str):
            known = [name.lower() for name in self.names]
            if motor.lower() not in known:
                raise KeyError(f"there is no motor {motor!r}: there are {', '.join(self.names)}")
            place = known.index(motor.lower())
        elif 1 <= motor <= len(self.names):
            place = motor - 1
        else:
            raise IndexError(f"there is no motor {motor}: give 1 to {len(self.names)}")
        if place not in self._ways:
            self._ways[place] = Way(self._run.columns(place), self.unit)
        return self._ways[place]

    @property
    def x(self) -> Way:
        """The way of the first motor."""
        return self[1]

    @property
    def y(self) -> Way:
        """The way of the second motor."""
        return self[2]

    @property
    def z(self) -> Way:
        """The way of the third motor."""
        return self[3]

    def __iter__(self) -> Iterator[Way]:
        return (self[number] for number in range(1, len(self.names) + 1))

    @cached_property
    def laser(self) -> Optional[Power]:
        """The power of the laser of a job; ``None`` without a laser."""
        columns = self._run.power()
        return None if columns is None else Power(columns)

    @property
    def positions(self) -> tuple[float, ...]:
        """The positions of the motors at the end."""
        return tuple(float(way.positions[-1]) for way in self)

    def facts(self) -> dict[str, Any]:
        """The results of cycles, as ``stepwright cycle FILE --format json`` prints them."""
        facts: dict[str, Any] = json.loads(self._run.facts or "{}")
        return facts

    def save(self, path: Union[str, os.PathLike[str]]) -> None:
        """Writes every edge of the virtual board's pins: ``.vcd``, ``.csv`` or ``.mcap``."""
        ending = os.path.splitext(path)[1].lower().lstrip(".")
        if ending not in ("csv", "vcd", "mcap"):
            raise ValueError(f"{path}: its name must end in .csv, .vcd or .mcap")
        data = self._run.pins(ending)
        with open(path, "wb") as file:
            file.write(data)

    def plot(self) -> Any:
        """Positions and speeds over time, and the way of the first two motors, by matplotlib."""
        from ._plot import draw_run

        return draw_run(self)

    def _repr_png_(self) -> Optional[bytes]:
        from ._plot import png

        return png(self.plot)

    def __repr__(self) -> str:
        places = ", ".join(f"{n} {p:.6g}" for n, p in zip(self.names, self.positions))
        return f"<Run of {self.duration:.6g} s, to {places} {self.unit}>"


def checked(run: _Run) -> Run:
    """A run that has reached its end. Raises the reason if it has not."""
    if run.error is not None:
        what, remedy = run.error
        raise Refused(what, remedy=remedy)
    return Run(run)


class Cycle:
    """A file of motor cycles."""

    def __init__(self, path: Union[str, os.PathLike[str]]):
        self.path = os.fspath(path)

    def run(
        self,
        port: Optional[Union[str, os.PathLike[str]]] = None,
        *,
        baud: int = 115_200,
        fast: bool = True,
        limit: int = 3600,
    ) -> Run:
        """Plays the file on a virtual board, or on the board at a port, which needs the program
        ``cycles`` (``stepwright flash mega --program cycles``).

        The time of the virtual board passes as fast as possible, or is real time without ``fast``.
        Ctrl-C brakes. A cycle that has not ended by itself is finished after ``limit`` seconds.
        Raises ``ValueError`` for an error in the file, ``Refused`` if a cycle was refused or
        cancelled, ``ConnectionError`` if there is no board. The ways of a real board have about
        ten looks a second, and there are no edges.
        """
        if not 1 <= limit <= 1_000_000:
            raise ValueError(f"limit is {limit}: it may be 1 to 1000000 s")
        with open(self.path, encoding="utf-8") as file:
            text = file.read()
        port = None if port is None else os.fspath(port)
        return checked(play_cycles(self.path, text, port, baud, fast, limit))

    def __repr__(self) -> str:
        return f"<Cycle {self.path}>"


def cycle(path: Union[str, os.PathLike[str]]) -> Cycle:
    """A file of motor cycles: ``sw.cycle("drawing.toml").run()``."""
    return Cycle(path)


def path(
    places: Sequence[Sequence[float]],
    *,
    feed: Quantity = "50mm/s",
    steps_per_mm: Paced[float] = 80.0,
    speed: Paced[Quantity] = "200mm/s",
    accel: Paced[Quantity] = "1000mm/s2",
    jump: Paced[Quantity] = "5mm/s",
    jerk: Paced[Optional[Quantity]] = None,
    tolerance: float = 0.0,
) -> Run:
    """Plans a path along straight lines between places, each ``(x, y)`` or ``(x, y, z)`` in mm, at the
    speed ``feed``, with corners at the speed that each axis allows. The path may be off the lines by
    ``tolerance``, in mm: then one arc replaces as many short lines as it fits.

    The path begins at rest at the first place and ends at rest at the last. The limits are those of
    ``Gcode.plan``. Raises ``ValueError``.
    """
    rate = speed_of("feed", feed)
    points = []
    for count, place in enumerate(places):
        if not 1 <= len(place) <= 3:
            raise ValueError(f"a place has one to three coordinates, not {len(place)}")
        full = [real(f"waypoint {count}", value, "numbers, in mm") for value in place]
        if not all(map(math.isfinite, full)):
            raise ValueError(f"waypoint {count} is {tuple(full)}: give finite numbers, in mm")
        full += [0.0] * (3 - len(place))
        points.append((full, rate))
    near = real("tolerance", tolerance, "a number of mm")
    return Run(walk(points, paces(steps_per_mm, speed, accel, jump, jerk), near))


__all__ = ["Cycle", "Power", "Run", "Way", "cycle", "path"]
