//! Random stories on a simulated chip, judged from outside as on the virtual board.

use std::collections::VecDeque;

use stepwright_sim::{Description, Edge, Pin};
use stepwright_stress::make::{Taste, story_on};
use stepwright_stress::story::{Can, Input};
use stepwright_stress::{Bench, Board as Nature, Fault, Player, Reset, Rules, Story, Sum};

use crate::board::{AXES, HZ};
use crate::{Board, Cause, Chip, Image};

/// The cycles of a byte on the line, rounded up.
const BYTE: u64 = 1389;

/// The properties of a board as seen from outside.
pub fn nature(board: Board) -> Nature {
    // All of our boards have the same costs, and so does the virtual Uno.
    let cost = Description::uno().board.cost;
    Nature {
        longer: cost.longer,
        can: Can { jerk: board == Board::Mega },
        // An interrupt of the line before a step; with other axes moving also their rare events,
        // which are compiled.
        jitter: (200.0, 2500.0),
        slack: 8,
        plans: true,
        ..Nature::simulated(HZ as u32, false, AXES as u8, cost.ticks, BYTE as u32)
    }
}

/// The story of a seed: a short one.
pub fn story(board: Board, seed: u64) -> Story {
    story_on(seed, nature(board), Taste::CHIP)
}

/// Plays a story on a chip with this firmware, whatever board the story was made for: its text
/// contains less than what is known of a chip.
///
/// # Errors
/// The first violated rule.
pub fn play(board: Board, image: &Image, story: &Story, rules: Rules) -> Result<Sum, Fault> {
    let mut bench = OnChip { chip: Chip::new(board, image), said: VecDeque::new(), low: 0 };
    bench.wake();
    let story = Story { board: nature(board), ..story.clone() };
    let mut player = Player::new(&story, rules);
    while let Some(reset) = player.play(&mut bench)? {
        match reset {
            Reset::Power => bench.chip.power_loss(0),
            Reset::Blink => bench.chip.reset_by(Cause::Power),
            Reset::Button => bench.chip.reset_by(Cause::Button),
            Reset::Watchdog => bench.chip.reset_by(Cause::Watchdog),
        }
        bench.wake();
    }
    Ok(player.sum(&bench))
}

/// A chip as seen from outside.
struct OnChip {
    chip: Chip,
    said: VecDeque<(u64, u8)>,
    /// The time of power-up, when all pins were low.
    low: u64,
}

impl OnChip {
    /// Waits for the start of the board, a few milliseconds, until it answers.
    fn wake(&mut self) {
        self.low = self.chip.now();
        // A line sent during the start would never be answered.
        self.chip.run_for(HZ / 200);
        for _ in 0..10 {
            if self.chip.ask("").is_some() {
                return;
            }
        }
    }
}

impl Bench for OnChip {
    fn now(&self) -> u64 {
        self.chip.now()
    }

    fn pass(&mut self, until: u64) {
        self.chip.run_until(until);
    }

    fn send(&mut self, byte: u8) {
        self.chip.send(&[byte]);
        self.chip.run_to(4 * BYTE, Chip::has_taken_all);
    }

    fn heard(&mut self) -> Option<(u64, u8)> {
        let begun = |(done, byte): (u64, u8)| (done.saturating_sub(BYTE), byte);
        self.said.extend(self.chip.take_said_with_times().into_iter().map(begun));
        self.said.pop_front()
    }

    fn edges(&mut self, into: &mut Vec<Edge>) {
        if self.low != u64::MAX {
            let time = std::mem::replace(&mut self.low, u64::MAX);
            let low = |axis| Edge { time, axis, pin: Pin::Direction, level: false };
            into.extend((0..AXES as u8).map(low));
        }
        into.extend(self.chip.take_edges());
    }

    fn enable(&mut self) -> (bool, u64) {
        self.chip.enable_changes().last().map_or((false, 0), |&(time, level)| (level, time))
    }

    fn switch(&mut self, axis: u8, high: bool) {
        self.chip.press(axis.into(), !high);
    }

    fn input(&mut self, input: Input, high: bool) {
        let [emergency, driver] = self.chip.board().stoppers();
        let pin = match input {
            Input::Emergency => emergency,
            Input::Driver => driver,
        };
        self.chip.pull(pin, !high);
    }

    fn patience(&self) -> u64 {
        HZ / 20
    }
}
