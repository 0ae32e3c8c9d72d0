//! The laws over the line: written rows parse to the same row, and the constants make the law's
//! delays.

use stepwright::{Accel, Rate, Speed};
use stepwright_austin::line::{LONGEST, Line, Refused, can};
use stepwright_austin::{
    Austin, C0, Divisor, Fixed, LawName, LinearFactor, Piecewise, PowerTerm, Recipe,
};

use stepwright_protocol::{Fault, read_row};

/// Parses a row with its mark.
fn read(text: &str) -> Result<Line, Fault<Refused>> {
    read_row(text.strip_prefix(':').unwrap().as_bytes(), Line::read)
}

fn accel(steps: u32) -> Accel {
    Accel::from_steps(steps).unwrap()
}

/// A recipe of each law, and the delays of the law itself.
fn recipes(top: u32, up: u32, down: u32, pulses: u32) -> Vec<(Recipe, Vec<u32>)> {
    let (top, up, down) = (Speed::from_steps(top).unwrap(), accel(up), accel(down));
    let general = Austin::new(Rate::MHZ, top, up).with_decel(down);
    let two_n = general.with_divisor(Divisor::TwoN);
    let first = general.with_c0(C0::FirstStep);
    let linear = LinearFactor::new(Rate::MHZ, top, up).with_decel(down).with_knee(400);
    let power = PowerTerm::new(Rate::MHZ, top, up, 9).with_decel(down);
    let pieces = Piecewise::new(Rate::MHZ, top, up).with_decel(down).with_breaks(8);
    let listing = Recipe::AustinFixed(50_000, 2_500);
    let mut all = vec![(listing, Fixed::new(pulses, 50_000, 2_500).collect())];
    for law in [general, two_n, first] {
        let made = law.delays(pulses).unwrap().collect();
        all.push((Recipe::Austin(law.constants(pulses).unwrap()), made));
    }
    let made = linear.delays(pulses).unwrap().collect();
    all.push((Recipe::LinearFactor(linear.constants(pulses).unwrap()), made));
    let made = power.delays(pulses).unwrap().collect();
    all.push((Recipe::Power(power.constants(pulses).unwrap()), made));
    let made = pieces.delays(pulses).unwrap().collect();
    all.push((Recipe::Piecewise(pieces.constants(pulses).unwrap()), made));
    all
}

#[test]
fn a_recipe_survives_the_line_and_makes_the_same_delays() {
    for (top, up, down, pulses) in
        [(1_000, 2_000, 2_000, 900), (4_000, 1, 100_000_000, 300), (30, 700, 900, 4)]
    {
        for (recipe, made) in recipes(top, up, down, pulses) {
            let text = Line::Law(recipe).to_string();
            assert!(text.len() + 3 <= LONGEST, "{text}");
            let Ok(Line::Law(read)) = read(&text) else { panic!("{text}") };
            assert_eq!(read, recipe);
            assert!(read.is_sound(), "{text}");
            assert_eq!(read.delays(pulses).collect::<Vec<_>>(), made, "{text}");
        }
    }
}

#[test]
fn every_other_line_is_read_as_written() {
    for line in [
        Line::Change(0, accel(500)),
        Line::Change(u32::MAX, Accel::MAX),
        Line::Go(i32::MIN),
        Line::Go(i32::MAX),
        Line::Run(true),
        Line::Run(false),
    ] {
        assert_eq!(read(&line.to_string()), Ok(line), "{line}");
    }
    for text in [
        ":",
        ":x",
        ":?1",
        ":G",
        ":G+",
        ":G--1",
        ":R",
        ":C1",
        ":C1,2000,3",
        ":F1",
        ":F1,2,3",
        ":F,1",
        ":A1,2,3,4000,5000,3",
        ":P1,2,3,4,5,6,7,8",
        ":Z",
        ": G1",
        ":S18446744073709551616,1,1,1,1",
    ] {
        assert_eq!(read(text), Err(Fault::Line), "{text}");
    }
    let (int, word) = ((i32::MIN.into(), i32::MAX.into()), (0, u32::MAX.into()));
    for (text, number, (least, most)) in [
        (":G2147483648", 1, int),
        (":R2", 1, (0, 1)),
        (":C1,0", 2, (1, 100_000_000_000)),
        (":A1,2,3,0,5000,4", 4, (1, 100_000_000_000)),
        (":L1,2,3,4,5,6,4294967296", 7, word),
        (":S1,2,3,4,256", 5, (0, 255)),
        (":F4294967296,1", 1, word),
    ] {
        assert_eq!(read(text), Err(Fault::Range { number, least, most }), "{text}");
    }
}

#[test]
fn refusals_are_read() {
    for (text, refused) in [
        ("E rest", Refused::Rest),
        ("E law", Refused::Law),
        ("E unsound", Refused::Unsound),
        ("E full", Refused::Full),
        ("E fast 7000", Refused::Fast(7_000)),
    ] {
        assert_eq!(Fault::read(text.as_bytes()), Some(Fault::Own(refused)));
    }
    for none in ["Y", "E fast", "E fast x", "E law 1", "E moving"] {
        assert_eq!(Fault::<Refused>::read(none.as_bytes()), None, "{none}");
    }
    assert_eq!(can("sum,austin,power").collect::<Vec<_>>(), [LawName::Austin, LawName::Power]);
}

/// Constants that fit no travel are refused, so that none of their steps can go wrong.
#[test]
fn unsound_recipes_are_told_apart() {
    let (_, recipes): ((), Vec<Recipe>) =
        ((), recipes(1_000, 2_000, 2_000, 900).into_iter().map(|(recipe, _)| recipe).collect());
    for recipe in recipes {
        let mut unsound = Vec::new();
        match recipe {
            Recipe::Austin(c) => {
                unsound.push(Recipe::Austin(stepwright_austin::general::RampConstants {
                    lead: 0,
                    ..c
                }));
                unsound.push(Recipe::Austin(stepwright_austin::general::RampConstants {
                    shortest: 1 << 54,
                    ..c
                }));
            }
            Recipe::AustinFixed(..) => {
                unsound.extend([Recipe::AustinFixed(0, 1), Recipe::AustinFixed(1, 1 << 22)]);
            }
            Recipe::LinearFactor(mut c) => {
                c.corners.n2 = c.corners.n1.wrapping_sub(1).min(1 << 31) | 1 << 31;
                unsound.push(Recipe::LinearFactor(c));
            }
            Recipe::Power(c) => {
                let with =
                    |power, fall| stepwright_austin::power::PowerConstants { power, fall, ..c };
                unsound.push(Recipe::Power(with(1, c.fall)));
                unsound.push(Recipe::Power(with(10, c.fall)));
                unsound.push(Recipe::Power(with(4, (c.rise.0 + 1, c.fall.1))));
                unsound.push(Recipe::Power(with(4, (c.fall.0, (1 << 63) + 1))));
            }
            Recipe::Piecewise(c) => {
                let with = |breaks, fall| stepwright_austin::piecewise::StageConstants {
                    breaks,
                    fall,
                    ..c
                };
                unsound.push(Recipe::Piecewise(with(9, c.fall)));
                unsound.push(Recipe::Piecewise(with(7, c.rise + 1)));
            }
        }
        for unsound in unsound {
            assert!(!unsound.is_sound(), "{unsound:?}");
        }
    }
}

/// Eq 13 and 18 in f64: a ramp whose acceleration changes on the way up, its top speed, and its way
/// down of J = (n + ½)·a/d steps, rounded.
fn by_formula(top: f64, up: f64, down: f64, pulses: u32, changes: &[(u32, f64)]) -> Vec<f64> {
    let least = 1e6 / top;
    let (mut c, mut n, mut a) = (0.676 * 1e6 * (2.0 / up).sqrt(), 0.0, up);
    let (mut all, mut held) = (vec![c], false);
    let mut fall = None;
    while (all.len() as u32) < pulses - 1 {
        let left = pulses - 1 - all.len() as u32;
        if let Some(change) = changes.iter().find(|(after, _)| *after == all.len() as u32 + 1)
            && !held
        {
            n = (n + 0.5) * a / change.1 - 0.5;
            a = change.1;
        }
        let down_from = |n: f64| ((n + 0.5) * a / down).floor();
        held |= c <= least || down_from(n + 1.0) > f64::from(left);
        if !held {
            n += 1.0;
            c -= 2.0 * c / (4.0 * n + 1.0);
        } else if fall.is_some() || f64::from(left) < down_from(n) {
            let j: &mut f64 = fall.get_or_insert(down_from(n));
            c += 2.0 * c / (4.0 * *j - 1.0);
            *j -= 1.0;
        }
        all.push(c.max(least));
    }
    all
}

/// Top speed, acceleration, deceleration, pulses, and the changes: the number of pulses and the new
/// acceleration.
type Case<'a> = (f64, f64, f64, u32, &'a [(u32, f64)]);

#[test]
fn a_ramp_that_changes_is_eq_18() {
    let cases: &[Case] = &[
        // Numbers for which no J is a whole step.
        (500.0, 200.0, 401.0, 1_000, &[(100, 503.0)]),
        (2_000.0, 1_000.0, 1_009.0, 3_000, &[(2, 4_001.0), (50, 307.0), (700, 2_503.0)]),
        (2_000.0, 500.0, 2_003.0, 300, &[(100, 101.0), (150, 5_003.0)]),
        (400.0, 4_000.0, 101.0, 2_000, &[(3, 41.0)]),
    ];
    for (top, up, down, pulses, changes) in cases {
        let law =
            Austin::new(Rate::MHZ, Speed::from_steps(*top as u32).unwrap(), accel(*up as u32))
                .with_decel(accel(*down as u32));
        let mut delays = law.delays(*pulses).unwrap();
        let mut made = Vec::new();
        loop {
            if let Some(change) = changes.iter().find(|(after, _)| *after == made.len() as u32) {
                delays.set_accel(accel(change.1 as u32));
            }
            let Some(delay) = delays.next() else { break };
            made.push(delay);
        }
        assert_eq!(made.len() as u32, *pulses);
        let wanted = by_formula(*top, *up, *down, *pulses, changes);
        for (n, (made, wanted)) in made[1..].iter().zip(&wanted).enumerate() {
            let off = (f64::from(*made) - wanted).abs();
            assert!(off <= 1.0, "{up} {changes:?}: {n}: {made} {wanted}");
        }
    }
}
