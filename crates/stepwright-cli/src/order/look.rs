//! `stepwright status`, `position` and `zero`: the positions of the axes.

use serde_json::{Map, Value, json};
use stepwright_protocol::{
    Abilities, Ability, AxisId, BoardError, Command, Info, Listed, Reply, Selection, Setting, Stop,
    Value as Set,
};

use super::refused;
use super::target::{self, AxisArgs, Format, PortArgs};
use super::travel::last_line;
use crate::failure::Failure;
use crate::machine::{self, MachineArgs};
use crate::quantity::{GeometryArgs, MachineUnit, in_unit};
use crate::say;
use stepwright_host::link::serial::Share;
use stepwright_host::{LinkError, Session};

/// Show the board, its axes and their states
#[derive(clap::Args)]
#[command(after_help = "\
An axis that has stopped before the end of its order shows the reason until it
moves again: `stopped by its limit switch`. `extras` lists jerk (S-curves), safety (leases,
soft limits and the other guards) and sum (checksums), if the board has them. `faults` are
counted since the last `!` (`stepwright send '!'` clears them). Then follow the limit switches
of the board, whether each is closed now and the level of its pin, and the settings that
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

/// Print the position of an axis
#[derive(clap::Args)]
#[command(after_help = "\
Prints `position N ready`, `position N busy` while the axis moves, or `position uncertain`
with status 1. If the steps of a turn are known, from the machine file or an option, the
position follows in millimetres or degrees: `position 4000 ready (10 mm)`.

Example:
  stepwright position --port /dev/ttyUSB0")]
pub struct PositionArgs {
    #[command(flatten)]
    one: OneArgs,
}

/// Set the current position of an axis to 0
#[derive(clap::Args)]
#[command(after_help = "\
After a kill it makes the position known again.

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
    #[command(flatten)]
    pub on: AxisArgs,
    #[command(flatten)]
    geometry: GeometryArgs,
}

impl OneArgs {
    /// The machine's unit, if known.
    pub fn unit(&self) -> Option<MachineUnit> {
        self.geometry.unit()
    }
}

/// The state of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct State {
    /// The axis.
    pub axis: AxisId,
    /// Whether it moves.
    pub busy: bool,
    /// Its position, if known.
    pub position: Option<i64>,
    /// The reason if it stopped before the end of its order.
    pub stop: Option<Stop>,
}

impl State {
    /// The state as a word: `uncertain`, `busy` or `ready`.
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

    /// `position 4000 ready (10 mm)`, and the reason if it was stopped.
    pub fn line_in(&self, unit: Option<MachineUnit>, why: Option<Stop>) -> String {
        let word = if why.is_some() { "stopped" } else { self.word() };
        let shown = unit.zip(self.position).map(|(unit, at)| format!(" ({})", unit.shown(at)));
        last_line(word, self.position, why) + &shown.unwrap_or_default()
    }
}

/// Requests the state of one axis, or of all.
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
    // Leaves axis 1 selected, for a host that knows only one axis.
    session.select(Selection::FIRST)?;
    Ok(states)
}

/// The states as JSON.
pub fn json(states: &[State]) -> Value {
    json_in(&[], states)
}

/// The states as JSON, also in the units of the axes.
fn json_in(units: &Units, states: &[State]) -> Value {
    let one = |state: &State| {
        let told = json!({
            "axis": state.axis.number(),
            "position": state.position,
            "state": state.word(),
            "stop": state.stop.map(Stop::name),
        });
        in_unit(unit_of(units, state.axis), told, &["position"])
    };
    states.iter().map(one).collect()
}

/// The units of a machine's axes.
type Units = [(AxisId, MachineUnit)];

fn unit_of(units: &Units, axis: AxisId) -> Option<MachineUnit> {
    units.iter().find(|(known, _)| *known == axis).map(|(_, unit)| *unit)
}

/// Checks that all positions are known.
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

/// Prints the board and the states of its axes.
pub fn status(args: StatusArgs, machine: &MachineArgs) -> Result<(), Failure> {
    let units = machine::units(machine)?;
    let mut session = args.port.meet("status", Share::Guest)?;
    let states = states(&mut session, None).map_err(target::trouble(&mut session))?;
    let info = session.info().copied();
    let listed = settings(&mut session).map_err(target::trouble(&mut session))?;
    let changed = changed(listed.as_ref());
    let closed = info.and_then(|info| info.closed);
    let switches = switches(listed.as_ref(), closed, &states);
    match args.format {
        Format::Json => say::json(json!({
            "board": info.map(board),
            "axes": json_in(&units, &states),
            "switches": switches.iter().map(LimitSwitch::json).collect::<Value>(),
            "settings": changed.iter().map(pair).collect::<Map<_, _>>(),
        })),
        Format::Text => {
            show(info);
            for state in &states {
                let number = state.axis.number();
                let why = state.stop.map(|stop| format!(", stopped by {}", stop.words()));
                let why = why.unwrap_or_default();
                let line = state.line_in(unit_of(&units, state.axis), None);
                say::result(format_args!("axis {number}      {line}{why}"));
            }
            if !switches.is_empty() {
                let words: Vec<_> = switches.iter().map(LimitSwitch::words).collect();
                say::result(format_args!("switches    {}", words.join(", ")));
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

/// The settings; `None` if the board has none.
fn settings(session: &mut Session) -> Result<Option<Listed>, LinkError> {
    if session.info().is_none() {
        return Ok(None);
    }
    // Asks once: no answer, or another one, is no error here.
    Ok(match session.once(Command::Settings)? {
        Some(Reply::Settings(settings)) => Some(settings),
        _ => None,
    })
}

/// The settings that differ from their defaults.
fn changed(listed: Option<&Listed>) -> Vec<Set> {
    let all = listed.into_iter().flat_map(Listed::values);
    all.filter(|value| value.number() != value.setting().default()).collect()
}

/// A limit switch that the board knows of.
struct LimitSwitch {
    axis: AxisId,
    /// Whether it is at the forward end of the travel.
    forward: bool,
    /// Whether its pin reads high when it is closed.
    high: bool,
    /// Whether it is closed now; `None` if the board does not report it.
    closed: Option<bool>,
    /// Whether it has stopped its axis.
    stopped: bool,
}

/// The limit switches of these axes. `closed` has the bits of the closed ones, from the board.
fn switches(listed: Option<&Listed>, closed: Option<u8>, states: &[State]) -> Vec<LimitSwitch> {
    let has = |setting, axis: AxisId| {
        let set = listed.and_then(|listed| listed.get(setting)).map_or(0, |value| value.number());
        set >> axis.index() & 1 != 0
    };
    let known = states.iter().filter(|state| has(Setting::Switches, state.axis));
    known
        .map(|state| LimitSwitch {
            axis: state.axis,
            forward: has(Setting::SwitchForward, state.axis),
            high: has(Setting::SwitchHigh, state.axis),
            closed: closed.map(|closed| closed >> state.axis.index() & 1 != 0),
            stopped: state.stop == Some(Stop::Switch),
        })
        .collect()
}

impl LimitSwitch {
    fn end(&self) -> &'static str {
        if self.forward { "forward" } else { "backward" }
    }

    /// The level of its pin, closed or open.
    fn level(&self, closed: bool) -> &'static str {
        if self.high == closed { "high" } else { "low" }
    }

    /// `axis 1 backward closed (reads low, has stopped it)`.
    fn words(&self) -> String {
        let (axis, end) = (self.axis.number(), self.end());
        let stopped = if self.stopped { ", has stopped it" } else { "" };
        let Some(closed) = self.closed else {
            return format!("axis {axis} {end} (reads {} when closed{stopped})", self.level(true));
        };
        let state = if closed { "closed" } else { "open" };
        format!("axis {axis} {end} {state} (reads {}{stopped})", self.level(closed))
    }

    fn json(&self) -> Value {
        json!({
            "axis": self.axis.number(),
            "end": self.end(),
            "closed": self.closed,
            "level_when_closed": self.level(true),
            "stopped": self.stopped,
        })
    }
}

/// A setting as JSON.
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
        "can": info.can.map(|can| abilities(can).collect::<Vec<_>>()),
        "errors": info.errors.map(|errors| errors.iter().map(BoardError::name).collect::<Vec<_>>()),
    })
}

/// The optional abilities of a board, by their words in `can=`.
fn abilities(can: Abilities) -> impl Iterator<Item = &'static str> {
    Ability::ALL.into_iter().filter(move |ability| can.has(*ability)).map(Ability::name)
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
    if let Some(can) = info.can {
        let words: Vec<_> = abilities(can).collect();
        let words = if words.is_empty() { "none".to_owned() } else { words.join(", ") };
        say::result(format_args!("extras      {words}"));
    }
    let lines = if info.refused == 1 { "line" } else { "lines" };
    let last = match info.last {
        Some(last) => format!(", the last as {}: {last}", last.name()),
        None => String::new(),
    };
    say::result(format_args!("refused     {} {lines}{last}", info.refused));
    if let Some(errors) = info.errors {
        let words: Vec<_> = errors.iter().map(BoardError::words).collect();
        let words = if words.is_empty() { "none".to_owned() } else { words.join(", ") };
        say::result(format_args!("faults      {words} since the last !"));
    }
}

/// Prints the position of an axis.
pub fn position(args: PositionArgs) -> Result<(), Failure> {
    let unit = args.one.unit();
    let OneArgs { port, on: AxisArgs { axis }, format, .. } = args.one;
    let mut session = port.meet("position", Share::Guest)?;
    target::has_axis(&session, axis)?;
    let states = states(&mut session, Some(axis)).map_err(target::trouble(&mut session))?;
    tell(format, unit, &states);
    all_known(&session.link().name(), &states)
}

/// Sets the current position of an axis to 0.
pub fn zero(args: ZeroArgs) -> Result<(), Failure> {
    let unit = args.one.unit();
    let OneArgs { port, on: AxisArgs { axis }, format, .. } = args.one;
    let mut session = port.meet("zero", Share::Alone)?;
    target::has_axis(&session, axis)?;
    let name = session.link().name();
    let lost = |trouble| target::lost(&name, &trouble);
    if session.ask(Command::Zero(axis)).map_err(lost)? != Reply::Yes {
        return Err(match session.why().map_err(lost)? {
            Some(why) => refused::by(&mut session, &format_args!("I{}", axis.number()), why),
            None => Failure::new(format!("{name} refused I{}", axis.number()))
                .hint("is the axis still travelling?"),
        });
    }
    let states = states(&mut session, Some(axis)).map_err(lost)?;
    tell(format, unit, &states);
    all_known(&name, &states)
}

fn tell(format: Format, unit: Option<MachineUnit>, states: &[State]) {
    for state in states {
        match format {
            Format::Json => {
                let told = json!({
                    "axis": state.axis.number(),
                    "position": state.position,
                    "state": state.word(),
                });
                say::json(in_unit(unit, told, &["position"]));
            }
            Format::Text => say::result(state.line_in(unit, None)),
        }
    }
}
