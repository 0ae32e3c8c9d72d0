"""Plans, compared with the same travels on chips, delay by delay.

``STEPWRIGHT_TICKS`` names the files with the lines of the chips, one file for each program. ``cargo xtask
ticks`` runs the programs of ``firmware/ticks`` on simulated chips and writes these files.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest
import seeded

import stepwright_motion as sw

FILES = [Path(file) for file in os.environ.get("STEPWRIGHT_TICKS", "").split(os.pathsep) if file]


@pytest.mark.skipif(not FILES, reason="STEPWRIGHT_TICKS names no chip's lines")
@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_a_chip_plans_the_same_delays(file: Path) -> None:
    """A line has a checksum of all delays. A delay that is a tick off changes it."""
    seen: dict[str, int] = {}
    for said in file.read_text().splitlines():
        law, number, *_ = said.split(" ")
        if law not in seeded.PLACES:
            continue  # a board's own planner, which Python has not
        assert int(number) == seen.get(law, 0), said
        seen[law] = int(number) + 1
        try:
            plan = sw.plan(law, **seeded.travel(law, int(number)))
        except ValueError:
            plan = None
        assert said == seeded.line(law, int(number), plan)
    assert seen and len(set(seen.values())) == 1, seen
    print(f"{file.stem}: {min(seen.values())} travels of {', '.join(seen)}")


def test_every_law_has_a_chip() -> None:
    assert set(seeded.PLACES) == set(seeded.TAKES)
    if FILES:
        said = {line.split(" ")[0] for file in FILES for line in file.read_text().splitlines()}
        assert set(seeded.PLACES) <= said


def test_a_delay_that_is_a_tick_off_is_another_line() -> None:
    values = seeded.travel("austin", 1)
    plan = sw.plan("austin", **values)
    right = seeded.line("austin", 1, plan)

    class Off:
        pulses = plan.pulses
        delays = [*plan.delays[:-1], plan.delays[-1] + 1]

    assert seeded.line("austin", 1, Off()) != right  # type: ignore[arg-type]
    assert right == seeded.line("austin", 1, plan)
