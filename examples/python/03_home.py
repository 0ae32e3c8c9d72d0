"""Finds the end switch of an axis, and calls that place 0."""

import sys

import stepwright_motion as sw

with sw.open(sys.argv[1]) if sys.argv[1:] else sw.virtual(switches={"x": -300}) as board:
    board.settings.switches = 1  # axis 1 has one
    outcome = board.x.home(within=2000).wait()
    print(outcome.words)  # homed: 0 is where its switch closes
    print(board.x.steps, "steps from it")  # 50 steps from it
