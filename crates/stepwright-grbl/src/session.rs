//! The controller: takes bytes and times, and gives answers and steps.

use std::collections::VecDeque;

use stepwright_gcode::{Coolant, Point, Reader, Spindle, SpindleMode};

use crate::homing::Homing;
use crate::line::{Line, Lock, SPOILT};
use crate::machine::{GrblMachine, Outputs};
use crate::motion::Motion;
use crate::overrides::Overrides;
use crate::rates::{Judge, virtual_rates};
use crate::report::Seldom;
use crate::settings::GrblSettings;
use crate::state::{After, State};
use crate::work::{Probing, Work};

/// The size of the receive buffer in reports. Further bytes are stored too, up to [`KEPT`].
pub const RX: usize = 128;

/// The most bytes of waiting lines. Beyond, no line is executed; real-time bytes are still obeyed.
pub const KEPT: usize = 65_536;

/// grbl 1.1 on a [`GrblMachine`].
///
/// Times are in seconds of any clock that does not go back. Call [`advance`](Grbl::advance) every
/// few milliseconds. Steps have the times of their plan, whenever it is called.
#[derive(Debug)]
pub struct Grbl<M> {
    pub(crate) machine: M,
    pub(crate) settings: GrblSettings,
    pub(crate) reader: Reader,
    pub(crate) motion: Motion,
    pub(crate) state: State,
    pub(crate) after: Option<After>,
    pub(crate) now: f64,
    pub(crate) overrides: Overrides,
    pub(crate) outputs: Outputs,
    /// The spindle as ordered, before overrides.
    pub(crate) spindle: Spindle,
    pub(crate) seldom: Seldom,
    pub(crate) work: Option<Work>,
    pub(crate) homing: Option<Homing>,
    pub(crate) probing: Option<Probing>,
    pub(crate) probe_at: Point,
    pub(crate) probe_met: bool,
    pub(crate) startup: [String; 2],
    pub(crate) build: String,
    /// The reader before check mode.
    pub(crate) unchecked: Option<Reader>,
    pub(crate) lock: Lock,
    /// Whether the spindle is stopped during a hold, by an override.
    pub(crate) spindle_rests: bool,
    /// The coolant, flood and mist, before a door stopped it.
    pub(crate) cooled: Option<(bool, bool)>,
    pub(crate) judge: Judge,
    /// Whether a fed board has an output for a laser.
    pub(crate) lasers: bool,
    /// The limit switches that were closed at the last check.
    closed: [bool; 3],
    /// The number of waiting bytes whose jogs are cancelled.
    cancelled: usize,
    /// The number of refused lines and alarms.
    pub(crate) faults: u64,
    rx: VecDeque<u8>,
    line: Line,
    out: Vec<u8>,
}

impl<M: GrblMachine> Grbl<M> {
    /// A controller at machine zero, with default settings. The banner is its first answer.
    pub fn new(machine: M) -> Grbl<M> {
        let mut grbl = Grbl {
            machine,
            settings: GrblSettings::default(),
            reader: Reader::default(),
            motion: Motion::default(),
            state: State::Idle,
            after: None,
            now: 0.0,
            overrides: Overrides::NONE,
            outputs: Outputs::default(),
            spindle: Spindle::default(),
            seldom: Seldom::default(),
            work: None,
            homing: None,
            probing: None,
            probe_at: Point::ZERO,
            probe_met: false,
            startup: [String::new(), String::new()],
            build: String::new(),
            unchecked: None,
            lock: Lock::default(),
            spindle_rests: false,
            cooled: None,
            judge: Judge(Box::new(virtual_rates)),
            lasers: false,
            closed: [false; 3],
            cancelled: 0,
            faults: 0,
            rx: VecDeque::new(),
            line: Line::default(),
            out: Vec::new(),
        };
        grbl.restart();
        grbl
    }

    /// Also executes lines after an error, as grbl does.
    pub fn with_errors_passed(mut self) -> Grbl<M> {
        self.lock.off = true;
        self
    }

    /// Takes bytes from the sender.
    pub fn receive(&mut self, now: f64, bytes: &[u8]) {
        self.advance(now);
        for &byte in bytes {
            if !self.real_time(byte) {
                let waits = self.work.is_some() || !self.rx.is_empty();
                self.lock.hear(self.now, waits);
                match self.rx.len() {
                    0..KEPT => self.rx.push_back(byte),
                    KEPT => self.rx.push_back(SPOILT),
                    _ => {}
                }
            }
        }
        self.pump();
    }

    /// Lets time pass: makes steps, checks the switches, executes lines.
    pub fn advance(&mut self, now: f64) {
        let now = self.now.max(now);
        while let Some(step) = self.motion.next(now) {
            self.now = self.now.max(step.time);
            self.machine.step(step.time, step.axis, step.forward);
            self.look();
        }
        self.now = now;
        self.look();
        self.settle();
        self.pump();
    }

    /// Takes the answers since the last call.
    pub fn take_answers(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.out)
    }

    /// The number of bytes of waiting lines.
    pub fn waiting(&self) -> usize {
        self.rx.len()
    }

    /// The number of refused lines and alarms since power-up.
    pub fn faults(&self) -> u64 {
        self.faults
    }

    /// Whether an axis moves, or will move without a further byte.
    pub fn is_moving(&self) -> bool {
        let moves = !(self.motion.is_over() || self.motion.is_held(self.now));
        moves || self.work.is_some() && !matches!(self.state, State::Hold | State::Door)
    }

    /// Whether nothing is left to do: no move, no line, no hold.
    pub fn is_idle(&self) -> bool {
        let waits = matches!(self.state, State::Hold | State::Door) || !self.rx.is_empty();
        self.motion.is_over() && self.work.is_none() && !waits
    }

    /// Ends the input: a line without an end is executed as it is.
    pub fn finish_line(&mut self, now: f64) {
        let half =
            self.rx.back().map_or(!self.line.is_empty(), |byte| !matches!(byte, b'\r' | b'\n'));
        if half {
            self.receive(now, b"\n");
        }
    }

    /// Brakes along the path, drops all lines and switches the outputs off. Unlike after ^X, no start-up
    /// line is executed, and no further line before a reset.
    pub fn end(&mut self, now: f64) {
        self.advance(now);
        self.forget_lines();
        self.brake(After::End);
    }

    /// Handles a sender that has disconnected: drops its incomplete line.
    pub fn hang_up(&mut self) {
        let ends = |byte: &u8| matches!(byte, b'\r' | b'\n');
        match self.rx.iter().rposition(ends) {
            Some(last) => self.rx.truncate(last + 1),
            None => {
                self.rx.clear();
                self.line = Line::default();
            }
        }
        self.cancelled = self.cancelled.min(self.rx.len());
    }

    /// The machine.
    pub fn machine(&self) -> &M {
        &self.machine
    }

    /// The machine, to set its switches.
    pub fn machine_mut(&mut self) -> &mut M {
        &mut self.machine
    }

    /// The steps of each axis from machine zero.
    pub fn position(&self) -> [i64; 3] {
        self.motion.at
    }

    /// The settings.
    pub fn settings(&self) -> &GrblSettings {
        &self.settings
    }

    pub(crate) fn say(&mut self, text: &str) {
        self.out.extend_from_slice(text.as_bytes());
    }

    pub(crate) fn ok(&mut self) {
        self.say("ok\r\n");
    }

    pub(crate) fn error(&mut self, number: u8) {
        self.faults += 1;
        self.say(&format!("error:{number}\r\n"));
    }

    /// Executes waiting lines while the state permits it.
    fn pump(&mut self) {
        loop {
            if self.after.is_some() || matches!(self.state, State::Alarm { critical: true }) {
                return;
            }
            match self.state {
                State::Hold | State::Door | State::Sleep => return,
                _ => {}
            }
            if self.work.is_some() {
                if !self.go_on_with_work() {
                    return;
                }
                continue;
            }
            let Some(byte) = self.rx.pop_front() else { return };
            let cancelled = self.cancelled > 0;
            self.cancelled = self.cancelled.saturating_sub(1);
            match self.line.take(byte) {
                Some(Ok(text)) if cancelled && text.starts_with(b"$J=") => self.ok(),
                Some(Ok(text)) => self.obey(&text),
                Some(Err(())) => self.refuse(11),
                None => {}
            }
        }
    }

    /// Refuses a line of G-code with an error.
    pub(crate) fn refuse(&mut self, number: u8) {
        // Check mode is there to find all errors.
        if self.state != State::Check {
            self.lock.close(self.now);
            if self.lock.is_closed() && self.settings.is_on(32) {
                // The next job switches the laser on by itself.
                self.stop_spindle();
            }
        }
        self.error(number);
    }

    fn obey(&mut self, text: &[u8]) {
        match text {
            [] => self.ok(),
            [b'$', order @ ..] => self.order(order),
            _ if matches!(self.state, State::Alarm { .. } | State::Jog) => self.error(9),
            // Orders that switch off are carried out even after an error.
            b"M5" | b"M05" | b"M9" | b"M09" => self.gcode(text),
            _ if self.lock.is_closed() => self.refuse(9),
            _ => self.gcode(text),
        }
    }

    /// Carries out a real-time byte. Returns false if the byte belongs to a line.
    fn real_time(&mut self, byte: u8) -> bool {
        match byte {
            b'?' => self.report(),
            0x18 => self.reset(),
            b'!' => self.hold(),
            b'~' => self.resume(),
            0x84 => self.door(),
            0x85 => self.cancel_jog(),
            0x9E => self.rest_spindle(),
            0xA0 | 0xA1 => self.toggle_coolant(byte == 0xA1),
            _ => match self.overrides.after(byte) {
                Some(overrides) => self.override_by(overrides),
                // Other bytes from 0x80 on belong to no line.
                None => return byte >= 0x80,
            },
        }
        true
    }

    fn override_by(&mut self, overrides: Overrides) {
        if overrides != self.overrides {
            self.overrides = overrides;
            self.seldom.overrides = 0;
            let plain = self.probing.is_some() || matches!(self.state, State::Jog | State::Home);
            self.motion.scale(self.now, overrides.scales(plain));
            self.switch();
        }
    }

    /// `!`
    fn hold(&mut self) {
        match self.state {
            State::Run | State::Idle => {
                self.motion.hold(self.now);
                self.state = State::Hold;
            }
            State::Jog => self.cancel_jog(),
            _ => {}
        }
    }

    /// `~`
    fn resume(&mut self) {
        let open = self.machine.inputs().door;
        if self.state == State::Hold || self.state == State::Door && !open {
            if self.state == State::Door && self.spindle.mode != SpindleMode::Off {
                self.say("[MSG:Restoring spindle]\r\n");
            }
            self.spindle_rests = false;
            self.motion.resume(self.now);
            self.state = if self.motion.is_over() { State::Idle } else { State::Run };
            self.switch();
        }
    }

    /// Handles an open door, or the real-time byte for it.
    fn door(&mut self) {
        match self.state {
            State::Idle | State::Run | State::Hold => {
                self.motion.hold(self.now);
                self.state = State::Door;
                if self.machine.inputs().door {
                    self.say("[MSG:Check Door]\r\n");
                }
            }
            State::Jog => {
                self.cancel_jog();
                self.brake(After::Door);
            }
            State::Home => self.brake(After::Alarm(7)),
            _ => {}
        }
        self.switch();
    }

    fn cancel_jog(&mut self) {
        if self.state == State::Idle {
            // The jog may have come right before this byte.
            self.cancelled = self.rx.len();
        }
        if self.state == State::Jog && self.after.is_none() {
            self.cancelled = self.rx.len();
            if self.work.take().is_some() {
                // Answers a jog that waits for its place in the planner.
                self.ok();
            }
            self.brake(After::Jog);
        }
    }

    /// Stops the spindle during a hold, or restarts it.
    fn rest_spindle(&mut self) {
        if self.state == State::Hold && self.spindle.mode != SpindleMode::Off {
            self.spindle_rests = !self.spindle_rests;
            self.switch();
        }
    }

    fn toggle_coolant(&mut self, mist: bool) {
        if matches!(self.state, State::Idle | State::Run | State::Hold) {
            let on = &mut self.outputs;
            let which = if mist { &mut on.mist } else { &mut on.flood };
            *which = !*which;
            let Outputs { flood, mist, .. } = *on;
            self.cool(Coolant { flood, mist });
        }
    }

    /// Switches the coolant.
    pub(crate) fn cool(&mut self, coolant: Coolant) {
        let Coolant { flood, mist } = coolant;
        // The reader reports changes relative to the state that it knows.
        self.reader.set_coolant(coolant);
        self.outputs = Outputs { flood, mist, ..self.outputs };
        self.seldom.overrides = 0;
        self.machine.switch(self.now, self.outputs);
    }

    /// Drops lines that were received and not executed.
    pub(crate) fn forget_lines(&mut self) {
        self.rx.clear();
        self.line = Line::default();
        self.cancelled = 0;
    }

    /// ^X
    fn reset(&mut self) {
        self.forget_lines();
        if self.state == State::Home {
            self.brake(After::Alarm(6));
            return;
        }
        self.brake(After::Reset);
    }

    /// Brakes along the path, then carries out `after`.
    pub(crate) fn brake(&mut self, after: After) {
        if self.after.is_none() {
            self.motion.cancel(self.now);
        }
        if self.after.is_none_or(|known| known.rank() < after.rank()) {
            self.after = Some(after);
        }
        if after.ends() && !self.motion.is_over() {
            // As in grbl, at once.
            self.cooled = None;
            self.cool(Coolant::default());
            self.switch();
        }
        self.settle();
    }

    /// Carries out `after` once no axis moves.
    pub(crate) fn settle(&mut self) {
        if !self.motion.is_over() {
            return;
        }
        match self.after.take() {
            Some(After::Reset) => return self.restart(),
            Some(After::Alarm(number)) => return self.alarm(number),
            Some(After::Jog) => self.find_place(),
            Some(After::Door) => {
                self.find_place();
                self.state = State::Door;
            }
            Some(After::Sleep | After::End) => {
                self.state = State::Sleep;
                return self.drop_all();
            }
            None => {}
        }
        if matches!(self.state, State::Run | State::Jog) && self.probing.is_none() {
            self.state = State::Idle;
        }
        self.switch();
    }

    /// Sets the reader's position to the machine's, from which the next move starts.
    pub(crate) fn find_place(&mut self) {
        self.reader.set_position(self.place());
    }

    /// Switches the spindle off until it is ordered again.
    fn stop_spindle(&mut self) {
        self.spindle = Spindle::default();
        self.reader.set_spindle(Spindle { mode: SpindleMode::Off, ..self.reader.modal().spindle });
    }

    /// Drops all orders, and switches the outputs off.
    fn drop_all(&mut self) {
        (self.work, self.homing, self.probing) = (None, None, None);
        self.stop_spindle();
        self.reader.set_coolant(Coolant::default());
        self.cooled = None;
        self.outputs = Outputs { power: -1.0, ..Outputs::default() };
        self.switch();
    }

    pub(crate) fn alarm(&mut self, number: u8) {
        self.faults += 1;
        let critical = matches!(number, 1..=3);
        self.state = State::Alarm { critical };
        self.drop_all();
        self.find_place();
        self.say(&format!("ALARM:{number}\r\n"));
        if critical {
            self.say("[MSG:Reset to continue]\r\n");
        }
        // A failed homing ends like a reset.
        if matches!(number, 6..=9) {
            self.restart_as(true);
        }
    }

    /// Restarts as at power-up, except for the position, the settings and the kept values.
    fn restart(&mut self) {
        self.restart_as(matches!(self.state, State::Alarm { .. } | State::Sleep));
    }

    /// Like [`restart`](Grbl::restart), locked or not.
    pub(crate) fn restart_as(&mut self, locked: bool) {
        // Lines that came while it braked were sent before the banner.
        self.forget_lines();
        self.reader = self.unchecked.take().unwrap_or(self.reader);
        self.reader = self.fresh_reader();
        self.find_place();
        self.overrides = Overrides::NONE;
        self.seldom = Seldom::default();
        (self.spindle_rests, self.probe_met) = (false, false);
        self.lock.open();
        let closed = self.settings.is_on(21) && self.machine.inputs().limit.contains(&true);
        let locked = locked || closed;
        self.state = if locked { State::Alarm { critical: false } } else { State::Idle };
        self.drop_all();
        self.say("\r\nGrbl 1.1h ['$' for help]\r\n");
        if closed {
            self.say("[MSG:Check Limits]\r\n");
        }
        if locked {
            self.say("[MSG:'$H'|'$X' to unlock]\r\n");
        } else {
            self.begin_startup();
        }
    }

    /// Checks the switches.
    fn look(&mut self) {
        let inputs = self.machine.inputs();
        let closed = std::mem::replace(&mut self.closed, inputs.limit);
        if self.homing.is_some() {
            if inputs.door && self.after.is_none() {
                self.brake(After::Alarm(7));
            }
            self.go_on_homing(inputs);
            return self.switch();
        }
        if let Some(probing) = &self.probing
            && inputs.probe == probing.probe.toward
            && !self.probe_met
        {
            (self.probe_at, self.probe_met) = (self.place(), true);
            self.motion.cancel(self.now);
        }
        let ends = self.after.is_some_and(After::ends);
        let moves = !self.motion.is_over() && !ends;
        // A switch that stays closed permits the motion away from it.
        let closes = (0..3).any(|axis| inputs.limit[axis] && !closed[axis]);
        if moves && self.settings.is_on(21) && closes {
            self.brake(After::Alarm(1));
        }
        if inputs.door && matches!(self.state, State::Idle | State::Run | State::Jog | State::Hold)
        {
            self.door();
        }
        if self.settings.is_on(32) || self.state == State::Door {
            self.switch();
        }
    }

    /// A new reader with the kept offsets.
    fn fresh_reader(&self) -> Reader {
        let mut reader = Reader::default();
        for parameter in crate::kept::PARAMETERS {
            reader.set_parameter(parameter, self.reader.parameter(parameter));
        }
        reader
    }
}
