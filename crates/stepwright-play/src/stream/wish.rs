//! Orders to a running player, from another thread.

use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};

/// How a run shall continue. A greater value takes precedence.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum PlayWish {
    /// Run to the end.
    Go,
    /// Brake along the path, and wait there.
    Hold,
    /// Brake along the path, and drop the rest.
    Brake,
    /// Stop at once, without a ramp.
    Kill,
}

/// The wish that a run obeys, and the total time on hold. Times are s since its start.
#[derive(Clone, Copy, Debug)]
pub struct Obeyed {
    /// The wish.
    pub wish: PlayWish,
    /// The seconds of the holds before, and the time of the last change.
    held: f64,
    since: f64,
}

impl Default for Obeyed {
    fn default() -> Self {
        Obeyed { wish: PlayWish::Go, held: 0.0, since: 0.0 }
    }
}

impl Obeyed {
    /// Changes the wish at this time.
    pub fn then(self, wish: PlayWish, at: f64) -> Obeyed {
        Obeyed { wish, held: at - self.without_holds(at), since: at }
    }

    /// Converts a time to one without the holds before it.
    pub fn without_holds(self, at: f64) -> f64 {
        let present = if self.wish == PlayWish::Hold { (at - self.since).max(0.0) } else { 0.0 };
        at - self.held - present
    }
}

/// The present wish. A run may be held and resumed any number of times; an end can only be replaced
/// by a kill.
#[derive(Debug, Default)]
pub struct PlayOrder {
    held: AtomicBool,
    end: AtomicU8,
}

const BRAKE: u8 = 1;
const KILL: u8 = 2;

impl PlayOrder {
    /// Holds the run, or resumes it.
    pub fn hold(&self, held: bool) {
        self.held.store(held, Ordering::Relaxed);
    }

    /// Brakes the motors, and drops the rest.
    pub fn stop(&self) {
        self.end.fetch_max(BRAKE, Ordering::Relaxed);
    }

    /// Stops the motors at once.
    pub fn kill(&self) {
        self.end.fetch_max(KILL, Ordering::Relaxed);
    }

    /// The present wish.
    pub fn wish(&self) -> PlayWish {
        match self.end.load(Ordering::Relaxed) {
            BRAKE => PlayWish::Brake,
            KILL => PlayWish::Kill,
            _ if self.held.load(Ordering::Relaxed) => PlayWish::Hold,
            _ => PlayWish::Go,
        }
    }
}

/// How the playing of a file ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlayEnd {
    /// At the end of the file.
    Done,
    /// By an order to brake.
    Stopped,
    /// By an order to kill.
    Killed,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_end_is_sterner_than_a_hold() {
        let order = PlayOrder::default();
        order.hold(true);
        assert_eq!(order.wish(), PlayWish::Hold);
        order.hold(false);
        assert_eq!(order.wish(), PlayWish::Go);
        order.kill();
        order.stop();
        order.hold(true);
        assert_eq!(order.wish(), PlayWish::Kill);
    }

    #[test]
    fn the_time_of_holds_is_left_out() {
        let run = Obeyed::default();
        let held = run.then(PlayWish::Hold, 2.0);
        assert_eq!((run.without_holds(1.5), held.without_holds(7.0)), (1.5, 2.0));
        let again = held.then(PlayWish::Go, 5.0).then(PlayWish::Hold, 6.0).then(PlayWish::Go, 10.0);
        assert_eq!(again.without_holds(12.0), 5.0);
    }
}
