"""Programs that end at random moments, in every way that programs end: each time the board rests
within its lease and a ramp, and knows where it is.

``STEPWRIGHT_MOMENTS`` says how many; ``STEPWRIGHT_SEED`` which.
"""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor

from conftest import Pty

import stepwright_motion as sw

MOMENTS = int(os.environ.get("STEPWRIGHT_MOMENTS", "12"))
SEED = os.environ.get("STEPWRIGHT_SEED", "stepwright")
BOARDS = 4
"""At once."""

LEASE = 0.4
RAMP = 0.1
"""From 2000 steps/s at 20000 steps/s²."""
SPARE = 0.6
"""For bytes on their way, and a loaded computer."""

PROGRAM = """
import random, sys, time
import stepwright_motion as sw
luck = random.Random(sys.argv[2])
fails = time.monotonic() + float(sys.argv[3])
print("opens", flush=True)
board = sw.open(sys.argv[1], lease={lease})
for axis in board:
    axis.speed, axis.accel = 2000, 20_000
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
        if not move.done:
            move.set_speed(1500)
    until = time.monotonic() + luck.uniform(0, 0.5)
    while time.monotonic() < until:
        board.sleep(0.02)
        if time.monotonic() > fails:
            raise RuntimeError("by its moment")
""".format(lease=LEASE)

ENDS = [signal.SIGKILL, signal.SIGKILL, signal.SIGTERM, signal.SIGHUP, signal.SIGINT, None]
"""The signals that end it; without one it fails by itself."""


def moment(port: str, number: int) -> str:
    """Ends a program at a moment, and looks at the board; what was wrong."""
    luck = random.Random(f"{SEED} {number}")
    end, when = luck.choice(ENDS), luck.uniform(0, 1.5)
    words = [sys.executable, "-c", PROGRAM, port, f"{SEED} {number}"]
    child = subprocess.Popen(
        [*words, "1e9" if end else str(when)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert child.stdout is not None and child.stdout.readline() == "opens\n"
    if end is not None:
        time.sleep(when)
        child.send_signal(end)
    try:
        why = child.communicate(timeout=15)[1]
    except subprocess.TimeoutExpired:
        child.kill()
        return f"moment {number}, {end!r}: the program did not end"
    if end is None and "by its moment" not in why:
        return f"moment {number}: it has failed otherwise: {why}"
    if end is signal.SIGINT and "KeyboardInterrupt" not in why:
        return f"moment {number}: it has not heard Ctrl-C: {why}"
    time.sleep(LEASE + RAMP + SPARE)
    with sw.open(port) as board:
        for axis in board:
            if axis.moving:
                return f"moment {number}, {end!r} after {when:.3f} s: axis {axis.number} moves"
            try:
                at = axis.steps
            except sw.Uncertain as lost:
                return f"moment {number}, {end!r} after {when:.3f} s: {lost}"
            if axis.number == 3 and axis.move_by(-7).wait().steps != (at - 7,):
                return f"moment {number}, {end!r}: axis 3 does not move on from {at}"
    return ""


def test_programs_end_at_random_moments() -> None:
    ptys = [Pty() for _ in range(BOARDS)]

    def some(place: int) -> list[str]:
        return [moment(ptys[place].port, number) for number in range(place, MOMENTS, BOARDS)]

    try:
        with ThreadPoolExecutor(BOARDS) as pool:
            said = [words for part in pool.map(some, range(BOARDS)) for words in part if words]
    finally:
        for pty in ptys:
            pty.close()
    assert not said, "\n".join(said)
