"""Runs of files: jobs, cycles and paths, compared with those of the command."""

from __future__ import annotations

import bisect
import csv
import json
import math
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from conftest import COMMAND, Pty

import stepwright_motion as sw

EXAMPLES = Path(__file__).parents[2] / "examples"
CYCLES = ["calibrate", "drawing", "feed", "joined", "readme", "series", "triangle"]


def command(*words: str) -> str:
    """The output of the command."""
    env = {"STEPWRIGHT_MACHINE": "none"}
    return subprocess.run(
        [COMMAND, *words], capture_output=True, text=True, check=True, env=env
    ).stdout


def steps(said: str, name: str) -> tuple[list[float], list[int]]:
    """The times of a motor's steps in s and its positions, from the command's events."""
    rows = [row for row in csv.reader(said.splitlines()) if row[1:4] == [name, "step", "1"]]
    return [float(row[0]) / 1e6 for row in rows], [int(row[4]) for row in rows]


def test_a_job_makes_each_step_when_the_command_does() -> None:
    job = str(EXAMPLES / "gcode" / "badge.nc")
    run = sw.gcode(job).run()
    said: dict[str, Any] = json.loads(command("gcode", job, "--fast", "--format", "json"))
    assert run.duration == pytest.approx(said["seconds"], abs=1e-9)
    assert run.positions == pytest.approx(said["position_mm"], abs=1e-9)
    assert (run.late, run.braked, run.unit) == (0, False, "mm")
    assert run.duration == pytest.approx(sw.gcode(job).plan().duration, abs=1e-6)
    lead = said["lead_ticks"] / said["ticks_per_second"]
    events = command("gcode", job, "--fast", "--format", "csv")
    for number, name in enumerate("XYZ", 1):
        times, places = steps(events, name)
        assert len(times) > 100 and len(run[number]) == len(times) + 1
        assert run[name].times[1:].tolist() == pytest.approx([t - lead for t in times], abs=2e-9)
        assert [round(place * 80) for place in run[number].positions[1:]] == places


def test_a_laser_and_its_jerk_are_those_of_the_command(tmp_path: Path) -> None:
    job = str(EXAMPLES / "gcode" / "engrave.nc")
    run = sw.gcode(job).run(laser=1000, jerk="10000mm/s3")
    asked = ["gcode", job, "--fast", "--laser", "--jerk", "10000mm/s3"]
    said: dict[str, Any] = json.loads(command(*asked, "--format", "json"))
    assert run.duration == pytest.approx(said["seconds"], abs=1e-9)
    assert run.positions == pytest.approx(said["position_mm"], abs=1e-9)
    lead = said["lead_ticks"] / said["ticks_per_second"]
    rows = list(csv.reader(command(*asked, "--format", "csv").splitlines()))
    changes = [(float(row[0]) / 1e6 - lead, float(row[3])) for row in rows if row[1] == "laser"]
    assert run.laser is not None and len(run.laser) == len(changes) + 1 > 100
    assert (run.laser.times[0], run.laser.powers[0], run.laser.powers[-1]) == (0, 0, 0)
    assert run.laser.times[1:].tolist() == pytest.approx([time for time, _ in changes], abs=2e-6)
    assert run.laser.powers[1:].tolist() == pytest.approx([power for _, power in changes], abs=1e-4)
    run.save(tmp_path / "engrave.vcd")
    assert len(run.plot().axes) == 4
    # A spindle has no power signal, and the path rests for its changes.
    plain = sw.gcode(job).run()
    assert plain.laser is None and len(plain.plot().axes) == 3


@pytest.mark.parametrize("name", CYCLES)
def test_cycles_make_each_step_when_the_command_does(name: str) -> None:
    file = str(EXAMPLES / "cycles" / f"{name}.toml")
    run = sw.cycle(file).run()
    facts = json.loads(command("cycle", file, "--format", "json"))
    assert run.facts() == facts
    assert list(run.positions) == [motor["position"] for motor in facts["motors"]]
    assert run.names == [motor["name"] for motor in facts["motors"]]
    events = command("cycle", file, "--format", "csv")
    for motor in run.names:
        times, places = steps(events, motor)
        ours, at = run[motor].times[1:].tolist(), run[motor].positions.tolist()
        if name in ("calibrate", "drawing"):
            # Until a motor finds a switch its position is not known.
            found = next(place for place, time in enumerate(times) if time > 4.5)
            times, places = times[found:], places[found:]
            ours, at = ours[len(ours) - len(times) :], at[len(at) - len(places) - 1 :]
        assert len(times) > (5 if motor != "Z" else -1)
        assert ours == pytest.approx(times, abs=2e-9), motor
        # With a fixed tick a step is counted after its row.
        assert places in (at[1:], at[:-1]), motor


def test_edges_of_a_run_are_those_of_the_command(tmp_path: Path) -> None:
    file = str(EXAMPLES / "cycles" / "triangle.toml")
    sw.cycle(file).run().save(f"{tmp_path}/ours.vcd")
    command("cycle", file, "--vcd", f"{tmp_path}/theirs.vcd")

    def rises(path: Path) -> dict[str, int]:
        lines = path.read_text().splitlines()
        names = {line.split()[3]: line.split()[4] for line in lines if line.startswith("$var")}
        return {name: lines.count(f"1{sign}") for sign, name in names.items() if "step" in name}

    ours = rises(tmp_path / "ours.vcd")
    assert ours == rises(tmp_path / "theirs.vcd") and sum(ours.values()) > 1000
    for ending in ("csv", "mcap"):
        sw.cycle(file).run().save(f"{tmp_path}/ours.{ending}")
        assert (tmp_path / f"ours.{ending}").stat().st_size > 10_000


def test_a_path_is_the_job_of_its_lines(tmp_path: Path) -> None:
    places = [(0, 0), (30, 5), (30, 20, 3), (-4, 20, 3), (0, 0)]
    job = tmp_path / "path.nc"
    words = (" ".join(f"{axis}{at}" for axis, at in zip("XYZ", place)) for place in places[1:])
    job.write_text("G1 F2400\n" + "\n".join(words) + "\n")
    limits: dict[str, Any] = {"accel": 500, "jump": {"x": 2, "y": 3, "z": "1mm/s"}, "jerk": 8000}
    path = sw.path(places, feed="40mm/s", **limits)
    run = sw.gcode(job).run(**limits)
    # The last place of the path has no Z, which means 0; in the job Z stays.
    assert path.positions == (0, 0, 0) and run.positions == (0, 0, 3)
    path = sw.path([*places[:-1], (0, 0, 3)], feed="40mm/s", **limits)
    assert path.duration == pytest.approx(run.duration, abs=1e-6)
    assert path.duration > sw.path([*places[:-1], (0, 0, 3)], feed=40, **{**limits, "jerk": None}).duration
    for ours, theirs in zip(path, run):
        # A path is not rounded to ticks.
        assert ours.times.tolist() == pytest.approx(theirs.times.tolist(), abs=2e-7)
        assert ours.positions.tolist() == pytest.approx(theirs.positions.tolist(), abs=1e-9)
    assert path.x.speeds.max() == pytest.approx(40 * 30 / math.hypot(30, 5), rel=0.001)
    with pytest.raises(ValueError, match="one to three"):
        sw.path([(0, 0, 0, 0)])
    with pytest.raises(ValueError, match="one place"):
        sw.path([])
    with pytest.raises(ValueError, match="waypoint 1"):
        sw.path([(0, 0), (float("nan"), 1)])
    with pytest.raises(ValueError, match="steps_per_mm"):
        sw.path([(0, 0), (1, 1)], steps_per_mm=0)


def test_short_lines_within_a_tolerance_are_an_arc(tmp_path: Path) -> None:
    angles = [math.tau * n / 1_257 for n in range(1_258)]
    circle = [(round(20 * math.cos(a) - 20, 2), round(20 * math.sin(a), 2)) for a in angles]
    path = sw.path(circle, feed=100, tolerance=0.01)
    assert path.duration < 0.5 * sw.path(circle, feed=100).duration
    job = tmp_path / "circle.nc"
    job.write_text("G64 P0.01 G1 F6000\n" + "".join(f"X{x} Y{y}\n" for x, y in circle))
    assert path.duration == pytest.approx(sw.gcode(job).plan().duration, abs=1e-6)
    assert path.positions == (0, 0, 0)
    job.write_text("G1 F6000\n" + "".join(f"X{x} Y{y}\n" for x, y in circle))
    asked = sw.gcode(job).run(tolerance=0.01)
    assert path.duration == pytest.approx(asked.duration, abs=1e-6)
    for wrong in (-1, math.nan, 2000):
        with pytest.raises(ValueError, match="^tolerance is (-1|NaN|2000): it may be 0 to 1000 mm"):
            sw.gcode(job).plan(tolerance=wrong)
    for wrong in (-1, math.nan):
        with pytest.raises(ValueError, match=r"^tolerance is (-1|NaN): the tolerance must be 0, or"):
            sw.path(circle, tolerance=wrong)
    with pytest.raises(TypeError, match="^tolerance is None: give a number of mm"):
        sw.path(circle, tolerance=None)  # type: ignore[arg-type]


def test_what_can_not_be_played_says_why(tmp_path: Path) -> None:
    job = tmp_path / "part.nc"
    job.write_text("G1 F6000 X100\n")
    with pytest.raises(sw.Refused, match="in line 1 X comes to"):
        sw.gcode(job).run(steps_per_mm=3200)
    file = tmp_path / "there.toml"
    motor = '[[motor]]\nname = "X"\nstep = 1\nsmallest-delay-us = 500\nmax = 5\n'
    file.write_text(f"{motor}[[cycle]]\nmove.X = {{ steps = many }}\n")
    with pytest.raises(ValueError, match=r"there.toml:7"):
        sw.cycle(file).run()
    file.write_text(f"{motor}[[cycle]]\nmove.X = {{ steps = 10 }}\n")
    with pytest.raises(sw.Refused, match="soft-end") as refused:
        sw.cycle(file).run()
    assert "stop-motor" in (refused.value.remedy or "")
    with pytest.raises(OSError):
        sw.cycle(tmp_path / "none.toml").run()
    with pytest.raises(ConnectionError, match="nowhere"):
        sw.cycle(EXAMPLES / "cycles" / "readme.toml").run("/dev/nowhere")
    run = sw.cycle(EXAMPLES / "cycles" / "readme.toml").run()
    with pytest.raises(KeyError, match="no motor"):
        run["other"]
    with pytest.raises(IndexError):
        run[9]


SLOW = """
import sys
import stepwright_motion as sw
print("runs", flush=True)
{0}.run(fast=False)
"""


@pytest.mark.parametrize("kind", ["job", "cycle"])
def test_ctrl_c_ends_a_run_in_real_time(kind: str) -> None:
    badge, feed = str(EXAMPLES / "gcode" / "badge.nc"), str(EXAMPLES / "cycles" / "feed.toml")
    what = f"sw.gcode({badge!r})" if kind == "job" else f"sw.cycle({feed!r})"
    child = subprocess.Popen(
        [sys.executable, "-c", SLOW.format(what)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert child.stdout is not None and child.stdout.readline() == "runs\n"
    with pytest.raises(subprocess.TimeoutExpired):
        child.wait(0.7)
    child.send_signal(signal.SIGINT)
    assert "KeyboardInterrupt" in child.communicate(timeout=10)[1]


def test_ctrl_c_ends_the_planning_of_a_job(tmp_path: Path) -> None:
    job = tmp_path / "long.nc"
    with open(job, "w") as file:
        file.write("G90 F3000\n")
        for place in range(400_000):
            file.write(f"G1 X{place % 50 / 10} Y{place % 70 / 10}\n")
    program = f"import stepwright_motion as sw\njob = sw.gcode({str(job)!r})\nprint('plans', flush=True)\n"
    child = subprocess.Popen(
        [sys.executable, "-c", program + "job.plan(jerk=10_000)"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert child.stdout is not None and child.stdout.readline() == "plans\n"
    with pytest.raises(subprocess.TimeoutExpired):
        child.wait(0.5)
    child.send_signal(signal.SIGINT)
    began = time.monotonic()
    assert "KeyboardInterrupt" in child.communicate(timeout=60)[1]
    assert time.monotonic() - began < 3


def test_a_run_is_drawn() -> None:
    pytest.importorskip("matplotlib").use("Agg")
    run = sw.cycle(EXAMPLES / "cycles" / "drawing.toml").run()
    figure = run.plot()
    assert len(figure.axes) == 3
    assert figure.axes[0].lines[0].get_ydata().tolist() == run.x.positions.tolist()
    picture = run._repr_png_()
    assert picture is not None and picture.startswith(b"\x89PNG") and len(picture) > 10_000


@pytest.fixture
def stream() -> Iterator[Pty]:
    """A virtual board with the program ``stream``, behind a pseudo-terminal."""
    pty = Pty("--program", "stream")
    yield pty
    pty.close()


def test_a_job_runs_on_a_board_that_plays_streams(stream: Pty, tmp_path: Path) -> None:
    job = tmp_path / "job.nc"
    job.write_text("M3 S500\nG1 X10 Y-5 F3000\nG2 X10 Y5 J5\n")
    for _ in range(2):
        run = sw.gcode(job).run(stream.port, laser=1000, jerk="20000mm/s3")
        assert run.positions == pytest.approx((10.0, 5.0, 0.0))
        assert run.duration == pytest.approx(sw.gcode(job).plan(jerk="20000mm/s3").duration, abs=1e-3)
        assert (run.late, run.braked) == (0, False)
        # Fifty looks a second, on the way of the plan.
        assert len(run.x) > 10 and run.x.times[-1] <= run.duration
        plan = sw.gcode(job).run(laser=1000, jerk="20000mm/s3")
        for time, place in zip(run.x.times[1:], run.x.positions[1:]):
            first = bisect.bisect_right(plan.x.times, time - 0.002) - 1
            last = bisect.bisect_left(plan.x.times, time + 0.002)
            near = plan.x.positions[max(first, 0) : last + 1]
            assert min(near) - 1e-9 <= place <= max(near) + 1e-9, (time, place)


def test_a_job_needs_a_board_that_plays_streams(pty: Pty, tmp_path: Path) -> None:
    job = tmp_path / "job.nc"
    job.write_text("G1 X10 F3000\n")
    with pytest.raises(ConnectionError, match="--program stream"):
        sw.gcode(job).run(pty.port)
    with pytest.raises(ConnectionError):
        sw.gcode(job).run(tmp_path / "nothing")


def test_ctrl_c_brakes_a_job_on_a_board(stream: Pty, tmp_path: Path) -> None:
    job = tmp_path / "job.nc"
    job.write_text("G1 X500 F3000\n")
    program = (
        "import stepwright_motion as sw\nprint('begins', flush=True)\n"
        f"sw.gcode({str(job)!r}).run({stream.port!r})\n"
    )
    child = subprocess.Popen(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert child.stdout is not None
    child.stdout.readline()
    time.sleep(2.0)
    child.send_signal(signal.SIGINT)
    _, said = child.communicate(timeout=20)
    assert "KeyboardInterrupt" in said
    # It rests where it has braked, and says where.
    told = command("stop", "--port", stream.port).split()
    assert told[:3] == ["axis", "1", "position"] and 800 < int(told[3]) < 39_000, told


def test_ctrl_c_ends_the_planning_of_a_path() -> None:
    program = (
        "import stepwright_motion as sw\n"
        "places = [(n % 50 / 10, n % 70 / 10) for n in range(600_000)]\n"
        "print('plans', flush=True)\nsw.path(places, jerk=10_000)\n"
    )
    child = subprocess.Popen(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert child.stdout is not None and child.stdout.readline() == "plans\n"
    with pytest.raises(subprocess.TimeoutExpired):
        child.wait(2.5)
    child.send_signal(signal.SIGINT)
    began = time.monotonic()
    assert "KeyboardInterrupt" in child.communicate(timeout=60)[1]
    assert time.monotonic() - began < 3
