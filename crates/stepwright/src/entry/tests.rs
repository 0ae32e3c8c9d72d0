extern crate std;
use super::writer::{FEW, JOINED};
use super::*;
use crate::format::Alike;
use crate::order::{Order, Travel};
use crate::planner::{Clock, Planned, Planner, Work};
use crate::profile::{Fit, Ramp};
use crate::queue::entries::Queue;
use crate::run::Run;
use crate::units::{Accel, Rate, Speed};
use proptest::prelude::*;
use std::vec::Vec;

const WIRING: Wiring = Wiring::new(4, 32);

impl Sink for Vec<Entry> {
    fn put(&mut self, entry: Entry) {
        self.push(entry);
    }
}

/// Times of the steps that entries make, in 2⁻¹⁶ ticks, and the time of their end.
fn steps_of(entries: &[Entry]) -> (Vec<i64>, i64) {
    let (mut time, mut steps) = (0, Vec::new());
    let mut events = entries.iter().flat_map(|entry| entry.play()).peekable();
    while let Some((pins, wait)) = events.next() {
        assert!(pins == 0 || pins == WIRING.step, "{pins}");
        // A prompt player need not wait for a next entry if there is none.
        let last = events.peek().is_none();
        assert!((u32::from(!last)..NEAR << 16).contains(&wait), "{wait}");
        if pins != 0 {
            steps.push(time);
        }
        time += i64::from(wait);
    }
    (steps, time)
}

/// Times of the steps of runs, the same.
fn steps_of_runs(runs: &[Run]) -> Vec<i64> {
    let mut time = 0;
    let mut all = Vec::new();
    for run in runs {
        let mut interval = run.interval() as i64;
        for _ in 0..run.count() {
            time += interval;
            all.push(time);
            interval += i64::from(run.add());
        }
    }
    all
}

fn entries_of(runs: &[Run]) -> Vec<Entry> {
    entries_for(WIRING, runs)
}

fn entries_for(wiring: Wiring, runs: &[Run]) -> Vec<Entry> {
    let (queue, mut entries) = (Queue::<8>::new(), Vec::new());
    // SAFETY: the only one.
    let mut producer = unsafe { queue.producer(wiring) };
    producer.set_open(true);
    for run in runs {
        while producer.is_full() {
            entries.extend(queue.take());
        }
        producer.push(*run).unwrap();
    }
    while producer.is_full() {
        entries.extend(queue.take());
    }
    producer.set_open(false);
    entries.extend(core::iter::from_fn(|| queue.take()));
    entries
}

/// The runs of a travel as a board plans it.
fn planned(start: u32, top: u32, accel: u32, steps: i32) -> Option<Vec<Run>> {
    let rate = Rate::from_hz(16_000_000).unwrap();
    let clock = Clock::new(rate, &Fit::board(rate));
    let ramp = Ramp::Accel(Accel::from_steps(accel).unwrap());
    let order = Order {
        start: Speed::from_steps(start).unwrap(),
        top: Speed::from_steps(top).unwrap(),
        up: ramp,
        down: ramp,
        jerk: None,
        travel: Travel::By(steps),
    };
    let mut planner = Planner::IDLE;
    planner.lay_out(&clock, &order).ok()?;
    let mut work = Work::NONE;
    let mut runs = std::vec![Run::new(4000 << 16 | 1 << 15, 0, 1)];
    loop {
        match planner.next(&clock, &mut work) {
            Planned::Ready => {
                planner.take(&mut work);
                runs.extend(work.taken());
                work.clear();
            }
            Planned::Again => {}
            Planned::End => return Some(runs),
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn a_planned_travel_keeps_its_deadlines(
        start in prop_oneof![Just(0u32), 1u32..2000],
        top in prop_oneof![1u32..2000, 2000u32..170_000],
        accel in prop_oneof![10u32..1000, 1000u32..2_000_000],
        steps in prop_oneof![2i32..50, 50i32..20_000],
    ) {
        let Some(runs) = planned(start.min(top), top, accel, steps) else { return Ok(()) };
        let (made, _) = steps_of(&entries_of(&runs));
        let want = steps_of_runs(&runs);
        prop_assert_eq!(made.len(), want.len());
        for (n, (made, want)) in made.iter().zip(&want).enumerate() {
            let off = (made - want) as f64 / 65536.0;
            prop_assert!(off.abs() < 12.0, "step {} is {} ticks off", n, off);
        }
    }

    /// A wait of any length is exact to its last bit, which is carried to the next one.
    #[test]
    fn one_step_after_another_however_long(
        waits in prop::collection::vec((any::<u32>(), 0u32..32, any::<u16>()), 1..20)
    ) {
        let runs: Vec<Run> = waits
            .iter()
            .map(|(ticks, shift, part)| Run { ticks: (ticks >> shift).max(LEAST + 2), part: *part, count: 1, add: 0 })
            .collect();
        let (made, _) = steps_of(&entries_of(&runs));
        let want = steps_of_runs(&runs);
        prop_assert_eq!(made.len(), want.len());
        for (made, want) in made.iter().zip(&want) {
            // 2¹⁸ waits lack less than 2¹⁸ units; fast steps may be joined.
            prop_assert!((-5 << 16..1 << 26).contains(&(want - made)), "{made}, not {want}");
        }
    }

    /// The entries of a prompt player equal the runs, to the last bit.
    #[test]
    fn a_prompt_player_gets_the_runs(
        runs in prop::collection::vec(
            (1u32..40, 0u32..1 << 16, -2000i32..2000, prop_oneof![Just(0), Just(1)], 1u16..70),
            1..20,
        ),
    ) {
        let runs: Vec<Run> = runs
            .iter()
            .map(|(ticks, part, add, grows, count)| {
                let ticks = if *count == 1 { ticks * ticks * ticks * 7 } else { ticks * 700 };
                Run::new(u64::from(ticks << 16 | part) + (2 << 16), add * grows, *count)
            })
            .collect();
        let (made, _) = steps_of(&entries_for(WIRING.prompt(), &runs));
        let want = steps_of_runs(&runs);
        prop_assert_eq!(made.len(), want.len());
        for (made, want) in made.iter().zip(&want) {
            // 16 waits instead of a long one lack less than 16 units.
            prop_assert!((0..16).contains(&(want - made)), "{made}, not {want}");
        }
    }

    /// Where at most two axes are as fast, no group is over before a step interrupt has prepared the
    /// next one: it has more than a few steps, or lasts as long as one of slow steps.
    #[test]
    fn no_group_of_fast_steps_is_short(
        top in 8_000u32..128_000,
        accel in 20_000u32..530_000,
        level in prop_oneof![-9_000i32..0, 0i32..10_000],
    ) {
        let ramps = (u64::from(top).pow(2) / u64::from(accel)) as i32;
        let Some(runs) = planned(0, top, accel, (ramps + level).max(100)) else { return Ok(()) };
        let entries = entries_of(&runs);
        let groups: Vec<_> = entries.iter().flat_map(|entry| entry.groups()).collect();
        // The last one is the last step of the travel.
        for (n, (_, events, wait)) in groups.iter().enumerate().take(groups.len() - 1) {
            let wait = wait >> 16;
            // A run that begins above the bound may end a little below it.
            let slow = wait >= JOINED - 20 || events * wait >= 900;
            let long = *events > u32::from(FEW) || slow;
            prop_assert!(long, "group {} has {} steps of {} ticks", n, events, wait);
        }
    }

    /// The last deadline of any run is exact, however badly the run fits into groups.
    #[test]
    fn the_end_of_a_run_is_exact(
        count in 2u16..3000, mean in 200u32..16_000, add in -3000i32..3000,
    ) {
        let add = (add / i32::from(count).pow(2)).max(-8000) * 2;
        let first = i64::from(mean) << 16;
        let run = Run::new(first as u64, add, count);
        prop_assume!((100..NEAR).contains(&((run.last_interval() >> 16) as u32)));
        let runs = [Run::steady(5000, 1), run, run, run];
        let (made, _) = steps_of(&entries_of(&runs));
        let want = steps_of_runs(&runs);
        for k in 0..4 {
            let at = usize::from(count) * k;
            let off = (made[at] - want[at]).abs();
            // Up to FEW steps of the previous run are joined with it.
            prop_assert!(off <= i64::from(count + FEW) * 129, "run {k}: {off}");
        }
    }
}

#[test]
fn events_count_from_one_to_the_most() {
    for count in [1u16, 2, 255, 256, 257, 512, 65535] {
        assert_eq!(Events::new(count).count(), u32::from(count));
    }
    assert_eq!(Events::new(0).count(), 65536);
    assert_eq!(Events::ONE.count(), 1);
}

#[test]
fn groups_grow_and_the_first_has_pins_of_its_own() {
    let entry = Entry {
        interval: bytes(1000 << 16),
        growth: bytes((-100i32 << 16) as u32),
        events: Events::new(2),
        groups: 3,
        then: 4,
        pins: 32,
    };
    let all: Vec<_> = entry.play().map(|(pins, wait)| (pins, wait >> 16)).collect();
    assert_eq!(all, [(32, 1000), (32, 1000), (4, 900), (4, 900), (4, 800), (4, 800)]);
    let groups: Vec<_> = entry.groups().map(|(pins, n, wait)| (pins, n, wait >> 16)).collect();
    assert_eq!(groups, [(32, 2, 1000), (4, 2, 900), (4, 2, 800)]);
}

/// A turn that leaves an interrupt no time is delayed, and the wait after it is shorter by the same
/// amount.
#[test]
fn a_short_hold_is_longer_and_the_first_step_comes_at_its_time() {
    let (mut writer, mut entries) = (Writer::new(WIRING), Vec::new());
    writer.turn(16, true, &mut entries);
    writer.run(&Run::steady(4000, 1), &mut entries);
    writer.run(&Run::steady(2000, 1), &mut entries);
    let all: Vec<_> = entries.iter().flat_map(|entry| entry.play()).collect();
    assert_eq!(all, [(0, LEAST << 16), (32, (4016 - LEAST) << 16), (4, 2000 << 16)]);
}

/// A corner between ramp and level is no group of its own.
#[test]
fn a_step_at_speed_is_joined_with_its_neighbours() {
    let level = Run::new(200 << 16, 0, 500);
    let corner = Run::new((200 << 16) + 5000, 0, 1);
    let fall = Run::new(201 << 16, 1 << 14, 256);
    let runs = [Run::steady(4000, 1), corner, level, level, corner, fall];
    let entries = entries_of(&runs);
    // Lead, twice a level, the first group of the fall, the rest of it, the last step.
    let steps: Vec<_> = entries.iter().map(|entry| entry.play().count()).collect();
    assert_eq!(steps, [1, 501, 500, 5, 252, 1]);
    let (made, _) = steps_of(&entries);
    let want = steps_of_runs(&runs);
    assert_eq!(made.len(), want.len());
    for (made, want) in made.iter().zip(&want) {
        assert!((made - want).abs() < 3 << 16, "{made}, not {want}");
    }
}

/// The time that joining adds or removes is compensated in the same steps: nothing accumulates
/// until a slow step has to compensate for all of it.
#[test]
fn many_joined_steps_owe_nothing() {
    for (corner, level) in
        [(201u64 << 16 | 60_000, 300), (198 << 16 | 9_000, 300), (201 << 16 | 60_000, 2)]
    {
        let mut runs = std::vec![Run::steady(4000, 1)];
        for _ in 0..100 {
            runs.extend([Run::new(corner, 0, 1), Run::new(200 << 16, 0, level)]);
        }
        runs.push(Run::steady(2000, 1));
        let (made, _) = steps_of(&entries_of(&runs));
        let want = steps_of_runs(&runs);
        assert_eq!(made.len(), want.len());
        for (n, (made, want)) in made.iter().zip(&want).enumerate() {
            let off = (made - want) as f64 / 65536.0;
            assert!(off.abs() < 5.0, "step {n} is {off} ticks off");
        }
    }
}

/// Steps that are alike equal the events one after another, except for the last of a group and the
/// last two groups.
#[test]
fn steps_that_are_alike_come_one_after_another() {
    let mut passed = 0;
    for groups in [1u32, 2, 3, 4, 50] {
        for events in [1u16, 2, 300] {
            for (pins, then) in [(4, 4), (4, 0), (32, 4), (0, 0)] {
                let entry = Entry {
                    interval: bytes(1000 << 16),
                    growth: bytes((-7i32 << 16) as u32),
                    events: Events::new(events),
                    groups: crate::format::groups(groups),
                    then,
                    pins,
                };
                let (mut fast, mut slow) = (entry.play(), entry.play());
                while let Some((pins, mut wait)) = fast.next() {
                    assert_eq!(Some((pins, wait)), slow.next());
                    let mut alike = if pins == 4 { Alike::of(&mut fast, 4) } else { Alike::NONE };
                    let left = alike.count() as u16;
                    assert_eq!(fast.left().wrapping_add(left), slow.left());
                    passed += u32::from(left);
                    for n in 0..=left {
                        assert_eq!(alike.count(), u32::from(left - n));
                        assert_eq!(fast.waits(alike), slow.waits(Alike::NONE));
                        if n < left {
                            assert!(!slow.is_last() || events > 1);
                            let before = u64::from(wait);
                            wait = alike.next(before) as u32;
                            assert_eq!(Some((4, wait)), slow.next());
                            assert_eq!(alike.undo(wait.into()), before);
                            alike.next(before);
                        }
                    }
                }
                assert_eq!(slow.next(), None);
            }
        }
    }
    // Of ramps 1 and 47 steps, and 46 after the one that turns; of groups of 300 all but two.
    assert_eq!(passed, 1 + 47 + 46 + 298 * (60 + 5 + 55));
}

/// As many waits are left out as fit, whether the count is found by a division or a product.
#[test]
fn waits_of_one_length_are_left_out() {
    let hop = 1u64 << 46;
    for (groups, events) in [(1u32, 1u16), (1, 5), (16, 1), (1 << 16, 1), (3, 7)] {
        for wait in [1u32, 1 << 16, 0x7EFF_0000, 0x8000_0000] {
            let entry = Entry {
                interval: bytes(wait),
                growth: [0; BYTES],
                events: Events::new(events),
                groups: crate::format::groups(groups),
                then: 0,
                pins: 0,
            };
            let (mut play, wait) = (entry.play(), u64::from(wait));
            let all = u64::from(groups) * u64::from(events);
            let fit = (hop / wait).saturating_sub(1);
            let left = play.join(wait as u32, hop) / wait - 1;
            let most = if all <= fit { all } else { fit.min(u64::from(events) - 1) };
            assert_eq!(left, most, "{groups} × {events} of {wait}");
            assert_eq!(play.count() as u64, all - most);
        }
    }
}
