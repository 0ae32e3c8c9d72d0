"""What can go wrong, a kind each."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Optional

if TYPE_CHECKING:
    from ._move import Outcome


class StepwrightError(Exception):
    """Whatever a board, or this package, has to say against something."""


class Refused(StepwrightError):
    """An order was not taken: nothing moves by it.

    ``what`` was wrong, what is ``allowed``, and what can be done (``remedy``).
    """

    def __init__(self, what: str, allowed: Optional[str] = None, remedy: Optional[str] = None):
        text = what
        if allowed:
            text += f" (allowed: {allowed})"
        if remedy:
            text += f"; {remedy}"
        super().__init__(text)
        self.what = what
        self.allowed = allowed
        self.remedy = remedy


class OutOfRange(Refused, ValueError):
    """A value is outside its range: ``allowed`` says which that is."""


class Ended(StepwrightError):
    """A motion has not ended where it was to: ``outcome`` says where, and why."""

    def __init__(self, outcome: Outcome):
        super().__init__(outcome.words)
        self.outcome = outcome

    def __reduce__(self) -> tuple[type[Ended], tuple[Outcome]]:
        # Pickled with its outcome: it may be raised in another process than the one that hears of it.
        return (type(self), (self.outcome,))


class Stopped(Ended):
    """An axis rests before its target: ``reason`` is what has stopped it, ``position`` where."""

    @property
    def reason(self) -> Optional[str]:
        """``switch``, ``stop``, ``timeout``, …: the name that the board has for it."""
        return self.outcome.reason

    @property
    def position(self) -> Optional[float]:
        """Where it rests, in the unit of its axis."""
        return self.outcome.position


class Uncertain(Ended):
    """It is not known where an axis is: a kill, or a reset, may have lost steps."""


class LinkLost(StepwrightError, ConnectionError):
    """The board does not answer, or its line is gone: a motor may be moving."""


class CantOpen(StepwrightError, OSError):
    """There is no board to be reached at this port."""


def declined(status: int, body: dict[str, Any]) -> StepwrightError:
    """The exception for an answer that is a refusal."""
    what, allowed, remedy = str(body["what"]), body.get("allowed"), body.get("do")
    if status == 503:
        return LinkLost(f"{what}; {remedy}" if remedy else what)
    kind = OutOfRange if status in (400, 422) else Refused
    return kind(what, allowed, remedy)
