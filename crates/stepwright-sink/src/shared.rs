//! A sink shared by an interrupt, which keeps it filled, and the main loop, which gives the orders.

use core::cell::{Cell, UnsafeCell};
use core::marker::PhantomData;
use core::mem::{ManuallyDrop, MaybeUninit};
use core::sync::atomic::{AtomicBool, Ordering};

use critical_section::Mutex;
use stepwright::drive::Axes;
use stepwright::queue::{Producer, Queue};
use stepwright::{Board, Control, HoldOff, Playing, Report, Ticks, Timing};

use crate::engine::SinkEngine;
use crate::player::Player;

/// A place for a [`SinkEngine`] and its queues, in a static that the player's interrupt and the main loop
/// share. It is to a sink what [`SharedEngine`](stepwright::SharedEngine) is to an engine of steps.
///
/// The main loop holds off that one interrupt for the microseconds that a call takes. The interrupt takes no
/// lock. An empty place takes no flash.
///
/// ```
/// # use critical_section as _;
/// use stepwright::{Axis, AxisLimits, Accel, Board, Cost, HoldOff, Rate, Speed, Steppers};
/// use stepwright_sink::SharedSink;
/// # type Pio = stepwright_sink::ModelPlayer<1>;
///
/// /// The interrupt of the player, held off at power-up.
/// struct PioInterrupt;
/// // SAFETY: the enable bit of that interrupt.
/// unsafe impl HoldOff for PioInterrupt {
///     fn hold() { /* NVIC::mask(PIO0_IRQ_0), dsb, isb */ }
///     fn release() { /* NVIC::unmask(PIO0_IRQ_0) */ }
/// }
///
/// static SINK: SharedSink<Pio, PioInterrupt, 1> = SharedSink::empty();
///
/// // The player's interrupt, of axis 0.
/// fn on_group() {
///     // SAFETY: called by that interrupt alone.
///     let _news = unsafe { SINK.serve(1) };
/// }
///
/// // The main function. An axis makes 250,000 steps/s at most.
/// let rate = Rate::of::<125_000_000>();
/// let cost = Cost::independent(500);
/// let mut board = Board::<1> { cost, ..Board::unmeasured(rate) };
/// board.set_drivers(rate.micros(1), rate.micros(1), rate.micros(1));
/// # let pio = Pio::default();
/// let (engine, feeds) = SINK.fill(pio, &board, rate.micros(1)).ok_or("filled twice")?;
/// let mut motors = Steppers::new(engine, feeds, board);
/// motors.set_limits(Axis::X, AxisLimits::new(Speed::of::<100_000>(), Accel::of::<200_000>()));
/// motors.move_to(Axis::X, 20_000)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct SharedSink<P: 'static, H, const N: usize, const Q: usize = 8> {
    engine: UnsafeCell<MaybeUninit<SinkEngine<'static, P, N, Q>>>,
    queues: UnsafeCell<[Queue<Q>; N]>,
    /// Set by the first call of `fill`.
    taken: Mutex<Cell<bool>>,
    /// Set once the engine is there.
    filled: AtomicBool,
    interrupt: PhantomData<fn() -> H>,
}

// SAFETY: engine and queues are made by `fill`, once, before `filled` says that they are there and the
// interrupt is let in. From then on the engine is reached by the interrupt, and by the one handle while
// that is held off: see `HoldOff`. The player may go from one to the other: `Send`.
unsafe impl<P: Send, H, const N: usize, const Q: usize> Sync for SharedSink<P, H, N, Q> {}

impl<P: Player, H: HoldOff, const N: usize, const Q: usize> SharedSink<P, H, N, Q> {
    /// An empty place: the interrupt does nothing.
    pub const fn empty() -> Self {
        SharedSink {
            engine: UnsafeCell::new(MaybeUninit::uninit()),
            queues: UnsafeCell::new([const { Queue::new() }; N]),
            taken: Mutex::new(Cell::new(false)),
            filled: AtomicBool::new(false),
            interrupt: PhantomData,
        }
    }

    /// Makes the engine over a player, with a bound as for [`SinkEngine::new`], and lets the interrupt in.
    /// Returns the main loop's handle and the feeds of the queues, for [`Steppers`](stepwright::Steppers);
    /// `None` if the place was filled before.
    pub fn fill(
        &'static self,
        player: P,
        board: &Board<N>,
        bound: Ticks,
    ) -> Option<(SinkHandle<P, H, N, Q>, [Producer<'static, Q>; N])> {
        if critical_section::with(|section| self.taken.borrow(section).replace(true)) {
            return None;
        }
        // SAFETY: this is the only call that comes here: nobody else has a reference to them.
        let queues = unsafe { &mut *self.queues.get() };
        let ends = ManuallyDrop::new(queues.each_mut().map(Queue::split));
        // SAFETY: each end is taken out once, and the array is not looked at or dropped again.
        let feeds = ends.each_ref().map(|(feed, _)| unsafe { core::ptr::read(feed) });
        // SAFETY: likewise.
        let entries = ends.each_ref().map(|(_, entries)| unsafe { core::ptr::read(entries) });
        let engine = SinkEngine::new(player, entries, board.timing, bound);
        // SAFETY: `filled` is false, so nobody else looks.
        unsafe { (*self.engine.get()).write(engine) };
        self.filled.store(true, Ordering::Release);
        H::release();
        Some((SinkHandle { shared: self, one_thread: PhantomData }, feeds))
    }

    /// For the player's interrupt, when a group of one of these axes has begun: see [`SinkEngine::serve`].
    ///
    /// # Safety
    /// To be called only by the interrupt that `H` holds off.
    #[inline]
    pub unsafe fn serve(&self, axes: Axes) -> bool {
        // An interrupt that was not held off at power-up finds no engine.
        self.filled.load(Ordering::Acquire)
            // SAFETY: it is there, and the handle holds this interrupt off while it has it.
            && unsafe { (*self.engine.get()).assume_init_mut() }.serve(axes)
    }
}

/// The main loop's handle on the engine in a [`SharedSink`].
///
/// While a travel is in progress the main loop must poll the motors, or ask whether they move. These calls
/// restart a player that stood still because nothing was planned.
pub struct SinkHandle<P: 'static, H: 'static, const N: usize, const Q: usize> {
    shared: &'static SharedSink<P, H, N, Q>,
    /// Not `Sync`: some calls need a shared reference only.
    one_thread: PhantomData<Cell<()>>,
}

impl<P: Player, H: HoldOff, const N: usize, const Q: usize> SinkHandle<P, H, N, Q> {
    fn with<R>(&self, ask: impl FnOnce(&mut SinkEngine<'static, P, N, Q>) -> R) -> R {
        H::hold();
        // SAFETY: `fill` made the engine and this handle, of which there is one; the interrupt is
        // held off, and `ask` of one call does not reach another.
        let answer = ask(unsafe { (*self.shared.engine.get()).assume_init_mut() });
        H::release();
        answer
    }
}

impl<P: Player, H: HoldOff, const N: usize, const Q: usize> Control for SinkHandle<P, H, N, Q> {
    fn start(&mut self, axes: Axes) {
        self.with(|engine| engine.start(axes));
    }
    fn kill(&mut self, axes: Axes) {
        self.with(|engine| engine.kill(axes));
    }
    fn report(&self, axis: u8) -> Report {
        self.with(|engine| {
            engine.catch_up();
            engine.report(axis)
        })
    }
    fn is_idle(&self, axis: u8) -> bool {
        self.with(|engine| {
            engine.catch_up();
            engine.is_idle(axis)
        })
    }
    fn playing(&mut self, axis: u8) -> Playing {
        self.with(|engine| engine.playing(axis))
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
    fn refill(&mut self) {
        self.with(|engine| engine.refill());
    }
}
