//! The chip as a test controls it: lines, pins, power.

use std::time::Duration;

use stepwright_sim::Edge;

use crate::board::{Board, HZ, Pin};
use crate::elf::Image;
use crate::line::Line;
use crate::probes::{IsrSpan, Taps};
use crate::silicon::{Cause, Silicon};
use crate::stack::{RESERVE, Stack};

/// The cycles that a test waits for an answer, unless it says otherwise: 50 ms.
const PATIENCE: u64 = HZ / 20;

/// A board with a firmware, switched on.
///
/// Time passes only in the `run` methods and in those that wait for an answer.
pub struct Chip {
    // Boxed: the callbacks hold its address.
    silicon: Box<Silicon>,
    probes: Taps,
    line: Line,
    board: Board,
    ram: u32,
    /// The time when interrupts were switched off, if they are.
    off_since: Option<u64>,
    /// The longest time without interrupts: cycles, and the address of the instruction after which
    /// they were enabled.
    off_longest: (u64, u32),
    watch: Option<Watch>,
    stack: Option<Stack>,
    /// The numbers of the step timers.
    timers: Vec<u8>,
    resets: u32,
}

/// A function whose calls are timed.
#[derive(Clone, Debug, Default)]
struct Watch {
    begin: u32,
    /// The bytes of a return address.
    address: u16,
    /// The stack pointer and the cycle at its entry, and the cycles spent in interrupts before.
    open: Option<(u16, u64, u64)>,
    /// The cycles of each call, without interrupts.
    calls: Vec<u64>,
}

impl Chip {
    /// Switches a board on, with `image` in its flash and an empty EEPROM.
    pub fn new(board: Board, image: &Image) -> Chip {
        Chip::of(board, board.chip(), image)
    }

    /// Switches on an Uno's core with four times its flash and eight times its RAM, an ATmega1284P,
    /// for programs that do not fit an Uno.
    pub fn roomy(image: &Image) -> Chip {
        Chip::of(Board::Uno, "atmega1284p", image)
    }

    fn of(board: Board, name: &str, image: &Image) -> Chip {
        let silicon = Box::new(Silicon::new(name, image));
        let channels = board.channels_of(image);
        let probes = Taps::new(board, &channels, &silicon);
        Chip {
            silicon,
            probes,
            line: Line::default(),
            board,
            ram: image.ram,
            off_since: Some(0),
            off_longest: (0, 0),
            watch: None,
            stack: None,
            timers: channels.iter().map(|channel| channel.number).collect(),
            resets: 0,
        }
    }

    /// The board.
    pub fn board(&self) -> Board {
        self.board
    }

    /// The cycles since it was switched on, through all resets.
    pub fn now(&self) -> u64 {
        self.probes.heard.base + self.silicon.cycle()
    }

    /// Executes one instruction, and the events of the surroundings meanwhile.
    #[inline(always)]
    fn step(&mut self) {
        let now = self.now();
        if self.line.due() <= now {
            self.line.tick(now, &mut self.silicon);
        }
        let before = self.silicon.cycle();
        self.silicon.step();
        if self.silicon.cycle() < before {
            // The watchdog has reset the chip: simavr counts from 0 again.
            self.restarted(before);
        }
        let now = self.now();
        match (self.off_since, self.silicon.interrupts()) {
            (None, false) => self.off_since = Some(now),
            (Some(since), true) => {
                self.off_since = None;
                if now - since > self.off_longest.0 {
                    self.off_longest = (now - since, self.silicon.pc());
                }
            }
            _ => {}
        }
        if let Some(watch) = &mut self.watch {
            watch.look(&self.silicon, now, self.probes.heard.inside);
        }
        if let Some(stack) = &mut self.stack {
            stack.look(&self.silicon, self.probes.heard.running);
        }
        if self.line.is_polling() {
            self.hear_answers(now);
        }
    }

    /// Continues a poll when an answer is complete.
    fn hear_answers(&mut self, now: u64) {
        while let Some(&(done, byte)) = self.probes.heard.said.front() {
            if done > now {
                return;
            }
            self.probes.heard.said.pop_front();
            if byte == b'\r' {
                self.line.answered(done);
            }
        }
    }

    /// Lets `cycles` pass.
    pub fn run_for(&mut self, cycles: u64) {
        self.run_until(self.now().saturating_add(cycles));
    }

    /// Lets time pass until `cycle`.
    pub fn run_until(&mut self, cycle: u64) {
        while self.now() < cycle {
            self.step();
        }
    }

    /// Lets time pass until `done` returns true, which is called after each instruction. False if
    /// it has not after `limit` cycles.
    pub fn run_to(&mut self, limit: u64, mut done: impl FnMut(&Chip) -> bool) -> bool {
        let end = self.now().saturating_add(limit);
        loop {
            if done(self) {
                return true;
            }
            if self.now() >= end {
                return false;
            }
            self.step();
        }
    }

    /// Sends bytes, one directly after the other, from now on.
    pub fn send(&mut self, bytes: &[u8]) {
        self.line.send(self.now(), bytes);
    }

    /// Sends a byte that is complete at `cycle`.
    pub(crate) fn send_complete_at(&mut self, cycle: u64, byte: u8) {
        let begin = cycle.saturating_sub(self.silicon.byte_time());
        self.line.send(begin, &[byte]);
    }

    /// Sends `lines` in turn, each as soon as the previous one is answered, while time passes,
    /// until it is called with none. The answers are not kept.
    pub fn poll(&mut self, lines: &[&str]) {
        self.line.poll(self.now(), lines);
    }

    /// The number of answers to the lines of [`poll`](Chip::poll) so far.
    pub fn polled(&self) -> u64 {
        self.line.polled
    }

    /// The board's output so far that was not taken.
    pub fn take_said(&mut self) -> Vec<u8> {
        self.take_said_with_times().into_iter().map(|(_, byte)| byte).collect()
    }

    /// The same, with the cycle at which each byte is complete.
    pub fn take_said_with_times(&mut self) -> Vec<(u64, u8)> {
        let now = self.now();
        let said = &mut self.probes.heard.said;
        let complete = said.partition_point(|&(done, _)| done <= now);
        said.drain(..complete).collect()
    }

    /// All bytes whose sending has begun, even if not complete.
    pub(crate) fn take_begun(&mut self) -> Vec<(u64, u8)> {
        self.probes.heard.said.drain(..).collect()
    }

    /// Sends a line with its CR and waits for the answer, which is returned without its CR; `None`
    /// if it does not come within 50 ms.
    pub fn ask(&mut self, line: &str) -> Option<String> {
        self.take_said();
        self.send(line.as_bytes());
        self.send(b"\r");
        let mut answer = Vec::new();
        let complete = self.run_to(PATIENCE, |chip| {
            chip.probes
                .heard
                .said
                .back()
                .is_some_and(|&(done, byte)| byte == b'\r' && done <= chip.now())
        });
        answer.extend(self.take_said());
        (complete && answer.pop() == Some(b'\r'))
            .then(|| String::from_utf8_lossy(&answer).into_owned())
    }

    /// Sends a line, and panics if the answer is a different one: for tests.
    #[track_caller]
    pub fn expect(&mut self, line: &str, answer: &str) {
        let got = self.ask(line);
        assert_eq!(got.as_deref(), Some(answer), "the answer to {line:?} at {}", self.now());
    }

    /// Sends `F` until the answer is `R`; false if that takes longer than `limit`.
    pub fn run_to_rest(&mut self, limit: Duration) -> bool {
        let end = self.now() + cycles(limit);
        while self.now() < end {
            match self.ask("F").as_deref() {
                Some("R") => return true,
                Some("B") => self.run_for(HZ / 100),
                _ => return false,
            }
        }
        false
    }

    /// Lets time pass without a line until no pin of a drive has changed for `quiet` cycles; false
    /// if that takes longer than `limit`.
    pub fn run_to_silence(&mut self, quiet: u64, limit: u64) -> bool {
        let mut seen = self.edges().len();
        let end = self.now() + limit;
        while self.now() < end {
            self.run_for(quiet);
            if self.edges().len() == seen {
                return true;
            }
            seen = self.edges().len();
        }
        false
    }

    /// Every edge of STEP and DIR so far.
    pub fn edges(&self) -> &[Edge] {
        &self.probes.heard.edges
    }

    /// Returns the edges so far, and clears them.
    pub fn take_edges(&mut self) -> Vec<Edge> {
        std::mem::take(&mut self.probes.heard.edges)
    }

    /// Every change of ENABLE so far: cycle and level. It is low at first, because a pin that is
    /// not driven counts as low.
    pub fn enable_changes(&self) -> &[(u64, bool)] {
        &self.probes.heard.enable
    }

    /// Every change of the LED on D13.
    pub fn led_changes(&self) -> &[(u64, bool)] {
        &self.probes.heard.led
    }

    /// Records the levels of these pins from now on: they are low until they rise.
    pub fn watch_pins(&mut self, pins: &[Pin]) {
        self.probes.watch(&self.silicon, pins);
    }

    /// Every change of a watched pin: its cycle, the pin's index, its level.
    pub fn watched_changes(&self) -> &[(u64, u8, bool)] {
        &self.probes.heard.watched
    }

    /// The same, and clears them.
    pub fn take_watched_changes(&mut self) -> Vec<(u64, u8, bool)> {
        std::mem::take(&mut self.probes.heard.watched)
    }

    /// Closes the limit switch of an axis to ground, or opens it.
    pub fn press(&mut self, axis: usize, closed: bool) {
        self.silicon.pull(self.board.switch()[axis], closed);
    }

    /// Pulls a pin to ground, or leaves it to its pull-up.
    pub fn pull(&mut self, pin: Pin, low: bool) {
        self.silicon.pull(pin, low);
    }

    /// Presses RESET: RAM and EEPROM keep their contents.
    pub fn reset(&mut self) {
        self.reset_by(Cause::Button);
    }

    /// A reset for a reason: RAM and EEPROM keep their contents.
    pub fn reset_by(&mut self, cause: Cause) {
        let before = self.silicon.cycle();
        self.silicon.reset(cause);
        self.restarted(before);
    }

    /// Clears the reason of the reset, before the program has run, as many boot loaders do.
    pub fn clear_cause(&mut self) {
        self.silicon.clear_cause();
    }

    /// Switches the power off and on: only flash and EEPROM keep their contents. A byte of the
    /// EEPROM that was being written becomes `spoilt`.
    pub fn power_loss(&mut self, spoilt: u8) {
        if let Some(address) = self.probes.heard.eeprom.cut() {
            self.silicon.set_eeprom(address, &[spoilt]);
        }
        let before = self.silicon.cycle();
        self.silicon.power_cycle();
        self.restarted(before);
        self.line.cut();
        self.probes.heard.said.clear();
    }

    fn restarted(&mut self, before: u64) {
        self.probes.heard.base += before;
        self.probes.release();
        self.probes.heard.running = false;
        self.off_since = Some(self.now());
        self.resets += 1;
        if let Some(watch) = &mut self.watch {
            watch.open = None;
        }
    }

    /// The resets of every kind since it was switched on.
    pub fn resets(&self) -> u32 {
        self.resets
    }

    /// The whole EEPROM.
    pub fn eeprom(&self) -> Vec<u8> {
        self.silicon.eeprom()
    }

    /// Writes bytes to the EEPROM.
    pub fn set_eeprom(&mut self, offset: u16, bytes: &[u8]) {
        self.silicon.set_eeprom(offset, bytes);
    }

    /// Whether a byte of the EEPROM is being written.
    pub fn eeprom_is_busy(&self) -> bool {
        self.probes.heard.eeprom.is_busy()
    }

    /// The number of bytes written to the EEPROM.
    pub fn eeprom_written(&self) -> u64 {
        self.probes.heard.eeprom.written()
    }

    /// Sets the low fuse byte, before the chip has run. It is 0 at first, and only tells the
    /// firmware its clock: the cycles are not affected. Its bit CKDIV8 sets CLKPR, as a reset does.
    pub fn set_low_fuse(&mut self, byte: u8) {
        self.silicon.set_low_fuse(byte);
    }

    /// A byte of RAM or a register.
    pub fn byte(&self, address: u16) -> u8 {
        self.silicon.byte(address)
    }

    /// Sets a byte of RAM, or one of the registers r0 to r31.
    ///
    /// # Panics
    /// It is a register of the hardware, or there is no such byte.
    pub fn set_byte(&mut self, address: u16, byte: u8) {
        self.silicon.set_byte(address, byte);
    }

    /// Writes other code to the flash from `address` on, and returns the previous code.
    ///
    /// # Panics
    /// The flash ends before.
    pub fn set_code(&mut self, address: u32, code: &[u8]) -> Vec<u8> {
        self.silicon.set_code(address, code)
    }

    /// Calls the function at `address` on a chip that has just been switched on, without running
    /// its program: arguments and results are in its registers, bytes 0 to 31. False if it does not
    /// return, with the stack unchanged, within `limit` cycles.
    pub fn call(&mut self, address: u32, limit: u64) -> bool {
        let sp = self.silicon.sp();
        self.silicon.enter(address);
        // It returns to the reset address.
        self.run_to(limit, |chip| chip.pc() == 0) && self.silicon.sp() == sp
    }

    /// The address of the next instruction, in bytes.
    pub fn pc(&self) -> u32 {
        self.silicon.pc()
    }

    /// The bytes of RAM in statics, and the largest stack so far.
    pub fn ram(&self) -> (u32, u32) {
        (self.ram, self.silicon.stack(self.ram))
    }

    /// Checks the stack pointer after each instruction from now on.
    pub fn watch_stack(&mut self) {
        self.stack = Some(Stack::new(self.timers.iter().copied()));
    }

    /// The free bytes between the statics and the deepest stack: as far as was written, and where
    /// the pointer is checked, with the deepest interrupt on top of the deepest place that lets a
    /// step interrupt in.
    pub fn spare(&self) -> i64 {
        let (room, end) = self.silicon.room();
        let met = self.stack.as_ref().map_or(0, |stack| stack.met(end));
        i64::from(room) - i64::from(self.ram) - i64::from(self.silicon.stack(self.ram).max(met))
    }

    /// The bytes that were lost on the way to the firmware.
    pub fn lost(&self) -> u64 {
        self.line.lost
    }

    /// Whether all sent bytes have reached the firmware.
    pub fn has_taken_all(&self) -> bool {
        self.line.is_idle()
    }

    /// The longest time with interrupts off so far: cycles, and the address after it.
    pub fn longest_off(&self) -> (u64, u32) {
        self.off_longest
    }

    /// Resets the longest time, to exclude the boot.
    pub fn clear_longest_off(&mut self) {
        self.off_longest = (0, 0);
    }

    /// The cycles in interrupts so far.
    pub fn inside_interrupts(&self) -> u64 {
        self.probes.heard.inside
    }

    /// Records every stay in the step interrupt from now on.
    pub fn keep_visits(&mut self) {
        self.probes.heard.keep_visits = true;
    }

    /// The stays in the step interrupt that were recorded and not taken.
    pub fn take_visits(&mut self) -> Vec<IsrSpan> {
        std::mem::take(&mut self.probes.heard.visits)
    }

    /// Times every call of the function at `address` from now on.
    pub fn watch_calls(&mut self, address: u32) {
        // A program counter of 22 bits takes three.
        let bytes = if self.board() == Board::Mega { 3 } else { 2 };
        self.watch = Some(Watch { begin: address, address: bytes, ..Watch::default() });
    }

    /// The cycles of each call of the timed function, without interrupts.
    pub fn take_calls(&mut self) -> Vec<u64> {
        self.watch.as_mut().map(|watch| std::mem::take(&mut watch.calls)).unwrap_or_default()
    }
}

impl Drop for Chip {
    /// Checks after every test that the stack has not come near the statics.
    fn drop(&mut self) {
        let spare = self.spare();
        assert!(
            self.ram == 0 || spare >= RESERVE.into() || std::thread::panicking(),
            "the stack has come within {spare} bytes of the statics, of which {RESERVE} are a reserve"
        );
    }
}

impl Watch {
    fn look(&mut self, silicon: &Silicon, now: u64, inside: u64) {
        match self.open {
            None if silicon.pc() == self.begin => self.open = Some((silicon.sp(), now, inside)),
            // The return address has been popped. A pointer that is merely above this is one that a
            // callee has half written, when its frame ends on another page.
            Some((sp, begun, then)) if silicon.sp() == sp + self.address => {
                self.calls.push((now - begun).saturating_sub(inside - then));
                self.open = None;
            }
            _ => {}
        }
    }
}

/// A time in cycles.
pub fn cycles(time: Duration) -> u64 {
    (time.as_nanos() * u128::from(HZ) / 1_000_000_000) as u64
}
