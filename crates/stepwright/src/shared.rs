//! An engine that an interrupt plays and the main loop orders about.
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

/// Holds the step interrupt off, and none that is more urgent: its enable bit in the timer or in the
/// interrupt controller. Those that are less urgent are best held off with it (BASEPRI on a
/// Cortex-M3 and better): one that comes in between makes the step interrupt wait for its own end.
///
/// # Safety
/// From the return of [`hold`](HoldOff::hold) to [`release`](HoldOff::release) the interrupt that calls
/// [`SharedEngine::on_compare`] MUST NOT run, on any core, nor before the first `release`. Both
/// MUST be barriers for the compiler, and for the processor where it needs one: on a Cortex-M
/// `NVIC::mask` with `dsb` and `isb` behind it. What is pending when `hold` comes, or becomes so
/// before `release`, MUST come after `release`.
pub unsafe trait HoldOff {
    /// Holds the interrupt off. Calls do not nest.
    fn hold();
    /// Lets the interrupt come.
    fn release();
}

/// The engine of an interrupt.
type Shared<T, D, const N: usize, const Q: usize> = Engine<T, D, Consumer<'static, Q>, N>;

/// A place for an engine and its queues, for a static that the step interrupt and the main loop
/// share.
///
/// The main loop holds off the step interrupt alone, for the microseconds that a call takes; the
/// interrupt takes no lock. Empty, it takes no flash. The crate `critical-section` decides
/// who fills it first, once; of its implementations the program chooses that of its chip.
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
#[repr(C)] // what each visit reads is near its beginning
pub struct SharedEngine<T: StepTimer, D, H, const N: usize, const Q: usize = 8> {
    /// There is an engine.
    filled: AtomicBool,
    /// Somebody fills it, or has filled it.
    taken: Mutex<Cell<bool>>,
    engine: UnsafeCell<MaybeUninit<Shared<T, D, N, Q>>>,
    queues: [Queue<Q>; N],
    interrupt: PhantomData<fn() -> H>,
}

// SAFETY: the engine is written by `fill`, once, before `filled` says that it is there and the
// interrupt is let in. From then on it is reached by the interrupt, and by the one handle while
// the interrupt is held off: see `HoldOff`. The engine itself may go from one to the other: `Send`.
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
    /// No engine yet: its interrupt does nothing.
    pub const fn empty() -> Self {
        SharedEngine {
            engine: UnsafeCell::new(MaybeUninit::uninit()),
            queues: [const { Queue::new() }; N],
            taken: Mutex::new(Cell::new(false)),
            filled: AtomicBool::new(false),
            interrupt: PhantomData,
        }
    }

    /// Makes the engine of a timer that counts and of the pins, and lets the step interrupt in.
    /// Returns the main loop's hold on it and the feeds of its queues, for
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
        // SAFETY: this is the only call that comes here, and it asks once for each queue.
        let feeds = self.queues.each_ref().map(|queue| unsafe { queue.producer(WIRING) });
        let entries = self.queues.each_ref().map(Queue::consumer);
        // SAFETY: `filled` is false, so nobody else looks.
        let engine = unsafe { &mut *self.engine.get() };
        let engine = engine.write(Engine::off(timer, drive, entries, board.timing, board.rate));
        engine.begin();
        self.filled.store(true, Ordering::Release);
        H::release();
        Some((EngineHandle { shared: Some(self), one_thread: PhantomData }, feeds))
    }

    /// The step interrupt: see [`Engine::on_compare`]. True if there is news for the main loop:
    /// a queue has room for more, a travel has ended, or a step was late. A main loop that sleeps
    /// is to be woken then. One that plans at such news alone, and not every few milliseconds, gives its
    /// motors the handle in a [`ByNews`](crate::ByNews), or slow axes step late.
    ///
    /// # Safety
    /// Called by the interrupt that `H` holds off, and by nothing else.
    #[inline]
    pub unsafe fn on_compare(&self) -> bool {
        // An interrupt that was not held off at power-up finds nothing.
        self.filled.load(Ordering::Acquire)
            // SAFETY: it is there, and the handle holds this interrupt off while it has it.
            && unsafe { (*self.engine.get()).assume_init_mut() }.on_compare()
    }
}

/// The main loop's hold on the engine in a [`SharedEngine`].
pub struct EngineHandle<
    T: StepTimer + 'static,
    D: 'static,
    H: 'static,
    const N: usize,
    const Q: usize,
> {
    /// `None` before [`fill`](SharedEngine::fill).
    shared: Option<&'static SharedEngine<T, D, H, N, Q>>,
    /// Not for two threads at once, as some calls go by a shared reference.
    one_thread: PhantomData<Cell<()>>,
}

impl<T: StepTimer, D: Drive, H: HoldOff, const N: usize, const Q: usize>
    EngineHandle<T, D, H, N, Q>
{
    /// No engine yet, for [blank](crate::OrderedMotors::blank) motors in a static: zeros, which take no
    /// flash.
    ///
    /// # Safety
    /// Nothing is asked of it: [`OrderedMotors::fill`](crate::OrderedMotors::fill) puts another in its
    /// place.
    pub const unsafe fn none() -> Self {
        EngineHandle { shared: None, one_thread: PhantomData }
    }

    fn with<R>(&self, ask: impl FnOnce(&mut Shared<T, D, N, Q>) -> R) -> R {
        // SAFETY: `fill` made this handle; of one without an engine nobody asks.
        let shared = unsafe { self.shared.unwrap_unchecked() };
        H::hold();
        // SAFETY: `fill` made the engine and this handle, of which there is one; the interrupt is
        // held off, and `ask` of one call does not reach another.
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
        // Asked often, and long to compute: the interrupt waits for the look alone. By an address that is
        // computed here: a step may wait for what comes behind it.
        let track = black_box(track);
        H::hold();
        // SAFETY: as in `with`, parts of that engine.
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
