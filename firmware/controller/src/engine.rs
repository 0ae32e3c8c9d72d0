//! The engine and the device of a controller, in a static.

use core::cell::UnsafeCell;

use stepwright::drive::Drive;
use stepwright::timer::StepTimer;
use stepwright::{Board, EngineHandle, HoldOff, OrderedMotors, SharedEngine};
use stepwright_device::main_loop::{self, OnBoard, SerialPort};
use stepwright_device::{BoardIo, Device};

use crate::{AXES, Panel, PortIo, RUNS};

/// The main loop's handle to the engine.
type Handle<T, D, H> = EngineHandle<T, D, H, AXES, RUNS>;

/// The static that a chip's step interrupt and [`run`] share: the engine, and the device, which is
/// set up in place, because a second one would not fit a small stack. It is all zeros, which take
/// no flash.
#[repr(C)] // // the fields that each visit reads are near the beginning
pub struct ControllerEngine<T: StepTimer + 'static, D: 'static, H: 'static> {
    engine: SharedEngine<T, D, H, AXES, RUNS>,
    device: UnsafeCell<Device<'static, Handle<T, D, H>, AXES, RUNS>>,
}

// SAFETY: the device belongs to the main loop: to `run`, after it has filled the engine, which
// happens once. The engine protects itself.
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

/// Runs the controller: fills the engine, and serves the line for ever.
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
    // The engine was filled elsewhere, which no program does.
    loop {
        core::hint::spin_loop();
    }
}

/// Sets up engine and device, once. In a stack frame of its own, which is released before the main
/// loop.
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
    // SAFETY: an engine is filled once, so this is reached once.
    let device = unsafe { &mut *shared.device.get() };
    device.motors_mut().fill(engine, feeds, board);
    device.begin(AXES as u8, io);
    Some(device)
}
