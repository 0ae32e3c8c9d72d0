//! Compares `calc timed` with the manual, the logs and the timed driver.

use super::*;
use clap::Parser;
use stepwright_plan::sheet::Cell;
use stepwright_timed::{Control, Driver, Hold, Model, Pace, SetSpeed, Status};

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
    // "Real: 1.8 RPM, 240 RPM"; the last update ends at a top of 10 clocks more.
    assert_eq!(column(&sheet, "rpm")[0], "1.8");
    assert_eq!(column(&sheet, "rpm")[29], "239.8801");
    let there = args("6 800 --updates 1").sheet().unwrap();
    assert_eq!(column(&there, "rpm")[1], "240");
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
    // Beside the log, and in section 8 at the start. (The log has the second row's speed at
    // the start as well.)
    let (rates, rpm) = (column(&sheet, "rate_steps_s"), column(&sheet, "rpm"));
    for (k, rate, speed) in [
        (0, "3.333333", "1"),
        (2, "13.08793", "3.92638"),
        (3, "25.5489", "7.664671"),
        (4, "48.7619", "14.62857"),
        (10, "461.6139", "138.4842"),
    ] {
        assert_eq!([&rates[k], &rpm[k]], [rate, speed], "{k}");
    }
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

/// Whether a number, printed with as many decimals, gives this text.
fn prints_as(value: f64, printed: &str) -> bool {
    let decimals = printed.split_once('.').map_or(0, |(_, decimals)| decimals.len());
    format!("{value:.decimals$}") == printed
}

fn reals(sheet: &Sheet, key: &str) -> Vec<f64> {
    let i = sheet.columns.iter().position(|(name, _)| *name == key).expect(key);
    let real = |cell: &Cell| match cell {
        Cell::Real(value, _) => *value,
        other => panic!("{key}: {other:?}"),
    };
    sheet.rows.iter().map(|row| real(&row[i])).collect()
}

/// Section 8's first table, every row: 16000000 / top, and 0.3 rpm for each step/s.
#[test]
fn the_linear_table_of_section_8() {
    let sheet = args("1000 51000 --tops --updates 50").sheet().unwrap();
    assert_eq!(whole_fact(&sheet, "modification"), 1000);
    let (tops, rates, rpm) =
        (column(&sheet, "top"), reals(&sheet, "rate_steps_s"), reals(&sheet, "rpm"));
    let printed = [
        ("16000", "4800"),
        ("8000", "2400"),
        ("5333.333", "1600"),
        ("4000", "1200"),
        ("3200", "960"),
        ("2666.667", "800"),
        ("2285.714", "685.7143"),
        ("2000", "600"),
        ("1777.778", "533.3333"),
        ("1600", "480"),
        ("1454.545", "436.3636"),
        ("1333.333", "400"),
        ("1230.769", "369.2308"),
        ("1142.857", "342.8571"),
        ("1066.667", "320"),
        ("1000", "300"),
        ("941.1765", "282.3529"),
        ("888.8889", "266.6667"),
        ("842.1053", "252.6316"),
        ("800", "240"),
        ("761.9048", "228.5714"),
        ("727.2727", "218.1818"),
        ("695.6522", "208.6957"),
        ("666.6667", "200"),
        ("640", "192"),
        ("615.3846", "184.6154"),
        ("592.5926", "177.7778"),
        ("571.4286", "171.4286"),
        ("551.7241", "165.5172"),
        ("533.3333", "160"),
        ("516.129", "154.8387"),
        ("500", "150"),
        ("484.8485", "145.4545"),
        ("470.5882", "141.1765"),
        ("457.1429", "137.1429"),
        ("444.4444", "133.3333"),
        ("432.4324", "129.7297"),
        ("421.0526", "126.3158"),
        ("410.2564", "123.0769"),
        ("400", "120"),
        ("390.2439", "117.0732"),
        ("380.9524", "114.2857"),
        ("372.093", "111.6279"),
        ("363.6364", "109.0909"),
        ("355.5556", "106.6667"),
        ("347.8261", "104.3478"),
        ("340.4255", "102.1277"),
        ("333.3333", "100"),
        ("326.5306", "97.95918"),
        ("320", "96"),
        ("313.7255", "94.11765"),
    ];
    assert_eq!(tops.len(), printed.len());
    for (k, (rate, speed)) in printed.into_iter().enumerate() {
        assert_eq!(tops[k], ((k + 1) * 1000).to_string());
        assert!(prints_as(rates[k], rate), "{}: {} steps/s, not {rate}", tops[k], rates[k]);
        assert!(prints_as(rpm[k], speed), "{}: {} rpm, not {speed}", tops[k], rpm[k]);
    }
}

/// Section 8's second table, every row, with a modification that doubles.
#[test]
fn the_doubling_table_of_section_8() {
    let sheet = args("1000 65536000 --tops --updates 16 --doubling").sheet().unwrap();
    assert_eq!(whole_fact(&sheet, "modification"), 1000);
    let (tops, by) = (column(&sheet, "top"), column(&sheet, "by"));
    let (rates, rpm) = (reals(&sheet, "rate_steps_s"), reals(&sheet, "rpm"));
    let printed = [
        (1000, "16000", "4800"),
        (2000, "8000", "2400"),
        (4000, "4000", "1200"),
        (8000, "2000", "600"),
        (16_000, "1000", "300"),
        (32_000, "500", "150"),
        (64_000, "250", "75"),
        (128_000, "125", "37.5"),
        (256_000, "62.5", "18.75"),
        (512_000, "31.25", "9.375"),
        (1_024_000, "15.625", "4.6875"),
        (2_048_000, "7.8125", "2.34375"),
        (4_096_000, "3.90625", "1.171875"),
        (8_192_000, "1.953125", "0.585938"),
        (16_384_000, "0.976563", "0.292969"),
        (32_768_000, "0.488281", "0.146484"),
        (65_536_000, "0.244141", "0.073242"),
    ];
    assert_eq!(tops.len(), printed.len());
    for (k, (top, rate, speed)) in printed.into_iter().enumerate() {
        assert_eq!(tops[k], top.to_string());
        // The increment in a row of the manual leads to its next row.
        assert!(k == 0 || by[k] == (top / 2).to_string(), "{k}");
        // Excel rounds a half up: 0.9765625.
        let up = |value: f64| value * (1.0 + 1e-12);
        assert!(prints_as(up(rates[k]), rate), "{top}: {} steps/s, not {rate}", rates[k]);
        assert!(prints_as(up(rpm[k]), speed), "{top}: {} rpm, not {speed}", rpm[k]);
    }
}

/// On a host there is no interrupt to disable.
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

/// The table agrees with the timed driver to the clock.
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
        let change = args(line).table(&hardware).unwrap().change().unwrap();
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

/// A change that would leave the timer's range is not made.
#[test]
fn a_fault_keeps_the_speed() {
    let line = "15000 33570000 --tops --updates 25 --doubling --modification 64";
    let sheet = args(line).sheet().unwrap();
    assert_eq!((sheet.rows.len(), sheet.notes.len()), (20, 1));
    // The change ends there, and the drawing continues at the last speed.
    let timed = args(&format!("{line} --every 250ms"));
    let sheet = timed.sheet().unwrap();
    let seconds = sheet.facts.iter().find(|fact| fact.key == "seconds").unwrap();
    assert_eq!(seconds.value.shown(), "4.75");
    let hardware = timed.clock.hardware().unwrap();
    let geometry = timed.geometry.geometry().unwrap();
    let figure = timed.table(&hardware).unwrap().figure(&hardware, &geometry);
    let figure = figure.unwrap();
    let curves = &figure.rows[0].1[0].curves;
    let points = &curves.iter().find(|curve| !curve.dashed).unwrap().points;
    let [.., before, last] = points[..] else { panic!("{points:?}") };
    assert_eq!((before.0, last.0, before.1), (4.75, 6.5, last.1));
    let line = "2000 700 --tops --updates 9 --modification 300";
    assert_eq!(column(&args(line).sheet().unwrap(), "top").last().unwrap(), "800");
}

/// "Maximal ~30, most likely even much less": 30 on a timer of 32 bits, and 25 on an AVR's.
#[test]
fn the_most_updates_that_double() {
    for (tops, timer, most) in [("640 67108863", "avr16", 25), ("640 2147483647", "wide32", 30)] {
        let line = |n| format!("{tops} --tops --timer {timer} --doubling --updates {n}");
        assert!(args(&line(most)).sheet().is_ok(), "{timer}");
        assert!(args(&line(most + 1)).sheet().is_err(), "{timer}");
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
