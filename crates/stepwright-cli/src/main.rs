//! The `stepwright` command: plan, move and watch stepper motors.
//!
//! Each subcommand is a module with `Args` (for clap) and `run(args) -> Result<(), Failure>`. To
//! add one, write the module and name it in [`Command`]. Shared modules:
//!
//! | module | what |
//! | --- | --- |
//! | [`apart`] | checks that the files of a command line differ |
//! | [`change`] | changes of a travel by another program |
//! | [`failure`] | errors, hints and the exit status |
//! | [`files`] | text files, with a size limit and replaced as a whole |
//! | [`interrupt`] | Ctrl-C and other signals |
//! | [`machine`] | the machine file: other defaults for the options |
//! | [`plot`] | writes figures into files |
//! | [`programs`] | the programs for boards |
//! | `pty` | a serial port for other programs |
//! | [`quantity`] | units: steps, turns, millimetres |
//! | [`say`] | lines on standard output and error |

mod apart;
mod board;
mod calc;
mod completions;
mod cycle;
mod failure;
mod figures;
mod files;
mod flash;
mod gcode;
mod grbl;
mod help;
mod interrupt;
mod machine;
mod order;
mod plan;
mod plot;
mod programs;
#[cfg(unix)]
mod pty;
mod quantity;
mod say;
mod selftest;
mod serve;
mod timed;

use std::mem;
use std::process::ExitCode;

use clap::error::{ContextKind, ContextValue};
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use failure::{Failure, unless_closed};

/// Real-time motion for stepper motors
#[derive(Parser)]
#[command(name = "stepwright", version, max_term_width = 100)]
#[command(after_help = "\
Begin without any hardware:
  stepwright move 4000              a virtual motor moves, and you see how
  stepwright board --pty            a virtual board behind a serial port of its own
                                    (not on Windows; `stepwright serve` is a page)

Then with a board:
  stepwright ports                  list the ports
  stepwright move 4000 --port PATH  /dev/ttyUSB0, or COM3 on Windows

Exit status:
  0    done
  1    refused by the board, a file or a calculation, or it failed
  2    invalid command line, whatever the board: an option, a number out of its
       range, a unit; nothing was touched
  130  ended by Ctrl-C or another signal before it was done
Errors begin with `error: `, and ` hint: ` says what to do; with --format json the last line on
standard error is both as JSON.")]
struct Cli {
    #[command(flatten)]
    machine: machine::MachineArgs,
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Move(order::travel::Args),
    Line(order::line::Args),
    Run(order::run::Args),
    Home(order::home::Args),
    Jog(order::jog::Args),
    Retarget(order::retarget::Args),
    Watch(order::watch::Args),
    Stop(order::stop::StopArgs),
    Kill(order::stop::KillArgs),
    Status(order::look::StatusArgs),
    Position(order::look::PositionArgs),
    Zero(order::look::ZeroArgs),
    Send(order::send::Args),
    Settings(order::settings::Args),
    Ports(order::ports::Args),
    Init(machine::init::Args),
    Serve(serve::Args),
    Board(board::Args),
    Flash(flash::Args),
    Selftest(selftest::Args),
    Plan(Box<plan::Args>),
    Timed(Box<timed::Args>),
    Cycle(cycle::Args),
    Gcode(Box<gcode::Args>),
    Grbl(grbl::Args),
    Figures(figures::Args),
    Calc(Box<calc::Args>),
    Completions(completions::Args),
}

fn main() -> ExitCode {
    interrupt::stay_awake();
    let cli = match read() {
        Ok(cli) => cli,
        Err(Unread::Failure(failure)) => return failure.report(),
        // Also for help and the version: printing them may fail.
        Err(Unread::Clap(mut said)) => {
            as_typed(&mut said);
            if said.use_stderr() && failure::is_json() {
                return Failure::from(said).report();
            }
            let printed = said.print();
            if said.use_stderr() {
                return ExitCode::from(said.exit_code() as u8);
            }
            return unless_closed(printed).map_or_else(|f| f.report(), |()| ExitCode::SUCCESS);
        }
    };
    let result = match cli.command {
        Command::Move(args) => order::travel::run(args),
        Command::Line(args) => order::line::run(args, &cli.machine),
        Command::Run(args) => order::run::run(args),
        Command::Home(args) => order::home::run(args),
        Command::Jog(args) => order::jog::run(args),
        Command::Retarget(args) => order::retarget::run(args),
        Command::Watch(args) => order::watch::run(args),
        Command::Stop(args) => order::stop::stop(args),
        Command::Kill(args) => order::stop::kill(args),
        Command::Status(args) => order::look::status(args, &cli.machine),
        Command::Position(args) => order::look::position(args),
        Command::Zero(args) => order::look::zero(args),
        Command::Send(args) => order::send::run(args),
        Command::Settings(args) => order::settings::run(args),
        Command::Ports(args) => order::ports::run(args),
        Command::Init(args) => machine::init::run(args),
        Command::Serve(args) => serve::run(args, &cli.machine),
        Command::Board(args) => board::run(args),
        Command::Flash(args) => flash::run(args),
        Command::Selftest(args) => selftest::run(args),
        Command::Plan(args) => plan::run(*args),
        Command::Timed(args) => timed::run(*args),
        Command::Cycle(args) => cycle::run(args),
        Command::Gcode(args) => gcode::run(*args, &cli.machine),
        Command::Grbl(args) => grbl::run(args),
        Command::Figures(args) => figures::run(args),
        Command::Calc(args) => calc::run(*args),
        Command::Completions(args) => completions::run(args),
    };
    match result {
        Ok(()) if say::lost() => ExitCode::FAILURE,
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}

/// Why no command is run.
enum Unread {
    Clap(clap::Error),
    Failure(Failure),
}

/// The command line. Every value may be a negative number: the parser of its option says what is allowed.
fn command() -> clap::Command {
    with_negatives(Cli::command())
}

fn with_negatives(command: clap::Command) -> clap::Command {
    let mut command = command.mut_args(|arg| match arg.get_action().takes_values() {
        true => arg.allow_negative_numbers(true),
        false => arg,
    });
    for below in command.get_subcommands_mut() {
        *below = with_negatives(mem::take(below));
    }
    command
}

/// Shows a value with the hyphen that was typed, which [`quantity::words`] has replaced.
fn as_typed(said: &mut clap::Error) {
    if let Some(ContextValue::String(value)) = said.get(ContextKind::InvalidValue) {
        let typed = ContextValue::String(value.replace('\u{2212}', "-"));
        said.insert(ContextKind::InvalidValue, typed);
    }
}

/// Parses the command line, with the machine's defaults for options that are not given.
fn read() -> Result<Cli, Unread> {
    let words = quantity::words(std::env::args_os());
    if words.windows(2).any(|pair| pair[0] == "--format" && pair[1] == "json")
        || words.iter().any(|word| word == "--format=json")
    {
        failure::say_json();
    }
    let typed = help::grouped(command()).try_get_matches_from(&words).map_err(Unread::Clap)?;
    let machine = machine::MachineArgs::from_arg_matches(&typed).map_err(Unread::Clap)?;
    let all = machine::read(command, &words, typed, &machine).map_err(Unread::Failure)?;
    let cli = Cli::from_arg_matches(&all).map_err(Unread::Clap)?;
    apart::apart(&all).map_err(Unread::Failure)?;
    Ok(cli)
}
