"""What can go wrong, and how a program hears of it."""

import sys

import stepwright_motion as sw

with sw.open(*sys.argv[1:]) as board:
    try:
        board.x.move_by(4000, speed=500_000)
    except sw.Refused as why:
        print("refused:", why.remedy)  # one axis takes ramps of up to …
    move = board.x.move_by(4000)
    board.x.stop()  # as another thread might
    try:
        move.wait()
    except sw.Stopped as why:
        print("stopped by:", why.reason)  # stop
