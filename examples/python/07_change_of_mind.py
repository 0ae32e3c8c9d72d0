"""Sends a motor elsewhere while it is on its way."""

import sys

import stepwright_motion as sw

with sw.open(*sys.argv[1:]) as board:
    board.x.zero()
    move = board.x.move_to(4000)
    board.sleep(0.5)
    print("at", board.x.steps, "of 4000; back to 100")
    move.retarget(100)
    print(move.wait().words, board.x.steps)  # every axis is where it was ordered to 100
