//! A sender with a clock: it says bytes, lets time pass, and reads what is answered.

use stepwright_grbl::{Grbl, VirtualMill};

/// Milliseconds from look to look.
const LOOK: f64 = 0.002;

pub struct Sender {
    pub grbl: Grbl<VirtualMill>,
    pub now: f64,
}

impl Sender {
    /// A machine of 100 steps/mm, 3000 mm/min, 500 mm/s², that may jump 120 mm/min.
    pub fn new() -> Sender {
        let mut sender = Sender { grbl: Grbl::new(VirtualMill::default()), now: 0.0 };
        sender.read();
        for axis in 0..3 {
            for (number, value) in [(100, 100), (110, 3_000), (120, 500), (140, 120)] {
                sender.says(&format!("${}={value}", number + axis), "ok");
            }
        }
        sender
    }

    pub fn send(&mut self, bytes: &[u8]) {
        self.grbl.receive(self.now, bytes);
    }

    pub fn read(&mut self) -> String {
        String::from_utf8(self.grbl.take_answers()).unwrap()
    }

    /// Lets seconds pass.
    pub fn pass(&mut self, seconds: f64) {
        let end = self.now + seconds;
        while self.now < end {
            self.now = (self.now + LOOK).min(end);
            self.grbl.advance(self.now);
        }
    }

    /// Until nothing moves.
    pub fn rest(&mut self) {
        for _ in 0..1_000_000 {
            if !self.grbl.is_moving() {
                return;
            }
            self.pass(LOOK);
        }
        panic!("it never ends");
    }

    /// Sends a line; its answer at once.
    pub fn ask(&mut self, line: &str) -> String {
        self.send(line.as_bytes());
        self.send(b"\n");
        self.read().trim_end().to_owned()
    }

    #[track_caller]
    pub fn says(&mut self, line: &str, answer: &str) {
        assert_eq!(self.ask(line), answer, "{line}");
    }

    /// Sends a line and waits for its end; all that is said meanwhile.
    pub fn does(&mut self, line: &str) -> String {
        self.send(line.as_bytes());
        self.send(b"\n");
        self.rest();
        self.read().trim_end().to_owned()
    }

    /// The status report.
    pub fn status(&mut self) -> String {
        self.send(b"?");
        self.read().trim_end().to_owned()
    }

    /// The state in the status report.
    pub fn state(&mut self) -> String {
        let status = self.status();
        status.trim_start_matches('<').split('|').next().unwrap().to_owned()
    }

    /// Where the machine is by its own count, which is to be the controller's.
    pub fn at(&self) -> [i64; 3] {
        self.grbl.machine().at
    }
}
