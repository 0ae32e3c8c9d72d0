//! The jobs of a board that wait.
//!
//! A stop or a kill goes before every order that waits, and those orders are declined: whoever stops a machine
//! does not want to see it start.

use std::collections::VecDeque;

use crate::report::Done;
use crate::{Declined, Wish};

/// The most orders that wait.
const WAITING: usize = 16;

/// A wish, and the receiver of its answer.
pub struct Job {
    /// The wish.
    pub wish: Wish,
    /// Whether the answer waits for the end of the order.
    pub waits: bool,
    begun: Option<Box<dyn FnOnce() + Send>>,
    answer: Box<dyn FnOnce(Result<Done, Declined>) + Send>,
}

impl Job {
    /// A wish whose answer goes to `answer`.
    pub fn new(
        wish: Wish,
        waits: bool,
        answer: impl FnOnce(Result<Done, Declined>) + Send + 'static,
    ) -> Job {
        Job { wish, waits, begun: None, answer: Box::new(answer) }
    }

    /// Adds a function that is called once the order has begun, for a caller that goes on meanwhile and waits
    /// for the answer later.
    pub fn when_begun(self, begun: impl FnOnce() + Send + 'static) -> Job {
        Job { begun: Some(Box::new(begun)), ..self }
    }

    /// Reports that the order has begun.
    pub(crate) fn begins(&mut self) {
        if let Some(begun) = self.begun.take() {
            begun();
        }
    }

    /// Answers the job. The caller may be gone.
    pub fn answer(self, answer: Result<Done, Declined>) {
        (self.answer)(answer);
    }
}

/// The jobs that wait, in the order in which they are carried out.
#[derive(Default)]
pub struct JobQueue {
    jobs: VecDeque<Job>,
    /// Why no job is accepted.
    closed: Option<Declined>,
}

impl JobQueue {
    /// Adds a job, or declines it.
    pub fn put(&mut self, job: Job) {
        if let Some(why) = &self.closed {
            return job.answer(Err(why.clone()));
        }
        if job.wish.is_urgent() {
            let (before, orders) = self.jobs.drain(..).partition(|job| job.wish.is_urgent());
            self.jobs = before;
            let orders: VecDeque<Job> = orders;
            for order in orders {
                order.answer(Err(Declined::refused("a stop came before this order was given")
                    .remedy("give it again if it is still wanted")));
            }
        } else if self.jobs.len() >= WAITING {
            let why = Declined::away("too many orders wait").remedy("give one after another");
            return job.answer(Err(why));
        }
        self.jobs.push_back(job);
    }

    /// Takes the next job, if one waits.
    pub fn take(&mut self) -> Option<Job> {
        self.jobs.pop_front()
    }

    /// Whether no job waits.
    pub fn is_empty(&self) -> bool {
        self.jobs.is_empty()
    }

    /// Whether a stop or a kill waits.
    pub fn is_urgent(&self) -> bool {
        self.jobs.front().is_some_and(|job| job.wish.is_urgent())
    }

    /// Accepts no jobs until [`open`](JobQueue::open), for this reason. Jobs that wait are declined with the
    /// same reason.
    pub fn close(&mut self, why: Declined) {
        self.jobs.drain(..).for_each(|job| job.answer(Err(why.clone())));
        self.closed = Some(why);
    }

    /// Accepts jobs again.
    pub fn open(&mut self) {
        self.closed = None;
    }
}

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Mutex};

    use stepwright_protocol::{AxisId, Selection};

    use super::*;

    /// The results of the jobs.
    type Answers = Arc<Mutex<Vec<u16>>>;

    fn put(jobs: &mut JobQueue, wish: Wish, answers: &Answers) {
        let answers = answers.clone();
        jobs.put(Job::new(wish, false, move |answer| {
            answers.lock().unwrap().push(answer.map_or_else(|why| why.status(), |_| 200));
        }));
    }

    #[test]
    fn a_stop_goes_first_and_what_waited_is_declined() {
        let (mut jobs, answers) = (JobQueue::default(), Answers::default());
        put(&mut jobs, Wish::Zero(AxisId::FIRST), &answers);
        assert!(!jobs.is_urgent());
        put(&mut jobs, Wish::Stop(Selection::All), &answers);
        put(&mut jobs, Wish::Acknowledge, &answers);
        put(&mut jobs, Wish::Kill, &answers);
        assert_eq!(*answers.lock().unwrap(), [409, 409]);
        assert!(jobs.is_urgent());
        assert_eq!(jobs.take().map(|job| job.wish), Some(Wish::Stop(Selection::All)));
        assert_eq!(jobs.take().map(|job| job.wish), Some(Wish::Kill));
        assert!(jobs.is_empty());
    }

    #[test]
    fn a_closed_queue_and_a_full_one_decline() {
        let (mut jobs, answers) = (JobQueue::default(), Answers::default());
        for _ in 0..=WAITING {
            put(&mut jobs, Wish::Acknowledge, &answers);
        }
        assert_eq!(*answers.lock().unwrap(), [503]);
        // Orders that wait never keep a stop out.
        put(&mut jobs, Wish::Kill, &answers);
        assert!(jobs.is_urgent());
        assert_eq!(answers.lock().unwrap()[1..], [409; WAITING]);
        answers.lock().unwrap().clear();
        jobs.close(Declined::away("the board is gone"));
        put(&mut jobs, Wish::Kill, &answers);
        assert_eq!(*answers.lock().unwrap(), [503, 503]);
        jobs.open();
        put(&mut jobs, Wish::Kill, &answers);
        assert!(jobs.is_urgent());
    }
}
