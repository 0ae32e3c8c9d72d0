#!/usr/bin/env python3
"""A master for the Nano slave's serial line, in Python with pyserial.

Talks to a real board, or to a virtual one:

    stepwright board --pty            says `pty /dev/pts/5`
    python3 examples/master.py /dev/pts/5

Plays the Nano slave's example, an order of 4000 steps, and then its other lines.
Every line is answered before the next is sent. Ends with status 0 if each
answer was as it should be.
"""

import sys
import time

import serial  # python3 -m pip install -r examples/requirements.txt


class Master:
    """The master's end of the line: one line out, one answer back."""

    def __init__(self, path):
        self.port = serial.Serial(path, 115200, timeout=2, exclusive=True)
        # Half a line of an earlier master may stand in the slave: a bad line
        # ends it. A board that was reset by opening its port needs a moment.
        for _ in range(5):
            self.port.reset_input_buffer()
            self.port.write(b"#\r")
            if self.port.read_until(b"\r") == b"E\r":
                return
        sys.exit(f"no answer from {path}")

    def say(self, line):
        """Sends a line, and returns the answer without its CR."""
        self.port.write(line.encode() + b"\r")
        answer = self.port.read_until(b"\r")
        if not answer.endswith(b"\r"):
            sys.exit(f"no answer to {line}")
        print(f"{line:8} {answer[:-1].decode()}")
        return answer[:-1].decode()

    def expect(self, line, *allowed):
        """Sends a line whose answer must be one of those allowed."""
        answer = self.say(line)
        if answer not in allowed:
            sys.exit(f"{line} was answered {answer}, not {' or '.join(allowed)}")
        return answer

    def wait_until_ready(self, limit):
        """Asks F until the motor rests, for at most this many seconds."""
        end = time.monotonic() + limit
        while self.expect("F", "R", "B") == "B":
            if time.monotonic() > end:
                sys.exit(f"still busy after {limit} s")
            time.sleep(0.25)

    def wait_for_steps(self, steps, limit):
        """Asks V1 until the motor has made this many steps."""
        begin = int(self.say("V1"))
        end = time.monotonic() + limit
        while abs(int(self.say("V1")) - begin) < steps:
            if time.monotonic() > end:
                sys.exit(f"not {steps} steps further after {limit} s")
            time.sleep(0.05)


def main(path):
    master = Master(path)
    # Where the axis stands is 0, whatever went before.
    master.expect("Z", "Y")
    master.wait_until_ready(60)
    master.expect("I1", "Y")

    # The Nano slave's example: 50 steps/s to start and to stop, 1000 at the top,
    # 200 steps between, 4000 steps clockwise. It takes 4.4 s.
    for line in ["PO", "S5", "T100", "R200", "G+4000", "E"]:
        master.expect(line, "Y")
    master.expect("F", "B")
    master.expect("S6", "E")  # not while it travels
    master.wait_until_ready(60)
    master.expect("V1", "4000")

    # An endless run, and a soft stop: the position stays known.
    master.expect("I1", "Y")
    master.expect("V1", "0")
    master.expect("g-", "Y")
    master.wait_for_steps(100, 60)
    master.expect("Z", "Y")
    master.wait_until_ready(60)
    rest = int(master.say("V1"))
    if rest > -100 or int(master.say("V1")) != rest:
        sys.exit(f"the motor should rest below -100, not at {rest}")

    # A hard stop: the position is lost, until it is set again.
    master.expect("g+", "Y")
    master.wait_for_steps(10, 60)
    master.expect("K", "Y")
    master.expect("F", "R")
    master.expect("V1", "E")
    master.expect("I1", "Y")
    master.expect("V1", "0")
    print("all as it should be")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(f"usage: {sys.argv[0]} PORT")
    main(sys.argv[1])
