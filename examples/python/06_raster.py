"""Two axes along the rows of a field, to and fro, all along straight lines."""

import sys

import stepwright_motion as sw

with sw.open(*sys.argv[1:]) as board:
    for axis in (board.x, board.y):
        axis.zero()
        axis.steps_per_mm = 80
    for row in range(4):
        board.line_to(x=0 if row % 2 else 10, speed="20mm/s").wait()
        board.line_to(y=row + 1, speed="20mm/s").wait()
    print(board.x.position, board.y.position)  # 0.0 4.0
