//! A timer's motor, ordered over the serial line: without its pins, clock and bytes.
//!
//! It is the same on a chip (`firmware/avr/src/bin/timed.rs`) and on the virtual board
//! (`stepwright-sim`): the program that has one or several of these is behind a `ProgramSlave`, and
//! finds the motor of a row by its timer.

use super::driver::{Driver, Hold};
use super::fit::Hardware;
use super::line::{Line, Report, Unwired, Wire};
use super::order::{Call, Code, Control, SetSpeed};
use super::pace::Model;
use stepwright_protocol::{Fault, Said};

/// A motor whose pins are set while the program runs.
pub trait WiredMotor: Hold {
    /// Moves the motor to these pins, while it is at rest. Returns false and does nothing if the
    /// board does not have them.
    fn rewire(&mut self, wire: &Wire) -> bool;

    /// The row of the motor's table at which it is.
    fn phase(&mut self) -> u8;

    /// Whether the motor moves.
    fn is_moving(&mut self) -> bool {
        self.with(|pace| pace.is_moving())
    }
}

/// A timer's motor and its driver.
pub struct TimedStation<H> {
    motor: H,
    driver: Driver,
    /// Whether the motor has pins.
    wired: bool,
    /// Milliseconds from one check by the main program to the next; 0: none.
    check: u16,
    /// The time of the last check, on the board's clock.
    checked: u32,
    /// The time of the call on the board's clock, and the time of the caller's clock then.
    call: u32,
    shown: u32,
    reached: Option<u32>,
    fault: Option<u32>,
}

impl<H: WiredMotor> TimedStation<H> {
    /// A motor at rest without pins.
    pub fn new(motor: H, hardware: Hardware) -> TimedStation<H> {
        TimedStation {
            motor,
            driver: Driver::new(hardware, Model::Ideal),
            wired: false,
            check: 0,
            checked: 0,
            call: 0,
            shown: 0,
            reached: None,
            fault: None,
        }
    }

    /// The motor.
    pub fn motor(&mut self) -> &mut H {
        &mut self.motor
    }

    /// Carries out a row at `now` milliseconds of the board's clock. An order begins with a
    /// millisecond, so that the checks come whole milliseconds after it. `report` answers a
    /// [`Line::Look`].
    ///
    /// # Errors
    /// [`Fault::Busy`], [`Unwired::Pins`]
    #[inline(never)]
    pub fn carry_out(
        &mut self,
        line: &Line,
        now: u32,
        report: &mut [u32; Report::NUMBERS],
    ) -> Result<Said, Fault<Unwired>> {
        match line {
            Line::Wire(_, wire) => {
                self.rests()?;
                if !self.motor.rewire(wire) {
                    return Err(Fault::Own(Unwired::Pins));
                }
                self.wired = true;
            }
            Line::Latched(_, latched) => {
                self.rests()?;
                let model = if *latched { Model::Latched } else { Model::Ideal };
                self.driver = Driver::new(*self.driver.hardware(), model);
            }
            Line::Check(_, ms) => self.check = *ms,
            Line::Move(_, order, shown) => {
                return Ok(Said::Number(self.order(order, *shown, now).get().into()));
            }
            Line::Look(_) => {
                *report = self.look(now).numbers();
                return Ok(Said::Report);
            }
        }
        Ok(Said::Yes)
    }

    fn rests(&mut self) -> Result<(), Fault<Unwired>> {
        if self.motor.is_moving() { Err(Fault::Busy) } else { Ok(()) }
    }

    fn order(&mut self, order: &SetSpeed, shown: u32, now: u32) -> Code {
        let wired = self.wired || order.top == 0 || !order.control.has(Control::DRV_EN);
        if !wired {
            return Code::NOT_WIRED;
        }
        let code = self.driver.set_speed(&mut self.motor, order, shown);
        // After an error the previous order continues, by its own clock.
        if !code.is_error() {
            (self.call, self.shown, self.checked) = (now, shown, now);
            (self.reached, self.fault) = (None, None);
        }
        code
    }

    fn look(&mut self, now: u32) -> Report {
        let phase = self.motor.phase();
        let dump = self.driver.dump(&mut self.motor, phase);
        Report {
            ms: now.wrapping_sub(self.call),
            dump,
            moving: self.motor.is_moving(),
            reached: self.reached,
            fault: self.fault,
        }
    }

    /// Stops the motor, and switches its drivers off.
    pub fn stop(&mut self, now: u32) {
        let shown = self.caller(now);
        self.driver.set_speed(&mut self.motor, &SetSpeed::STOP, shown);
    }

    /// The time of the caller's clock.
    fn caller(&self, now: u32) -> u32 {
        now.wrapping_sub(self.call).wrapping_add(self.shown)
    }

    /// Makes the main program's check, if it is due.
    pub fn poll(&mut self, now: u32) {
        if self.check == 0 || now.wrapping_sub(self.checked) < self.check.into() {
            return;
        }
        self.checked = self.checked.wrapping_add(self.check.into());
        let at = self.checked.wrapping_sub(self.call);
        let time = self.caller(self.checked);
        let (reached, fault) = (&mut self.reached, &mut self.fault);
        self.driver.update_check(&mut self.motor, time, |call| match call {
            Call::Reached => *reached = Some(at),
            Call::Fault => *fault = Some(at),
        });
    }
}
