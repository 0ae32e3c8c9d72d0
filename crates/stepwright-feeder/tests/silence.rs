//! A host falls silent at random instants of runs of all speeds, on the virtual board. 1,000 and more of
//! them, here and on the chips: `cargo xtask silence`.

use crate::common::guards;
use crate::common::instants::{Befalls, Guarded, KINDS, Random, befall, instant, motion};
use crate::common::wire::Wire;
use crate::common::{Job, MILLIS, board};
use stepwright_sim::{Edge, Queues, StreamBoard};

impl Guarded for StreamBoard<'_, Vec<Edge>> {
    fn close(&mut self, input: u8, closed: bool) {
        self.set_input(input, closed);
    }
    fn now(&self) -> u64 {
        StreamBoard::now(self)
    }
}

fn number(name: &str, otherwise: u64) -> u64 {
    std::env::var(name).map_or(otherwise, |value| value.parse().expect(name))
}

#[test]
fn silence_at_any_instant_brakes_every_axis() {
    let (instants, seed) = (number("STEPWRIGHT_INSTANTS", 24), number("STEPWRIGHT_SEED", 1));
    let (mut wrong, mut off, mut most) = (Vec::new(), 0, 0.0f64);
    for n in 0..instants {
        let mut random = Random::new(seed + n);
        let mut motion = motion((seed + n) % KINDS, &mut random);
        let (at, befalls) = (instant(&motion, &mut random), Befalls::any(&mut random));
        motion.lease = [0, 200, 1_000][random.below(3) as usize];
        let mut queues = Queues::default();
        let mut board = board(&mut queues);
        let mut wire = Wire::new(Job::new(motion.path.clone()), motion.terms(), 0);
        wire.feed(&mut board, at);
        match befall(&mut board, &mut wire, &motion, befalls, &mut random) {
            Ok(outcome) => {
                off += u64::from(outcome.off);
                most = outcome.axes.iter().fold(most, |most, axis| most.max(axis.steepest));
            }
            Err(why) => {
                wrong.push(format!("seed {}: {}, {befalls:?}: {why}", seed + n, motion.name))
            }
        }
    }
    println!("{instants} instants, {off} off the path, at most {most:.3} of a deceleration");
    assert!(wrong.is_empty(), "{} of {instants}:\n{}", wrong.len(), wrong.join("\n"));
    assert!(off > instants / 2, "{off} of {instants}");
}

#[test]
fn an_end_while_axes_are_at_speed_brakes_them() {
    for kind in 0..KINDS {
        let mut random = Random::new(kind);
        let motion = motion(kind, &mut random);
        let mut queues = Queues::default();
        let mut board = board(&mut queues);
        let mut wire = Wire::new(Job::new(motion.path.clone()), motion.terms(), 0);
        wire.feed(&mut board, 700 * MILLIS);
        let outcome = befall(&mut board, &mut wire, &motion, Befalls::End, &mut random);
        assert!(outcome.as_ref().is_ok_and(|outcome| outcome.off), "{}: {outcome:?}", motion.name);
    }
}

/// Each on a board of its own.
fn guarded(test: impl FnOnce(&mut StreamBoard<'_, Vec<Edge>>)) {
    test(&mut board(&mut Queues::default()));
}

#[test]
fn an_input_brakes_all_axes() {
    guarded(|board| guards::an_input_brakes_all_axes(board));
    guarded(|board| guards::an_input_that_opens_brakes_all_axes(board));
}

#[test]
fn z_brakes_and_k_stops() {
    guarded(|board| guards::z_brakes_and_f_tells(board));
    guarded(|board| guards::k_stops_at_once(board));
}

#[test]
fn what_was_not_started_is_forgotten() {
    guarded(|board| guards::what_was_not_started_is_forgotten(board));
    guarded(|board| guards::a_count_of_nothing_moves_nothing(board));
}

#[test]
fn a_lease_counts_until_the_end() {
    guarded(|board| guards::a_lease_counts_until_the_end(board));
}
