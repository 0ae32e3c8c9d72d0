"""Errors of arguments: each names the argument and what is allowed."""

from __future__ import annotations

import math
import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any, Callable

import pytest
import seeded

import stepwright_motion as sw


def test_what_is_no_number_is_named(board: sw.Board) -> None:
    x: Any = board.x
    for what, call in (
        ("distance is None: give a number", lambda: x.move_by(None)),
        (r"distance is b'3'", lambda: x.move_by(b"3")),
        (r"position is \[1\]", lambda: board.line_to([1])),  # type: ignore[arg-type]
        ("speed is None: give", lambda: x.move_by(500).set_speed(None)),
        ("seconds is None: give a number of seconds", lambda: board.sleep(None)),  # type: ignore[arg-type]
        ("steps_per_mm is None", lambda: setattr(x, "steps_per_mm", None)),
        ("steps is None", lambda: sw.plan("trapezoid", None, accel=5, speed=5)),  # type: ignore[arg-type]
        ("max_speed is 2.5: give a whole number, 1 to 1000000 steps/s", lambda: _set(board, 2.5)),
        ("max_speed is None: give a whole number", lambda: _set(board, None)),
    ):
        with pytest.raises(TypeError, match=what):
            call()
        board.stop()


def _set(board: sw.Board, value: Any) -> None:
    board.settings.max_speed = value


def test_an_axis_takes_no_limit_that_it_has_not(board: sw.Board) -> None:
    for name in ("acel", "max_speed", "top_speed", "steps_per_rev"):
        with pytest.raises(AttributeError, match=f"^an axis has no {name}: set one of speed, accel,"):
            setattr(board.x, name, 100)
    board.x.accel, board.x.steps_per_mm = 2_000, 80
    assert (board.x.accel, board.x.steps_per_mm) == (2_000, 80)


def test_a_board_takes_nothing_that_it_has_not(board: sw.Board) -> None:
    for name in ("steps_per_mm", "speed", "acel"):
        with pytest.raises(AttributeError, match=f"^a board has no {name}: set it on an axis"):
            setattr(board, name, 80)


def test_a_bare_number_is_the_same_as_text(board: sw.Board) -> None:
    x = board.x
    x.steps_per_mm = 80
    for place, speed, steps in (("25", "20", 2000), (" 2.5", "1e1", 200), ("\u22121", "20", -80)):
        assert x.move_to(place, speed=speed).wait().steps == (steps,)
    assert x.move_by("3", "mm").wait().steps == (160,)
    # 1,600,000 steps/s; as steps/s it would be taken.
    with pytest.raises(ValueError, match="^speed"):
        x.move_by("1", speed="20000")


def test_what_is_out_of_range_is_named(board: sw.Board) -> None:
    x = board.x
    calls: tuple[tuple[str, Callable[[], object]], ...] = (
        ("distance is nan: give a finite number", lambda: x.move_by(math.nan)),
        ("accel is inf: give a finite number", lambda: x.move_by(5, accel=math.inf)),
        (r"^speed is 0 \(allowed: 0.001 to 1000000 steps/s\)", lambda: x.move_by(5, speed=0)),
        ("steps_per_rev is -5: it may be 1 to 10000000 steps", lambda: x.scale_to(-5)),
        ("steps_per_rev is 0", lambda: sw.plan("trapezoid", 5, steps_per_rev=0, accel=5, speed=5)),
        ("seconds is '2s': give a number of seconds", lambda: x.run(5, seconds="2s")),  # type: ignore[arg-type]
        ("lease is -1: it may be 0.2 to 60 s", lambda: sw.virtual(lease=-1)),
        ("lease is 100000000.0: it may be 0.2 to 60 s", lambda: sw.virtual(lease=1e8)),
        ("baud is 0: it may be 50 to 12000000", lambda: sw.open("/dev/null", baud=0)),
        ("2.5: a place is a whole number", lambda: sw.virtual(switches={"x": 2.5})),  # type: ignore[dict-item]
    )
    for what, call in calls:
        with pytest.raises(ValueError, match=what):
            call()
    for what in ("speed", "jump", "feed"):
        with pytest.raises(ValueError, match=f"^{what} is 0: give 0.001 steps/s or more"):
            sw.path([(0, 0), (5, 0)], **{what: 0})
    far = [(0, 0), (math.nan, 0)]
    for what, places in (("waypoint 1 is", far), ("'2mm': give numbers", [("2mm", 0)])):
        with pytest.raises(ValueError, match=what):
            sw.path(places)  # type: ignore[arg-type]
    with pytest.raises(sw.OutOfRange, match="`within` is missing") as missing:
        x.home()
    assert "server" not in str(missing.value)


def test_an_axis_has_one_letter(board: sw.Board) -> None:
    assert board["Y"] is board.y
    with board.record() as log:
        pass
    for name in ("xy", "yz", "xyz", "", True, 0, 4, 1.5):
        for of in (board, log):
            with pytest.raises(IndexError, match="give 1 to 3"):
                of[name]  # type: ignore[index]


def test_an_axis_has_any_whole_number(board: sw.Board) -> None:
    np = pytest.importorskip("numpy")
    assert [board[i] for i in np.arange(1, 4)] == [board.x, board.y, board.z]


def test_none_leaves_an_axis_of_a_line_where_it_is(board: sw.Board) -> None:
    assert board.line_to(x=100, y=None).wait().steps == (100,)
    assert board.line_by(None, 50, z=None).wait().steps == (50,)
    with pytest.raises(TypeError, match="x twice"):
        board.line_to(1, x=2)
    with pytest.raises(TypeError, match="not w"):
        board.line_to(x=5, w=3)


def test_a_law_takes_nothing_that_it_does_not_go_by() -> None:
    for law, takes in seeded.TAKES.items():
        name = "knee" if "jerk" in takes else "jerk"
        with pytest.raises(ValueError, match=f"the law {law} has no {name}: it takes "):
            values = {one: 5 for one in takes} | {name: 1}
            sw.plan(law, 10, **values)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="there is no law 'None'"):
        sw.plan(None, 10)  # type: ignore[arg-type]


def test_what_is_not_there_is_told(tmp_path: Path) -> None:
    with pytest.raises(sw.CantOpen, match="HOST:PORT") as away:
        sw.open("tcp://127.0.0.1:1")
    assert "plugged" not in str(away.value)
    with pytest.raises(FileNotFoundError, match="none.nc"):
        sw.gcode(tmp_path / "none.nc").plan()


def test_files_may_be_paths(board: sw.Board, tmp_path: Path) -> None:
    with pytest.raises(sw.CantOpen):
        sw.open(tmp_path / "none")
    cycles = tmp_path / "cycles.toml"
    cycles.write_text(
        '[[motor]]\nname = "X"\nstep = 1\nsmallest-delay-us = 100\n'
        "[[cycle]]\nmove.X = { steps = 5, delay-us = 1000 }\n"
    )
    with pytest.raises(ConnectionError):
        sw.cycle(cycles).run(tmp_path / "none")
    cycles.unlink()
    sw.plan("trapezoid", 20, accel=500, speed=50).plot(tmp_path / "plan.svg")
    with board.record() as log:
        board.x.move_by(5).wait()
    log.save(tmp_path / "log.csv")
    assert {file.name for file in tmp_path.iterdir()} == {"plan.svg", "log.csv"}


def test_what_was_raised_gets_to_another_process() -> None:
    outcome = sw.Outcome("stopped", "stopped by its limit switch", (5,), (0.5,), "switch")
    for error in (sw.Stopped(outcome), sw.Uncertain(outcome), sw.OutOfRange("a", "b", "c")):
        again = pickle.loads(pickle.dumps(error))
        assert (type(again), str(again), vars(again)) == (type(error), str(error), vars(error))


@pytest.mark.skipif(sys.platform == "win32", reason="it has no fork")
def test_a_forked_child_ends_without_a_word() -> None:
    program = (
        "import os, sys, stepwright_motion as sw\n"
        "board = sw.virtual()\n"
        "child = os.fork()\n"
        "if child == 0:\n"
        "    sys.exit(3)\n"
        "assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 3\n"
        "print(board.x.move_by(5).wait().kind)\n"
    )
    ran = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)
    assert (ran.stdout, ran.stderr) == ("reached\n", "")
