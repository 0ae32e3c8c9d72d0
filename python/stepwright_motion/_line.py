"""The line to a board's thread, which its axes and moves share."""

from __future__ import annotations

import json
from operator import index
from typing import Any, Callable, Optional, Union

from ._errors import CantOpen, LinkLost, StepwrightError, declined
from ._native import LOST, Kept, Order


def place_of(axis: Union[int, str], count: int) -> int:
    """The place of an axis, from 0, by its number or its letter."""
    try:
        # numpy's whole numbers, too.
        number = {"x": 1, "y": 2, "z": 3}[axis.lower()] if isinstance(axis, str) else index(axis)
    except (KeyError, TypeError):
        number = 0
    if isinstance(axis, bool) or not 1 <= number <= count:
        raise IndexError(f"there is no axis {axis!r}: give 1 to {count}")
    return number - 1


class Line:
    """The line to the thread of a board that was met.

    When nobody holds it any more, the thread brakes everything and ends.
    """

    def __init__(self, kept: Kept):
        self.kept = kept
        self.lost = False
        """Whether the program has heard that the board is lost."""
        met = kept.meet()
        if met is not None:
            failed = declined(met[0], json.loads(met[1]))
            raise CantOpen(str(failed)) if isinstance(failed, LinkLost) else failed
        self.name = str(self.sheet()["name"])

    def state(self) -> dict[str, Any]:
        """What the board does, by the last look."""
        state: dict[str, Any] = json.loads(self.kept.state())
        return state

    def sheet(self) -> dict[str, Any]:
        """What the board is."""
        sheet: dict[str, Any] = json.loads(self.kept.sheet())
        return sheet

    def check_answer(self, answer: tuple[int, str]) -> dict[str, Any]:
        """What came of an order; raises what it was refused with."""
        status, body = answer[0], json.loads(answer[1])
        if status != 200:
            failed = declined(status, body)
            self.lost = self.lost or isinstance(failed, LinkLost)
            raise failed
        done: dict[str, Any] = body
        return done

    def check(self) -> None:
        """Raises ``LinkLost`` if the board is lost."""
        trouble = self.state()["trouble"]
        if trouble is not None:
            self.lost = True
            raise LinkLost(f"{trouble['what']}; {LOST}")

    def give(self, name: str, body: dict[str, Any], seconds: Optional[float] = None) -> Order:
        """Gives an order whose end will be waited for."""
        return self.kept.ask(name, json.dumps(body), True, seconds)

    def ask(self, asked: str, **body: Any) -> None:
        """Asks for something that is done at once."""
        order = self.kept.ask(asked, json.dumps(body))
        order.wait()
        answer = order.answer()
        if answer is not None:
            self.check_answer(answer)

    def sleep(self, seconds: float) -> None:
        """Lets time pass on the board; what interrupts it brakes everything."""
        try:
            self.kept.sleep(seconds)
        except BaseException:
            self.brake()
            raise

    def rest(self, rests: Callable[[], bool]) -> None:
        """Waits until this holds."""
        while not rests():
            self.check()
            self.sleep(0.01)

    def brake(self) -> None:
        """Brakes everything, for something has gone wrong; what else does is not said."""
        try:
            self.kept.ask("stop", "{}").wait(1.0)
        except (StepwrightError, RuntimeError):
            pass

    def close(self) -> None:
        """Brakes everything, waits until it rests, and ends the thread."""
        ended = self.kept.close()
        if ended is not None:
            self.check_answer(ended)
