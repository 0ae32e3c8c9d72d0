//! The engine and the device of a controller, in a static.

use core::cell::UnsafeCell;

use stepwright::drive::Drive;
use stepwright::timer::StepTimer;
use stepwright::{Board, EngineHandle, HoldOff, OrderedMotors, SharedEngine};
use stepwright_device::main_loop::{self, OnBoard, SerialPort};
use stepwright_device::{BoardIo, Device};

use crate::{AXES, Panel, PortIo, RUNS};

/// The main loop's way to the engine.
type Handle<T, D, H> = EngineHandle<T, D, H, AXES, RUNS>;

/// What a chip's program has in a static, for its step interrupt and for [`run`]: the engine, and the
/// device, which is made where it lies, as a second one would not fit a small stack. Zeros, which
/// take no flash.
#[repr(C)] // what each visit reads is near its beginning
pub struct ControllerEngine<T: StepTimer + 'static, D: 'static, H: 'static> {
    engine: SharedEngine<T, D, H, AXES, RUNS>,
    device: UnsafeCell<Device<'static, Handle<T, D, H>, AXES, RUNS>>,
}

// SAFETY: the device is the main loop's: `run`, which is the one that has filled the engine, which
// is done once. The engine looks after itself.
unsafe impl<T: StepTimer, D, H> Sync for ControllerEngine<T, D, H> where
    SharedEngine<T, D, H, AXES, RUNS>: Sync
{
}

impl<T: StepTimer, D: Drive, H: HoldOff> ControllerEngine<T, D, H> {
    /// No engine yet: its interrupt does nothing.
    pub const fn empty() -> Self {
        // SAFETY: `run` powers the motors up before anything else.
        let motors = unsafe { OrderedMotors::blank(EngineHandle::none()) };
        ControllerEngine {
            engine: SharedEngine::empty(),
            device: UnsafeCell::new(Device::blank(motors)),
        }
    }

    /// The step interrupt: see [`SharedEngine::on_compare`].
    ///
    /// # Safety
    /// Called by the interrupt that `H` holds off, and by nothing else.
    #[inline(always)]
    pub unsafe fn on_compare(&self) -> bool {
        // SAFETY: the caller's promise.
        unsafe { self.engine.on_compare() }
    }
}

/// The controller: fills the engine, and serves the line for good.
pub fn run<T: StepTimer, D: Drive, H: HoldOff>(
    shared: &'static ControllerEngine<T, D, H>,
    timer: T,
    drive: D,
    board: Board<AXES>,
    panel: impl Panel,
    line: &mut impl SerialPort,
) -> ! {
    let mut io = PortIo::new(panel, board.rate);
    if let Some(device) = begin(shared, timer, drive, &board, &mut io) {
        main_loop::run(&mut OnBoard { device, io }, line);
    }
    // Somebody else has filled it, which no program does.
    loop {
        core::hint::spin_loop();
    }
}

/// Makes engine and device, once. A frame of its own, which is left before the main loop.
#[inline(never)]
#[allow(clippy::mut_from_ref, reason = "an engine is filled once")]
fn begin<T: StepTimer, D: Drive, H: HoldOff>(
    shared: &'static ControllerEngine<T, D, H>,
    timer: T,
    drive: D,
    board: &Board<AXES>,
    io: &mut impl BoardIo,
) -> Option<&'static mut Device<'static, Handle<T, D, H>, AXES, RUNS>> {
    let (engine, feeds) = shared.engine.fill(timer, drive, board)?;
    // SAFETY: an engine is filled once, so nobody else comes here.
    let device = unsafe { &mut *shared.device.get() };
    device.motors_mut().fill(engine, feeds, board);
    device.begin(AXES as u8, io);
    Some(device)
}
