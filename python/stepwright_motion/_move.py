"""An ordered motion and its outcome."""

from __future__ import annotations

import asyncio
import json
from dataclasses import dataclass
from types import TracebackType
from typing import TYPE_CHECKING, Any, Generator, Optional, Type

from ._errors import Refused, Stopped, Uncertain
from ._quantity import Quantity

if TYPE_CHECKING:
    from ._axis import Axis
    from ._line import Line
    from ._native import Order


@dataclass(frozen=True)
class Outcome:
    """The outcome of a motion."""

    kind: str
    """``reached``: every axis rests at its target. ``stopped``: an axis rests elsewhere.
    ``uncertain``: the position of an axis is not known."""
    words: str
    """The outcome in words."""
    steps: tuple[Optional[int], ...]
    """The positions of its axes in steps; ``None`` if not known."""
    positions: tuple[Optional[float], ...]
    """The positions in the unit of each axis."""
    reason: Optional[str] = None
    """The cause of a stop before the end: ``switch``, ``stop``, ``timeout``, …"""

    @property
    def position(self) -> Optional[float]:
        """The position of its first axis, in the unit of that axis."""
        return self.positions[0] if self.positions else None

    def __bool__(self) -> bool:
        return self.kind == "reached"


class Move:
    """A motion in progress: wait for it, await it, change it or stop it.

    The end of a ``with`` block stops it.
    """

    def __init__(self, line: Line, axes: tuple[Axis, ...], order: Order, endless: bool = False):
        self._line = line
        self._axes = axes
        self._order = order
        self._endless = endless
        self._stopped_here = False

    def _begun(self) -> Move:
        """Waits until the motion has begun. Raises the reason if it does not."""
        try:
            self._order.begun()
        except BaseException:
            # It may be about to begin.
            self._line.brake()
            raise
        answer = self._order.answer()
        if answer is not None:
            self._line.check_answer(answer)
        return self

    @property
    def done(self) -> bool:
        """Whether the motion has ended or is lost."""
        return self._order.answer() is not None

    @property
    def outcome(self) -> Optional[Outcome]:
        """The outcome; ``None`` while the motion is in progress.

        Raises ``LinkLost`` if it will never be known.
        """
        answer = self._order.answer()
        if answer is None:
            return None
        return self._outcome(self._line.check_answer(answer)["ended"])

    def _outcome(self, end: dict[str, Any]) -> Outcome:
        ends: list[dict[str, Any]] = end.get("axes", [])
        steps = tuple(one["position"] for one in ends)
        known = {axis.number: axis.scale for axis in self._axes}
        scales = [known[one["axis"]] for one in ends]
        places = tuple(
            None if at is None else at / scale.unit[1] for at, scale in zip(steps, scales)
        )
        kind, words = str(end["outcome"]), str(end["words"])
        stops = [one["stop"]["name"] for one in ends if one.get("stop")]
        reason = stops[0] if stops else None
        if self._endless and kind == "stopped" and reason == "stop" and self._ends_here():
            kind, words, reason = "reached", "the run has ended", None
        return Outcome(kind, words, steps, places, reason)

    def _ends_here(self) -> bool:
        """Whether its time or this object has ended a run."""
        return self._stopped_here or self._order.timed

    def _checked(self) -> Outcome:
        outcome = self.outcome
        assert outcome is not None
        if outcome or self._stopped_here and outcome.kind != "uncertain":
            return outcome
        raise (Stopped if outcome.kind == "stopped" else Uncertain)(outcome)

    def wait(self, timeout: Optional[float] = None) -> Outcome:
        """Waits until the motion has ended, and returns the outcome.

        Other threads run meanwhile. Raises ``Stopped`` if an axis rests elsewhere, ``Uncertain``
        if a position is not known, ``LinkLost`` if the board is lost, and ``TimeoutError`` after
        ``timeout`` seconds, while the motion goes on. Ctrl-C brakes.
        """
        try:
            ended = self._order.wait(timeout)
        except BaseException:
            self._line.brake()
            raise
        if not ended:
            raise TimeoutError(f"it goes on after {timeout} s")
        return self._checked()

    def stop(self) -> Outcome:
        """Brakes along the ramp, waits for rest, and returns the outcome.

        Raises ``Uncertain`` if a position is not known.
        """
        if not self.done:
            self._stopped_here = True
            for axis in self._axes:
                self._line.ask("stop", axis=axis.number)
            self._order.wait()
        return self._checked()

    def retarget(self, position: Quantity, unit: Optional[str] = None) -> Move:
        """Changes the target during the motion. Raises ``Refused`` if the motion has ended."""
        axis = self._single("other target")
        self._line.ask("retarget", axis=axis.number, to=axis._steps(position, unit))
        return self

    def set_speed(self, speed: Quantity, unit: Optional[str] = None) -> Move:
        """Changes the top speed during the motion. Raises ``Refused`` if the motion has ended."""
        axis = self._single("other speed")
        top = axis._rate("speed", speed, unit)
        self._line.ask("retarget", axis=axis.number, top_speed=top)
        return self

    def _single(self, what: str) -> Axis:
        if self.done:
            # Another order may be moving its axis now, and must not be changed.
            raise Refused("this motion has ended", remedy="give the next order to its axis")
        if len(self._axes) != 1:
            raise ValueError(f"a line of several axes takes no {what}: stop it")
        return self._axes[0]

    async def _finish(self) -> Outcome:
        loop = asyncio.get_running_loop()
        ended: asyncio.Future[None] = loop.create_future()

        def end() -> None:
            if not ended.done():
                ended.set_result(None)

        self._order.when_ended(lambda: loop.call_soon_threadsafe(end))
        try:
            await ended
        except BaseException:
            # A caller that no longer waits for a motion no longer wants it.
            self._line.brake()
            raise
        return self._checked()

    def __await__(self) -> Generator[Any, None, Outcome]:
        return self._finish().__await__()

    def __enter__(self) -> Move:
        return self

    def __exit__(
        self,
        kind: Optional[Type[BaseException]],
        value: Optional[BaseException],
        trace: Optional[TracebackType],
    ) -> None:
        if kind is None:
            self.stop()
        elif not self.done:
            self._line.brake()

    def __repr__(self) -> str:
        axes = ", ".join(str(axis.number) for axis in self._axes)
        answer = self._order.answer()
        if answer is None:
            return f"<Move of axis {axes}, on its way>"
        body = json.loads(answer[1])
        words = self._outcome(body["ended"]).words if body.get("ended") else body.get("what")
        return f"<Move of axis {axes}: {words}>"
