//! What whoever plays a file is told meanwhile, from another thread.

use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};

/// How a run is to go on: the sterner, the greater.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Wish {
    /// To its end.
    Go,
    /// It brakes along its path, and stands there.
    Hold,
    /// It brakes along its path: the rest is not made.
    Brake,
    /// Dead, at once.
    Kill,
}

/// What a run does, and for how long it was held. Times are s since its start.
#[derive(Clone, Copy, Debug)]
pub struct Obeyed {
    pub wish: Wish,
    /// Seconds of the holds before, and since when it does what it does.
    held: f64,
    since: f64,
}

impl Default for Obeyed {
    fn default() -> Self {
        Obeyed { wish: Wish::Go, held: 0.0, since: 0.0 }
    }
}

impl Obeyed {
    /// From this time on it does something else.
    pub fn then(self, wish: Wish, at: f64) -> Obeyed {
        Obeyed { wish, held: at - self.without_holds(at), since: at }
    }

    /// A time without the holds up to then.
    pub fn without_holds(self, at: f64) -> f64 {
        let present = if self.wish == Wish::Hold { (at - self.since).max(0.0) } else { 0.0 };
        at - self.held - present
    }
}

/// What is wished. A run may be held and go on any number of times; an end is only ever sterner.
#[derive(Debug, Default)]
pub struct PlayOrder {
    held: AtomicBool,
    end: AtomicU8,
}

const BRAKE: u8 = 1;
const KILL: u8 = 2;

impl PlayOrder {
    /// The motors brake and stand, or go on.
    pub fn hold(&self, held: bool) {
        self.held.store(held, Ordering::Relaxed);
    }

    /// The motors brake, and the rest is not played.
    pub fn stop(&self) {
        self.end.fetch_max(BRAKE, Ordering::Relaxed);
    }

    /// Nothing more is played.
    pub fn kill(&self) {
        self.end.fetch_max(KILL, Ordering::Relaxed);
    }

    /// How it is to go on.
    pub fn wish(&self) -> Wish {
        match self.end.load(Ordering::Relaxed) {
            BRAKE => Wish::Brake,
            KILL => Wish::Kill,
            _ if self.held.load(Ordering::Relaxed) => Wish::Hold,
            _ => Wish::Go,
        }
    }
}

/// How a file was played to its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Played {
    /// All of it.
    Done,
    /// Up to an order to brake.
    Stopped,
    /// Up to an order to kill.
    Killed,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_end_is_sterner_than_a_hold() {
        let order = PlayOrder::default();
        order.hold(true);
        assert_eq!(order.wish(), Wish::Hold);
        order.hold(false);
        assert_eq!(order.wish(), Wish::Go);
        order.kill();
        order.stop();
        order.hold(true);
        assert_eq!(order.wish(), Wish::Kill);
    }

    #[test]
    fn the_time_of_holds_is_left_out() {
        let run = Obeyed::default();
        let held = run.then(Wish::Hold, 2.0);
        assert_eq!((run.without_holds(1.5), held.without_holds(7.0)), (1.5, 2.0));
        let again = held.then(Wish::Go, 5.0).then(Wish::Hold, 6.0).then(Wish::Go, 10.0);
        assert_eq!(again.without_holds(12.0), 5.0);
    }
}
