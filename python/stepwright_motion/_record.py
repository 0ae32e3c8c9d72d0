"""The recorded motion of axes, as arrays."""

from __future__ import annotations

import csv
import importlib
import os
import struct
from types import TracebackType
from typing import TYPE_CHECKING, Any, Iterator, Optional, Type, Union

from ._arrays import array
from ._line import place_of
from ._native import Recorder

if TYPE_CHECKING:
    from ._axis import Axis

STATES = ("ready", "busy", "uncertain", "lost")
"""The states of an axis, by the numbers of ``Track.state``."""


class Track:
    """The recorded motion of an axis. Each array has one value for every look at the axis."""

    def __init__(self, axis: Axis, columns: list[bytearray], missed: int):
        steps = axis.scale.unit[1]
        self.unit = axis.unit
        """The unit of the positions."""
        self.time: Any = array(columns[0], "d")
        """Seconds since the board was opened, by the clock of ``board.time``."""
        self.position: Any = _scaled(array(columns[1], "d"), steps)
        """The position; NaN if it was not known."""
        self.speed: Any = _scaled(array(columns[2], "d"), steps)
        """The speed over the last tenth of a second, in units/s."""
        self.state: Any = array(columns[3], "B")
        """The state, as an index of ``STATES``."""
        self.missed = missed
        """The number of looks, 50 a second while the axis moved, that did not come in time."""

    def __len__(self) -> int:
        return len(self.time)


def _scaled(values: Any, steps: float) -> Any:
    if steps == 1.0:
        return values
    if isinstance(values, memoryview):
        return memoryview(bytearray(b"".join(_double(value / steps) for value in values))).cast("d")
    return values / steps


def _double(value: float) -> bytes:
    return struct.pack("=d", value)


class Recording:
    """A recording: ``with board.record() as log: …``, then ``log.x.time``, ``log.x.position``.

    It has every look at the axes: 50 a second at moving axes, 2 at resting axes. ``missed`` is the
    number of looks that did not come in time.
    """

    def __init__(self, axes: tuple[Axis, ...], recorder: Recorder):
        self._axes = axes
        self._recorder = recorder

    def stop(self) -> None:
        """Ends the recording."""
        self._recorder.stop()

    def __enter__(self) -> Recording:
        return self

    def __exit__(
        self,
        kind: Optional[Type[BaseException]],
        value: Optional[BaseException],
        trace: Optional[TracebackType],
    ) -> None:
        self.stop()

    def __getitem__(self, axis: Union[int, str]) -> Track:
        """The track of an axis, so far."""
        place = place_of(axis, len(self._axes))
        of = self._axes[place]
        return Track(of, self._recorder.columns(place), self._recorder.missed(place))

    @property
    def x(self) -> Track:
        """The track of axis 1, so far."""
        return self[1]

    @property
    def y(self) -> Track:
        """The track of axis 2, so far."""
        return self[2]

    @property
    def z(self) -> Track:
        """The track of axis 3, so far."""
        return self[3]

    @property
    def missed(self) -> int:
        """The number of looks that did not come in time while an axis moved."""
        return sum(self._recorder.missed(axis) for axis in range(self._recorder.axes))

    def rows(self) -> Iterator[tuple[int, float, float, float, str]]:
        """Every look as axis, time, position, speed, state; axis by axis."""
        for axis in self._axes:
            track = self[axis.number]
            for look in range(len(track)):
                at = (float(track.time[look]), float(track.position[look]), float(track.speed[look]))
                yield (axis.number, *at, STATES[int(track.state[look])])

    def save(self, path: Union[str, os.PathLike[str]]) -> None:
        """Writes a file of the kind that its name ends with.

        ``.csv``: every look as a row. ``.vcd`` (GTKWave, PulseView) and ``.mcap`` (Foxglove,
        PlotJuggler): the edges of STEP and DIR. The pins of a real board are not visible: its file has
        the planned pulses of the last 10 s.
        """
        ending = os.path.splitext(path)[1].lower().lstrip(".")
        if ending not in ("csv", "vcd", "mcap"):
            raise ValueError(f"{path}: its name must end in .csv, .vcd or .mcap")
        if ending != "csv":
            data = self._recorder.pins(ending)
            with open(path, "wb") as pins:
                pins.write(data)
            return
        with open(path, "w", newline="", encoding="utf-8") as file:
            table = csv.writer(file)
            table.writerow(("axis", "time", "position", "speed", "state"))
            table.writerows(self.rows())

    def frame(self) -> Any:
        """The looks as a frame of pandas. Needs pandas."""
        names = ("axis", "time", "position", "speed", "state")
        return importlib.import_module("pandas").DataFrame(list(self.rows()), columns=list(names))
