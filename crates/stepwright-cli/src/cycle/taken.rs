//! Recordings of cycles while they are played.

use stepwright::Rate;
use stepwright_sim::{Edge, Pin, Recorder, Shaft};

use crate::board::edge_files::{EdgeFiles, EdgePaths};
use crate::failure::Failure;
use crate::plot;
use crate::say;
use stepwright_cyclefile::CyclePlan;
use stepwright_play::cycle::PlayTape;
use stepwright_play::gcode::Lit;
use stepwright_plot::{MotionPlot, PlotFile, Traces};

/// The requested recordings.
#[derive(Default)]
pub struct Wanted<'a> {
    pub inverted: u8,
    pub edges: EdgePaths<'a>,
    pub motions: bool,
    pub events: bool,
}

/// The recordings so far.
pub struct Taken {
    rate: Rate,
    files: EdgeFiles,
    traces: Option<Traces>,
    shafts: Vec<Shaft>,
    /// Motors for which DIR low is forward, as bits.
    inverted: u8,
    /// The edges since the last fetch.
    events: Option<Vec<Edge>>,
    /// With a laser: edges that wait until its power up to their time is known.
    held: Option<Vec<Edge>>,
}

/// The pins of a motor, and their levels before the first edge.
const PINS: [(Pin, Option<bool>); 5] = [
    (Pin::Step, Some(false)),
    (Pin::Direction, None),
    (Pin::Enable, None),
    (Pin::Min, Some(false)),
    (Pin::Max, Some(false)),
];

impl Taken {
    /// Begins the requested recordings of this many motors.
    pub fn begin(rate: Rate, motors: u8, wanted: &Wanted) -> Result<Taken, Failure> {
        let pins = (0..motors).flat_map(|axis| PINS.map(|(pin, level)| (axis, pin, level)));
        let files = EdgeFiles::begin(wanted.edges, rate, &pins.collect::<Vec<_>>())?;
        let traces = wanted.motions.then(|| Traces::new(rate.hz()));
        let (inverted, events) = (wanted.inverted, wanted.events.then(Vec::new));
        let shafts = vec![Shaft::default(); motors.into()];
        let held = wanted.edges.laser.then(Vec::new);
        Ok(Taken { rate, files, traces, shafts, inverted, events, held })
    }

    /// Writes the edges so far, with the changes of the laser's power between them.
    pub fn write_laser(&mut self, lit: &[Lit]) {
        let Some(held) = &mut self.held else { return };
        let mut lit = lit.iter().peekable();
        for edge in held.drain(..) {
            while let Some(change) = lit.next_if(|change| change.time <= edge.time) {
                self.files.laser(change.time, change.power);
            }
            self.files.edge(edge);
        }
        lit.for_each(|change| self.files.laser(change.time, change.power));
    }

    /// Finishes the edge files.
    pub fn finish(&mut self, seconds: f64) -> Result<(), Failure> {
        let time = (seconds * f64::from(self.rate.hz())).round() as u64;
        for path in self.files.finish(time)? {
            say::note(format_args!("edges written to {}", path.display()));
        }
        Ok(())
    }

    /// Draws the motion of the motors in this many seconds.
    pub fn plot(
        &self,
        file: &PlotFile,
        title: &str,
        plan: &CyclePlan,
        seconds: f64,
    ) -> Result<(), Failure> {
        let Some(traces) = &self.traces else { return Ok(()) };
        let mut series = traces.series(0);
        for series in &mut series {
            // Replaces `axis 1` by the motor's name.
            let number = series.name.rsplit(' ').next().and_then(|n| n.parse::<usize>().ok());
            if let Some(name) = number.and_then(|n| plan.names.get(n - 1)) {
                series.name.clone_from(name);
            }
            // The motor is at rest before its first step and after its last.
            let last = series.position.last().map_or(0.0, |(_, position)| *position);
            series.position.insert(0, (0.0, 0.0));
            series.position.push((seconds, last));
        }
        if series.is_empty() {
            say::note("nothing has moved: there is nothing to plot");
            return Ok(());
        }
        let what = "A speed is one step over the time between two; where that is more than 5 times \
                    the one before, the motor is drawn at rest.";
        let notes = vec![what.to_owned()];
        let title = title.to_owned();
        let plot = MotionPlot { title, notes, series, stacked: true, ..MotionPlot::default() };
        plot::save(file, &plot.figure())
    }
}

impl PlayTape for Taken {
    fn fetch(&mut self) -> Vec<Edge> {
        self.events.as_mut().map(std::mem::take).unwrap_or_default()
    }
}

impl Recorder for Taken {
    fn edge(&mut self, edge: Edge) {
        match &mut self.held {
            Some(held) => held.push(edge),
            None => self.files.edge(edge),
        }
        // The level as seen by the motor, for which forward may be DIR low.
        let turned = edge.pin == Pin::Direction && self.inverted >> edge.axis & 1 != 0;
        let seen = Edge { level: edge.level != turned, ..edge };
        if let Some(shaft) = self.shafts.get_mut(usize::from(edge.axis))
            && let Some(forward) = shaft.follow(seen)
        {
            self.files.step(edge.axis, edge.time, forward);
        }
        if let Some(traces) = &mut self.traces {
            match seen.pin {
                Pin::Direction => traces.direction(seen.axis, seen.level),
                Pin::Step if seen.level => traces.pulse(seen.axis, seen.time),
                _ => {}
            }
        }
        if let Some(events) = &mut self.events {
            events.push(edge);
        }
    }
}
