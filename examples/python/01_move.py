"""Moves an axis to 25 mm."""

import sys

import stepwright_motion as sw

with sw.open(*sys.argv[1:]) as board:  # a port; without one, a virtual board
    board.x.zero()
    board.x.steps_per_mm = 80
    outcome = board.x.move_to(25, "mm", speed="20mm/s").wait()
    print(outcome.kind, outcome.position)  # reached 25.0
