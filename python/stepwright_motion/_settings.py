"""The settings of a board, as attributes."""

from __future__ import annotations

import operator
from typing import TYPE_CHECKING, Any, Iterator

if TYPE_CHECKING:
    from ._line import Line


class Settings:
    """The settings of a board. An Uno, a Nano and a Mega keep them without power.

    ``board.settings.max_speed`` reads a setting, ``board.settings.max_speed = 20000`` sets it, and
    ``print(board.settings)`` describes all.
    """

    _line: Line

    def __init__(self, line: Line):
        object.__setattr__(self, "_line", line)

    def _all(self) -> dict[str, dict[str, Any]]:
        return {one["name"].replace("-", "_"): one for one in self._line.sheet()["settings"]}

    def _one(self, name: str) -> dict[str, Any]:
        try:
            return self._all()[name]
        except KeyError:
            raise AttributeError(f"the board has no setting {name}") from None

    def __getattr__(self, name: str) -> int:
        if name.startswith("_"):
            raise AttributeError(name)
        return int(self._one(name)["value"])

    def __setattr__(self, name: str, value: int) -> None:
        one = self._one(name)
        try:
            whole = operator.index(value)
        except TypeError:
            range_of = f"{one['min']} to {one['max']} {one['unit']}".rstrip()
            raise TypeError(f"{name} is {value!r}: give a whole number, {range_of}") from None
        self._line.ask("set", name=one["name"], value=whole)

    def describe(self, name: str) -> str:
        """What a setting does, and its range."""
        one = self._one(name)
        unit = f" {one['unit']}" if one["unit"] else ""
        return f"{one['help']}: {one['min']} to {one['max']}{unit} [default: {one['default']}]"

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._all()]

    def __iter__(self) -> Iterator[str]:
        return iter(self._all())

    def __repr__(self) -> str:
        rows = [f"{name} = {one['value']}" for name, one in self._all().items()]
        wide = max(map(len, rows), default=0)
        return "\n".join(f"{row:<{wide}}  {self.describe(row.split()[0])}" for row in rows)

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><td><code>{name}</code></td><td>{one['value']} {one['unit']}</td>"
            f"<td>{one['help']}</td></tr>"
            for name, one in self._all().items()
        )
        return f"<table>{rows}</table>"
