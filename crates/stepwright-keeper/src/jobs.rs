//! The jobs that wait for a board.
//!
//! A stop or a kill goes before every order that waits, and these orders are declined: who
//! stops a machine does not want to see it start.

use std::collections::VecDeque;

use crate::report::Done;
use crate::{Declined, Wish};

/// Orders that wait, at most.
const WAITING: usize = 16;

/// A wish, and where its answer goes.
pub struct Job {
    /// What is to be done.
    pub wish: Wish,
    /// Whether the answer waits for the end of the order.
    pub waits: bool,
    begun: Option<Box<dyn FnOnce() + Send>>,
    answer: Box<dyn FnOnce(Result<Done, Declined>) + Send>,
}

impl Job {
    /// A wish that is answered so.
    pub fn new(
        wish: Wish,
        waits: bool,
        answer: impl FnOnce(Result<Done, Declined>) + Send + 'static,
    ) -> Job {
        Job { wish, waits, begun: None, answer: Box::new(answer) }
    }

    /// The same, and this is told once its order has begun: for one who goes on meanwhile, and
    /// waits for the answer later.
    pub fn when_begun(self, begun: impl FnOnce() + Send + 'static) -> Job {
        Job { begun: Some(Box::new(begun)), ..self }
    }

    /// Its order has begun.
    pub(crate) fn begins(&mut self) {
        if let Some(begun) = self.begun.take() {
            begun();
        }
    }

    /// Answers it. Who asked may be gone.
    pub fn answer(self, answer: Result<Done, Declined>) {
        (self.answer)(answer);
    }
}

/// Jobs, in the order in which they are carried out.
#[derive(Default)]
pub struct JobQueue {
    jobs: VecDeque<Job>,
    /// Why none is taken.
    closed: Option<Declined>,
}

impl JobQueue {
    /// Takes a job, or declines it.
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

    /// The next one, if any waits.
    pub fn take(&mut self) -> Option<Job> {
        self.jobs.pop_front()
    }

    /// Whether none waits.
    pub fn is_empty(&self) -> bool {
        self.jobs.is_empty()
    }

    /// Whether a stop or a kill waits.
    pub fn is_urgent(&self) -> bool {
        self.jobs.front().is_some_and(|job| job.wish.is_urgent())
    }

    /// Takes no jobs until [`open`](JobQueue::open), for this reason; those that wait are
    /// declined with it.
    pub fn close(&mut self, why: Declined) {
        self.jobs.drain(..).for_each(|job| job.answer(Err(why.clone())));
        self.closed = Some(why);
    }

    /// Takes jobs again.
    pub fn open(&mut self) {
        self.closed = None;
    }
}

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Mutex};

    use stepwright_protocol::{AxisId, Selection};

    use super::*;

    /// What became of the jobs that were put.
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
        // No crowd of orders keeps a stop out.
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
