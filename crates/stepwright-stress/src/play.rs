//! Plays a story on a board that is visible only from outside.

use std::collections::VecDeque;
use stepwright::Rate;
use stepwright::timer::Count;

use stepwright_sim::{
    Description, EMPTY, Edge, Mark, Queues, Recorder, Remains, Reset as Cause, VirtualBoard,
};

use crate::fault::{Fault, Rule, Rules};
use crate::judge::{Enable, Judge};
use crate::story::{Act, Board, Input, Reset, Story};
use crate::track::Goal;

/// A board seen from outside: its line, its pins, its clock.
pub trait Bench {
    /// Ticks since the first power-up.
    fn now(&self) -> u64;
    /// Lets time pass until this tick.
    fn pass(&mut self, until: u64);
    /// Sends a byte. It is complete on the line when this returns.
    fn send(&mut self, byte: u8);
    /// The next byte from the board, and the time at which it began.
    fn heard(&mut self) -> Option<(u64, u8)>;
    /// Takes the edges since the last call in the order of time.
    fn edges(&mut self, into: &mut Vec<Edge>);
    /// The level of the drivers' enable pin, and the time of its last change.
    fn enable(&mut self) -> (bool, u64);
    /// Sets the level of a switch's pin.
    fn switch(&mut self, axis: u8, high: bool);
    /// Sets the level of a stop input, if the board has it.
    fn input(&mut self, input: Input, high: bool);
    /// The most ticks until an answer begins or continues: `$` has some 500 bytes.
    fn patience(&self) -> u64;
}

/// The sums of one or more stories.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sum {
    /// The number of stories.
    pub stories: u64,
    /// Damaged bytes.
    pub noise: u64,
    /// Answered lines.
    pub lines: u64,
    /// Steps on all pins.
    pub steps: u64,
    /// Simulated time in µs.
    pub micros: u64,
}

impl Sum {
    /// The sum of both.
    pub fn plus(self, other: Sum) -> Sum {
        Sum {
            stories: self.stories + other.stories,
            noise: self.noise + other.noise,
            lines: self.lines + other.lines,
            steps: self.steps + other.steps,
            micros: self.micros + other.micros,
        }
    }
}

/// A story while it is played.
pub struct Player<'s> {
    story: &'s Story,
    judge: Judge,
    at: usize,
    edges: Vec<Edge>,
}

/// The longest wait for the end of a travel, in µs.
const LONGEST: u64 = 2_000_000;

impl<'s> Player<'s> {
    /// A player at the beginning of the story.
    pub fn new(story: &'s Story, rules: Rules) -> Player<'s> {
        Player { story, judge: Judge::new(&story.board, rules), at: 0, edges: Vec::new() }
    }

    /// Plays to the next reset, which the caller has to make, or to the end.
    ///
    /// # Errors
    /// The first broken rule.
    pub fn play(&mut self, bench: &mut impl Bench) -> Result<Option<Reset>, Fault> {
        if self.judge.is_unsure() {
            self.ask(bench, "$")?;
        }
        while let Some(act) = self.story.acts.get(self.at) {
            self.at += 1;
            match act {
                Act::Send(bytes) => {
                    bytes.iter().try_for_each(|&byte| self.send(bench, byte).map(drop))?;
                }
                Act::Wait(micros) => self.wait(bench, (*micros).into())?,
                Act::Rest => self.rest(bench, LONGEST)?,
                Act::Switch(axis, high) => {
                    self.judge.switch(*axis, *high, bench.now())?;
                    bench.switch(*axis, *high);
                }
                Act::Input(input, high) => {
                    self.judge.input(*input, *high, bench.now())?;
                    bench.input(*input, *high);
                }
                Act::Reset(reset) => {
                    self.look(bench, u64::MAX)?;
                    self.judge.reset(*reset, bench.now())?;
                    self.edges.clear();
                    return Ok(Some(*reset));
                }
            }
        }
        self.end(bench)?;
        Ok(None)
    }

    /// The sum so far.
    pub fn sum(&self, bench: &impl Bench) -> Sum {
        Sum {
            stories: 1,
            noise: self.story.noise.into(),
            lines: self.judge.lines,
            steps: self.judge.tracks.iter().map(|track| track.steps).sum(),
            micros: (bench.now() as u128 * 1_000_000 / u128::from(self.story.board.hz)) as u64,
        }
    }

    fn wait(&mut self, bench: &mut impl Bench, micros: u64) -> Result<(), Fault> {
        bench.pass(bench.now() + self.story.board.ticks_wide(micros));
        self.look(bench, u64::MAX)
    }

    /// Judges the edges up to this time.
    fn look(&mut self, bench: &mut impl Bench, until: u64) -> Result<(), Fault> {
        bench.edges(&mut self.edges);
        let count = self.edges.partition_point(|edge| edge.time <= until);
        self.edges.drain(..count).try_for_each(|edge| self.judge.edge(edge))
    }

    /// Sends a byte and waits for the answer if one is due.
    fn send(&mut self, bench: &mut impl Bench, byte: u8) -> Result<Vec<u8>, Fault> {
        let mut answer = Vec::new();
        let (enabled, _) = bench.enable();
        bench.send(byte);
        let sent = bench.now();
        self.look(bench, sent)?;
        if byte != b'\r'
            && let Some((now, byte)) = bench.heard()
        {
            let what = || format!("the board says {:?} unasked", char::from(byte));
            self.judge.measure().rules.broken(Rule::Answer, now, what)?;
        }
        if !self.judge.byte(byte, sent)? {
            return Ok(answer);
        }
        let (mut begun, mut ended) = (None, sent);
        loop {
            while let Some((at, byte)) = bench.heard() {
                (begun, ended) = (begun.or(Some(at)), at);
                answer.push(byte);
            }
            if answer.last() == Some(&b'\r') || bench.now() > ended + bench.patience() {
                break;
            }
            bench.pass(bench.now() + self.story.board.ticks(50));
        }
        let whole = answer.pop() == Some(b'\r') && !answer.contains(&b'\r');
        let begun = begun.unwrap_or(bench.now());
        // An axis may step before the answer to its order begins, while the board plans another axis.
        bench.edges(&mut self.edges);
        let first = self.edges.iter().find(|edge| edge.is_step() && self.judge.rests(edge.axis));
        let begun = first.map_or(begun, |first| begun.min(first.time - 1));
        self.look(bench, begun)?;
        let enable = Enable { before: enabled, since: bench.enable().1 };
        self.judge.answer(whole.then_some(&answer), (begun, ended), enable)?;
        Ok(answer)
    }

    fn ask(&mut self, bench: &mut impl Bench, line: &str) -> Result<Vec<u8>, Fault> {
        let mut answer = Vec::new();
        for byte in line.bytes().chain([b'\r']) {
            answer = self.send(bench, byte)?;
        }
        Ok(answer)
    }

    /// Sends F until the answer is R, for at most this many µs.
    fn rest(&mut self, bench: &mut impl Bench, most: u64) -> Result<(), Fault> {
        let (mut waited, mut wait) = (0, 500);
        while waited < most && self.ask(bench, "F")? != b"R" {
            self.wait(bench, wait)?;
            waited += wait;
            wait = (wait * 3 / 2).min(50_000);
        }
        Ok(())
    }

    /// Brakes all axes and checks the final state.
    fn end(&mut self, bench: &mut impl Bench) -> Result<(), Fault> {
        for line in ["", "A0", "Z"] {
            self.ask(bench, line)?;
        }
        let late = bench.now() + self.story.board.ticks_wide(LONGEST);
        let far = |goal: Goal| matches!(goal, Goal::Stop(by) if by > late);
        if !self.judge.tracks.iter().any(|track| far(track.goal)) {
            self.rest(bench, LONGEST)?;
        }
        if self.judge.tracks.iter().any(|track| track.goal != Goal::Rest) {
            self.ask(bench, "K")?;
        }
        self.wait(bench, 3000)?;
        for axis in 1..=self.story.board.axes {
            self.ask(bench, &format!("V{axis}"))?;
        }
        for line in ["?", "$"] {
            self.ask(bench, line)?;
        }
        self.look(bench, u64::MAX)
    }
}

/// Plays a story on the virtual board.
///
/// # Errors
/// The first broken rule.
pub fn simulate(story: &Story, rules: Rules) -> Result<Sum, Fault> {
    if story.board.wide {
        simulate_on::<u32>(story, rules)
    } else {
        simulate_on::<u16>(story, rules)
    }
}

fn simulate_on<C: Count>(story: &Story, rules: Rules) -> Result<Sum, Fault> {
    let mut player = Player::new(story, rules);
    let (mut base, mut switches, mut inputs) = (0, [true; 3], [true; 2]);
    let mut remains = Remains { eeprom: EMPTY, mark: Mark::NONE };
    let mut why = Reset::Power;
    loop {
        let mut queues = Queues::default();
        let board = Simulated::<C>::begin(&mut queues, &story.board, why, remains);
        let mut bench = Simulated {
            board,
            base,
            byte: story.board.byte.into(),
            since: base,
            switches,
            inputs,
            said: VecDeque::new(),
        };
        Input::ALL.into_iter().zip(inputs).for_each(|((input, _), high)| bench.input(input, high));
        (0..).zip(switches).for_each(|(axis, high)| bench.board.set_switch(axis, high));
        let Some(reset) = player.play(&mut bench)? else { return Ok(player.sum(&bench)) };
        (why, base, remains) = (reset, bench.now(), bench.board.remains());
        (switches, inputs) = (bench.switches, bench.inputs);
        if reset == Reset::Power {
            remains.mark = Mark::NONE;
        }
    }
}

/// The edges since the last call.
#[derive(Default)]
struct Taken(Vec<Edge>);

impl Recorder for Taken {
    fn edge(&mut self, edge: Edge) {
        self.0.push(edge);
    }
}

/// The virtual board seen from outside.
struct Simulated<'q, C: Count> {
    board: VirtualBoard<'q, C, Taken>,
    base: u64,
    byte: u64,
    /// The time of the last change of the enable pin.
    since: u64,
    switches: [bool; 3],
    inputs: [bool; 2],
    said: VecDeque<(u64, u8)>,
}

impl<'q, C: Count> Simulated<'q, C> {
    fn begin(
        queues: &'q mut Queues,
        board: &Board,
        reset: Reset,
        remains: Remains,
    ) -> VirtualBoard<'q, C, Taken> {
        let rate = Rate::from_hz(board.hz).expect("a story's board has a rate of its list");
        let description = match board.uno {
            true => Description::uno(),
            false => Description { axes: board.axes, ..Description::quick(rate, board.cost) },
        };
        let reset = match reset {
            Reset::Power | Reset::Blink => Cause::Power,
            Reset::Button => Cause::Other,
            Reset::Watchdog => Cause::Watchdog,
        };
        VirtualBoard::restarted(queues, description, Taken::default(), reset, remains)
    }
}

impl<C: Count> Bench for Simulated<'_, C> {
    fn now(&self) -> u64 {
        self.base + self.board.now()
    }

    fn pass(&mut self, until: u64) {
        self.board.run_until(until - self.base);
    }

    fn send(&mut self, byte: u8) {
        self.board.run_until(self.board.now() + self.byte);
        self.board.receive(byte);
        let now = self.now();
        self.said.extend(self.board.take_answers().into_iter().map(|byte| (now, byte)));
    }

    fn heard(&mut self) -> Option<(u64, u8)> {
        self.said.pop_front()
    }

    fn edges(&mut self, into: &mut Vec<Edge>) {
        let base = self.base;
        into.extend(
            self.board.recorder().0.drain(..).map(|edge| Edge { time: base + edge.time, ..edge }),
        );
    }

    fn enable(&mut self) -> (bool, u64) {
        let changes = self.board.take_enable_changes();
        if let Some(&(time, _)) = changes.last() {
            self.since = self.base + time;
        }
        (self.board.enable_level(), self.since)
    }

    fn switch(&mut self, axis: u8, high: bool) {
        self.board.set_switch(axis, high);
        if let Some(level) = self.switches.get_mut(usize::from(axis)) {
            *level = high;
        }
    }

    fn input(&mut self, input: Input, high: bool) {
        match input {
            Input::Emergency => self.board.set_emergency(high),
            Input::Driver => self.board.set_driver_fault(high),
        }
        self.inputs[usize::from(input == Input::Driver)] = high;
    }

    fn patience(&self) -> u64 {
        0
    }
}
