//! Runs a job on the virtual board, which has the timer and the step costs of an Uno.

use stepwright::{Rate, Ticks};
use stepwright_path::AxisPace;
use stepwright_plan::gcode::JobPlan;
use stepwright_play::cycle::PlayTape;
use stepwright_play::gcode::{BegunJob, GcodeBoard, Lit, NAMES, begin};
use stepwright_play::micros;
use stepwright_play::stream::{PlayEnd, Streamed};
use stepwright_plot::SpeedWay;
use stepwright_sim::{Edge, Pin};

use super::terminal::Terminal;
use crate::board::edge_files::EdgePaths;
use crate::cycle::taken::{self, Taken};
use crate::failure::Failure;
use crate::say;

/// The requested outputs of a run.
pub struct Wanted<'a> {
    pub csv: bool,
    pub fast: bool,
    pub edges: EdgePaths<'a>,
    pub way: bool,
}

/// The result of a run.
pub struct Played {
    pub ran: Streamed,
    pub rate: Rate,
    /// Ticks from the start of the run to that of the path, and from there to its end.
    pub lead: Ticks,
    pub ticks: u64,
    pub way: Option<SpeedWay>,
}

/// Points of a picture are at least 1/1200 of its longer side apart.
const FINE: f64 = 1_200.0;

/// A speed is measured from the present again after this many seconds without a step.
const REST: f64 = 0.05;

/// Plays a job that has been planned and admitted.
pub fn play(
    job: Vec<u8>,
    axes: [AxisPace; 3],
    plan: &JobPlan,
    wanted: &Wanted,
) -> Result<Played, Failure> {
    let recorded =
        taken::Wanted { inverted: 0, edges: wanted.edges, motions: false, events: wanted.csv };
    let taken = |rate| Taken::begin(rate, 3, &recorded);
    begin(job, axes, plan, taken, |begun| follow(begun, axes, plan, wanted))
}

/// Follows a run to its end, with the requested outputs.
fn follow(
    mut job: BegunJob<Taken>,
    axes: [AxisPace; 3],
    plan: &JobPlan,
    wanted: &Wanted,
) -> Result<Played, Failure> {
    let mut rows = wanted.csv.then(|| Rows::begin(plan.laser.is_some(), job.rate));
    let rate = job.rate;
    let hz = f64::from(rate.hz());
    // The power of a laser at the present.
    let mut power = plan.laser.map(|_| 0.0);
    let mut drawn = wanted.way.then(|| Drawn::new(plan, &axes));
    let end = job.play(wanted.fast, &mut Terminal::new(plan), |board, lit| {
        if let Some(rows) = &mut rows {
            rows.print(board, lit);
        }
        if let Some(drawn) = &mut drawn {
            let cycle = board.cycle();
            let at = [0, 1].map(|axis| cycle.position(axis).unwrap_or(0));
            drawn.see(board.now() as f64 / hz, at, power);
        }
        if let Some(power) = &mut power {
            board.with_recorder(|taken| taken.write_laser(lit));
            *power = lit.last().map_or(*power, |change| change.power);
        }
    })?;
    if end == PlayEnd::Killed {
        return Err(Failure::interrupted("killed: the positions are lost"));
    }
    let still = (plan.time * hz).round() as u64;
    let ticks = if job.board.now() > job.path { job.passed() } else { still };
    let (position, late) = (job.positions(), job.board.cycle().late());
    let over = job.board.now() as f64 / hz;
    job.board.with_recorder(|taken| taken.finish(over))?;
    let ran = Streamed {
        position: position.map(Some),
        late: late.into(),
        seconds: ticks as f64 / hz,
        braked: end == PlayEnd::Stopped,
        again: 0,
    };
    Ok(Played { ran, rate, lead: job.lead, ticks, way: drawn.map(Drawn::end) })
}

/// Prints events as rows of CSV.
struct Rows {
    rate: Rate,
    /// The power of a laser.
    power: Option<f64>,
}

impl Rows {
    fn begin(laser: bool, rate: Rate) -> Rows {
        let columns = "time_us,axis,event,value,position";
        say::result(if laser { format!("{columns},power") } else { columns.to_owned() });
        Rows { rate, power: laser.then_some(0.0) }
    }

    /// Prints the edges since the last call, and the changes of the laser's power.
    fn print(&mut self, board: &mut GcodeBoard<Taken>, lit: &[Lit]) {
        let mut lit = lit.iter().peekable();
        for Edge { time, axis, pin, level } in board.with_recorder(Taken::fetch) {
            while let Some(change) = lit.next_if(|change| change.time <= time) {
                self.light(change);
            }
            let (event, value) = match pin {
                Pin::Step => ("step", level),
                Pin::Direction => ("dir", level),
                // A low level turns a driver on.
                Pin::Enable => ("enable", !level),
                Pin::Coil(_) | Pin::Min | Pin::Max => continue,
            };
            let name = NAMES.get(usize::from(axis)).copied().unwrap_or("?");
            let position = board.cycle().position(axis).unwrap_or(0);
            let time = micros(time, self.rate);
            let power = self.power.map_or(String::new(), |power| format!(",{power:.4}"));
            let value = u8::from(value);
            say::result(format_args!("{time},{name},{event},{value},{position}{power}"));
        }
        lit.for_each(|change| self.light(change));
    }

    fn light(&mut self, change: &Lit) {
        self.power = Some(change.power);
        let (time, power) = (micros(change.time, self.rate), change.power);
        say::result(format_args!("{time},laser,power,{power:.4},,{power:.4}"));
    }
}

/// The path of X and Y by the steps that were made, with the speed, or with the power of a laser in
/// percent. It is pale where the laser is off.
struct Drawn {
    way: SpeedWay,
    /// mm a step.
    steps: [f64; 2],
    /// The least distance of two points in mm.
    fine: f64,
    /// The last position and its time. `from` is the position and time at which the measurement of
    /// the speed begins.
    last: ([i64; 2], f64),
    from: ([f64; 2], f64),
    /// The power on the path to `last`.
    power: Option<f64>,
}

impl Drawn {
    fn new(plan: &JobPlan, axes: &[AxisPace; 3]) -> Drawn {
        let power = plan.laser.map(|_| 0.0);
        let mut way = SpeedWay::new(["X", "Y"], "mm", if power.is_some() { "%" } else { "mm/s" });
        way.go(0.0, 0.0, 0.0);
        let [x, y, _] = plan.survey.extents.0;
        // The span includes the start, 0.
        let span = [x, y].into_iter().flatten().map(|[from, to]| to.max(0.0) - from.min(0.0));
        let steps = [axes[0].step, axes[1].step];
        let fine = (span.fold(0.0, f64::max) / FINE).max(4.0 * steps[0].max(steps[1]));
        Drawn { way, steps, fine, last: ([0; 2], 0.0), from: ([0.0; 2], 0.0), power }
    }

    fn see(&mut self, time: f64, at: [i64; 2], power: Option<f64>) {
        if at == self.last.0 {
            return;
        }
        let steps = self.steps;
        let place = |at: [i64; 2]| [0, 1].map(|n| at[n] as f64 * steps[n]);
        let ends = self.power.is_some_and(|known| (known > 0.0) != (power > Some(0.0)));
        if ends {
            // The laser went on or off at the last step.
            let [x, y] = place(self.last.0);
            self.go(x, y, 0.0);
            self.from = ([x, y], self.last.1);
        }
        self.power = power;
        if time - self.last.1 > REST {
            // After a rest, the motion begins here.
            self.from = (place(at), time);
        }
        self.last = (at, time);
        let here = place(at);
        let way = (here[0] - self.from.0[0]).hypot(here[1] - self.from.0[1]);
        if way >= self.fine && time > self.from.1 {
            self.go(here[0], here[1], way / (time - self.from.1));
            self.from = (here, time);
        }
    }

    fn go(&mut self, x: f64, y: f64, speed: f64) {
        match self.power {
            Some(power) if power > 0.0 => self.way.go(x, y, power * 100.0),
            Some(_) => self.way.go_pale(x, y),
            None => self.way.go(x, y, speed),
        }
    }

    /// Returns the path up to its last step.
    fn end(mut self) -> SpeedWay {
        let [x, y] = [0, 1].map(|n| self.last.0[n] as f64 * self.steps[n]);
        self.go(x, y, 0.0);
        self.way
    }
}
