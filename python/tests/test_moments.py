"""Programs that end at random moments, in every way that programs end, and boards that vanish: each
time the board rests within its lease and a ramp, and its position is known.

``STEPWRIGHT_MOMENTS`` is the number of moments, ``STEPWRIGHT_SEED`` their seed.
"""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor

import pytest
from conftest import Cable, Pty

import stepwright_motion as sw

MOMENTS = int(os.environ.get("STEPWRIGHT_MOMENTS", "24"))
SEED = os.environ.get("STEPWRIGHT_SEED", "stepwright")
BOARDS = int(os.environ.get("STEPWRIGHT_BOARDS", "4"))
"""The number of boards at once."""

LEASE = 0.4
RAMP = 0.1
"""The ramp from 2000 steps/s at 20000 steps/s²."""
SPARE = 0.6
"""Spare time for bytes in transit and a loaded computer."""

BEGIN = """
import random, sys, time
import stepwright_motion as sw
luck = random.Random(sys.argv[2])
fails = time.monotonic() + float(sys.argv[3])
print("opens", flush=True)
board = sw.open(sys.argv[1], lease={lease})
for axis in board:
    axis.speed, axis.accel = 2000, 20_000
""".format(lease=LEASE)

PROGRAM = (
    BEGIN
    + """
while True:
    board.stop()
    order = luck.randrange(4)
    if order == 0:
        move = board.x.run(luck.choice([-2000, 2000]))
    elif order == 1:
        move = board.y.move_by(luck.choice([-100_000, 100_000]))
    elif order == 2:
        move = board.line_by(luck.randint(100, 5000), -luck.randint(100, 5000))
    else:
        move = board.z.move_by(luck.randint(200, 4000))
        board.sleep(0.05)
        try:
            move.set_speed(1500)
        except sw.Refused:
            pass  # it has ended by then
    until = time.monotonic() + luck.uniform(0, 0.5)
    while time.monotonic() < until:
        board.sleep(0.02)
        if time.monotonic() > fails:
            raise RuntimeError("by its moment")
"""
)

CALLBACK = (
    BEGIN
    + """
import asyncio

async def main():
    loop = asyncio.get_running_loop()
    heard = loop.create_future()
    def callback():
        try:
            raise RuntimeError("by its moment")
        except RuntimeError as why:
            heard.set_exception(why)
    loop.call_later(max(fails - time.monotonic(), 0), callback)
    async def drive(axis):
        while True:
            await axis.move_by(luck.choice([-1, 1]) * luck.randint(300, 100_000))
    await asyncio.gather(heard, drive(board.x), drive(board.z))

asyncio.run(main())
"""
)
"""An exception in a callback of an event loop, which reaches the awaiting coroutine."""

WAYS = {
    "kill": signal.SIGKILL,
    "term": signal.SIGTERM,
    "hup": signal.SIGHUP,
    "int": signal.SIGINT,
    "exception": None,
    "callback": None,
    "notebook": None,
    "unplugged": None,
    "silent": None,
}
"""The signals that end a program; ``None`` for another way."""


def by_a_program(way: str, port: str, number: int, when: float) -> str:
    """Ends a program by a signal or by an exception."""
    end = WAYS[way]
    text = CALLBACK if way == "callback" else PROGRAM
    words = [sys.executable, "-X", "faulthandler", "-c", text, port, f"{SEED} {number}"]
    child = subprocess.Popen(
        [*words, "1e6" if end else str(when)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert child.stdout is not None and child.stdout.readline() == "opens\n"
    if end is not None:
        time.sleep(when)
        child.send_signal(end)
    try:
        why = child.communicate(timeout=30)[1]
    except subprocess.TimeoutExpired:
        child.send_signal(signal.SIGABRT)
        return f"the program did not end: {child.communicate()[1]}"
    if end is None and "by its moment" not in why:
        return f"it has failed otherwise: {why}"
    if end is signal.SIGINT and "KeyboardInterrupt" not in why:
        return f"it has not heard Ctrl-C: {why}"
    return ""


def by_a_notebook(port: str, number: int, when: float) -> str:
    """Closes a notebook while its cell runs, or after that."""
    client = pytest.importorskip("jupyter_client")
    begin = BEGIN.replace("sys.argv", repr(["", port, f"{SEED} {number}", "1e6"]))
    kernel = client.KernelManager(kernel_name="python3")
    kernel.start_kernel(stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    talk = kernel.client()
    talk.start_channels()
    try:
        talk.wait_for_ready(timeout=60)
        talk.execute_interactive(begin, timeout=60, output_hook=lambda _: None)
        talk.execute("move = board.x.run(2000); board.y.move_by(100_000)")
        talk.execute("move.wait()" if number % 2 else "board.z.move_by(-3000).wait()")
        time.sleep(when)
    finally:
        talk.stop_channels()
        kernel.shutdown_kernel(now=number % 4 > 1)
        kernel.context.destroy()
    return ""


def by_a_board(way: str, port: str, number: int, when: float) -> str:
    """Pulls the cable of a board, or stops all bytes on its line."""
    with Cable(port) as cable:
        try:
            with sw.open(cable.address, lease=LEASE) as board:
                for axis in board:
                    axis.speed, axis.accel = 2000, 20_000
                luck = random.Random(f"{SEED} {number}")
                moves = [board.x.run(2000), board.z.move_by(luck.choice([-100_000, 3_000]))]
                board.sleep(when)
                if way == "unplugged":
                    cable.pull()
                else:
                    cable.mute()
                moves[0].wait(10)
        except sw.LinkLost:
            return ""
        except sw.Stopped as why:
            # This computer was so busy that the board had braked before.
            return "" if why.reason == "timeout" else str(why)
    return "nobody has heard that the board is gone"


def moment(port: str, number: int) -> str:
    """Ends a program at a moment and looks at the board. Returns what is wrong."""
    luck = random.Random(f"{SEED} {number}")
    # All ways in turn, so that even a few moments include each way.
    way, when = list(WAYS)[number % len(WAYS)], luck.uniform(0, 1.5)
    if way == "notebook":
        wrong = by_a_notebook(port, number, when)
    elif way in ("unplugged", "silent"):
        wrong = by_a_board(way, port, number, when)
    else:
        wrong = by_a_program(way, port, number, when)
    if wrong:
        return f"moment {number}, {way}: {wrong}"
    time.sleep(LEASE + RAMP + SPARE)
    with sw.open(port) as board:
        for axis in board:
            if axis.moving:
                return f"moment {number}, {way} after {when:.3f} s: axis {axis.number} moves"
            try:
                at = axis.steps
            except sw.Uncertain as lost:
                return f"moment {number}, {way} after {when:.3f} s: {lost}"
            if axis.number == 3 and axis.move_by(-7).wait().steps != (at - 7,):
                return f"moment {number}, {way}: axis 3 does not move on from {at}"
    return ""


def test_programs_end_at_random_moments() -> None:
    ptys = [Pty() for _ in range(BOARDS)]

    def one(port: str, number: int) -> str:
        try:
            return moment(port, number)
        except Exception as why:
            return f"moment {number}: {type(why).__name__}: {why}"

    def some(place: int) -> list[str]:
        return [one(ptys[place].port, number) for number in range(place, MOMENTS, BOARDS)]

    try:
        with ThreadPoolExecutor(BOARDS) as pool:
            said = [words for part in pool.map(some, range(BOARDS)) for words in part if words]
    finally:
        for pty in ptys:
            pty.close()
    assert not said, "\n".join(said)
