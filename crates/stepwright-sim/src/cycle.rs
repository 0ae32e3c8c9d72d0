//! Motor cycles on simulated pins, with switches at given positions and drivers that are on or off.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use stepwright::drive::{Axes, Drive};
use stepwright::{Board, Cost, Rate, Ticks};
use stepwright_cycle::line::{LONGEST, MotorPins};
use stepwright_cycle::{Clock, Cycle, CycleHold, Leg, MachineIo, Motor, Remote, Switches};
use stepwright_protocol::{Text, flash_text};

use crate::clock::{Now, Present, SimTimer};
use crate::description::Description;
use crate::edge::{Edge, Pin, Recorder};
use crate::program::{ProgramBoard, SimProgram};

/// Ticks between two visits of the main loop.
const LOOK: u64 = 1_600;

/// The positions of a motor's switches: in steps of its shaft from power-up, in the motor's own direction.
/// `None`: there is no switch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stand {
    /// The switch is closed at this position and below.
    pub min: Option<i64>,
    /// The switch is closed at this position and above.
    pub max: Option<i64>,
}

/// The state of the shafts, and the recorder of the edges.
struct Shafts<R, const N: usize> {
    now: Now,
    recorder: R,
    inverted: Axes,
    /// The levels of DIR.
    forward: [bool; N],
    at: [i64; N],
    stands: [Stand; N],
    closed: Switches,
    enabled: Option<Axes>,
}

impl<R: Recorder, const N: usize> Shafts<R, N> {
    fn say(&mut self, axis: u8, pin: Pin, level: bool) {
        self.recorder.edge(Edge { time: self.now.get(), axis, pin, level });
    }

    /// Updates the switches of an axis.
    fn look(&mut self, axis: u8) {
        let n = usize::from(axis);
        let (Some(at), Some(stand)) = (self.at.get(n), self.stands.get(n)) else { return };
        let bit = 1 << axis;
        let min = stand.min.is_some_and(|min| *at <= min);
        let max = stand.max.is_some_and(|max| *at >= max);
        if min != (self.closed.min & bit != 0) {
            self.closed.min ^= bit;
            self.say(axis, Pin::Min, min);
        }
        if max != (self.closed.max & bit != 0) {
            self.closed.max ^= bit;
            self.say(axis, Pin::Max, max);
        }
    }
}

/// The drive of a cycle and the pins around its motors.
pub struct CyclePins<R, const N: usize>(Rc<RefCell<Shafts<R, N>>>);

impl<R: Recorder, const N: usize> Drive for CyclePins<R, N> {
    fn begin(&mut self, axes: Axes) {
        let mut shafts = self.0.borrow_mut();
        for axis in (0..N as u8).filter(|axis| axes >> axis & 1 != 0) {
            shafts.say(axis, Pin::Step, true);
            let n = usize::from(axis);
            let forward = shafts.forward[n] != (shafts.inverted >> axis & 1 != 0);
            shafts.at[n] += if forward { 1 } else { -1 };
            shafts.look(axis);
        }
    }

    fn end(&mut self, axes: Axes) {
        let mut shafts = self.0.borrow_mut();
        for axis in (0..N as u8).filter(|axis| axes >> axis & 1 != 0) {
            shafts.say(axis, Pin::Step, false);
        }
    }

    fn direction(&mut self, axis: u8, forward: bool) {
        let mut shafts = self.0.borrow_mut();
        if let Some(known) = shafts.forward.get_mut(usize::from(axis)) {
            *known = forward;
            shafts.say(axis, Pin::Direction, forward);
        }
    }
}

impl<R: Recorder, const N: usize> MachineIo for CyclePins<R, N> {
    fn switches(&mut self) -> Switches {
        self.0.borrow().closed
    }

    fn enable(&mut self, axes: Axes) {
        let mut shafts = self.0.borrow_mut();
        let before = shafts.enabled.replace(axes);
        for axis in 0..N as u8 {
            let on = axes >> axis & 1 != 0;
            if before.is_none_or(|before| on != (before >> axis & 1 != 0)) {
                // A low level switches a driver on.
                shafts.say(axis, Pin::Enable, !on);
            }
        }
    }
}

/// A board as quick as an Uno, for any number of motors. Each motor beyond the third adds as much as the third.
fn board<const N: usize>(rate: Rate) -> Board<N> {
    let [one, two, three] = Description::uno().board.cost.ticks;
    // Costs measured at 16 MHz.
    let scaled = |ticks: Ticks| rate.nanos(ticks * 125 / 2);
    let cost = std::array::from_fn(|n| match n {
        0 => scaled(one),
        1 => scaled(two),
        _ => scaled(three + (three - two) * (n as Ticks - 2)),
    });
    let uno = Description::quick(rate, [one, two, three].map(scaled)).board;
    let Board { timing, runs, fit, horizon, lead, .. } = uno;
    Board { rate, timing, cost: Cost::any_pulse(cost), runs, fit, horizon, lead }
}

/// N motors and their cycle in simulated time, with a 32-bit timer.
///
/// ```
/// use stepwright_cycle::{Calibration, Clock, Motor, Program};
/// use stepwright::Rate;
/// use stepwright_sim::{CycleBoard, Edge, Stand};
/// let mut board: CycleBoard<Vec<Edge>, 1> = CycleBoard::new(
///     [Motor::new(7_500, 1_000)],
///     [Stand::default()],
///     Clock::Tick { period: 200 },
///     Rate::from_hz(16_000_000)?,
///     Vec::new(),
/// );
/// board.cycle().prepare(0, Program::Steps { count: 3, delay: 0 }, Calibration::None)?;
/// board.cycle().start()?;
/// board.run_to_rest();
/// assert_eq!(board.cycle().position(0), Some(22_500));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct CycleBoard<'a, R: Recorder, const N: usize> {
    now: Now,
    shafts: Rc<RefCell<Shafts<R, N>>>,
    cycle: BoardCycle<'a, R, N>,
}

type BoardCycle<'a, R, const N: usize> =
    Cycle<'a, SimTimer<u32, Now>, CyclePins<R, N>, CyclePins<R, N>, N>;

impl<'a, R: Recorder, const N: usize> CycleBoard<'a, R, N> {
    /// Switches on a board whose timer runs at `rate`; its edges go to `recorder`. A step costs as much as on
    /// an Uno.
    pub fn new(
        motors: [Motor; N],
        stands: [Stand; N],
        clock: Clock,
        rate: Rate,
        recorder: R,
    ) -> Self {
        let board = board(rate);
        let now = Now::default();
        let bit = |axis: usize| 1 << axis;
        let inverted = (0..N).filter(|n| motors[*n].inverted).map(bit).fold(0, |a, b| a | b);
        let shafts = Rc::new(RefCell::new(Shafts {
            now: now.clone(),
            recorder,
            inverted,
            forward: [true; N],
            at: [0; N],
            stands,
            closed: Switches::default(),
            enabled: None,
        }));
        let (pins, world) = (CyclePins(shafts.clone()), CyclePins(shafts.clone()));
        let timer = SimTimer::new(now.clone());
        let cycle = Cycle::new(timer, pins, world, motors, clock, board);
        for axis in 0..N as u8 {
            shafts.borrow_mut().look(axis);
        }
        CycleBoard { now, shafts, cycle }
    }

    /// The present, in ticks since the board was switched on.
    pub fn now(&self) -> u64 {
        self.now.get()
    }

    /// The cycle of the motors.
    pub fn cycle(&mut self) -> &mut Cycle<'a, SimTimer<u32, Now>, impl Drive, impl MachineIo, N> {
        &mut self.cycle
    }

    /// Lets time pass until `time`, with all events up to and at `time`.
    pub fn run_until(&mut self, time: u64) {
        while self.pass(time) {}
        self.now.set(time.max(self.now.get()));
    }

    /// Lets time pass until the cycle is over. Never returns if it has no end.
    pub fn run_to_rest(&mut self) {
        while self.cycle.is_running() && !self.cycle.is_paused() {
            self.pass(u64::MAX);
        }
    }

    /// Goes on to the next event, at which several motors may step. False if the event is after `limit`.
    pub fn pass(&mut self, limit: u64) -> bool {
        let wake = self.cycle.timer().wake();
        if wake > limit {
            return false;
        }
        // A pulse may have taken longer than that.
        self.now.set(wake.max(self.now.get()));
        let before = self.shafts.borrow().closed;
        self.cycle.on_compare();
        if self.shafts.borrow().closed != before {
            // The interrupt of the switches' pins.
            self.cycle.look();
        }
        true
    }

    /// The recorder.
    pub fn with_recorder<T>(&mut self, look: impl FnOnce(&mut R) -> T) -> T {
        look(&mut self.shafts.borrow_mut().recorder)
    }
}

/// The virtual board at the end of a line. Its motors are on any pins.
impl<'a, R: Recorder, const N: usize> CycleHold<'a, N> for CycleBoard<'a, R, N> {
    type Timer = SimTimer<u32, Now>;
    type Drive = CyclePins<R, N>;
    type Io = CyclePins<R, N>;

    fn with<T>(
        &mut self,
        ask: impl FnOnce(&mut Cycle<'a, SimTimer<u32, Now>, CyclePins<R, N>, CyclePins<R, N>, N>) -> T,
    ) -> T {
        ask(&mut self.cycle)
    }

    fn wire(&mut self, _: u8, pins: &MotorPins) -> Result<(), u8> {
        // Ports A to L are known.
        let known = |code: u8| code < 96 || code == MotorPins::NO_PIN;
        let place = (0u8..).zip(pins.codes).find(|(_, code)| !known(*code));
        place.map_or(Ok(()), |(place, _)| Err(place))
    }

    fn about(&self) -> (Text, Text) {
        let about = flash_text!("stepwright-cycle virtual hz=16000000 axes=3 legs=24");
        (about, flash_text!(",brakes,home,tick"))
    }
}

/// The program `cycles` of a chip, on a virtual board.
pub type CycleLineBoard<'a, R, const N: usize> =
    ProgramBoard<Remote<'a, CycleBoard<'a, R, N>, N>, LONGEST>;

impl<'a, R: Recorder, const N: usize> CycleLineBoard<'a, R, N> {
    /// A board at the end of a line, with these motors and memory for legs.
    pub fn new(motors: CycleBoard<'a, R, N>, legs: &'a [Cell<Leg>]) -> Self {
        ProgramBoard::of(Remote::new(motors, legs), LOOK)
    }
}

impl<'a, R: Recorder, const N: usize> SimProgram for Remote<'a, CycleBoard<'a, R, N>, N> {
    fn pass_until(&mut self, time: u64) -> u64 {
        self.hold().run_until(time);
        self.hold().now()
    }
}
