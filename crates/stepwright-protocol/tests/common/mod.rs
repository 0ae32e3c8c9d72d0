//! A machine for tests: it logs its calls and moves when told to.
#![allow(dead_code)] // // fuzz.rs uses a part of it

use std::fmt::Write as _;
use std::task::Poll;

use stepwright::profile::Ramp;
use stepwright::{Change, Order, Speed, Travel};
use stepwright_protocol::{
    AxisId, Command, Machine, Refusal, Reply, Setting, Settings, Slave, Stop,
};

/// One axis of the bench.
#[derive(Clone, Default)]
pub struct Axis {
    pub running: Option<Order>,
    pub position: i64,
    pub uncertain: bool,
}

/// A machine whose axes are busy until the test lets them arrive.
#[derive(Clone, Default)]
pub struct Bench {
    pub axes: Vec<Axis>,
    /// The reason with which the next start is refused.
    pub refuse: Option<Refusal>,
    pub late: u32,
    /// The axes whose switch is closed.
    pub closed: u8,
    pub settings: Settings,
    /// The settings at the last `set_up`.
    before: Settings,
    /// The number of calls that the next start takes.
    pub pieces: u32,
    /// The prepared orders.
    prepared: Vec<(AxisId, Order)>,
    /// Every requested start, including refused ones.
    pub asked: Vec<Vec<(AxisId, Order)>>,
    /// Every requested change of a travel in progress, in words, including refused ones.
    pub changes: Vec<String>,
    /// The calls since the log was last read, in words.
    pub log: String,
}

impl Bench {
    pub fn new(axes: usize) -> Bench {
        Bench { axes: vec![Axis::default(); axes], ..Bench::default() }
    }

    fn axis(&mut self, axis: AxisId) -> &mut Axis {
        &mut self.axes[axis.index()] // the slave never names another one
    }

    fn note(&mut self, text: &str) {
        if !self.log.is_empty() {
            self.log += "; ";
        }
        self.log += text;
    }

    /// A button of the machine itself is pressed: an idle axis starts.
    pub fn press(&mut self, index: usize) {
        let travel = Travel::Endless(true);
        let (up, down) = (Ramp::Steps(999), Ramp::Steps(999));
        let order = Order { start: Speed::ZERO, top: Speed::MAX, up, down, jerk: None, travel };
        self.axes[index].running.get_or_insert(order);
    }

    /// The axis reaches the end of its travel; an endless travel goes 1000.
    pub fn arrive(&mut self, index: usize) {
        let axis = &mut self.axes[index];
        axis.position += match axis.running.take().map(|order| order.travel) {
            Some(Travel::By(steps)) => steps.into(),
            Some(Travel::Endless(true)) => 1000,
            Some(Travel::Endless(false)) => -1000,
            None => 0,
        };
    }
}

impl Machine for Bench {
    fn axes(&self) -> u8 {
        self.axes.len() as u8
    }

    fn busy(&self, axis: AxisId) -> bool {
        self.axes[axis.index()].running.is_some()
    }

    fn prepare(&mut self, axis: AxisId, order: &Order) -> Result<(), Refusal> {
        if self.busy(axis) {
            return Err(Refusal::Busy);
        }
        assert!(self.prepared.iter().all(|(other, _)| *other != axis), "prepared twice");
        self.prepared.push((axis, *order));
        Ok(())
    }

    fn commit(&mut self) -> Poll<Result<(), Refusal>> {
        if self.pieces > 0 {
            self.pieces -= 1;
            return Poll::Pending;
        }
        let orders = self.prepared.clone();
        assert!(!orders.is_empty(), "started nothing");
        assert!(orders.is_sorted_by(|(a, _), (b, _)| a < b));
        self.asked.push(orders.clone());
        if let Some(refusal) = self.refuse.take() {
            return Poll::Ready(Err(refusal));
        }
        for (axis, order) in &orders {
            self.note(&format!("start {} {}", axis.number(), words(order)));
            assert!(!self.busy(*axis), "started while busy");
            let at_once = order.travel == Travel::By(0);
            self.axis(*axis).running = (!at_once).then_some(*order);
        }
        self.prepared.clear();
        Poll::Ready(Ok(()))
    }

    fn cancel(&mut self) {
        self.prepared.clear();
    }

    fn stop(&mut self, axis: AxisId) {
        self.note(&format!("stop {}", axis.number()));
    }

    fn change(&mut self, axes: u8, change: Change) -> Result<(), Refusal> {
        let all = (0..self.axes.len()).filter(|n| axes >> n & 1 != 0);
        let named: Vec<String> = all.clone().map(|n| (n + 1).to_string()).collect();
        let text = format!("change {}: {}", named.join(" "), change_in_words(change));
        self.changes.push(text.clone());
        assert_eq!(all.clone().count() as u32, axes.count_ones(), "an axis that is not there");
        assert!(
            axes != 0 && all.clone().all(|n| self.axes[n].running.is_some()),
            "at rest: {text}"
        );
        if let Some(refusal) = self.refuse.take() {
            return Err(refusal);
        }
        self.note(&text);
        for axis in all {
            let order = self.axes[axis].running.as_mut().unwrap();
            match change {
                Change::Target(steps) => order.travel = Travel::By(steps),
                Change::Top(top) => order.top = top,
                Change::Accel(a) => order.up = Ramp::Accel(a),
                Change::Decel(d) => order.down = Ramp::Accel(d),
            }
        }
        Ok(())
    }

    fn kill(&mut self) {
        self.note("kill");
        for axis in &mut self.axes {
            axis.uncertain |= axis.running.take().is_some();
        }
    }

    fn position(&self, axis: AxisId) -> Option<i64> {
        let axis = &self.axes[axis.index()];
        (!axis.uncertain).then_some(axis.position)
    }

    fn closed(&self) -> u8 {
        self.closed
    }

    fn zero(&mut self, axis: AxisId) {
        self.note(&format!("zero {}", axis.number()));
        assert!(!self.busy(axis), "zeroed while busy");
        *self.axis(axis) = Axis::default();
    }

    fn max_rate(&self) -> u32 {
        120_000
    }

    fn late(&self) -> u32 {
        self.late
    }

    fn clear_late(&mut self) {
        self.note("clear");
        self.late = 0;
    }

    fn lease(&mut self, millis: u16) -> Result<(), Refusal> {
        self.note(&format!("lease {millis}"));
        Ok(())
    }

    fn settings(&mut self) -> Option<&mut Settings> {
        Some(&mut self.settings)
    }

    fn set_up(&mut self) {
        for setting in Setting::ALL {
            let value = self.settings.get(setting);
            if value != self.before.get(setting) {
                self.note(&format!("{}={value}", setting.name()));
            }
        }
        assert!((0..self.axes.len()).all(|n| self.axes[n].running.is_none()), "set up while busy");
        assert_ne!(self.settings, self.before, "set up for nothing");
        self.before = self.settings;
    }
}

/// An order in words: `50-1000 R200 R200 +4000`.
pub fn words(order: &Order) -> String {
    let mut text = format!("{}-{}", order.start, order.top);
    for ramp in [order.up, order.down] {
        let _ = match ramp {
            Ramp::Steps(n) => write!(text, " R{n}"),
            Ramp::Accel(a) => write!(text, " {a}/s2"),
        };
    }
    if let Some(jerk) = order.jerk {
        let _ = write!(text, " {jerk}/s3");
    }
    let _ = match order.travel {
        Travel::By(steps) => write!(text, " {steps:+}"),
        Travel::Endless(true) => write!(text, " forward"),
        Travel::Endless(false) => write!(text, " backward"),
    };
    text
}

/// A change in words: `t500`, `@-20`.
pub fn change_in_words(change: Change) -> String {
    match change {
        Change::Target(steps) => format!("@{steps:+}"),
        Change::Top(top) => format!("t{top}"),
        Change::Accel(a) => format!("a{a}"),
        Change::Decel(d) => format!("d{d}"),
    }
}

/// Plays a table against a board of three axes, from power-up.
///
/// Each row is a line of the master, the slave's answer and, after `->`, the calls to the machine.
/// `""` is an empty line. A row that begins with `*` is an event of the machine: `*arrive 1`,
/// `*press 1`, `*refuse too-fast`, `*late 7`, `*closed 5`, `*switch 1`, `*silent 1`, `*emergency
/// 1`, or 0 at rest.
pub fn talk(table: &str) {
    let (mut slave, mut bench) = (Slave::<3>::new(), Bench::new(3));
    for (n, row) in table.lines().map(str::trim).enumerate().filter(|(_, row)| !row.is_empty()) {
        let (said, told) = row.split_once("->").unwrap_or((row, ""));
        let (line, answer) = said.trim().split_once(' ').expect("a line and its answer");
        let answer = answer.trim();
        match line {
            "*arrive" => bench.arrive(answer.parse::<usize>().unwrap() - 1),
            "*switch" | "*silent" => {
                let index = answer.parse::<usize>().unwrap() - 1;
                let reason = if line == "*switch" { Stop::Switch } else { Stop::Timeout };
                slave.stopped(1 << index, reason);
            }
            "*emergency" => {
                let axes = answer.parse::<u32>().unwrap();
                slave.stopped((1u8 << axes) >> 1, Stop::Emergency);
            }
            "*press" => bench.press(answer.parse::<usize>().unwrap() - 1),
            "*refuse" => bench.refuse = Some(Refusal::named(answer.as_bytes())),
            "*late" => bench.late = answer.parse().unwrap(),
            "*closed" => bench.closed = answer.parse().unwrap(),
            _ => {
                let line = line.replace("\"\"", "").replace("\\n", "\n").replace("\\0", "\0");
                let mut said = say(&mut slave, &mut bench, line.as_bytes());
                if line == "?" {
                    said = without_extras(&said, answer);
                }
                assert_eq!(said, answer, "row {n}: {row}");
            }
        }
        assert_eq!(std::mem::take(&mut bench.log), told.trim(), "row {n}: {row}");
    }
}

/// The answer to `?` without those of the words `stop`, `errors`, `can` and `closed` that
/// `expected` does not have.
fn without_extras(said: &str, expected: &str) -> String {
    let words = said.split(' ').filter(|word| {
        let extra = ["stop", "errors", "can", "closed"]
            .into_iter()
            .find(|name| word.starts_with(&format!("{name}=")));
        extra.is_none_or(|name| expected.contains(&format!(" {name}=")))
    });
    words.collect::<Vec<_>>().join(" ")
}

/// Sends a line and its CR, and returns the one answer without its CR.
pub fn say<const N: usize>(slave: &mut Slave<N>, bench: &mut Bench, line: &[u8]) -> String {
    for byte in line {
        slave.receive(*byte, bench);
        assert!(!slave.work(bench) && !slave.is_answering(), "an answer before the CR");
    }
    slave.receive(b'\r', bench);
    while slave.work(bench) {}
    text(slave, bench)
}

/// The answer as text.
pub fn text<const N: usize>(slave: &mut Slave<N>, bench: &mut Bench) -> String {
    let bytes: Vec<u8> = std::iter::from_fn(|| slave.next_byte(bench)).collect();
    assert!(!slave.is_answering());
    let mut text = String::from_utf8(bytes).unwrap();
    assert_eq!(text.pop(), Some('\r'));
    assert!(!text.contains('\r'));
    let bare = text.split('*').next().unwrap();
    assert!(Reply::parse(bare.as_bytes()).is_some());
    text
}

/// Commands as text, separated by spaces: `PO S5 E`.
pub fn lines(commands: impl Iterator<Item = Command>) -> String {
    commands.map(|command| command.to_string()).collect::<Vec<_>>().join(" ")
}

/// SplitMix64 (public domain): small, seeded, good enough to make noise.
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// 0 … n − 1.
    pub fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    /// True in one of n cases.
    pub fn one_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }

    pub fn byte(&mut self) -> u8 {
        self.next() as u8
    }
}
