//! Against the manual, the logs, and the core's driver.

use super::*;
use clap::Parser;
use stepwright::timed::{Control, Driver, Hold, Model, Pace, SetSpeed, Status};

#[derive(Parser)]
struct Line {
    #[command(flatten)]
    args: Args,
}

fn args(line: &str) -> Args {
    Line::parse_from(format!("calc {line}").split_whitespace()).args
}

fn whole_fact(sheet: &Sheet, key: &str) -> i64 {
    match sheet.facts.iter().find(|fact| fact.key == key).expect(key).value {
        Cell::Whole(value) => value,
        ref other => panic!("{key}: {other:?}"),
    }
}

fn column(sheet: &Sheet, key: &str) -> Vec<String> {
    let i = sheet.columns.iter().position(|(name, _)| *name == key).expect(key);
    let shown = |cell: &Cell| match cell {
        Cell::Whole(value) => value.to_string(),
        Cell::Real(_, text) => text.clone(),
        _ => String::new(),
    };
    sheet.rows.iter().map(|row| shown(&row[i])).collect()
}

/// Section 7: (2666666 − 20000) / 29, and 20010 at the end.
#[test]
fn the_manuals_example() {
    let sheet = args("6 800 --updates 29 --every 250ms").sheet().unwrap();
    assert_eq!(whole_fact(&sheet, "start_top"), 2_666_666);
    assert_eq!(whole_fact(&sheet, "wanted_top"), 20_000);
    assert_eq!(whole_fact(&sheet, "modification"), 91_264);
    assert_eq!(whole_fact(&sheet, "end_top"), 20_010);
    assert_eq!(column(&sheet, "time_s").last().unwrap(), "7.25");
    // "Real: 1.8 RPM, 240 RPM".
    assert_eq!(column(&sheet, "rpm")[0], "1.8");
}

/// Section 8: 4768000 / (2 − 2^−10), which the manual rounds to 2385000.
#[test]
fn a_halving_modification() {
    let sheet = args("1rpm 500 --updates 11 --doubling").sheet().unwrap();
    assert_eq!(whole_fact(&sheet, "start_top"), 4_800_000);
    assert_eq!(whole_fact(&sheet, "wanted_top"), 32_000);
    assert_eq!(whole_fact(&sheet, "modification"), 2_385_164);
}

/// Case 2, every row of the log.
#[test]
fn case_2() {
    let line = "4800000 32000 --tops --updates 11 --halving --modification 2385000";
    let sheet = args(line).sheet().unwrap();
    let tops = [
        4_800_000, 2_415_000, 1_222_500, 626_250, 328_125, 179_063, 104_532, 67_267, 48_635,
        39_319, 34_661, 32_332,
    ];
    assert_eq!(column(&sheet, "top"), tops.map(|top: u32| top.to_string()));
    let by =
        [2_385_000, 1_192_500, 596_250, 298_125, 149_062, 74_531, 37_265, 18_632, 9316, 4658, 2329];
    assert_eq!(column(&sheet, "by")[1..], by.map(|by: i64| (-by).to_string()));
    // Beside the log: 13.08793, 25.5489, 48.7619 and 461.6139 steps/s.
    let rates = column(&sheet, "rate_steps_s");
    assert_eq!(
        [&rates[2], &rates[3], &rates[4], &rates[10]],
        ["13.08793", "25.5489", "48.7619", "461.6139"]
    );
    assert_eq!(column(&sheet, "rpm")[10], "138.4842");
}

/// Case 1: 15000 + 64·(2^k − 1).
#[test]
fn case_1() {
    let line = "15000 33570000 --tops --updates 19 --doubling --modification 64";
    let tops = column(&args(line).sheet().unwrap(), "top");
    assert_eq!(tops.len(), 20);
    for (top, k) in tops.iter().zip(0..) {
        assert_eq!(*top, (15_000 + 64 * ((1 << k) - 1)).to_string());
    }
}

/// Section 8's two tables: RPM as printed there.
#[test]
fn the_tables_of_section_8() {
    let sheet = args("1000 51000 --tops --updates 50").sheet().unwrap();
    assert_eq!(whole_fact(&sheet, "modification"), 1000);
    let (rates, rpm) = (column(&sheet, "rate_steps_s"), column(&sheet, "rpm"));
    for (timer, rate, speed) in [
        (1, "16000", "4800"),
        (3, "5333.333", "1600"),
        (7, "2285.714", "685.7143"),
        (9, "1777.778", "533.3333"),
        (17, "941.1765", "282.3529"),
        (22, "727.2727", "218.1818"),
        (29, "551.7241", "165.5172"),
        (35, "457.1429", "137.1429"),
        (43, "372.093", "111.6279"),
        (49, "326.5306", "97.95918"),
        (51, "313.7255", "94.11765"),
    ] {
        assert_eq!([&rates[timer - 1], &rpm[timer - 1]], [rate, speed], "{timer}000");
    }
    let sheet = args("1000 65536000 --tops --updates 16 --doubling").sheet().unwrap();
    assert_eq!(whole_fact(&sheet, "modification"), 1000);
    let (rates, rpm) = (column(&sheet, "rate_steps_s"), column(&sheet, "rpm"));
    for (k, rate, speed) in [
        (0, "16000", "4800"),
        (5, "500", "150"),
        (7, "125", "37.5"),
        (11, "7.8125", "2.34375"),
        (12, "3.90625", "1.171875"),
    ] {
        assert_eq!([&rates[k], &rpm[k]], [rate, speed], "{k}");
    }
    // Printed with fewer digits: 0.244141 and 0.073242.
    assert_eq!([&rates[16], &rpm[16]], ["0.2441406", "0.07324219"]);
}

/// A host has no interrupt to hold off.
struct Here(Pace);

impl Hold for Here {
    fn with<R>(&mut self, look: impl FnOnce(&mut Pace) -> R) -> R {
        look(&mut self.0)
    }
    fn begin(&mut self, pace: Pace, _forward: bool) {
        self.0 = pace;
    }
    fn stop(&mut self) {}
}

/// The table is what the core's driver does, to the clock.
#[test]
fn the_driver_does_as_the_table_says() {
    let hardware = Hardware::avr16(16_000_000);
    for line in [
        "6 800 --updates 29",
        "1rpm 500 --updates 11 --doubling",
        "500 1rpm --updates 13 --doubling",
        "15000 33570000 --tops --updates 25 --doubling --modification 64",
        "2000 700 --tops --updates 9 --modification 300",
        "9000 700 --tops --updates 40 --doubling",
    ] {
        let (change, _) = args(line).change(&hardware).unwrap();
        let bit = |set, bit| if set { bit } else { Control::OFF };
        let order = SetSpeed {
            modification: change.modification,
            update_ms: 1,
            mod_counts: change.updates,
            ..SetSpeed::fixed(
                Control::DRV_EN
                    | Control::SPEED_VARIABLE
                    | bit(change.faster, Control::FASTER)
                    | bit(change.doubling, Control::VARIABLE_PWR),
                change.start,
            )
        };
        let mut here = Here(Pace::idle());
        let mut driver = Driver::new(hardware, Model::Ideal);
        assert!(!driver.set_speed(&mut here, &order, 0).is_error());
        let mut tops = vec![change.start];
        for ms in 1..=change.updates.into() {
            driver.update_check(&mut here, ms, |_| {});
            if driver.status(&mut here).has(Status::FAULT) {
                break;
            }
            tops.push(driver.dump(&mut here, 0).top);
        }
        let table: Vec<u32> = change.states(hardware).map(|state| state.top).collect();
        assert_eq!(table, tops, "{line}");
    }
}

/// What would leave the timer's range is not made.
#[test]
fn a_fault_keeps_the_speed() {
    let line = "15000 33570000 --tops --updates 25 --doubling --modification 64";
    let sheet = args(line).sheet().unwrap();
    assert_eq!((sheet.rows.len(), sheet.notes.len()), (20, 1));
    let line = "2000 700 --tops --updates 9 --modification 300";
    assert_eq!(column(&args(line).sheet().unwrap(), "top").last().unwrap(), "800");
}

/// The most updates that are named are the most there are.
#[test]
fn too_many_updates() {
    for (way, doubling) in [(10, false), (1000, true), (1023, true), (1022, true)] {
        let most = if doubling { u32::ilog2(way + 1) } else { way } as u16;
        assert!(modification(way, most, doubling, false) > 0, "{way}");
        assert_eq!(modification(way, most + 1, doubling, false), 0, "{way}");
    }
}

#[test]
fn what_makes_no_sense_is_refused() {
    for line in [
        "6 0 --updates 3",
        "6 30000 --updates 3",
        "6 7 --updates 65535 --doubling --tops",
        "1000 1010 --tops --updates 11",
        "1000 2000 --tops --updates 11 --doubling",
        "800 800 --updates 11",
        "x 2000 --updates 11",
    ] {
        assert!(args(line).sheet().is_err(), "{line}");
    }
}
