//! Scenes of a story that are rare by chance: slow steps, waits and mixed speeds, with changes and stops in
//! the middle.

use super::{Act, Teller, scale};

impl Teller<'_> {
    pub(super) fn special(&mut self) {
        match self.rng.u8(..5) {
            0 => self.slow(),
            1 => self.drivers_wait(),
            2 => self.crawl(),
            3 => self.mixed(),
            _ => self.polls(),
        }
    }

    /// A wait of up to this many µs, evenly distributed over orders of magnitude.
    fn pause(&mut self, most: u32) {
        let most = most.min(self.taste.slow);
        if most > 20 && !self.one_in(5) {
            let micros = scale(self.rng, 20.0, most.into()) as u32;
            self.acts.push(Act::Wait(micros));
        }
    }

    fn between(&mut self, least: f64, most: f64) -> u32 {
        scale(self.rng, least, most) as u32
    }

    /// One to four changes with pauses between them, and a stop.
    fn changes_and_stop(&mut self, pause: u32) {
        for _ in 0..self.rng.u8(1..=4) {
            let top = self.speed();
            let slope = self.between(50.0, 4e6);
            match self.rng.u8(..5) {
                0 | 1 => self.say(format!("t{top}")),
                2 => self.say(format!("a{slope}")),
                3 => self.say(format!("d{slope}")),
                _ => {
                    let (sign, steps) = (self.sign(), self.distance(top.into()));
                    self.say(format!("@{sign}{steps}"));
                }
            }
            self.pause(pause);
        }
        match self.rng.u8(..4) {
            0 => {}
            1 => self.say("L5"),
            _ => self.say("Z"),
        }
        self.pause(pause);
    }

    /// First steps of up to a second, with changes and a stop within one of them.
    fn slow(&mut self) {
        let start = self.between(1.0, 60.0);
        let top = start + self.between(1.0, 400.0);
        self.say("PO");
        self.say(format!("s{start}"));
        self.say(format!("t{top}"));
        if self.one_in(3) {
            let ramp = self.rng.u32(1..=999);
            self.say(format!("R{ramp}"));
        } else {
            for letter in ["a", "d"] {
                let slope = self.between(1.0, 2e5);
                self.say(format!("{letter}{slope}"));
            }
        }
        self.go(f64::from(top) * 100.0);
        self.say("E");
        self.pause(2_000_000 / start);
        self.changes_and_stop(1_000_000 / start);
    }

    /// Drivers with a long `enable-ms`.
    fn drivers_wait(&mut self) {
        let millis = self.between(1.0, 1000.0).clamp(1, (self.taste.slow / 1000).min(1000));
        self.say("$idle-ms=1");
        self.say(format!("$enable-ms={millis}"));
        self.acts.push(Act::Wait(5000));
        self.order();
        self.pause(1000 * millis);
        self.changes_and_stop(500 * millis);
        self.say("$idle-ms=0");
    }

    /// Slows down to a few steps/s, and stops there.
    fn crawl(&mut self) {
        let start = self.rng.u32(..4);
        let (top, up) = (self.speed().min(4000), self.between(500.0, 240_000.0));
        for line in [format!("s{start}"), format!("t{top}"), format!("a{up}"), "g+".into()] {
            self.say(line);
        }
        self.pause(200_000);
        let slow = self.between(f64::from(start.max(1)), 40.0);
        self.say(format!("t{slow}"));
        self.pause(1_500_000);
        self.pause(1_500_000);
        self.changes_and_stop(1_000_000);
    }

    /// A fast axis beside slow axes, or equal axes, on ramps as steep as those of machines.
    fn mixed(&mut self) {
        let fast = scale(self.rng, 0.1, 0.9) * self.fastest;
        let equal = self.rng.bool();
        let up = self.between(5_000.0, 240_000.0);
        self.say("PO");
        for axis in 1..=self.board.axes {
            let share = match axis {
                _ if equal => 0.6 / f64::from(self.board.axes),
                1 => 0.8,
                _ => 0.04,
            };
            let top = (fast * share).clamp(1.0, 1e6);
            let lines = [
                format!("A{axis}"),
                format!("t{}", top as u32),
                "s0".into(),
                format!("a{up}"),
                format!("d{up}"),
            ];
            lines.into_iter().for_each(|line| self.say(line));
            self.go(top * 2.0);
        }
        self.say("E");
        self.pause(500_000);
        match self.rng.u8(..4) {
            0 => self.polls(),
            1 => {
                let axis = self.axis();
                self.say(format!("A{axis}"));
                self.changes_and_stop(50_000);
            }
            2 => ["A0", "Z"].into_iter().for_each(|line| self.say(line)),
            _ => {}
        }
    }

    /// Questions one after the other.
    fn polls(&mut self) {
        for _ in 0..self.rng.u8(2..=12) {
            let line = ["?", "$", "F", "V1", "$max-speed"][self.rng.usize(..5)];
            self.say(line);
        }
    }
}
