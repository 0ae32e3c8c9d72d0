//! `stepwright init`: asks for the properties of a machine, and writes the machine file.

use std::io::{self, BufRead, IsTerminal, Write};
use std::path::{Path, PathBuf};

use stepwright_protocol::AxisId;
use toml_edit::{DocumentMut, Item, Table, TableLike, value};

use super::HERE;
use super::file;
use crate::failure::{Failure, unless_closed};
use crate::order::target;
use crate::{files, say};

/// Write a file with the port, units, speeds and ramps of a machine
///
/// Asks for each value that is not given as an option; an empty answer leaves a key out. `move`,
/// `run`, `line`, `home` and the others use the file's values for options that are not given.
#[derive(clap::Args)]
#[command(after_help = "\
An existing file keeps its other axes, keys and comments. Commands use the file of --machine,
else that of the variable STEPWRIGHT_MACHINE, else stepwright.toml in the current folder, else
~/.config/stepwright/machine.toml (%APPDATA% on Windows).

A file with all keys:
  port = \"/dev/ttyUSB0\"       every command goes to this board
  baud = 115200
  lease = \"2s\"                the board brakes when the command is silent for this time

  [axis.1]
  steps-per-rev = 3200        full steps of a turn times microsteps
  mm-per-rev = 8              a turn moves the load by this many millimetres
  start-speed = \"1mm/s\"
  top-speed = \"40mm/s\"
  accel = \"200mm/s2\"          or ramp = 400, in steps
  decel = \"100mm/s2\"
  jerk = \"2000mm/s3\"
  home-speed = \"10mm/s\"
  home-slow = \"1mm/s\"
  home-back-off = \"2mm\"
  home-within = \"300mm\"

Examples:
  stepwright init
  stepwright init --axis 2
  stepwright init --port /dev/ttyUSB0 --steps-per-rev 3200 --mm-per-rev 8 \\
      --top-speed 40mm/s --accel 200mm/s2")]
pub struct Args {
    /// File to write
    #[arg(long, value_name = "FILE", default_value = HERE)]
    file: PathBuf,
    /// The axis, 1 to 8
    #[arg(long, value_name = "N", default_value = "1", value_parser = target::axis)]
    axis: AxisId,
    /// Serial port of the board
    #[arg(long, value_name = "PATH")]
    port: Option<String>,
    /// Steps of one turn, microsteps included
    #[arg(long, value_name = "N")]
    steps_per_rev: Option<String>,
    /// Millimetres that the load travels in one turn
    #[arg(long, value_name = "MM")]
    mm_per_rev: Option<String>,
    /// Speed between the ramps
    #[arg(long, value_name = "SPEED")]
    top_speed: Option<String>,
    /// Acceleration of the ramp up
    #[arg(long, value_name = "ACCEL")]
    accel: Option<String>,
}

/// Asks, writes the file, and prints what to do next.
pub fn run(args: Args) -> Result<(), Failure> {
    let before = match args.file.try_exists() {
        Ok(true) => file::text(&args.file)?,
        _ => String::new(),
    };
    // An existing file must be valid before anything is asked.
    file::parse(&before, &args.file)?;
    let mut file: DocumentMut = before
        .parse()
        .map_err(|error| Failure::new(format!("{}: {error}", args.file.display())))?;
    let number = args.axis.number();
    let mut asked = Asked { any: args.is_complete(), file: &args.file };
    let port = asked.answer(&args.port, "Serial port of the board (empty: a virtual board)")?;
    set(file.as_table_mut(), "port", port);
    let questions = [
        ("steps-per-rev", &args.steps_per_rev, "Steps of one turn, microsteps included [200]"),
        ("mm-per-rev", &args.mm_per_rev, "Millimetres of one turn (empty: nothing moves along)"),
        ("top-speed", &args.top_speed, "Top speed, like 1000, 300rpm or 40mm/s [1000]"),
        ("accel", &args.accel, "Acceleration, like 4000 or 200mm/s2 (empty: by the top speed)"),
    ];
    for (key, typed, question) in questions {
        loop {
            let answer = asked.answer(typed, &format!("Axis {number}: {question}"))?;
            if let Some(doubt) =
                answer.as_deref().and_then(|answer| bare(&file, number, key, answer))
            {
                match asked.any {
                    true => return Err(Failure::usage(format!("--{key} {doubt}"))),
                    false => say::note(format_args!("{key} {doubt}")),
                }
                continue;
            }
            let mut tried = file.clone();
            if let Some(axis) = axis_of(&mut tried, number) {
                set(axis, key, answer);
            }
            match file::parse(&tried.to_string(), &args.file) {
                Ok(_) => {
                    file = tried;
                    break;
                }
                Err(failure) if asked.any => return Err(wrong(key, failure)),
                Err(failure) => say::note(failure.message()),
            }
        }
    }
    files::replace(&args.file, file.to_string().as_bytes())?;
    say::result(format_args!("{} has axis {number}", args.file.display()));
    say::note(format_args!("try it: `stepwright move 360deg --axis {number} --virtual`"));
    Ok(())
}

/// The failure text for a number without a unit, on an axis that has millimetres.
fn bare(file: &DocumentMut, axis: u8, key: &str, answer: &str) -> Option<String> {
    let unit = match key {
        "top-speed" => "s",
        "accel" => "s2",
        _ => return None,
    };
    answer.parse::<f64>().ok()?;
    file.get("axis")?.get(axis.to_string())?.get("mm-per-rev")?;
    Some(format!(
        "{answer}: mm/{unit} or steps/{unit}? write {answer}mm/{unit}, or {answer}steps/{unit}"
    ))
}

/// The failure for an option whose value no file has yet.
fn wrong(key: &str, failure: Failure) -> Failure {
    let why = failure.place().and_then(|place| place.what.strip_prefix(&format!("{key} = ")));
    match why {
        Some(why) => Failure::usage(format!("--{key} {why}")),
        None => failure,
    }
}

impl Args {
    /// Whether anything was given: then nothing is asked.
    fn is_complete(&self) -> bool {
        let given =
            [&self.port, &self.steps_per_rev, &self.mm_per_rev, &self.top_speed, &self.accel];
        given.iter().any(|option| option.is_some())
    }
}

/// The questions.
struct Asked<'a> {
    /// Whether options were given instead of answers.
    any: bool,
    file: &'a Path,
}

impl Asked<'_> {
    /// The answer; `None` if it is empty.
    fn answer(
        &mut self,
        typed: &Option<String>,
        question: &str,
    ) -> Result<Option<String>, Failure> {
        if self.any {
            return Ok(typed.clone());
        }
        unless_closed(write!(io::stderr(), "{question}: ").and_then(|()| io::stderr().flush()))?;
        let mut line = String::new();
        let read = io::stdin().lock().read_line(&mut line);
        if !line.ends_with('\n') || !io::stdin().is_terminal() {
            // No Enter key has ended the line of the question.
            say::note("");
        }
        match read {
            Ok(0) => Err(Failure::new(format!("no more answers: {} stays", self.file.display()))
                .hint("give them as options: `stepwright init --help`")),
            Ok(_) => Ok(Some(line.trim().to_owned()).filter(|line| !line.is_empty())),
            Err(error) => Err(Failure::new(format!("can't read the answer: {error}"))),
        }
    }
}

/// The table of an axis, `[axis.1]` or inline; created if it is missing. `None` if the key holds
/// anything else.
fn axis_of(file: &mut DocumentMut, number: u8) -> Option<&mut dyn TableLike> {
    let axes = file.entry("axis").or_insert_with(|| {
        let mut table = Table::new();
        table.set_implicit(true);
        Item::Table(table)
    });
    let axes = axes.as_table_like_mut()?;
    axes.entry(&number.to_string()).or_insert(Item::Table(Table::new())).as_table_like_mut()
}

/// Sets a key, as a number if the answer is one. Does nothing without an answer.
fn set(table: &mut dyn TableLike, key: &str, answer: Option<String>) {
    let Some(answer) = answer else { return };
    let item = match (answer.parse::<i64>(), answer.parse::<f64>()) {
        (Ok(whole), _) => value(whole),
        (_, Ok(number)) if number.is_finite() => value(number),
        _ => value(answer),
    };
    table.insert(key, item);
}
