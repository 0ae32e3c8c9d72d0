"""A G-code job on a simulated Pico by the command: python job.py STEPWRIGHT FOLDER-OF-ELVES FILE [OPTION…]

The pins decide: the positions of the axes, and the duration of the job on the board's clock.
"""

import json
import os
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "../../../crates/stepwright-cli/tests/senders"))

from own_time import OwnTime  # noqa: E402

command, folder, job, *options = sys.argv[1:]
pico = OwnTime(["node", f"{HERE}/stream.cjs", folder, "0"])
gcode = [command, "gcode", job, "--port", pico.path, "--format", "json", *options]
told = subprocess.run(gcode, env=pico.env, stdout=subprocess.PIPE, check=True, text=True).stdout
told, made = json.loads(told), pico.end()
print(
    f"  {made['steps']} steps to {made['position']}; {made['seconds']:.4f} s by its clock, planned "
    f"{told['planned_seconds']:.4f}; {made['slower']:.1f} times slower than real time; late "
    f"{told['late']}, sent again {told['sent_again']}"
)
assert made["position"] == told["position"], (made, told)
assert told["state"] == "ready" and told["late"] == 0 and told["sent_again"] == 0, told
# From the first step to the last one: the path begins before and ends after them.
assert 0 <= told["planned_seconds"] - made["seconds"] < 0.05, (made, told)
