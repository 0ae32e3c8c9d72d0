//! The slave: it answers each line once, and commands a machine.

use crate::answer::{Answer, DIGITS, NOTHING, line, value};
use crate::axis::{AxisId, MAX_AXES};
use crate::command::Command;
use crate::errors;
use crate::grammar::{self, flag};
use crate::line::Collector;
use crate::machine::{Machine, Refusal};
use crate::motion_params::{MotionParams, NO_JERK};
use crate::raw_line::RawLine;
use crate::reply::{Reply, VERSION};
use crate::setting::{Setting, Settings};
use crate::stop::{self, Stop};
use crate::sum::{self, Tail};
use guard::Guard;
use state::{Axis, Naming, Open, Task};

mod guard;
mod start;
mod state;

/// The slave's half of the line, for up to `AXES` axes (at most 8).
///
/// It takes bytes, answers each CR with exactly one [`Reply`] and commands the [`Machine`]. It
/// holds no clock and does no I/O.
///
/// ```text
///   bytes ─► receive ─► work … work ─► next_byte … ─► answer
/// ```
///
/// An order is started piece by piece, one piece per call of [`work`](Slave::work), and answered at
/// the end. Meanwhile the next line may come. It waits, but Z and K act at once: Z brakes the
/// moving axes, K stops them and refuses the order. When Z is obeyed in its turn, it also brakes
/// the axes that the order started.
///
/// On an AVR it takes 73 bytes of RAM and 29 more per axis, 33 with the feature `jerk`. The code
/// for an ATmega328P contains no panic (rustc 1.96, `opt-level = "s"`, LTO).
#[derive(Clone, Debug)]
pub struct Slave<const AXES: usize> {
    line: Collector<{ LONGEST }>,
    axes: [Axis; AXES],
    /// The letter of the last stop of each axis.
    stops: [u8; AXES],
    /// The axes that lines address: bit 0 is axis 1. All bits: A0.
    selected: u8,
    /// Whether it is clear that the lines mean these axes.
    naming: Naming,
    order: Open,
    /// The number of lines that were answered E.
    refused: u16,
    last: Option<Refusal>,
    answer: Answer,
    /// The checksum of the answer.
    tail: Tail,
    guard: Guard<AXES>,
    /// The present task.
    task: Task,
    /// A complete line waits for its turn.
    waits: bool,
}

/// Checks the sizes in the documentation.
#[cfg(target_arch = "avr")]
const _: () = {
    let axis = if cfg!(feature = "jerk") { 33 } else { 29 };
    assert!(size_of::<Slave<1>>() <= 73 + axis && size_of::<Slave<3>>() <= 73 + 3 * axis);
};

/// The longest line, with its checksum.
const LONGEST: usize = Command::LONGEST + 3;

/// Axis 1.
const FIRST: u8 = 1;

impl<const AXES: usize> Default for Slave<AXES> {
    fn default() -> Self {
        Slave::new()
    }
}

impl<const AXES: usize> Slave<AXES> {
    /// The state at power-up: axis 1 selected, no order open, S5 T100 R200.
    pub fn new() -> Slave<AXES> {
        let mut slave = Slave::blank();
        slave.begin();
        slave
    }

    /// A slave before [`begin`](Slave::begin), all zeros, so that a static one takes no flash.
    pub const fn blank() -> Slave<AXES> {
        const { assert!(AXES >= 1 && AXES <= MAX_AXES as usize) };
        let axis = Axis { params: MotionParams::BLANK, staged: 0, backward: false, steps: 0 };
        Slave {
            line: Collector::blank(),
            axes: [axis; AXES],
            stops: [0; AXES],
            selected: 0,
            naming: Naming::Used,
            order: Open::Spoiled(Refusal::Line),
            refused: 0,
            last: Some(Refusal::Line),
            answer: Answer::NONE,
            tail: Tail::NONE,
            guard: Guard::NONE,
            task: Task::Line(0),
            waits: false,
        }
    }

    /// Sets the state at power-up: S5 T100 R200. Call it once, before anything else.
    #[inline(never)]
    pub fn begin(&mut self) {
        self.line.begin();
        (self.selected, self.order, self.last) = (FIRST, Open::No, None);
        self.mark(u8::MAX, stop::NONE);
        for axis in &mut self.axes {
            axis.params.begin();
        }
    }

    /// Takes a byte from the line. At a CR it obeys the line and returns the answer.
    ///
    /// For a host, which needs the answer as a value. A chip calls [`receive`](Slave::receive),
    /// [`work`](Slave::work) and [`next_byte`](Slave::next_byte).
    pub fn push<M: Machine>(&mut self, byte: u8, machine: &mut M) -> Option<Reply> {
        self.receive(byte, machine);
        while self.work(machine) {}
        let mut line = Collector::<{ Reply::LONGEST + 3 }>::new();
        while let Some(byte) = self.next_byte(machine) {
            if let Some(line) = line.push(byte) {
                let line = line.ok()?;
                let line = sum::checked(line).unwrap_or(line);
                return Reply::parse(line);
            }
        }
        None
    }

    /// Whether it takes bytes: no complete line waits for its turn.
    pub fn listens(&self) -> bool {
        !self.waits
    }

    /// Whether [`work`](Slave::work) obeys a complete line next that is not a stop. A caller that
    /// is behind with planning may delay it.
    pub fn can_wait(&self) -> bool {
        let stops = || matches!(self.line.look(), Some([b'Z' | b'K', ..]));
        self.waits && !self.is_starting() && !stops()
    }

    /// Takes a byte from the line. At a CR the line is complete, and [`work`](Slave::work) obeys it
    /// once the previous line is answered. A byte that comes while the slave does not
    /// [listen](Slave::listens) spoils the waiting line.
    pub fn receive<M: Machine>(&mut self, byte: u8, machine: &mut M) {
        if self.waits {
            return self.line.garble();
        }
        self.waits = self.line.collect(byte);
        if self.waits && self.is_starting() {
            self.stop_at_once(machine);
        }
    }

    /// Obeys a complete line, or does one piece of starting the present order. True while the
    /// answer is not ready.
    pub fn work<M: Machine>(&mut self, machine: &mut M) -> bool {
        if self.is_starting() {
            return self.start(machine);
        }
        !self.is_answering() && core::mem::take(&mut self.waits) && self.obey_line(machine)
    }

    /// Obeys the complete line and prepares its answer. True if the line began the start of an
    /// order.
    #[inline(never)]
    fn obey_line<M: Machine>(&mut self, machine: &mut M) -> bool {
        let (mut raw, mut empty) = (RawLine::NOTHING, false);
        let line = self.line.take();
        let summed = line.is_ok_and(sum::is_wanted);
        self.tail = Tail::new(summed);
        let read = match line {
            Ok(line) => {
                empty = line.is_empty();
                let line = if summed { sum::checked(line) } else { Ok(line) };
                line.and_then(|line| {
                    // A line without a checksum must not use the room for one.
                    if line.len() > Command::LONGEST { Err(Refusal::Line) } else { raw.read(line) }
                })
            }
            Err(_) => Err(Refusal::Line),
        };
        if read == Err(Refusal::Sum) {
            self.guard.note(errors::SUM);
        }
        let first = match read.and_then(|()| self.execute(&mut raw, machine)) {
            Ok(_) if self.is_starting() => return true,
            Ok(first) => first,
            Err(refusal) => {
                // Masters send an empty line to get in step. It does not count as refused.
                if empty {
                    self.spoil(refusal);
                } else {
                    self.refuse(refusal);
                }
                line::NO
            }
        };
        let lines = match first {
            line::INFO => line::SETTINGS - line::INFO,
            line::SETTINGS if raw.letter == b'$' => Setting::COUNT as u8,
            _ => 1,
        };
        self.answer.begin(first, lines);
        false
    }

    /// Counts a line that is answered E.
    #[inline(never)]
    fn refuse(&mut self, refusal: Refusal) {
        // Saturates. `saturating_add` is longer.
        let refused = self.refused.wrapping_add(1);
        if refused != 0 {
            self.refused = refused;
        }
        self.last = Some(refusal);
        self.task = Task::Line(0);
        self.spoil(refusal);
    }

    /// Whether part of the last answer is still to be sent.
    pub fn is_answering(&self) -> bool {
        self.answer.is_left() || self.tail.is_left()
    }

    /// The next byte of the answer, including the CR; `None` when the answer is complete. A number
    /// is read at the moment when it is due.
    ///
    /// A number costs one conversion to decimal where it begins: about 100 simple byte operations
    /// for 4000, 1,400 for 2³² − 1. Texts and further digits cost next to nothing.
    pub fn next_byte<M: Machine>(&mut self, machine: &mut M) -> Option<u8> {
        if let Some(byte) = self.tail.next() {
            return Some(byte);
        }
        let byte = self.answer_byte(machine)?;
        Some(self.tail.pass(byte))
    }

    /// The next byte of the answer, without the checksum.
    #[inline(always)]
    fn answer_byte<M: Machine>(&mut self, machine: &mut M) -> Option<u8> {
        let axes = self.count(machine);
        let last = self.last.map_or(0, |last| (last as u8).wrapping_add(1));
        self.answer.next(last, |n, digits| {
            let number = match n {
                value::POSITION => {
                    let Task::Line(asked) = self.task else { return NOTHING };
                    let axis = AxisId::at(asked);
                    // It was known when V was obeyed.
                    let Some(steps) = machine.position(axis) else { return b'E' };
                    let mut bytes = steps.to_le_bytes();
                    let backward = steps < 0;
                    if backward {
                        negate(&mut bytes);
                    }
                    digits.set(&mut bytes);
                    return if backward { b'-' } else { DIGITS };
                }
                value::STOPS..value::ERRORS => {
                    let index = n.wrapping_sub(value::STOPS);
                    let stop = self.stops.get(usize::from(index));
                    let stop = stop.copied().filter(|_| index < axes);
                    let stop = stop.map(|letter| self.guard.stop(letter, index, machine));
                    return stop.unwrap_or(NOTHING);
                }
                value::ERRORS..value::CLOSED => {
                    let late = machine.late() != 0;
                    let index = n.wrapping_sub(value::ERRORS);
                    return self.guard.errors(late).letter(index).unwrap_or(NOTHING);
                }
                value::MAJOR => VERSION.0.into(),
                value::MINOR => VERSION.1.into(),
                value::AXES => axes.into(),
                value::MAX => machine.max_rate(),
                value::LATE => machine.late(),
                value::REFUSED => self.refused.into(),
                value::UNCERTAIN => (machine.uncertain() & all(axes)).into(),
                value::CLOSED => machine.closed().into(),
                _ => match (machine.settings(), n.wrapping_sub(value::SETTINGS)) {
                    (Some(settings), index) => settings.number(index),
                    (None, _) => 0,
                },
            };
            digits.set(&mut number.to_le_bytes());
            DIGITS
        })
    }

    /// Reports that a byte was lost or damaged on the way: an overrun or a framing error of the
    /// receiver. The line that it belongs to is answered E, whatever its other bytes are: `G+400`
    /// may have been `G+4000`.
    pub fn garbled(&mut self) {
        self.line.garble();
        self.guard.note(errors::GARBLED);
    }

    /// Reports that the machine has stopped these axes, or brakes them, for a reason that is not a
    /// line; bit 0 is axis 1. Pass only axes that move; there may be none. [`Stop::Emergency`] and
    /// [`Stop::Driver`] spoil an open order, as K does.
    ///
    /// `stop=` in the answer to `?` has the letter until the axis starts again, or `!` comes. Of
    /// two soft stops the first is kept.
    pub fn stopped(&mut self, axes: u8, reason: Stop) {
        self.mark(axes, reason.letter());
        if matches!(reason, Stop::Emergency | Stop::Driver) {
            self.spoil(Refusal::Fault);
        }
    }

    /// Sets the letters of these axes.
    #[cfg_attr(target_arch = "avr", inline(never))]
    fn mark(&mut self, mut axes: u8, letter: u8) {
        self.guard.mark(axes, letter);
        if let Task::Start(stopped) = &mut self.task {
            *stopped |= axes;
        }
        for stop in &mut self.stops {
            if axes & 1 != 0 && !(stop::is_soft(letter) && stop::is_soft(*stop)) {
                *stop = letter;
            }
            axes >>= 1;
        }
    }

    /// Whether it is clear which axes a line addresses.
    ///
    /// # Errors
    /// [`Refusal::NoAxis`] if not.
    fn named(&self) -> Result<(), Refusal> {
        if self.naming == Naming::Unclear { Err(Refusal::NoAxis) } else { Ok(()) }
    }

    /// Obeys a line, and returns the line of the text that answers it.
    fn execute<M: Machine>(&mut self, raw: &mut RawLine, machine: &mut M) -> Result<u8, Refusal> {
        raw.unify();
        let RawLine { letter, flags, number, .. } = *raw;
        let mut go = false;
        let busy = self.busy(machine);
        // Whether all selected axes are idle.
        let idle = busy & self.selected == 0;
        // Whether g starts at once, or is part of an order.
        let alone = self.order == Open::No;
        // The conditions in the row of the line.
        if flags & flag::NAMED != 0 {
            self.named()?;
        }
        if flags & flag::OPEN != 0 && alone {
            return Err(Refusal::Closed);
        }
        let in_motion = flags & flag::IDLE != 0 && !idle;
        // Checks every axis, because most settings apply to all of them.
        if in_motion || flags & flag::REST != 0 && busy != 0 {
            return Err(Refusal::Busy);
        }
        match letter {
            b'P' => {
                self.forget_travels();
                // The masters of the Nano slave know no jerk.
                for axis in &mut self.axes {
                    axis.params.jerk = NO_JERK;
                }
                self.order = Open::Yes;
                // A line of a master that knows no A addresses axis 1; a master that has sent A may
                // mean the axis of its A.
                if self.naming == Naming::Chosen && self.selected != FIRST {
                    self.naming = Naming::Unclear;
                    self.selected |= FIRST;
                } else {
                    self.naming = Naming::Used;
                    self.selected = FIRST;
                }
            }
            b'G' | b'g' => {
                self.stage(raw);
                go = alone;
            }
            b'@' => {
                let axes = self.selected & all(self.count(machine));
                if busy & axes != axes {
                    return Err(Refusal::NoTravel);
                }
                self.guard.admit_target(axes, raw.steps(), machine)?;
                machine.change(axes, MotionParams::change(raw))?;
                self.mark(axes, stop::NONE);
                self.guard.retargeted(axes);
            }
            b'E' => {
                if let Open::Spoiled(first) = self.order {
                    return Err(first);
                }
                go = true;
            }
            b'F' => {
                return Ok(if idle { line::READY } else { line::BUSY });
            }
            b'Z' => self.stop(machine),
            b'K' => self.kill(machine),
            b'I' | b'V' | b'A' => {
                let axis = number as u8;
                if axis > self.count(machine) {
                    return Err(Refusal::Axis);
                }
                let index = axis.wrapping_sub(1);
                let bit = 1u8.wrapping_shl(index.into());
                if letter == b'A' {
                    self.selected = if axis == 0 { u8::MAX } else { bit };
                    self.naming = Naming::Chosen;
                } else if letter == b'V' {
                    if machine.uncertain() & bit != 0 {
                        return Err(Refusal::Uncertain);
                    }
                    self.task = Task::Line(index);
                    return Ok(line::POSITION);
                } else {
                    if busy & bit != 0 {
                        return Err(Refusal::Busy);
                    }
                    machine.zero(AxisId::at(index));
                }
            }
            b'L' => machine.lease(number as u16)?,
            b'?' => return Ok(line::INFO),
            b'!' => {
                machine.clear_late();
                self.refused = 0;
                self.last = None;
                self.mark(u8::MAX, stop::NONE);
                self.guard.clear(busy);
            }
            // The remaining lines begin with `$`.
            grammar::SET | grammar::RESET => {
                let settings = settings(machine)?;
                let changed = if letter == grammar::SET {
                    settings.put(raw.setting as u8, number)
                } else {
                    settings.reset()
                };
                if changed {
                    machine.set_up();
                }
            }
            b'$' | grammar::ONE => {
                settings(machine)?;
                let index = if letter == grammar::ONE { raw.setting as u8 } else { 0 };
                return Ok(line::SETTINGS.wrapping_add(index));
            }
            // The remaining lines set motion parameters: R, s, m, a, d or j.
            _ => {
                if !idle {
                    // m, a or d. An open order is only for axes at rest.
                    if !alone {
                        return Err(Refusal::Busy);
                    }
                    if let Some(settings) = machine.settings() {
                        MotionParams::check_change(raw, settings)?;
                    }
                    self.guard.admit_change(busy & self.selected, letter, machine)?;
                    machine.change(busy & self.selected, MotionParams::change(raw))?;
                }
                let mut selected = self.selected;
                for axis in &mut self.axes {
                    if selected & 1 != 0 {
                        axis.params.set(letter, number);
                    }
                    selected >>= 1;
                }
            }
        }
        if go {
            if self.staged() & all(self.count(machine)) == 0 {
                return Err(Refusal::NoTravel);
            }
            self.task = Task::Check(0);
        }
        Ok(line::YES)
    }

    /// Brakes the selected axes.
    #[inline(never)]
    fn stop<M: Machine>(&mut self, machine: &mut M) {
        let mut stop = self.busy(machine) & self.selected;
        self.mark(stop, b'Z');
        for index in 0..AXES as u8 {
            if stop & 1 != 0 {
                machine.stop(AxisId::at(index));
            }
            stop >>= 1;
        }
    }

    /// Stops everything.
    #[inline(never)]
    fn kill<M: Machine>(&mut self, machine: &mut M) {
        let busy = self.busy(machine);
        // Even if nothing seems to move: K relies on no state.
        machine.kill();
        self.mark(busy, b'K');
        self.spoil(Refusal::Killed);
    }

    /// Stores the travel of G or g for the selected axes.
    fn stage(&mut self, raw: &RawLine) {
        let mut selected = self.selected;
        for axis in &mut self.axes {
            if selected & 1 != 0 {
                (axis.staged, axis.backward) = (raw.letter, raw.backward);
                axis.steps = raw.number;
            }
            selected >>= 1;
        }
    }

    /// Keeps the open order, or the order that is being started, from starting.
    fn spoil(&mut self, reason: Refusal) {
        if self.is_starting() {
            self.task = Task::Refuse(reason);
        } else if self.order == Open::Yes {
            self.order = Open::Spoiled(reason);
        }
    }

    #[inline(never)]
    fn forget_travels(&mut self) {
        for axis in &mut self.axes {
            axis.staged = 0;
        }
    }

    /// The busy axes: bit 0 is axis 1.
    fn busy<M: Machine>(&self, machine: &M) -> u8 {
        let (mut busy, mut bit) = (0, 1u8);
        for index in 0..self.count(machine) {
            if machine.busy(AxisId::at(index)) {
                busy |= bit;
            }
            bit <<= 1;
        }
        busy
    }

    /// The number of axes that the machine has and this slave has room for.
    fn count<M: Machine>(&self, machine: &M) -> u8 {
        let room = if AXES > MAX_AXES as usize { MAX_AXES } else { AXES as u8 };
        machine.axes().min(room)
    }
}

/// Makes a negative number positive, byte by byte, the lowest first. On a small chip a choice
/// between two 8-byte numbers needs three times the code.
fn negate(bytes: &mut [u8]) {
    let mut carry = true;
    for byte in bytes {
        (*byte, carry) = (!*byte).overflowing_add(carry.into());
    }
}

/// The first `axes` bits, at least one.
fn all(axes: u8) -> u8 {
    u8::MAX.wrapping_shr(u32::from(MAX_AXES.wrapping_sub(axes)))
}

/// The machine's settings, if it has any.
fn settings<M: Machine>(machine: &mut M) -> Result<&mut Settings, Refusal> {
    machine.settings().ok_or(Refusal::Setting)
}
