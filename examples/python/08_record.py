"""Writes down what an axis does, as arrays and as a table."""

import sys

import stepwright_motion as sw

with sw.open(*sys.argv[1:]) as board:
    board.x.zero()
    with board.record() as log:
        board.x.move_to(1000).wait()
track = log.x  # its time, position, speed and state are arrays
print(len(track), "looks, the last at", track.position[-1])  # … at 1000.0
print("fastest:", round(max(track.speed)), "steps/s;", log.missed, "looks missed")
log.save("travel.csv")
