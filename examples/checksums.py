#!/usr/bin/env python3
"""A master whose lines have checksums, in Python with pyserial.

Talks to a board that can `sum`, which a Mega and a virtual board do:

    stepwright board --pty            says `pty /dev/pts/5`
    python3 examples/checksums.py /dev/pts/5

A line ends with `*` and the CRC-8 of what stands before it, and so does its answer:
a digit that noise has changed is never an order. Moves the motor to and fro while
this program flips a bit of every fifth line, and ends with status 0 if each step was
as ordered all the same.
"""

import random
import sys
import time

import serial  # python3 -m pip install -r examples/requirements.txt


def crc8(line):
    """CRC-8/SMBUS: polynomial 0x07, begun with 0; `123456789` gives 0xF4."""
    crc = 0
    for byte in line:
        crc ^= byte
        for _ in range(8):
            crc = (crc << 1 ^ 0x07 if crc & 0x80 else crc << 1) & 0xFF
    return crc


class Master:
    """The master's end of the line."""

    def __init__(self, path, noise):
        self.port = serial.Serial(path, 115200, timeout=0.5, exclusive=True)
        self.dice = random.Random(1)
        self.noise = noise
        self.damaged = 0
        self.in_step()
        if "sum" not in self.words("?")["can"].split(","):
            sys.exit("this board can't check sums: it is an Uno's")

    def in_step(self):
        """Ends half a line that may stand in the board, and waits for its answer."""
        for _ in range(10):
            self.port.reset_input_buffer()
            self.port.write(b"#\rF*D5\r")
            if self.port.read_until(b"\r") and self.answer() in ("R", "B"):
                return
        sys.exit("no answer")

    def answer(self):
        """The next answer whose checksum is right; None if it does not come."""
        line = self.port.read_until(b"\r")
        bare, star, crc = line[:-1].rpartition(b"*")
        if not line.endswith(b"\r") or not star or crc != b"%02X" % crc8(bare):
            return None
        return bare.decode()

    def once(self, line):
        """Sends a line once; its answer, or None if either was lost or damaged."""
        sent = bytearray(b"%s*%02X\r" % (line.encode(), crc8(line.encode())))
        if self.noise and self.dice.random() < self.noise:
            sent[self.dice.randrange(len(sent) - 1)] ^= 1 << self.dice.randrange(8)
            self.damaged += 1
        self.port.write(sent)
        return self.answer()

    def words(self, line):
        """The answer to `?`: a dictionary of its words."""
        answer = self.ask(line)
        return dict(word.split("=") for word in answer.split() if "=" in word)

    def ask(self, line):
        """A line that is harmless twice, until it has arrived and is answered."""
        for _ in range(10):
            answer = self.once(line)
            if answer is None:
                self.in_step()
            elif answer != "E" or line == "V1" and not self.was_damaged():
                return answer
        sys.exit(f"{line} was refused, or never arrived")

    def was_damaged(self):
        """Whether the line that was just refused was another one when it arrived."""
        return self.words("?")["last"] == "sum"

    def move(self, steps):
        """Orders a travel. One line that does not arrive spoils the whole order, and
        nothing has moved; so it is said once more, from PO on."""
        for _ in range(20):
            before = self.ask("V1")
            lines = ["PO", "S50", "T200", "R99", f"G{steps:+}", "E"]
            if all(self.once(line) == "Y" for line in lines):
                return
            # Was it only the answer to E that got lost?
            self.in_step()
            if self.ask("F") == "B" or self.ask("V1") != before:
                return
        sys.exit("the order never arrived")

    def wait(self):
        """Waits until the motor rests; where it is."""
        while self.ask("F") == "B":
            time.sleep(0.05)
        return int(self.ask("V1"))


def main(path):
    master = Master(path, noise=0)
    master.ask("Z")
    master.wait()
    master.ask("I1")

    # A flipped digit: 4000 has become 4001, and the board notices.
    master.ask("PO")
    master.port.write(b"G+4001*0B\r")
    if master.answer() != "E" or not master.was_damaged():
        sys.exit("a damaged line was taken")

    master.noise = 0.2
    at = 0
    for steps in [500, -320, 77, -1000, 743] * 3:
        master.move(steps)
        at += steps
        rests = master.wait()
        print(f"{steps:+5} steps: at {rests}, {master.damaged} damaged lines so far")
        if rests != at:
            sys.exit(f"the motor is at {rests}, not at {at}")
    if master.damaged < 10:
        sys.exit("hardly a line was damaged")
    print("all as it should be")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(f"usage: {sys.argv[0]} PORT")
    main(sys.argv[1])
