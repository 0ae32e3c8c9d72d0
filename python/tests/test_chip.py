"""Plans and runs, compared with the pins of a simulated Uno, which runs the real firmware.

``STEPWRIGHT_SIM`` is the simulator (``cargo xtask sim`` builds it), ``STEPWRIGHT_FIRMWARE`` the folder
of the firmware images.
"""

from __future__ import annotations

import math
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest
from conftest import COMMAND

import stepwright_motion as sw

SIM = os.environ.get("STEPWRIGHT_SIM")
FIRMWARE = Path(os.environ.get("STEPWRIGHT_FIRMWARE", "."))
pytestmark = pytest.mark.skipif(SIM is None, reason="STEPWRIGHT_SIM names no simulator")

STEP = {"x": "D2", "y": "D3", "z": "D4"}
"""The pins of a CNC shield."""
HZ = 16_000_000


class Chip:
    """A simulated Uno or another board that runs a program and dumps its pins."""

    def __init__(self, folder: Path, program: str, board: str = "uno"):
        self._dump = folder / "pins.vcd"
        elf = FIRMWARE / (f"{board}-{program}.elf" if program else f"{board}.elf")
        words = [str(SIM), board, "--elf", str(elf), "--vcd", str(self._dump)]
        self._process = subprocess.Popen(
            words,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )
        assert self._process.stdout is not None
        said = self._process.stdout.readline()
        assert said.startswith("pty "), said
        self.port = said.split()[1]

    def end(self) -> None:
        """Ends the simulator, so that its dump is complete."""
        if self._process.poll() is None:
            self._process.communicate("end\n", timeout=20)

    def rises(self, pin: str) -> list[int]:
        """The times at which a pin rose, in cycles."""
        self.end()
        sign, now, found = "", 0, []
        unit = 0.0
        for line in self._dump.read_text().splitlines():
            if line.startswith("$timescale"):
                number = "".join(line.split()[1:-1])
                size = {"ps": 1e-12, "ns": 1e-9, "us": 1e-6}[number[-2:]]
                unit = float(number[:-2] or 1) * size * HZ
            elif line.startswith("$var") and line.split()[4] == pin:
                sign = line.split()[3]
            elif line.startswith("#"):
                now = round(int(line[1:]) * unit)
            elif sign and line == f"1{sign}":
                found.append(now)
        return found


TICK_HZ = 1_000_000
"""The timer of the laws. A command orders their constants in its ticks."""
LISTED = {"c0": round(0.676 * TICK_HZ * math.sqrt(2 / 2000)), "c_min": round(TICK_HZ / 800)}
"""The constants of the published listing for 2000 steps/s² and 800 steps/s: Eq 7, 15 and 2."""

LAWS: list[tuple[str, str, int, dict[str, Any], dict[str, Any]]] = [
    ("", "trapezoid", 700, {"accel": 4000, "speed": 2000, "start_speed": 50}, {}),
    ("", "trapezoid", 900, {"accel": 20000, "speed": 3000, "start_speed": 0, "decel": 9000}, {}),
    ("", "ramp", 800, {"ramp": 150, "speed": 2000, "start_speed": 100}, {}),
    ("laws", "austin", 600, {"accel": 2000, "speed": 900}, {}),
    ("laws", "austin", 500, {"accel": 2000, "speed": 900, "changes": [(100, 500)]}, {}),
    ("laws", "austin-fixed", 400, LISTED, {"accel": 2000, "speed": 800}),
    ("transitions", "linear-factor", 600, {"accel": 2000, "speed": 800}, {}),
    ("transitions", "piecewise", 500, {"accel": 900, "speed": 450}, {}),
    ("power-term", "power", 150, {"accel": 200, "speed": 95}, {}),
    ("mega", "s-curve", 900, {"accel": 8000, "speed": 2000, "start_speed": 0, "jerk": 90_000}, {}),
    (
        "mega",
        "s-curve",
        300,
        {"accel": 9000, "speed": 3000, "start_speed": 0, "decel": 5000, "jerk": 80_000},
        {},
    ),
]
"""A program, or the controller of an Uno or of a Mega; a law, its steps and values; the values for the
command, if they differ."""

OPTIONS = {"accel": "--accel", "speed": "--top-speed", "start_speed": "--start-speed", "ramp": "--ramp"}


@pytest.mark.parametrize(("program", "law", "steps", "limits", "ordered"), LAWS)
def test_the_chip_makes_the_planned_steps(
    tmp_path: Path,
    program: str,
    law: str,
    steps: int,
    limits: dict[str, Any],
    ordered: dict[str, Any],
) -> None:
    """Each edge is at its planned time, except for the time to enter the interrupt."""
    plan = sw.plan(law, steps, timer_hz=TICK_HZ if limits is LISTED else HZ, **limits)
    mega = program == "mega"
    controller = mega or not program
    chip = Chip(tmp_path, "", "mega") if mega else Chip(tmp_path, program)
    try:
        if controller and law != "ramp":
            with sw.open(chip.port) as board:
                board.x.move_by(steps, **limits).wait()
        else:
            words = [COMMAND, "move", str(steps), "--port", chip.port]
            # The ramp in steps is the controller's default.
            words += ["--law", law] if program else []
            for name, value in (ordered or limits).items():
                if name == "changes":
                    words += [word for after, to in value for word in ("--change", f"{after}:{to}")]
                else:
                    words += [OPTIONS[name], str(value)]
            subprocess.run(words, check=True, env={"STEPWRIGHT_MACHINE": "none"}, stdout=subprocess.DEVNULL)
        rises = chip.rises(STEP["x"])
    finally:
        chip.end()
    assert len(rises) == steps
    ticks = [int(tick) * HZ // plan.timer_hz for tick in plan.ticks]
    off = [rise - rises[0] - tick for rise, tick in zip(rises, ticks)]
    # Allows for another interrupt, and for the rounding of the controller's runs, 1 µs.
    assert max(map(abs, off)) <= (250 if controller else 40), (min(off), max(off))
    # On average the steps are neither early nor late.
    assert abs(sum(off) / steps) <= 40


def test_cycles_are_played_by_the_chip(tmp_path: Path) -> None:
    file = Path(__file__).parents[2] / "examples" / "cycles" / "readme.toml"
    chip = Chip(tmp_path, "cycles")
    try:
        run = sw.cycle(file).run(chip.port)
    finally:
        chip.end()
    there = sw.cycle(file).run()
    assert run.positions == there.positions and run.names == there.names
    assert run.duration == pytest.approx(there.duration, abs=0.05)
    assert len(run.x) > 5 and run.late == 0


def test_what_runs_another_program_says_so(tmp_path: Path) -> None:
    file = Path(__file__).parents[2] / "examples" / "cycles" / "readme.toml"
    chip = Chip(tmp_path, "laws")
    try:
        with pytest.raises(ConnectionError, match="runs another program.*flash"):
            sw.cycle(file).run(chip.port)
        with pytest.raises(sw.CantOpen, match="flash the controller"):
            sw.open(chip.port)
    finally:
        chip.end()


def test_a_killed_script_is_missed_by_the_chip(tmp_path: Path) -> None:
    """By the pins alone: the last step comes within the lease and the ramp."""
    chip = Chip(tmp_path, "")
    program = (
        "import stepwright_motion as sw\n"
        f"board = sw.open({chip.port!r}, lease=0.5)\n"
        "board.x.run(1000, accel=10_000)\n"
        "print('moves', flush=True)\n"
        "board.sleep(60)\n"
    )
    try:
        child = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
        assert child.stdout is not None and child.stdout.readline() == "moves\n"
        time.sleep(0.5)
        child.kill()
        child.communicate()
        time.sleep(2.0)
        with sw.open(chip.port) as board:
            assert not board.moving
            at = board.x.steps
        rises = chip.rises(STEP["x"])
    finally:
        chip.end()
    assert len(rises) == at
    # The motor stood for at least a second before this look.
    assert (rises[-1] - rises[0]) / HZ < 0.5 + 0.5 + 0.2 + 0.3
