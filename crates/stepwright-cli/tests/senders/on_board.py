"""A job with limited jerk from CNCjs, on a simulated board: on_board.py STEPWRIGHT CHORDS BOARD…

    CNCjs ─ grbl's protocol ─► stepwright grbl --port ─ frames ─► the board's binary, in its own time

BOARD are the words that begin its simulator. The pins have the last word: where the axes are, and how long the
job took by the board's clock. 31,500 chords are ten minutes of that.
"""

import json
import subprocess
import sys
import tempfile
import time

from line import STEPS, Grbl, spiral
from own_time import OwnTime
from senders import cncjs_job

# In mm/min, steps/mm, mm/s², mm/s³: what may change at once, and the rest.
FEED, JUMP, ACCEL, JERK = 1200, 300, 1000, 10_000
SETTINGS = "".join(f"$12{a}={ACCEL}\n$14{a}={JUMP}\n$15{a}={JERK}\n" for a in range(3))


def planned(command, folder, job):
    """What `--plan` says, in s."""
    path = f"{folder}/plan.nc"
    with open(path, "w", encoding="ascii") as file:
        file.write("\n".join(job) + "\n")
    words = [command, "gcode", path, "--plan", "--format", "json", "--machine", "none"]
    words += ["--steps-per-rev", str(STEPS), "--mm-per-rev", "1", "--top-speed", "500mm/s"]
    words += ["--accel", f"{ACCEL}mm/s2", "--start-speed", f"{JUMP / 60}mm/s"]
    words += ["--jerk", f"{JERK}mm/s3"]
    plan = subprocess.run(words, stdout=subprocess.PIPE, check=True, text=True).stdout
    return json.loads(plan)["seconds"]


def main():
    command, chords, *words = sys.argv[1:]
    job, end = spiral(int(chords), FEED)
    with tempfile.TemporaryDirectory() as folder:
        plan = planned(command, folder, job)
        board = OwnTime(words)
        grbl = Grbl(command, folder, ["--port", board.path], SETTINGS, board.env)
        begun = time.monotonic()
        with cncjs_job(grbl, folder, job) as (_, finish):
            finish()
        assert grbl.until("Idle") == end
        took = time.monotonic() - begun
        assert grbl.end() == end
        made = board.end()
        print(
            f"  {made['steps']} steps to {made['position']}; {made['seconds']:.4f} s by the board's clock, planned "
            f"{plan:.4f}, {took:.0f} s by ours; at most {grbl.most} bytes under way"
        )
        assert made["position"] == end, (made, end)
        assert not grbl.errors, grbl.errors
        assert grbl.most <= 127, grbl.most
        assert "late steps 0" in grbl.said, grbl.said
        # The session plans as the lines come, with 128 moves ahead of it; a busy sender may begin with few.
        assert -0.05 < made["seconds"] - plan < 0.5 + 0.001 * plan, (made, plan)


if __name__ == "__main__":
    main()
