//! A virtual board of either timer width, with any of the programs, limit switches and a recorder.

use std::io;

use stepwright::Axis;
use stepwright::timer::Count;
use stepwright_sim::{
    AXES, Description, Edge, LawBoard, Queues, Recorder, Shaft, StreamBoard, Switch, Switched,
    VirtualBoard, run_switched,
};

use super::simulated::Simulated;

/// A recorder of a board on a bench.
pub trait BenchRecorder: Recorder {
    /// Time has passed to this tick. `enables` are the changes of the enable pin meanwhile: times and
    /// levels.
    fn pass(&mut self, now: u64, enables: &[(u64, bool)]) {
        let _ = (now, enables);
    }

    /// Ends the recording at this tick.
    ///
    /// # Errors
    /// The recording can't be written.
    fn finish(&mut self, now: u64) -> io::Result<()> {
        let _ = now;
        Ok(())
    }
}

impl BenchRecorder for () {}

/// The shafts of the motors, which move switches.
struct Shafts([Shaft; AXES]);

impl Shafts {
    fn of(description: &Description) -> Shafts {
        let mut shafts = [Shaft::default(); AXES];
        for (axis, shaft) in (0..).zip(&mut shafts) {
            *shaft = Shaft::of(description, axis);
        }
        Shafts(shafts)
    }
}

impl Recorder for Shafts {
    fn edge(&mut self, edge: Edge) {
        if let Some(shaft) = self.0.get_mut(usize::from(edge.axis)) {
            shaft.follow(edge);
        }
    }
}

/// Width of a board's step timer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimerWidth {
    /// 16 bits, as on an Uno.
    Narrow,
    /// 32 bits, as on most 32-bit chips.
    Wide,
}

/// The functions of a virtual board that do not depend on its timer width and program.
trait Board<R> {
    fn now(&self) -> u64;
    fn receive(&mut self, byte: u8);
    fn take_answers(&mut self) -> Vec<u8>;
    fn run_until(&mut self, time: u64);
    fn is_busy(&mut self) -> bool;
    /// Whether an axis moves. A board that does not distinguish its axes answers for all of them.
    fn is_moving(&mut self, _axis: u8) -> bool {
        self.is_busy()
    }
    fn is_endless(&self) -> bool {
        false
    }
    fn position(&mut self, axis: u8) -> Option<i64>;
    fn late(&mut self) -> u32 {
        0
    }
    /// Brakes all axes.
    fn stop(&mut self) {
        b"Z\r".iter().for_each(|byte| self.receive(*byte));
    }
    fn set_switch(&mut self, _axis: u8, _high: bool) {}
    fn take_enable_changes(&mut self) -> Vec<(u64, bool)> {
        Vec::new()
    }
    fn recorder(&mut self) -> &mut (Shafts, R);
}

impl<C: Count, R: Recorder> Board<R> for VirtualBoard<'static, C, (Shafts, R)> {
    fn now(&self) -> u64 {
        VirtualBoard::now(self)
    }
    fn receive(&mut self, byte: u8) {
        VirtualBoard::receive(self, byte);
    }
    fn take_answers(&mut self) -> Vec<u8> {
        VirtualBoard::take_answers(self)
    }
    fn run_until(&mut self, time: u64) {
        VirtualBoard::run_until(self, time);
    }
    fn is_busy(&mut self) -> bool {
        VirtualBoard::is_busy(self)
    }
    fn is_moving(&mut self, axis: u8) -> bool {
        Axis::new(axis.into()).is_ok_and(|axis| self.motors().is_moving(axis))
    }
    fn is_endless(&self) -> bool {
        VirtualBoard::is_endless(self)
    }
    fn position(&mut self, axis: u8) -> Option<i64> {
        VirtualBoard::position(self, axis)
    }
    fn late(&mut self) -> u32 {
        VirtualBoard::late(self)
    }
    fn stop(&mut self) {
        Axis::all().for_each(|axis| self.motors().stop(axis));
    }
    fn set_switch(&mut self, axis: u8, high: bool) {
        VirtualBoard::set_switch(self, axis, high);
    }
    fn take_enable_changes(&mut self) -> Vec<(u64, bool)> {
        VirtualBoard::take_enable_changes(self)
    }
    fn recorder(&mut self) -> &mut (Shafts, R) {
        self.recorder()
    }
}

/// The program `laws`: one motor, driven by a ramp law.
impl<R: Recorder> Board<R> for LawBoard<'static, (Shafts, R)> {
    fn now(&self) -> u64 {
        LawBoard::now(self)
    }
    fn receive(&mut self, byte: u8) {
        LawBoard::receive(self, byte);
    }
    fn take_answers(&mut self) -> Vec<u8> {
        LawBoard::take_answers(self)
    }
    fn run_until(&mut self, time: u64) {
        LawBoard::run_until(self, time);
    }
    fn is_busy(&mut self) -> bool {
        LawBoard::is_busy(self)
    }
    fn position(&mut self, axis: u8) -> Option<i64> {
        if axis == 0 { LawBoard::position(self, axis) } else { Some(0) }
    }
    fn recorder(&mut self) -> &mut (Shafts, R) {
        self.recorder()
    }
}

impl<R> Switched for dyn Board<R> {
    fn now(&self) -> u64 {
        Board::now(self)
    }
    fn run_until(&mut self, time: u64) {
        Board::run_until(self, time);
    }
    fn shaft(&mut self, axis: u8) -> i64 {
        self.recorder().0.0.get(usize::from(axis)).map_or(0, Shaft::position)
    }
    fn set_switch(&mut self, axis: u8, high: bool) {
        Board::set_switch(self, axis, high);
    }
}

/// The program `stream`: motion streamed by a host.
impl<R: Recorder> Board<R> for StreamBoard<'static, (Shafts, R)> {
    fn now(&self) -> u64 {
        StreamBoard::now(self)
    }
    fn receive(&mut self, byte: u8) {
        StreamBoard::receive(self, &[byte]);
    }
    fn take_answers(&mut self) -> Vec<u8> {
        StreamBoard::take_answers(self)
    }
    fn run_until(&mut self, time: u64) {
        StreamBoard::run_until(self, time);
    }
    fn is_busy(&mut self) -> bool {
        StreamBoard::is_busy(self)
    }
    fn position(&mut self, axis: u8) -> Option<i64> {
        StreamBoard::position(self, axis)
    }
    fn late(&mut self) -> u32 {
        StreamBoard::late(self)
    }
    fn set_switch(&mut self, axis: u8, high: bool) {
        self.set_input(axis, !high);
    }
    fn recorder(&mut self) -> &mut (Shafts, R) {
        self.recorder()
    }
}

/// A virtual board that is switched on. The memory of its queues is never freed.
pub struct Bench<R> {
    board: Box<dyn Board<R>>,
    description: Description,
    /// Axes whose position was at some time not 0, or unknown.
    moved: [bool; AXES],
    switches: Vec<Switch>,
}

fn queues() -> &'static mut Queues {
    Box::leak(Box::default())
}

impl<R: BenchRecorder + 'static> Bench<R> {
    /// Switches on a controller.
    pub fn new(description: Description, width: TimerWidth, recorder: R) -> Bench<R> {
        let recorder = (Shafts::of(&description), recorder);
        let board: Box<dyn Board<R>> = match width {
            TimerWidth::Narrow => {
                Box::new(VirtualBoard::<u16, _>::new(queues(), description, recorder))
            }
            TimerWidth::Wide => {
                Box::new(VirtualBoard::<u32, _>::new(queues(), description, recorder))
            }
        };
        Bench::of(board, description)
    }

    /// Switches on a board with the program `laws`.
    pub fn laws(description: Description, recorder: R) -> Bench<R> {
        let recorder = (Shafts::of(&description), recorder);
        Bench::of(Box::new(LawBoard::new(queues(), description, recorder)), description)
    }

    /// Switches on a board with the program `stream`.
    pub fn stream(description: Description, recorder: R) -> Bench<R> {
        let recorder = (Shafts::of(&description), recorder);
        Bench::of(Box::new(StreamBoard::new(queues(), description, recorder)), description)
    }

    fn of(board: Box<dyn Board<R>>, description: Description) -> Bench<R> {
        Bench { board, description, moved: [false; AXES], switches: Vec::new() }
    }

    /// Adds limit switches.
    pub fn with_switches(mut self, switches: &[Switch]) -> Bench<R> {
        self.switches = switches.to_vec();
        self
    }

    fn notice(&mut self) {
        for (axis, moved) in (0..).zip(&mut self.moved) {
            *moved |= self.board.position(axis) != Some(0);
        }
    }

    /// Whether any axis moves.
    pub fn is_busy(&mut self) -> bool {
        self.board.is_busy()
    }

    /// Whether any axis moves until it is stopped.
    pub fn is_endless(&self) -> bool {
        self.board.is_endless()
    }

    /// Brakes all axes, as the stop button would.
    pub fn stop(&mut self) {
        self.board.stop();
    }

    /// The positions of the axes, a line each. Axes that never moved are left out, except axis 1,
    /// which is always the last line.
    pub fn report(&mut self) -> Vec<String> {
        self.notice();
        let late = self.board.late();
        let mut state = |axis: u8| match self.board.position(axis) {
            // An axis that still moves was interrupted.
            _ if self.board.is_moving(axis) => "position uncertain".to_owned(),
            Some(steps) => format!("position {steps} ready"),
            None => "position uncertain".to_owned(),
        };
        let others = (1..self.description.axes).filter(|axis| self.moved[usize::from(*axis)]);
        let mut lines: Vec<String> =
            others.map(|axis| format!("axis {} {}", axis + 1, state(axis))).collect();
        if late > 0 {
            lines.insert(0, format!("late steps: {late}"));
        }
        lines.push(state(0));
        lines
    }
}

impl<R: BenchRecorder + 'static> Simulated for Bench<R> {
    fn hz(&self) -> u32 {
        self.description.board.rate.hz()
    }

    fn byte_time(&self) -> u64 {
        self.description.byte_time()
    }

    fn now(&self) -> u64 {
        self.board.now()
    }

    fn run_until(&mut self, time: u64) {
        let rate = self.description.board.rate;
        run_switched(&mut *self.board, &self.switches, rate, time);
        let (now, enables) = (self.board.now(), self.board.take_enable_changes());
        self.board.recorder().1.pass(now, &enables);
        if self.board.is_busy() {
            self.notice();
        }
    }

    fn receive(&mut self, byte: u8) {
        self.board.receive(byte);
    }

    fn take_answers(&mut self) -> Vec<u8> {
        self.board.take_answers()
    }

    fn finish(&mut self) -> io::Result<()> {
        let now = self.board.now();
        self.board.recorder().1.finish(now)
    }
}
