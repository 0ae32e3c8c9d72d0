//! Several axes on one path: lines, arcs and circles under one ramp, with the
//! speed along the path held. Planned on a host, in floating point.
//!
//! A [`Law`] says when the path is where; a curve ([`Line`], [`Arc`]) says where
//! on it each axis steps; [`Steps`] joins the two to what a cycle plays
//! ([`Program::Paced`](stepwright::cycle::Program::Paced)). A hold brakes along
//! the path and goes on along it: all axes stay on it.
//!
//! ```
//! use stepwright::Rate;
//! use stepwright_path::{Line, Pace, Steps};
//! let line = Line { steps: [300, -100], step: [1.0, 1.0] };
//! let [x, y] = Steps::line(&line, Pace::new(500.0, 2_000.0), Rate::MHZ, 1_000)?;
//! let sum = |steps: Steps| steps.map(|pace| u64::from(pace.ticks)).sum::<u64>();
//! assert_eq!((sum(x.clone()), x.count()), (sum(y.clone()), 300));
//! # Ok::<(), stepwright_path::Unplannable>(())
//! ```

mod curve;
mod law;

use std::sync::{Arc as Shared, Mutex, PoisonError};

use stepwright::{Rate, Ticks, cycle};

pub use curve::{Arc, Line, Mark, Marks};
pub use law::{Law, Pace, Unplannable};

/// A law that several axes follow, and that may be held up while they do.
#[derive(Clone, Debug)]
pub struct Held(Shared<Mutex<Law>>);

impl Held {
    fn look<T>(&self, look: impl FnOnce(&mut Law) -> T) -> T {
        look(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// [`Law::hold`]. Each axis has asked for one step ahead, which stays where it
    /// was planned.
    pub fn hold(&self, at: f64, until: Option<f64>) {
        self.look(|law| law.hold(at, until));
    }

    /// [`Law::duration`].
    pub fn duration(&self) -> f64 {
        self.look(|law| law.duration())
    }
}

/// The steps of one axis in ticks of a timer, for
/// [`Program::Paced`](stepwright::cycle::Program::Paced).
///
/// Each is at the nearest tick to its time; nothing gathers.
#[derive(Clone, Debug)]
pub struct Steps {
    marks: Marks,
    law: Held,
    hz: f64,
    lead: Ticks,
    /// Ticks from the start to the last step.
    gone: u64,
}

impl Steps {
    fn all<const N: usize>(
        marks: [Marks; N],
        law: Law,
        rate: Rate,
        lead: Ticks,
    ) -> ([Steps; N], Held) {
        let law = Held(Shared::new(Mutex::new(law)));
        let hz = f64::from(rate.hz());
        let steps = marks.map(|marks| Steps { marks, law: law.clone(), hz, lead, gone: 0 });
        (steps, law)
    }

    /// Of a line. The first steps come `lead` ticks after the start.
    ///
    /// # Errors
    /// [`Unplannable`].
    pub fn line<const N: usize>(
        line: &Line<N>,
        pace: Pace,
        rate: Rate,
        lead: Ticks,
    ) -> Result<[Steps; N], Unplannable> {
        let marks = line.marks()?;
        Ok(Steps::all(marks, Law::new(line.length(), pace)?, rate, lead).0)
    }

    /// Of an arc; it begins `lead` ticks after the start.
    ///
    /// # Errors
    /// [`Unplannable`].
    pub fn arc(arc: &Arc, pace: Pace, rate: Rate, lead: Ticks) -> Result<[Steps; 2], Unplannable> {
        let marks = arc.marks()?;
        Ok(Steps::all(marks, Law::new(arc.length(), pace)?, rate, lead).0)
    }

    /// The law that they follow, with all other axes.
    pub fn law(&self) -> Held {
        self.law.clone()
    }
}

impl Iterator for Steps {
    type Item = cycle::Pace;

    fn next(&mut self) -> Option<cycle::Pace> {
        let mark = self.marks.next()?;
        // Beyond the place where it stands for good there are no steps.
        let time = self.law.look(|law| law.time(mark.at))?;
        let due = (time * self.hz).round() as u64 + u64::from(self.lead);
        let ticks = Ticks::try_from(due.saturating_sub(self.gone)).unwrap_or(Ticks::MAX);
        self.gone = self.gone.saturating_add(ticks.into());
        Some(cycle::Pace { ticks, forward: mark.forward })
    }
}
