"""A G-code job on a simulated Pico by the command: python job.py STEPWRIGHT FOLDER-OF-ELVES FILE BAUD [OPTION…]

The Pico (stream.cjs) goes slower than real time, by its own clock. Its line is to be faster than BAUD all the
same: a host sends again what is not answered, and a line that is slower than that fills up. Its pins have the
last word: where the axes are, and how long the job took.
"""

import json
import os
import pty
import select
import socket
import subprocess
import sys
import threading
import tty

command, folder, job, baud, *options = sys.argv[1:]
here = os.path.dirname(os.path.abspath(__file__))
node = subprocess.Popen(
    ["node", os.path.join(here, "stream.cjs"), folder, "0"], stdout=subprocess.PIPE, text=True
)
port = int(node.stdout.readline().split()[1])
board = socket.create_connection(("127.0.0.1", port))
board.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
near, far = pty.openpty()
tty.setraw(far)
path = os.ttyname(far)


def bridge() -> None:
    while True:
        for ready in select.select([near, board], [], [])[0]:
            if ready is board:
                told = board.recv(4096)
                if not told:
                    return
                os.write(near, told)
            else:
                board.sendall(os.read(near, 4096))


threading.Thread(target=bridge, daemon=True).start()
gcode = [command, "gcode", job, "--port", path, "--baud", baud, "--format", "json", *options]
told = json.loads(subprocess.run(gcode, stdout=subprocess.PIPE, check=True, text=True).stdout)
board.shutdown(socket.SHUT_RDWR)
made = json.loads(node.stdout.readline())
print(
    f"  {made['steps']} steps to {made['position']}; {made['seconds']:.4f} s by its clock, planned "
    f"{told['planned_seconds']:.4f}; {made['slower']:.1f} times slower than real time; late "
    f"{told['late']}, sent again {told['sent_again']}"
)
assert made["position"] == told["position"], (made, told)
assert told["state"] == "ready" and told["late"] == 0, told
# From the first step to the last one: the path begins before and ends behind them.
assert 0 <= told["planned_seconds"] - made["seconds"] < 0.05, (made, told)
