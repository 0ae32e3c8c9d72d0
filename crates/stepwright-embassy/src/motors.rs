//! Motors shared by several tasks of one executor, and their planner.

use core::cell::{Cell, RefCell};
use core::convert::Infallible;
use core::future::poll_fn;
use core::mem;
use core::pin::pin;
use core::task::{Context, Poll};

use stepwright::queue::Producer;
use stepwright::{Axis, AxisSet, Board, ByNews, Control, MoveError, Refusal, Steppers};

use crate::axis::AsyncAxis;
use crate::news::News;
use crate::outcome::Outcome;
use crate::waiters::Waiters;

/// N motors with moves as futures.
///
/// Made from the parts that [`SharedEngine::fill`](stepwright::SharedEngine::fill) returns. It
/// belongs to one executor, whose tasks share it by reference. One task, or a part of one, must run
/// the planner ([`plan`](Motors::plan)); without it nothing moves.
pub struct Motors<'q, E, const N: usize, const Q: usize = 8> {
    shared: RefCell<Shared<'q, E, N, Q>>,
    /// Axes whose futures were dropped while `shared` was borrowed, by seat: they brake after the
    /// borrow.
    released: Cell<[AxisSet<N>; SEATS]>,
    news: &'q News,
}

/// The state that the tasks share.
struct Shared<'q, E, const N: usize, const Q: usize> {
    steppers: Steppers<'q, ByNews<E>, N, Q>,
    places: [Place; N],
}

/// The number of futures of one axis: one that moves it, and one that has not yet seen the end of
/// the move before.
const SEATS: usize = 2;

/// The place of a future of an axis.
#[derive(Clone, Copy)]
enum Seat {
    Free,
    /// The future's move is under way.
    Owns,
    /// It has ended, and the future has not yet seen that.
    Ended(Outcome),
}

/// The state of an axis for the tasks that wait for it.
struct Place {
    /// The target of its move; `None` for a run.
    goal: Option<i64>,
    seats: [Seat; SEATS],
    /// Whether it brakes because its future was dropped during the move.
    dropped: bool,
    /// The tasks that wait for its rest.
    waiters: Waiters,
    /// Those that wait for its next move.
    watchers: Waiters,
}

impl Place {
    const FREE: Place = Place {
        goal: None,
        seats: [Seat::Free; SEATS],
        dropped: false,
        waiters: Waiters::NONE,
        watchers: Waiters::NONE,
    };

    /// Notes that its move has ended at this position, and wakes the tasks that wait for that.
    fn end(&mut self, position: Option<i64>) {
        self.dropped = false;
        let outcome = match position {
            None => Outcome::Uncertain,
            Some(at) if self.goal == Some(at) => Outcome::Reached { at },
            Some(at) => Outcome::Stopped { at },
        };
        for seat in self.seats.iter_mut().filter(|seat| matches!(seat, Seat::Owns)) {
            *seat = Seat::Ended(outcome);
        }
        self.waiters.wake();
    }
}

impl<E: Control, const N: usize, const Q: usize> Shared<'_, E, N, Q> {
    /// Notes which moves have ended, before others can begin or a position can change, and wakes the
    /// tasks that wait for axes now at rest, or now moving.
    fn settle(&mut self) {
        for (axis, place) in Axis::all().zip(&mut self.places) {
            if !self.steppers.is_moving(axis) {
                place.end(self.steppers.position(axis));
            } else {
                place.watchers.wake();
            }
        }
    }
}

impl<'q, E: Control, const N: usize, const Q: usize> Motors<'q, E, N, Q> {
    /// All motors at rest at position 0, with
    /// [`AxisLimits::DEFAULT`](stepwright::AxisLimits::DEFAULT).
    ///
    /// `engine` and `feeds` come from one [`fill`](stepwright::SharedEngine::fill), `board` is the
    /// one given to it, and the interrupt of that engine tells `news`. An engine whose interrupt does
    /// not come when an axis comes to rest, as that of a player of `stepwright-sink`, needs a
    /// [`tell`](News::tell) from a timer as well.
    pub const fn new(
        engine: E,
        feeds: [Producer<'q, Q>; N],
        board: Board<N>,
        news: &'q News,
    ) -> Self {
        let steppers = Steppers::new(ByNews::new(engine, &board), feeds, board);
        let shared = RefCell::new(Shared { steppers, places: [Place::FREE; N] });
        Motors { shared, released: Cell::new([AxisSet::NONE; SEATS]), news }
    }

    /// Plans ahead for all axes, for ever. Run it in a task of its own, or joined with the code
    /// that moves the motors; only one instance at a time.
    ///
    /// It sleeps until an order comes, the step interrupt has taken an entry from a queue, or an
    /// axis has come to rest. In a move it wakes at most two times more than the move has entries.
    /// While awake, it yields to other tasks after every run that it has planned: 3,000 to 7,000
    /// cycles.
    pub fn plan(&self) -> impl Future<Output = Infallible> {
        poll_fn(|context| {
            loop {
                if self.plan_once() {
                    // Other tasks come first.
                    context.waker().wake_by_ref();
                    return Poll::Pending;
                }
                if pin!(self.news.wait()).poll(context).is_pending() {
                    return Poll::Pending;
                }
            }
        })
    }

    /// Plans at most one run. Returns whether there may be more to plan.
    fn plan_once(&self) -> bool {
        let planned = self.ask(|shared| {
            let more = shared.steppers.poll() == Some(0);
            shared.settle();
            more
        });
        planned.unwrap_or(false)
    }

    /// A handle of an axis. Several tasks may hold handles of one axis: one can change or stop a
    /// move that another awaits.
    pub const fn axis(&self, axis: Axis<N>) -> AsyncAxis<'_, 'q, E, N, Q> {
        AsyncAxis { motors: self, axis }
    }

    /// Gives access to the motors themselves, for functions that this crate lacks and that need no
    /// waiting. Returns `None` within another `with`. No other call reaches the motors meanwhile:
    /// [`stop`](Motors::stop), [`kill`](Motors::kill) and [`fault`](Motors::fault) do nothing.
    ///
    /// A move that begins here belongs to no future, so it always goes on;
    /// [`rest`](AsyncAxis::rest) waits for its end. The future of an earlier move still gets the
    /// outcome of its own move, whenever it is polled.
    pub fn with<R>(&self, ask: impl FnOnce(&mut Steppers<'q, ByNews<E>, N, Q>) -> R) -> Option<R> {
        // It may have been an order.
        self.order(|shared| ask(&mut shared.steppers))
    }

    /// Brakes all axes along their ramps, as dropping their futures would. The positions stay
    /// known.
    pub fn stop(&self) {
        self.order(|shared| shared.steppers.stop(AxisSet::ALL));
    }

    /// Stops these axes at once, between two steps. A moving axis loses its position until it is
    /// set; its move ends as [`Outcome::Uncertain`].
    pub fn kill(&self, axes: impl Into<AxisSet<N>>) {
        let axes = axes.into();
        self.order(|shared| shared.steppers.kill(axes));
    }

    /// Brakes these axes along their ramps and makes their positions unknown, after a stall or a
    /// driver fault. Their moves end as [`Outcome::Uncertain`].
    pub fn fault(&self, axes: impl Into<AxisSet<N>>) {
        let axes = axes.into();
        self.order(|shared| {
            shared.steppers.stop(axes);
            shared.steppers.mark_unknown(axes);
        });
    }

    /// Waits until one of these axes moves, whoever moves it.
    pub fn motion(&self, axes: impl Into<AxisSet<N>>) -> impl Future<Output = ()> {
        let axes = axes.into();
        poll_fn(move |context| {
            let moves = self.ask(|Shared { steppers, places }| {
                for (axis, place) in Axis::all().zip(places) {
                    if axes.contains(axis) {
                        if steppers.is_moving(axis) {
                            return true;
                        }
                        place.watchers.add(context.waker());
                    }
                }
                false
            });
            if moves == Some(true) { Poll::Ready(()) } else { Poll::Pending }
        })
    }

    /// The number of late steps of all axes: see [`Steppers::late`].
    pub fn late(&self) -> u32 {
        self.ask(|shared| shared.steppers.late()).unwrap_or(0)
    }

    /// Borrows the shared state. `None` only within [`with`](Motors::with).
    fn ask<R>(&self, ask: impl FnOnce(&mut Shared<'q, E, N, Q>) -> R) -> Option<R> {
        let mut shared = self.shared.try_borrow_mut().ok()?;
        shared.settle();
        let answer = ask(&mut shared);
        drop(shared);
        // A woken waker may have owned the last reference to its task.
        for (seat, axes) in self.released.take().into_iter().enumerate() {
            for axis in axes.iter() {
                self.release(axis, seat);
            }
        }
        Some(answer)
    }

    /// Like `ask`, and tells the planner.
    fn order<R>(&self, ask: impl FnOnce(&mut Shared<'q, E, N, Q>) -> R) -> Option<R> {
        let answer = self.ask(ask);
        self.news.tell();
        answer
    }

    /// Reads or changes an axis without telling the planner.
    pub(crate) fn look<R>(
        &self,
        look: impl FnOnce(&mut Steppers<'q, ByNews<E>, N, Q>) -> R,
    ) -> Option<R> {
        self.ask(|shared| look(&mut shared.steppers))
    }

    /// Gives an order that may be refused.
    pub(crate) fn say(
        &self,
        order: impl FnOnce(&mut Steppers<'q, ByNews<E>, N, Q>) -> Result<(), MoveError>,
    ) -> Result<(), MoveError> {
        self.order(|shared| order(&mut shared.steppers)).unwrap_or(Err(Refusal::Busy.into()))
    }

    /// Begins a move to a goal, owned by a future. Returns the seat of that future.
    pub(crate) fn begin(
        &self,
        axis: Axis<N>,
        goal: impl FnOnce(&Steppers<'q, ByNews<E>, N, Q>) -> Option<i64>,
        order: impl FnOnce(&mut Steppers<'q, ByNews<E>, N, Q>) -> Result<(), MoveError>,
    ) -> Result<usize, MoveError> {
        let begun = self.order(|Shared { steppers, places }| {
            let place = places.get_mut(axis.index()).ok_or(Refusal::Busy)?;
            let owned = place.seats.iter().any(|seat| matches!(seat, Seat::Owns));
            let mut seats = place.seats.iter_mut().enumerate();
            let free = seats.find(|(_, seat)| !owned && matches!(seat, Seat::Free));
            let (number, seat) = free.ok_or(Refusal::Busy)?;
            let goal = goal(steppers);
            order(steppers)?;
            *seat = Seat::Owns;
            (place.goal, place.dropped) = (goal, false);
            Ok(number)
        });
        begun.unwrap_or(Err(Refusal::Busy.into()))
    }

    /// Ready once an axis no longer brakes because of a dropped future.
    pub(crate) fn poll_braked(&self, axis: Axis<N>, context: &Context<'_>) -> Poll<()> {
        let brakes = self.ask(|Shared { places, .. }| {
            let place = places.get_mut(axis.index())?;
            place.dropped.then(|| place.waiters.add(context.waker()))
        });
        if brakes.flatten().is_some() { Poll::Pending } else { Poll::Ready(()) }
    }

    /// Gives a move a new goal.
    pub(crate) fn retarget(&self, axis: Axis<N>, position: i64) -> Result<(), MoveError> {
        let changed = self.order(|Shared { steppers, places }| {
            steppers.retarget(axis, position)?;
            if let Some(place) = places.get_mut(axis.index()) {
                place.goal = Some(position);
            }
            Ok(())
        });
        changed.unwrap_or(Err(Refusal::Busy.into()))
    }

    /// The outcome of the move of the future at this seat, once it has ended.
    pub(crate) fn poll_end(
        &self,
        axis: Axis<N>,
        seat: usize,
        context: &Context<'_>,
    ) -> Poll<Outcome> {
        let ended = self.ask(|Shared { places, .. }| {
            let place = places.get_mut(axis.index())?;
            match *place.seats.get(seat)? {
                Seat::Ended(outcome) => Some(outcome),
                _ => {
                    place.waiters.add(context.waker());
                    None
                }
            }
        });
        ended.flatten().map_or(Poll::Pending, Poll::Ready)
    }

    /// The position of an axis, once it rests.
    pub(crate) fn poll_rest(&self, axis: Axis<N>, context: &Context<'_>) -> Poll<Option<i64>> {
        let rests = self.ask(|Shared { steppers, places }| {
            let place = places.get_mut(axis.index())?;
            if steppers.is_moving(axis) {
                place.waiters.add(context.waker());
                return None;
            }
            Some(steppers.position(axis))
        });
        rests.flatten().map_or(Poll::Pending, Poll::Ready)
    }

    /// Frees the seat of a future: its axis brakes if it still moves.
    pub(crate) fn release(&self, axis: Axis<N>, seat: usize) {
        let moved = self.ask(|Shared { steppers, places }| {
            let Some(place) = places.get_mut(axis.index()) else { return false };
            let Some(own) = place.seats.get_mut(seat) else { return false };
            let moves = matches!(mem::replace(own, Seat::Free), Seat::Owns);
            if moves {
                place.dropped = true;
                steppers.stop(axis);
            }
            moves
        });
        match moved {
            Some(true) => self.news.tell(),
            Some(false) => {}
            None => {
                let mut released = self.released.get();
                if let Some(axes) = released.get_mut(seat) {
                    *axes |= axis;
                }
                self.released.set(released);
            }
        }
    }
}
