//! The timers of the examples keep the contract of `StepTimer`.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Instant;

use stepwright::timer::Count;
use stepwright_port_test::{TestPort, TimerProbe, check};

#[allow(dead_code)]
#[path = "../examples/10_interrupt.rs"]
mod interrupt;
#[allow(dead_code)]
#[path = "../examples/07_your_own_board.rs"]
mod your_own_board;

/// Time passes only here.
struct OwnBoard(TimerProbe<your_own_board::Timer>);

impl TestPort for OwnBoard {
    type Timer = your_own_board::Timer;

    fn with<R>(&mut self, ask: impl FnOnce(&mut TimerProbe<Self::Timer>) -> R) -> R {
        let answer = ask(&mut self.0);
        Self::tick(self.0.timer());
        answer
    }
    fn idle(&mut self) {
        let timer = self.0.timer();
        // The counter of the example jumps, so it does not match in between.
        if !timer.compare.is_after(timer.count) {
            self.0.on_compare();
        }
    }
    fn tick(timer: &mut Self::Timer) {
        timer.count = timer.count.wrapping_add(1);
    }
    fn set_count(&mut self, count: u32) -> bool {
        self.0.timer().count = count;
        true
    }
}

#[test]
fn the_timer_of_your_own_board_keeps_the_contract() {
    let checked = check(&mut OwnBoard(TimerProbe::new(your_own_board::Timer::default())), 20);
    assert!(checked.is_ok_and(|checked| checked.wrapped), "{checked:?}");
}

/// A thread stands for the interrupt.
struct Threaded(Arc<Mutex<TimerProbe<interrupt::Timer>>>);

impl TestPort for Threaded {
    type Timer = interrupt::Timer;

    fn with<R>(&mut self, ask: impl FnOnce(&mut TimerProbe<Self::Timer>) -> R) -> R {
        ask(&mut self.0.lock().unwrap())
    }
    fn idle(&mut self) {
        thread::yield_now();
    }
}

#[test]
fn the_timer_of_the_interrupt_keeps_the_contract() {
    let probe = Arc::new(Mutex::new(TimerProbe::new(interrupt::Timer(Instant::now()))));
    let done = Arc::new(AtomicBool::new(false));
    let (own, over) = (Arc::clone(&probe), Arc::clone(&done));
    <interrupt::Interrupt as stepwright::HoldOff>::release();
    let serving = thread::spawn(move || {
        interrupt::serve(|| own.lock().unwrap().on_compare(), &over);
    });
    // A thread may wait seconds for a processor.
    let checked = check(&mut Threaded(probe), 60_000_000);
    done.store(true, Ordering::Relaxed);
    serving.join().unwrap();
    assert!(checked.is_ok_and(|checked| !checked.wrapped), "{checked:?}");
}
