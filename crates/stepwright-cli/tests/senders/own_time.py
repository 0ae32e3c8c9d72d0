"""A simulated board that plays streams, as a serial port for the command.

It may go slower than real time. So the command lives in the board's time: clock.c reads what the simulator writes.
"""

import json
import os
import pty
import re
import select
import socket
import subprocess
import tempfile
import threading
import tty

HERE = os.path.dirname(os.path.abspath(__file__))


class OwnTime:
    """A board at the serial port `path`, for a command with the environment `env`.

    `words` begin its simulator, and a file for its time comes behind them.
    """

    def __init__(self, words):
        self.folder = tempfile.TemporaryDirectory()
        library, clock = f"{self.folder.name}/clock.so", f"{self.folder.name}/clock"
        build = ["gcc", "-O1", "-Wall", "-shared", "-fPIC", "-o", library, f"{HERE}/clock.c"]
        subprocess.run(build, check=True)
        with open(clock, "wb") as file:
            file.write(bytes(8))
        self.env = dict(os.environ, BOARD_CLOCK=clock, LD_PRELOAD=library)
        self.board = subprocess.Popen(
            [*words, clock], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        kind, at = self.board.stdout.readline().split()
        self.socket = None
        if kind == "pty":
            self.path = at
        else:
            self._bridge(int(at))

    def _bridge(self, port):
        """A simulator without pseudo-terminals."""
        self.socket = socket.create_connection(("127.0.0.1", port))
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.near, self.far = pty.openpty()
        tty.setraw(self.far)
        self.path = os.ttyname(self.far)
        threading.Thread(target=self._carry, daemon=True).start()

    def _carry(self):
        while True:
            for ready in select.select([self.near, self.socket], [], [])[0]:
                if ready is self.socket:
                    told = self.socket.recv(4096)
                    if not told:
                        return
                    os.write(self.near, told)
                else:
                    self.socket.sendall(os.read(self.near, 4096))

    def end(self):
        """By the edges of its pins: steps, the position of each axis, s from the first step to the last one."""
        if self.socket:
            self.socket.shutdown(socket.SHUT_RDWR)
            told, _ = self.board.communicate(timeout=60)
            made = json.loads(told)
        else:
            told, _ = self.board.communicate("end\n", timeout=60)
            axes = re.findall(r"axis \d: (\d+) steps, from 0 to (-?\d+)", told)
            begun, ended = re.search(r"steps from ([\d.]+) s to ([\d.]+) s", told).groups()
            made = {
                "steps": sum(int(steps) for steps, _ in axes),
                "position": [int(place) for _, place in axes],
                "seconds": float(ended) - float(begun),
            }
        self.folder.cleanup()
        return made
