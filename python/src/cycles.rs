//! Files of motor cycles, played on a virtual board or on a real board.

use std::fmt::Display;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use pyo3::exceptions::{PyConnectionError, PyValueError};
use pyo3::prelude::*;
use stepwright_cyclefile::{CyclePlan, MOST, Stage};
use stepwright_host::LinkError;
use stepwright_host::link::bench::BenchRecorder;
use stepwright_host::link::serial::{LeaseWait, SerialLink, Share};
use stepwright_host::programs::{CycleSession, RowProblem};
use stepwright_keeper::scope::ScopeSource;
use stepwright_play::cycle::{CyclePlayer, CyclesOnBoard, Onlooker, PlayAhead, PlayPart, PlayText};
use stepwright_play::edges::EdgeStore;
use stepwright_play::{PlayError, PlayFormat};
use stepwright_sim::Pin;

use crate::run::{Run, Silent, Way, playing};

/// The time between two looks at the clock, in real time.
const LOOK: Duration = Duration::from_millis(2);

/// The pins of a motor, and their levels before the first edge.
const PINS: [(Pin, Option<bool>); 5] = [
    (Pin::Step, Some(false)),
    (Pin::Direction, None),
    (Pin::Enable, None),
    (Pin::Min, Some(false)),
    (Pin::Max, Some(false)),
];

/// Follows the motors, lets time pass, and brakes when asked to.
struct Follower<'a> {
    hz: f64,
    /// The start of real time; `None`: as fast as possible.
    since: Option<Instant>,
    asked: &'a AtomicBool,
    edges: EdgeStore,
    braking: bool,
    ways: Vec<Way>,
}

impl Onlooker for Follower<'_> {
    fn part(&mut self, _: PlayPart) {}

    fn at(&mut self, ticks: u64, positions: &[i64; MOST]) {
        for (motor, (way, place)) in self.ways.iter_mut().zip(positions).enumerate() {
            if way.is_elsewhere(*place as f64) {
                let rose = self.edges.take_rise(motor).unwrap_or(ticks);
                way.see(rose as f64 / self.hz, *place as f64);
            }
        }
    }

    fn may(&mut self, ticks: u64) -> Result<PlayAhead, PlayError> {
        if self.asked.load(Ordering::Relaxed) && !self.braking {
            self.braking = true;
            return Ok(PlayAhead::Stop);
        }
        let Some(since) = self.since else { return Ok(PlayAhead::On(u64::MAX)) };
        let now = || (since.elapsed().as_secs_f64() * self.hz) as u64;
        if now() <= ticks {
            thread::sleep(LOOK);
        }
        Ok(PlayAhead::On(now()))
    }
}

/// Plays a file with this name and text on the board at a port, or on a virtual board, which runs in real time
/// unless `fast`. A cycle that has not ended after `limit` seconds is finished.
#[pyfunction]
pub fn play_cycles(
    py: Python<'_>,
    name: &str,
    text: &str,
    port: Option<String>,
    baud: u32,
    fast: bool,
    limit: u32,
) -> PyResult<Run> {
    let text = PlayText::named(name, text);
    let read = stepwright_cyclefile::read(&text).map_err(|error| {
        let hint = error.hint.map_or(String::new(), |hint| format!("\n hint: {hint}"));
        PyValueError::new_err(format!("{}{hint}", error.message))
    });
    let mut plan = read?;
    let mut stages = std::mem::take(&mut plan.stages);
    playing(py, |asked| match port {
        None => Ok(on_virtual(&plan, &text, &mut stages, fast, limit, asked)),
        Some(port) => on_board(&plan, &text, &mut stages, (Path::new(&port), baud), limit, asked),
    })
}

fn begun(plan: &CyclePlan) -> Vec<Way> {
    plan.positions.iter().take(plan.names.len()).map(|place| Way::from(*place as f64)).collect()
}

fn on_virtual(
    plan: &CyclePlan,
    text: &PlayText,
    stages: &mut [Stage],
    fast: bool,
    limit: u32,
    asked: &AtomicBool,
) -> Run {
    let hz = plan.rate.hz();
    let motors = 0..plan.names.len() as u8;
    let pins = motors.flat_map(|axis| PINS.map(|(pin, level)| (axis, pin, level)));
    let mut edges = EdgeStore::new(hz, usize::MAX, pins);
    let since = (!fast).then(Instant::now);
    let hz = f64::from(hz);
    let mut follower =
        Follower { hz, since, asked, edges: edges.clone(), braking: false, ways: begun(plan) };
    // A request to end brakes the motors first.
    let voice = Silent(&AtomicBool::new(false));
    let (run, end) = {
        let player =
            CyclePlayer::new(plan, text, edges.clone(), PlayFormat::Silent, &voice, None, limit);
        let mut player = player.before(&mut follower);
        let error = player.play(stages).err();
        let (facts, braked) = (Some(player.json()), player.braked());
        let (seconds, late) = (player.seconds(), player.late());
        (Run { facts, braked, error, seconds, late, ..Run::default() }, player.now())
    };
    edges.pass(end, &[]);
    let pins = Some(edges.record(end as f64, 0.0));
    Run { names: plan.names.clone(), unit: plan.unit.clone(), ways: follower.ways, pins, ..run }
}

fn on_board(
    plan: &CyclePlan,
    text: &PlayText,
    stages: &mut [Stage],
    (port, baud): (&Path, u32),
    limit: u32,
    asked: &AtomicBool,
) -> PyResult<Run> {
    let name = port.display().to_string();
    let cant = |why: &dyn Display| PyConnectionError::new_err(format!("{name}: {why}"));
    let link = SerialLink::open(port, baud, Share::Alone, |_| LeaseWait::Over);
    let link = link.map_err(|why| cant(&why))?;
    let flash = "flash the program: `stepwright flash uno --program cycles` (or mega)";
    let board = CycleSession::on(Box::new(link)).map_err(|problem| match problem {
        RowProblem::OtherProgram(about) => {
            cant(&format_args!("it runs another program ({about}); {flash}"))
        }
        RowProblem::Lost(LinkError::Silent) => cant(&format_args!("it does not answer; {flash}")),
        problem => cant(&problem),
    })?;
    let voice = Silent(asked);
    let mut ways = begun(plan);
    let hz = f64::from(plan.rate.hz());
    let mut look = |ticks: u64, positions: &[i64]| {
        for (way, place) in ways.iter_mut().zip(positions) {
            way.see(ticks as f64 / hz, *place as f64);
        }
    };
    let mut player = CyclesOnBoard::new(board, plan, text, PlayFormat::Silent, &voice, limit);
    player.watch_by(&mut look);
    let error = player.play(stages).err();
    let (seconds, late, facts) = (player.seconds(), player.late(), Some(player.json()));
    let braked = asked.load(Ordering::Relaxed);
    drop(player);
    let (names, unit) = (plan.names.clone(), plan.unit.clone());
    Ok(Run { names, unit, seconds, late, facts, error, braked, ways, ..Run::default() })
}
