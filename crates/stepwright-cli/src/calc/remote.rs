//! The calculators for pages and programs, with the same arguments as on the command line.

use clap::{Arg, ArgMatches, Args as _, Command, FromArgMatches};
use stepwright_keeper::Declined;
use stepwright_serve::calc::{CalcAnswer, CalcFact, CalcOption, CalculatorSheet, Calculators};

use super::Args;
use crate::failure::Failure;
use stepwright_plan::sheet::Sheet;

/// Options that a page does not get: how the result is printed, and files, which would be the
/// server's.
const OUTPUT: [&str; 2] = ["format", FILES];
const FILES: &str = "plot";

/// All calculators.
pub fn calculators() -> Calculators {
    Calculators { sheets: command().get_subcommands().map(sheet).collect(), answer }
}

fn command() -> Command {
    let mut command =
        Args::augment_args(Command::new("calc").no_binary_name(true).disable_help_subcommand(true));
    command.build();
    command
}

fn sheet(command: &Command) -> CalculatorSheet {
    let about = command.get_about().map(ToString::to_string).unwrap_or_default();
    let wanted = |arg: &&Arg| {
        let id = arg.get_id().as_str();
        !OUTPUT.contains(&id) && !["help", "version"].contains(&id)
    };
    let options = command.get_arguments().filter(wanted).map(option).collect();
    CalculatorSheet { name: command.get_name().to_owned(), about, options }
}

fn option(arg: &Arg) -> CalcOption {
    let bare = arg.is_positional();
    let name = match arg.get_long() {
        Some(long) => format!("--{long}"),
        None => arg
            .get_value_names()
            .and_then(|names| names.first())
            .map_or_else(|| arg.get_id().to_string(), ToString::to_string),
    };
    let takes_value = arg.get_action().takes_values();
    let defaults: Vec<_> = arg.get_default_values().iter().map(|v| v.to_string_lossy()).collect();
    let choices = arg.get_possible_values().into_iter().map(|one| one.get_name().to_owned());
    CalcOption {
        name,
        bare,
        takes_value,
        help: arg.get_help().map(ToString::to_string).unwrap_or_default(),
        default: (takes_value && !defaults.is_empty()).then(|| defaults.join(",")),
        required: arg.is_required_set(),
        choices: if takes_value { choices.collect() } else { Vec::new() },
    }
}

/// Computes the answer to the arguments after `stepwright calc`.
fn answer(words: &[String]) -> Result<CalcAnswer, Declined> {
    let computed = || -> Result<Sheet, Failure> {
        let matches = command().try_get_matches_from(words)?;
        let writes = |given: &ArgMatches| given.try_contains_id(FILES).unwrap_or(false);
        if matches.subcommand().is_some_and(|(_, given)| writes(given)) {
            let what = format!("--{FILES} writes a file, which only the command itself does");
            return Err(Failure::new(what).hint("leave it out"));
        }
        Args::from_arg_matches(&matches)?.chosen().0.sheet()
    };
    computed().map(told).map_err(|failure| {
        let declined = Declined::range(failure.message());
        match failure.hinted().filter(|hint| !hint.is_empty()) {
            Some(hint) => declined.remedy(hint),
            None => declined,
        }
    })
}

fn told(sheet: Sheet) -> CalcAnswer {
    let facts = sheet.facts.iter().map(|fact| CalcFact {
        name: fact.name.to_owned(),
        value: fact.value.shown(),
        unit: fact.unit.to_owned(),
    });
    CalcAnswer {
        facts: facts.collect(),
        columns: sheet.columns.iter().map(|(_, name)| (*name).to_owned()).collect(),
        rows: sheet.rows.iter().map(|row| row.iter().map(|cell| cell.shown()).collect()).collect(),
        title: sheet.title,
        notes: sheet.notes,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(line: &str) -> Result<CalcAnswer, Declined> {
        answer(&line.split_whitespace().map(str::to_owned).collect::<Vec<_>>())
    }

    #[test]
    fn a_page_gets_what_the_command_prints() {
        let belt = said("belt --teeth 20").unwrap();
        let travel = &belt.facts[0];
        assert_eq!((travel.value.as_str(), travel.unit.as_str()), ("40", "mm"));
        assert_eq!((belt.rows.len(), belt.rows[0].len()), (6, belt.columns.len()));
        // 16 MHz / 180 = 88888.9: too much for 16 bits; divided by 8, it fits.
        let timer = said("timer 180").unwrap();
        assert!(timer.facts.iter().any(|fact| fact.value == "88888"), "{timer:?}");
    }

    #[test]
    fn what_makes_no_sense_says_why() {
        for (line, what) in [
            ("", "Calculate timers"),
            ("belt", "required arguments"),
            ("belt --teeth 0", "a whole number from 1 to 10000"),
            ("belt --teeth 20 --microsteps 1,x", "invalid value"),
            ("nothing", "unrecognized subcommand"),
            ("--help", ""),
        ] {
            let declined = said(line).unwrap_err();
            assert!(
                declined.what.contains(what) && declined.status() == 422,
                "{line}: {declined:?}"
            );
        }
    }

    /// Anyone who reaches the server may calculate.
    #[test]
    fn no_file_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("curve.svg");
        for plot in [format!("--plot {}", file.display()), format!("--plot={}", file.display())] {
            let declined = said(&format!("timed 6 800 --updates 3 {plot}")).unwrap_err();
            assert!(declined.what.contains("--plot writes a file"), "{declined:?}");
            assert_eq!(declined.status(), 422);
        }
        assert!(!file.exists());
    }

    #[test]
    fn all_that_can_be_given_is_listed() {
        let sheets = calculators().sheets;
        let names: Vec<_> = sheets.iter().map(|sheet| sheet.name.as_str()).collect();
        let all: Vec<_> = sheets.iter().flat_map(|sheet| &sheet.options).collect();
        assert!(all.iter().all(|one| !["--format", "--plot"].contains(&one.name.as_str())));
        for name in ["timer", "timed", "range", "belt", "screw", "delay", "vref", "microstep"] {
            assert!(names.contains(&name), "{names:?}");
        }
        assert!(!names.contains(&"help"));
        let belt = sheets.iter().find(|sheet| sheet.name == "belt").unwrap();
        let option = |name: &str| belt.options.iter().find(|one| one.name == name).unwrap();
        assert!(option("--teeth").required && option("--teeth").default.is_none());
        assert_eq!(option("--pitch").default.as_deref(), Some("2mm"));
        assert!(belt.options.iter().all(|one| !one.help.is_empty() && one.name != "--format"));
        let vref = sheets.iter().find(|sheet| sheet.name == "vref").unwrap();
        assert!(vref.options.iter().any(|one| one.bare && one.name == "CURRENT"));
        assert!(vref.options.iter().any(|one| one.choices.contains(&"a4988".to_owned())));
    }
}
