//! Motor cycles over the serial line, on a chip of 32 bits: three motors on the board's own pins.

use core::cell::{Cell, UnsafeCell};
use core::marker::PhantomData;
use core::mem::MaybeUninit;

use stepwright::drive::{Axes, Drive};
use stepwright::timer::StepTimer;
use stepwright::{Board, HoldOff};
use stepwright_cycle::line::{LONGEST, MotorPins};
use stepwright_cycle::{Clock, Cycle, CycleHold, Leg, MachineIo, Motor, Remote, Switches};
use stepwright_device::ProgramDevice;
use stepwright_device::main_loop::{self, SerialPort};
use stepwright_protocol::{Text, flash_text};

use crate::kept::KeptMark;
use crate::{AXES, Panel};

/// The legs of all series.
const LEGS: usize = 64;

/// The codes of a motor's pins, which are the bits of the board's port: STEP, DIR, the enable pin
/// of all motors, and the motor's switch, at either end. A line that wires a motor names these; it
/// may omit all but STEP and DIR.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CyclePins {
    /// STEP.
    pub step: u8,
    /// DIR.
    pub direction: u8,
    /// The enable pin. Low switches the drivers on.
    pub enable: u8,
    /// The switch, to ground; `MotorPins::NO_PIN` for none.
    pub switch: u8,
}

impl CyclePins {
    /// The pin that a line may name at each place.
    const fn codes(&self) -> [u8; 5] {
        [self.step, self.direction, self.enable, self.switch, self.switch]
    }
}

/// The pins around the motors, for a cycle.
pub struct CycleIo<P> {
    panel: P,
    /// The motors whose switch is at the minimum, and those whose switch is at the maximum.
    ends: Switches,
}

impl<P: Panel> MachineIo for CycleIo<P> {
    #[inline(always)]
    fn switches(&mut self) -> Switches {
        if self.ends.min | self.ends.max == 0 {
            return Switches::NONE;
        }
        let closed = !self.panel.switches();
        Switches { min: closed & self.ends.min, max: closed & self.ends.max }
    }

    fn enable(&mut self, axes: Axes) {
        self.panel.set_enable(axes == 0); // on while it is low
    }
}

type Motors<T, D, P> = Cycle<'static, T, D, CycleIo<P>, AXES>;

/// The static that a chip's step interrupt and main loop share: motors and the legs of their
/// series.
pub struct ControllerCycle<T: StepTimer + 'static, D: 'static, H: 'static, P: 'static> {
    cycle: UnsafeCell<MaybeUninit<Motors<T, D, P>>>,
    legs: UnsafeCell<[Cell<Leg>; LEGS]>,
    hold_off: PhantomData<H>,
}

// SAFETY: the main loop uses the motors while the interrupt is held off, the interrupt otherwise;
// the legs are written while no cycle runs, and read by the cycle.
unsafe impl<T: StepTimer + Send, D: Send, H, P: Send> Sync for ControllerCycle<T, D, H, P> {}

impl<T: StepTimer, D: Drive, H: HoldOff, P: Panel> ControllerCycle<T, D, H, P> {
    /// No motors yet.
    pub const fn empty() -> Self {
        ControllerCycle {
            cycle: UnsafeCell::new(MaybeUninit::uninit()),
            legs: UnsafeCell::new([const { Cell::new(Leg::Steps { count: 0, delay: 0 }) }; LEGS]),
            hold_off: PhantomData,
        }
    }

    /// The step interrupt.
    ///
    /// # Safety
    /// Called by the interrupt that `H` holds off, and by nothing else.
    #[inline(always)]
    pub unsafe fn on_compare(&self) {
        // SAFETY: `run` has set the motors before it let the interrupt in, and holds it off while
        // it uses them.
        unsafe { (*self.cycle.get()).assume_init_mut() }.on_compare();
    }

    /// Sets up the motors, and serves the rows of `stepwright_cycle::line` for ever. `about` is the
    /// answer to `?`: the board, its timer's rate, `axes=3 legs=64`.
    ///
    /// # Safety
    /// Called once, while the step interrupt is held off.
    pub unsafe fn run(
        &'static self,
        (timer, drive, mut panel): (T, D, P),
        board: Board<AXES>,
        pins: [CyclePins; AXES],
        about: Text,
        line: &mut impl SerialPort,
    ) -> ! {
        let marks = KeptMark(panel.reset());
        let io = CycleIo { panel, ends: Switches::NONE };
        let motors = [Motor::new(1, 1); AXES];
        let cycle = Cycle::new(timer, drive, io, motors, Clock::Deadlines, board);
        // SAFETY: the caller's promise.
        unsafe { (*self.cycle.get()).write(cycle) };
        // SAFETY: cells, and this is the only reference to them.
        let legs = unsafe { &*self.legs.get() };
        let hold = Held { shared: self, pins, about };
        let remote = Remote::new(hold, legs);
        let mut device: ProgramDevice<_, _, LONGEST> = ProgramDevice::new(remote, marks);
        loop {
            device.program().hold().with(|cycle| cycle.surroundings().panel.feed());
            main_loop::round(&mut device, line);
        }
    }
}

/// The main loop's handle to the motors.
struct Held<T: StepTimer + 'static, D: 'static, H: 'static, P: 'static> {
    shared: &'static ControllerCycle<T, D, H, P>,
    pins: [CyclePins; AXES],
    about: Text,
}

impl<T: StepTimer, D: Drive, H: HoldOff, P: Panel> CycleHold<'static, AXES> for Held<T, D, H, P> {
    type Timer = T;
    type Drive = D;
    type Io = CycleIo<P>;

    #[inline(always)]
    fn with<R>(&mut self, ask: impl FnOnce(&mut Motors<T, D, P>) -> R) -> R {
        H::hold();
        // SAFETY: the interrupt is held off, and `run` has set the motors.
        let answer = ask(unsafe { (*self.shared.cycle.get()).assume_init_mut() });
        H::release();
        answer
    }

    fn wire(&mut self, motor: u8, pins: &MotorPins) -> Result<(), u8> {
        let own = self.pins.get(usize::from(motor)).ok_or(0u8)?.codes();
        let none = |code: u8| code == MotorPins::NO_PIN;
        for ((place, code), own) in (0u8..).zip(pins.codes).zip(own) {
            if code != own && (place < 2 || !none(code)) {
                return Err(place);
            }
        }
        let [.., min, max] = pins.codes;
        if !none(min) && !none(max) {
            // A motor has only one switch.
            return Err(4);
        }
        self.with(|cycle| {
            let ends = &mut cycle.surroundings().ends;
            for (end, code) in [(&mut ends.min, min), (&mut ends.max, max)] {
                *end &= !(1 << motor);
                *end |= Axes::from(!none(code)) << motor;
            }
        });
        Ok(())
    }

    fn about(&self) -> (Text, Text) {
        (self.about, flash_text!(",brakes,home,tick"))
    }
}
