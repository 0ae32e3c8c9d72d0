//! The machine file: how a machine's axes are built, so that nobody types it twice.
//!
//! ```text
//!   stepwright.toml ──► file::Machine ──► defaults of the options ──► clap
//! ```
//!
//! The file gives options of the command line other defaults, and nothing else: an option
//! that is typed wins, and whatever a subcommand checks, it checks as if it had been typed.
//! The command line is read twice, because the defaults depend on the subcommand and its
//! `--axis`.

mod file;
pub mod init;

use std::env;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::parser::ValueSource;
use clap::{ArgMatches, Command};

use crate::failure::Failure;
use crate::{files, say};
use file::{About, Key, Machine, Values};
use stepwright_protocol::AxisId;
use stepwright_serve::report::{MachineSheet, MachineValue};

/// The file that is found where the command is run.
const HERE: &str = "stepwright.toml";
/// Instead of a file: none.
const NONE: &str = "none";
/// Names the file, or none, where `--machine` doesn't.
const VARIABLE: &str = "STEPWRIGHT_MACHINE";
/// A machine file has this many bytes at most.
const MOST: usize = 100_000;

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

/// Where a user keeps settings.
fn of_user() -> Option<PathBuf> {
    let folder = match env::var_os(if cfg!(windows) { "APPDATA" } else { "XDG_CONFIG_HOME" }) {
        Some(folder) if !folder.is_empty() => PathBuf::from(folder),
        _ => env::home_dir()?.join(".config"),
    };
    Some(folder.join("stepwright").join("machine.toml"))
}

/// What was typed, with the machine's defaults for what wasn't. `machine` is the option
/// as the first reading of the command line has it.
pub fn read(
    command: impl Fn() -> Command,
    words: &[OsString],
    first: ArgMatches,
    machine: &MachineArgs,
) -> Result<ArgMatches, Failure> {
    let (path, typed) = deepest(&first);
    if !takes_defaults(&path) {
        return Ok(first);
    }
    let Some(from) = machine.path() else { return Ok(first) };
    let machine = Machine::parse(&files::read(&from, MOST)?, &from)?;
    let axis = match typed.try_get_one::<AxisId>("axis") {
        Ok(Some(axis)) => machine.axis(*axis),
        _ => machine.common(),
    };
    let defaults = defaults(machine.board().into_iter().chain(axis).collect(), &path, typed);
    if defaults.is_empty() {
        return Ok(first);
    }
    say::note(format_args!("machine: {}", from.display()));
    let command = with(command(), &path, &defaults);
    // What is wrong with a default, the file has been told.
    command.try_get_matches_from(words).map_err(|error| {
        Failure::usage(format!("{} does not fit this command: {error}", from.display()))
    })
}

/// What stands in the machine file, for people who look at a board.
pub fn shown(machine: &MachineArgs) -> Result<Option<MachineSheet>, Failure> {
    let Some(from) = machine.path() else { return Ok(None) };
    let machine = Machine::parse(&files::read(&from, MOST)?, &from)?;
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

/// The subcommand that was typed, by its names from the outermost, and its options.
fn deepest(matches: &ArgMatches) -> (Vec<String>, &ArgMatches) {
    let (mut path, mut deepest) = (Vec::new(), matches);
    while let Some((name, below)) = deepest.subcommand() {
        path.push(name.to_owned());
        deepest = below;
    }
    (path, deepest)
}

/// Whether a subcommand orders a board, or plans.
fn takes_defaults(path: &[String]) -> bool {
    let first = path.first().map(String::as_str);
    const ORDERS: [&str; 16] = [
        "move", "line", "run", "home", "jog", "retarget", "watch", "stop", "kill", "status",
        "position", "zero", "send", "settings", "plan", "serve",
    ];
    first.is_some_and(|name| ORDERS.contains(&name))
}

/// The options, by id, that the machine gives another default.
fn defaults(values: Values, path: &[String], typed: &ArgMatches) -> Vec<(&'static str, String)> {
    let has = |id: &str| typed.try_contains_id(id).is_ok();
    let is_typed = |id: &str| has(id) && typed.value_source(id) == Some(ValueSource::CommandLine);
    // What only a virtual board has is asked of one.
    let own = ["virtual", "fast", "vcd", "mcap", "plot", "switch", "drive"];
    let virtual_board = own.into_iter().any(is_typed);
    // A ramp is one thing: the file's is another one than the one that was typed.
    let ramp_typed = ["ramp", "accel"].into_iter().any(is_typed);
    let order = path.first().map_or("", String::as_str);
    let wanted = |name: &str, about: About| match about {
        About::Board => !virtual_board,
        About::Units => true,
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

/// The command with these defaults for its subcommand.
fn with(command: Command, path: &[String], defaults: &[(&'static str, String)]) -> Command {
    match path.split_first() {
        Some((name, rest)) => command.mut_subcommand(name, |below| with(below, rest, defaults)),
        None => defaults.iter().fold(command, |command, (id, value)| {
            command.mut_arg(id, |arg| arg.default_value(value.clone()))
        }),
    }
}
