"""Moves two boards in step: both have arrived before either goes on."""

import sys

import stepwright_motion as sw

ports = [*sys.argv[1:], "virtual", "virtual"]
with sw.open(ports[0]) as left, sw.open(ports[1]) as right:
    boards = (left, right)
    for board in boards:
        board.x.zero()
    for place in (200, 400, -100):
        moves = [board.x.move_to(place) for board in boards]
        print([move.wait().position for move in moves])  # [200.0, 200.0], …
