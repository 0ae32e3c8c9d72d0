"""Two axes move while a camera goes on, by asyncio."""

import asyncio
import sys

import stepwright_motion as sw


async def main(board):
    camera = asyncio.ensure_future(asyncio.sleep(0.5, "a picture"))
    moves = board.x.move_by(400), board.y.move_by(-200)
    print(await asyncio.gather(*moves))
    print(await camera)


with sw.open(*sys.argv[1:]) as board:
    asyncio.run(main(board))
