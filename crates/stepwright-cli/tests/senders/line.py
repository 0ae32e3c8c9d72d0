"""The line between a sender and `stepwright grbl`, listened to."""

import contextlib
import os
import pty
import re
import select
import subprocess
import threading
import time
import tty

# Settings of the machine: 100 steps/mm, 500 mm/s, 5000 mm/s², 10 mm/s at once.
STEPS = 100
KEPT = "".join(
    f"$10{a}={STEPS}\n$11{a}=30000\n$12{a}=5000\n$14{a}=600\n$13{a}=400\n" for a in range(3)
) + "$10=3\n$25=3000\n"

REAL_TIME = {0x18, 0x21, 0x3F, 0x7E} | set(range(0x80, 0x100))


class Grbl:
    """A virtual machine on a pseudo-terminal of its own, behind a second one that counts."""

    def __init__(self, command, folder, extra=(), settings="", env=None):
        kept = os.path.join(folder, "kept.txt")
        with open(kept, "w", encoding="ascii") as file:
            file.write(KEPT + settings)
        words = [command, "grbl", "--pty", "--keep", kept, *extra]
        self.process = subprocess.Popen(
            words, env=env, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        first = self.process.stdout.readline().split()
        assert first[:1] == ["pty"], first
        self.line = os.open(first[1], os.O_RDWR | os.O_NOCTTY)
        tty.setraw(self.line)
        master, slave = pty.openpty()
        tty.setraw(master)
        tty.setraw(slave)
        # As on a cable, what nobody reads is lost.
        os.set_blocking(master, False)
        self.master, self.slave = master, slave
        self.path = os.ttyname(slave)
        # Lengths of lines that have no answer yet, and of the one that is being sent.
        self.sent, self.open, self.most, self.old = [], 0, 0, 0
        self.heard, self.errors = b"", []
        self.status = self.said = ""
        self.lock = threading.Lock()
        self.running = True
        self.threads = [threading.Thread(target=self._carry, daemon=True)]
        self.threads[0].start()

    def _carry(self):
        while self.running:
            ready, _, _ = select.select([self.master, self.line], [], [], 0.05)
            if self.master in ready:
                data = os.read(self.master, 4096)
                self._count(data)
                os.write(self.line, data)
            if self.line in ready:
                data = os.read(self.line, 4096)
                self._hear(data)
                with contextlib.suppress(BlockingIOError):
                    os.write(self.master, data)

    def _count(self, data):
        for byte in data:
            if byte == 0x18:
                # Answers to lines before it may be on their way.
                self.old += len(self.sent)
                self.sent, self.open = [], 0
            if byte in REAL_TIME:
                continue
            self.open += 1
            if byte in b"\r\n":
                self.sent.append(self.open)
                self.open = 0
            self.most = max(self.most, sum(self.sent) + self.open)

    def _hear(self, data):
        self.heard += data
        *lines, self.heard = self.heard.split(b"\n")
        for line in lines:
            text = line.decode("ascii").strip()
            if text.startswith("Grbl"):
                self.old = 0
            if text == "ok" or text.startswith("error:"):
                if self.old:
                    self.old -= 1
                elif self.sent:
                    self.sent.pop(0)
                else:
                    self.errors.append("an answer to nothing")
            if text.startswith(("error:", "ALARM:")):
                self.errors.append(text)
            if text.startswith("<"):
                with self.lock:
                    self.status = text

    def say(self, data):
        """Real-time bytes, past the sender."""
        os.write(self.line, data)

    def order(self, text):
        """A line of ours, before the sender comes."""
        data = text.encode() + b"\n"
        self._count(data)
        self.say(data)
        while self.sent:
            time.sleep(0.005)

    def ask(self):
        """A status report of now: its state, and the position in steps."""
        with self.lock:
            self.status = ""
        self.say(b"?")
        for _ in range(400):
            with self.lock:
                status = self.status
            if status:
                break
            time.sleep(0.005)
        found = re.match(r"<(\w+(?::\d)?)\|MPos:([-\d.,]+)", status)
        assert found, f"no status: {status!r}"
        state, place = found.groups()
        return state, [round(float(x) * STEPS) for x in place.split(",")]

    def until(self, *states, within=60.0):
        """Waits for one of these states; the position then."""
        end = time.monotonic() + within
        while time.monotonic() < end:
            state, place = self.ask()
            if state in states:
                return place
            time.sleep(0.02)
        raise AssertionError(f"{state} and not {states}")

    def end(self):
        """Ctrl-C; the machine's own count of steps."""
        self.running = False
        self.threads[0].join()
        self.process.send_signal(2)
        _, self.said = self.process.communicate(timeout=20)
        for end in (self.line, self.master, self.slave):
            os.close(end)
        place = re.search(r"position (-?\d+) (-?\d+) (-?\d+) steps", self.said)
        assert place, self.said
        return [int(x) for x in place.groups()]


def spiral(lines, feed=12000):
    """A spiral of so many chords in 3 decimals, and where it ends, in steps."""
    import math

    job = ["G21 G90 G94 (a spiral)", f"G1 F{feed}"]
    for n in range(1, lines + 1):
        radius, angle = 30 * n / lines, 2 * math.pi * n / 250
        job.append(f"X{radius * math.cos(angle):.3f} Y{radius * math.sin(angle):.3f}")
    job += ["G0 Z1.5", "X12.34 Y-5.67 ; the end"]
    return job, [1234, -567, 150]
