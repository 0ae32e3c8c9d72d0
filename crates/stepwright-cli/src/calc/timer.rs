//! `calc timer`: a speed on a hardware timer (the Arduino driver, sections 4 and 6).

use stepwright_plan::calc::{TimerSpeed, timer};
use stepwright_plan::sheet::Sheet;
use stepwright_units::measure::whole;

use super::Calculator;
use super::clock::ClockArgs;
use crate::failure::Failure;
use crate::quantity::{GeometryArgs, SpeedArg};

/// A speed on a timer.
#[derive(clap::Args)]
pub struct Args {
    /// How fast: 180, 10rpm, 0.5rev/s … (a bare number is steps/s)
    #[arg(value_name = "SPEED", allow_hyphen_values = true)]
    #[arg(required_unless_present = "top", conflicts_with = "top")]
    speed: Option<SpeedArg>,
    /// A virtual top instead: 926533, 0xE2345
    #[arg(long, value_name = "N", value_parser = whole)]
    top: Option<u32>,
    /// Do not round the speed to whole steps/s
    #[arg(long, conflicts_with = "top")]
    exact: bool,
    #[command(flatten)]
    clock: ClockArgs,
    #[command(flatten)]
    geometry: GeometryArgs,
}

impl Calculator for Args {
    fn sheet(&self) -> Result<Sheet, Failure> {
        let wanted = match &self.speed {
            Some(speed) => TimerSpeed::Speed { speed: speed.clone(), exact: self.exact },
            None => TimerSpeed::Top(self.top.unwrap_or_default()),
        };
        Ok(timer(&wanted, &self.clock.hardware()?, &self.geometry.geometry()?)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;
    use stepwright_plan::sheet::Cell;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        args: Args,
    }

    fn sheet(line: &str) -> Result<Sheet, Failure> {
        Line::parse_from(format!("calc {line}").split_whitespace()).args.sheet()
    }

    /// A fact as text.
    fn shown(sheet: &Sheet, key: &str) -> String {
        let fact = sheet.facts.iter().find(|fact| fact.key == key);
        match fact.map(|fact| &fact.value) {
            Some(Cell::Whole(value)) => value.to_string(),
            Some(Cell::Real(_, text)) => text.clone(),
            other => panic!("{key}: {other:?}"),
        }
    }

    #[track_caller]
    fn check(line: &str, want: &[(&str, &str)]) {
        let sheet = sheet(line).unwrap();
        for (key, value) in want {
            assert_eq!(shown(&sheet, key), *value, "{line}: {key}");
        }
    }

    /// Section 6: the spreadsheet's two examples.
    #[test]
    fn the_spreadsheet() {
        check(
            "180",
            &[
                ("io_clock_hz", "16000000"),
                ("virtual_top", "88888"),
                ("top", "11111"),
                ("prescaler", "8"),
                ("rate_steps_s", "180.0018"),
                ("deviation_percent", "0.001000"),
                ("rpm", "54.00054001"),
                ("turns_s", "0.900009"),
            ],
        );
        check(
            "10rpm",
            &[
                ("wanted_steps_s", "33"),
                ("virtual_top", "484848"),
                ("top", "60606"),
                ("prescaler", "8"),
                ("rate_steps_s", "33.000033"),
                ("deviation_percent", "0.000100"),
                ("rpm", "9.9000099"),
                ("rpm_deviation_percent", "-0.999901"),
                ("turns_s", "0.165"),
            ],
        );
        // Sections 1 and 7: 200 steps/rev; the text of the example asks for 2 and 120 rpm, its code
        // for 6 and 800 steps/s, which are 1.8 and 240 rpm.
        check("100", &[("rpm", "30")]);
        check("2rpm", &[("wanted_steps_s", "6"), ("virtual_top", "2666666")]);
        check("120rpm", &[("wanted_steps_s", "400"), ("rpm", "120")]);
        check("800", &[("virtual_top", "20000"), ("rpm", "240")]);
        check("10rpm --exact", &[("virtual_top", "480000"), ("rpm", "10")]);
    }

    /// Section 4: 0xE2345, printed as 0x12345.
    #[test]
    fn a_virtual_top() {
        check(
            "--top 0xE2345",
            &[
                ("virtual_top", "926533"),
                ("top", "14477"),
                ("prescaler", "64"),
                ("interval", "926528"),
                ("interval_percent", "99.999"),
            ],
        );
        // "Steps per second: 17, expected RPM: 5.1": both are printed without further decimals.
        check("--top 0xE2345", &[("wanted_steps_s", "17.26867796")]);
        // Section 7's calls.
        check("--top 32000", &[("rate_steps_s", "500"), ("rpm", "150")]);
        check("--top 64000", &[("rate_steps_s", "250"), ("rpm", "75")]);
    }

    #[test]
    fn other_clocks_and_timers() {
        check("20 --oscillator 8MHz --clkpr 4", &[("io_clock_hz", "2000000"), ("top", "12500")]);
        check(
            "100 --timer avr8",
            &[("virtual_top", "160000"), ("top", "156"), ("prescaler", "1024")],
        );
        check("400 --timer wide32 --oscillator 80MHz", &[("top", "200000"), ("prescaler", "1")]);
        check("50mm/s --mm-per-rev 40", &[("wanted_steps_s", "250"), ("virtual_top", "64000")]);
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        for line in ["0", "25001", "0.2 --exact", "0.5", "--top 67108864", "--top 639"] {
            assert!(sheet(line).is_err(), "{line}");
        }
        assert!(sheet("50mm/s").is_err());
        assert!(Line::try_parse_from(["calc", "1", "--clkpr", "3"]).is_err());
    }
}
