"""A plan as a figure of matplotlib."""

from __future__ import annotations

import importlib
import io
from typing import TYPE_CHECKING, Any, Callable, Optional

from ._native import PHASES

if TYPE_CHECKING:
    from ._plan import Plan
    from ._run import Run

_COLOURS = ("#1d5fc4", "#d4550f", "#128a63", "#7a4a9c", "#8a6d00", "#00808a", "#a0325f", "#555555")
"""The colours of curves. Those of the command's plots come first."""
_GREY = "#6b7280"
_SHADES = {
    "up": "#edf6ef",
    "cruise": None,
    "down": "#fdf1e6",
    "jerk-up": "#eff1fa",
    "jerk-down": "#eff1fa",
}
"""The background of the phases of a travel."""


def _look(panel: Any) -> Any:
    """Styles a panel like the command's plots."""
    panel.grid(True, axis="y", color="#e2e5ea", linewidth=0.8)
    panel.set_axisbelow(True)
    panel.spines[["top", "right", "left"]].set_visible(False)
    panel.spines["bottom"].set_color("#9aa1ad")
    panel.tick_params(colors=_GREY, length=0)
    return panel


def png(draw: Callable[[], Any]) -> Optional[bytes]:
    """A figure as PNG; ``None`` without matplotlib."""
    try:
        figure = draw()
    except ImportError:
        return None
    picture = io.BytesIO()
    figure.savefig(picture, format="png", dpi=100)
    importlib.import_module("matplotlib.pyplot").close(figure)
    return picture.getvalue()


def draw_run(run: Run) -> Any:
    """Positions, speeds and the power of a laser over time. With two motors or more, also the way of the
    first two."""
    pyplot = importlib.import_module("matplotlib.pyplot")
    figure = pyplot.figure(figsize=(10, 5), layout="constrained")
    moved = [number for number, way in enumerate(run) if len(way) > 1]
    columns = 2 if len(run.names) > 1 else 1
    rows = 2 if run.laser is None else 3
    grid = figure.add_gridspec(rows, columns)
    places = _look(figure.add_subplot(grid[0, 0]))
    speeds = _look(figure.add_subplot(grid[1, 0], sharex=places))
    for number in moved:
        way, colour = run[number + 1], _COLOURS[number % len(_COLOURS)]
        places.plot(way.times, way.positions, color=colour, label=run.names[number])
        speeds.plot(way.times, way.speeds, color=colour, linewidth=1.0)
    places.set_ylabel(f"position, {run.unit}")
    speeds.set_ylabel(f"speed, {run.unit}/s")
    lowest = speeds
    if run.laser is not None:
        lowest = _look(figure.add_subplot(grid[2, 0], sharex=places))
        powers = [100 * power for power in run.laser.powers]
        lowest.step(run.laser.times, powers, where="post", color=_COLOURS[0], linewidth=1.0)
        lowest.set_ylabel("laser, %")
    lowest.set_xlabel("time, s")
    if moved:
        places.legend(frameon=False)
    if columns == 2:
        numpy = importlib.import_module("numpy")
        x, y = run[1], run[2]
        times = numpy.union1d(x.times, y.times)
        xy = [
            way.positions[numpy.searchsorted(way.times, times, side="right") - 1] for way in (x, y)
        ]
        panel = _look(figure.add_subplot(grid[:, 1]))
        panel.plot(*xy, color=_COLOURS[0], linewidth=1.0)
        panel.set_aspect("equal", adjustable="datalim")
        panel.set_xlabel(f"{run.names[0]}, {run.unit}")
        panel.set_ylabel(f"{run.names[1]}, {run.unit}")
    return figure


def _phases(plan: Plan) -> list[tuple[str, int, int]]:
    """The phases of a plan in their order, each with its first and its last pulse, counted from 0."""
    found: list[tuple[str, int, int]] = []
    for pulse, phase in enumerate(plan.phases.tolist()):
        name = PHASES[phase]
        if found and found[-1][0] == name:
            found[-1] = (name, found[-1][1], pulse)
        else:
            found.append((name, pulse, pulse))
    return found


def draw(plan: Plan) -> Any:
    """Speed and acceleration over time and over steps, and the jerk of an S-curve, as the command
    draws them."""
    pyplot = importlib.import_module("matplotlib.pyplot")
    rows = [("Speed", "/s", plan.speeds), ("Acceleration", "/s²", plan.accelerations)]
    if plan.law == "s-curve":
        rows.append(("Jerk", "/s³", plan.jerks))
    high = 1.5 + 2.6 * len(rows)
    figure, panels = pyplot.subplots(
        len(rows), 2, sharex="col", squeeze=False, figsize=(11, high), layout="constrained"
    )
    scales = (plan.times, [pulse + 1 for pulse in range(plan.pulses)])
    phases = _phases(plan)
    for row, (name, per, values) in enumerate(rows):
        for panel, x in zip(panels[row], scales):
            _look(panel)
            panel.set_title(f"{name}, {plan.unit}{per}", loc="left", fontsize=10, fontweight="bold")
            for phase, first, last in phases:
                if _SHADES[phase] is not None:
                    panel.axvspan(x[first], x[last], color=_SHADES[phase], zorder=0)
            panel.fill_between(x, values, color=_COLOURS[row], alpha=0.1, linewidth=0)
            panel.plot(x, values, color=_COLOURS[row], linewidth=1.6)
            panel.margins(x=0)
    for panel, words in zip(panels[-1], ("time, s", "step")):
        panel.set_xlabel(words)
    name = plan.law[:1].upper() + plan.law[1:]
    facts = (
        f"duration {plan.duration:.4g} s  ·  peak speed {plan.peak:.6g} {plan.unit}/s  ·  braking "
        f"{plan.braking} steps  ·  largest error {plan.worst_error:.2f} ticks of {plan.timer_hz} Hz"
    )
    figure.suptitle(f"{name}, {plan.pulses} steps\n\n", x=0.01, ha="left", fontweight="bold")
    figure.text(0.01, 1 - 0.36 / high, facts, ha="left", va="top", fontsize=9, color=_GREY)
    return figure
