"""Scans an axis in 100 stops, with a reading at each, into a table."""

import math
import sys

import stepwright_motion as sw

with sw.open(*sys.argv[1:]) as board, open("scan.csv", "w") as table:
    board.x.zero()
    board.x.steps_per_mm, board.x.start_speed = 80, "5mm/s"
    for stop in range(100):
        place = board.x.move_to(stop * 0.1, "mm").wait().position
        reading = math.sin(place)  # your instrument's
        print(place, reading, sep=",", file=table)
print(sum(1 for _ in open("scan.csv")), "readings")  # 100 readings
