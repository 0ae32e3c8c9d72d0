"""The Pico's program on another emulator, rp2040-pio-emulator: is every edge of STEP at the computed cycle?

Usage: second_opinion.py WORDS.json [WORDS]

The program is the firmware's, as loaded by the trial in rp2040js. The words are random, with short waits and
few steps, as this emulator takes a second for some 100,000 cycles.
"""
import json
import random
import sys
from collections import deque

from pioemu import State, emulate
from pioemu.shift_register import ShiftRegister

PULSE = 125
WRAP = 8
# The emulator knows no IRQ: an instruction without effect of the same duration replaces it.
IRQ, NOTHING = 0xC010, 0xA042


def edges(code, words, steps):
    """The times at which STEP rises, and the widths of its pulses."""
    rises, widths = [], set()
    run = emulate(
        code,
        initial_state=State(
            transmit_fifo=deque(words),
            output_shift_register=ShiftRegister(0, 32),
        ),
        stop_when=lambda opcode, state: len(rises) > steps or not state.transmit_fifo and state.program_counter == 0,
        auto_pull=True,
        pull_threshold=32,
        shift_osr_right=True,
        out_base=8,
        out_count=1,
        side_set_base=0,
        side_set_count=1,
        wrap_target=0,
        wrap_top=WRAP,
    )
    for before, after in run:
        was, level = before.pin_values & 1, after.pin_values & 1
        if level and not was:
            rises.append(before.clock)
        elif was and not level:
            widths.add(before.clock - rises[-1])
    return rises, widths


def main():
    code = json.load(open(sys.argv[1]))["code"]
    code = [NOTHING if line == IRQ else line for line in code]
    count = int(sys.argv[2]) if len(sys.argv) > 2 else 10_000
    random.seed(20261126)
    words, want, at = [], [], 0
    for _ in range(count // 2):
        wait, steps = random.randrange(50), random.choice((1, 1, 1, 2, 2, 4))
        words += [wait, (steps - 1) << 1 | random.randrange(2)]
        for _ in range(steps):
            at += wait + PULSE + 7
            want.append(at)
    rises, widths = edges(code, words, len(want))
    assert len(rises) == len(want), (len(rises), len(want))
    apart = {rise - edge for rise, edge in zip(rises, want)}
    assert len(apart) == 1, f"edges are off by {apart} cycles"
    assert widths == {PULSE}, f"pulses of {widths} cycles"
    print(f"{len(words)} words, {len(rises)} edges, each at the computed cycle")


if __name__ == "__main__":
    main()
