//! Typed values against the stored ones.

use super::*;
use proptest::prelude::*;

fn motor() -> Geometry {
    Geometry::new(200).unwrap().travelling_nm(40_000_000).unwrap()
}

fn speed(text: &str) -> String {
    text.parse::<SpeedArg>().unwrap().resolve(&motor(), "--top-speed").unwrap().to_string()
}

fn accel(text: &str) -> String {
    text.parse::<AccelArg>().unwrap().resolve(&motor(), "--accel").unwrap().to_string()
}

#[test]
fn speeds_in_every_unit() {
    for (typed, held) in [
        ("400", "400 steps/s"),
        ("400steps/s", "400 steps/s"),
        ("0.5", "0.5 steps/s"),
        ("120rpm", "120rpm → 400 steps/s"),
        ("120 RPM", "120 RPM → 400 steps/s"),
        ("2rev/s", "2rev/s → 400 steps/s"),
        ("2turns/s", "2turns/s → 400 steps/s"),
        ("120rev/min", "120rev/min → 400 steps/s"),
        ("360deg/s", "360deg/s → 200 steps/s"),
        ("1.8°/s", "1.8°/s → 1 steps/s"),
        ("50mm/s", "50mm/s → 250 steps/s"),
        ("3000mm/min", "3000mm/min → 250 steps/s"),
        ("10rad/s", "10rad/s ≈ 318.31 steps/s"),
        ("100rpm", "100rpm ≈ 333.333 steps/s"),
        ("0.0004", "0.0004 ≈ 0 steps/s"),
        ("1000000", "1000000 steps/s"),
    ] {
        assert_eq!(speed(typed), held);
    }
}

/// The value used in calculations is the stored one, except for rounding to a thousandth.
#[test]
fn speeds_are_computed_as_they_are_held() {
    for typed in ["400", "120rpm", "2rev/s", "7.5deg/s", "3000mm/min", "10rad/s", "100rpm", "0"] {
        let arg: SpeedArg = typed.parse().unwrap();
        let held = arg.resolve(&motor(), "--top-speed").unwrap();
        let steps = arg.steps(&motor(), "--top-speed").unwrap() * 1000.0;
        let slack = if held.exact { 1e-9 } else { 0.5 };
        assert!((steps - f64::from(held.value.millisteps())).abs() <= slack, "{typed}: {steps}");
    }
    let arg: SpeedArg = "5mm/s".parse().unwrap();
    assert!(arg.steps(&Geometry::new(200).unwrap(), "--top-speed").is_err());
}

#[test]
fn accelerations_in_every_unit() {
    for (typed, held) in [
        ("400", "400 steps/s²"),
        ("400steps/s2", "400 steps/s²"),
        ("400 steps/s²", "400 steps/s²"),
        ("400steps/s^2", "400 steps/s²"),
        ("400steps/s/s", "400 steps/s²"),
        ("120rpm/s", "120rpm/s → 400 steps/s²"),
        ("2rev/s2", "2rev/s2 → 400 steps/s²"),
        ("200mm/s2", "200mm/s2 → 1000 steps/s²"),
        // Austin: 4π rad/s² of a 1.8° motor are 400 steps/s².
        ("12.566rad/s2", "12.566rad/s2 ≈ 399.988 steps/s²"),
        ("12.566370614359172rad/s2", "12.566370614359172rad/s2 ≈ 400 steps/s²"),
    ] {
        assert_eq!(accel(typed), held);
    }
}

#[test]
fn jerks_in_every_unit() {
    let jerk = |text: &str| {
        text.parse::<JerkArg>().unwrap().resolve(&motor(), "--jerk").unwrap().to_string()
    };
    for (typed, held) in [
        ("4000", "4000 steps/s³"),
        ("4000steps/s3", "4000 steps/s³"),
        ("4000 steps/s³", "4000 steps/s³"),
        ("4000steps/s^3", "4000 steps/s³"),
        ("4000steps/s/s/s", "4000 steps/s³"),
        ("120rpm/s2", "120rpm/s2 → 400 steps/s³"),
        ("120rpm/s/s", "120rpm/s/s → 400 steps/s³"),
        ("2rev/s3", "2rev/s3 → 400 steps/s³"),
        ("360deg/s3", "360deg/s3 → 200 steps/s³"),
        ("200mm/s3", "200mm/s3 → 1000 steps/s³"),
        ("12.566rad/s3", "12.566rad/s3 ≈ 399.988 steps/s³"),
        ("1000000000000000", "1000000000000000 steps/s³"),
    ] {
        assert_eq!(jerk(typed), held);
    }
    for (typed, word) in [
        ("5rpm/s", "'rpm/s' is a unit of acceleration; for a jerk use steps/s3"),
        ("5mm/s", "is a unit of speed; for a jerk use"),
        ("5x", "no unit of a jerk"),
        ("-5", "without a sign"),
    ] {
        let error = typed.parse::<JerkArg>().unwrap_err();
        assert!(error.contains(word), "{typed}: {error}");
    }
    for typed in ["0", "0.0004", "1000000000000001"] {
        assert!(typed.parse::<JerkArg>().unwrap().resolve(&motor(), "--jerk").is_err());
    }
    let error = "5rad/s3".parse::<AccelArg>().unwrap_err();
    assert!(error.contains("'rad/s3' is a unit of jerk"), "{error}");
}

#[test]
fn what_is_wrong_is_said() {
    for (typed, word) in [
        ("", "begins with a number"),
        ("fast", "begins with a number"),
        ("-5", "without a sign"),
        ("1,000", "decimal point"),
        ("1.2.3", "not a number"),
        ("5furlong/s", "'furlong/s' is no unit of a speed"),
        ("5s", "no unit"),
        ("5/s", "no unit"),
        ("5rpm/s", "unit of acceleration"),
        ("12345678901234567890", "too many digits"),
    ] {
        let error = typed.parse::<SpeedArg>().unwrap_err();
        assert!(error.contains(word), "{typed}: {error}");
    }
    for (typed, word) in
        [("5rpm", "'rpm/s'"), ("5mm/s", "'mm/s2'"), ("5rev/min", "'rev/min/s'"), ("5x", "no unit")]
    {
        let error = typed.parse::<AccelArg>().unwrap_err();
        assert!(error.contains(word), "{typed}: {error}");
    }
}

#[test]
fn what_the_core_cannot_hold_is_refused() {
    let motor = Geometry::new(200).unwrap();
    let speed = |text: &str| text.parse::<SpeedArg>().unwrap().resolve(&motor, "--top-speed");
    let accel = |text: &str| text.parse::<AccelArg>().unwrap().resolve(&motor, "--accel");
    assert!(speed("1000000.0004").is_ok());
    for result in
        [speed("1000001"), speed("5000000000"), speed("999999999999999rpm"), speed("1mm/s")]
    {
        assert!(result.is_err());
    }
    for result in [accel("0"), accel("0.0004"), accel("100000001"), accel("1mm/s2")] {
        assert!(result.is_err());
    }
}

#[test]
fn signs_are_directions() {
    for (typed, forward) in [("100", true), ("+100", true), ("-100", false), ("\u{2212}100", false)]
    {
        let signed: SignedSpeedArg = typed.parse().unwrap();
        assert_eq!(signed.forward, forward);
        assert_eq!(signed.speed, "100".parse().unwrap());
    }
    assert!("--100".parse::<SignedSpeedArg>().is_err());
}

#[test]
fn distances_of_a_turn() {
    let nm = |text: &str| text.parse::<MmArg>().map(|MmArg(nm)| nm);
    assert_eq!(nm("40"), Ok(40_000_000));
    assert_eq!(nm("3.175mm"), Ok(3_175_000));
    for text in ["0", "0.0000001", "5000", "2in", ""] {
        assert!(nm(text).is_err(), "{text}");
    }
}

proptest! {
    /// Against f64, which is good to 15 digits: at most half a thousandth off.
    #[test]
    fn every_unit_is_rounded_once(
        digits in 1u64..100_000_000,
        places in 0u32..5,
        steps in 1u32..100_000,
        nm in 1_000u32..,
        unit in 0usize..6,
    ) {
        let geometry = Geometry::new(steps).unwrap().travelling_nm(nm).unwrap();
        let typed = digits as f64 / 10f64.powi(places as i32);
        let scale = 10u64.pow(places);
        let (whole, part) = (digits / scale, digits % scale);
        let (name, per) = [
            ("steps/s", 1.0),
            ("rpm", f64::from(steps) / 60.0),
            ("rev/s", f64::from(steps)),
            ("deg/s", f64::from(steps) / 360.0),
            ("rad/s", f64::from(steps) / std::f64::consts::TAU),
            ("mm/s", f64::from(steps) * 1e6 / f64::from(nm)),
        ][unit];
        let text = format!("{whole}.{part:0places$}{name}", places = places as usize);
        let want = typed * per;
        match text.parse::<SpeedArg>().unwrap().resolve(&geometry, "x") {
            Ok(held) => {
                let off = (f64::from(held.value.millisteps()) - want * 1e3).abs();
                prop_assert!(off <= 0.5001, "{text}: {} is not {want}", held.value);
                prop_assert!(!held.exact || off < 1e-4, "{text}: {off}");
            }
            Err(_) => prop_assert!(want > 999_999.9, "{text} is {want}"),
        }
    }

    #[test]
    fn no_text_panics(text in "\\PC{0,24}") {
        let _ = text.parse::<SignedSpeedArg>();
        let _ = text.parse::<AccelArg>();
    }

    #[test]
    fn no_number_panics(digits in "[0-9.]{0,40}", unit in "(rpm|mm/s|rad/s2|rpm/s|)") {
        let geometry = Geometry::new(10_000_000).unwrap().travelling_nm(1).unwrap();
        let text = format!("{digits}{unit}");
        let _ = text.parse::<SpeedArg>().map(|v| v.resolve(&geometry, "x"));
        let _ = text.parse::<AccelArg>().map(|a| a.resolve(&geometry, "x"));
    }
}
