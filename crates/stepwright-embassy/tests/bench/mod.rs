//! A board in simulated time, and an executor that sleeps on it.
//!
//! Only the engine is the library's: the time, the pins and the count of entries are made here.
#![allow(dead_code)] // shared with the driver's tests, and each uses its part

use std::cell::{Cell, RefCell};
use std::future::Future;
use std::ops::Deref;
use std::pin::Pin;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Context, Poll, Wake, Waker};

use stepwright::drive::{Axes, Drive};
use stepwright::entry::Play;
use stepwright::queue::{Consumer, Loaded, Queue, Source};
use stepwright::timer::StepTimer;
use stepwright::{
    Accel, Axis, AxisLimits, Board, Control, Engine, Playing, Rate, Report, Speed, Timing,
};
use stepwright_embassy::{Motors, News};
use stepwright_sim::HardStop;

pub const HZ: u64 = 1_000_000;
pub const AXES: usize = 3;

/// The present time, and the time at which the compare register matches.
#[derive(Clone, Default)]
pub struct Time(Rc<Cell<(u64, u64)>>);

impl Time {
    pub fn now(&self) -> u64 {
        self.0.get().0
    }
    fn set(&self, now: u64) {
        self.0.set((now, self.0.get().1));
    }
}

impl StepTimer for Time {
    type Count = u32;

    fn now(&mut self) -> u32 {
        self.0.get().0 as u32
    }
    fn wake_at(&mut self, at: u32) {
        let now = self.0.get().0;
        let ahead = at.wrapping_sub(now as u32) as i32;
        self.0.set((now, now + ahead.max(0) as u64));
    }
    fn hold_until(&mut self, at: u32) {
        let ahead = at.wrapping_sub(StepTimer::now(self)) as i32;
        self.set(self.0.get().0 + ahead.max(0) as u64);
    }
}

/// The positions of the motors according to their pins, and the times of their steps.
#[derive(Default)]
pub struct Shafts {
    backward: [bool; AXES],
    /// The hard stops of some motors.
    pub stops: [Option<HardStop>; AXES],
    pub at: [i64; AXES],
    pub steps: [Vec<u64>; AXES],
}

struct Wires(Rc<RefCell<Shafts>>, Time);

impl Drive for Wires {
    fn begin(&mut self, axes: Axes) {
        let shafts = &mut *self.0.borrow_mut();
        for axis in (0..AXES).filter(|axis| axes >> axis & 1 != 0) {
            let backward = shafts.backward[axis];
            shafts.at[axis] += if backward { -1 } else { 1 };
            if let Some(stop) = &mut shafts.stops[axis] {
                stop.step(!backward);
            }
            shafts.steps[axis].push(self.1.now());
        }
    }
    fn end(&mut self, _: Axes) {}
    fn direction(&mut self, axis: u8, forward: bool) {
        self.0.borrow_mut().backward[usize::from(axis)] = !forward;
    }
}

/// Counts the entries that the engine takes.
struct Counted<'q>(Consumer<'q, 8>, Rc<Cell<usize>>);

impl Source for Counted<'_> {
    const IS_QUEUE: bool = true;

    fn load(&mut self, play: &mut Play) -> Loaded {
        let loaded = self.0.load(play);
        self.1.set(self.1.get() + usize::from(loaded == Loaded::Entry));
        loaded
    }
    fn look_ahead(&mut self) {
        self.0.look_ahead();
    }
    fn clear(&mut self, forward: bool) {
        self.0.clear(forward);
    }
}

type Played<'q> = Engine<Time, Wires, Counted<'q>, AXES>;

/// The engine, shared by the interrupt and the motors as on a chip.
pub struct Handle<'q>(Rc<RefCell<Played<'q>>>);

impl Control for Handle<'_> {
    fn start(&mut self, axes: Axes) {
        self.0.borrow_mut().start(axes);
    }
    fn kill(&mut self, axes: Axes) {
        self.0.borrow_mut().kill(axes);
    }
    fn report(&self, axis: u8) -> Report {
        self.0.borrow().report(axis)
    }
    fn playing(&mut self, axis: u8) -> Playing {
        self.0.borrow_mut().playing(axis)
    }
    fn set_position(&mut self, axis: u8, position: i64) {
        self.0.borrow_mut().set_position(axis, position);
    }
    fn set_timing(&mut self, timing: Timing) {
        self.0.borrow_mut().set_timing(timing);
    }
    fn late(&self) -> u32 {
        self.0.borrow().late()
    }
    fn clear_late(&mut self) {
        self.0.borrow_mut().clear_late();
    }
}

pub type Moved<'q> = Motors<'q, Handle<'q>, AXES>;

/// The board without its motors.
pub struct Bench<'q> {
    engine: Rc<RefCell<Played<'q>>>,
    news: &'q News,
    pub entries: Rc<Cell<usize>>,
    /// How often news of the step interrupt ended the executor's sleep.
    pub wakings: Cell<usize>,
    pub around: Rc<Around>,
}

/// The surroundings of the motors.
#[derive(Default)]
pub struct Around {
    pub time: Time,
    pub shafts: Rc<RefCell<Shafts>>,
    alarms: RefCell<Vec<(u64, Waker)>>,
    /// Tasks that look at a pin after each interrupt.
    watchers: RefCell<Vec<Waker>>,
}

impl Deref for Bench<'_> {
    type Target = Around;
    fn deref(&self) -> &Around {
        &self.around
    }
}

/// A task, and whether it must be polled.
type Task<'t> = (Option<Pin<Box<dyn Future<Output = ()> + 't>>>, Arc<Awake>);

struct Awake(AtomicBool);

impl Wake for Awake {
    fn wake(self: Arc<Self>) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Makes a board of three axes at 1 MHz, and calls `play` with it.
pub fn with<R>(play: impl FnOnce(&Bench<'_>, &Moved<'_>) -> R) -> R {
    let (mut queues, news) = (Queues::default(), News::new());
    let (bench, motors) = built(&mut queues, &news);
    play(&bench, &motors)
}

/// The same board, leaked, for tests that keep their motors for ever.
pub fn leaked() -> (&'static Bench<'static>, &'static Moved<'static>) {
    let (bench, motors) = built(Box::leak(Box::default()), Box::leak(Box::default()));
    (Box::leak(Box::new(bench)), Box::leak(Box::new(motors)))
}

type Queues = [Queue<8>; AXES];

fn built<'q>(queues: &'q mut Queues, news: &'q News) -> (Bench<'q>, Moved<'q>) {
    let (around, entries) = (Rc::new(Around::default()), Rc::new(Cell::new(0)));
    let time = &around.time;
    let board = Board::unmeasured(Rate::of::<{ HZ as u32 }>());
    let wires = Wires(Rc::clone(&around.shafts), time.clone());
    let [x, y, z] = queues.each_mut().map(|queue| queue.split());
    let sources = [x.1, y.1, z.1].map(|entry| Counted(entry, Rc::clone(&entries)));
    let engine = Engine::new(time.clone(), wires, sources, board.timing, board.rate);
    let engine = Rc::new(RefCell::new(engine));
    let motors = Motors::new(Handle(Rc::clone(&engine)), [x.0, y.0, z.0], board, news);
    for axis in Axis::all() {
        motors.axis(axis).set_limits(AxisLimits::new(Speed::of::<2_000>(), Accel::of::<20_000>()));
    }
    (Bench { engine, news, entries, wakings: Cell::new(0), around }, motors)
}

impl Around {
    /// Wakes a task after the next interrupt or alarm.
    pub fn watch(&self, context: &Context<'_>) {
        self.watchers.borrow_mut().push(context.waker().clone());
    }

    /// Waits until this many milliseconds have passed.
    pub async fn after(&self, ms: u64) {
        self.after_us(ms * 1_000).await;
    }

    /// Waits until this many microseconds have passed.
    pub async fn after_us(&self, us: u64) {
        let due = self.time.now() + us * HZ / 1_000_000;
        std::future::poll_fn(|context| {
            if self.time.now() >= due {
                return Poll::Ready(());
            }
            self.alarms.borrow_mut().push((due, context.waker().clone()));
            Poll::Pending
        })
        .await;
    }
}

impl Bench<'_> {
    /// Runs the planner and these tasks until the tasks have ended and the motors rest.
    pub fn run<'t>(
        &self,
        motors: &'t Moved<'_>,
        tasks: impl IntoIterator<Item = Pin<Box<dyn Future<Output = ()> + 't>>>,
    ) {
        let planner: Pin<Box<dyn Future<Output = ()> + 't>> = Box::pin(async {
            motors.plan().await;
        });
        let mut tasks: Vec<Task<'t>> = [planner]
            .into_iter()
            .chain(tasks)
            .map(|task| (Some(task), Arc::new(Awake(AtomicBool::new(true)))))
            .collect();
        loop {
            poll(&mut tasks);
            assert!(self.time.now() < 7_200 * HZ, "two hours, and no end");
            let done = tasks[1..].iter().all(|(task, _)| task.is_none());
            let rests = (0..AXES as u8).all(|axis| self.engine.borrow().is_idle(axis));
            let alarm = self.alarms.borrow().iter().map(|(due, _)| *due).min();
            if done && rests && alarm.is_none() {
                return;
            }
            assert!(!rests || alarm.is_some(), "asleep, and nothing will wake it");
            self.sleep(alarm.unwrap_or(u64::MAX));
        }
    }

    /// Lets time pass until the step interrupt has news, or until an alarm.
    fn sleep(&self, until: u64) {
        while self.time.0.get().1 <= until {
            self.time.set(self.time.0.get().1.max(self.time.now()));
            let news = self.engine.borrow_mut().on_compare();
            if news {
                self.wakings.set(self.wakings.get() + 1);
                self.news.tell();
            }
            let watchers = self.watchers.take();
            if news || !watchers.is_empty() {
                return watchers.into_iter().for_each(Waker::wake);
            }
        }
        self.time.set(until);
        self.watchers.take().into_iter().for_each(Waker::wake);
        let alarms = self.alarms.take();
        let (due, later) = alarms.into_iter().partition(|(due, _)| *due <= until);
        self.alarms.replace(later);
        let due: Vec<(u64, Waker)> = due;
        due.into_iter().for_each(|(_, waker)| waker.wake());
    }
}

/// Polls the tasks that are awake, until all sleep.
fn poll(tasks: &mut [Task<'_>]) {
    // No round of planning takes this many polls.
    for _ in 0..10_000 {
        let mut all_sleep = true;
        for (task, awake) in &mut *tasks {
            if !awake.0.swap(false, Ordering::Relaxed) {
                continue;
            }
            all_sleep = false;
            let waker = Waker::from(Arc::clone(awake));
            if let Some(future) = task
                && future.as_mut().poll(&mut Context::from_waker(&waker)).is_ready()
            {
                *task = None;
            }
        }
        if all_sleep {
            return;
        }
    }
    panic!("the executor never sleeps");
}
