//! The common part of the tests of streams on different chips: the virtual board that plays the
//! same frames.

use stepwright_controller::StreamBoard as Player;
use stepwright_feeder::FeedTerms;
use stepwright_sim::{Description, Edge, Queues, StreamBoard};
use stepwright_stream::brake::BrakeLaw;

use crate::feed::{self, Job, Line, Step, Target, run};

/// The virtual board at a chip's rate, in 2⁻⁴ µs.
struct Scaled<'q> {
    board: StreamBoard<'q, Vec<Edge>, u32>,
    /// The ticks of a unit.
    unit: f64,
    edges: Vec<Edge>,
}

impl Target for Scaled<'_> {
    fn run_until(&mut self, cycle: u64) {
        self.board.run_until((cycle as f64 * self.unit) as u64);
    }
    fn receive(&mut self, byte: u8) {
        self.board.receive(&[byte]);
    }
    fn said(&mut self) -> Vec<u8> {
        self.board.take_answers()
    }
    fn edges(&mut self) -> &[Edge] {
        let unit = self.unit;
        let new = self.board.recorder().iter().skip(self.edges.len());
        self.edges.extend(new.map(|edge| Edge { time: (edge.time as f64 / unit) as u64, ..*edge }));
        &self.edges
    }
}

/// The terms of a player, with these decelerations in steps/s².
pub fn terms(player: Player, decels: [f64; 3]) -> FeedTerms {
    let hz = player.rate.hz();
    let brakes = decels.map(|a| BrakeLaw::of((a * 1e3) as u64, hz).unwrap());
    // A visit of their interrupt makes the steps of all axes at once.
    FeedTerms { hz, shortest: player.least, stagger: 0, ..FeedTerms::avr(brakes) }
}

/// The largest distance of an edge from the virtual board's, in µs.
pub fn apart(of: Description, edges: &[Edge], job: &[Vec<Step>; 3], terms: FeedTerms) -> f64 {
    let mut queues = Queues::default();
    let unit = f64::from(terms.hz) / feed::HZ;
    let ideal = StreamBoard::new(&mut queues, of, Vec::new());
    let mut ideal = Scaled { board: ideal, unit, edges: Vec::new() };
    run(&mut ideal, Job::new(job.clone()), terms, Line::default());
    let apart = feed::apart(edges, ideal.edges());
    apart[apart.len() - 1].max(-apart[0])
}

/// A motion that turns all the time, at up to 7,000 steps/s if its size is 1.
pub fn organic(seconds: f64, size: f64) -> [Vec<Step>; 3] {
    let waves = [(400.0, 1.0), (150.0, 3.1), (30.0, 9.7)].map(|(wave, hz)| (size * wave, hz));
    [0.0, 1.9, 0.4]
        .map(|phase| feed::wander(seconds, &waves[..if phase == 0.4 { 1 } else { 3 }], phase))
}
