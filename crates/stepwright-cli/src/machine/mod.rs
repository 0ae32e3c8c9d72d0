//! The machine file: the properties of a machine's axes, so that they need not be typed each time.
//!
//! ```text
//!   stepwright.toml ──► file::Machine ──► defaults of the options ──► clap
//! ```
//!
//! The file changes the defaults of command-line options, and nothing else. An option that is typed
//! takes precedence, and a subcommand checks a default of the file as if it had been typed. The
//! command line is parsed twice, because the defaults depend on the subcommand and its `--axis`.

mod file;
pub mod init;

use std::env;
use std::ffi::OsString;
use std::mem;
use std::path::{Path, PathBuf};

use clap::parser::ValueSource;
use clap::{ArgMatches, Command};

use crate::failure::Failure;
use crate::order::law::LawArg;
use crate::quantity::{DistanceArg, GeometryArgs, MachineUnit, is_of_motor};
use crate::say;
use file::{About, Key, Values};
use stepwright_keeper::report::{MachineSheet, MachineValue};
use stepwright_protocol::AxisId;

/// The orders that look up the motor's properties for each axis themselves.
const EACH: [&str; 2] = ["line", "serve"];

/// The machine file in the current folder.
const HERE: &str = "stepwright.toml";
/// The name that stands for no file.
const NONE: &str = "none";
/// The environment variable that names the file, or none, if `--machine` is not given.
const VARIABLE: &str = "STEPWRIGHT_MACHINE";
/// The subcommands that order a board, or plan.
const ORDERS: [&str; 16] = [
    "move", "line", "run", "home", "jog", "retarget", "watch", "stop", "kill", "status",
    "position", "zero", "send", "settings", "plan", "serve",
];
/// The orders that an error in the file must not prevent.
const STOPS: [&str; 2] = ["stop", "kill"];

/// The option that names the machine file.
#[derive(clap::Args, Clone, Debug)]
pub struct MachineArgs {
    /// File with the port, units, speeds and ramps of the machine, or `none`
    /// [default: stepwright.toml here, or the user's own]
    #[arg(long, value_name = "FILE", global = true, help_heading = "Machine")]
    machine: Option<PathBuf>,
}

impl MachineArgs {
    /// The file, if there is one.
    fn path(&self) -> Option<PathBuf> {
        let named = self.machine.clone().or_else(|| env::var_os(VARIABLE).map(PathBuf::from));
        match named {
            Some(path) if path.as_os_str().is_empty() || path == Path::new(NONE) => None,
            Some(path) => Some(path),
            None => [Some(PathBuf::from(HERE)), of_user()]
                .into_iter()
                .flatten()
                .find(|path| path.is_file()),
        }
    }
}

/// The path of the machine file in the user's settings folder.
fn of_user() -> Option<PathBuf> {
    let folder = match env::var_os(if cfg!(windows) { "APPDATA" } else { "XDG_CONFIG_HOME" }) {
        Some(folder) if !folder.is_empty() => PathBuf::from(folder),
        _ => env::home_dir()?.join(".config"),
    };
    Some(folder.join("stepwright").join("machine.toml"))
}

/// The typed options, with the machine's defaults for the others. `machine` is the option from the
/// first parse of the command line.
///
/// An error in the file must not prevent a stop: `stop` and `kill` use the values that can be read,
/// and report the error.
pub fn read(
    command: impl Fn() -> Command,
    words: &[OsString],
    first: ArgMatches,
    machine: &MachineArgs,
) -> Result<ArgMatches, Failure> {
    let (path, typed) = deepest(&first);
    let Some(order) = path.first().filter(|name| ORDERS.contains(&name.as_str())) else {
        return Ok(first);
    };
    let Some(from) = machine.path() else { return Ok(first) };
    let stops = STOPS.contains(&order.as_str());
    let or = |values: Result<Values, Failure>, rest: Values| match values {
        Err(failure) if stops => {
            say::note(format_args!("machine: {}", failure.message()));
            Ok(rest)
        }
        values => values,
    };
    let values =
        file::text(&from).and_then(|text| or(values(&text, &from, typed), file::readable(&text)));
    let values = or(values, Vec::new())?;
    let mut command = command();
    let below = path.iter().try_fold(&mut command, |above, name| above.find_subcommand_mut(name));
    let Some(below) = below else { return Ok(first) };
    let has = |id: &str| below.get_arguments().any(|option| option.get_id() == id);
    let one_motor = has("steps_per_rev") && !has("axis") && !EACH.contains(&order.as_str());
    if one_motor && typed.value_source("steps_per_rev") != Some(ValueSource::CommandLine) {
        built_alike(&from, words)?;
    }
    let defaults = defaults(values, order, typed, below);
    let each = EACH.contains(&order.as_str()) && !alike(&from)?;
    if defaults.is_empty() && !each {
        return Ok(first);
    }
    say::note(format_args!("machine: {}", from.display()));
    // Only existing options can be given a default this way.
    *below = mem::take(below).mut_args(|option| {
        match defaults.iter().find(|(id, _)| option.get_id() == id) {
            Some((_, value)) => option.default_value(value.clone()),
            None => option,
        }
    });
    // A `stop` or `kill` ignores defaults that do not fit.
    command.try_get_matches_from(words).or_else(|error| match stops {
        true => Ok(first),
        false => {
            Err(Failure::usage(format!("{} does not fit this command: {error}", from.display())))
        }
    })
}

/// The file's values for the typed axis, or those that its axes have in common.
fn values(text: &str, from: &Path, typed: &ArgMatches) -> Result<Values, Failure> {
    let machine = file::parse(text, from)?;
    let axis = match typed.try_get_one::<AxisId>("axis") {
        Ok(Some(axis)) => machine.axis(*axis),
        _ => machine.common(),
    };
    Ok(machine.board().into_iter().chain(axis).collect())
}

/// Whether a turn of every axis of the file has the same steps and millimetres.
fn alike(from: &Path) -> Result<bool, Failure> {
    Ok(file::parse(&file::text(from)?, from)?.built_alike())
}

/// Checks that a turn of every axis of the file has the same steps and millimetres, if a typed
/// number needs that.
fn built_alike(from: &Path, words: &[OsString]) -> Result<(), Failure> {
    match words.iter().find(|word| is_of_motor(word)) {
        Some(word) if !alike(from)? => {
            let (word, from) = (word.display(), from.display());
            let what = format!("{word}: a turn of the axes in {from} differs in steps or mm");
            Err(Failure::usage(what).hint(
                "give --steps-per-rev, and --mm-per-rev for millimetres, of the axis that is meant; \
                 or steps",
            ))
        }
        _ => Ok(()),
    }
}

/// The content of the machine file, to show beside a board.
pub fn shown(machine: &MachineArgs) -> Result<Option<MachineSheet>, Failure> {
    let Some(from) = machine.path() else { return Ok(None) };
    let machine = file::parse(&file::text(&from)?, &from)?;
    let value = |axis: Option<AxisId>, (key, value): (&'static Key, String)| MachineValue {
        axis: axis.map(AxisId::number),
        name: key.name,
        value,
    };
    let board = machine.board().into_iter().map(|one| value(None, one));
    let axes = machine.axes().iter();
    let axes =
        axes.flat_map(|(axis, values)| values.iter().map(|one| value(Some(*axis), one.clone())));
    let values = board.chain(axes).collect();
    Ok(Some(MachineSheet { file: from.display().to_string(), values }))
}

/// The units of the axes in the machine file.
pub fn units(machine: &MachineArgs) -> Result<Vec<(AxisId, MachineUnit)>, Failure> {
    let Some(from) = machine.path() else { return Ok(Vec::new()) };
    let machine = file::parse(&file::text(&from)?, &from)?;
    let unit = |(axis, values): &(AxisId, Values)| Some((*axis, built(values).unit()?));
    Ok(machine.axes().iter().filter_map(unit).collect())
}

/// The greatest distance to the limit switch of each axis, in steps, if the machine file has it.
/// Typed motor properties take precedence over the file.
pub fn home_within(
    machine: &MachineArgs,
    typed: &GeometryArgs,
) -> Result<Vec<(AxisId, u32)>, Failure> {
    let Some(from) = machine.path() else { return Ok(Vec::new()) };
    let machine = file::parse(&file::text(&from)?, &from)?;
    let mut all = Vec::new();
    for (axis, values) in machine.axes() {
        let Some(text) = value(values, "within") else { continue };
        let name = format!("home-within of axis {} in {}", axis.number(), from.display());
        let within: DistanceArg = text.parse().map_err(Failure::usage)?;
        let steps = within.resolve(&typed.or(&built(values)).geometry()?, &name)?.value;
        let far = u32::try_from(steps).ok().filter(|steps| (1..=i32::MAX as u32).contains(steps));
        all.push((
            *axis,
            far.ok_or_else(|| {
                let most = i32::MAX;
                Failure::new(format!("{name} is {steps} steps: 1 to {most}"))
                    .hint("give a little more than the axis can travel")
            })?,
        ));
    }
    Ok(all)
}

/// The machine file's values for each axis, for a command that moves several axes with separate
/// limits.
pub struct MachineAxes(Vec<(AxisId, Values)>);

impl MachineAxes {
    /// Reads the file, and prints a note that it is used. Empty without a file.
    pub fn read(machine: &MachineArgs) -> Result<MachineAxes, Failure> {
        let axes = MachineAxes::quiet(machine)?;
        if let Some(from) = machine.path().filter(|_| !axes.0.is_empty()) {
            say::note(format_args!("machine: {}", from.display()));
        }
        Ok(axes)
    }

    /// Reads the file without a note.
    pub fn quiet(machine: &MachineArgs) -> Result<MachineAxes, Failure> {
        let Some(from) = machine.path() else { return Ok(MachineAxes(Vec::new())) };
        let machine = file::parse(&file::text(&from)?, &from)?;
        Ok(MachineAxes(machine.axes().to_vec()))
    }

    /// The values without a file.
    #[cfg(test)]
    pub fn none() -> MachineAxes {
        MachineAxes(Vec::new())
    }

    /// The motor properties of an axis: as typed, else as in the file.
    pub fn geometry(&self, axis: AxisId, typed: &GeometryArgs) -> GeometryArgs {
        match self.0.iter().find(|(known, _)| *known == axis) {
            Some((_, values)) => typed.or(&built(values)),
            None => typed.clone(),
        }
    }

    /// The value of an option of an axis, as in the file.
    pub fn value(&self, axis: AxisId, id: &str) -> Option<&str> {
        let (_, values) = self.0.iter().find(|(known, _)| *known == axis)?;
        value(values, id)
    }
}

/// The value of an option.
fn value<'a>(values: &'a Values, id: &str) -> Option<&'a str> {
    values.iter().find(|(key, _)| key.id == id).map(|(_, text)| text.as_str())
}

/// The motor properties of an axis with these values.
fn built(values: &Values) -> GeometryArgs {
    let steps = value(values, "steps_per_rev").and_then(|text| text.parse().ok());
    GeometryArgs::new(steps, value(values, "mm_per_rev").and_then(|text| text.parse().ok()))
}

/// The names of the typed subcommand from the outermost, and its options.
fn deepest(matches: &ArgMatches) -> (Vec<String>, &ArgMatches) {
    let (mut path, mut deepest) = (Vec::new(), matches);
    while let Some((name, below)) = deepest.subcommand() {
        path.push(name.to_owned());
        deepest = below;
    }
    (path, deepest)
}

/// The options of this subcommand for which the machine has another default, by id. `order` is the
/// outermost subcommand.
fn defaults(
    values: Values,
    order: &str,
    typed: &ArgMatches,
    subcommand: &Command,
) -> Vec<(&'static str, String)> {
    // Uses the definition, because `ArgMatches` does not know the names of options in a release
    // build.
    let has = |id: &str| subcommand.get_arguments().any(|option| option.get_id() == id);
    let is_typed = |id: &str| has(id) && typed.value_source(id) == Some(ValueSource::CommandLine);
    // An option that only a virtual board has selects one.
    let own = ["virtual", "fast", "vcd", "mcap", "plot", "switch", "drive"];
    let virtual_board = own.into_iter().any(is_typed);
    // If `ramp` or `accel` is typed, no part of the ramp is taken from the file.
    let ramp_typed = ["ramp", "accel"].into_iter().any(is_typed);
    // Austin's laws begin at rest, by an acceleration.
    let law = typed.try_get_one::<LawArg>("law").ok().flatten();
    let is_austin = law.is_some_and(|law| law.is_austin());
    let wanted = |name: &str, about: About| match about {
        // A detached motor has no lease, because nobody would renew it.
        About::Board if name == "lease" && is_typed("detach") => false,
        About::Board => !virtual_board,
        About::Units => true,
        About::Motion if is_austin && ["start-speed", "ramp", "jerk"].contains(&name) => false,
        About::Motion if ramp_typed && ["ramp", "accel", "decel"].contains(&name) => false,
        About::Motion => ["move", "line", "run", "home", "jog"].contains(&order),
        About::Homing => order == "home",
    };
    values
        .into_iter()
        .filter(|(key, _)| has(key.id) && wanted(key.name, key.about))
        .map(|(key, text)| (key.id, text))
        .collect()
}
