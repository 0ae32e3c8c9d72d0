//! A plan that is ahead of the machine, and can be taken back.
//!
//! ```text
//!   behind                            kept                    ahead
//!   ──┴─────────────────────────────────┴───────────────────────┴────►  steps
//!     what is made by now               cut: a plan from here on
//! ```
//!
//! A machine that gets its steps some time before it moves takes them from the plan *ahead*. A second plan,
//! *behind*, is where the machine is. It is asked for the same steps, and gets the same orders between the same
//! steps, so it arrives at the same state. A [`cut`](Lead::cut) takes a copy of the plan behind to the last
//! step that is kept, and continues from there.

use std::collections::VecDeque;

use crate::route::RouteStep;

/// A plan whose steps depend only on its orders, and on the steps after which it gets them.
pub trait Planned: Clone {
    /// An order to the plan.
    type Order: Clone + std::fmt::Debug;

    /// The next step; `None` if there is none before another order.
    fn step(&mut self) -> Option<RouteStep>;

    /// Takes an order.
    fn obey(&mut self, order: &Self::Order);

    /// Whether an order stays valid if steps before it are taken back.
    fn stays(order: &Self::Order) -> bool;
}

/// An order that a plan got, or `None` where it had no step.
type Told<P> = Option<<P as Planned>::Order>;

/// A plan ahead of a machine.
#[derive(Clone, Debug)]
pub struct Lead<P: Planned> {
    ahead: P,
    behind: P,
    /// The steps that the plan behind has yet to make, from number `done` on.
    steps: VecDeque<RouteStep>,
    done: u64,
    /// What the plan ahead was told before the step with this number.
    told: VecDeque<(u64, Told<P>)>,
    /// The state without the last cut.
    uncut: Option<Box<Uncut<P>>>,
}

#[derive(Clone, Debug)]
struct Uncut<P: Planned> {
    ahead: P,
    steps: VecDeque<RouteStep>,
    done: u64,
    told: VecDeque<(u64, Told<P>)>,
    /// The number of steps that the cut keeps, and the orders since then.
    keep: u64,
    since: Vec<P::Order>,
}

impl<P: Planned> Lead<P> {
    /// A plan without any steps yet.
    pub fn new(plan: P) -> Lead<P> {
        Lead {
            behind: plan.clone(),
            ahead: plan,
            steps: VecDeque::new(),
            done: 0,
            told: VecDeque::new(),
            uncut: None,
        }
    }

    /// The plan where the machine is.
    pub fn behind(&self) -> &P {
        &self.behind
    }

    /// The plan ahead.
    pub fn ahead(&self) -> &P {
        &self.ahead
    }

    /// The number of steps that the machine has made.
    pub fn done(&self) -> u64 {
        self.done
    }

    /// The number of steps that were planned, those of the machine included.
    pub fn made(&self) -> u64 {
        self.done + self.steps.len() as u64
    }

    /// Plans the next step; `None` if there is none before another order.
    pub fn plan(&mut self) -> Option<RouteStep> {
        match self.ahead.step() {
            Some(step) => {
                self.steps.push_back(step);
                Some(step)
            }
            None => {
                // Asked again without an order in between, the plan has no step either.
                let now = self.made();
                if !matches!(self.told.back(), Some((at, None)) if *at == now) {
                    self.told.push_back((now, None));
                    self.settle();
                }
                None
            }
        }
    }

    /// Gives an order after the last planned step.
    pub fn obey(&mut self, order: P::Order) {
        self.ahead.obey(&order);
        if let Some(uncut) = &mut self.uncut
            && P::stays(&order)
        {
            uncut.since.push(order.clone());
        }
        self.told.push_back((self.made(), Some(order)));
        self.settle();
    }

    /// Returns the next step that the machine makes, if it is due by `time`.
    pub fn pass(&mut self, time: f64) -> Option<RouteStep> {
        // While the cut can be undone, the step after it is not known.
        if self.uncut.as_ref().is_some_and(|uncut| self.done >= uncut.keep) {
            return None;
        }
        let step = *self.steps.front().filter(|step| step.time <= time)?;
        self.steps.pop_front();
        let same = self.behind.step();
        debug_assert_eq!(same, Some(step), "step {}", self.done);
        self.done += 1;
        self.settle();
        Some(step)
    }

    /// Plans again after the first `steps` steps, which are made in any case: with `changes`, and all orders
    /// that stay valid. Steps that are made already are always kept.
    pub fn cut(&mut self, steps: u64, changes: &[P::Order]) {
        let mut plan = self.behind.clone();
        let (mut at, mut told) = (self.done, std::mem::take(&mut self.told));
        let mut kept = VecDeque::new();
        let keep = steps.max(self.done).min(self.made());
        loop {
            while let Some(next) = pop::<P>(&mut told, at) {
                hear(&mut plan, &next.1);
                kept.push_back(next);
            }
            if at >= keep {
                break;
            }
            let same = plan.step();
            debug_assert_eq!(same.as_ref(), self.steps.get((at - self.done) as usize));
            at += 1;
        }
        let later: Vec<P::Order> =
            told.iter().filter_map(|next| next.1.clone()).filter(P::stays).collect();
        self.uncut = Some(Box::new(Uncut {
            ahead: std::mem::replace(&mut self.ahead, plan),
            steps: self.steps.clone(),
            done: self.done,
            told: kept.iter().cloned().chain(told).collect(),
            keep,
            since: Vec::new(),
        }));
        self.told = kept;
        self.steps.truncate((keep - self.done) as usize);
        for order in changes.iter().cloned().chain(later) {
            self.ahead.obey(&order);
            self.told.push_back((keep, Some(order)));
        }
        self.settle();
    }

    /// Makes the last cut final.
    pub fn keep_cut(&mut self) {
        if self.uncut.take().is_some() {
            self.settle();
        }
    }

    /// Undoes the last cut. Orders that came since are obeyed after the steps that were planned before it.
    pub fn undo_cut(&mut self) {
        let Some(uncut) = self.uncut.take() else { return };
        let Uncut { ahead, mut steps, done, mut told, keep, since } = *uncut;
        // Without what the plan behind has made and was told meanwhile.
        steps.drain(..((self.done - done) as usize).min(steps.len()));
        if let Some(most) = keep.checked_sub(1) {
            while pop::<P>(&mut told, self.done.min(most)).is_some() {}
        }
        (self.ahead, self.steps, self.told) = (ahead, steps, told);
        for order in since {
            self.obey(order);
        }
    }

    /// Tells the plan behind what the plan ahead was told up to this step.
    fn settle(&mut self) {
        // Nothing after a cut that can be undone.
        let most = self.uncut.as_ref().map_or(Some(u64::MAX), |uncut| uncut.keep.checked_sub(1));
        let Some(most) = most else { return };
        while let Some(next) = pop::<P>(&mut self.told, self.done.min(most)) {
            hear(&mut self.behind, &next.1);
        }
    }
}

/// Removes and returns the first, if it was told before the step with this number.
fn pop<P: Planned>(told: &mut VecDeque<(u64, Told<P>)>, step: u64) -> Option<(u64, Told<P>)> {
    if told.front()?.0 <= step { told.pop_front() } else { None }
}

fn hear<P: Planned>(plan: &mut P, told: &Told<P>) {
    match told {
        Some(order) => plan.obey(order),
        None => _ = plan.step(),
    }
}
