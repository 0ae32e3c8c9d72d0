"""A plan as a figure of matplotlib."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ._plan import Plan

_COLOURS = ("#1f5fa8", "#b3471f")
"""Of the speed and the acceleration, on white."""


def draw(plan: Plan) -> Any:
    """Speed and acceleration over time and over steps."""
    pyplot = importlib.import_module("matplotlib.pyplot")
    figure, panels = pyplot.subplots(2, 2, sharex="col", figsize=(10, 6), layout="constrained")
    rows = (("Speed", "/s", plan.speeds), ("Acceleration", "/s²", plan.accelerations))
    for row, (name, per, values) in enumerate(rows):
        for column, x in enumerate((plan.times, range(1, plan.pulses + 1))):
            panel = panels[row][column]
            panel.plot(x, values, color=_COLOURS[row], linewidth=1.5)
            panel.grid(True, color="#dddddd", linewidth=0.6)
            panel.spines[["top", "right"]].set_visible(False)
        panels[row][0].set_ylabel(f"{name}, {plan.unit}{per}")
    panels[1][0].set_xlabel("time, s")
    panels[1][1].set_xlabel("step")
    figure.suptitle(f"{plan.law.capitalize()}, {plan.pulses} steps, {plan.duration:.4g} s")
    return figure
