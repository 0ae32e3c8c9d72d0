"""The exceptions, one for each kind of error."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Optional

if TYPE_CHECKING:
    from ._move import Outcome


class StepwrightError(Exception):
    """The base of all errors of a board or of this package."""


class Refused(StepwrightError):
    """An order was refused, and nothing moves by it.

    ``what`` is wrong, what is ``allowed``, and a ``remedy``.
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
    """A value is outside its range. ``allowed`` is the range."""


class Ended(StepwrightError):
    """A motion has not ended at its target. ``outcome`` says where, and why."""

    def __init__(self, outcome: Outcome):
        super().__init__(outcome.words)
        self.outcome = outcome

    def __reduce__(self) -> tuple[type[Ended], tuple[Outcome]]:
        # Pickles the outcome too: another process may raise the exception than the one that handles it.
        return (type(self), (self.outcome,))


class Stopped(Ended):
    """An axis rests before its target. ``reason`` is the cause of the stop, ``position`` the place."""

    @property
    def reason(self) -> Optional[str]:
        """The board's name of the cause: ``switch``, ``stop``, ``timeout``, …"""
        return self.outcome.reason

    @property
    def position(self) -> Optional[float]:
        """The position at rest, in the unit of the axis."""
        return self.outcome.position


class Uncertain(Ended):
    """The position of an axis is not known: a kill or a reset may have lost steps."""


class LinkLost(StepwrightError, ConnectionError):
    """The board does not answer, or its line is lost. A motor may be moving."""


class CantOpen(StepwrightError, OSError):
    """No board can be reached at this port."""


def declined(status: int, body: dict[str, Any]) -> StepwrightError:
    """The exception for a refusal."""
    what, allowed, remedy = str(body["what"]), body.get("allowed"), body.get("do")
    if status == 503:
        return LinkLost(f"{what}; {remedy}" if remedy else what)
    kind = OutOfRange if status in (400, 422) else Refused
    return kind(what, allowed, remedy)
