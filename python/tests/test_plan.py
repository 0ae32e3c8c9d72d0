"""Plans, compared with those of the command."""

from __future__ import annotations

import array
import json
import math
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
import seeded
from conftest import COMMAND

import stepwright_motion as sw

OPTIONS = {"speed": "--top-speed", "first": "--c0"}


TRAVELS = int(os.environ.get("STEPWRIGHT_TRAVELS", "1000"))
"""The number of travels of each law, the same as on the chips. Each travel starts the command."""


def by_the_command(law: str, values: dict[str, Any]) -> tuple[int, str, str]:
    """The result of ``stepwright plan`` as CSV."""
    words = [COMMAND, "plan", law, "--format", "csv"]
    for name, value in values.items():
        option = OPTIONS.get(name, f"--{name.replace('_', '-')}")
        words += [option, str(value)]
    ran = subprocess.run(words, capture_output=True, text=True, env={"STEPWRIGHT_MACHINE": "none"})
    return ran.returncode, ran.stdout, ran.stderr


@pytest.mark.parametrize("law", seeded.TAKES)
def test_travels_are_those_of_the_command(law: str) -> None:
    travels = [seeded.travel(law, number) for number in range(TRAVELS)]
    refused = 0
    with ThreadPoolExecutor(2) as pool:
        answers = pool.map(lambda values: by_the_command(law, values), travels)
        for values, (status, said, why) in zip(travels, answers):
            if status != 0:
                refused += 1
                with pytest.raises(ValueError):
                    sw.plan(law, **values)
                continue
            # The csv module would take longer than the command.
            head, *rows = (line.split(",") for line in said.splitlines())
            columns = dict(zip(head, zip(*rows)))
            plan = sw.plan(law, **values)
            assert plan.pulses == len(rows), values
            assert plan.delays.tolist() == [int(delay) for delay in columns["delay"]], values
            assert plan.ticks.tolist() == [int(time) for time in columns["time"]], values
            assert plan.speeds.tolist() == [float(speed) for speed in columns["speed"]], values
            names = [sw.PHASES[phase] for phase in plan.phases.tolist()]
            assert names == list(columns["phase"]), values
    assert refused <= TRAVELS // 10, f"{refused} of the travels were none"


def test_what_the_arrays_say_fits_together() -> None:
    numpy = pytest.importorskip("numpy")
    plan = sw.plan("trapezoid", 2000, accel=2000, speed=1000)
    assert plan.duration == pytest.approx(2.5, rel=1e-3)
    assert plan.duration == pytest.approx(plan.times[-1], rel=1e-12)
    assert plan.peak == pytest.approx(1000) and plan.worst_error <= 1
    assert numpy.abs(plan.times - plan.ideal_times).max() <= 1.01e-6
    assert (len(plan), plan.positions[0], plan.positions[-1]) == (2000, 1, 2000)
    up = plan.phases == sw.PHASES.index("up")
    assert plan.accelerations[up][20:-5] == pytest.approx(2000, rel=0.02)
    curve = sw.plan("s-curve", 2000, accel=4000, speed=1000, jerk=80_000)
    # Without the ends, where a step takes long.
    assert numpy.median(numpy.abs(curve.jerks[curve.phases == 3])) == pytest.approx(80_000, rel=0.1)
    in_mm = sw.plan("trapezoid", "25mm", accel="500mm/s2", speed="50mm/s", mm_per_rev=40)
    assert (in_mm.pulses, in_mm.unit, in_mm.positions[-1]) == (125, "mm", 25)
    assert in_mm.peak == pytest.approx(50)


def test_mistakes_are_told() -> None:
    for law, steps, values, why in [
        ("parabola", 10, {}, "there is no law"),
        ("trapezoid", 10, {}, "needs accel"),
        ("trapezoid", -10, {"accel": 5, "speed": 5}, "0 to 2147483647"),
        ("trapezoid", 10, {"accel": "5mm/s2", "speed": 5}, "mm"),
        ("trapezoid", 10, {"accel": 5, "speed": "fast"}, "speed = 'fast'"),
        ("power", 10, {"accel": 5, "speed": 5, "power": 1}, "^power is 1: give a whole number, 2 to 9$"),
        ("power", 10, {"accel": 5, "speed": 5, "power": 300}, "^power is 300: give .* 2 to 9$"),
        ("power", 10, {"accel": 5, "speed": 5, "power": 2.5}, "^power is 2.5: give a whole number"),
        ("piecewise", 10, {"accel": 5, "speed": 5, "breaks": 17}, "^breaks is 17: give .* 0 to 16$"),
        ("ramp", 10, {"speed": 5, "ramp": -1}, "^ramp is -1: give a whole number, 1 to 65535$"),
        ("ramp", 10, {"speed": 5, "ramp": 2**70}, f"^ramp is {2**70}: give a whole number"),
        ("linear-factor", 10, {"accel": 5, "speed": 5, "knee": math.nan}, "^knee is nan: give a finite"),
        ("linear-factor", 10, {"accel": 5, "speed": 5, "knee": 1}, "^knee is 1: it may be 0 to 0.9"),
        ("austin-fixed", 10, {"c0": 0, "c_min": 5}, "^c0 is 0: give a whole number, 1 to 2147483647$"),
        ("austin-fixed", 10, {"c0": 5, "c_min": -2}, "^c_min is -2: give a whole number"),
        ("austin", 10, {"accel": 5, "speed": 5, "changes": [(-1, 5)]}, "^changes is -1: give a whole"),
        ("austin", 10, {"accel": 5, "speed": 5, "first": 5}, "^first is '5': it may be"),
        ("austin", 10, {"accel": 5, "speed": 5, "first": "c2"}, "exact, 0.676, c1"),
        ("trapezoid", 10, {"accel": 5, "speed": 5, "timer_hz": 5}, "^timer_hz is 5: give .* 100000 to 200000000$"),
        ("trapezoid", 10, {"accel": 5, "speed": 5, "timer_hz": -1}, "^timer_hz is -1: give a whole"),
        ("trapezoid", 10, {"accel": 5, "speed": 5, "timer_hz": 2**33}, f"^timer_hz is {2**33}: give"),
        ("trapezoid", 100_000, {"accel": 1e8, "speed": 1e6, "timer_hz": 100_000}, "step"),
    ]:
        with pytest.raises(ValueError, match=why):
            sw.plan(law, steps, **values)  # type: ignore[arg-type]


def test_numbers_of_numpy_are_numbers_of_a_law() -> None:
    np = pytest.importorskip("numpy")
    plan = sw.plan("ramp", np.int32(90), speed=900, ramp=np.int64(30), timer_hz=np.uint32(2_000_000))
    assert plan.delays.tolist() == sw.plan("ramp", 90, speed=900, ramp=30, timer_hz=2_000_000).delays.tolist()
    changes = [(np.int64(40), np.float64(500.5))]
    sw.plan("austin", 200, accel=1000, speed=900, changes=changes)
    sw.plan("linear-factor", 90, accel=1000, speed=900, knee=np.float32(0.5))


def test_a_plan_is_drawn(tmp_path: Path) -> None:
    plan = sw.plan("s-curve", 2000, accel=4000, speed=1000, jerk=80_000)
    assert plan._repr_svg_().startswith("<svg") and "S-curve" in plan._repr_svg_()
    for ending in ("svg", "png", "html"):
        plan.plot(f"{tmp_path}/plan.{ending}")
        assert (tmp_path / f"plan.{ending}").stat().st_size > 1000
    pytest.importorskip("matplotlib").use("Agg")
    figure = plan.plot()
    assert len(figure.axes) == 6  # the jerk, too
    assert len(sw.plan("ramp", 90, speed=900, start_speed=50, ramp=30).plot().axes) == 4
    line = figure.axes[0].lines[0]
    assert line.get_ydata().tolist() == plan.speeds.tolist()


JOB = "G0 X10\nG1 X30 Y5 F1200\nG3 X10 I-10\nG4 P0.5\nG0 X0 Y0\n"


def test_a_job_is_planned_as_by_the_command(tmp_path: Path) -> None:
    path = tmp_path / "part.nc"
    path.write_text(JOB)
    plan = sw.gcode(path).plan()
    words = [COMMAND, "gcode", str(path), "--plan", "--format", "json"]
    said = subprocess.run(
        words, capture_output=True, text=True, check=True, env={"STEPWRIGHT_MACHINE": "none"}
    )
    assert plan.facts() == json.loads(said.stdout)
    assert plan.duration == pytest.approx(plan.facts()["seconds"]) and plan.duration > 3
    assert plan.extents["x"][0] == 0 and plan.lines == 5 and plan.refused is None
    assert plan.corners and plan.corners[0].cost > 0
    assert "part.nc" in str(plan) and "part.nc" in plan._repr_html_()
    slow = sw.gcode(path).plan(speed={"x": 10, "y": "10mm/s", "z": 10})
    assert slow.duration > plan.duration
    assert plan.facts().get("laser_on_s") is None
    path.write_text("M4 S300\n" + JOB)
    plan = sw.gcode(path).plan(jerk={"x": 10_000, "y": "10000mm/s3", "z": None}, laser=200)
    asked = ["--jerk", "10000mm/s3,10000mm/s3,0", "--laser", "--laser-max", "200"]
    said = subprocess.run(
        [*words, *asked], capture_output=True, text=True, check=True, env={"STEPWRIGHT_MACHINE": "none"}
    )
    assert plan.facts() == json.loads(said.stdout)
    assert plan.duration > sw.gcode(path).plan(laser=200).duration and plan.facts()["laser_on_s"] > 1
    for wrong in (0, -1, 1e7, float("nan")):
        with pytest.raises(ValueError, match="^laser is .*: S of full power may be 0.001 to 1000000"):
            sw.gcode(path).plan(laser=wrong)
    with pytest.raises(TypeError, match=r"^laser is \[\]: give S of full power, or None"):
        sw.gcode(path).plan(laser=[])  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="jerk"):
        sw.gcode(path).plan(jerk="5mm/s2")
    path.write_text("G0 X10\nG1 X\n")
    with pytest.raises(ValueError, match="part.nc:2:"):
        sw.gcode(path).plan()
    with pytest.raises(OSError, match="nowhere"):
        sw.gcode("nowhere.nc").plan()


def test_without_numpy_arrays_are_views_of_the_same_numbers() -> None:
    program = (
        "import sys; sys.modules['numpy'] = None\n"
        "import stepwright_motion as sw\n"
        "plan = sw.plan('trapezoid', 300, accel=2000, speed=1000)\n"
        "print(list(plan.delays), list(plan.ticks), list(plan.times)[-1] == plan.duration)\n"
        "with sw.virtual(fast=True) as board, board.record() as log:\n"
        "    board.x.steps_per_mm = 80\n"
        "    board.x.move_to(10).wait()\n"
        "print(log.x.position[-1], len(log.x.time) == len(log.x.state))\n"
    )
    ran = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert ran.returncode == 0, ran.stderr
    plan = sw.plan("trapezoid", 300, accel=2000, speed=1000)
    delays, ticks = array.array("I", plan.delays).tolist(), array.array("Q", plan.ticks).tolist()
    assert ran.stdout == f"{delays} {ticks} True\n10.0 True\n"


def test_changes_have_no_divisor() -> None:
    changes = [(100, 2000)]
    sw.plan("austin", 1000, accel=1000, speed=1000, changes=changes)
    with pytest.raises(ValueError, match="divisor or changes, not both"):
        sw.plan("austin", 1000, accel=1000, speed=1000, changes=changes, divisor="2n")
