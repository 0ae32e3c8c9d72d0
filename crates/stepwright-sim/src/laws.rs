//! A motor that moves by one of Austin's laws, on simulated pins: the program `laws` of a chip.

use stepwright::timer::Count;
use stepwright::{Engine, Ticks};
use stepwright_austin::Station;
use stepwright_austin::line::LONGEST;
use stepwright_austin::station::{About, Costs};
use stepwright_protocol::flash_text;

use crate::board::{Queues, RUNS, Shared};
use crate::clock::SimTimer;
use crate::description::Description;
use crate::edge::Recorder;
use crate::pins::Pins;
use crate::program::{ProgramBoard, SimProgram};
use crate::steppers::SimEngine;

/// A board that takes the rows of `stepwright_austin::line`, and moves its first axis.
///
/// ```
/// use stepwright_sim::{Description, Edge, LawBoard, Queues};
/// let mut queues = Queues::default();
/// let mut board: LawBoard<Vec<Edge>> =
///     LawBoard::new(&mut queues, Description::uno(), Vec::new());
/// for byte in *b":F50000,2500\r:G10\r" {
///     board.receive(byte);
/// }
/// assert_eq!(board.take_answers(), b"Y\rY\r");
/// board.run_until(16_000_000);
/// let steps: Vec<u64> =
///     board.recorder().iter().filter(|edge| edge.is_step()).map(|edge| edge.time).collect();
/// assert_eq!((steps.len(), steps[1] - steps[0], steps[2] - steps[1]), (10, 800_000, 480_000));
/// ```
pub type LawBoard<'q, R, C = u16> = ProgramBoard<Station<'q, SimEngine<'q, R, C>, RUNS>, LONGEST>;

impl<'q, R: Recorder, C: Count> LawBoard<'q, R, C> {
    /// Switches a new board on.
    pub fn new(queues: &'q mut Queues, description: Description, recorder: R) -> Self {
        let board = description.board;
        let Shared { ends: [x, y, z], now, reverse } = queues.lend(&description);
        let mut pins = Pins::new(now, reverse, &description.coils, recorder);
        pins.face();
        let timer = SimTimer::on_grid(now, description.grid);
        let engine = Engine::new(timer, pins, [x.1, y.1, z.1], board.timing, board.rate);
        let mhz = board.rate.hz() / 1_000_000;
        let about = About { name: flash_text!("virtual"), mhz, costs: Costs::AVR };
        let station = Station::new(SimEngine::new(now, engine), x.0, about);
        ProgramBoard::of(station, board.rate.micros(50).into())
    }

    /// The recorder.
    pub fn recorder(&mut self) -> &mut R {
        self.program().engine().recorder()
    }
}

impl<R: Recorder, C: Count> SimProgram for Station<'_, SimEngine<'_, R, C>, RUNS> {
    fn pass_until(&mut self, time: u64) -> u64 {
        let engine = self.engine();
        engine.pass(time.saturating_sub(engine.now()) as Ticks);
        engine.now()
    }
}
