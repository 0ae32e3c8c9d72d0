//! The slave: lines in, one answer each, and a machine that obeys.

use crate::axis::{AxisId, MAX_AXES, Selection};
use crate::command::{BadLine, Command};
use crate::line::Collector;
use crate::machine::{Machine, Refusal};
use crate::number::Direction;
use crate::order::{Manner, Travel};
use crate::reply::{Info, Reply, VERSION};
use crate::setting::{Settings, Value};

/// The slave's half of the line, for up to `AXES` axes (at most 8).
///
/// Fed with bytes, it answers each CR with exactly one [`Reply`] and tells the
/// [`Machine`] what to do. It holds no clock and does no I/O.
///
/// On an ATmega328P (rustc 1.96, `opt-level = "s"`, LTO) it takes 35 bytes of
/// RAM and 27 more an axis, and with the compiler's own routines 9 KB of flash;
/// its texts stay there. No panic is left in it.
#[derive(Clone, Debug)]
pub struct Slave<const AXES: usize> {
    line: Collector<{ Command::LONGEST }>,
    axes: [Axis; AXES],
    selected: Selection,
    order: Open,
    refused: u32,
    last: Option<Refusal>,
}

/// What the lines have said of one axis.
#[derive(Clone, Copy, Debug)]
struct Axis {
    manner: Manner,
    /// Where to, once E comes.
    staged: Option<Travel>,
}

/// The order that is being programmed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Open {
    /// There is none.
    No,
    /// PO has come.
    Yes,
    /// PO has come, and after it a line that was refused, or K: the reason of
    /// the first. No E starts it. It stays open all the same: a g of it that
    /// is still on its way must not be taken for one that starts at once.
    Spoiled(Refusal),
}

impl<const AXES: usize> Default for Slave<AXES> {
    fn default() -> Self {
        Slave::new()
    }
}

impl<const AXES: usize> Slave<AXES> {
    /// As at power-up: axis 1 selected, no order open, S5 T100 R200.
    pub const fn new() -> Slave<AXES> {
        const { assert!(AXES >= 1 && AXES <= MAX_AXES as usize) };
        Slave {
            line: Collector::new(),
            axes: [Axis { manner: Manner::INITIAL, staged: None }; AXES],
            selected: Selection::FIRST,
            order: Open::No,
            refused: 0,
            last: None,
        }
    }

    /// Takes a byte from the line. At a CR it obeys and returns the answer,
    /// whose [`bytes`](Reply::bytes) go back on the line.
    pub fn push<M: Machine>(&mut self, byte: u8, machine: &mut M) -> Option<Reply> {
        let command = match self.line.push(byte)?.and_then(Command::parse) {
            Ok(command) => command,
            Err(bad) => {
                // Masters send an empty line to get in step. That is no news.
                if bad != BadLine::Empty {
                    self.note(bad.into());
                }
                self.spoil(bad.into());
                return Some(Reply::No);
            }
        };
        let reply = self.obey(command, machine).unwrap_or_else(|refusal| {
            self.note(refusal);
            // E itself leaves the order as it was, to be mended.
            if !matches!(command, Command::Execute) {
                self.spoil(refusal);
            }
            Reply::No
        });
        Some(reply)
    }

    /// Tells that a byte was lost or damaged on the way: an overrun or a
    /// framing error of the receiver. The line that it belongs to is answered
    /// E, whatever the rest of it says; `G+400` may have been `G+4000`.
    pub fn garbled(&mut self) {
        self.line.garble();
    }

    #[cfg_attr(target_arch = "avr", inline(never))]
    fn obey<M: Machine>(&mut self, command: Command, machine: &mut M) -> Result<Reply, Refusal> {
        match command {
            Command::Program => {
                self.idle(machine)?;
                self.forget_travels();
                self.order = Open::Yes;
                self.selected = Selection::FIRST;
            }
            Command::StartTens(_)
            | Command::TopTens(_)
            | Command::Ramp(_)
            | Command::Start(_)
            | Command::Top(_)
            | Command::Accel(_)
            | Command::Decel(_) => {
                self.idle(machine)?;
                self.for_selected(|axis| axis.manner.apply(command));
            }
            Command::Go(distance) => {
                if self.order == Open::No {
                    return Err(Refusal::Closed);
                }
                self.stage(machine, Travel::By(distance))?;
            }
            Command::Run(direction) => self.run(machine, direction)?,
            Command::Execute => self.execute(machine)?,
            Command::Status => {
                let ready = self.idle(machine).is_ok();
                return Ok(if ready { Reply::Ready } else { Reply::Busy });
            }
            Command::Brake => {
                for axis in self.selected(machine) {
                    if machine.busy(axis) {
                        machine.brake(axis);
                    }
                }
            }
            Command::Kill => {
                // Even if nothing seems to move: K relies on nothing.
                machine.kill();
                self.spoil(Refusal::Killed);
            }
            Command::Zero(axis) => {
                self.exists(machine, axis)?;
                if machine.busy(axis) {
                    return Err(Refusal::Busy);
                }
                machine.zero(axis);
            }
            Command::Position(axis) => {
                self.exists(machine, axis)?;
                let steps = machine.position(axis).ok_or(Refusal::Uncertain)?;
                return Ok(Reply::Position(steps));
            }
            Command::Select(selection) => {
                if let Selection::One(axis) = selection {
                    self.exists(machine, axis)?;
                }
                self.selected = selection;
            }
            Command::Info => return Ok(Reply::Info(self.info(machine))),
            Command::Clear => {
                machine.clear_late();
                self.refused = 0;
                self.last = None;
            }
            Command::Settings => return Ok(Reply::Settings(*settings(machine)?)),
            Command::Setting(setting) => {
                return Ok(Reply::Setting(settings(machine)?.value(setting)));
            }
            Command::Set(value) => self.set_up(machine, Some(value))?,
            Command::Reset => self.set_up(machine, None)?,
        }
        Ok(Reply::Yes)
    }

    /// g: part of an open order, else it starts at once.
    fn run<M: Machine>(&mut self, machine: &mut M, direction: Direction) -> Result<(), Refusal> {
        self.stage(machine, Travel::Endless(direction))?;
        if self.order != Open::No {
            return Ok(());
        }
        let started = self.start(machine);
        // Whatever came of it, outside an order nothing stays staged.
        self.forget_travels();
        started
    }

    /// E: starts what is staged.
    fn execute<M: Machine>(&mut self, machine: &mut M) -> Result<(), Refusal> {
        match self.order {
            Open::No => return Err(Refusal::Closed),
            Open::Spoiled(first) => return Err(first),
            Open::Yes => {}
        }
        if self.axes.iter().all(|axis| axis.staged.is_none()) {
            return Err(Refusal::NoTravel);
        }
        self.start(machine)?;
        self.forget_travels();
        self.order = Open::No;
        Ok(())
    }

    fn start<M: Machine>(&mut self, machine: &mut M) -> Result<(), Refusal> {
        let axes = AxisId::first(self.count(machine)).zip(&self.axes);
        // G found the axes idle, and nothing but E starts one; but a machine
        // may have buttons of its own.
        for (id, axis) in axes.clone().filter(|(_, axis)| axis.staged.is_some()) {
            if machine.busy(id) {
                return Err(Refusal::Busy);
            }
            if let Some(settings) = machine.settings() {
                axis.manner.check(settings)?;
            }
        }
        let orders = axes.filter_map(|(id, axis)| {
            let travel = axis.staged?;
            Some((id, axis.manner.order(travel)))
        });
        machine.start(orders)
    }

    fn stage<M: Machine>(&mut self, machine: &M, travel: Travel) -> Result<(), Refusal> {
        self.idle(machine)?;
        self.for_selected(|axis| axis.staged = Some(travel));
        Ok(())
    }

    /// Changes one setting of the machine, or gives all their defaults, and
    /// tells it if they are others then.
    fn set_up<M: Machine>(&self, machine: &mut M, to: Option<Value>) -> Result<(), Refusal> {
        // Most settings are all axes' own.
        self.free(machine, Selection::All)?;
        let settings = settings(machine)?;
        let old = *settings;
        match to {
            Some(value) => {
                settings.set(value);
            }
            None => *settings = Settings::new(),
        }
        if *settings != old {
            machine.set_up();
        }
        Ok(())
    }

    /// Remembers a refusal for `?`.
    fn note(&mut self, refusal: Refusal) {
        self.refused = self.refused.saturating_add(1);
        self.last = Some(refusal);
    }

    fn spoil(&mut self, reason: Refusal) {
        if self.order == Open::Yes {
            self.order = Open::Spoiled(reason);
        }
    }

    fn forget_travels(&mut self) {
        for axis in &mut self.axes {
            axis.staged = None;
        }
    }

    #[cfg_attr(target_arch = "avr", inline(never))]
    fn for_selected(&mut self, change: impl Fn(&mut Axis)) {
        let selected = self.selected;
        let all = AxisId::first(MAX_AXES).zip(&mut self.axes);
        all.filter(|(id, _)| selected.contains(*id)).for_each(|(_, axis)| change(axis));
    }

    /// Are all the selected axes idle?
    fn idle<M: Machine>(&self, machine: &M) -> Result<(), Refusal> {
        self.free(machine, self.selected)
    }

    /// Are all of these axes idle?
    fn free<M: Machine>(&self, machine: &M, axes: Selection) -> Result<(), Refusal> {
        let mut all = AxisId::first(self.count(machine));
        let busy = all.any(|axis| axes.contains(axis) && machine.busy(axis));
        if busy { Err(Refusal::Busy) } else { Ok(()) }
    }

    #[cfg_attr(target_arch = "avr", inline(never))]
    fn exists<M: Machine>(&self, machine: &M, axis: AxisId) -> Result<(), Refusal> {
        if axis.number() > self.count(machine) { Err(Refusal::Axis) } else { Ok(()) }
    }

    /// How many axes there are and have room here.
    fn count<M: Machine>(&self, machine: &M) -> u8 {
        let room = if AXES > MAX_AXES as usize { MAX_AXES } else { AXES as u8 };
        machine.axes().min(room)
    }

    fn selected<M: Machine>(&self, machine: &M) -> impl Iterator<Item = AxisId> + use<M, AXES> {
        let selected = self.selected;
        AxisId::first(self.count(machine)).filter(move |axis| selected.contains(*axis))
    }

    fn info<M: Machine>(&self, machine: &M) -> Info {
        let axes = self.count(machine);
        let uncertain = AxisId::first(axes)
            .filter(|axis| machine.position(*axis).is_none())
            .fold(0, |mask, axis| mask | 1u8.wrapping_shl(axis.index() as u32));
        Info {
            version: VERSION,
            axes,
            max: machine.max_rate(),
            late: machine.late(),
            refused: self.refused,
            last: self.last,
            uncertain,
        }
    }
}

/// The machine's settings, if it has any.
fn settings<M: Machine>(machine: &mut M) -> Result<&mut Settings, Refusal> {
    machine.settings().ok_or(Refusal::Setting)
}
