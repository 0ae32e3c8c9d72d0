//! Queues, from both ends.

extern crate std;
use super::*;
use std::boxed::Box;
use std::cell::RefCell;
use std::vec::Vec;

const WIRING: Wiring = Wiring::new(4, 32);

std::thread_local! {
    /// The action of the other side before the next read of a shared byte.
    static MEANWHILE: RefCell<Option<Box<dyn FnMut()>>> = const { RefCell::new(None) };
}

pub(crate) fn before_a_read() {
    // Taken out while it runs: its own reads interrupt nothing.
    if let Some(mut side) = MEANWHILE.take() {
        side();
        MEANWHILE.set(Some(side));
    }
}

/// The wait of a step, in ticks: the entry is one event.
fn wait(entry: Entry) -> u32 {
    let mut events = entry.play();
    let (_, wait) = events.next().unwrap();
    assert_eq!(events.next(), None);
    wait >> 16
}

#[test]
fn a_last_run_is_taken_whenever_it_comes() {
    // A producer pushes its last run before the read number `push` of a
    // consumer, and closes before the read number `close`.
    const READS: u32 = 24;
    for push in 0..READS {
        for close in push..READS {
            let queue = Box::leak(Box::new(Queue::<4>::new()));
            let (mut producer, mut consumer) = queue.split();
            producer.set_open(true);
            let mut read = 0;
            MEANWHILE.set(Some(Box::new(move || {
                if read == push {
                    producer.push(Run::steady(2000, 1)).unwrap();
                }
                if read == close {
                    producer.set_open(false);
                }
                read += 1;
            })));
            let mut waits = Vec::new();
            // At least two reads for each: by then both have happened.
            for _ in 0..=READS / 2 {
                match consumer.take() {
                    Next::Entry(entry) => waits.push(wait(entry)),
                    Next::Late => {}
                    Next::End => break,
                }
            }
            MEANWHILE.take();
            // The wait before the step, and the step.
            let both = [2000, 0];
            assert_eq!(waits, both, "pushed before read {push}, closed before {close}");
            assert_eq!(consumer.take(), Next::End);
        }
    }
}

#[test]
fn a_player_may_tell_that_all_is_played() {
    let mut queue = Queue::<8>::new();
    let (mut producer, mut consumer) = queue.split();
    producer.set_open(true);
    for _ in 0..3 {
        producer.push(Run::steady(2000, 1)).unwrap();
    }
    let pushed = producer.len();
    assert!(matches!(consumer.take(), Next::Entry(_)));
    assert_eq!(producer.len(), pushed);
    consumer.set_played();
    assert_eq!(producer.len(), pushed - 1);
    // An entry taken ahead is not played.
    consumer.look_ahead();
    consumer.set_played();
    assert_eq!(producer.len(), pushed - 1);
}

#[test]
fn full_empty_and_wrapped() {
    let mut queue = Queue::<4>::new();
    let (mut producer, mut consumer) = queue.split();
    let mut before = None;
    for round in 0..1000u32 {
        for k in 0..2 {
            producer.push(Run::steady(2000 + round * 2 + k, 1)).unwrap();
        }
        assert!(producer.push(Run::steady(9, 9)).is_err());
        for k in 0..2 {
            let Next::Entry(entry) = consumer.take() else { panic!("empty") };
            let ticks = wait(entry);
            assert_eq!(ticks, 2000 + round * 2 + k);
            assert!(before.is_none_or(|before| before < ticks));
            before = Some(ticks);
        }
        // The queue is closed, and the last step has not been handed out yet.
        assert_eq!(consumer.take(), Next::End);
    }
}

#[test]
fn an_open_queue_is_late_not_ended() {
    let mut queue = Queue::<4>::new();
    let (mut producer, mut consumer) = queue.split();
    producer.set_open(true);
    assert_eq!(consumer.take(), Next::Late);
    producer.push(Run::steady(2000, 1)).unwrap();
    consumer.clear(true);
    producer.set_open(false);
    assert_eq!(consumer.take(), Next::End);
    assert!(producer.is_empty());
}

/// The entry being played counts, and one taken ahead too.
#[test]
fn what_is_played_to_its_end_is_counted_out() {
    let mut queue = Queue::<8>::new();
    let (mut producer, mut consumer) = queue.split();
    producer.set_open(true);
    for ticks in [2000, 3000, 4000] {
        producer.push(Run::steady(ticks, 1)).unwrap();
    }
    for left in [3, 2, 1] {
        assert!(matches!(consumer.take(), Next::Entry(_)));
        assert_eq!(producer.len(), left);
        consumer.look_ahead();
        assert_eq!(producer.len(), left);
    }
    assert_eq!(consumer.take(), Next::Late);
    assert!(producer.is_empty());
}

#[test]
fn threads_lose_and_invent_nothing() {
    let mut queue = Queue::<8>::new();
    let (mut producer, mut consumer) = queue.split();
    let ticks = |n: u32| 2000 + n % 30_000;
    producer.set_open(true);
    std::thread::scope(|scope| {
        scope.spawn(move || {
            for n in 0..200_000u32 {
                let mut run = Run::steady(ticks(n), 1);
                while let Err(back) = producer.push(run) {
                    run = back;
                    std::hint::spin_loop();
                }
            }
            producer.set_open(false);
        });
        let mut want = 0u32;
        loop {
            match consumer.take() {
                Next::Entry(entry) if want < 200_000 => {
                    assert_eq!(wait(entry), ticks(want));
                    want += 1;
                }
                // The last step.
                Next::Entry(entry) => assert_eq!(wait(entry), 0),
                Next::Late => std::hint::spin_loop(),
                Next::End => break,
            }
        }
        assert_eq!(want, 200_000);
    });
}

/// All events: pins, and ticks.
fn events(queue: &Queue<8>) -> Vec<(u8, u32)> {
    let entries = core::iter::from_fn(|| queue.take());
    entries.flat_map(Entry::play).map(|(pins, wait)| (pins, wait >> 16)).collect()
}

#[test]
fn a_travel_is_hold_turn_steps_and_the_last_one() {
    let queue = Queue::new();
    // SAFETY: the only one.
    let mut producer = unsafe { queue.producer(WIRING) };
    producer.set_open(true);
    producer.push(Run::turn(2500, false)).unwrap();
    producer.push(Run::steady(4000, 1)).unwrap();
    producer.push(Run::steady(1000, 2)).unwrap();
    producer.set_open(false);
    let all = events(&queue);
    assert_eq!(&all[..4], [(0, 2500), (32, 4000), (4, 1000), (4, 1000)]);
    assert_eq!((all.len(), all[4].0), (5, 4));
    // To the same side: DIR does not toggle.
    producer.set_open(true);
    producer.push(Run::turn(2500, false)).unwrap();
    producer.push(Run::steady(4000, 1)).unwrap();
    producer.set_open(false);
    assert_eq!(&events(&queue)[..2], [(0, 2500), (0, 4000)]);
}

#[test]
fn what_is_stopped_makes_no_last_step_and_keeps_its_side() {
    let queue = Queue::new();
    // SAFETY: the only one.
    let mut producer = unsafe { queue.producer(WIRING) };
    producer.set_open(true);
    producer.push(Run::turn(2500, false)).unwrap();
    producer.push(Run::steady(4000, 1)).unwrap();
    queue.clear(true);
    producer.set_open(false);
    assert!(producer.is_empty());
    assert_eq!(events(&queue), []);
    // It has not turned yet.
    producer.set_open(true);
    producer.push(Run::turn(2500, false)).unwrap();
    producer.push(Run::steady(4000, 1)).unwrap();
    assert_eq!(events(&queue), [(0, 2500), (32, 4000)]);
}

/// A run's steps become entries when there is room for them.
#[test]
fn a_run_of_long_intervals_is_step_by_step() {
    let queue = Queue::<8>::new();
    // SAFETY: the only one.
    let mut producer = unsafe { queue.producer(WIRING) };
    producer.set_open(true);
    producer.push(Run::steady(4000, 1)).unwrap();
    producer.push(Run::new(60_000 << 16, -(20_000 << 16), 3)).unwrap();
    assert!(!producer.is_full());
    producer.push(Run::new(20_000 << 16, 13_000 << 16, 2)).unwrap();
    assert!(producer.is_full());
    let (mut time, mut steps) = (0, Vec::new());
    let mut all = events(&queue);
    assert!(!producer.is_full());
    producer.set_open(false);
    all.extend(events(&queue));
    for (pins, wait) in all {
        if pins == 4 {
            steps.push(time);
        }
        time += wait;
    }
    assert_eq!(steps, [4000, 64_000, 104_000, 124_000, 144_000, 177_000]);
}

#[test]
fn a_full_queue_gives_the_run_back_and_keeps_room_for_the_last_step() {
    let queue = Queue::<8>::new();
    // SAFETY: the only one.
    let mut producer = unsafe { queue.producer(WIRING) };
    producer.set_open(true);
    let mut pushed = 0;
    while producer.push(Run::steady(2000, 1)).is_ok() {
        pushed += 1;
    }
    assert_eq!(pushed, 6);
    producer.set_open(false);
    assert_eq!(events(&queue).len(), 7);
}
