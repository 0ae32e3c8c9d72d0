"""An axis of a board."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Iterator, Optional, Union

from ._errors import OutOfRange, Uncertain
from ._move import Move, Outcome
from ._native import Scale
from ._quantity import Quantity, text
from ._quantity import seconds as in_seconds
from ._scales import MmScale, scale_of

if TYPE_CHECKING:
    from ._line import Line


class Axis:
    """An axis: ``board.x``, ``board[1]``.

    An axis counts in its ``unit``: steps, or the unit set by ``steps_per_mm``, by ``scale_to`` or by a
    machine file. Bare numbers are in this unit (speeds in units/s, accelerations in units/s²), and so
    are the positions that the axis returns. ``"25"`` is the same as 25; a text may have any unit: ``"25mm"``, ``"90deg"``,
    ``"120rpm"``; units of turns need more than ``steps_per_mm``.
    """

    speed: Optional[Quantity] = None
    """The speed between the ramps. By default 1000 steps/s."""
    accel: Optional[Quantity] = None
    """The acceleration. By default it reaches the speed in 0.4 s."""
    decel: Optional[Quantity] = None
    """The deceleration. By default the acceleration."""
    start_speed: Optional[Quantity] = None
    """The speed to which the motor jumps from rest, and from which it stops. By default 50 steps/s."""
    jerk: Optional[Quantity] = None
    """The limit of jerk, for a board with S-curves. By default none."""

    def __init__(self, line: Line, number: int):
        self._line = line
        self.number = number
        self.scale: Union[Scale, MmScale] = Scale()
        self._home: dict[str, Quantity] = {}

    # A misspelt name would set a limit that nothing keeps. Type checkers find that without this.
    if not TYPE_CHECKING:

        def __setattr__(self, name: str, value: Any) -> None:
            if not (name.startswith("_") or name in ("number", "scale") or hasattr(Axis, name)):
                settable = "speed, accel, decel, start_speed, jerk and steps_per_mm"
                raise AttributeError(f"an axis has no {name}: set one of {settable}")
            super().__setattr__(name, value)

    # The relation of steps to turns and millimetres.

    @property
    def unit(self) -> str:
        """``steps``, ``mm`` or ``deg``."""
        return str(self.scale.unit[0])

    @property
    def steps_per_mm(self) -> float:
        """The steps per millimetre."""
        name, steps = self.scale.unit
        if name != "mm":
            raise ValueError(f"axis {self.number} counts {name}: set steps_per_mm")
        return float(steps)

    @steps_per_mm.setter
    def steps_per_mm(self, steps: float) -> None:
        self.scale = MmScale(steps)

    def scale_to(
        self, steps_per_rev: Optional[int] = None, mm_per_rev: Optional[float] = None
    ) -> None:
        """Makes the axis count in millimetres, or in degrees if only the steps of a turn are given.

        By default a turn has 200 steps.
        """
        self.scale = scale_of(steps_per_rev, mm_per_rev)

    def _steps(self, position: Quantity, unit: Optional[str] = None, name: str = "position") -> int:
        with self._in_words():
            return self.scale.distance(name, text(name, position, unit, self.unit))

    @contextmanager
    def _in_words(self) -> Iterator[None]:
        """Adds the remedy of this package to an error of a unit."""
        try:
            yield
        except ValueError as why:
            if "need the distance of one turn" not in str(why):
                raise
            raise ValueError(f"{why}: set steps_per_mm of axis {self.number}") from None

    def _rate(self, name: str, value: Quantity, unit: Optional[str] = None) -> float:
        with self._in_words():
            rate = self._rate_of(name, value, unit)
        if name in ("speed", "slow") and rate == 0:
            raise OutOfRange(f"{name} is {value}", "0.001 to 1000000 steps/s")
        return rate

    def _rate_of(self, name: str, value: Quantity, unit: Optional[str]) -> float:
        usual = self.unit
        if name in ("accel", "decel"):
            return self.scale.accel(name, text(name, value, unit, f"{usual}/s2"))
        if name == "jerk":
            return self.scale.jerk(name, text(name, value, unit, f"{usual}/s3"))
        return self.scale.speed(name, text(name, value, unit, f"{usual}/s"))

    def _limits(self, given: dict[str, Any], top: str = "top_speed") -> dict[str, float]:
        limits: dict[str, float] = {}
        for name in ("speed", "accel", "decel", "start_speed", "jerk"):
            value = given.get(name)
            value = getattr(self, name) if value is None else value
            if value is not None:
                limits[top if name == "speed" else name] = self._rate(name, value)
        return limits

    # The state of the axis.

    def _state(self) -> dict[str, Any]:
        state: dict[str, Any] = self._line.state()["axes"][self.number - 1]
        return state

    @property
    def steps(self) -> int:
        """The position in steps at the last look, at most 20 ms ago while the axis moves.

        Raises ``Uncertain`` if the position is not known.
        """
        at = self._state()["position"]
        if at is None:
            self._line.check()
            words = f"the position of axis {self.number} is uncertain"
            raise Uncertain(Outcome("uncertain", words, (None,), (None,)))
        return int(at)

    @property
    def position(self) -> float:
        """The position in the unit of the axis."""
        return self.steps / self.scale.unit[1]

    @property
    def speed_now(self) -> float:
        """The speed over the last tenth of a second, in units/s."""
        self._line.check()
        return float(self._state()["speed"]) / float(self.scale.unit[1])

    @property
    def moving(self) -> bool:
        """Whether the axis moves. Raises ``LinkLost`` if that is not known."""
        self._line.check()
        return bool(self._state()["moving"])

    # Orders.

    def move_to(
        self,
        position: Quantity,
        unit: Optional[str] = None,
        *,
        speed: Optional[Quantity] = None,
        accel: Optional[Quantity] = None,
        decel: Optional[Quantity] = None,
        start_speed: Optional[Quantity] = None,
        jerk: Optional[Quantity] = None,
    ) -> Move:
        """Begins to move to a position. Raises ``Refused`` if nothing moves."""
        limits = self._limits(locals())
        body = {"axis": self.number, "to": self._steps(position, unit), **limits}
        return self._order("move", body)

    def move_by(
        self,
        distance: Quantity,
        unit: Optional[str] = None,
        *,
        speed: Optional[Quantity] = None,
        accel: Optional[Quantity] = None,
        decel: Optional[Quantity] = None,
        start_speed: Optional[Quantity] = None,
        jerk: Optional[Quantity] = None,
    ) -> Move:
        """Begins to move by a distance. Raises ``Refused`` if nothing moves."""
        limits = self._limits(locals())
        body = {"axis": self.number, "by": self._steps(distance, unit, "distance"), **limits}
        return self._order("move", body)

    def run(
        self,
        speed: Optional[Quantity] = None,
        unit: Optional[str] = None,
        *,
        seconds: Optional[float] = None,
        accel: Optional[Quantity] = None,
        decel: Optional[Quantity] = None,
        start_speed: Optional[Quantity] = None,
        jerk: Optional[Quantity] = None,
    ) -> Move:
        """Begins to run, backward if the speed is negative, until a stop or for ``seconds``.

        In a ``with`` block the axis runs until the end of the block.
        """
        given = self.speed if speed is None else speed
        size = "1000steps/s" if given is None else text("speed", given, unit, f"{self.unit}/s")
        backward = size.startswith(("-", "\u2212"))
        limits = self._limits({**locals(), "speed": size.lstrip("+-\u2212")}, "speed")
        if backward:
            limits["speed"] = -limits["speed"]
        lasts = None if seconds is None else in_seconds("seconds", seconds)
        return self._order("run", {"axis": self.number, **limits}, lasts, endless=True)

    jog = run

    def home(
        self,
        within: Optional[Quantity] = None,
        *,
        speed: Optional[Quantity] = None,
        slow: Optional[Quantity] = None,
        back_off: Optional[Quantity] = None,
        accel: Optional[Quantity] = None,
        start_speed: Optional[Quantity] = None,
    ) -> Move:
        """Begins to find 0 by the limit switch, which the setting ``switches`` enables.

        ``within`` is the longest distance to the switch, ``back_off`` the distance of the axis from the
        switch at the end. The axis moves to the switch at ``speed``, by default 500 steps/s, and a
        second time at ``slow``, by default 50.
        """
        body: dict[str, Any] = {"axis": self.number}
        known = {**self._home, **{k: v for k, v in locals().items() if v is not None}}
        for name in ("within", "back_off"):
            if name in known:
                body[name] = self._steps(known[name], None, name)
        if "within" not in body:
            raise OutOfRange(
                f"`within` is missing: how far the switch of axis {self.number} may be",
                "1 to 2147483647 steps",
                "give a little more than the axis can travel, or write home-within into the machine "
                f"file, under [axis.{self.number}]",
            )
        for name in ("speed", "slow"):
            if name in known:
                body[name] = self._rate(name, known[name])
        for name, given in (("accel", accel), ("start_speed", start_speed)):
            value = getattr(self, name) if given is None else given
            if value is not None:
                body[name] = self._rate(name, value)
        return self._order("home", body)

    def stop(self) -> None:
        """Brakes the axis along its ramp and waits until it rests."""
        self._line.ask("stop", axis=self.number)
        self._line.rest(lambda: not self.moving)

    def zero(self) -> None:
        """Sets the present position to 0."""
        self._line.ask("zero", axis=self.number)

    def _order(
        self,
        name: str,
        body: dict[str, Any],
        seconds: Optional[float] = None,
        endless: bool = False,
    ) -> Move:
        order = self._line.give(name, body, seconds)
        return Move(self._line, (self,), order, endless)._begun()

    def __repr__(self) -> str:
        return f"<Axis {self.number} of {self._line.name}>"
