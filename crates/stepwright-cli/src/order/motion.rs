//! The options of a motion, and the order for the board.

use std::fmt::Display;

use serde_json::{Value, json};
use stepwright::{Accel, Geometry, Jerk, Speed};
use stepwright_protocol::{AxisId, Command, Order, Ramp, RampSteps, Script, Travel, WholeJerk};

use crate::board::recording::Heading;
use crate::failure::Failure;
use crate::quantity::{
    AccelArg, GeometryArgs, JerkArg, MachineUnit, Rounded, SpeedArg, in_unit, whole_in,
};
use stepwright_host::course::Course;
use stepwright_host::settings::STEEPEST_TOGETHER;
use stepwright_machine::RAMP;
use stepwright_plot::GAP;

/// The help heading of the options of a motion.
pub const MOTION: &str =
    "Motion (speeds like 500, 120rpm, 50mm/s; accelerations like 4000, 10rad/s2)";

/// The default top speed of a travel, in steps/s.
pub const TOP: u32 = 1000;

/// The default start speed, in steps/s.
const START: u32 = 50;

/// The options that say how to start and stop.
#[derive(clap::Args, Clone, Debug)]
#[command(next_help_heading = MOTION)]
pub struct RampArgs {
    /// Speed at which the motor starts and stops without a ramp [default: 50]
    #[arg(long, value_name = "SPEED", allow_negative_numbers = true)]
    start_speed: Option<SpeedArg>,
    /// Length of both ramps in steps [default: a fifth of the top speed, 200 at 1000 steps/s]
    #[arg(long, value_name = "STEPS", conflicts_with = "accel")]
    #[arg(value_parser = whole_in::<u32>(RAMP))]
    ramp: Option<u32>,
    /// Acceleration of the ramp up, in place of its length
    #[arg(long, value_name = "ACCEL", allow_negative_numbers = true)]
    accel: Option<AccelArg>,
    /// Deceleration of the ramp down, if it differs
    #[arg(long, value_name = "ACCEL", allow_negative_numbers = true)]
    decel: Option<AccelArg>,
    /// Jerk limit, like 400000 or 200rad/s3: the ramps are S-curves [default: 0, none]
    #[arg(long, value_name = "JERK", allow_negative_numbers = true)]
    jerk: Option<JerkArg>,
    #[command(flatten)]
    geometry: GeometryArgs,
    /// How many axes move at once.
    #[arg(skip = 1usize)]
    moving: usize,
}

/// An order, as typed and as sent.
#[derive(Clone)]
pub struct Motion {
    axis: AxisId,
    /// The order as the board gets it.
    pub order: Order,
    start: Rounded<Speed>,
    top: Rounded<Speed>,
    /// The accelerations, if the ramps were given as such.
    accel: Option<String>,
    decel: Option<String>,
    jerk: Option<String>,
    /// The unit of the machine.
    pub unit: Option<MachineUnit>,
}

impl RampArgs {
    /// The same options for the motor that leads a line of `moving` axes.
    pub fn on(&self, geometry: GeometryArgs, moving: usize) -> RampArgs {
        RampArgs { geometry, moving, ..self.clone() }
    }

    /// The properties of the motor.
    pub fn built(&self) -> &GeometryArgs {
        &self.geometry
    }

    /// The geometry of the motor: steps, turns and millimetres.
    pub fn geometry(&self) -> Result<Geometry, Failure> {
        self.geometry.geometry()
    }

    /// The unit of the machine, if known.
    pub fn unit(&self) -> Option<MachineUnit> {
        self.geometry.unit()
    }

    /// Whether a start speed was given.
    pub fn has_start(&self) -> bool {
        self.start_speed.is_some()
    }

    /// Whether the length of the ramps was given.
    pub fn has_length(&self) -> bool {
        self.ramp.is_some()
    }

    /// Whether a jerk was given.
    pub fn has_jerk(&self) -> bool {
        self.jerk().is_some()
    }

    /// The jerk limit, if there is one.
    fn jerk(&self) -> Option<&JerkArg> {
        self.jerk.as_ref().filter(|jerk| !jerk.is_zero())
    }

    /// Acceleration and deceleration of a law that begins at rest. By default the top speed is
    /// reached in 0.4 s.
    pub fn slopes_from_rest(
        &self,
        geometry: &Geometry,
        top: &Rounded<Speed>,
    ) -> Result<(Rounded<Accel>, Rounded<Accel>), Failure> {
        let accel = match &self.accel {
            Some(accel) => accel.resolve(geometry, "--accel")?,
            None => {
                let whole = (u64::from(top.value.millisteps()) / 400).max(1);
                let suited: AccelArg = whole.to_string().parse().map_err(Failure::usage)?;
                suited.resolve(geometry, "--accel")?
            }
        };
        let decel = self.decel.as_ref().map(|d| d.resolve(geometry, "--decel")).transpose()?;
        let decel = decel.unwrap_or_else(|| accel.clone());
        Ok((accel, decel))
    }

    /// The order of one axis.
    pub fn motion(
        &self,
        axis: AxisId,
        top: &SpeedArg,
        top_name: &str,
        travel: Travel,
    ) -> Result<Motion, Failure> {
        let geometry = self.geometry.geometry()?;
        let start = self.start_speed.clone().unwrap_or_else(|| SpeedArg::of_steps(START));
        let start = start.resolve(&geometry, "--start-speed")?;
        let top = top.moving(&geometry, top_name)?;
        let accel = self.accel.as_ref().map(|a| a.resolve(&geometry, "--accel")).transpose()?;
        let decel = self.decel.as_ref().map(|d| d.resolve(&geometry, "--decel")).transpose()?;
        let jerk = self.jerk().map(|j| j.resolve(&geometry, "--jerk")).transpose()?;
        for (name, held) in [("--accel", &accel), ("--decel", &decel)] {
            held.as_ref().map_or(Ok(()), |held| sendable_accel(name, held))?;
        }
        jerk.as_ref().map_or(Ok(()), sendable_jerk)?;
        let up = match (&accel, self.ramp) {
            (Some(accel), _) => Ramp::Accel(accel.value),
            (None, Some(steps)) => Ramp::Steps(RampSteps::clamped(steps)),
            (None, None) => suited(start.value, top.value, steepest(self.moving, jerk.is_some())),
        };
        let down = decel.as_ref().map_or(up, |d| Ramp::Accel(d.value));
        let bend = jerk.as_ref().map(|j| j.value);
        let order = Order { start: start.value, top: top.value, up, down, jerk: bend, travel };
        let order = order.sendable()?;
        let shown = |held: &Rounded<_>| held.to_string();
        let (accel, decel) = (accel.as_ref().map(shown), decel.as_ref().map(shown));
        let jerk = jerk.as_ref().zip(order.jerk);
        let jerk = jerk.map(|(held, sent)| sent_as(held, held.value != sent, sent));
        let unit = self.unit();
        Ok(Motion { axis, order, start, top, accel, decel, jerk, unit })
    }
}

/// Checks that a board takes this acceleration: whole steps/s².
pub fn sendable_accel(name: &str, accel: &Rounded<Accel>) -> Result<(), Failure> {
    if accel.value.millisteps() >= 1000 {
        return Ok(());
    }
    Err(Failure::usage(format!("{name} {} is less than 1 step/s²", accel.given))
        .hint("a board takes accelerations as whole numbers of steps/s²: 1 or more"))
}

/// Checks that a board takes this jerk: whole steps/s³.
fn sendable_jerk(jerk: &Rounded<Jerk>) -> Result<(), Failure> {
    let most = WholeJerk::LARGEST.get();
    let range = match jerk.value.millisteps() {
        0..1000 => "less than 1 step/s³".to_owned(),
        value if value > u64::from(most) * 1000 => format!("more than {most} steps/s³"),
        _ => return Ok(()),
    };
    Err(Failure::usage(format!("--jerk {} is {range}", jerk.given))
        .hint(format!("a board takes jerks as whole numbers of steps/s³: 1 to {most}")))
}

/// The steepest default ramp of this many axes at once.
fn steepest(moving: usize, has_jerk: bool) -> Accel {
    let [two, three] = STEEPEST_TOGETHER[usize::from(has_jerk)];
    match moving {
        0 | 1 => Accel::MAX,
        2 => Accel::clamped(two),
        _ => Accel::clamped(three),
    }
}

/// The default ramp of an order: as many steps as the motor makes in a fifth of a second at its top
/// speed, so that from rest the ramp takes 0.4 s at any top speed; but not steeper than `most`.
fn suited(start: Speed, top: Speed, most: Accel) -> Ramp {
    let steps = (top.millisteps() / 5).div_ceil(1000).max(1);
    // The acceleration of a ramp of this length.
    let square = |v: Speed| u128::from(v.millisteps()).pow(2);
    let rise = square(top).saturating_sub(square(start));
    let accel = rise / (2 * u128::from(steps) * 1000);
    if accel > u128::from(most.millisteps()) {
        return Ramp::Accel(most);
    }
    if RAMP.contains(&steps) {
        return Ramp::Steps(RampSteps::clamped(steps));
    }
    // More steps than the line can carry.
    let whole = accel.div_ceil(1000).saturating_mul(1000);
    let accel = u64::try_from(whole).ok().and_then(|a| Accel::from_millisteps(a).ok());
    accel.map_or(Ramp::Steps(RampSteps::clamped(*RAMP.end())), Ramp::Accel)
}

impl Motion {
    /// The motion for another travel.
    pub fn with_travel(&self, travel: Travel) -> Motion {
        Motion { order: Order { travel, ..self.order }, ..self.clone() }
    }

    /// The axis that moves.
    pub fn axis(&self) -> AxisId {
        self.axis
    }

    /// The lines of the order.
    pub fn lines(&self) -> Result<Vec<Command>, Failure> {
        let orders = [(self.axis, self.order)];
        Ok(Script::new(&orders)?.collect())
    }

    /// The motion in closed form; `None` if it is endless, or no timer can represent it.
    pub fn course(&self) -> Option<Course> {
        Course::of(&self.order.into())
    }

    /// Its duration in seconds; `None` if it is endless.
    pub fn duration(&self) -> Option<f64> {
        self.course().map(|course| course.duration())
    }

    /// The values of the order, as text.
    pub fn show(&self) -> Vec<String> {
        let mut rows = Vec::new();
        let mut row = |name: &str, text: String| rows.push(format!("  {name:<12}{text}"));
        let speed = |held: &Rounded<Speed>, sent: Speed| sent_as(held, held.value != sent, sent);
        row("start speed", speed(&self.start, self.order.start));
        row("top speed", speed(&self.top, self.order.top));
        if self.order.top <= self.order.start {
            row("ramps", "none: the top speed is not above the start speed".to_owned());
        } else {
            row("ramp up", self.ramp(self.order.up, self.accel.as_deref()));
            let down = self.decel.as_deref().or(self.accel.as_deref());
            row("ramp down", self.ramp(self.order.down, down));
            if let Some(jerk) = &self.jerk {
                row("jerk", jerk.clone());
            }
        }
        if let Some(course) = self.course().filter(|course| course.pulses() > 1) {
            if course.peak() < self.order.top.millisteps() {
                let peak = f64::from(course.peak()) / 1000.0;
                row("peak", format!("{peak:.0} steps/s: too short a travel for the top speed"));
            }
            row("takes", seconds(course.duration()));
        }
        rows
    }

    /// The values of the order, as the heading of a plot.
    pub fn heading(&self, title: String) -> Heading {
        let rows = self.show().into_iter();
        let note = rows.map(|row| row.split_whitespace().collect::<Vec<_>>().join(" "));
        let notes = vec![note.collect::<Vec<_>>().join(GAP)];
        Heading { title, notes, unit: self.unit, jerk: self.jerk.is_some() }
    }

    fn ramp(&self, ramp: Ramp, given: Option<&str>) -> String {
        let squared = |v: Speed| (f64::from(v.millisteps()) / 1000.0).powi(2);
        let rise = squared(self.order.top) - squared(self.order.start);
        match ramp {
            Ramp::Steps(steps) => {
                let accel = rise / (2.0 * f64::from(steps.get()));
                let unit = if steps.get() == 1 { "step" } else { "steps" };
                format!("{} {unit} ({accel:.0} steps/s²)", steps.get())
            }
            Ramp::Accel(accel) => {
                let steps = rise / (2.0 * accel.millisteps() as f64 / 1000.0);
                let sent = format!("{accel} steps/s²");
                let given = given.unwrap_or(&sent);
                let sent = if given.ends_with(&sent) {
                    String::new()
                } else {
                    format!(", sent as {accel}")
                };
                match self.jerk {
                    // The jerk limit makes the ramp longer.
                    Some(_) => format!("{given}{sent}"),
                    None => format!("{given}{sent} ({steps:.0} steps)"),
                }
            }
        }
    }

    /// The values of the order, as JSON.
    pub fn json(&self) -> Value {
        let ramp = |ramp| match ramp {
            Ramp::Steps(steps) => json!({ "steps": steps.get() }),
            Ramp::Accel(accel) => json!({ "accel": accel.millisteps() as f64 / 1000.0 }),
        };
        let speed = |speed: Speed| f64::from(speed.millisteps()) / 1000.0;
        let motion = json!({
            "start_speed": speed(self.order.start),
            "top_speed": speed(self.order.top),
            "ramp_up": ramp(self.order.up),
            "ramp_down": ramp(self.order.down),
            "jerk": self.order.jerk.map(|jerk| jerk.millisteps() as f64 / 1000.0),
            "duration": self.duration(),
        });
        let names = ["start_speed", "top_speed", "ramp_up", "ramp_down", "jerk"];
        in_unit(self.unit, motion, &names)
    }
}

/// The longest wait of a board in this order, in seconds: between two steps; for a motion from
/// rest, in the first step, the last one and one at the top speed, which the board holds together.
pub fn longest_wait(order: &Order) -> f64 {
    let speed = |v: Speed| f64::from(v.millisteps()) / 1000.0;
    let top = speed(order.top);
    if order.start != Speed::ZERO {
        return 1.0 / top.min(speed(order.start));
    }
    let from_rest = |ramp| match ramp {
        Ramp::Steps(steps) => 2.0 * f64::from(steps.get()).sqrt() / top,
        Ramp::Accel(accel) => (2000.0 / accel.millisteps() as f64).sqrt(),
    };
    from_rest(order.up) + from_rest(order.down) + 1.0 / top
}

fn sent_as(held: &impl Display, rounded: bool, sent: impl Display) -> String {
    if rounded { format!("{held}, sent as {sent}") } else { held.to_string() }
}

/// A time as text.
pub fn seconds(time: f64) -> String {
    let whole = time.round();
    if time < 100.0 {
        format!("{time:.3} s")
    } else if whole < 6000.0 {
        format!("{:.0} min {:02.0} s", (whole / 60.0).floor(), whole % 60.0)
    } else {
        format!("{:.0} h {:02.0} min", (whole / 3600.0).floor(), (whole % 3600.0 / 60.0).floor())
    }
}

/// The lines, separated by spaces.
pub fn listed(lines: &[Command]) -> String {
    let lines: Vec<String> = lines.iter().map(Command::to_string).collect();
    lines.join(" ")
}

#[cfg(test)]
mod tests {
    use super::seconds;

    #[test]
    fn times_are_rounded_as_a_whole() {
        for (time, text) in [
            (1.2345, "1.234 s"),
            (99.9, "99.900 s"),
            (119.4, "1 min 59 s"),
            (119.6, "2 min 00 s"),
            (5639.9, "94 min 00 s"),
            (5999.7, "1 h 40 min"),
            (21474.8, "5 h 57 min"),
        ] {
            assert_eq!(seconds(time), text);
        }
    }
}
