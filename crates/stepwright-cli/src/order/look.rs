//! `stepwright status`, `position` and `zero`: where the axes are.

use serde_json::{Map, Value, json};
use stepwright_protocol::{
    AxisId, BoardError, Command, Errors, Info, Reply, Selection, Stop, Value as Set,
};

use super::target::{self, Format, PortArgs};
use super::travel::last_line;
use crate::failure::Failure;
use crate::link::serial::Share;
use crate::say;
use crate::session::{LinkError, Session};

/// What the board is, and what its axes are doing
#[derive(clap::Args)]
#[command(after_help = "\
Behind an axis that has not come to the end of its order stands the reason, until the
axis moves again: `stopped by its limit switch`. The last line has the settings that
differ from their defaults.

Example:
  stepwright status --port /dev/ttyUSB0")]
pub struct StatusArgs {
    /// How to write the result
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    #[command(flatten)]
    port: PortArgs,
}

/// Where an axis is
#[derive(clap::Args)]
#[command(after_help = "\
Says `position N ready`, `position N busy` on the way, or `position uncertain`
with status 1.

Example:
  stepwright position --port /dev/ttyUSB0")]
pub struct PositionArgs {
    #[command(flatten)]
    one: OneArgs,
}

/// Call the place where an axis stands 0
#[derive(clap::Args)]
#[command(after_help = "\
Makes a position certain again that a kill has lost.

Example:
  stepwright zero --port /dev/ttyUSB0")]
pub struct ZeroArgs {
    #[command(flatten)]
    one: OneArgs,
}

/// One axis of a board.
#[derive(clap::Args)]
pub struct OneArgs {
    /// How to write the result
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub format: Format,
    #[command(flatten)]
    pub port: PortArgs,
    /// Which axis of the board: 1 to 8
    #[arg(long, value_name = "N", default_value = "1", value_parser = target::axis)]
    #[arg(help_heading = "Board")]
    pub axis: AxisId,
}

/// What an axis is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct State {
    /// Which one.
    pub axis: AxisId,
    /// Whether it moves.
    pub busy: bool,
    /// Where it is, if that is known.
    pub position: Option<i64>,
    /// Why it has stopped before the end of its order.
    pub stop: Option<Stop>,
}

impl State {
    /// What it is doing: `busy`.
    pub fn word(&self) -> &'static str {
        match (self.position, self.busy) {
            (None, _) => "uncertain",
            (_, true) => "busy",
            (_, false) => "ready",
        }
    }

    /// `position 4000 ready`.
    pub fn line(&self) -> String {
        last_line(self.word(), self.position, None)
    }
}

/// Asks for the state of one axis, or of all.
pub fn states(session: &mut Session, only: Option<AxisId>) -> Result<Vec<State>, LinkError> {
    let axes = session.info().map_or(1, |info| info.axes);
    let mut states = Vec::new();
    for axis in AxisId::first(axes).filter(|axis| only.is_none_or(|only| only == *axis)) {
        let busy = session.is_busy(Selection::One(axis))?;
        let position = if busy { session.position(axis)? } else { session.rest_position(axis)? };
        states.push(State { axis, busy, position, stop: None });
    }
    let stops = session.ask_info()?.and_then(|info| info.stops);
    for state in states.iter_mut().filter(|state| !state.busy) {
        state.stop = stops.and_then(|stops| stops.of(state.axis));
    }
    // As a master finds it that knows of one axis only.
    session.select(Selection::FIRST)?;
    Ok(states)
}

/// The states for programs.
pub fn json(states: &[State]) -> Value {
    let one = |state: &State| {
        json!({
            "axis": state.axis.number(),
            "position": state.position,
            "state": state.word(),
            "stop": state.stop.map(stop_word),
        })
    };
    states.iter().map(one).collect()
}

/// The reason of a stop for programs: `switch`.
pub fn stop_word(stop: Stop) -> String {
    format!("{stop:?}").to_lowercase()
}

/// That all positions are known.
pub fn all_known(name: &str, states: &[State]) -> Result<(), Failure> {
    match states.iter().find(|state| state.position.is_none()) {
        None => Ok(()),
        Some(lost) => {
            let axis = lost.axis.number();
            Err(Failure::new(format!("{name}: the position of axis {axis} is uncertain")).hint(
                format!(
                    "a kill has lost it. If it stands at a known place, or to go and find one, \
                     call it 0: `stepwright zero --axis {axis} --port {name}`"
                ),
            ))
        }
    }
}

/// Says what the board is and does.
pub fn status(args: StatusArgs) -> Result<(), Failure> {
    let mut session = args.port.meet("status", Share::Guest)?;
    let states = states(&mut session, None).map_err(target::trouble(&mut session))?;
    let info = session.info().copied();
    let changed = changed(&mut session).map_err(target::trouble(&mut session))?;
    match args.format {
        Format::Json => say::result(json!({
            "board": info.map(board),
            "axes": json(&states),
            "settings": changed.iter().map(pair).collect::<Map<_, _>>(),
        })),
        Format::Text => {
            show(info);
            for state in &states {
                let number = state.axis.number();
                let why = state.stop.map(|stop| format!(", stopped by {}", stop.words()));
                let why = why.unwrap_or_default();
                say::result(format_args!("axis {number}      {}{why}", state.line()));
            }
            if !changed.is_empty() {
                let words = changed
                    .iter()
                    .map(|value| format!("{}={}", value.setting().name(), value.number()));
                let words: Vec<_> = words.collect();
                say::result(format_args!("settings    {}", words.join(" ")));
            }
        }
    }
    Ok(())
}

/// The settings that differ from their defaults; none of a board that has no settings.
fn changed(session: &mut Session) -> Result<Vec<Set>, LinkError> {
    if session.info().is_none() {
        return Ok(Vec::new());
    }
    let differs = |value: &Set| value.number() != value.setting().default();
    // Once: a board that has none, or answers otherwise, is no trouble here.
    Ok(match session.once(Command::Settings)? {
        Some(Reply::Settings(settings)) => settings.values().filter(differs).collect(),
        _ => Vec::new(),
    })
}

/// A setting for programs.
fn pair(value: &Set) -> (String, Value) {
    (value.setting().name().to_owned(), json!(value.number()))
}

fn board(info: Info) -> Value {
    json!({
        "protocol": format!("{}.{}", info.version.0, info.version.1),
        "axes": info.axes,
        "max_speed": info.max,
        "late": info.late,
        "refused": info.refused,
        "last": info.last.map(|last| last.name()),
        "errors": info.errors.map(|errors| errors.iter().map(BoardError::name).collect::<Vec<_>>()),
    })
}

fn show(info: Option<Info>) {
    let Some(info) = info else {
        return say::result("board       knows the Nano slave's lines only");
    };
    let axes = if info.axes == 1 { "axis" } else { "axes" };
    say::result(format_args!(
        "board       stepwright {}.{}, {} {axes}, up to {} steps/s",
        info.version.0, info.version.1, info.axes, info.max
    ));
    say::result(format_args!("late        {} steps", info.late));
    let lines = if info.refused == 1 { "line" } else { "lines" };
    let last = match info.last {
        Some(last) => format!(", the last as {}: {last}", last.name()),
        None => String::new(),
    };
    say::result(format_args!("refused     {} {lines}{last}", info.refused));
    if let Some(errors) = info.errors.filter(|errors| *errors != Errors::NONE) {
        let words: Vec<_> = errors.iter().map(BoardError::words).collect();
        say::result(format_args!("since !     {}", words.join(", ")));
    }
}

/// Says where an axis is.
pub fn position(args: PositionArgs) -> Result<(), Failure> {
    let OneArgs { port, axis, format } = args.one;
    let mut session = port.meet("position", Share::Guest)?;
    target::has_axis(&session, axis)?;
    let states = states(&mut session, Some(axis)).map_err(target::trouble(&mut session))?;
    tell(format, &states);
    all_known(&session.link().name(), &states)
}

/// Calls the place where an axis stands 0.
pub fn zero(args: ZeroArgs) -> Result<(), Failure> {
    let OneArgs { port, axis, format } = args.one;
    let mut session = port.meet("zero", Share::Alone)?;
    target::has_axis(&session, axis)?;
    let name = session.link().name();
    let lost = |trouble| target::lost(&name, &trouble);
    if session.ask(Command::Zero(axis)).map_err(lost)? != Reply::Yes {
        return Err(match session.why().map_err(lost)? {
            Some(why) => Failure::new(format!("{name} refused I{}: {why}", axis.number())),
            None => Failure::new(format!("{name} refused I{}", axis.number()))
                .hint("is the axis still travelling?"),
        });
    }
    let states = states(&mut session, Some(axis)).map_err(lost)?;
    tell(format, &states);
    all_known(&name, &states)
}

fn tell(format: Format, states: &[State]) {
    for state in states {
        match format {
            Format::Json => say::result(json!({
                "axis": state.axis.number(),
                "position": state.position,
                "state": state.word(),
            })),
            Format::Text => say::result(state.line()),
        }
    }
}
