//! Switches: latched when they close, and the reaction of a motor that moves towards one.
//!
//! ```text
//!   switch    ________▔▔▔▔▔▔▔▔▔▔▔▔▔▔▔▔▔▔▔▔▔
//!   at once   │ │ │ │
//!   braking   │ │ │ │ ┊ │  │   │     │         each step costs it 2a of v²
//!                     the step that is under way
//! ```

use super::brake::BRAKES;
use super::motor::{End, Faults, Status};
use super::player::Verdict;
use super::strategy::AtHardEnd;
use super::surroundings::{MachineIo, Switches};
use super::{Cycle, State};
use stepwright::drive::{Axes, Drive};
use stepwright::timer::StepTimer;

impl<T: StepTimer, D: Drive, S: MachineIo, const N: usize> Cycle<'_, T, D, S, N> {
    /// Reads the switches, latches those that have closed, and stops the motors that move towards
    /// one. Returns whether any is closed.
    pub(crate) fn watch(&mut self) -> bool {
        let now = self.surroundings.switches();
        let before = core::mem::replace(&mut self.seen, now);
        let any = now != Switches::NONE;
        if any {
            self.closed(now, before);
        }
        any
    }

    /// Handles closed switches: `now` closed now, `before` at the last read.
    #[cold]
    #[inline(never)]
    fn closed(&mut self, now: Switches, before: Switches) {
        // While a motor stands at its switch, this is done before every event of the others.
        let mut bit: Axes = 1;
        for motor in 0..N as u8 {
            let own = bit;
            bit = bit.wrapping_shl(1);
            if (now.min | now.max) & own == 0 {
                continue;
            }
            for (end, now, before) in
                [(End::Min, now.min, before.min), (End::Max, now.max, before.max)]
            {
                if now & own == 0 {
                    continue;
                }
                if before & own == 0 {
                    let at = self.position(motor);
                    let side = self.triggers.get_mut(usize::from(motor));
                    if let Some(side) = side.and_then(|sides| sides.get_mut(end as usize)) {
                        *side = at;
                    }
                }
                if matches!(self.state, State::Running) && self.heads(motor, end) {
                    self.trip(motor, end);
                }
            }
        }
    }

    /// Whether the next step of a motor goes towards this end.
    fn heads(&mut self, motor: u8, end: End) -> bool {
        self.player(motor).is_some_and(|player| player.heading == Some(end == End::Max))
    }

    /// Stops a motor that moves towards a closed switch.
    #[inline(never)]
    fn trip(&mut self, motor: u8, end: End) {
        let strategy = self.strategies.hard_end;
        let Some(player) = self.player(motor) else { return };
        // If all motors brake, one may already be braking when it reaches its own switch.
        let begins = !player.is_braking();
        player.faults |= Faults::hard(end);
        let verdict = match strategy {
            AtHardEnd::StopMotor | AtHardEnd::BrakeMotor => Verdict::Stop,
            AtHardEnd::Cancel => Verdict::Cancel,
            AtHardEnd::BrakeAll => Verdict::Brake,
        };
        if player.verdict != Verdict::Cancel {
            player.verdict = verdict;
        }
        match strategy {
            _ if !BRAKES => self.stop_motor(motor),
            AtHardEnd::BrakeMotor | AtHardEnd::BrakeAll if !begins => {}
            AtHardEnd::BrakeMotor => self.brake(motor),
            AtHardEnd::BrakeAll => (0..N as u8).for_each(|motor| self.brake(motor)),
            AtHardEnd::StopMotor | AtHardEnd::Cancel => self.stop_motor(motor),
        }
    }

    /// Stops a motor between two steps and ends its program.
    fn stop_motor(&mut self, motor: u8) {
        self.engine.kill(1 << motor);
        self.engine.drive().lower(1 << motor);
        if let Some(player) = self.player(motor) {
            player.end();
        }
    }

    /// Brakes a motor from its next step on; a motor slower than that stops.
    fn brake(&mut self, motor: u8) {
        let left = self.engine.loaded(motor);
        let Some(player) = self.player(motor) else { return };
        if player.is_braking() || player.status != Status::Running {
            return;
        }
        if !player.brake(left) {
            return self.stop_motor(motor);
        }
        let cut = self.engine.cut(motor);
        if let Some(player) = self.player(motor) {
            player.take_back(cut);
        }
    }
}
