//! `move` and `run` by one of Austin's laws, on a board with a program for it or on a virtual
//! board.

use std::time::Duration;

use serde_json::{Value, json};
use stepwright_austin::line::{Line, NAME, Refused};
use stepwright_austin::station::{CHANGES, Costs};
use stepwright_austin::{LawName, Recipe};
use stepwright_protocol::{AxisId, Fault, Selection};

use super::drive;
use super::law::LawArgs;
use super::motion::{RampArgs, TOP, seconds};
use super::target::{self, Format, PortArgs, VirtualArgs};
use super::travel::{last_line, short, start_position};
use crate::board::recording::{Heading, Recording};
use crate::failure::Failure;
use crate::interrupt;
use crate::programs;
use crate::quantity::{Rounded, SpeedArg, in_unit};
use crate::say;
use stepwright::{Accel, Geometry, Rate, Speed};
use stepwright_host::LinkError;
use stepwright_host::link::Link;
use stepwright_host::link::bench::Bench;
use stepwright_host::link::serial::Share;
use stepwright_host::link::simulated::VirtualLink;
use stepwright_host::motion::{Action, NotBegun, RestPlace};
use stepwright_host::programs::{LawProblem, LawSession, RowProblem};
use stepwright_plan::RampChange;
use stepwright_plot::GAP;
use stepwright_sim::Description;

/// The target, as typed.
#[derive(Clone, Copy)]
pub enum Goal {
    /// This many steps from the present position.
    By(i64),
    /// To a position.
    To(i64),
    /// Endless, until it is stopped: true is forward.
    Endless(bool),
}

/// An order by a law.
pub struct LawOrder<'a> {
    /// The law.
    pub law: LawName,
    /// Its options.
    pub options: &'a LawArgs,
    /// Its accelerations.
    pub ramps: &'a RampArgs,
    /// The top speed. By default the usual one, or the highest that the board can make.
    pub top: Option<&'a SpeedArg>,
    /// The target.
    pub goal: Goal,
    /// The duration of an endless travel.
    pub time: Option<Duration>,
    /// How to write the result.
    pub format: Format,
}

/// The values of the options.
struct Understood {
    top: Rounded<Speed>,
    accel: Rounded<Accel>,
    decel: Rounded<Accel>,
    changes: Vec<RampChange>,
}

impl LawOrder<'_> {
    /// Carries out the order.
    pub fn run(&self, axis: AxisId, port: &PortArgs, virt: &VirtualArgs) -> Result<(), Failure> {
        if axis != AxisId::FIRST {
            return Err(Failure::usage(format!("a law moves axis 1, not {}", axis.number()))
                .hint("leave --axis out"));
        }
        let geometry: Geometry = self.ramps.geometry()?;
        // A travel that no timer can represent is refused before anything is opened. A virtual
        // board begins at 0.
        let steps = self.steps(0)?;
        let held = match self.top {
            Some(top) => self.understood(&geometry, top)?,
            None => self.suited(&geometry, steps)?,
        };
        self.recipe(&held, steps)?;
        interrupt::listen(interrupt::While::Holding)?;
        let link: Box<dyn Link> = match &port.port {
            Some(path) => Box::new(target::serial(path, port.baud, Share::Alone)?),
            None => self.virtual_link(&held, virt)?,
        };
        let mut session = target::conversation(link);
        let at = session.name();
        let about = target::met_program(&mut session, NAME, |about| program(self.law, about))?;
        let mut board =
            LawSession::of(session, about).map_err(|problem| failure(self.law, &at, problem))?;
        let result = self.on(&mut board, &held);
        // The recordings are also written after an error.
        let finished = target::finish(board.session());
        result.and(finished)
    }

    /// The values of the options, with this top speed.
    fn understood(&self, geometry: &Geometry, top: &SpeedArg) -> Result<Understood, Failure> {
        let name = match self.goal {
            Goal::Endless(_) => "the speed",
            _ => "--top-speed",
        };
        let top = top.moving(geometry, name)?;
        let (accel, decel) = self.ramps.slopes_from_rest(geometry, &top)?;
        let changes = self.options.changes(geometry)?;
        Ok(Understood { top, accel, decel, changes })
    }

    /// The values of the options with the usual top speed, or the highest that a board can make by
    /// this law.
    fn suited(&self, geometry: &Geometry, steps: i32) -> Result<Understood, Failure> {
        let held = self.understood(geometry, &SpeedArg::of_steps(TOP))?;
        let recipe = self.recipe(&held, steps)?;
        let changing = if held.changes.is_empty() { 0 } else { Costs::AVR.changing };
        let least = Costs::AVR.of(&recipe).max(changing);
        if recipe.shortest() >= least {
            return Ok(held);
        }
        self.understood(geometry, &SpeedArg::of_steps(Rate::MHZ.hz() / least))
    }

    fn virtual_link(
        &self,
        held: &Understood,
        virt: &VirtualArgs,
    ) -> Result<Box<dyn Link>, Failure> {
        let description = Description::uno();
        let title = format!("Axis 1 by the law {}", self.law.name());
        let note = self
            .rows(held)
            .iter()
            .map(|row| row.split_whitespace().collect::<Vec<_>>().join(" "))
            .collect::<Vec<_>>();
        let heading =
            Heading { title, notes: vec![note.join(GAP)], unit: self.ramps.unit(), jerk: false };
        let plot = virt.plot.as_ref().map(|file| (file, heading));
        let recording = Recording::begin(&description, virt.edges(), plot)?;
        Ok(Box::new(VirtualLink::new(Bench::laws(description, recording), virt.fast)))
    }

    /// The steps from `from` to the target; 0 if endless.
    fn steps(&self, from: i64) -> Result<i32, Failure> {
        let steps = match self.goal {
            Goal::By(steps) => steps,
            Goal::To(to) => to.saturating_sub(from),
            Goal::Endless(_) => return Ok(0),
        };
        i32::try_from(steps).map_err(|_| {
            Failure::usage(format!("{steps} steps are too far for one travel"))
                .hint("a travel has at most 2147483647 steps forward, 2147483648 backward")
        })
    }

    fn recipe(&self, held: &Understood, steps: i32) -> Result<Recipe, Failure> {
        let endless = matches!(self.goal, Goal::Endless(_));
        let pulses = if endless { stepwright_austin::line::ENDLESS } else { steps.unsigned_abs() };
        let (accel, decel) = (held.accel.value, held.decel.value);
        self.options.recipe(self.law, pulses, held.top.value, accel, decel)
    }

    /// The values of the options, as text.
    fn rows(&self, held: &Understood) -> Vec<String> {
        let mut rows = vec![
            format!("  {:<12}{}, from rest", "law", self.law.name()),
            format!("  {:<12}{}", "top speed", held.top),
            format!("  {:<12}{}", "ramp up", held.accel),
            format!("  {:<12}{}", "ramp down", held.decel),
        ];
        for (steps, accel) in &held.changes {
            rows.push(format!("  {:<12}{accel} after {steps} steps", "change"));
        }
        rows
    }

    fn on(&self, board: &mut LawSession, held: &Understood) -> Result<(), Failure> {
        let at = board.name();
        if !board.laws().any(|law| law == self.law) {
            let (name, has) = (self.law.name(), board.laws().map(LawName::name));
            let has = has.collect::<Vec<_>>().join(",");
            let about = board.about();
            return Err(Failure::new(format!("{at} has the laws {has}, and not {name}"))
                .hint(programs::flash(about, program(self.law, about))));
        }
        let axis = AxisId::FIRST;
        let session = board.session();
        let trouble = target::trouble(session);
        if session.is_busy(Selection::One(axis)).map_err(trouble)? {
            return Err(Failure::new(format!("{at} moves already")).hint("wait until it rests"));
        }
        let from = start_position(session, axis)?;
        let steps = self.steps(from)?;
        let (title, go) = match self.goal {
            Goal::Endless(forward) => {
                let way = if forward { "forward" } else { "backward" };
                (format!("axis 1 {way} without end on {at}"), Line::Run(forward))
            }
            _ => (format!("axis 1 by {steps:+} steps on {at}"), Line::Go(steps)),
        };
        if self.format == Format::Text {
            say::result(title);
            self.rows(held).iter().for_each(say::result);
        }
        let recipe = self.recipe(held, steps)?;
        let changes: Vec<_> = held.changes.iter().map(|(n, accel)| (*n, accel.value)).collect();
        board.set_law(&recipe, &changes).map_err(|problem| failure(self.law, &at, problem))?;
        let before = board.word("late").and_then(|late| late.parse::<u32>().ok());
        let begun = board.session().now();
        let mut signal = false;
        let watched = match board.begin(&go, Some(from)) {
            Ok(()) => {
                let session = board.session();
                let until = self.time.map(|time| session.now() + time);
                session.watch(axis, until, |_, sight| {
                    if !interrupt::asked() {
                        return Action::GoOn;
                    }
                    if sight.moving && !sight.braking {
                        signal = true;
                        say::note(interrupt::braking());
                    }
                    Action::Stop
                })
            }
            Err(RowProblem::Lost(LinkError::Killed)) => Err(LinkError::Killed),
            Err(RowProblem::Lost(trouble)) => {
                return Err(drive::not_begun(board.session(), NotBegun::unsure(trouble)));
            }
            Err(RowProblem::Noise { .. }) => {
                return Err(drive::not_begun(board.session(), NotBegun::Noise));
            }
            Err(problem) => return Err(failure(self.law, &at, problem)),
        };
        let session = board.session();
        let ended = drive::conclude(session, axis, watched);
        let took = session.now().saturating_sub(begun).as_secs_f64();
        let target =
            (!matches!(self.goal, Goal::Endless(_))).then(|| from.saturating_add(steps.into()));
        let (state, position) = match ended.end {
            RestPlace::At(at) if target.is_none_or(|target| at == target) => ("ready", Some(at)),
            RestPlace::At(at) => ("stopped", Some(at)),
            RestPlace::Uncertain => ("uncertain", None),
        };
        let late =
            before.zip(board.late().ok().flatten()).map(|(before, now)| now.saturating_sub(before));
        if let Some(late @ 1..) = late {
            say::note(format_args!("{late} steps came late: the board is too slow for this speed"));
        }
        match self.format {
            Format::Json => say::json(in_unit(
                self.ramps.unit(),
                self.json(held, &at, (from, target), (state, position, late), took),
                &["from", "steps", "target", "position"],
            )),
            Format::Text => {
                say::result(format_args!("  {:<12}{}", "took", seconds(took)));
                say::result(last_line(state, position, None));
            }
        }
        match (ended.failure, position, target) {
            (Some(failure), ..) => Err(failure),
            (None, Some(at), Some(target)) if at != target => {
                Err(short(at, target, signal && ended.braked, None))
            }
            _ => Ok(()),
        }
    }

    fn json(
        &self,
        held: &Understood,
        board: &str,
        (from, target): (i64, Option<i64>),
        (state, position, late): (&str, Option<i64>, Option<u32>),
        took: f64,
    ) -> Value {
        let accel = |accel: &Rounded<Accel>| accel.value.millisteps() as f64 / 1000.0;
        let changes = held.changes.iter();
        json!({
            "axis": 1,
            "law": self.law.name(),
            "from": from,
            "target": target,
            "position": position,
            "state": state,
            "seconds": took,
            "late": late,
            "board": board,
            "top_speed": f64::from(held.top.value.millisteps()) / 1000.0,
            "accel": accel(&held.accel),
            "decel": accel(&held.decel),
            "changes": changes
                .map(|(after, to)| json!({ "steps": after, "accel": accel(to) }))
                .collect::<Vec<_>>(),
        })
    }
}

/// The failure for `--detach` and `--lease`: a board with a law must be watched to the end.
pub fn watched() -> Failure {
    Failure::usage("a board that goes by a law is watched to the end")
        .hint("leave --detach and --lease out")
}

/// The program that has a law, on the board of this answer.
fn program(law: LawName, about: &str) -> &'static str {
    if about.contains(" mega ") {
        return "laws";
    }
    match law {
        LawName::Austin | LawName::AustinFixed => "laws",
        LawName::LinearFactor | LawName::Piecewise => "transitions",
        LawName::Power => "power-term",
    }
}

/// The failure for a row that was not carried out, before anything moved.
fn failure(law: LawName, at: &str, problem: LawProblem) -> Failure {
    let name = law.name();
    let (line, reason) = match problem {
        RowProblem::Refused { row, reason } => (row, reason),
        RowProblem::Lost(trouble) => return target::lost(at, &trouble),
        RowProblem::Noise { row } => {
            let what = format!("{at}: noise spoiled the answer to {row}");
            return Failure::new(what).hint("nothing has moved. Look at the cable and its ground");
        }
        RowProblem::OtherProgram(answer) => {
            return Failure::new(format!("{at} answered {answer:?} to ?"));
        }
        RowProblem::Nonsense { row, answer } => {
            return Failure::new(format!("{at} answered {answer:?} to {row}"));
        }
    };
    match reason {
        Fault::Own(Refused::Fast(ticks)) => {
            let what = match line {
                Line::Change(..) => "changes of acceleration".to_owned(),
                _ => format!("the law {name}"),
            };
            let most = 1_000_000 / ticks.max(1);
            Failure::new(format!("{at} is too slow for {what} at this top speed"))
                .hint(format!("give a top speed of at most {most} steps/s"))
        }
        Fault::Own(Refused::Unsound) => {
            Failure::new(format!("{at} can't hold this travel by the law {name}")).hint(
                "a delay is at most 4 s, a ramp has at most 1073741824 steps, and power and \
                 piecewise take a --decel of at least --accel",
            )
        }
        Fault::Busy => Failure::new(format!("{at} moves already")),
        Fault::Own(Refused::Full) => {
            Failure::usage(format!("{at} keeps {CHANGES} changes of a travel"))
                .hint("leave some of --change out")
        }
        Fault::Own(Refused::Law) if matches!(line, Line::Change(..)) => {
            Failure::usage("this form of the law does not change on its way")
                .hint("leave --change or --divisor out")
        }
        reason => Failure::new(format!("{at} refused {line}: {reason}")),
    }
}
