#!/usr/bin/env python3
"""A master in Python that shares a board with `stepwright serve` or `stepwright move`.

    stepwright board --pty                 says `pty /dev/pts/5`
    stepwright serve --port /dev/pts/5
    python3 examples/guest.py /dev/pts/5   says where axis 1 is

A free port is opened with pyserial. Of a port that a stepwright holds, the holder has a socket with
the same lines: questions, changes of a travel and stops. Orders are refused there, because their
lines would mingle with those of the holder.
"""

import os
import socket
import sys

import serial  # python3 -m pip install -r examples/requirements.txt


class Guest:
    """The line to a board through the program that holds its port."""

    def __init__(self, path):
        runtime = os.environ.get("XDG_RUNTIME_DIR")
        folder = f"{runtime}/stepwright" if runtime else f"/tmp/stepwright-{os.getuid()}"
        name = os.path.realpath(path).lstrip("/").replace("/", "-")
        self.socket = socket.socket(socket.AF_UNIX)
        self.socket.settimeout(5)
        self.socket.connect(f"{folder}/{name}.socket")

    def write(self, line):
        self.socket.sendall(line)

    def read_until(self, end):
        """Reads until these bytes have come."""
        answer = b""
        while not answer.endswith(end):
            more = self.socket.recv(64)
            if not more:
                break
            answer += more
        return answer


def open_line(path):
    """The line to the board on this port, by whoever has the port."""
    try:
        return serial.Serial(path, 115200, timeout=2, exclusive=True)
    except serial.SerialException:
        return Guest(path)


def say(line, text):
    """Sends a line, and returns the answer without its CR."""
    line.write(text.encode() + b"\r")
    return line.read_until(b"\r").decode().rstrip("\r")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: guest.py PORT")
    print(f"axis 1 is at {say(open_line(sys.argv[1]), 'V1')}")
