"""The line to a board's thread. The axes and moves of the board share it."""

from __future__ import annotations

import json
from operator import index
from typing import Any, Callable, Optional, Union

from ._errors import CantOpen, LinkLost, StepwrightError, declined
from ._native import LOST, Kept, Order


def place_of(axis: Union[int, str], count: int) -> int:
    """The index of an axis, counted from 0, by its number or its letter."""
    try:
        # Whole numbers of numpy, too.
        number = {"x": 1, "y": 2, "z": 3}[axis.lower()] if isinstance(axis, str) else index(axis)
    except (KeyError, TypeError):
        number = 0
    if isinstance(axis, bool) or not 1 <= number <= count:
        raise IndexError(f"there is no axis {axis!r}: give 1 to {count}")
    return number - 1


class Line:
    """The line to the thread of a board.

    When nobody holds the line any more, the thread brakes all axes and ends.
    """

    def __init__(self, kept: Kept):
        self.kept = kept
        self.lost = False
        """Whether an exception has told the program that the board is lost."""
        met = kept.meet()
        if met is not None:
            failed = declined(met[0], json.loads(met[1]))
            raise CantOpen(str(failed)) if isinstance(failed, LinkLost) else failed
        self.name = str(self.sheet()["name"])

    def state(self) -> dict[str, Any]:
        """The state of the board at the last look."""
        state: dict[str, Any] = json.loads(self.kept.state())
        return state

    def sheet(self) -> dict[str, Any]:
        """The description of the board."""
        sheet: dict[str, Any] = json.loads(self.kept.sheet())
        return sheet

    def check_answer(self, answer: tuple[int, str]) -> dict[str, Any]:
        """The result of an order. Raises the exception of a refusal."""
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
        """Gives an order. Its answer comes at its end."""
        return self.kept.ask(name, json.dumps(body), True, seconds)

    def ask(self, asked: str, **body: Any) -> None:
        """Gives an order that is carried out at once."""
        order = self.kept.ask(asked, json.dumps(body))
        order.wait()
        answer = order.answer()
        if answer is not None:
            self.check_answer(answer)

    def sleep(self, seconds: float) -> None:
        """Lets time pass on the board. An interrupt brakes all axes."""
        try:
            self.kept.sleep(seconds)
        except BaseException:
            self.brake()
            raise

    def rest(self, rests: Callable[[], bool]) -> None:
        """Waits until ``rests()`` is true."""
        while not rests():
            self.check()
            self.sleep(0.01)

    def brake(self) -> None:
        """Brakes all axes after an error. Further errors are ignored."""
        try:
            self.kept.ask("stop", "{}").wait(1.0)
        except (StepwrightError, RuntimeError):
            pass

    def close(self) -> None:
        """Brakes all axes, waits until they rest, and ends the thread."""
        ended = self.kept.close()
        if ended is not None:
            self.check_answer(ended)
