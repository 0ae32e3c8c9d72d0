//! Starting an order: from E, or a g alone, to its answer.
//!
//! ```text
//!              each axis             until the machine is ready
//!   E ─► Check(0) ─► Admit(0) ─► HandOver(0) … ─► Start ───► Y
//!           └───────────┴───────────┴───────────────┴─► Refuse ─► E      K and faults, too
//! ```

use core::task::Poll;

use stepwright::Travel;

use super::Slave;
use super::state::{Naming, Open, Task};
use crate::answer::line;
use crate::axis::AxisId;
use crate::machine::{Machine, Refusal};
use crate::stop;
use crate::sum;

impl<const AXES: usize> Slave<AXES> {
    /// Whether an order is being started. Its axes may begin at the next call of
    /// [`work`](Slave::work).
    pub fn is_starting(&self) -> bool {
        !matches!(self.task, Task::Line(_))
    }

    /// Obeys a complete line at once if it is a stop, while an order is being started. In its turn
    /// the line is obeyed again and answered.
    #[inline(never)]
    pub(super) fn stop_at_once<M: Machine>(&mut self, machine: &mut M) {
        let line = self.line.look().unwrap_or_default();
        let line = if sum::is_wanted(line) { sum::checked(line).unwrap_or_default() } else { line };
        if let [letter] = line {
            match letter {
                b'K' => self.kill(machine),
                b'Z' => self.stop(machine),
                _ => {}
            }
        }
    }

    /// Does one piece of starting the order. False once the answer is ready.
    pub(super) fn start<M: Machine>(&mut self, machine: &mut M) -> bool {
        let result = match self.task {
            Task::Line(_) => return false,
            Task::Check(index) => self.check(index, machine),
            Task::Admit(index) => self.admit(index, machine),
            Task::HandOver(index) => self.hand_over(index, machine),
            Task::Start(stopped) => match machine.commit() {
                Poll::Pending => Ok(()),
                Poll::Ready(Ok(())) => {
                    self.started(stopped);
                    self.close(line::YES);
                    return false;
                }
                Poll::Ready(refused) => refused,
            },
            Task::Refuse(refusal) => {
                machine.cancel();
                self.refuse(refusal);
                self.close(line::NO);
                return false;
            }
        };
        if let Err(refusal) = result {
            self.task = Task::Refuse(refusal);
        }
        true
    }

    /// All axes of the order have started, and these have been stopped since.
    #[inline(always)]
    fn started(&mut self, stopped: u8) {
        let started = self.staged() & !stopped;
        self.mark(started, stop::NONE);
        self.guard.started(started);
        if self.order == Open::Yes {
            self.naming = Naming::Used;
        }
        self.order = Open::No;
    }

    /// Ends the start of the order, and answers it with this line of the text.
    #[inline(never)]
    fn close(&mut self, answer: u8) {
        self.forget_travels();
        self.task = Task::Line(0);
        self.answer.begin(answer, 1);
    }

    /// Checks whether the settings allow the motion parameters of an axis that is to travel.
    fn check<M: Machine>(&mut self, index: u8, machine: &mut M) -> Result<(), Refusal> {
        let count = self.count(machine);
        let Some(axis) = self.axes.get(usize::from(index)).filter(|_| index < count) else {
            self.task = Task::Start(0);
            return Ok(());
        };
        if axis.staged == 0 {
            self.task = Task::Check(index.wrapping_add(1));
            return Ok(());
        }
        self.task = Task::Admit(index);
        machine.settings().map_or(Ok(()), |settings| axis.params.check(settings))
    }

    /// Checks whether the soft limits of an axis allow its travel. They may shorten it.
    fn admit<M: Machine>(&mut self, index: u8, machine: &mut M) -> Result<(), Refusal> {
        self.task = Task::HandOver(index);
        if let Some(axis) = self.axes.get_mut(usize::from(index)) {
            let mut travel = axis.travel();
            self.guard.admit(index, &mut travel, machine)?;
            if let Travel::By(steps) = travel {
                (axis.staged, axis.backward) = (b'G', steps < 0);
                axis.steps = steps.unsigned_abs();
            }
        }
        Ok(())
    }

    /// Hands the travel of an axis to the machine.
    fn hand_over<M: Machine>(&mut self, index: u8, machine: &mut M) -> Result<(), Refusal> {
        self.task = Task::Check(index.wrapping_add(1));
        let Some(axis) = self.axes.get(usize::from(index)) else { return Ok(()) };
        let order = axis.params.order(axis.travel());
        machine.prepare(AxisId::at(index), &order)
    }

    /// The axes that are to travel: bit 0 is axis 1.
    #[inline(never)]
    pub(super) fn staged(&self) -> u8 {
        let (mut staged, mut bit) = (0, 1u8);
        for axis in &self.axes {
            if axis.staged != 0 {
                staged |= bit;
            }
            bit <<= 1;
        }
        staged
    }
}
