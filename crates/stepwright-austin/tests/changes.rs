//! Changes under Austin's law, in random sequences, against its formulas in `f64`.
//!
//! The model has signed accelerations and therefore signed n, as in Eq 13 and 18, and makes its own
//! decisions; it uses nothing of the core. The test asserts that it obeys the limits (by Eq 3),
//! overshoots nothing at which it could stop, and keeps v² = v₀² + 2as within the stated error.

use proptest::prelude::*;
use stepwright::{Accel, Rate, Speed};
use stepwright_austin::Motion;

/// v²/2 = (n + ½)·a of Eq 18, in 2⁻⁴⁰ · 10⁻⁶ (steps/s)²: whether another step is needed to brake
/// depends on equality, so sums have to be exact.
type Energy = i128;

/// The value of one (step/s)².
const UNIT: f64 = 1e6 * (1u64 << 40) as f64;

/// The model, in ticks and thousandths.
#[derive(Clone, Copy, Debug)]
struct Model {
    hz: f64,
    top: u32,
    a: u64,
    d: u64,
    position: i64,
    target: i64,
    end: i64,
    /// +1 or −1.
    way: i64,
    begun: bool,
    /// 0 at rest.
    energy: Energy,
    c: f64,
    /// By how much f²/c² is shifted to one side, for sums that end on whole steps.
    lean: f64,
}

/// The energy that a step adds.
fn slope(a: u64) -> Energy {
    (Energy::from(a) * 1000) << 40
}

impl Model {
    fn c_min(&self) -> f64 {
        (1e3 * self.hz / f64::from(self.top)).max(1.0)
    }

    fn at_top(&self) -> bool {
        (self.c / self.c_min() - 1.0).abs() < 1e-12
    }

    /// Eq 16, with the half step.
    fn full(&self) -> Energy {
        if self.c_min() > 1.0 {
            return Energy::from(self.top).pow(2) << 39;
        }
        (self.hz.powi(2) / 2.0 * UNIT) as Energy
    }

    fn seen(&self) -> Energy {
        match self.energy {
            0 => 0,
            _ if self.at_top() => self.full(),
            _ => ((self.hz / self.c).powi(2) / 2.0 * (1.0 + self.lean) * UNIT) as Energy,
        }
    }

    /// The most energy that is allowed `left` steps before the end: n = −left.
    fn room(&self, left: i64) -> Energy {
        slope(self.d) / 2 * (2 * Energy::from(left) + 1)
    }

    /// Whole steps to rest: the least number that leaves room.
    fn braking(&self, energy: Energy) -> i64 {
        let n = (energy - slope(self.d) / 2).max(0) / slope(self.d);
        let n = i64::try_from(n).unwrap();
        if self.room(n) < energy { n + 1 } else { n }
    }

    fn settle(&mut self) {
        let ahead = (self.target - self.position) * self.way;
        self.correct(ahead);
        let steps = self.braking(self.energy);
        self.end = match self.energy {
            0 => self.position,
            _ if steps <= ahead => self.target,
            _ => self.position + self.way * steps,
        };
    }

    /// Prevents the errors of Eq 13 near n = 1 from accumulating.
    fn correct(&mut self, ahead: i64) {
        let seen = self.seen();
        let [gained, lost] = [(seen, self.energy), (self.energy, seen)]
            .map(|(a, b)| self.braking(a) <= ahead && self.braking(b) > ahead);
        let slack = self.energy + if lost { 4 * slope(self.d) } else { 0 };
        if gained || (seen - self.energy).abs() > slack / 32 {
            self.energy = seen;
        }
    }

    fn stop(&mut self) {
        self.correct((self.end - self.position).abs());
        self.end = self.position + self.way * self.braking(self.energy);
        self.target = self.end;
    }

    fn next(&mut self) -> Option<f64> {
        let first = !self.begun;
        if self.position == self.end {
            if self.position == self.target {
                return None;
            }
            self.begun = true;
            self.way = (self.target - self.position).signum();
            self.end = self.target;
        }
        self.position += self.way;
        if first {
            return Some(0.0);
        }
        self.step((self.end - self.position).abs());
        Some(self.c)
    }

    fn step(&mut self, left: i64) {
        let (old, c_min, full, room) = (self.energy, self.c_min(), self.full(), self.room(left));
        let (a, d) = (slope(self.a), slope(self.d));
        let level = old > 0 && self.at_top();
        let above = old > 0 && self.c < c_min && !level;
        let next = if level || above && room < full {
            old.min(room)
        } else if above {
            (old - d).max(full / 2).min(old)
        } else if old < a / 2 {
            (a / 2).min(room)
        } else {
            (old + a).min(room)
        };
        let speed = |energy| (2.0 * energy as f64 / UNIT).sqrt();
        if next > old && old < a / 2 {
            // Eq 15, at the acceleration that leads there in half a step.
            let accel = 2.0 * next as f64 / UNIT;
            let first = 0.676 * self.hz * (2.0 / accel).sqrt();
            self.c = if old == 0 { first } else { first.min(self.c) };
        } else if old > 3 * next {
            self.c = self.hz / speed(next);
        } else if next != old {
            // Eq 18, with signs; Eq 13.
            let n = next as f64 / (next - old) as f64 - 0.5;
            self.c -= 2.0 * self.c / (4.0 * n + 1.0);
        }
        let reached = if above { room >= full && self.c >= c_min } else { self.c <= c_min };
        self.energy = next;
        if reached && !level {
            (self.c, self.energy) = (c_min, full.min(room));
        }
        if left == 0 {
            self.energy = 0;
        }
    }
}

#[derive(Clone, Copy, Debug)]
enum Wish {
    /// This far from here, or from where the motion began.
    Go(i32),
    Target(i32),
    /// In thousandths.
    Top(u32),
    Accel(u64),
    Decel(u64),
    Stop,
}

/// A number of pulses, then a change.
#[derive(Clone, Copy, Debug)]
struct Change {
    after: u32,
    wish: Wish,
}

#[derive(Clone, Copy, Debug)]
struct Order {
    hz: u32,
    top: u32,
    accel: u64,
    decel: u64,
}

fn spread(low: f64, high: f64) -> impl Strategy<Value = f64> {
    (low.ln()..high.ln()).prop_map(f64::exp)
}

fn top() -> impl Strategy<Value = u32> {
    spread(1.0, 1e5).prop_map(|v| (v * 1e3) as u32)
}

fn accel() -> impl Strategy<Value = u64> {
    spread(1.0, 1e7).prop_map(|a| (a * 1e3) as u64)
}

fn order() -> impl Strategy<Value = Order> {
    (spread(1e5, 2e8), top(), accel(), prop::option::of(accel())).prop_map(
        |(hz, top, accel, decel)| Order {
            hz: hz as u32,
            top,
            accel,
            decel: decel.unwrap_or(accel),
        },
    )
}

fn change() -> impl Strategy<Value = Change> {
    let far = || {
        (spread(0.6, 20_000.0), any::<bool>())
            .prop_map(|(d, back)| (if back { -d } else { d }).round() as i32)
    };
    let wish = prop_oneof![
        4 => far().prop_map(Wish::Go),
        1 => far().prop_map(Wish::Target),
        2 => top().prop_map(Wish::Top),
        1 => accel().prop_map(Wish::Accel),
        1 => accel().prop_map(Wish::Decel),
        1 => Just(Wish::Stop),
    ];
    let after = prop_oneof![
        2 => 0u32..4,
        4 => spread(1.0, 400.0).prop_map(|n| n as u32),
        1 => Just(3_000),
    ];
    (after, wish).prop_map(|(after, wish)| Change { after, wish })
}

/// The motion and its model, side by side.
struct Pair {
    motion: Motion,
    model: Model,
    /// The difference between their pulses, in ticks.
    off: f64,
    /// A target at which the motion can stop, from its present speed.
    reach: Option<i64>,
}

impl Pair {
    /// Makes a change in both, in which they agree.
    fn change(&mut self, wish: Wish) -> Result<(), TestCaseError> {
        let (motion, model) = (&mut self.motion, &mut self.model);
        let (before, seen) = (motion.speed(), model.seen());
        let mut refused = false;
        match wish {
            Wish::Go(_) | Wish::Target(_) => {
                let target = match wish {
                    Wish::Go(far) => model.position + i64::from(far),
                    Wish::Target(target) => target.into(),
                    _ => unreachable!(),
                };
                motion.retarget(i32::try_from(target).unwrap());
                model.target = target;
                model.settle();
            }
            Wish::Top(top) => {
                refused = motion.set_top_speed(Speed::from_millisteps(top).unwrap()).is_err();
                if !refused {
                    // The energy is that of the present delay, whatever the top speed.
                    model.settle();
                    model.top = top;
                }
            }
            Wish::Accel(a) => {
                refused = motion.set_accel(Accel::from_millisteps(a).unwrap()).is_err();
                if !refused {
                    model.a = a;
                    model.settle();
                }
            }
            Wish::Decel(d) => {
                refused = motion.set_decel(Accel::from_millisteps(d).unwrap()).is_err();
                if !refused {
                    model.d = d;
                    model.settle();
                }
            }
            Wish::Stop => {
                motion.stop();
                model.stop();
            }
        }
        prop_assert_eq!(motion.speed(), before); // it goes on as it is
        prop_assert_eq!(motion.target(), model.target);
        if !refused {
            let (way, ahead) = (model.way, (model.target - model.position) * model.way);
            let known = seen > 0 && ahead >= 0 && model.braking(seen) <= ahead;
            self.reach = known.then_some(model.target).filter(|_| model.way == way);
        }
        Ok(())
    }

    /// Makes one delay; false at the end.
    fn step(&mut self) -> Result<bool, TestCaseError> {
        let old = self.model;
        let (got, want) = (self.motion.next(), self.model.next());
        prop_assert_eq!(got.is_some(), want.is_some(), "{:?} {:?}", got, want);
        let (Some(got), Some(want)) = (got, want) else { return Ok(false) };
        let off = f64::from(got) - want;
        prop_assert!(off.abs() <= 1.0 + want * 1e-9, "{got}, not {want}: {old:?}");
        self.off += off;
        prop_assert!(self.off.abs() <= 1.0, "{} ticks off: {old:?}", self.off);
        prop_assert_eq!(self.motion.position(), self.model.position);
        prop_assert_eq!(self.motion.is_forward(), self.model.way > 0);
        if let Some(target) = self.reach {
            let ahead = (target - self.model.position) * old.way;
            prop_assert!(ahead >= 0 && self.model.way == old.way, "overshot: {old:?}");
            self.reach = Some(target).filter(|_| ahead > 0);
        }
        self.limits(&old)?;
        Ok(true)
    }

    /// Checks speed, and acceleration by Eq 3.
    fn limits(&self, old: &Model) -> Result<(), TestCaseError> {
        let (hz, new) = (old.hz, &self.model);
        let [a, d] = [old.a, old.d].map(|a| a as f64 / 1e3);
        let c_min = new.c_min();
        prop_assert!(new.c == 0.0 || new.c >= c_min.min(old.c), "too fast: {old:?} {new:?}");
        if old.energy > 0 && new.way == old.way {
            let (c1, c2) = (old.c, new.c);
            let accel = 2.0 * hz * hz * (c1 - c2) / (c1 * c2 * (c1 + c2));
            prop_assert!((-d * FAST..=a * FAST).contains(&accel), "{accel}: {old:?} {new:?}");
        }
        if new.energy > 0 {
            // v² = v₀² ± 2as, and the delay by it.
            let most = -slope(old.d)..=slope(old.a);
            let within = new.c == c_min || most.contains(&(new.energy - old.energy));
            prop_assert!(within, "{old:?} {new:?}");
            let off = hz / new.c / (2.0 * new.energy as f64 / UNIT).sqrt() - 1.0;
            prop_assert!(off.abs() <= OFF, "{off} off v² = v₀² + 2as: {old:?} {new:?}");
        }
        Ok(())
    }
}

/// The excess over a limit by Eq 3: a ramp's first step is 4.4 % fast (Eq 15), and a gentle fall
/// may follow at once.
const FAST: f64 = 1.095;
/// The error of the speed against v² = v₀² + 2as: Eq 15 and Table 1's n = 1.
const OFF: f64 = 0.064;

fn walk(order: Order, changes: &[Change], lean: f64) -> Result<(), TestCaseError> {
    let rate = Rate::from_hz(order.hz).unwrap();
    let accel = |a| Accel::from_millisteps(a).unwrap();
    let Ok(mut motion) =
        Motion::new(rate, Speed::from_millisteps(order.top).unwrap(), accel(order.accel))
    else {
        return Ok(());
    };
    if motion.set_decel(accel(order.decel)).is_err() {
        return Ok(());
    }
    let model = Model {
        hz: order.hz.into(),
        top: order.top,
        a: order.accel,
        d: order.decel,
        position: 0,
        target: 0,
        end: 0,
        way: 1,
        begun: false,
        energy: 0,
        c: 0.0,
        lean,
    };
    let mut pair = Pair { motion, model, off: 0.0, reach: None };
    for change in changes {
        for _ in 0..change.after {
            if !pair.step()? {
                break;
            }
        }
        pair.change(change.wish)?;
    }
    // To the end, or as far as a test can wait.
    let mut steps = 0;
    while steps < 30_000 && pair.step()? {
        steps += 1;
    }
    if steps < 30_000 {
        prop_assert_eq!(pair.motion.position(), pair.motion.target());
    }
    Ok(())
}

fn cases() -> u32 {
    std::env::var("STEPWRIGHT_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(4_000)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cases()))]

    /// 4,000 sequences of 25: 100,000 changes in CI.
    #[test]
    fn every_delay_after_every_change(
        order in order(),
        changes in prop::collection::vec(change(), 25),
    ) {
        let first = walk(order, &changes, 0.0);
        if first.is_err() && [1e-10, -1e-10].iter().all(|lean| walk(order, &changes, *lean).is_err()) {
            first?;
        }
    }
}
