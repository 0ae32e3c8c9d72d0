"""Orders and their outcomes on a virtual board."""

from __future__ import annotations

import asyncio
import json
import math
import threading
import time
from pathlib import Path

import pytest
from conftest import Pty

import stepwright_motion as sw


def test_a_move_reaches_its_target_in_the_unit_of_its_axis(board: sw.Board) -> None:
    board.x.steps_per_mm = 80
    outcome = board.x.move_to(25, "mm").wait()
    assert (outcome.kind, outcome.position, outcome.steps) == ("reached", 25.0, (2000,))
    assert outcome
    assert (board.x.position, board.x.steps, board.x.unit) == (25.0, 2000, "mm")
    assert board.x.move_by("-1.5mm").wait().position == 23.5
    # Bare numbers are in the unit of the positions.
    assert board.x.move_to(board.x.position + 1).wait().position == 24.5
    assert board.x.move_to("100steps").wait().steps == (100,)


@pytest.mark.parametrize(
    ("steps_per_rev", "mm_per_rev", "given", "steps"),
    [(3200, None, 90, 800), (3200, 8.0, -1.25, -500), (None, 40.0, "0.5turns", 100)],
)
def test_scales(
    board: sw.Board, steps_per_rev: int, mm_per_rev: float, given: float, steps: int
) -> None:
    board.y.scale_to(steps_per_rev, mm_per_rev)
    assert board.y.move_to(given).wait().steps == (steps,)


def test_a_fraction_of_a_step_per_mm_counts(board: sw.Board) -> None:
    board.x.steps_per_mm = 78.74
    assert board.x.move_to(100).wait().steps == (7874,)
    assert board.x.steps_per_mm == pytest.approx(78.74)
    # A rack with a pinion of 20 mm, and motors whose step is about a metre.
    for steps in (200 / (math.pi * 20), 0.0014, 0.001, 415.461_234_5, 9999.9999):
        board.x.steps_per_mm = steps
        assert board.x.steps_per_mm == steps
    board.x.zero()
    board.x.steps_per_mm = 3.1831
    assert board.x.move_to(10_000, speed=4_000, accel=20_000).wait().steps == (31_831,)
    assert board.x.position == 10_000
    # A position is exact to the step.
    for steps in (200 / (math.pi * 20), 0.001234, 9999.9876, 41.7012904):
        board.x.steps_per_mm = steps
        for place in (999_999_937, -123_456_789, 1):
            assert board.x._steps(place / steps) == place
    # The limits of a path's axis are as exact as its steps.
    coarse = sw.path([(0, 0), (5000, 0)], feed=100, steps_per_mm=0.0014, accel=1000, jump=100)
    assert coarse.duration == pytest.approx(50, rel=0.01)


def test_small_floats_are_positions(board: sw.Board) -> None:
    """The shortest decimals of these have more than 18 places."""
    board.x.steps_per_mm = 6_000
    for place, steps in ((0.01 / 6, 10), (-0.1 / 6000, 0), (7 / 6000, 7), (1e-30, 0), (0.0011 / 3, 2)):
        assert board.x.move_to(place, speed=1.1 / 700, accel=0.5).wait().steps == (steps,)


def test_steps_per_mm_say_nothing_of_turns(board: sw.Board) -> None:
    board.x.steps_per_mm = 80
    for text in ("1turn", "1 rev", "90deg", "90°", "1.5RAD", "2turns"):
        with pytest.raises(ValueError, match="says nothing of turns"):
            board.x.move_by(text)
    for speed in ("120rpm", "2rev/s", "720deg/s", "6rad/s"):
        with pytest.raises(ValueError, match="says nothing of turns"):
            board.x.run(speed)
        with pytest.raises(ValueError, match="says nothing of turns"):
            sw.path([(0, 0), (9, 0)], feed=speed)
    with pytest.raises(ValueError, match="accel 2rev/s2: steps_per_mm says nothing of turns"):
        board.x.move_by(5, accel="2rev/s2")
    assert board.x.steps == 0 and board.x.move_by("40steps").wait().position == 0.5
    board.x.scale_to(steps_per_rev=3200, mm_per_rev=40)
    assert board.x.move_by("90deg").wait().steps == (840,)
    with pytest.raises(TypeError, match="steps_per_mm is"):
        sw.path([(0, 0)], steps_per_mm=[80, 80])  # type: ignore[arg-type]


def test_speeds_are_those_asked_for(board: sw.Board) -> None:
    """4000 steps at 500 steps/s take 8 s plus the ramps."""
    for given in ({"speed": 500}, {"speed": "150rpm"}):
        board.x.zero()
        began = board.time
        board.x.move_to(4000, accel=10_000, start_speed=0, **given).wait()
        assert board.time - began == pytest.approx(8.05, abs=0.06)
    board.x.speed, board.x.accel, board.x.start_speed = 2000, 20_000, 0
    began = board.time
    board.x.move_to(0).wait()
    assert board.time - began == pytest.approx(2.1, abs=0.06)


def test_ranges_and_refusals_say_what_is_allowed(board: sw.Board) -> None:
    with pytest.raises(sw.OutOfRange) as range_error:
        board.x.move_to(10, accel=0.5)
    assert range_error.value.allowed == "1 to 100000000 steps/s²"
    with pytest.raises(sw.Refused) as refused:
        board.x.move_to(400_000, speed=500_000, accel=100_000)
    assert "at most" in (refused.value.remedy or "")
    board.settings.max_speed = 700
    with pytest.raises(sw.Refused, match="max-speed=700"):
        board.x.move_to(4000, speed=800)
    for wrong in ("10furlongs", "10mm/s", "far", math.nan, math.inf):
        with pytest.raises(ValueError):
            board.x.move_to(wrong)
    with pytest.raises(IndexError):
        board[4]
    with pytest.raises(TypeError):
        board.line_to(x=5, w=3)
    # None of these orders has moved anything.
    assert board.x.steps == 0 and not board.moving


def test_garbage_is_refused_and_nothing_hangs(board: sw.Board) -> None:
    nan = math.nan
    for wrong in (
        lambda: board.sleep(nan),
        lambda: board.sleep(-1),
        lambda: board.x.run(100, seconds=nan),
        lambda: board.x.run(100, seconds=-1),
        lambda: board.x.move_to(5, speed=nan),
        lambda: board.x.move_to(5, accel=-5),
        lambda: setattr(board.x, "steps_per_mm", nan),
        lambda: setattr(board.x, "steps_per_mm", -80),
        lambda: sw.virtual(lease=nan),
        lambda: sw.open("/dev/null", baud=-3),
    ):
        with pytest.raises(ValueError):
            wrong()
    with pytest.raises(ValueError, match="set steps_per_mm of axis 1"):
        board.x.move_to("5mm")
    with pytest.raises(TypeError):
        board.settings.max_speed = "fast"  # type: ignore[assignment]
    assert not board.moving and board.x.steps == 0
    board.close()
    with pytest.raises(sw.LinkLost, match="closed"):
        with board:
            pass


def test_a_second_order_is_refused_and_the_first_goes_on(board: sw.Board) -> None:
    move = board.x.move_to(400)
    with pytest.raises(sw.Refused, match="on its way"):
        board.x.move_to(100)
    assert not move.done and move.outcome is None
    assert move.wait().steps == (400,)
    assert move.done and move.outcome == move.wait()


def test_a_motion_that_has_ended_changes_no_other(board: sw.Board) -> None:
    ended = board.x.move_by(100)
    ended.wait()
    going = board.x.move_by(5000)
    with pytest.raises(sw.Refused, match="this motion has ended"):
        ended.retarget(200)
    with pytest.raises(sw.Refused, match="this motion has ended"):
        ended.set_speed(50)
    with pytest.raises(sw.Refused, match="wait, or stop it$"):
        board.x.zero()
    assert going.wait().steps == (5100,)
    line = board.line_by(50, 50)
    with pytest.raises(ValueError, match="takes no other target: stop it"):
        line.retarget(5)


def test_a_move_is_stopped_and_another_is_sent_elsewhere(board: sw.Board) -> None:
    move = board.x.move_to(4000)
    board.sleep(0.5)
    outcome = move.stop()
    assert outcome.kind == "stopped" and outcome.reason == "stop"
    assert 0 < board.x.steps < 4000 and outcome.steps == (board.x.steps,)
    move = board.x.move_to(4000)
    board.sleep(0.5)
    assert move.retarget(-50).wait().steps == (-50,)
    move = board.x.move_to(4000)
    board.sleep(0.5)
    began = board.time
    move.set_speed(200)
    move.wait()
    assert board.time - began > 15


def test_a_switch_at_the_forward_end_stops_the_axis() -> None:
    with sw.virtual(fast=True, switches={"x": -300, "y": 300}) as board:
        for axis, way in ((board.x, -1), (board.y, 1)):
            with pytest.raises(sw.Stopped) as stopped:
                axis.move_to(1000 * way).wait()
            assert stopped.value.reason == "switch"
            assert 300 <= axis.steps * way < 400


def test_who_waits_hears_what_has_stopped_it() -> None:
    with sw.virtual(fast=True, switches={"x": -300}) as board:
        with pytest.raises(sw.Stopped) as stopped:
            board.x.move_to(-1000).wait()
        assert stopped.value.reason == "switch"
        assert stopped.value.position == board.x.position <= -300
        outcome = board.x.home(within=2000).wait()
        assert outcome and board.x.steps == 50
        move = board.x.move_to(1000)
        board.sleep(0.3)
        board.kill()
        with pytest.raises(sw.Uncertain):
            move.wait()
        with pytest.raises(sw.Uncertain):
            board.x.position
        with pytest.raises(sw.Refused, match="uncertain"):
            board.x.move_to(0)
        board.x.zero()
        assert board.x.move_to(20).wait().position == 20


def test_runs_last_as_long_as_they_should(board: sw.Board) -> None:
    outcome = board.x.run(1000, seconds=2.0, accel=100_000).wait()
    assert outcome and board.x.steps == pytest.approx(2000, abs=40)
    outcome = board.x.run("-1000steps/s", seconds=2.0, accel=100_000).wait()
    assert board.x.steps == pytest.approx(0, abs=60)
    with board.y.run(-500):
        board.sleep(1.0)
        assert board.y.speed_now == pytest.approx(-500, abs=20)
    assert board.y.steps == pytest.approx(-500, abs=150) and not board.moving
    # A run that another call ends counts as stopped.
    run = board.x.run(100)
    board.stop()
    with pytest.raises(sw.Stopped):
        run.wait()


def test_a_run_without_a_speed_is_as_fast_as_a_move_without_one(board: sw.Board) -> None:
    board.x.steps_per_mm = 80
    board.x.run(seconds=2.0, accel="100000steps/s2").wait()
    assert board.x.steps == pytest.approx(2000, abs=40)
    board.x.speed = 5
    board.x.run(seconds=2.0, accel="100000steps/s2").wait()
    assert board.x.steps == pytest.approx(2800, abs=60)


def test_a_stop_tells_that_nobody_knows_where() -> None:
    with sw.virtual() as board:
        move = board.x.move_to(5000, speed=2000)
        board.sleep(0.2)
        board.kill()
        with pytest.raises(sw.Uncertain):
            move.stop()
        with pytest.raises(sw.Uncertain):
            with board.y.run(1000):
                board.sleep(0.2)
                board.kill()


def test_lines_are_straight(board: sw.Board) -> None:
    for axis in board:
        axis.steps_per_mm = 80
    with board.record() as log:
        outcome = board.line_to(x=20, y=-10, speed="20mm/s").wait()
    assert outcome.positions == (20.0, -10.0)
    # Both axes were looked at almost at the same time.
    middle = len(log.x) // 2
    assert log.y.position[middle] == pytest.approx(-log.x.position[middle] / 2, abs=0.3)
    assert board.line_by(None, 5).wait().positions == (-5.0,)
    assert board.x.position == 20
    with pytest.raises(sw.OutOfRange):
        board.line_by(x=0)


def test_settings_are_attributes_with_their_documentation(board: sw.Board) -> None:
    assert board.settings.pulse_us == 2
    board.settings.pulse_us = 3
    assert board.settings.pulse_us == 3
    assert "pulse_us" in dir(board.settings) and "pulse_us" in list(board.settings)
    assert "STEP" in board.settings.describe("pulse_us")
    assert "pulse_us" in repr(board.settings) and "pulse_us" in board.settings._repr_html_()
    with pytest.raises(sw.OutOfRange, match="1 to 20"):
        board.settings.pulse_us = 21
    with pytest.raises(AttributeError):
        board.settings.pulse = 3
    with pytest.raises(AttributeError):
        board.settings.nothing


def test_a_recording_has_every_look(board: sw.Board) -> None:
    with board.record() as log:
        board.x.move_to(1000, accel=10_000).wait()
    x = log.x
    assert log.missed == 0
    assert len(x.time) == len(x.position) == len(x.speed) == len(x.state) == len(x)
    assert list(x.time) == sorted(x.time)
    gaps = [b - a for a, b, s in zip(x.time, x.time[1:], x.state) if s == 1]
    # The last look finds the axis at rest, and comes after the board has said why.
    assert max(gaps[:-1]) < 0.04 and gaps[-1] < 0.06 and sum(gaps) / len(gaps) < 0.025
    assert (x.position[0], x.position[-1]) == (0, 1000)
    assert max(x.speed) == pytest.approx(1000, abs=15)
    assert x.state[-1] == sw.STATES.index("ready") and 1 in x.state
    assert len(log.y) >= 1 and log.y.position[-1] == 0


def test_a_recording_says_what_it_has_missed() -> None:
    """For a while nothing looks at the board, in real time."""
    import signal
    import subprocess
    import sys

    program = (
        "import stepwright_motion as sw\n"
        "with sw.virtual(lease=5) as board, board.record() as log:\n"
        "    move = board.x.move_to(2000)\n"
        "    print('moves', flush=True)\n"
        "    move.wait()\n"
        "print(log.missed, log.x.position[-1])\n"
    )
    child = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    assert child.stdout is not None and child.stdout.readline() == "moves\n"
    time.sleep(0.5)
    child.send_signal(signal.SIGSTOP)
    time.sleep(0.5)
    child.send_signal(signal.SIGCONT)
    missed, last = child.communicate(timeout=30)[0].split()
    assert int(missed) >= 20 and float(last) == 2000


def test_a_recording_becomes_a_table(board: sw.Board, tmp_path: Path) -> None:
    with board.record() as log:
        board.x.move_to(100).wait()
    log.save(f"{tmp_path}/log.csv")
    rows = open(f"{tmp_path}/log.csv").read().splitlines()
    assert rows[0] == "axis,time,position,speed,state"
    assert len(rows) == 1 + sum(len(log[axis]) for axis in (1, 2, 3))


def test_a_recording_becomes_a_frame(board: sw.Board) -> None:
    pytest.importorskip("pandas")
    with board.record() as log:
        board.x.move_to(100).wait()
    frame = log.frame()
    assert list(frame.columns) == ["axis", "time", "position", "speed", "state"]
    assert len(frame) == sum(len(log[axis]) for axis in (1, 2, 3))
    assert frame[frame.axis == 1].position.iloc[-1] == 100


def test_a_recording_has_every_edge_of_a_virtual_board(board: sw.Board, tmp_path: Path) -> None:
    board.x.move_to(100).wait()
    with board.record() as log:
        board.x.move_to(400).wait()
        board.y.move_to(-50).wait()
    board.x.move_to(0).wait()  # which is none of it
    log.save(f"{tmp_path}/log.vcd")
    dump = (tmp_path / "log.vcd").read_text()
    names = dict(line.split()[3:5] for line in dump.splitlines() if line.startswith("$var"))
    changes = dump.split("$dumpvars")[1].split("$end", 1)[1].splitlines()
    letters = {name: letter for letter, name in names.items()}
    assert changes.count(f"1{letters['step1']}") == 300
    assert changes.count(f"1{letters['step2']}") == 50
    mcap = pytest.importorskip("mcap.reader")
    log.save(f"{tmp_path}/log.mcap")
    with open(f"{tmp_path}/log.mcap", "rb") as file:
        messages = [
            (channel.topic, json.loads(message.data))
            for _, channel, message in mcap.make_reader(file).iter_messages()
        ]
    last = {topic: data["position"] for topic, data in messages if topic.startswith("/axis")}
    assert (last["/axis1"], last["/axis2"]) == (300, -50)
    with pytest.raises(ValueError, match=".csv, .vcd or .mcap"):
        log.save(f"{tmp_path}/log.txt")


def test_a_recording_of_a_real_board_has_the_planned_pulses(pty: Pty, tmp_path: Path) -> None:
    with sw.open(pty.port) as board, board.record() as log:
        board.x.move_to(400).wait()
        log.save(f"{tmp_path}/log.vcd")
    dump = (tmp_path / "log.vcd").read_text()
    assert "planned" in dump.splitlines()[0]
    assert sum(line == "1!" for line in dump.splitlines()) == 400


def test_moves_are_awaited(board: sw.Board) -> None:
    async def both() -> tuple[sw.Outcome, sw.Outcome]:
        async def one(move: sw.Move) -> sw.Outcome:
            return await move

        return await asyncio.gather(one(board.x.move_to(400)), one(board.y.move_to(-200)))

    first, second = asyncio.run(both())
    assert (first.steps, second.steps) == ((400,), (-200,))

    async def again() -> sw.Outcome:
        move = board.x.move_to(0)
        await move
        return await move

    assert asyncio.run(again()).steps == (0,)


def test_an_await_that_is_cancelled_brakes() -> None:
    async def late(board: sw.Board) -> None:
        move = board.x.run(1000)

        async def wait() -> None:
            await move

        await asyncio.wait_for(wait(), 0.3)

    with sw.virtual() as board:
        with pytest.raises(asyncio.TimeoutError):
            asyncio.run(late(board))
        deadline = time.monotonic() + 2
        while board.moving:
            assert time.monotonic() < deadline
            time.sleep(0.01)
        assert 0 < board.x.steps < 1500


def test_the_interpreter_is_free_while_it_waits() -> None:
    counted = 0
    with sw.virtual() as board:
        move = board.x.move_to(800)
        waits = threading.Thread(target=move.wait)
        waits.start()
        while waits.is_alive():
            counted += 1
            time.sleep(0.001)
        assert board.x.steps == 800
    assert counted > 100


def test_threads_share_a_board(board: sw.Board) -> None:
    """Each thread has an axis, and all axes reach their targets."""
    failed: list[BaseException] = []

    def drive(axis: sw.Axis) -> None:
        try:
            for place in (100, -50, 30):
                assert axis.move_to(place).wait().steps == (place,)
        except BaseException as error:
            failed.append(error)

    threads = [threading.Thread(target=drive, args=(axis,)) for axis in board]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not failed and [axis.steps for axis in board] == [30, 30, 30]


def test_several_boards_at_once() -> None:
    with sw.virtual(fast=True) as one, sw.virtual(fast=True) as other:
        moves = [one.x.move_to(300), other.x.move_to(-300)]
        assert [move.wait().steps for move in moves] == [(300,), (-300,)]


def test_wait_with_a_timeout_leaves_it_going() -> None:
    with sw.virtual() as board:
        move = board.x.move_to(1000)
        with pytest.raises(TimeoutError):
            move.wait(0.1)
        assert not move.done
        assert move.wait().steps == (1000,)


def test_numbers_of_numpy_are_numbers(board: sw.Board) -> None:
    numpy = pytest.importorskip("numpy")
    board.x.steps_per_mm = 80
    for place in numpy.linspace(0, 1, 3):
        assert board.x.move_to(place, accel=numpy.int64(500)).wait().position == place
