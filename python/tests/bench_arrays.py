"""The time to make an array of a plan, compared with the time of the core for the plan.

``cargo xtask bench python`` prints and stores the table: ``python bench_arrays.py FILE [--check]``.
"""

from __future__ import annotations

import json
import sys
import time
from typing import Callable

import stepwright_motion as sw

STEPS = 1_000_000
TRIES = 9
MOST = 1.5
"""The array may take at most this many times as long."""

TRAVELS = {
    "trapezoid": {"accel": 50_000, "speed": 20_000},
    "s-curve": {"accel": 50_000, "speed": 20_000, "jerk": 500_000},
    "austin": {"accel": 50_000, "speed": 20_000},
}


def best(parts: dict[str, Callable[[], object]]) -> dict[str, float]:
    """The shortest time of several tries of each part in ms. The tries alternate."""
    found = dict.fromkeys(parts, float("inf"))
    for _ in range(TRIES):
        for name, part in parts.items():
            began = time.perf_counter()
            part()
            found[name] = min(found[name], (time.perf_counter() - began) * 1e3)
    return found


def main(path: str, check: bool) -> int:
    table = {}
    print(f"{STEPS} steps   core, ms   array, ms   ratio")
    for law, limits in TRAVELS.items():
        plan = sw.plan(law, STEPS, timer_hz=16_000_000, **limits)  # type: ignore[arg-type]
        native = plan._planned

        def array() -> object:
            del plan.__dict__["delays"]
            return plan.delays

        assert int(plan.delays.sum(dtype="uint64")) == native.walk()
        times = best({"core": native.walk, "array": array})
        ratio = times["array"] / times["core"]
        table[law] = {"ratio": round(ratio, 3), **{k: round(v, 2) for k, v in times.items()}}
        print(f"{law:<15} {times['core']:8.2f}   {times['array']:9.2f}   {ratio:5.2f}")
    if not check:
        with open(path, "w", encoding="utf-8") as file:
            json.dump({"steps": STEPS, "most": MOST, "laws": table}, file, indent=2)
            file.write("\n")
    return int(table["trapezoid"]["ratio"] > MOST)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], "--check" in sys.argv))
