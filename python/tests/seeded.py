"""The seeded travels of ``firmware/ticks/src/lib.rs``, written a second time: the results of the chips
are checked by other code than their own. That file says how the travels are drawn."""

from __future__ import annotations

import zlib
from typing import Any, Optional

import stepwright_motion as sw

MASK = 0xFFFFFFFF

PLACES = {
    "trapezoid": 0,
    "s-curve": 1,
    "ramp": 2,
    "austin": 3,
    "austin-fixed": 4,
    "linear-factor": 5,
    "power": 6,
    "piecewise": 7,
}
"""The laws of ``sw.plan`` with the seed of each."""

TAKES = {
    "trapezoid": ("accel", "speed", "decel", "start_speed"),
    "s-curve": ("accel", "speed", "decel", "start_speed", "jerk"),
    "ramp": ("speed", "start_speed", "ramp"),
    "austin": ("accel", "speed", "decel", "first", "divisor"),
    "austin-fixed": ("c0", "c_min"),
    "linear-factor": ("accel", "speed", "decel", "first", "knee"),
    "power": ("accel", "speed", "decel", "first", "power"),
    "piecewise": ("accel", "speed", "decel", "first", "breaks"),
}
"""The parameters of each law, beside the steps and the timer."""


class Luck:
    """Marsaglia's xorshift of 32 bits."""

    def __init__(self, place: int, number: int):
        seed = ((number + 1) * 2654435769 + place * 2246822519) & MASK
        self._x = seed or 1
        for _ in range(8):
            self._next()

    def _next(self) -> int:
        x = self._x
        x ^= x << 13 & MASK
        x ^= x >> 17
        x ^= x << 5 & MASK
        self._x = x
        return x

    def below(self, limit: int) -> int:
        """0 to ``limit`` - 1."""
        return self._next() % limit

    def about(self, low: int, high: int) -> int:
        """A number that is equally likely between any two neighbouring powers of two."""
        size = 1 << low + self.below(high - low)
        return size + self.below(size)


def thousandths(value: int) -> str:
    """A value in thousandths as text, without the rounding of a float."""
    return f"{value // 1000}.{value % 1000:03}"


def travel(law: str, number: int) -> dict[str, Any]:
    """The arguments for ``sw.plan``."""
    luck = Luck(PLACES[law], number)
    timer = (1_000_000, 2_000_000, 16_000_000, 84_000_000)[luck.below(4)]
    steps = luck.about(0, 8)
    speed = luck.about(15, 25)
    accel = luck.about(16, 28)
    decel = accel if luck.below(2) == 0 else luck.about(16, 28)
    start = 0 if luck.below(2) == 0 else speed // 20
    drawn: dict[str, Any] = {
        "speed": thousandths(speed),
        "accel": thousandths(accel),
        "decel": thousandths(decel),
        "start_speed": thousandths(start),
        "jerk": luck.about(10, 24),
        "ramp": luck.about(0, 9),
        "first": ("exact", "0.676", "c1")[luck.below(3)],
        "divisor": ("4n+1", "2n")[luck.below(2)],
        "knee": float(thousandths(luck.below(901))),
        "power": 2 + luck.below(8),
        "breaks": luck.below(17),
        "c0": luck.about(11, 17),
        "c_min": luck.about(6, 12),
    }
    values = {"steps": steps, "timer_hz": timer, **{name: drawn[name] for name in TAKES[law]}}
    if "divisor" in values:
        # c/2n has its own first delay; 4n + 1 is the default.
        del values["first" if values["divisor"] == "2n" else "divisor"]
    return values


def line(law: str, number: int, plan: Optional[sw.Plan]) -> str:
    """The line of a chip for a travel with this plan; ``None`` if the plan was refused."""
    if plan is None:
        return f"{law} {number} refused"
    words = (int(delay).to_bytes(4, "little") for delay in plan.delays)
    return f"{law} {number} {plan.pulses} {zlib.crc32(b''.join(words)):08x}"
