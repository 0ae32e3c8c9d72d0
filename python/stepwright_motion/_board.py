"""A board: how to open it, and its orders as a whole."""

from __future__ import annotations

import atexit
import html
import os
import weakref
from types import TracebackType
from typing import TYPE_CHECKING, Any, Iterator, Optional, Type, Union

from ._axis import Axis
from ._errors import LinkLost, StepwrightError
from ._line import Line, place_of
from ._machine import File, Machine
from ._move import Move
from ._native import Kept
from ._quantity import Quantity, number, real
from ._quantity import seconds as in_seconds
from ._record import Recording
from ._settings import Settings

_open: weakref.WeakSet[Line] = weakref.WeakSet()


class Board:
    """An open board. At the end of a ``with`` block all axes brake, in every case.

    A separate thread talks to the board while this program lives. If the program dies, the board
    brakes along its ramps after its lease, and its positions stay known.
    """

    def __init__(self, line: Line, machine: Machine):
        # The objects below hold the line, and nothing holds the board: it is let go once nobody holds it.
        self._line = line
        self.name = line.name
        """The port."""
        self._axes = tuple(Axis(line, one["axis"]) for one in line.sheet()["axes"])
        for axis in self._axes:
            machine.set_up(axis)
        self.settings = Settings(line)
        """The settings, as attributes."""
        _open.add(line)

    # As an axis does: nothing would keep what is set by a misspelt name.
    if not TYPE_CHECKING:

        def __setattr__(self, name: str, value: Any) -> None:
            if not (name.startswith("_") or name in ("name", "settings") or hasattr(Board, name)):
                raise AttributeError(f"a board has no {name}: set it on an axis, such as board.x")
            super().__setattr__(name, value)

    # The axes.

    @property
    def axes(self) -> tuple[Axis, ...]:
        """The axes."""
        return self._axes

    @property
    def x(self) -> Axis:
        """Axis 1."""
        return self[1]

    @property
    def y(self) -> Axis:
        """Axis 2."""
        return self[2]

    @property
    def z(self) -> Axis:
        """Axis 3."""
        return self[3]

    def __getitem__(self, axis: Union[int, str]) -> Axis:
        """An axis by its letter, or its number, counted from 1."""
        return self._axes[place_of(axis, len(self._axes))]

    def __iter__(self) -> Iterator[Axis]:
        return iter(self._axes)

    def __len__(self) -> int:
        return len(self._axes)

    # The state of the board.

    @property
    def time(self) -> float:
        """Seconds since the board was opened, by the clock of recordings."""
        return self._line.kept.time

    @property
    def moving(self) -> bool:
        """Whether any axis moves. Raises ``LinkLost`` if that is not known."""
        self._line.check()
        return any(bool(axis["moving"]) for axis in self._line.state()["axes"])

    @property
    def late(self) -> int:
        """The number of late steps since the last ``acknowledge``."""
        return int(self._line.state()["late"])

    @property
    def errors(self) -> list[str]:
        """The errors since the last ``acknowledge``, in words."""
        return [str(one["words"]) for one in self._line.state()["errors"]]

    @property
    def max_speed(self) -> Optional[int]:
        """The highest speed of a single axis, in steps/s."""
        speed: Optional[int] = self._line.sheet()["max_speed"]
        return speed

    def notes(self) -> list[str]:
        """The notes for people since the last call."""
        return self._line.kept.notes()

    # Orders.

    def line_to(self, *places: Optional[Quantity], **given: Optional[Quantity]) -> Move:
        """Moves axes together along a straight line: ``line_to(x=25, y="-3mm", speed="40mm/s")``.

        All start and end together; ``None`` leaves an axis where it is. The speed and the ramps
        are those of the axis that goes furthest.
        """
        return self._straight("to", places, given)

    def line_by(self, *distances: Optional[Quantity], **given: Optional[Quantity]) -> Move:
        """Moves axes along a straight line, by distances from their present positions."""
        return self._straight("by", distances, given)

    def _straight(self, way: str, places: tuple[Optional[Quantity], ...], given: Any) -> Move:
        wanted: dict[int, Quantity] = {
            number: place for number, place in enumerate(places, 1) if place is not None
        }
        limits = {}
        for name, value in given.items():
            if name in ("speed", "accel", "decel", "start_speed", "jerk"):
                limits[name] = value
            elif name not in ("x", "y", "z"):
                raise TypeError(
                    f"line_{way} takes x, y, z, speed, accel, decel, start_speed, jerk, not {name}"
                )
            elif "xyz".index(name) + 1 in wanted:
                raise TypeError(f"line_{way} was given {name} twice")
            elif value is not None:
                wanted["xyz".index(name) + 1] = value
        steps: list[Optional[int]] = [None] * max(wanted, default=1)
        for number, place in wanted.items():
            axis = self[number]
            steps[number - 1] = axis._steps(place)
        lead = self[max(wanted, key=lambda n: self._length(way, n, steps), default=1)]
        order = self._line.give("line", {way: steps, **lead._limits(limits)})
        axes = tuple(self[number] for number in sorted(wanted))
        return Move(self._line, axes, order)._begun()

    def _length(self, way: str, number: int, steps: list[Optional[int]]) -> int:
        there = self._line.state()["axes"][number - 1]["position"] or 0
        return abs((steps[number - 1] or 0) - (there if way == "to" else 0))

    def stop(self) -> None:
        """Brakes every axis along its ramp and waits until all rest."""
        self._line.ask("stop")
        self._line.rest(lambda: not self.moving)

    def kill(self) -> None:
        """Stops every axis at once. The position of a moving axis becomes unknown."""
        self._line.ask("kill")

    def acknowledge(self) -> None:
        """Clears the errors."""
        self._line.ask("acknowledge")

    def sleep(self, seconds: float) -> None:
        """Lets this time pass on the board. On a fast virtual board it takes less real time."""
        self._line.sleep(in_seconds("seconds", seconds))
        self._line.check()

    def record(self) -> Recording:
        """Begins to record positions, speeds and states, until the recording is stopped or its
        ``with`` block ends."""
        return Recording(self._axes, self._line.kept.record())

    # The end.

    def close(self) -> None:
        """Brakes all axes, waits until they rest, and closes the board.

        Raises ``LinkLost`` if the board is lost: a motor may be moving.
        """
        _open.discard(self._line)
        self._line.close()

    def __enter__(self) -> Board:
        if self._line.kept.ended:
            self._line.check()
            raise LinkLost("the board is closed; open it again")
        return self

    def __exit__(
        self,
        kind: Optional[Type[BaseException]],
        value: Optional[BaseException],
        trace: Optional[TracebackType],
    ) -> None:
        heard = self._line.lost
        try:
            self.close()
        except LinkLost:
            if kind is None and not heard:
                raise

    def _repr_html_(self) -> str:
        looks = self._line.state()["axes"]
        rows = "".join(
            f"<tr><td>{axis.number}</td><td>{_known(look['position'], axis)}</td>"
            f"<td>{axis.unit}</td><td>{look['state']}</td></tr>"
            for axis, look in zip(self._axes, looks)
        )
        head = "<tr><th>axis</th><th>position</th><th>unit</th><th>state</th></tr>"
        return f"<p>{html.escape(repr(self))}</p><table>{head}{rows}</table>"

    def __repr__(self) -> str:
        state = "closed" if self._line.kept.ended else "open"
        return f"<Board {self.name}, {len(self._axes)} axes, {state}>"


def _known(position: Optional[int], axis: Axis) -> str:
    return "unknown" if position is None else f"{position / axis.scale.unit[1]:g}"


def open(
    port: Optional[File] = None,
    *,
    baud: Optional[int] = None,
    lease: Optional[float] = None,
    machine: Optional[File] = None,
) -> Board:
    """Opens the board on a serial port, or behind a plain socket: ``tcp://192.168.0.7:4000``.

    Without a port it opens the port of the machine file, or else a virtual board. ``"virtual"`` is
    always a virtual board. ``lease`` is the silence in s, 1 by default, after which the board brakes by
    itself because this program has died or the cable is pulled. ``machine`` is a machine file, by
    default the file that the command uses here. Raises ``CantOpen``.
    """
    file = Machine.find(machine)
    port = file.port if port is None else os.fspath(port)
    if port is None or port == "virtual":
        return virtual(lease=lease, machine=machine)
    rate = file.baud or 115_200 if baud is None else baud
    if not 50 <= rate <= 12_000_000:
        raise ValueError(f"baud is {rate}: it may be 50 to 12000000 bits/s")
    return Board(Line(Kept.open(port, rate, _millis(lease, file), False, [])), file)


def _millis(lease: Optional[float], file: Machine) -> int:
    seconds = file.lease if lease is None else lease
    held = real("lease", 1.0 if seconds is None else seconds, "a number of seconds")
    if not 0.2 <= held <= 60:
        raise ValueError(f"lease is {seconds!r}: it may be 0.2 to 60 s")
    return round(held * 1000)


def virtual(
    *,
    fast: bool = False,
    switches: Optional[dict[Union[int, str], int]] = None,
    lease: Optional[float] = None,
    machine: Optional[File] = None,
) -> Board:
    """A virtual Uno in this process: the engine of the chip, with simulated pins.

    Its time is real time. With ``fast`` it passes only while something waits for it, as fast as the
    simulation allows. ``switches={"x": -1000}`` puts a limit switch on the machine, which the axis
    closes at this position in steps and beyond.
    """
    file = Machine.find(machine)
    places = []
    for axis, place in (switches or {}).items():
        if not (steps := number("switches", place).lstrip("-")).isdecimal() or not int(steps):
            raise ValueError(f"switches has {place!r}: a place is a whole number of steps, not 0")
        places.append(f"{place_of(axis, 3) + 1}:{number('switches', place)}")
    board = Board(Line(Kept.open(None, 115_200, _millis(lease, file), fast, places)), file)
    if ends := [(int(axis) - 1, int(at)) for axis, at in (place.split(":") for place in places)]:
        board.settings.switches = sum(1 << axis for axis, _ in ends)
        board.settings.switch_forward = sum(1 << axis for axis, at in ends if at > 0)
    return board


@atexit.register
def _close_all() -> None:
    for line in list(_open):
        try:
            line.close()
        except (StepwrightError, RuntimeError):
            # The board is gone, or belongs to the process that this one was forked from.
            pass
