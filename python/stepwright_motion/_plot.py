"""A plan as a figure of matplotlib."""

from __future__ import annotations

import importlib
import io
from typing import TYPE_CHECKING, Any, Callable, Optional

if TYPE_CHECKING:
    from ._plan import Plan
    from ._run import Run

_COLOURS = ("#1f5fa8", "#b3471f", "#3b7d3b", "#7a4a9c", "#8a6d00", "#00808a", "#a0325f", "#555555")
"""Of curves, on white: those of the command's plots."""


def _panel(panel: Any) -> Any:
    panel.grid(True, color="#dddddd", linewidth=0.6)
    panel.spines[["top", "right"]].set_visible(False)
    return panel


def png(draw: Callable[[], Any]) -> Optional[bytes]:
    """A figure as a picture; none without matplotlib."""
    try:
        figure = draw()
    except ImportError:
        return None
    picture = io.BytesIO()
    figure.savefig(picture, format="png", dpi=100)
    importlib.import_module("matplotlib.pyplot").close(figure)
    return picture.getvalue()


def draw_run(run: Run) -> Any:
    """Positions and speeds over time; of two motors and more the way of the first two."""
    pyplot = importlib.import_module("matplotlib.pyplot")
    figure = pyplot.figure(figsize=(10, 5), layout="constrained")
    moved = [number for number, way in enumerate(run) if len(way) > 1]
    columns = 2 if len(run.names) > 1 else 1
    grid = figure.add_gridspec(2, columns)
    places = _panel(figure.add_subplot(grid[0, 0]))
    speeds = _panel(figure.add_subplot(grid[1, 0], sharex=places))
    for number in moved:
        way, colour = run[number + 1], _COLOURS[number % len(_COLOURS)]
        places.plot(way.times, way.positions, color=colour, label=run.names[number])
        speeds.plot(way.times, way.speeds, color=colour, linewidth=1.0)
    places.set_ylabel(f"position, {run.unit}")
    speeds.set_ylabel(f"speed, {run.unit}/s")
    speeds.set_xlabel("time, s")
    if moved:
        places.legend(frameon=False)
    if columns == 2:
        numpy = importlib.import_module("numpy")
        x, y = run[1], run[2]
        times = numpy.union1d(x.times, y.times)
        xy = [
            way.positions[numpy.searchsorted(way.times, times, side="right") - 1] for way in (x, y)
        ]
        panel = _panel(figure.add_subplot(grid[:, 1]))
        panel.plot(*xy, color=_COLOURS[0], linewidth=1.0)
        panel.set_aspect("equal", adjustable="datalim")
        panel.set_xlabel(f"{run.names[0]}, {run.unit}")
        panel.set_ylabel(f"{run.names[1]}, {run.unit}")
    return figure


def draw(plan: Plan) -> Any:
    """Speed and acceleration over time and over steps."""
    pyplot = importlib.import_module("matplotlib.pyplot")
    figure, panels = pyplot.subplots(2, 2, sharex="col", figsize=(10, 6), layout="constrained")
    rows = (("Speed", "/s", plan.speeds), ("Acceleration", "/s²", plan.accelerations))
    for row, (name, per, values) in enumerate(rows):
        for column, x in enumerate((plan.times, range(1, plan.pulses + 1))):
            panel = _panel(panels[row][column])
            panel.plot(x, values, color=_COLOURS[row], linewidth=1.5)
        panels[row][0].set_ylabel(f"{name}, {plan.unit}{per}")
    panels[1][0].set_xlabel("time, s")
    panels[1][1].set_xlabel("step")
    figure.suptitle(f"{plan.law.capitalize()}, {plan.pulses} steps, {plan.duration:.4g} s")
    return figure
