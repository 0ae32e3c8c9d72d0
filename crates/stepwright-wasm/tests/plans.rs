//! Plans against the core's own iterators, and with any numbers.

use proptest::prelude::*;
use stepwright::profile::Trapezoid;
use stepwright_wasm::order::FIELDS;
use stepwright_wasm::planner::{MOST_POINTS, PlanColumn};
use stepwright_wasm::{PlanLaw, PlanOrder, Planner};

/// The example with some numbers changed.
fn numbers(changes: &[(usize, f64)]) -> [f64; FIELDS] {
    let mut numbers = PlanOrder::EXAMPLE;
    for (at, number) in changes {
        numbers[*at] = *number;
    }
    numbers
}

fn planned(law: PlanLaw, changes: &[(usize, f64)]) -> Box<Planner> {
    let mut planner = Box::new(Planner::new());
    planner.plan(law, &PlanOrder::check(&numbers(changes)).unwrap()).unwrap();
    planner
}

#[test]
fn the_figures_are_those_of_the_delays() {
    let order = PlanOrder::check(&numbers(&[(2, 50.0), (5, 1000.0)])).unwrap();
    let law = Trapezoid::new(order.rate, order.start, order.top, order.accel);
    let delays: Vec<_> = law.with_decel(order.decel).delays(order.steps).unwrap().collect();
    let planner = planned(PlanLaw::Trapezoid, &[(2, 50.0), (5, 1000.0)]);
    let figures = planner.figures();
    let ticks: u64 = delays.iter().map(|&delay| u64::from(delay)).sum();
    assert_eq!(figures.ticks, ticks as f64);
    assert_eq!(figures.first, f64::from(delays[1]));
    assert_eq!(figures.shortest, f64::from(*delays[1..].iter().min().unwrap()));
    assert_eq!(figures.peak, 1000.0);
    // From 1000 steps/s to 50 at 1000 steps/s²: v²/2a, and 0.95 s.
    assert_eq!(figures.braking_steps, 499.0);
    assert!((figures.braking_seconds - 0.95).abs() < 2e-2);
    assert!(figures.error > 0.0 && figures.error <= 1.0, "{}", figures.error);
    // It is the constant acceleration with which the others are compared.
    assert!(figures.deviation_rms < 1e-6 && figures.lost.abs() < 1e-6);
}

#[test]
fn the_curves_are_those_of_the_law() {
    let planner = planned(PlanLaw::Trapezoid, &[]);
    let [times, places, speeds, accels, intervals, deviations] =
        PlanColumn::ALL.map(|column| planner.column(column));
    assert_eq!(times.len(), planner.figures().points as usize);
    assert!(times.len() > 700 && times.len() <= MOST_POINTS);
    assert!(times.is_sorted() && places.is_sorted());
    assert_eq!((places[0], places[places.len() - 1]), (0.0, 3999.0));
    for i in 5..times.len() - 1 {
        // 1000 steps/s after 0.5 s, until 0.5 s before the end.
        let (time, left) = (times[i], times[times.len() - 1] - times[i]);
        let ramp = if time < left { time } else { left };
        let speed = (2000.0 * ramp).min(1000.0);
        assert!((speeds[i] - speed).abs() < 8.0, "{} at {time}", speeds[i]);
        if (ramp - 0.5).abs() > 0.01 && ramp > 0.02 {
            let accel =
                if ramp > 0.5 { 0.0 } else { 2000.0 } * if time < left { 1.0 } else { -1.0 };
            assert!((accels[i] - accel).abs() < 1.0, "{} at {time}", accels[i]);
        }
        // The interval is that of the steps before the point, where on slow ramps the speed differs.
        let whole = intervals[i] * speeds[i] / 1e6;
        assert!(ramp < 0.1 || (whole - 1.0).abs() < 0.05, "{} at {time}", intervals[i]);
        assert!(deviations[i].abs() < 1e-6);
    }
}

/// A window has as many points as the whole travel.
#[test]
fn a_window_is_looked_at_closely() {
    let all = planned(PlanLaw::Austin, &[(1, 100_000.0)]);
    let part = planned(PlanLaw::Austin, &[(1, 100_000.0), (12, 50.0), (13, 51.0)]);
    assert_eq!(all.figures().ticks, part.figures().ticks);
    assert_eq!(all.hash(), part.hash());
    let times = part.column(PlanColumn::Time);
    assert!(times[0] <= 50.0 && times[0] > 49.9 && times[times.len() - 1] > 51.0);
    let inside = |times: &[f64]| times.iter().filter(|t| (50.0..=51.0).contains(*t)).count();
    assert!(inside(times) > 500 && inside(all.column(PlanColumn::Time)) < 30);
}

#[test]
fn nothing_and_a_single_step_are_plans_too() {
    for law in PlanLaw::ALL {
        for steps in [0.0, 1.0, 2.0, 3.0] {
            let planner = planned(law, &[(1, steps)]);
            let figures = planner.figures();
            assert_eq!(figures.pulses, steps, "{law:?}");
            assert_eq!(planner.column(PlanColumn::Time).len(), steps as usize, "{law:?}");
            assert!(steps > 1.0 || (figures.seconds, figures.peak) == (0.0, 0.0), "{law:?}");
        }
    }
}

#[test]
fn what_is_refused_says_why() {
    for at in 0..FIELDS {
        let field = PlanOrder::field(at).unwrap();
        for number in [f64::NAN, f64::INFINITY, field.low - 1.0, field.high * 2.0 + 1.0] {
            assert_eq!(PlanOrder::check(&numbers(&[(at, number)])), Err(field.refusal));
        }
        for number in [field.low, field.high] {
            assert!(PlanOrder::check(&numbers(&[(at, number)])).is_ok(), "{at}");
        }
    }
    let refused = |law, changes: &[(usize, f64)]| {
        let order = PlanOrder::check(&numbers(changes)).unwrap();
        Planner::new().plan(law, &order).unwrap_err().to_string()
    };
    let fast = [(0, 1e5), (3, 2e5), (4, 1e8), (5, 1e8)];
    assert!(refused(PlanLaw::Trapezoid, &fast).contains("a faster timer"));
    assert!(refused(PlanLaw::AustinFixed, &[(5, 1.0)]).contains("give both ramps alike"));
    assert!(refused(PlanLaw::SCurve, &[(0, 2e8), (6, 1e-3)]).contains("too slow for this timer"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]
    #[test]
    fn no_numbers_stop_it(
        law in 0usize..7,
        parts in prop::array::uniform14(0.0f64..=1.0),
        odd in prop::collection::vec((0usize..FIELDS, any::<f64>()), 0..2),
    ) {
        let mut numbers = PlanOrder::EXAMPLE;
        for (at, part) in parts.into_iter().enumerate() {
            let field = PlanOrder::field(at).unwrap();
            let low = field.low.max(field.high * 1e-12);
            numbers[at] = (low * (field.high / low).powf(part)).clamp(field.low, field.high);
        }
        numbers[1] = numbers[1].min(3000.0);
        for (at, number) in odd {
            numbers[at] = if at == 1 { number % 3000.0 } else { number };
        }
        let Ok(order) = PlanOrder::check(&numbers) else { return Ok(()) };
        let mut planner = Box::new(Planner::new());
        if planner.plan(PlanLaw::ALL[law], &order).is_ok() {
            let figures = planner.figures();
            prop_assert_eq!(figures.pulses, f64::from(order.steps));
            // The listing rounds each delay separately; the others carry the rounding on.
            let most = match PlanLaw::ALL[law] {
                PlanLaw::AustinFixed => figures.pulses / 2.0,
                _ => 1.0 + figures.ticks * 1e-12,
            };
            prop_assert!(figures.error <= most, "{:?}", figures);
            prop_assert!(planner.column(PlanColumn::Time).len() <= MOST_POINTS);
            prop_assert!(planner.column(PlanColumn::Time).is_sorted());
        }
    }
}
