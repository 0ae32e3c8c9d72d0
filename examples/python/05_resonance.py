"""Runs an axis at many speeds, with a reading at each: where does the machine ring?"""

import sys

import stepwright_motion as sw

with sw.open(*sys.argv[1:]) as board, board.record() as log:
    for speed in range(200, 1001, 100):
        with board.x.run(speed, accel=20_000):  # as long as the block lasts
            board.sleep(0.2)
            print(f"{speed} steps/s: {board.x.speed_now:.0f} measured")  # and your sensor's
log.save("resonance.csv")
print("looks that were missed:", log.missed)
