//! A board of a few cells, and an engine that plays on request. A test controls the time and the
//! end of each motion, and sees each pin.

use std::cell::Cell;

use stepwright::queue::{Consumer, Next, Producer, Queue, Source};
use stepwright::{Board, Control, OrderedMotors, Playing, Rate, Report, Ticks, Timing};
use stepwright_device::{BoardIo, Device, Mark, Memory, Reset, ResetIo, Store};

/// The pin of a step in an entry.
const STEP: u8 = 1;

/// Two motors that rest until they are started, and then move until all queued entries are played.
pub struct Motion<'q> {
    ends: [Consumer<'q, 8>; 2],
    pub moving: u8,
    pub timing: Option<Timing>,
    pub late: u32,
    /// The ticks of the played entries up to the first step.
    pub waited: [u64; 2],
    pub stepped: u8,
}

impl Motion<'_> {
    /// Plays the queued entries. An axis whose travel is planned to its end then rests.
    pub fn play(&mut self) {
        for (axis, end) in self.ends.iter_mut().enumerate() {
            loop {
                match end.take() {
                    Next::Entry(entry) if self.stepped >> axis & 1 == 0 => {
                        for (pins, wait) in entry.play() {
                            if pins & STEP != 0 {
                                self.stepped |= 1 << axis;
                                break;
                            }
                            self.waited[axis] += u64::from(wait) >> 16;
                        }
                    }
                    Next::Entry(_) => {}
                    Next::Late => break,
                    Next::End => {
                        self.moving &= !(1 << axis);
                        break;
                    }
                }
            }
        }
    }
}

impl Control for Motion<'_> {
    fn playing(&mut self, _: u8) -> Playing {
        Playing::Unknown
    }
    fn start(&mut self, axes: u8) {
        self.moving |= axes;
    }
    fn kill(&mut self, axes: u8) {
        self.moving &= !axes;
        for (axis, end) in self.ends.iter_mut().enumerate() {
            if axes >> axis & 1 != 0 {
                end.clear(true);
            }
        }
    }
    fn report(&self, axis: u8) -> Report {
        Report { position: 0, idle: self.moving >> axis & 1 == 0, forward: true }
    }
    fn set_position(&mut self, _: u8, _: i64) {}
    fn set_timing(&mut self, timing: Timing) {
        self.timing = Some(timing);
    }
    fn late(&self) -> u32 {
        self.late
    }
    fn clear_late(&mut self) {
        self.late = 0;
    }
}

/// Pins, time and bytes. A tick is 1/16 µs.
pub struct Panel {
    pub millis: u32,
    pub switches: u8,
    pub emergency: bool,
    pub driver_fault: bool,
    /// The level of the enable pin, once it has been set.
    pub enable: Option<bool>,
    pub reset: Reset,
    pub mark: Mark,
    pub reverse: u8,
    pub bytes: Vec<u8>,
    pub writing: Cell<bool>,
}

impl Panel {
    pub fn new() -> Panel {
        Panel {
            millis: 0,
            switches: 0xFF,
            emergency: true,
            driver_fault: true,
            enable: None,
            reset: Reset::Power,
            mark: Mark::NONE,
            reverse: 0,
            bytes: vec![0xFF; Store::SIZE.into()],
            writing: Cell::new(false),
        }
    }
}

impl Memory for Panel {
    fn read(&mut self, address: u16) -> u8 {
        self.bytes[usize::from(address)]
    }
    fn start_write(&mut self, address: u16, byte: u8) {
        self.bytes[usize::from(address)] = byte;
        self.writing.set(true);
    }
    fn is_writing(&self) -> bool {
        self.writing.replace(false)
    }
}

impl ResetIo for Panel {
    fn reset(&mut self) -> Reset {
        self.reset
    }
    fn mark(&self) -> Mark {
        self.mark
    }
    fn set_mark(&mut self, mark: Mark) {
        self.mark = mark;
    }
}

impl BoardIo for Panel {
    fn millis(&self) -> u32 {
        self.millis
    }
    fn ticks(&self, micros: u16) -> Ticks {
        Ticks::from(micros) * 16
    }
    fn switches(&self) -> u8 {
        self.switches
    }
    fn emergency(&self) -> bool {
        self.emergency
    }
    fn driver_fault(&self) -> bool {
        self.driver_fault
    }
    fn set_enable(&mut self, high: bool) {
        self.enable = Some(high);
    }
    fn set_reverse(&mut self, axes: u8) {
        self.reverse = axes;
    }
}

/// A device with its board.
pub struct Rig<'q> {
    pub device: Device<'q, Motion<'q>, 2, 8>,
    pub panel: Panel,
    /// What happens between two pieces of the device's work, as in a main loop: see
    /// [`Rig::between`].
    pub meanwhile: Option<Meanwhile>,
}

/// A source of random moments, and of what may happen at one of them.
pub struct Meanwhile {
    state: u32,
    /// Moments until these pins become low, and these pins: the switches, and the emergency stop.
    pub low: Option<(u32, u8, bool)>,
}

impl Meanwhile {
    /// The moments of this seed; nothing happens but time.
    pub fn of(seed: u32) -> Meanwhile {
        Meanwhile { state: seed.wrapping_mul(0x9E37_79B9) | 1, low: None }
    }

    /// A number below `bound`.
    pub fn below(&mut self, bound: u32) -> u32 {
        self.state ^= self.state << 13;
        self.state ^= self.state >> 17;
        self.state ^= self.state << 5;
        (self.state >> 8) % bound
    }
}

impl<'q> Rig<'q> {
    pub fn new(queues: &'q mut [Queue<8>; 2], panel: Panel) -> Rig<'q> {
        Rig::with_axes(2, queues, panel)
    }

    pub fn with_axes(axes: u8, queues: &'q mut [Queue<8>; 2], mut panel: Panel) -> Rig<'q> {
        let [(x, x_end), (y, y_end)] = queues.each_mut().map(Queue::split);
        let feeds: [Producer<8>; 2] = [x, y];
        let motion = Motion {
            ends: [x_end, y_end],
            moving: 0,
            timing: None,
            late: 0,
            waited: [0; 2],
            stepped: 0,
        };
        let board = Board::unmeasured(Rate::from_hz(16_000_000).unwrap());
        let motors = OrderedMotors::new(motion, feeds, board);
        Rig { device: Device::new(motors, axes, &mut panel), panel, meanwhile: None }
    }

    /// The answer to a line. An order has begun before it is answered.
    pub fn ask(&mut self, line: &str) -> String {
        for byte in line.bytes().chain([b'\r']) {
            self.device.receive(byte, &mut self.panel);
            self.between();
        }
        while self.device.work(&mut self.panel) {
            self.between();
        }
        let mut answer = Vec::new();
        while let Some(byte) = self.device.next_byte(&mut self.panel) {
            answer.push(byte);
            self.between();
        }
        self.plan();
        String::from_utf8(answer).unwrap().trim_end().into()
    }

    /// Does what the main loop does between two pieces of work, if the rig has its `meanwhile`:
    /// some milliseconds may pass, a pin may become low, and the device is polled. Wherever a motor
    /// may step, a reset must find the mark of a moving board, and the drivers must be on.
    pub fn between(&mut self) {
        let Some(meanwhile) = &mut self.meanwhile else { return };
        if let Some((moments, switches, emergency)) = &mut meanwhile.low {
            if *moments == 0 {
                self.panel.switches &= !*switches;
                self.panel.emergency &= !*emergency;
                meanwhile.low = None;
            } else {
                *moments -= 1;
            }
        }
        // Mostly none has passed, and at most as many as a change takes.
        self.panel.millis += [0, 0, 0, 1, 1, 3][meanwhile.below(6) as usize];
        let pieces = meanwhile.below(4);
        self.device.poll_io(&mut self.panel);
        self.check();
        for _ in 0..pieces {
            self.device.plan();
            self.check();
        }
    }

    /// Checks the mark and the drivers of a board that moves.
    fn check(&mut self) {
        if self.device.motors_mut().engine().moving != 0 {
            assert_eq!((self.panel.mark, self.panel.enable), (Mark::MOVING, Some(false)));
        }
    }

    /// Sends several lines; each must be answered Y.
    pub fn say(&mut self, lines: &str) {
        for line in lines.split(' ') {
            assert_eq!(self.ask(line), "Y", "{line}");
        }
    }

    /// A word of the answer to `?`.
    pub fn told(&mut self, name: &str) -> String {
        let answer = self.ask("?");
        let word = |word: &str| word.strip_prefix(name)?.strip_prefix('=').map(String::from);
        answer.split(' ').find_map(word).unwrap_or_else(|| panic!("no {name} in {answer}"))
    }

    pub fn plan(&mut self) {
        while self.device.poll(&mut self.panel) {}
    }

    /// Advances the time, millisecond by millisecond.
    pub fn pass(&mut self, millis: u32) {
        for _ in 0..millis {
            self.panel.millis = self.panel.millis.wrapping_add(1);
            self.plan();
        }
    }

    /// Plays until an axis rests, or for 10,000 runs.
    pub fn play_out(&mut self) {
        for _ in 0..10_000 {
            self.plan();
            self.device.motors_mut().engine().play();
            if !self.device.motors().any_moving() {
                return;
            }
        }
    }

    /// The ticks from now to the first step in the queue of an axis.
    pub fn wait(&mut self, axis: usize) -> u64 {
        let motion = self.device.motors_mut().engine();
        motion.stepped = 0;
        motion.waited = [0; 2];
        motion.play();
        motion.waited[axis]
    }

    pub fn moving(&self) -> bool {
        self.device.motors().any_moving()
    }
}
