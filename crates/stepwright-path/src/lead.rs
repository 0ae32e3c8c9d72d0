//! A plan that is ahead of what is made, and can be taken back.
//!
//! ```text
//!   behind                            kept                    ahead
//!   ──┴─────────────────────────────────┴───────────────────────┴────►  steps
//!     what is made by now               cut: a plan from here on
//! ```
//!
//! A machine that is fed some time before it moves takes steps of the plan *ahead*. A second plan
//! is where the machine is, *behind*: it is asked for the same steps, and told the same between
//! the same steps, so it comes to the same. A [`cut`](Lead::cut) takes a copy of it to the last step
//! that is kept, and goes on from there.

use std::collections::VecDeque;

use crate::route::RouteStep;

/// A plan whose steps depend on nothing but what it was told, and after how many steps.
pub trait Planned: Clone {
    /// What it is told.
    type Order: Clone + std::fmt::Debug;

    /// The next step; `None` if there is none before it is told something.
    fn step(&mut self) -> Option<RouteStep>;

    /// Takes an order.
    fn obey(&mut self, order: &Self::Order);

    /// Whether an order stays one if steps before it are taken back.
    fn stays(order: &Self::Order) -> bool;
}

/// What a plan was told, or that it had no step.
type Told<P> = Option<<P as Planned>::Order>;

/// A plan ahead of a machine.
#[derive(Clone, Debug)]
pub struct Lead<P: Planned> {
    ahead: P,
    behind: P,
    /// Steps that the plan behind has yet to make, from number `done` on.
    steps: VecDeque<RouteStep>,
    done: u64,
    /// What the plan ahead was told, before the step of this number.
    told: VecDeque<(u64, Told<P>)>,
    /// The plan without the last cut.
    uncut: Option<Box<Uncut<P>>>,
}

#[derive(Clone, Debug)]
struct Uncut<P: Planned> {
    ahead: P,
    steps: VecDeque<RouteStep>,
    done: u64,
    told: VecDeque<(u64, Told<P>)>,
    /// Steps that the cut keeps, and orders since.
    keep: u64,
    since: Vec<P::Order>,
}

impl<P: Planned> Lead<P> {
    /// Nothing is made, nor ahead.
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

    /// Steps that are made.
    pub fn done(&self) -> u64 {
        self.done
    }

    /// Steps that are planned.
    pub fn made(&self) -> u64 {
        self.done + self.steps.len() as u64
    }

    /// The next step ahead; `None` if there is none before an order.
    pub fn plan(&mut self) -> Option<RouteStep> {
        match self.ahead.step() {
            Some(step) => {
                self.steps.push_back(step);
                Some(step)
            }
            None => {
                // Asked again without an order between, it says the same.
                let now = self.made();
                if !matches!(self.told.back(), Some((at, None)) if *at == now) {
                    self.told.push_back((now, None));
                    self.settle();
                }
                None
            }
        }
    }

    /// An order, behind the last step ahead.
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

    /// The next step that the machine makes, if that is due by `time`.
    pub fn pass(&mut self, time: f64) -> Option<RouteStep> {
        // Whether it is another behind a cut is not known yet.
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

    /// Plans again behind the first `steps` steps, which are made all the same: with `changes`, and all
    /// orders that stay. At least what is made is kept.
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

    /// The last cut stays.
    pub fn keep_cut(&mut self) {
        if self.uncut.take().is_some() {
            self.settle();
        }
    }

    /// The last cut was none. Orders that came since are obeyed behind what was planned before it.
    pub fn undo_cut(&mut self) {
        let Some(uncut) = self.uncut.take() else { return };
        let Uncut { ahead, mut steps, done, mut told, keep, since } = *uncut;
        // The same as the plan behind was told meanwhile.
        steps.drain(..((self.done - done) as usize).min(steps.len()));
        if let Some(most) = keep.checked_sub(1) {
            while pop::<P>(&mut told, self.done.min(most)).is_some() {}
        }
        (self.ahead, self.steps, self.told) = (ahead, steps, told);
        for order in since {
            self.obey(order);
        }
    }

    /// The plan behind is told what the one ahead was told here.
    fn settle(&mut self) {
        // Nothing of a cut that may be undone.
        let most = self.uncut.as_ref().map_or(Some(u64::MAX), |uncut| uncut.keep.checked_sub(1));
        let Some(most) = most else { return };
        while let Some(next) = pop::<P>(&mut self.told, self.done.min(most)) {
            hear(&mut self.behind, &next.1);
        }
    }
}

/// The first, if it was told before the step of this number.
fn pop<P: Planned>(told: &mut VecDeque<(u64, Told<P>)>, step: u64) -> Option<(u64, Told<P>)> {
    if told.front()?.0 <= step { told.pop_front() } else { None }
}

fn hear<P: Planned>(plan: &mut P, told: &Told<P>) {
    match told {
        Some(order) => plan.obey(order),
        None => _ = plan.step(),
    }
}
