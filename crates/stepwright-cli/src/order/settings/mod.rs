//! `stepwright settings`: the values that outlast a loss of a board's power.

mod file;
mod words;

use std::path::{Path, PathBuf};

use clap::Subcommand;
use serde_json::{Map, json};
use stepwright_protocol::{Command, Listed, Refusal, Reply, Setting, Settings, Value};

use super::target::{self, Format, PortArgs};
use crate::failure::{Failure, unless_closed};
use crate::files;
use crate::say;
use stepwright_host::Session;
use stepwright_host::link::serial::Share;

/// The largest size of a settings file in bytes. One with all settings and their meanings has some
/// two thousand.
const MOST: usize = 100_000;

/// Show the settings of a board, and change them
#[derive(clap::Args)]
#[command(after_help = "\
A setting takes effect at once. An Uno, a Nano and a Mega keep it when their power
goes off; other boards over a reset alone. None is changed while a motor moves.
The names are those of the serial line: `$` lists them, `$pulse-us=3` sets one.

Examples:
  stepwright settings get --port /dev/ttyUSB0
  stepwright settings set --port /dev/ttyUSB0 idle-ms=60000 pulse-us=3
  stepwright settings save --port /dev/ttyUSB0 mill.toml
  stepwright settings load --port /dev/ttyUSB0 mill.toml
  stepwright settings set --help       what there is to be set")]
pub struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(Subcommand)]
enum What {
    Get(GetArgs),
    Set(SetArgs),
    Reset(ResetArgs),
    Load(LoadArgs),
    Save(SaveArgs),
}

/// Print the settings of a board, or the value of one
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  stepwright settings get --port /dev/ttyUSB0
  stepwright settings get --port /dev/ttyUSB0 idle-ms")]
struct GetArgs {
    /// Print the value of this setting alone
    #[arg(value_parser = words::NameParser, hide_possible_values = true)]
    name: Option<Setting>,
    /// How to write the result
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    #[command(flatten)]
    port: PortArgs,
}

/// Set one or more settings
#[derive(clap::Args)]
#[command(after_help = "\
Nothing is sent unless every value is allowed. Axes are given as a sum: 1 for X,
2 for Y, 4 for Z.

Examples:
  Drivers off after a minute's rest, and a longer pulse:
    stepwright settings set --port /dev/ttyUSB0 idle-ms=60000 pulse-us=3
  X and Y have limit switches to ground, both at the lower end:
    stepwright settings set --port /dev/ttyUSB0 switches=3 switch-forward=0 switch-high=0")]
struct SetArgs {
    /// A name and its number
    #[arg(required = true, value_name = "NAME=VALUE", value_parser = words::ValueParser)]
    values: Vec<Value>,
    #[command(flatten)]
    port: PortArgs,
}

/// Reset all settings to their defaults
#[derive(clap::Args)]
#[command(after_help = "\
Example:
  stepwright settings reset --port /dev/ttyUSB0")]
struct ResetArgs {
    #[command(flatten)]
    port: PortArgs,
}

/// Set the settings that a file names
#[derive(clap::Args)]
#[command(after_help = "\
The file is TOML, `name = number` a line, as `stepwright settings save` writes it;
what it leaves out stays as it is. If any line is bad, nothing is set and every bad
line is reported.

Example:
  stepwright settings load --port /dev/ttyUSB0 mill.toml")]
struct LoadArgs {
    /// The file
    file: PathBuf,
    #[command(flatten)]
    port: PortArgs,
}

/// Write all settings to a file
#[derive(clap::Args)]
#[command(after_help = "\
The file is TOML, with the meaning, the unit and the range of every setting. A file
that is there already is replaced as a whole, and keeps its permissions.

Examples:
  stepwright settings save --port /dev/ttyUSB0 mill.toml
  stepwright settings save --port /dev/ttyUSB0 -          to standard output")]
struct SaveArgs {
    /// The file, or `-`
    file: PathBuf,
    #[command(flatten)]
    port: PortArgs,
}

/// Runs one of the subcommands.
pub fn run(args: Args) -> Result<(), Failure> {
    match args.what {
        What::Get(args) => get(&args),
        What::Set(args) => set(&args),
        What::Reset(args) => reset(&args),
        What::Load(args) => load(&args),
        What::Save(args) => save(&args),
    }
}

fn get(args: &GetArgs) -> Result<(), Failure> {
    let (_, settings) = meet(&args.port, "settings get")?;
    if let Some(setting) = args.name {
        there(&settings, setting)?;
    }
    let asked = |value: &Value| args.name.is_none_or(|name| name == value.setting());
    let asked: Vec<_> = settings.values().filter(asked).collect();
    if args.format == Format::Json {
        let pair = |value: &Value| (value.setting().name().to_owned(), json!(value.number()));
        say::json(json!(asked.iter().map(pair).collect::<Map<_, _>>()));
    } else if args.name.is_some() {
        asked.iter().for_each(|value| say::result(value.number()));
    } else {
        asked.iter().for_each(|value| say::result(row(*value)));
    }
    Ok(())
}

/// The value of a setting. An error if the board does not have it.
fn there(settings: &Listed, setting: Setting) -> Result<Value, Failure> {
    settings.get(setting).ok_or_else(|| {
        Failure::new(format!("this board has no setting {}", setting.name()))
            .hint("`stepwright settings get` lists those that it has")
    })
}

/// A setting as a row of a table.
fn row(value: Value) -> String {
    let (setting, number) = (value.setting(), value.number());
    let unit = setting.unit();
    format!("{:<15}{number:>10} {unit:<9} {}", setting.name(), setting.help())
}

fn set(args: &SetArgs) -> Result<(), Failure> {
    let (mut session, settings) = meet(&args.port, "settings set")?;
    change(&mut session, settings, &args.values)?;
    args.values.iter().for_each(|value| say::result(row(*value)));
    Ok(())
}

fn reset(args: &ResetArgs) -> Result<(), Failure> {
    let (mut session, _) = meet(&args.port, "settings reset")?;
    order(&mut session, Command::Reset)?;
    say::result("all settings have their defaults");
    Ok(())
}

fn load(args: &LoadArgs) -> Result<(), Failure> {
    let path = &args.file;
    let text = files::read(path, MOST)?;
    let values = file::read(&text).map_err(|wrong| {
        Failure::new(format!("{}: {}", path.display(), wrong.join("\n       ")))
            .hint("nothing was set; `stepwright settings save` writes a file that is right")
    })?;
    let (mut session, settings) = meet(&args.port, "settings load")?;
    let changed = change(&mut session, settings, &values)?;
    say::result(format_args!("{changed} of {} settings changed", values.len()));
    Ok(())
}

fn save(args: &SaveArgs) -> Result<(), Failure> {
    let (mut session, settings) = meet(&args.port, "settings save")?;
    let text = file::write(&settings, &session.link().name());
    if args.file == Path::new("-") {
        use std::io::Write;
        return unless_closed(std::io::stdout().write_all(text.as_bytes()));
    }
    files::replace(&args.file, text.as_bytes())
}

/// Connects to a board that has settings.
fn meet(port: &PortArgs, order: &str) -> Result<(Session, Listed), Failure> {
    let mut session = port.meet(order, Share::Alone)?;
    let settings = ask(&mut session)?;
    Ok((session, settings))
}

/// The settings of a board.
pub fn ask(session: &mut Session) -> Result<Listed, Failure> {
    // A damaged line is answered with E.
    for _ in 0..3 {
        let reply = session.ask(Command::Settings).map_err(target::trouble(session))?;
        if let Reply::Settings(settings) = reply {
            return Ok(settings);
        }
    }
    let name = session.link().name();
    Err(Failure::new(format!("{name} has no settings: it answers `$` with E"))
        .hint("is it a board with the Nano slave's program? It can't be set up over the line"))
}

/// Sets the settings that have another value. Returns their number.
fn change(session: &mut Session, settings: Listed, values: &[Value]) -> Result<usize, Failure> {
    let mut now = Settings::new();
    for value in values {
        now.set(there(&settings, value.setting())?);
    }
    let mut changed = 0;
    for value in values {
        if now.set(*value) {
            order(session, Command::Set(*value))?;
            changed += 1;
        }
    }
    if changed > 0 {
        has_kept(session, &now, values)?;
    }
    Ok(changed)
}

/// Checks that the board has these settings with the values of `now`. A board whose power failed
/// meanwhile has restarted with its stored values, and has only the later changes.
fn has_kept(session: &mut Session, now: &Settings, values: &[Value]) -> Result<(), Failure> {
    let kept = ask(session)?;
    for setting in values.iter().map(|value| value.setting()) {
        let has = there(&kept, setting)?.number();
        if has != now.get(setting) {
            let (board, name) = (session.link().name(), setting.name());
            let what = format!("{board} has {name}={has}, and not {}", now.get(setting));
            return Err(Failure::new(what)
                .hint("it was restarted meanwhile: look at its power, and set all of it again"));
        }
    }
    Ok(())
}

/// Sends a line that changes settings; repeating it is harmless.
pub fn order(session: &mut Session, line: Command) -> Result<(), Failure> {
    for _ in 0..3 {
        let reply = session.ask(line).map_err(target::trouble(session))?;
        if reply == Reply::Yes {
            return Ok(());
        }
        let why = session.why().map_err(target::trouble(session))?;
        match why {
            // The line was damaged: sends it again.
            None | Some(Refusal::Line | Refusal::Sum) => {}
            Some(why) => {
                return Err(Failure::new(format!("the board refuses {line}")).hint(why.to_string()));
            }
        }
    }
    Err(Failure::new(format!("the board refuses {line}")))
}

#[cfg(test)]
mod tests {
    use std::io;
    use std::time::Duration;

    use super::*;
    use stepwright_host::link::Link;
    use stepwright_host::link::simulated::{VirtualLink, VirtualUno};

    /// A board that answers `idle-ms` with Y, but does not store it.
    struct Forgetful(VirtualLink<VirtualUno>, Vec<u8>);

    impl Link for Forgetful {
        fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
            if bytes.starts_with(b"$idle-ms=") {
                self.1.extend(b"Y\r");
                return Ok(());
            }
            self.0.write(bytes)
        }

        fn read(&mut self, buffer: &mut [u8], limit: Duration) -> io::Result<usize> {
            if self.1.is_empty() {
                return self.0.read(buffer, limit);
            }
            let said = self.1.drain(..);
            Ok(buffer.iter_mut().zip(said).map(|(to, byte)| *to = byte).count())
        }

        fn now(&self) -> Duration {
            self.0.now()
        }

        fn name(&self) -> String {
            "the board".to_owned()
        }
    }

    #[test]
    fn a_setting_that_is_lost_on_the_way_is_noticed() {
        let board = VirtualLink::new(VirtualUno::new(), true);
        let mut session = Session::new(Box::new(Forgetful(board, Vec::new())));
        let value = |setting, number| Value::new(setting, number).unwrap();
        let set = |session: &mut Session, values: &[Value]| {
            let settings = ask(session).unwrap();
            change(session, settings, values).map_err(|failure| failure.to_string())
        };
        let (pulse, idle) = (value(Setting::Pulse, 5), value(Setting::Idle, 7));
        assert_eq!(set(&mut session, &[pulse]), Ok(1));
        // The last of two values counts; an unchanged value is not sent.
        let again = [value(Setting::Pulse, 6), pulse, value(Setting::Idle, 0)];
        assert_eq!(set(&mut session, &again), Ok(2));
        let lost = set(&mut session, &[idle, value(Setting::Hold, 3)]);
        assert_eq!(lost, Err("the board has idle-ms=0, and not 7".to_owned()));
    }
}
