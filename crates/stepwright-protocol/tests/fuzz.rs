//! Noise against the slave: whatever comes, every CR gets exactly one answer, the right one, and
//! only a well-formed order starts a motor.
//!
//! `common/noise.rs` makes the input, `common/judge.rs` derives the expected effect.
//! `STEPWRIGHT_FUZZ_CASES` sets the number of cases (the default takes about ten seconds in
//! release), `STEPWRIGHT_FUZZ_SEED` the first seed: a failure prints its own.

mod common;
#[path = "common/judge.rs"]
mod judge;
#[path = "common/noise.rs"]
mod noise;

use common::{Bench, Random, text, words};
use judge::{AXES, Entry, should_answer, should_change, should_start};
use stepwright_protocol::{Refusal, Slave};

/// Plays one case. Returns the numbers of answered lines, starts and changes.
fn play(seed: u64) -> (usize, usize, usize) {
    let mut random = Random(seed);
    let bytes = noise::input(&mut random);
    let (mut slave, mut bench) = (Slave::<AXES>::new(), Bench::new(AXES));
    let (mut log, mut line) = (Vec::new(), Vec::new());
    for &byte in &bytes {
        let ends = byte == b'\r';
        let refuses = ends && random.one_in(12);
        bench.refuse = refuses.then_some(Refusal::TooFast);
        let mut entry = Entry::before(&bench);
        let (asked, changes) = (bench.asked.len(), bench.changes.len());
        bench.pieces = random.below(4) as u32;
        slave.receive(byte, &mut bench);
        while slave.work(&mut bench) {}
        let answers = slave.is_answering();
        let said = |log: &[Entry]| {
            let said: Vec<_> = log.iter().map(|e| format!("{:?} {}", e.line, e.answer)).collect();
            format!("STEPWRIGHT_FUZZ_SEED={seed}\n{}\n{}", bytes.escape_ascii(), said.join("\n"))
        };
        assert_eq!(answers, ends, "one answer at each CR\n{}", said(&log));
        if !answers {
            assert_eq!(bench.asked.len(), asked, "a start without a CR\n{}", said(&log));
            assert_eq!(bench.changes.len(), changes, "a change without a CR\n{}", said(&log));
            if byte != b'\n' || !line.is_empty() {
                line.push(byte);
            }
            continue;
        }
        while line.last() == Some(&b'\n') {
            line.pop();
        }
        let (said_line, summed) = judge::unsummed(&line);
        entry.line = said_line;
        entry.answer = text(&mut slave, &mut bench);
        if summed {
            let (bare, sum) = entry.answer.rsplit_once('*').expect("a checksum");
            assert_eq!(sum, format!("{:02X}", judge::remainder(bare.as_bytes())), "of {bare:?}");
            entry.answer = bare.into();
        }
        entry.refused = refuses;
        entry.asked = bench.asked[asked..]
            .iter()
            .map(|orders| {
                let orders = orders.iter().map(|(a, o)| format!("{} {}", a.number(), words(o)));
                orders.collect::<Vec<_>>().join("; ")
            })
            .collect();
        entry.changed = bench.changes[changes..].to_vec();
        line.clear();
        log.push(entry);
        let last = log.last().unwrap();
        assert_eq!(last.asked, Vec::from_iter(should_start(&log)), "starts\n{}", said(&log));
        assert_eq!(last.changed, Vec::from_iter(should_change(&log)), "changes\n{}", said(&log));
        assert_eq!(judge::comparable(&last.answer), should_answer(&log), "{}", said(&log));
        let moving = bench.axes.iter().any(|axis| axis.running.is_some());
        assert!(last.line != "K" || !moving, "K left an axis running\n{}", said(&log));
        if random.one_in(3) {
            bench.arrive(random.below(AXES));
        }
        if random.one_in(30) {
            bench.press(random.below(AXES));
        }
    }
    let starts = log.iter().map(|entry| entry.asked.len()).sum();
    (log.len(), starts, log.iter().map(|entry| entry.changed.len()).sum())
}

#[test]
fn noise_moves_nothing_by_mistake() {
    let set = |name: &str| std::env::var(name).ok().map(|n| n.parse::<u64>().expect(name));
    let seed = set("STEPWRIGHT_FUZZ_SEED");
    let default = match seed {
        Some(_) => 1,
        None if cfg!(debug_assertions) => 50_000,
        None => 300_000,
    };
    let cases = set("STEPWRIGHT_FUZZ_CASES").unwrap_or(default);
    let (mut lines, mut starts, mut changes) = (0, 0, 0);
    for case in 0..cases {
        let (l, s, c) = play(seed.unwrap_or(0).wrapping_add(case));
        lines += l;
        starts += s;
        changes += c;
    }
    println!("{cases} cases, {lines} lines, {starts} starts, {changes} changes");
    // The test is void if nothing ever starts or changes.
    let least = if cases < 1000 { 0 } else { cases as usize / 10 };
    assert!(starts >= least && changes >= least, "only {starts} starts, {changes} changes");
}
