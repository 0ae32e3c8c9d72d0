//! Requests whose answer waits for the end of their order.
//!
//! The end of each axis is noted as soon as it rests: another order may move it again before the other axes of
//! a line rest.

use stepwright_host::{Conversation, LinkError};
use stepwright_protocol::AxisId;

use crate::jobs::Job;
use crate::keeper::{Keeper, KeeperDesk};
use crate::report::{AxisEnd, Done, OrderEnd};
use crate::sight::{Watched, reason};
use crate::{Declined, Wish, homing};

/// A request that waits.
pub struct WaitingJob {
    job: Job,
    /// The lines that the board has accepted.
    lines: Vec<String>,
    /// The axes of the order, and their ends.
    axes: Vec<(AxisId, Option<Rest>)>,
}

/// The end of an axis.
struct Rest {
    end: AxisEnd,
    /// Why its homing has failed, and the remedy.
    failed: Option<(String, Option<String>)>,
    /// That it is homed, in words.
    homed: Option<String>,
}

impl<D: KeeperDesk> Keeper<D> {
    /// Answers a job whose order has begun: now, or when the order has ended.
    pub(crate) fn answer(&mut self, mut job: Job, lines: Vec<String>) {
        job.begins();
        let axes: Vec<AxisId> = match &job.wish {
            _ if !job.waits => Vec::new(),
            Wish::Travel(axis, ..) | Wish::Run(axis, ..) | Wish::Home(axis, ..) => vec![*axis],
            Wish::Line(ways, _) => ways.iter().map(|(axis, _)| *axis).collect(),
            _ => Vec::new(),
        };
        if axes.is_empty() {
            job.answer(Ok(Done { lines, ended: None }));
            return;
        }
        let axes = axes.into_iter().map(|axis| (axis, None)).collect();
        self.waiting.push(WaitingJob { job, lines, axes });
    }

    /// Whether a request waits for the end of an order of this axis.
    fn is_awaited(&self, axis: AxisId) -> bool {
        let mut axes = self.waiting.iter().flat_map(|one| &one.axes);
        axes.any(|(one, rest)| *one == axis && rest.is_none())
    }

    /// Notes the ends of the axes that rest, and answers the requests whose order has ended.
    pub(crate) async fn settle(&mut self, talk: &mut Conversation) -> Result<(), LinkError> {
        let rests = |axis: &&Watched| !axis.moving && axis.homing.is_none();
        let ended: Vec<_> = self.axes.iter().filter(rests).map(|axis| axis.id).collect();
        let ended: Vec<_> = ended.into_iter().filter(|axis| self.is_awaited(*axis)).collect();
        if ended.is_empty() {
            return Ok(());
        }
        // The reasons of the stops.
        self.ask_why(talk).await?;
        for axis in ended {
            let position = talk.rest_position(axis).await?;
            if let Some(watched) = self.axes.get_mut(axis.index()) {
                watched.see(self.desk.time(), position);
            }
            let Some(watched) = self.axes.get(axis.index()) else { continue };
            for waiting in &mut self.waiting {
                let homed = matches!(waiting.job.wish, Wish::Home(..));
                for (_, rest) in
                    waiting.axes.iter_mut().filter(|(one, rest)| *one == axis && rest.is_none())
                {
                    *rest = Some(Rest::of(watched, homed));
                }
            }
        }
        // The next request sees this state.
        self.publish();
        let is_over = |one: &mut WaitingJob| one.axes.iter().all(|(_, rest)| rest.is_some());
        for over in self.waiting.extract_if(.., is_over) {
            let rests: Vec<_> = over.axes.into_iter().filter_map(|(_, rest)| rest).collect();
            over.job.answer(Ok(Done { lines: over.lines, ended: Some(concluded(rests)) }));
        }
        Ok(())
    }

    /// Notes that this axis rests, even if it was not looked at: another order comes next.
    pub(crate) async fn ended(
        &mut self,
        talk: &mut Conversation,
        axis: AxisId,
    ) -> Result<(), LinkError> {
        if !self.is_awaited(axis) {
            return Ok(());
        }
        if let Some(watched) = self.axes.get_mut(axis.index()) {
            watched.moving = false;
        }
        self.settle(talk).await
    }

    /// Answers all requests that wait: the ends of their orders are unknown.
    pub(crate) fn give_up_waiting(&mut self, what: &str) {
        let why = Declined::away(what).remedy("a motor may be moving: look at it");
        self.waiting.drain(..).for_each(|one| one.job.answer(Err(why.clone())));
    }
}

impl Rest {
    fn of(watched: &Watched, homed: bool) -> Rest {
        let home = watched.home.clone().filter(|_| homed);
        let (done, failed) = match home {
            Some(home) if home.stage == "done" => (Some(home.words), None),
            Some(home) => (None, Some((home.words, home.remedy))),
            // A kill clears the report of a homing that was stopped.
            None if homed => (None, Some((homing::stopped().what, None))),
            None => (None, None),
        };
        let (position, target) = (watched.position, watched.target.filter(|_| !homed));
        // A homed axis was stopped by its switch, as intended.
        let there = if homed { done.is_some() } else { position.is_some() && position == target };
        Rest {
            end: AxisEnd {
                axis: watched.id.number(),
                position,
                target,
                stop: watched.stop.filter(|_| !there).map(reason),
            },
            failed,
            homed: done,
        }
    }
}

/// The end of an order, from the ends of its axes.
fn concluded(rests: Vec<Rest>) -> OrderEnd {
    let lost = rests.iter().find(|rest| rest.end.position.is_none());
    // An endless run has no target, and ends only by a stop.
    let elsewhere = rests.iter().find(|rest| {
        rest.failed.is_some()
            || rest.end.target.is_some_and(|to| Some(to) != rest.end.position)
            || rest.end.target.is_none() && rest.end.stop.is_some()
    });
    let (outcome, words, remedy) = match (lost, elsewhere) {
        (Some(rest), _) => {
            let axis = rest.end.axis;
            let words = match &rest.end.stop {
                Some(stop) => format!("the position of axis {axis} is uncertain: {}", stop.words),
                None => format!("the position of axis {axis} is uncertain"),
            };
            let remedy = "if it stands at a known place, or to go and find one, call it 0";
            ("uncertain", words, Some(remedy.to_owned()))
        }
        (None, Some(Rest { failed: Some((words, remedy)), end, .. })) => {
            ("stopped", format!("axis {} is not homed: {words}", end.axis), remedy.clone())
        }
        (None, Some(Rest { end, .. })) => {
            // For a line, the first axis that something has stopped.
            let stopped = rests.iter().find_map(|rest| Some((&rest.end, rest.end.stop.as_ref()?)));
            match stopped {
                Some((end, stop)) => {
                    let words = format!("axis {} was stopped by {}", end.axis, stop.words);
                    ("stopped", words, None)
                }
                None => (
                    "stopped",
                    format!("axis {} does not rest where it was ordered to", end.axis),
                    Some("did a reset stop it, or noise change a digit?".to_owned()),
                ),
            }
        }
        (None, None) => {
            let homed = rests.iter().find_map(|rest| rest.homed.clone());
            let there = || "every axis is where it was ordered to".to_owned();
            ("reached", homed.unwrap_or_else(there), None)
        }
    };
    let axes = rests.into_iter().map(|rest| rest.end).collect();
    OrderEnd { outcome, words, remedy, axes }
}
