//! Random stories: lines that a master sends, lines that it never should send, and noise that damages both.

mod scenes;

use fastrand::Rng;

use crate::story::{Act, Board, Input, Reset, Story};
use crate::sum::crc;

/// The kind of stories to make.
#[derive(Clone, Copy, Debug)]
pub struct Taste {
    /// The most acts.
    pub acts: usize,
    /// The longest wait, in µs.
    pub wait: u32,
    /// The longest travel by its numbers, in µs.
    pub travel: u32,
    /// The shortest time to reach the top speed, in seconds.
    pub ramp: f64,
    /// The longest wait for a slow step, in µs.
    pub slow: u32,
    /// Whether power cuts and switches occur.
    pub events: bool,
}

impl Taste {
    /// Stories for the virtual board.
    pub const WIDE: Taste = Taste {
        acts: 24,
        wait: 60_000,
        travel: 150_000,
        ramp: 0.001,
        slow: 1_500_000,
        events: true,
    };
    /// Short stories for a simulated chip.
    pub const CHIP: Taste =
        Taste { acts: 10, wait: 12_000, travel: 30_000, ramp: 0.02, slow: 300_000, events: true };
}

/// The story of a seed, on a random virtual board.
pub fn story(seed: u64) -> Story {
    let mut rng = Rng::with_seed(seed);
    let board = board(&mut rng);
    tell(&mut rng, board, Taste::WIDE)
}

/// The story of a seed on this board.
pub fn story_on(seed: u64, board: Board, taste: Taste) -> Story {
    tell(&mut Rng::with_seed(seed), board, taste)
}

/// A random number in a range, evenly distributed over orders of magnitude.
fn scale(rng: &mut Rng, least: f64, most: f64) -> f64 {
    (least.ln() + rng.f64() * (most.max(least).ln() - least.ln())).exp()
}

/// Clock rates of real chips.
const CLOCKS: [u32; 9] = [
    100_000,
    250_000,
    1_000_000,
    2_000_000,
    16_000_000,
    20_000_000,
    72_000_000,
    84_000_000,
    200_000_000,
];

fn board(rng: &mut Rng) -> Board {
    let hz = match rng.u8(..8) {
        0 => return Board::uno(if rng.bool() { 0 } else { 1389 }),
        1 | 2 => 16_000_000,
        3 | 4 => CLOCKS[rng.usize(..CLOCKS.len())],
        _ => scale(rng, 1e5, 2e8) as u32,
    };
    // A step takes 4 to 60 µs, and at least a few ticks.
    let micros = scale(rng, 4.0, 60.0);
    let one = (micros * f64::from(hz) / 1e6).max(4.0);
    let cost = [one, one * (1.3 + rng.f64() * 0.4), one * (1.6 + rng.f64() * 0.6)]
        .map(|cost| cost as u32 + 1);
    let axes = rng.u8(1..=3);
    let byte = if rng.bool() { 0 } else { (f64::from(hz) / 11_520.0) as u32 };
    Board::simulated(hz, rng.bool(), axes, cost, byte)
}

/// Makes a story.
struct Teller<'r> {
    rng: &'r mut Rng,
    board: Board,
    taste: Taste,
    acts: Vec<Act>,
    /// Damaged bytes in a thousand.
    noise: u32,
    damaged: u32,
    /// Whether lines have checksums.
    sums: bool,
    /// The highest step rate of a single axis.
    fastest: f64,
}

fn tell(rng: &mut Rng, board: Board, taste: Taste) -> Story {
    let noise = if rng.u8(..3) == 0 { scale(rng, 2.0, 60.0) as u32 } else { 0 };
    let fastest = f64::from(board.hz) / f64::from(board.cost[0]);
    let sums = rng.u8(..4) == 0;
    let mut teller =
        Teller { rng, board, taste, acts: Vec::new(), noise, damaged: 0, sums, fastest };
    if teller.rng.u8(..3) == 0 {
        teller.settings();
    }
    if teller.one_in(3) {
        teller.guards();
    }
    let length = teller.rng.usize(2..=taste.acts);
    while teller.acts.len() < length {
        teller.scene();
    }
    Story { board, noise: teller.damaged, acts: teller.acts }
}

impl Teller<'_> {
    fn one_in(&mut self, n: u32) -> bool {
        self.rng.u32(..n) == 0
    }

    /// Adds a line, with noise.
    fn say(&mut self, line: impl AsRef<str>) {
        let mut bytes = Vec::new();
        let mut line = line.as_ref().to_owned();
        if self.sums {
            line += &format!("*{:02X}", crc(line.as_bytes()));
        }
        for byte in line.bytes().chain([b'\r']) {
            if self.rng.u32(..1000) >= self.noise {
                bytes.push(byte);
                continue;
            }
            self.damaged += 1;
            match self.rng.u8(..4) {
                0 => {}
                1 => bytes.extend([byte, byte]),
                _ => bytes.push(byte ^ 1 << self.rng.u8(..8)),
            }
        }
        self.acts.push(Act::Send(bytes));
    }

    fn wait(&mut self) {
        let wait = scale(self.rng, 20.0, self.taste.wait.into()) as u32;
        self.acts.push(Act::Wait(wait));
    }

    fn speed(&mut self) -> u32 {
        let fast = self.fastest * if self.one_in(12) { 1.2 } else { 0.98 };
        scale(self.rng, (0.04 * self.fastest).clamp(20.0, 400.0), fast).clamp(1.0, 1e6) as u32
    }

    /// Sends the parameters of a travel. Returns the top speed.
    fn manner(&mut self) -> f64 {
        let top = self.speed();
        if self.one_in(3) && top >= 10 {
            self.say(format!("T{}", (top / 10).min(999)));
        } else if self.one_in(4) {
            let part = self.rng.u32(..1000);
            self.say(format!("m{}", (u64::from(top) * 1000 + u64::from(part)).min(1_000_000_000)));
        } else {
            self.say(format!("t{top}"));
        }
        match self.rng.u8(..6) {
            0 => self.say("s0"),
            1 => self.say(format!("s{top}")),
            2 => {
                let start = self.speed();
                self.say(format!("s{start}"));
            }
            3 => {
                let start = self.rng.u32(1..=50);
                self.say(format!("S{start}"));
            }
            _ => {
                let start = self.rng.u32(1..=top.max(2) / 2);
                self.say(format!("s{start}"));
            }
        }
        self.ramps(top);
        f64::from(top)
    }

    fn slope(&mut self, top: u32) -> u32 {
        let time = scale(self.rng, self.taste.ramp, 1.0);
        (f64::from(top) / time).clamp(1.0, 1e8) as u32
    }

    fn ramps(&mut self, top: u32) {
        match self.rng.u8(..4) {
            0 => {
                let ramp = scale(self.rng, 1.0, 999.0) as u32;
                self.say(format!("R{ramp}"));
            }
            1 => {}
            _ => {
                let (up, down) = (self.slope(top), self.slope(top));
                self.say(format!("a{up}"));
                if self.rng.bool() {
                    self.say(format!("d{down}"));
                }
            }
        }
        if self.board.can.jerk && self.one_in(5) {
            let time = scale(self.rng, 0.001, 0.1);
            let jerk = (f64::from(self.slope(top)) / time).clamp(1.0, 4e9) as u32;
            self.say(format!("j{jerk}"));
        }
    }

    fn sign(&mut self) -> char {
        if self.rng.bool() { '+' } else { '-' }
    }

    fn distance(&mut self, top: f64) -> u32 {
        match self.rng.u8(..8) {
            0 => self.rng.u32(..4),
            1 => self.rng.u32(1..=20),
            _ => scale(self.rng, 1.0, (top * f64::from(self.taste.travel) / 1e6).max(2.0)) as u32,
        }
    }

    fn go(&mut self, top: f64) {
        let sign = self.sign();
        if self.one_in(7) {
            self.say(format!("g{sign}"));
        } else {
            let steps = self.distance(top);
            self.say(format!("G{sign}{steps}"));
        }
    }

    fn axis(&mut self) -> u8 {
        if self.one_in(40) { self.rng.u8(..=9) } else { self.rng.u8(1..=self.board.axes) }
    }

    /// An order of one or several axes.
    fn order(&mut self) {
        let open = if self.one_in(9) { "P0" } else { "PO" };
        self.say(open);
        for axis in 1..=self.board.axes {
            if axis > 1 && self.rng.bool() {
                continue;
            }
            if axis > 1 {
                self.say(format!("A{axis}"));
            } else if self.one_in(8) {
                self.say("A0");
            }
            let top = if self.rng.bool() { self.manner() } else { 1000.0 };
            self.go(top);
        }
        self.say("E");
    }

    /// A change during a travel.
    fn change(&mut self) {
        let top = self.speed();
        match self.rng.u8(..8) {
            0 | 1 => self.say(format!("t{top}")),
            2 => {
                let up = self.slope(top);
                self.say(format!("a{up}"));
            }
            3 => {
                let down = self.slope(top);
                self.say(format!("d{down}"));
            }
            4 | 5 => {
                let (sign, steps) = (self.sign(), self.distance(top.into()));
                self.say(format!("@{sign}{steps}"));
            }
            6 => self.say("Z"),
            _ => {
                let axis = self.axis();
                self.say(format!("A{axis}"));
            }
        }
    }

    fn ask(&mut self) {
        let axis = self.axis();
        match self.rng.u8(..6) {
            0 => self.say("F"),
            1..=3 => self.say(format!("V{axis}")),
            4 => self.say("?"),
            _ => self.say("$"),
        }
    }

    fn settings(&mut self) {
        let set = self.rng.u32(..8);
        let (name, number) = match self.rng.u8(..14) {
            0 => ("max-speed", self.speed()),
            1 => ("max-accel", scale(self.rng, 100.0, 1e8) as u32),
            2 => ("idle-ms", self.rng.u32(..50)),
            3 | 4 => ("timeout-ms", self.rng.u32(..40)),
            5 => ("enable-ms", self.rng.u32(..20)),
            6 => ("setup-us", self.rng.u32(..=1000)),
            7 => ("hold-us", self.rng.u32(..=1000)),
            8 => ("pulse-us", self.rng.u32(..=21)),
            9 => ("reverse", set),
            10 => ("enable-high", set & 1),
            11 => ("switches", set),
            12 => ("switch-forward", set),
            _ => ("switch-high", set),
        };
        self.say(format!("${name}={number}"));
        if self.one_in(4) {
            let line = if self.rng.bool() { format!("${name}") } else { "$reset".into() };
            self.say(line);
        }
    }

    /// Sets one or more of the safety settings.
    fn guards(&mut self) {
        let name = ["x", "y", "z"][self.rng.usize(..3)];
        let far = scale(self.rng, 1.0, 3000.0) as u32;
        let set = self.rng.u32(..8);
        let millis = [0, 1, 5, 25, 250][self.rng.usize(..5)];
        match self.rng.u8(..9) {
            0..=2 => {
                for side in ["ahead", "behind"] {
                    if !self.one_in(4) {
                        self.say(format!("${side}-{name}={far}"));
                    }
                }
                let set = if self.rng.bool() { 7 } else { set };
                self.say(format!("$soft-limits={set}"));
            }
            3 => self.say(format!("$safe-start={}", set.min(1))),
            4 => self.say(format!("$home-first={}", set.min(1))),
            5 => self.say(format!("$kill-off={}", set.min(1))),
            6 => self.say(format!("$estop={}", set % 3)),
            7 => self.say(format!("$driver-fault={}", set % 3)),
            _ => self.say(format!("$debounce-ms={millis}")),
        }
        if self.rng.bool() {
            self.guards();
        }
    }

    /// Sets a lease.
    fn lease(&mut self) {
        let millis = if self.one_in(3) { 0 } else { self.rng.u32(..60) };
        self.say(format!("L{millis}"));
    }

    /// A line of random characters.
    fn babble(&mut self) {
        let letters = b"PSTRG@gEFZKIVALstmadj?!$O0123456789+-=x \n";
        let length = self.rng.usize(..8);
        let line: String =
            (0..length).map(|_| char::from(*self.rng.choice(letters).unwrap_or(&b'x'))).collect();
        self.say(line);
    }

    fn event(&mut self) {
        if self.one_in(3) {
            let (reset, _) = *self.rng.choice(&Reset::ALL).unwrap_or(&Reset::ALL[0]);
            self.acts.push(Act::Reset(reset));
        } else if self.one_in(3) {
            let (input, _) = Input::ALL[self.rng.usize(..2)];
            let high = self.rng.bool();
            self.acts.push(Act::Input(input, high));
            if self.rng.bool() {
                self.wait();
            }
        } else if self.one_in(3) {
            self.press();
        } else {
            let axis = self.rng.u8(..self.board.axes);
            let high = self.rng.bool();
            self.acts.push(Act::Switch(axis, high));
        }
    }

    /// Presses and releases a switch, then orders a travel.
    fn press(&mut self) {
        let axis = self.rng.u8(..self.board.axes);
        self.say("$switches=7");
        for high in [false, true] {
            self.acts.push(Act::Switch(axis, high));
            self.wait();
        }
        let sign = self.sign();
        self.say(format!("A{}", axis + 1));
        self.say(format!("g{sign}"));
    }

    fn scene(&mut self) {
        match self.rng.u8(..36) {
            0..=7 => {
                self.order();
                if self.rng.bool() {
                    self.wait();
                }
            }
            8..=13 => {
                self.change();
                if self.rng.bool() {
                    self.wait();
                }
            }
            14..=17 => self.ask(),
            18..=20 => self.acts.push(Act::Rest),
            21..=23 => self.wait(),
            24 => {
                let sign = self.sign();
                self.say(format!("g{sign}"));
                self.wait();
            }
            25 => {
                if self.rng.bool() {
                    self.say("K");
                }
                let axis = self.axis();
                self.say(format!("I{axis}"));
            }
            26 => self.say("Z"),
            27 if self.rng.bool() => self.guards(),
            27 => self.settings(),
            28 => self.babble(),
            29 if self.one_in(3) => self.lease(),
            29 => self.say("!"),
            30 if self.taste.events => self.event(),
            31 => {
                self.manner();
            }
            _ => self.special(),
        }
    }
}
