//! The limits of a job's axes: from options, from the machine file, or those of a usual machine.

use std::fmt::Display;
use std::str::FromStr;

use stepwright_path::AxisPace;
use stepwright_play::gcode::NAMES;
use stepwright_protocol::AxisId;

use crate::failure::Failure;
use crate::machine::{MachineArgs, MachineAxes};
use crate::quantity::{AccelArg, GeometryArgs, JerkArg, MmArg, STEPS_PER_REV, SpeedArg, whole_in};

/// The heading of these options.
const AXES: &str = "Axes";

/// The values of a usual machine: a belt of 40 mm a turn, 16 microsteps.
const USUAL: [(&str, &str); 5] = [
    ("steps_per_rev", "3200"),
    ("mm_per_rev", "40"),
    ("top_speed", "200mm/s"),
    ("accel", "1000mm/s2"),
    ("start_speed", "5mm/s"),
];

/// The options: one value for all axes, or one for each.
#[derive(clap::Args, Clone, Debug, Default)]
#[command(next_help_heading = AXES)]
pub struct AxesArgs {
    /// Steps of one turn, microsteps included [default: 3200]
    #[arg(long, value_name = "N[,N,N]", value_delimiter = ',')]
    #[arg(value_parser = whole_in::<u32>(STEPS_PER_REV))]
    steps_per_rev: Vec<u32>,
    /// Millimetres that the axis travels in one turn [default: 40]
    #[arg(long, value_name = "MM[,MM,MM]", value_delimiter = ',', allow_hyphen_values = true)]
    mm_per_rev: Vec<MmArg>,
    /// The highest speed, whatever the job orders; that of rapid moves [default: 200mm/s]
    #[arg(long, value_name = "SPEED[,…]", value_delimiter = ',', allow_hyphen_values = true)]
    top_speed: Vec<SpeedArg>,
    /// Acceleration [default: 1000mm/s2]
    #[arg(long, value_name = "ACCEL[,…]", value_delimiter = ',', allow_hyphen_values = true)]
    accel: Vec<AccelArg>,
    /// By how much the speed may change at once, as at a corner [default: 5mm/s]
    #[arg(long, value_name = "SPEED[,…]", value_delimiter = ',', allow_hyphen_values = true)]
    start_speed: Vec<SpeedArg>,
    /// By how much the acceleration may change in a second; 0 is no limit [default: no limit]
    #[arg(long, value_name = "JERK[,…]", value_delimiter = ',', allow_hyphen_values = true)]
    jerk: Vec<JerkArg>,
}

impl AxesArgs {
    /// The limits of X, Y and Z, in mm and s. Prints a note if the machine file is used.
    pub fn paces(&self, machine: &MachineArgs) -> Result<[AxisPace; 3], Failure> {
        self.of(&MachineAxes::read(machine)?)
    }

    /// The limits of X, Y and Z, in mm and s, with this machine file.
    pub fn of(&self, file: &MachineAxes) -> Result<[AxisPace; 3], Failure> {
        for (name, count) in [
            ("--steps-per-rev", self.steps_per_rev.len()),
            ("--mm-per-rev", self.mm_per_rev.len()),
            ("--top-speed", self.top_speed.len()),
            ("--accel", self.accel.len()),
            ("--start-speed", self.start_speed.len()),
            ("--jerk", self.jerk.len()),
        ] {
            if ![0, 1, 3].contains(&count) {
                let what = format!("{name} has {count} values: one for all axes, or three");
                return Err(Failure::usage(what));
            }
        }
        let mut paces =
            [AxisPace { step: 1.0, speed: 1.0, accel: 1.0, jump: 1.0, jerk: f64::INFINITY }; 3];
        for ((n, pace), axis) in paces.iter_mut().enumerate().zip(AxisId::first(3)) {
            *pace = self.pace(n, axis, file)?;
        }
        Ok(paces)
    }

    fn pace(&self, n: usize, axis: AxisId, file: &MachineAxes) -> Result<AxisPace, Failure> {
        let name = NAMES.get(n).copied().unwrap_or("?");
        let steps = chosen(&self.steps_per_rev, n, file, axis, "steps_per_rev")?;
        let mm = chosen(&self.mm_per_rev, n, file, axis, "mm_per_rev")?;
        let geometry = GeometryArgs::new(Some(steps), Some(mm)).geometry()?;
        // The length of a step in mm.
        let step = mm.nm() as f64 / 1e6 / f64::from(steps);
        let speed = |typed: &[SpeedArg], id: &str, option: &str| {
            let speed: SpeedArg = chosen(typed, n, file, axis, id)?;
            let speed = speed.moving(&geometry, &format!("{option} of {name}"))?;
            Ok::<f64, Failure>(f64::from(speed.value.millisteps()) / 1e3 * step)
        };
        let top = speed(&self.top_speed, "top_speed", "--top-speed")?;
        // 0 means that the motor starts from rest. That is valid for an order, but not at a corner.
        let jump = speed(&self.start_speed, "start_speed", "--start-speed")?;
        let accel = match file.value(axis, "ramp") {
            Some(ramp) if self.accel.is_empty() => {
                let ramp: f64 = parsed(ramp)?;
                top * top / (2.0 * ramp * step)
            }
            _ => {
                let accel: AccelArg = chosen(&self.accel, n, file, axis, "accel")?;
                let accel = accel.resolve(&geometry, &format!("--accel of {name}"))?;
                accel.value.millisteps() as f64 / 1e3 * step
            }
        };
        // One limit for acceleration and deceleration: the lower one.
        let decel = file.value(axis, "decel").filter(|_| self.accel.is_empty());
        let decel = decel.map(parsed::<AccelArg>).transpose()?;
        let decel = decel.map(|decel| decel.resolve(&geometry, "decel")).transpose()?;
        let accel = decel.map_or(accel, |d| accel.min(d.value.millisteps() as f64 / 1e3 * step));
        let typed = self.jerk.get(n).or(self.jerk.first()).cloned();
        let known = file.value(axis, "jerk").map(parsed::<JerkArg>).transpose()?;
        let jerk = match typed.or(known).filter(|jerk| !jerk.is_zero()) {
            Some(jerk) => {
                let jerk = jerk.resolve(&geometry, &format!("--jerk of {name}"))?;
                jerk.value.millisteps() as f64 / 1e3 * step
            }
            None => f64::INFINITY,
        };
        Ok(AxisPace { step, speed: top, accel, jump, jerk })
    }
}

/// The value typed for axis `n`, else that of the machine file, else the usual one.
fn chosen<T: FromStr<Err: Display> + Clone>(
    typed: &[T],
    n: usize,
    file: &MachineAxes,
    axis: AxisId,
    id: &str,
) -> Result<T, Failure> {
    if let Some(typed) = typed.get(n).or(typed.first()) {
        return Ok(typed.clone());
    }
    let usual = USUAL.iter().find(|(known, _)| *known == id).map_or("", |(_, value)| value);
    parsed(file.value(axis, id).unwrap_or(usual))
}

fn parsed<T: FromStr<Err: Display>>(text: &str) -> Result<T, Failure> {
    text.parse().map_err(|why: T::Err| Failure::usage(why.to_string()))
}
