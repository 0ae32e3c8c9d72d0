//! Austin's laws against its formulas in f64, and its printed numbers.
//!
//! The oracle works on whole lists of real delays: a ramp from rest, another one in reverse, and Eq
//! 16 to 25 for their ends. It shares only the stored values with the core.

use proptest::prelude::*;
use stepwright::profile::Unfit;
use stepwright::{Accel, Rate, Speed};
use stepwright_austin::{
    Austin, C0, Divisor, Fixed, LinearFactor, Piecewise, PowerTerm, Ramp, Slope,
};

/// The stored values as real numbers: steps and seconds.
#[derive(Clone, Copy, Debug)]
struct Order {
    hz: u32,
    /// In thousandths.
    top: u32,
    accel: u64,
    decel: u64,
    c0: C0,
    pulses: u32,
}

impl Order {
    fn rate(&self) -> Rate {
        Rate::from_hz(self.hz).unwrap()
    }
    fn top(&self) -> Speed {
        Speed::from_millisteps(self.top).unwrap()
    }
    fn accels(&self) -> (Accel, Accel) {
        let a = |a| Accel::from_millisteps(a).unwrap();
        (a(self.accel), a(self.decel))
    }

    /// The acceleration from which the first step can still be braked.
    fn fitted(mut self) -> Order {
        let most = u128::from(2 * u64::from(self.pulses.max(1)) - 1) * u128::from(self.decel);
        self.accel = u128::from(self.accel).min(most) as u64;
        self
    }

    fn f(&self) -> f64 {
        f64::from(self.hz)
    }
    fn v(&self) -> f64 {
        f64::from(self.top) / 1e3
    }
    fn c_min(&self) -> f64 {
        (self.f() / self.v()).max(1.0)
    }

    /// c₀ as emitted, and the value from which the formula continues (Eq 7, 15).
    fn c0(&self, accel: u64) -> (f64, f64) {
        let exact = self.f() * (2e3 / accel as f64).sqrt();
        match self.c0 {
            C0::Exact => (exact, exact),
            C0::Reduced => (0.676 * exact, 0.676 * exact),
            C0::FirstStep => (exact, 0.676 * exact),
        }
    }

    /// The actual acceleration of the ramp.
    fn real_accel(&self, accel: u64) -> f64 {
        let part = if self.c0 == C0::Exact { 0.676 * 0.676 } else { 1.0 };
        accel as f64 / 1e3 * part
    }

    /// Builds a travel: N steps of `up`, a hold, and J steps down.
    fn travel(&self, up: &[f64], down: &[f64]) -> Vec<f64> {
        let delays = self.pulses.saturating_sub(1) as usize;
        let mut all = vec![self.c0(self.accel).0];
        all.extend(&up[1..]);
        let last = if up.len() == 1 { up[0] } else { all[all.len() - 1] };
        let inner = down.len().saturating_sub(1); // j = 1 is the hold after the end
        while all.len() + inner < delays {
            all.push(last);
        }
        all.extend(&down[..inner]);
        all.truncate(delays);
        all.iter().map(|c| c.max(self.c_min())).collect()
    }
}

/// Eq 12 and 14 with their variant.
fn general(order: Order, divisor: Divisor) -> Vec<f64> {
    let order = order.fitted();
    let two = divisor == Divisor::TwoN;
    let mut up = vec![order.c0(order.accel).1];
    if two {
        up[0] = order.f() * (2e3 / order.accel as f64).sqrt() * std::f64::consts::PI.sqrt() / 2.0;
    }
    // Eq 18, rounded, in integers, so that the rounding of f64 does not matter.
    let j = |n: usize| {
        let (n, a, d) = (n as u128, u128::from(order.accel), u128::from(order.decel));
        if two { ((4 * n + 1) * a + d) / (4 * d) } else { ((2 * n + 1) * a) / (2 * d) }
    };
    while up[up.len() - 1] > order.c_min()
        && (up.len() as u128 + 1) + j(up.len()) <= u128::from(order.pulses)
    {
        let (n, c) = (up.len() as f64, up[up.len() - 1]);
        up.push(if two { c - c / (2.0 * n) } else { c - 2.0 * c / (4.0 * n + 1.0) });
    }
    let mut c = up[up.len() - 1];
    let down = (1..=j(up.len() - 1)).rev().map(|j| {
        let j = j as f64;
        c += if two { c / (2.0 * j - 1.0) } else { 2.0 * c / (4.0 * j - 1.0) };
        c
    });
    let down: Vec<_> = down.collect();
    let mut all = order.travel(&up, &down);
    if two && !all.is_empty() {
        all[0] = up[0].max(order.c_min());
    }
    all
}

/// A curve as (delay, divisor that led to it) from rest, endless. `lean` is 1, or differs from it
/// in the last place: if two delays are practically equal, either answer is right.
fn shadowed(
    order: Order,
    enough: f64,
    lean: f64,
    curve: impl Fn(u64) -> Box<dyn Iterator<Item = (f64, f64)>>,
) -> Vec<f64> {
    let order = order.fitted();
    let (mut rise, mut fall) = (curve(order.accel), curve(order.decel));
    let (mut up, mut down) = (vec![rise.next().unwrap().0], vec![fall.next().unwrap()]);
    let mut j = 0;
    let mut follow = |c: f64, left: usize| -> Option<usize> {
        let mut k = j;
        while down.get(k).map_or(f64::INFINITY, |s| s.0) > c.max(enough) * lean {
            if k >= left {
                return None;
            }
            k += 1;
            if down.len() <= k {
                down.push(fall.next().unwrap());
            }
        }
        if k <= left {
            j = k;
            Some(k)
        } else {
            None
        }
    };
    let mut braking = follow(up[0], usize::MAX).unwrap();
    let mut next = rise.next();
    while up[up.len() - 1] > enough * lean {
        let c = next.unwrap().0;
        let Some(left) = (order.pulses as usize).checked_sub(up.len() + 1) else { break };
        let Some(j) = follow(c, left) else { break };
        braking = j;
        up.push(c);
        next = rise.next();
    }
    let mut c = up[up.len() - 1];
    let slower: Vec<_> = (1..=braking)
        .rev()
        .map(|j| {
            c += 2.0 * c / (down[j].1 - 2.0);
            c
        })
        .collect();
    order.travel(&up, &slower)
}

/// Eq 20, 21.
fn power(order: Order, p: i32, lean: f64) -> Vec<f64> {
    shadowed(order, order.c_min(), lean, |accel| {
        let n_t = (order.v() * order.v() / (2.0 * order.real_accel(accel))).max(1.0);
        let k = 4.0 / n_t.powi(p - 1);
        let first = (order.c0(accel).1, 0.0);
        let mut n = 0.0;
        Box::new(std::iter::successors(Some(first), move |(c, _)| {
            n += 1.0;
            let d = 4.0 * n + 1.0 + k * f64::powi(n, p);
            Some((c - 2.0 * c / d, d))
        }))
    })
}

/// Figure 5's rule.
fn piecewise(order: Order, breaks: usize, lean: f64) -> Vec<f64> {
    let c_min = order.c_min();
    shadowed(order, c_min, lean, |accel| {
        // (c)₀ = 3·c_min, (c)ⱼ = ((c)ⱼ₋₁ + c_min)/2
        let mut levels = Vec::new();
        let mut level = 3.0 * c_min;
        for _ in 0..breaks {
            level = (level + c_min) / 2.0;
            levels.push(level);
        }
        let (mut n, mut crossed) = (0.0, 0);
        Box::new(std::iter::successors(Some((order.c0(accel).1, 0.0)), move |&(c, _)| {
            n += 1.0;
            while crossed < levels.len() && c <= levels[crossed] * lean {
                n *= 1.375;
                crossed += 1;
            }
            let d = 4.0 * n + 1.0;
            Some((c - 2.0 * c / d, d))
        }))
    })
}

/// n₁ and n₂ by Eq 16, 23 and 24.
fn transition(order: &Order, a: f64, knee: f64) -> (f64, f64) {
    let v2 = order.v() * order.v();
    let n1 = (knee * knee * v2 / (2.0 * a)).round();
    if n1 == 0.0 {
        return (0.0, (v2 / (0.736 * a)).floor().max(1.0));
    }
    let reached = |n2: f64| {
        let ratio = (n2 + 0.5) / (n1 + 0.5);
        2.0 / std::f64::consts::E * a * (n1 + 0.5) * ratio.powf(n2 / (n2 - n1))
    };
    let (mut low, mut high) = (n1 + 1.0, 4e9);
    while low + 1.0 < high {
        let middle = ((low + high) / 2.0).floor();
        if reached(middle) <= v2 { low = middle } else { high = middle }
    }
    (n1, low)
}

/// Eq 22 and 25.
fn linear(order: Order, knee: f64) -> Vec<f64> {
    let order = order.fitted();
    let m = f64::from(order.pulses);
    let (mut n1, mut n2) = transition(&order, order.real_accel(order.accel), knee);
    let (mut j1, mut j2) = transition(&order, order.real_accel(order.decel), knee);
    if n2 + j2 > m && m >= 2.0 {
        let (a, d) = (order.accel as f64, order.decel as f64);
        let short = (m * d / (a + d)).round().clamp(1.0, m - 1.0);
        n1 = (n1 * short / n2).round().min(short - 1.0);
        j1 = (j1 * (m - short) / j2).round().min(m - short - 1.0);
        (n2, j2) = (short, m - short);
    }
    j1 = j1.max(1.0);
    let (mut c, mut all) = (order.c0(order.accel).1, Vec::new());
    for i in 0..order.pulses.saturating_sub(1) {
        let (n, j) = (f64::from(i), m - f64::from(i));
        if i == 0 {
            all.push(order.c0(order.accel).0);
            continue;
        }
        if n <= n2 && j > j2 {
            let factor = if n <= n1 { 1.0 } else { (n2 - n) / (n2 - n1) };
            c -= 2.0 * c / (4.0 * n + 1.0) * factor;
        } else if j <= j2 {
            let factor = if j <= j1 { 1.0 } else { (j2 - j) / (j2 - j1) };
            c += 2.0 * c / (4.0 * j - 1.0) * factor;
        }
        all.push(c);
    }
    all.iter().map(|c| c.max(order.c_min())).collect()
}

/// Each delay is within a tick of its formula, and each pulse within a tick of its time.
fn check(got: Result<Vec<u32>, Unfit>, want: &[f64], pulses: u32) -> Result<(), TestCaseError> {
    // The first and the last step take 2³¹ ticks in no order: accelerations are 1 step/s² and more.
    let got = got.map_err(|why| TestCaseError::fail(format!("{why:?}")))?;
    prop_assert_eq!(got.len(), pulses as usize);
    prop_assert_eq!(want.len(), pulses.saturating_sub(1) as usize);
    if let Some(first) = got.first() {
        prop_assert_eq!(*first, 0);
    }
    let (mut time, mut ideal) = (0.0, 0.0);
    for (i, (delay, count)) in got.iter().skip(1).zip(want).enumerate() {
        let off = f64::from(*delay) - count;
        prop_assert!(off.abs() <= 1.0 + count * 1e-9, "delay {i}: {delay}, not {count}");
        time += f64::from(*delay);
        ideal += count;
        let off: f64 = time - ideal;
        prop_assert!(off.abs() <= 1.0 + ideal * 1e-9, "pulse {i}: {time}, not {ideal}");
    }
    Ok(())
}

/// The same for a law that compares its delays.
fn check_any(
    got: Result<Vec<u32>, Unfit>,
    want: impl Fn(f64) -> Vec<f64>,
    pulses: u32,
) -> Result<(), TestCaseError> {
    let lean = [1.0, 1.0 - 1e-10, 1.0 + 1e-10];
    let mut tried = lean.map(|lean| check(got.clone(), &want(lean), pulses)).into_iter();
    let first = tried.next().unwrap();
    if first.is_ok() || tried.any(|other| other.is_ok()) { Ok(()) } else { first }
}

/// Numbers spread evenly over the orders of magnitude.
fn spread(low: f64, high: f64) -> impl Strategy<Value = f64> {
    (low.ln()..high.ln()).prop_map(f64::exp)
}

fn orders() -> impl Strategy<Value = Order> {
    let c0 = prop_oneof![Just(C0::Exact), Just(C0::Reduced), Just(C0::FirstStep)];
    let ratio = prop_oneof![1 => Just(1.0), 2 => spread(0.1, 10.0), 1 => spread(1e-3, 1e3)];
    (spread(1e5, 2e8), spread(10.0, 2e5), spread(1.0, 2e4), ratio, 0u32..3_000, c0).prop_map(
        |(hz, top, steps, ratio, pulses, c0)| {
            // An acceleration that reaches the top speed in this many steps.
            let accel = (top * top / (2.0 * steps) * 1e3).clamp(1e3, 1e11);
            let decel = (accel * ratio).clamp(1e3, 1e11);
            let (accel, decel) = (accel as u64, decel as u64);
            Order { hz: hz as u32, top: (top * 1e3) as u32, accel, decel, c0, pulses }
        },
    )
}

fn cases() -> u32 {
    std::env::var("STEPWRIGHT_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(4_000)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cases()))]

    #[test]
    fn general_form(order in orders()) {
        let law = Austin::new(order.rate(), order.top(), order.accels().0)
            .with_decel(order.accels().1)
            .with_c0(order.c0);
        let got = law.delays(order.pulses).map(Iterator::collect);
        check(got, &general(order, Divisor::FourN), order.pulses)?;
        let got = law.with_divisor(Divisor::TwoN).delays(order.pulses).map(Iterator::collect);
        check(got, &general(order, Divisor::TwoN), order.pulses)?;
    }

    #[test]
    fn power_term(order in orders(), p in 2u8..=9) {
        let law = PowerTerm::new(order.rate(), order.top(), order.accels().0, p)
            .with_decel(order.accels().1)
            .with_c0(order.c0);
        let got = law.delays(order.pulses).map(Iterator::collect);
        check_any(got, |lean| power(order, p.into(), lean), order.pulses)?;
    }

    #[test]
    fn stages(order in orders(), breaks in 0u8..=16) {
        let law = Piecewise::new(order.rate(), order.top(), order.accels().0)
            .with_decel(order.accels().1)
            .with_c0(order.c0)
            .with_breaks(breaks);
        let got = law.delays(order.pulses).map(Iterator::collect);
        check_any(got, |lean| piecewise(order, breaks.into(), lean), order.pulses)?;
    }

    #[test]
    fn linear_factor(order in orders(), knee in 0u16..=900) {
        let law = LinearFactor::new(order.rate(), order.top(), order.accels().0)
            .with_decel(order.accels().1)
            .with_c0(order.c0)
            .with_knee(knee);
        let got = law.delays(order.pulses).map(Iterator::collect);
        check(got, &linear(order, f64::from(knee) / 1e3), order.pulses)?;
    }

    /// Eq 13 with any changes during the travel (Eq 18).
    #[test]
    fn changes_of_acceleration(
        hz in 100_000u32..20_000_000,
        first in 10_000u64..100_000_000,
        changes in prop::collection::vec((1u32..200, -10_000_000i64..20_000_000), 1..6),
    ) {
        let accel = |a| Accel::from_millisteps(a).unwrap();
        let Ok(mut ramp) = Ramp::new(Rate::from_hz(hz).unwrap(), accel(first), C0::Reduced) else {
            return Ok(());
        };
        let c0 = 0.676 * f64::from(hz) * (2e3 / first as f64).sqrt();
        let (mut n, mut a, mut c) = (0.0, first as f64, c0);
        let mut want = vec![c0];
        let mut got: Vec<u32> = ramp.by_ref().take(2).collect();
        'all: for (steps, next) in changes {
            let level = (-1_000_000..1_000_000).contains(&next);
            ramp.set(match next {
                _ if level => Slope::Level,
                1.. => Slope::Up(accel(next as u64)),
                _ => Slope::Down(accel(-next as u64)),
            });
            if !level {
                n = (n + 0.5) * a / next as f64 - 0.5;
                a = next as f64;
            }
            for _ in 0..steps {
                if !level {
                    n += 1.0;
                    if f64::abs(n + 1.0) < 1e-3 {
                        return Ok(()); // rounding decides whether this is the end
                    }
                    if (-1.0..0.0).contains(&n) || n >= 0.0 && a < 0.0 {
                        break 'all;
                    }
                    c -= 2.0 * c / (4.0 * n + 1.0);
                }
                want.push(c);
                let Some(delay) = ramp.next() else { break 'all };
                got.push(delay);
            }
        }
        let pulses = got.len() as u32;
        check(Ok(got), &want, pulses)?;
    }

    /// The listing in f64 without its rounding: the error of truncation.
    #[test]
    fn fixed_point(pulses in 0u32..5_000, c0 in 2_000u32..200_000, c_min in 200u32..10_000) {
        let got: Vec<_> = Fixed::new(pulses, c0, c_min).collect();
        prop_assert_eq!(got.len(), pulses as usize);
        let (mut c, mut n) = (f64::from(c0.max(c_min)), 0u32);
        let mut bound = 0.5;
        for (i, delay) in got.iter().skip(1).enumerate() {
            let left = pulses - 1 - i as u32;
            if i > 0 && left > n && c.round() > f64::from(c_min) {
                n += 1;
                c -= 2.0 * c / (4.0 * f64::from(n) + 1.0);
                bound += 1.0 / 256.0;
            } else if i > 0 {
                break;
            }
            let off = f64::from(*delay) - c.max(f64::from(c_min));
            prop_assert!(off.abs() <= bound, "delay {i}: {delay}, not {c}");
        }
    }
}

/// Table 1, every cell.
#[test]
fn table_1() {
    let exact = |n: f64| ((1.0 + 1.0 / n).sqrt() - 1.0) / (1.0 - (1.0 - 1.0 / n).sqrt());
    let approx = |n: f64| (4.0 * n - 1.0) / (4.0 * n + 1.0);
    let rows = [
        (1.0, "0.4142", "0.6000", 0.4485, 5e-5),
        (2.0, "0.7673", "0.7778", 0.0136, 5e-5),
        (3.0, "0.8430", "0.8462", 0.003_70, 6e-6),
        (4.0, "0.8810", "0.8824", 0.001_52, 5e-6),
        (5.0, "0.9041", "0.9048", 7.66e-4, 5e-7),
        (6.0, "0.9196", "0.9200", 4.41e-4, 5e-7),
        (10.0, "0.9511", "0.9512", 9.42e-5, 5e-8),
        (100.0, "0.9950", "0.9950", 9.38e-8, 5e-11),
        (1_000.0, "0.9995", "0.9995", 9.37e-11, 3e-13),
    ];
    for (n, e, a, error, digit) in rows {
        assert_eq!((format!("{:.4}", exact(n)), format!("{:.4}", approx(n))), (e.into(), a.into()));
        let relative = approx(n) / exact(n) - 1.0;
        assert!((relative - error).abs() <= digit, "n = {n}: {relative}");
    }
}

/// Figures 2 to 4: 0 to 120 rpm in a second, 1.8°, 1 MHz; 4π rad/s² are 400
/// steps/s².
#[test]
fn figures_2_to_4() {
    let law =
        Austin::new(Rate::MHZ, Speed::from_steps(400).unwrap(), Accel::from_steps(400).unwrap());
    // The formulas.
    let c0 = 1e6 * (2.0f64 / 400.0).sqrt();
    assert_eq!(format!("{c0:.2} {:.2}", 0.676 * c0), "70710.68 47800.42");
    let exact = |n: f64| c0 * ((n + 1.0).sqrt() - n.sqrt());
    assert_eq!(format!("{:.3}", exact(199.0)), "2503.133");
    assert!(((0..200).map(|n| exact(n.into())).sum::<f64>() - 1e6).abs() < 1e-6);
    let approx = (1..200).fold(0.676 * c0, |c, n| c - 2.0 * c / (4.0 * f64::from(n) + 1.0));
    assert_eq!(format!("{approx:.3}"), "2503.210");
    // The law.
    for (c0, first) in [(C0::Reduced, 47_800), (C0::FirstStep, 70_711), (C0::Exact, 70_711)] {
        let delays: Vec<_> = law.with_c0(c0).delays(2_000).unwrap().collect();
        assert_eq!((delays[0], delays[1]), (0, first));
        let at = if c0 == C0::Exact { 3_703 } else { 2_503 };
        assert!(delays[200].abs_diff(at) <= 1, "{c0:?}: {}", delays[200]);
    }
}

/// Figure 6, p = 2: k = 0.02; and every power reaches the speed of Eq 20.
#[test]
fn figure_6() {
    let (v, a) = (400.0, 400.0);
    assert_eq!(4.0 * (2.0 * a / (v * v)), 0.02);
    let speed = |p| {
        let law = PowerTerm::new(
            Rate::MHZ,
            Speed::from_steps(400).unwrap(),
            Accel::from_steps(400).unwrap(),
            p,
        );
        let delays: Vec<_> = law.delays(1_000).unwrap().collect();
        1e6 / f64::from(*delays[1..].iter().min().unwrap())
    };
    assert!(speed(2) < 360.0); // falls short
    for p in 3..=5 {
        assert!((385.0..=400.0).contains(&speed(p)), "p = {p}: {}", speed(p));
    }
}

/// The approach follows Eq 20 to the end: 0.99995 of the top speed after 4,000 steps with p = 4.
#[test]
fn the_power_term_approaches_its_top_speed_as_equation_20_does() {
    let (v, a) = (400.0f64, 400.0f64);
    let rate = Rate::from_hz(16_000_000).unwrap();
    let (top, accel) = (Speed::from_steps(400).unwrap(), Accel::from_steps(400).unwrap());
    for (p, part) in [(2, 0.976_837), (4, 0.999_946), (9, 0.999_968)] {
        let delays: Vec<_> = PowerTerm::new(rate, top, accel, p).delays(20_000).unwrap().collect();
        let k = 4.0 / (v * v / (2.0 * a)).powi(i32::from(p) - 1);
        let mut c = 0.676 * 16e6 * (2.0 / a).sqrt();
        for n in 1..=8_000u16 {
            let m = f64::from(n);
            c -= 2.0 * c / (4.0 * m + 1.0 + k * m.powi(p.into()));
            let got = f64::from(delays[usize::from(n) + 1]);
            assert!((got - c).abs() < 1.0, "p = {p}, n = {n}: {got} {c}");
            if n == 4_000 {
                assert!((16e6 / v / c - part).abs() < 1e-6, "p = {p}: {}", 16e6 / v / c);
            }
        }
    }
}

/// A speed that the way down never has ends the ramp, and is not searched for in all the remaining
/// steps: with 2³¹ of them this test would take minutes.
#[test]
fn a_speed_beyond_the_way_down_ends_the_power_terms_ramp() {
    let accel = |n| Accel::from_steps(n).unwrap();
    let law = PowerTerm::new(Rate::MHZ, Speed::from_steps(400).unwrap(), accel(400), 4);
    let mut delays = law.with_decel(accel(4_000)).delays(1 << 31).unwrap();
    let first: Vec<u32> = delays.by_ref().take(10_000).collect();
    assert_eq!(delays.phase(), stepwright::profile::Phase::Cruise);
    assert!(first[9_999].abs_diff(first[5_000]) <= 1, "{} {}", first[5_000], first[9_999]);
    delays.stop();
    assert!(delays.count() < 5_000);
}

/// Figure 8: 10 rad/s at 10 and −20 rad/s².
#[test]
fn figure_8() {
    let accel = |n| Accel::from_millisteps(n).unwrap();
    let top = Speed::from_millisteps(318_310).unwrap();
    let law = LinearFactor::new(Rate::MHZ, top, accel(318_310)).with_decel(accel(636_620));
    let corners = |m| {
        let corners = law.corners(m).unwrap();
        (corners.n1, corners.n2, corners.n3(m))
    };
    assert_eq!(corners(700), (0, 432, 484));
    assert_eq!(corners(500), (0, 333, 333));
    // c_min is 3141.6; the estimate of Eq 24 is 0.2 % below the top speed.
    let delays: Vec<_> = law.delays(700).unwrap().collect();
    assert!((3_141..3_149).contains(&delays[450]), "{}", delays[450]);
    assert!(delays[433..484].iter().all(|d| d.abs_diff(delays[450]) <= 1));
    // With and without a section at top speed, the acceleration has no jump there.
    let delays: Vec<_> = law.delays(500).unwrap().collect();
    let speed = |i: usize| 1e6 / f64::from(delays[i]);
    assert!((speed(333) - speed(334)).abs() < 0.2);
    assert!(speed(333) > 270.0 && speed(333) < 318.31, "{}", speed(333));
}
