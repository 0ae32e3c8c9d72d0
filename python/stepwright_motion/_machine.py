"""Machine files: the port, units, speeds and ramps of a machine, shared with the command."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Optional, Union

from ._native import Scale, read_lease, read_machine
from ._quantity import is_bare

if TYPE_CHECKING:
    from ._axis import Axis

File = Union[str, "os.PathLike[str]"]


class Machine:
    """The values of a machine file."""

    def __init__(self, path: Optional[Path] = None):
        self.path = path
        self._board: dict[str, str] = {}
        self._axes: dict[int, dict[str, str]] = {}
        if path is not None:
            try:
                board, axes = read_machine(path.read_text("utf-8"))
            except ValueError as why:
                raise ValueError(f"{path}: {why}") from None
            self._board = dict(board)
            self._axes = {number: dict(values) for number, values in axes}

    @staticmethod
    def find(named: Optional[File]) -> Machine:
        """The file with this name, or the file that the command finds: ``STEPWRIGHT_MACHINE``,
        ``stepwright.toml`` here, the user's file. ``"none"`` is no file."""
        name = os.environ.get("STEPWRIGHT_MACHINE") if named is None else os.fspath(named)
        if name is not None:
            return Machine() if name in ("", "none") else Machine(Path(name))
        variable = "APPDATA" if os.name == "nt" else "XDG_CONFIG_HOME"
        folder = Path(os.environ.get(variable) or Path.home() / ".config")
        for path in (Path("stepwright.toml"), folder / "stepwright" / "machine.toml"):
            if path.is_file():
                return Machine(path)
        return Machine()

    @property
    def port(self) -> Optional[str]:
        """The port of the board."""
        return self._board.get("port")

    @property
    def baud(self) -> Optional[int]:
        """The rate of the port in bits/s."""
        return int(self._board["baud"]) if "baud" in self._board else None

    @property
    def lease(self) -> Optional[float]:
        """The silence in s after which the board brakes."""
        return read_lease(self._board["lease"]) if "lease" in self._board else None

    def set_up(self, axis: Axis) -> None:
        """Gives an axis its values from the file."""
        values = self._axes.get(axis.number, {})
        rev, mm = values.get("steps-per-rev"), values.get("mm-per-rev")
        if rev or mm:
            axis.scale = Scale(int(rev) if rev else None, float(mm.rstrip("m")) if mm else None)
        # A bare number in the file is in steps.
        texts = {
            key: f"{value}{_BARE.get(key, '')}" if is_bare(value) else value
            for key, value in values.items()
        }
        axis.speed = texts.get("top-speed")
        axis.accel = texts.get("accel")
        axis.decel = texts.get("decel")
        axis.start_speed = texts.get("start-speed")
        axis.jerk = texts.get("jerk")
        if "ramp" in values:
            # The ramp from the start speed to the top speed has this many steps.
            top = axis._rate("speed", axis.speed or "1000steps/s")
            start = axis._rate("start_speed", axis.start_speed or "50steps/s")
            slope = (top**2 - start**2) / (2 * int(values["ramp"]))
            # A top speed that is not above the start speed has no ramp, and any acceleration will do.
            axis.accel = f"{max(slope, 1.0):.3f}steps/s2"
        homing = ("home-within", "home-back-off", "home-speed", "home-slow")
        known = {key[5:].replace("-", "_"): texts[key] for key in homing if key in texts}
        axis._home.update(known)


_BARE = {
    "top-speed": "steps/s",
    "start-speed": "steps/s",
    "home-speed": "steps/s",
    "home-slow": "steps/s",
    "accel": "steps/s2",
    "decel": "steps/s2",
    "jerk": "steps/s3",
    "home-within": "steps",
    "home-back-off": "steps",
}
