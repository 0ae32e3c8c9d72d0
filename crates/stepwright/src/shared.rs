//! An engine that a step interrupt runs and the main loop controls.
//!
//! ```text
//!   main loop                              step interrupt
//!   Steppers ─► EngineHandle ─► SharedEngine ◄─ on_compare ◄─ the timer
//!                 hold … release   │  engine, queues
//!                                  └► any other interrupt comes as it likes
//! ```

use core::cell::{Cell, UnsafeCell};
use core::hint::black_box;
use core::marker::PhantomData;
use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicBool, Ordering};

use critical_section::Mutex;

use crate::board::Board;
use crate::control::Control;
use crate::drive::{Axes, Drive};
use crate::engine::{Engine, Playing, Report, Timing, WIRING};
use crate::queue::{Consumer, Producer, Queue};
use crate::timer::StepTimer;

/// Holds the step interrupt off, and no more urgent one: by its enable bit in the timer or in the
/// interrupt controller. It is best to hold off less urgent interrupts too (BASEPRI on a Cortex-M3
/// and better): if one comes in between, the step interrupt waits until it ends.
///
/// # Safety
/// From the return of [`hold`](HoldOff::hold) to [`release`](HoldOff::release), and before the
/// first `release`, the interrupt that calls [`SharedEngine::on_compare`] MUST NOT run on any core.
/// Both calls MUST be barriers for the compiler, and for the processor where it needs one: on a
/// Cortex-M `NVIC::mask` followed by `dsb` and `isb`. A request that is pending at `hold`, or
/// becomes pending before `release`, MUST be served after `release`.
pub unsafe trait HoldOff {
    /// Holds the interrupt off. Calls do not nest.
    fn hold();
    /// Enables the interrupt again.
    fn release();
}

/// The engine of an interrupt.
type Shared<T, D, const N: usize, const Q: usize> = Engine<T, D, Consumer<'static, Q>, N>;

/// A place for an engine and its queues, for a static that the step interrupt and the main loop
/// share.
///
/// The main loop holds off only the step interrupt, for the microseconds that a call takes; the
/// interrupt takes no lock. While empty, the static takes no flash. The crate `critical-section`
/// ensures that it is filled only once; the program links the implementation of `critical-section`
/// for its chip.
///
/// ```
/// # use critical_section as _;
/// use stepwright::{Axis, Board, HoldOff, Rate, SharedEngine, Steppers};
/// # use stepwright::{drive::Drive, timer::StepTimer};
/// # struct Timer;
/// # impl StepTimer for Timer {
/// #     type Count = u32;
/// #     fn now(&mut self) -> u32 { 0 }
/// #     fn wake_at(&mut self, _: u32) {}
/// # }
/// # struct Pins;
/// # impl Drive for Pins {
/// #     fn begin(&mut self, _: u8) {}
/// #     fn end(&mut self, _: u8) {}
/// #     fn direction(&mut self, _: u8, _: bool) {}
/// # }
///
/// /// The interrupt of the timer, held off at power-up.
/// struct TimerInterrupt;
/// // SAFETY: the enable bit of that interrupt.
/// unsafe impl HoldOff for TimerInterrupt {
///     fn hold() { /* NVIC::mask(TIMER0), dsb, isb */ }
///     fn release() { /* NVIC::unmask(TIMER0) */ }
/// }
///
/// static ENGINE: SharedEngine<Timer, Pins, TimerInterrupt, 1> = SharedEngine::empty();
///
/// // The timer's interrupt.
/// fn on_compare() {
///     // SAFETY: called by that interrupt alone.
///     let _news = unsafe { ENGINE.on_compare() };
/// }
///
/// // The main function.
/// let board = Board::unmeasured(Rate::MHZ);
/// let (engine, feeds) = ENGINE.fill(Timer, Pins, &board).ok_or("filled twice")?;
/// let mut motors = Steppers::new(engine, feeds, board);
/// motors.move_to(Axis::X, 400)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[repr(C)] // the fields that each visit reads come first
pub struct SharedEngine<T: StepTimer, D, H, const N: usize, const Q: usize = 8> {
    /// Whether there is an engine.
    filled: AtomicBool,
    /// Whether it is being filled, or has been.
    taken: Mutex<Cell<bool>>,
    engine: UnsafeCell<MaybeUninit<Shared<T, D, N, Q>>>,
    queues: [Queue<Q>; N],
    interrupt: PhantomData<fn() -> H>,
}

// SAFETY: `fill` writes the engine once, before it sets `filled` and lets the interrupt in. From
// then on the interrupt accesses the engine, and so does the one handle while the interrupt is held
// off: see `HoldOff`. The engine may move between the two contexts: `Send`.
unsafe impl<T, D, H, const N: usize, const Q: usize> Sync for SharedEngine<T, D, H, N, Q>
where
    T: StepTimer + Send,
    T::Count: Send,
    D: Send,
{
}

impl<T: StepTimer, D: Drive, H: HoldOff, const N: usize, const Q: usize>
    SharedEngine<T, D, H, N, Q>
{
    /// A place without an engine: its interrupt does nothing.
    pub const fn empty() -> Self {
        SharedEngine {
            engine: UnsafeCell::new(MaybeUninit::uninit()),
            queues: [const { Queue::new() }; N],
            taken: Mutex::new(Cell::new(false)),
            filled: AtomicBool::new(false),
            interrupt: PhantomData,
        }
    }

    /// Makes the engine from a running timer and the pins, and enables the step interrupt. Returns
    /// the main loop's handle to the engine and the feeds of its queues, for
    /// [`Steppers`](crate::Steppers); `None` if it was filled before.
    pub fn fill(
        &'static self,
        timer: T,
        drive: D,
        board: &Board<N>,
    ) -> Option<(EngineHandle<T, D, H, N, Q>, [Producer<'static, Q>; N])> {
        if critical_section::with(|section| self.taken.borrow(section).replace(true)) {
            return None;
        }
        // SAFETY: only one call gets here, and it asks once for each queue.
        let feeds = self.queues.each_ref().map(|queue| unsafe { queue.producer(WIRING) });
        let entries = self.queues.each_ref().map(Queue::consumer);
        // SAFETY: `filled` is false, so nothing else accesses the engine.
        let engine = unsafe { &mut *self.engine.get() };
        let engine = engine.write(Engine::off(timer, drive, entries, board.timing, board.rate));
        engine.begin();
        self.filled.store(true, Ordering::Release);
        H::release();
        Some((EngineHandle { shared: Some(self), one_thread: PhantomData }, feeds))
    }

    /// The step interrupt: see [`Engine::on_compare`]. Returns true if there is news for the main
    /// loop: a queue has room for more, a travel has ended, or a step was late. Wake a sleeping
    /// main loop then. A main loop that plans only at such news, and not every few milliseconds,
    /// must wrap the handle in a [`ByNews`](crate::ByNews), or slow axes step late.
    ///
    /// # Safety
    /// Only the interrupt that `H` holds off may call this.
    #[inline]
    pub unsafe fn on_compare(&self) -> bool {
        // An interrupt that was not held off at power-up finds no engine.
        self.filled.load(Ordering::Acquire)
            // SAFETY: the engine exists, and the handle accesses it only while this interrupt is
            // held off.
            && unsafe { (*self.engine.get()).assume_init_mut() }.on_compare()
    }
}

/// The main loop's handle to the engine in a [`SharedEngine`].
pub struct EngineHandle<
    T: StepTimer + 'static,
    D: 'static,
    H: 'static,
    const N: usize,
    const Q: usize,
> {
    /// `None` before [`fill`](SharedEngine::fill).
    shared: Option<&'static SharedEngine<T, D, H, N, Q>>,
    /// Makes the handle `!Sync`, because some calls use a shared reference.
    one_thread: PhantomData<Cell<()>>,
}

impl<T: StepTimer, D: Drive, H: HoldOff, const N: usize, const Q: usize>
    EngineHandle<T, D, H, N, Q>
{
    /// A handle without an engine, for [blank](crate::OrderedMotors::blank) motors in a static:
    /// zeros, which take no flash.
    ///
    /// # Safety
    /// No method may be called on it: [`OrderedMotors::fill`](crate::OrderedMotors::fill) replaces
    /// it.
    pub const unsafe fn none() -> Self {
        EngineHandle { shared: None, one_thread: PhantomData }
    }

    fn with<R>(&self, ask: impl FnOnce(&mut Shared<T, D, N, Q>) -> R) -> R {
        // SAFETY: `fill` made this handle; a handle without an engine is never used.
        let shared = unsafe { self.shared.unwrap_unchecked() };
        H::hold();
        // SAFETY: `fill` made the engine and this handle, of which there is one; the interrupt is
        // held off, and the closures `ask` do not nest.
        let answer = ask(unsafe { (*shared.engine.get()).assume_init_mut() });
        H::release();
        answer
    }
}

impl<T: StepTimer, D: Drive, H: HoldOff, const N: usize, const Q: usize> Control
    for EngineHandle<T, D, H, N, Q>
{
    fn start(&mut self, axes: Axes) {
        self.with(|engine| engine.start(axes));
    }
    fn kill(&mut self, axes: Axes) {
        self.with(|engine| engine.kill(axes));
    }
    fn report(&self, axis: u8) -> Report {
        self.with(|engine| engine.report(axis))
    }
    fn is_idle(&self, axis: u8) -> bool {
        self.with(|engine| engine.is_idle(axis))
    }
    fn playing(&mut self, axis: u8) -> Playing {
        // SAFETY: as in `with`.
        let shared = unsafe { self.shared.unwrap_unchecked() };
        let engine = shared.engine.get().cast::<Shared<T, D, N, Q>>();
        let Some((timer, track)) = Engine::places(engine, axis) else { return Playing::Unknown };
        // Called often, and long to compute: the interrupt is held off only for the reading. The
        // address is computed before that, because a step may have to wait for what follows `hold`.
        let track = black_box(track);
        H::hold();
        // SAFETY: as in `with`; the places are parts of that engine.
        let seen = unsafe { (*track).glance((*timer).now()) };
        H::release();
        seen.playing()
    }
    fn set_position(&mut self, axis: u8, position: i64) {
        self.with(|engine| engine.set_position(axis, position));
    }
    fn set_timing(&mut self, timing: Timing) {
        self.with(|engine| engine.set_timing(timing));
    }
    fn late(&self) -> u32 {
        self.with(|engine| engine.late())
    }
    fn clear_late(&mut self) {
        self.with(|engine| engine.clear_late());
    }
}
