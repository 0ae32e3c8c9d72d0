"""The ends of programs: the motors always come to rest, and their positions stay known."""

from __future__ import annotations

import asyncio
import os
import signal
import subprocess
import sys
import threading
import time

import pytest
from conftest import Pty

import stepwright_motion as sw


def test_leaving_the_block_brakes(pty: Pty) -> None:
    with sw.open(pty.port) as board:
        board.x.move_to(100_000)
        board.y.run(-500)
        board.sleep(0.3)
    with sw.open(pty.port) as board:
        assert not board.moving
        assert 0 < board.x.steps < 2000 and -1000 < board.y.steps < 0


def test_an_exception_brakes_and_is_told(pty: Pty) -> None:
    with pytest.raises(ZeroDivisionError):
        with sw.open(pty.port) as board:
            board.x.run(1000)
            board.sleep(0.2)
            1 / 0
    with sw.open(pty.port) as board:
        assert not board.moving and 0 < board.x.steps < 1500


def run(program: str) -> subprocess.Popen[str]:
    """Starts a program in a separate interpreter, and returns when a motor moves."""
    child = subprocess.Popen(
        [sys.executable, "-c", program],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert child.stdout is not None
    said = child.stdout.readline()
    assert said == "moves\n", (said, child.communicate())
    return child


WAITS = """
import stepwright_motion as sw
board = sw.open({port!r}, lease=0.5)
move = board.x.run(1000)
print("moves", flush=True)
move.wait()
"""


def test_ctrl_c_brakes(pty: Pty) -> None:
    """Without a ``with`` block, as in a notebook."""
    child = run(WAITS.format(port=pty.port))
    time.sleep(0.3)
    child.send_signal(signal.SIGINT)
    assert "KeyboardInterrupt" in child.communicate(timeout=10)[1]
    with sw.open(pty.port) as board:
        assert not board.moving and 0 < board.x.steps < 3000
        assert board.x._state()["stop"]["name"] == "stop"


def test_the_end_of_the_program_brakes(pty: Pty) -> None:
    child = run(WAITS.format(port=pty.port).replace("move.wait()", "board.sleep(0.3)"))
    assert child.communicate(timeout=10)[1] == ""
    with sw.open(pty.port) as board:
        assert not board.moving and 0 < board.x.steps < 3000
        assert board.x._state()["stop"]["name"] == "stop"


@pytest.mark.parametrize("order", ["board.x.run(1000)", "board.x.move_to(100_000)"])
def test_a_killed_interpreter_is_missed_by_the_board(pty: Pty, order: str) -> None:
    """The axis rests within its lease and its ramp, and its position is known."""
    child = run(WAITS.format(port=pty.port).replace("board.x.run(1000)", order))
    time.sleep(0.3)
    child.kill()
    child.communicate()
    killed = time.monotonic()
    # After the lease, the ramp of 0.4 s and a moment the axis rests, without any report.
    time.sleep(0.5 + 0.4 + 0.3)
    with sw.open(pty.port) as board:
        assert not board.moving
        state = board.x._state()
        assert state["stop"]["name"] == "timeout", (state, time.monotonic() - killed)
        at = board.x.steps
        assert 300 < at < 2500
        assert board.x.move_to(0).wait().steps == (0,)


def test_a_board_that_vanishes_is_lost(pty: Pty) -> None:
    with sw.open(pty.port) as board:
        move = board.x.move_to(100_000)
        board.sleep(0.2)
        pty.process.kill()
        with pytest.raises(sw.LinkLost):
            move.wait()
        with pytest.raises(sw.LinkLost, match="and open it again"):
            board.x.move_to(0)
        with pytest.raises(sw.LinkLost, match="and open it again"):
            board.x.position
        # A motor may be moving: no call says that none moves, or how fast.
        for asked in (lambda: board.moving, lambda: board.x.moving, lambda: board.x.speed_now):
            with pytest.raises(sw.LinkLost):
                asked()
    # A program that knows of the loss gets no second exception at the end of the block.
    with pytest.raises(sw.LinkLost):
        board.x.move_to(0)


def test_a_board_that_vanishes_unnoticed_is_told_at_the_end(pty: Pty) -> None:
    with pytest.raises(sw.LinkLost, match="closed at its other end"):
        with sw.open(pty.port) as board:
            board.x.move_to(100_000)
            board.sleep(0.2)
            pty.process.kill()
            time.sleep(0.3)


def test_a_closed_board_says_so() -> None:
    board = sw.virtual(fast=True)
    board.close()
    board.close()
    with pytest.raises(sw.LinkLost, match="closed"):
        board.x.move_to(0)
    assert "closed" in repr(board)


def test_what_is_no_board_can_not_be_opened(pty: Pty) -> None:
    with pytest.raises(sw.CantOpen, match="nowhere"):
        sw.open("/dev/nowhere")
    with pytest.raises(sw.CantOpen):
        sw.open("tcp://127.0.0.1:1")
    with sw.open(pty.port):
        with pytest.raises(sw.CantOpen, match="in use"):
            sw.open(pty.port)
    with pytest.raises(ValueError, match="lease"):
        sw.virtual(lease=0.01)


def test_a_dropped_board_brakes(pty: Pty) -> None:
    board = sw.open(pty.port)
    board.x.run(1000)
    board.sleep(0.2)
    del board
    deadline = time.monotonic() + 5
    while True:
        try:
            with sw.open(pty.port) as board:
                assert not board.moving and 0 < board.x.steps < 3000
                return
        except sw.CantOpen:
            assert time.monotonic() < deadline
            time.sleep(0.05)


@pytest.mark.skipif(not os.path.isdir("/proc/self/fd"), reason="nothing tells what is open")
def test_a_closed_board_leaves_nothing_open(pty: Pty) -> None:
    """Neither a file nor a thread stays open, even after many boards."""

    def held() -> tuple[int, int]:
        time.sleep(0.1)
        return len(os.listdir("/proc/self/fd")), len(os.listdir("/proc/self/task"))

    def opened(port: str) -> sw.Board:
        return sw.virtual(fast=True) if port == "virtual" else sw.open(port)

    for port in (pty.port, "virtual"):
        with opened(port) as board:
            board.x.move_by(1).wait()
        before = held()
        for _ in range(8):
            with opened(port) as board:
                assert not board.moving
        now = held()
        assert now[0] <= before[0] and now[1] <= before[1], (before, now)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork")
def test_a_forked_process_leaves_the_board_alone() -> None:
    with sw.virtual() as board:
        move = board.x.move_to(500)
        child = os.fork()
        if child == 0:
            try:
                board.x.move_to(0)
            except RuntimeError:
                os._exit(7)
            os._exit(1)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
        assert move.wait().steps == (500,)


async def awaited(move: sw.Move) -> sw.Outcome:
    return await move


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork")
def test_a_forked_process_awaits_moves_of_its_own_alone() -> None:
    """This holds even if the parent process has awaited a move before."""
    with sw.virtual() as board:
        asyncio.run(awaited(board.x.move_by(5)))
        move = board.x.move_to(500)
        child = os.fork()
        if child == 0:
            # Nothing else ends a child that hangs.
            signal.signal(signal.SIGALRM, signal.SIG_DFL)
            signal.alarm(20)
            try:
                asyncio.run(awaited(move))
            except RuntimeError as why:
                if "another process" not in str(why):
                    os._exit(2)
                with sw.virtual(fast=True) as own:
                    os._exit(7 if asyncio.run(awaited(own.x.move_by(50))).steps == (50,) else 3)
            finally:
                os._exit(1)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
        assert move.wait().steps == (500,)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork")
def test_a_forked_process_ends_no_recording() -> None:
    """The locks of a recording may be held by a thread that the process does not have."""
    with sw.virtual() as board, board.record() as log:
        child = os.fork()
        if child == 0:
            try:
                log.stop()
            except RuntimeError as why:
                os._exit(7 if "another process" in str(why) else 2)
            os._exit(1)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7


def test_ctrl_c_brakes_a_motion_that_is_about_to_begin(pty: Pty) -> None:
    with sw.open(pty.port) as board:
        # The board does not answer while the order is given.
        pty.process.send_signal(signal.SIGSTOP)
        threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT)).start()
        threading.Timer(0.4, pty.process.send_signal, (signal.SIGCONT,)).start()
        with pytest.raises(KeyboardInterrupt):
            board.x.move_to(100_000)
        board.sleep(1.5)
        assert not board.moving and board.x.steps < 2_000
