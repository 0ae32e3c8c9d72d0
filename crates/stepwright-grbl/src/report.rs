//! Reports: status, parameters, modes.

use std::fmt::Write;

use stepwright_gcode::{
    Length, Modal, MotionMode, Parameter, Plane, Point, Probe, Reader, SpindleMode, System,
};

use crate::machine::{GrblMachine, Inputs};
use crate::motion::{BLOCKS, clamped, length};
use crate::session::{Grbl, RX};
use crate::state::State;
use stepwright_path::{decimal, mm};

/// Every n-th report has the offsets: n at rest, and n during a motion.
const OFFSETS_EVERY: (u8, u8) = (10, 30);
/// Every n-th report has the overrides: n at rest, and n during a motion.
const OVERRIDES_EVERY: (u8, u8) = (10, 20);

/// The number of reports until the next one with offsets, and with overrides.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Seldom {
    pub offsets: u8,
    pub overrides: u8,
}

/// Writes coordinates, separated by commas.
fn coordinates(out: &mut String, values: [Length; 3], inches: bool) {
    for (axis, value) in values.into_iter().enumerate() {
        if axis > 0 {
            out.push(',');
        }
        number(out, value, inches);
    }
}

/// Writes a coordinate: three digits after the point, four in inches.
fn number(out: &mut String, value: Length, inches: bool) {
    // Rounds first, so that zero has no sign.
    let (value, digits) = if inches { (mm(value) / 25.4, 4) } else { (mm(value), 3) };
    let scale = 10f64.powi(digits);
    let rounded = (value * scale).round() / scale + 0.0;
    _ = write!(out, "{rounded:.*}", digits as usize);
}

/// The offset of work coordinates from machine coordinates.
pub(crate) fn offset(reader: &Reader) -> Point {
    let of = |parameter| reader.parameter(parameter).0;
    let parts = [
        of(Parameter::System(reader.modal().system)),
        of(Parameter::G92),
        of(Parameter::ToolLength),
    ];
    Point([0, 1, 2].map(|axis| clamped(parts.iter().map(|part| part[axis].picometres()).sum())))
}

/// The modes as `$G` prints them.
pub(crate) fn modes(modal: &Modal) -> String {
    let motion = match modal.motion {
        MotionMode::Rapid => "G0",
        MotionMode::Feed => "G1",
        MotionMode::Clockwise => "G2",
        MotionMode::CounterClockwise => "G3",
        MotionMode::Probe(Probe { toward: true, must: true }) => "G38.2",
        MotionMode::Probe(Probe { toward: true, must: false }) => "G38.3",
        MotionMode::Probe(Probe { toward: false, must: true }) => "G38.4",
        MotionMode::Probe(Probe { toward: false, must: false }) => "G38.5",
        MotionMode::Off => "G80",
    };
    let plane = match modal.plane {
        Plane::Xy => "G17",
        Plane::Zx => "G18",
        Plane::Yz => "G19",
    };
    let system = 54 + modal.system as u8;
    let [units, distance, feed] = [
        if modal.inches { "G20" } else { "G21" },
        if modal.incremental { "G91" } else { "G90" },
        if modal.inverse_time { "G93" } else { "G94" },
    ];
    let spindle = match modal.spindle.mode {
        SpindleMode::Clockwise => "M3",
        SpindleMode::CounterClockwise => "M4",
        SpindleMode::Off => "M5",
    };
    let coolant = match (modal.coolant.mist, modal.coolant.flood) {
        (true, true) => "M7 M8",
        (true, false) => "M7",
        (false, true) => "M8",
        (false, false) => "M9",
    };
    let rate = modal.feed.map_or(0.0, mm) / if modal.inches { 25.4 } else { 1.0 };
    let power = decimal(modal.spindle.speed);
    let tool = modal.tool;
    let digits = usize::from(modal.inches);
    format!(
        "[GC:{motion} G{system} {plane} {units} {distance} {feed} {spindle} {coolant} T{tool} \
         F{rate:.digits$} S{power:.0}]"
    )
}

impl<M: GrblMachine> Grbl<M> {
    /// The machine's position.
    pub(crate) fn place(&self) -> Point {
        let steps = self.settings.axes(100);
        Point([0, 1, 2].map(|axis| length(self.motion.at[axis] as f64 / steps[axis])))
    }

    /// Writes the status report.
    pub(crate) fn report(&mut self) {
        let mut out = String::from("<");
        let held = self.motion.is_over() || self.motion.is_held(self.now);
        let door = self.machine.inputs().door;
        out += match self.state {
            State::Idle => "Idle",
            State::Run => "Run",
            State::Jog => "Jog",
            State::Hold if held => "Hold:0",
            State::Hold => "Hold:1",
            State::Door if !held => "Door:2",
            State::Door if door => "Door:1",
            State::Door => "Door:0",
            State::Home => "Home",
            State::Alarm { .. } => "Alarm",
            State::Check => "Check",
            State::Sleep => "Sleep",
        };
        let (mask, inches) = (self.settings.get(10) as u16, self.settings.is_on(13));
        let (place, offset) = (self.place(), offset(&self.reader));
        if mask & 1 != 0 {
            out += "|MPos:";
            coordinates(&mut out, place.0, inches);
        } else {
            out += "|WPos:";
            let less =
                |axis: usize| clamped(place.0[axis].picometres() - offset.0[axis].picometres());
            coordinates(&mut out, [0, 1, 2].map(less), inches);
        }
        if mask & 2 != 0 {
            let free = RX.saturating_sub(self.waiting());
            _ = write!(out, "|Bf:{},{free}", self.motion.room().min(BLOCKS));
        }
        if let Some(line) = self.motion.line() {
            _ = write!(out, "|Ln:{line}");
        }
        let speed = self.motion.speed(self.now) * 60.0 / if inches { 25.4 } else { 1.0 };
        let digits = usize::from(inches);
        _ = write!(out, "|FS:{speed:.digits$},{:.0}", self.outputs.power);
        pins(&mut out, self.machine.inputs());
        self.seldom(&mut out, offset, inches);
        out += ">\r\n";
        self.say(&out);
    }

    /// Writes the fields that not every report has.
    fn seldom(&mut self, out: &mut String, offset: Point, inches: bool) {
        let moves = !matches!(self.state, State::Idle | State::Alarm { .. });
        let every = |(rest, busy): (u8, u8)| if moves { busy } else { rest };
        let seldom = &mut self.seldom;
        if seldom.offsets > 0 {
            seldom.offsets -= 1;
        } else {
            seldom.offsets = every(OFFSETS_EVERY) - 1;
            // Overrides come in the next report.
            seldom.overrides = seldom.overrides.max(1);
            *out += "|WCO:";
            coordinates(out, offset.0, inches);
        }
        if seldom.overrides > 0 {
            seldom.overrides -= 1;
            return;
        }
        seldom.overrides = every(OVERRIDES_EVERY) - 1;
        let of = self.overrides;
        _ = write!(out, "|Ov:{},{},{}", of.feed, of.rapid, of.spindle);
        let on = self.outputs;
        let letters: String = [
            (on.spindle == SpindleMode::Clockwise, 'S'),
            (on.spindle == SpindleMode::CounterClockwise, 'C'),
            (on.flood, 'F'),
            (on.mist, 'M'),
        ]
        .into_iter()
        .filter_map(|(on, letter)| on.then_some(letter))
        .collect();
        if !letters.is_empty() {
            _ = write!(out, "|A:{letters}");
        }
    }

    /// Writes the parameters as in `$#`.
    pub(crate) fn parameters(&mut self) {
        let inches = self.settings.is_on(13);
        let mut out = String::new();
        let systems = System::ALL
            .map(|system| (format!("G{}", 54 + system as u8), Parameter::System(system)));
        let others = [("G28", Parameter::G28), ("G30", Parameter::G30), ("G92", Parameter::G92)];
        let others = others.map(|(name, parameter)| (name.to_owned(), parameter));
        for (name, parameter) in systems.into_iter().chain(others) {
            _ = write!(out, "[{name}:");
            coordinates(&mut out, self.reader.parameter(parameter).0, inches);
            out += "]\r\n";
        }
        out += "[TLO:";
        number(&mut out, self.reader.parameter(Parameter::ToolLength).0[2], inches);
        out += "]\r\n";
        self.say(&out);
        self.probed();
    }

    /// Writes the position of the probe's contact.
    pub(crate) fn probed(&mut self) {
        let mut out = String::from("[PRB:");
        coordinates(&mut out, self.probe_at.0, self.settings.is_on(13));
        _ = write!(out, ":{}]\r\n", u8::from(self.probe_met));
        self.say(&out);
    }
}

/// Writes the letters of the closed switches.
fn pins(out: &mut String, inputs: Inputs) {
    let letters: String = [
        (inputs.probe, 'P'),
        (inputs.limit[0], 'X'),
        (inputs.limit[1], 'Y'),
        (inputs.limit[2], 'Z'),
        (inputs.door, 'D'),
    ]
    .into_iter()
    .filter_map(|(closed, letter)| closed.then_some(letter))
    .collect();
    if !letters.is_empty() {
        _ = write!(out, "|Pn:{letters}");
    }
}
