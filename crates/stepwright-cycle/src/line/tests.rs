extern crate std;
use std::format;
use std::string::ToString;

use stepwright::run::Run;

use stepwright_protocol::{Fault, OwnFault, read_row};

use super::*;
use crate::Clock;
use crate::homing::Homing;
use crate::motor::{Calibration, End, Motor};
use crate::program::{DelayRamp, Leg};
use crate::strategy::{
    AtHardEnd, AtSmallDelay, AtSoftEnd, AtTiming, CycleError, Refusal, Strategies,
};

/// Parses a row with its mark.
fn read(text: &str) -> Result<CycleLine, Fault<CycleFault>> {
    let row = text.strip_prefix(':').unwrap_or(text).as_bytes();
    read_row(row, |letter, numbers| CycleLine::read(letter, numbers, 3, 24))
}

const RAMP: DelayRamp = DelayRamp { from: 3_000, to: 600, by: 10 };

fn planned(interval: u64, growth: i32, count: u16, forward: bool) -> Leg {
    Leg::Run { run: Run::new(interval, growth, count), forward }
}

fn lines() -> std::vec::Vec<CycleLine> {
    let motor = Motor::new(7_500, 1_000).braking(u32::MAX).inverted();
    let mut lines = std::vec![
        CycleLine::New,
        CycleLine::Look,
        CycleLine::Clock(Clock::Deadlines, Strategies::CANCEL),
        CycleLine::Wire(2, MotorPins { codes: [0x1A, 0x1D, 8, 9, MotorPins::NO_PIN] }),
        CycleLine::Motor(0, Motor::new(1, u32::MAX)),
        CycleLine::Motor(1, motor.between(-300_000_000, i64::MAX)),
        CycleLine::Motor(2, Motor { min: Some(i64::MIN + 1), ..motor }),
        CycleLine::Motor(2, Motor { max: Some(-1), ..motor }),
        CycleLine::Position(1, -5_000_000_000),
        CycleLine::Leg(0, Leg::Steps { count: i32::MIN, delay: 900 }),
        CycleLine::Leg(23, Leg::Wait { count: u32::MAX, delay: u32::MAX }),
        CycleLine::Leg(1, planned(4_095 << 16 | 0x8001, -0x1_8000, 2_047, true)),
        CycleLine::Leg(2, planned((1 << 47) - 1, i32::MIN, 1, false)),
        CycleLine::Leg(3, planned(1 << 46, 1 << 20, u16::MAX, false)),
        CycleLine::Leg(4, Leg::Run { run: Run::turn(1 << 30, true), forward: true }),
        CycleLine::Start(255),
        CycleLine::Home(7, Homing::new(2, End::Max, 20_000, 200).delays(200, 2_000)),
    ];
    for hard_end in
        [AtHardEnd::StopMotor, AtHardEnd::BrakeMotor, AtHardEnd::Cancel, AtHardEnd::BrakeAll]
    {
        for small_delay in [AtSmallDelay::Fix, AtSmallDelay::StopMotor, AtSmallDelay::Cancel] {
            lines.push(CycleLine::Clock(
                Clock::Grid { period: 200 },
                Strategies {
                    hard_end,
                    small_delay,
                    soft_end: AtSoftEnd::StopMotor,
                    timing: AtTiming::Ignore,
                },
            ));
        }
    }
    for act in LineAct::ALL {
        lines.push(CycleLine::Now(act));
        lines.push(CycleLine::Act(act, 16_000_000_000));
    }
    for calibration in [Calibration::None, Calibration::StartMin, Calibration::BoundsMax] {
        for program in [
            LineProgram::Steps { count: -13_333, delay: 0 },
            LineProgram::Whirl { forward: false, delay: 200 },
            LineProgram::Ramp { steps: Some(800), forward: true, ramp: RAMP },
            LineProgram::Ramp { steps: Some(1 << 31), forward: false, ramp: RAMP },
            LineProgram::Ramp { steps: None, forward: false, ramp: RAMP },
            LineProgram::Legs { first: 3, count: 21 },
        ] {
            lines.push(CycleLine::Prepare(1, calibration, program));
        }
    }
    lines
}

#[test]
fn what_is_written_is_read() {
    for line in lines() {
        let text = line.to_string();
        assert!(text.len() + 3 <= LONGEST, "{text}");
        // A row of all programs, which is not parsed here.
        if text != "Z" {
            assert_eq!(read(&text), Ok(line), "{text}");
        }
    }
}

#[test]
fn a_number_out_of_range_is_refused_with_what_is_allowed() {
    for (line, number, least, most) in [
        (":S3,0,1,1", 1, 0, 2),
        (":S0,3,1,1", 2, 0, 2),
        (":S0,0,2147483648,1", 3, i32::MIN.into(), i32::MAX.into()),
        (":S0,0,1,4294967296", 4, 0, u32::MAX.into()),
        (":S0,0,1,-1", 4, 0, u32::MAX.into()),
        (":H0,0,2,1", 3, 0, 1),
        (":A24,1,1", 1, 0, 23),
        (":L0,0,24,1", 4, 0, 0),
        (":L0,0,3,22", 4, 0, 21),
        (":M0,0,1,0,0,0,0,0", 2, 1, u32::MAX.into()),
        (":M0,1,0,0,0,0,0,0", 3, 1, u32::MAX.into()),
        (":M0,1,1,0,0,3,5,4", 8, 5, i64::MAX),
        (":P0,9223372036854775808", 2, i64::MIN + 1, i64::MAX),
        (":W0,256,0,0,0,0", 2, 0, 255),
        (":C1000001,2,1,2,1", 1, 0, 1_000_000),
        (":C0,4,1,2,1", 2, 0, 3),
        (":T3,0", 1, 0, 2),
        (":T0,-1", 2, 0, i64::MAX),
        (":G0", 1, 1, 255),
        (":G256", 1, 1, 255),
        (":U1,3,0,0,0,0,0", 2, 0, 2),
        (":X24,1,1,0", 1, 0, 23),
        (":X0,65536,1,0", 2, -65_535, 65_535),
        (":X0,1,-1,0", 3, 0, (1 << 47) - 1),
        (":X0,1,140737488355328,0", 3, 0, (1 << 47) - 1),
        (":X0,1,1,2147483648", 4, i32::MIN.into(), i32::MAX.into()),
        // Ten intervals down from 900.
        (":X0,11,900,-91", 4, -90, ((1 << 47) - 1 - 900) / 10),
    ] {
        let fault = Fault::Range { number, least, most };
        assert_eq!(read(line), Err(fault), "{line}");
    }
}

#[test]
fn what_is_no_line_is_not_read() {
    for line in [
        "",
        ":",
        ":?1",
        ":V",
        ":S",
        ":S0",
        ":S0,0,1",
        ":S0,0,1,1,1",
        ":S0,0,1,",
        ":S0,,1,1",
        ":X",
        ":F",
        ":K",
        ":S0,0,--1,1",
        ":S0,0,A,1",
        ":S0,0, 1,1",
        ":s0,0,1,1",
        ":P0,-",
    ] {
        assert_eq!(read(line), Err(Fault::Line), "{line}");
    }
}

#[test]
fn a_fault_comes_back() {
    let (motor, needs) = (2, 300);
    let mut faults = std::vec![CycleFault::Pin { number: 3 }];
    faults.extend(
        [
            Refusal::Running,
            Refusal::NotRunning,
            Refusal::Nothing,
            Refusal::NoMotor,
            Refusal::PeriodTooLong { motor, needs },
            Refusal::PeriodAliquant { motor, needs },
            Refusal::NeedsDeadlines { motor },
            Refusal::SmallDelay { motor, needs },
            Refusal::NoBrakes,
            Refusal::NeedsDecel { motor },
            Refusal::TooFast { motor, needs },
            Refusal::NoTick,
            Refusal::NoPaths { motor },
        ]
        .map(CycleFault::Refused),
    );
    for fault in faults {
        let word = if matches!(fault, CycleFault::Pin { .. }) { "pin" } else { "cycle" };
        let numbers: std::vec::Vec<_> =
            (0..).map_while(|n| fault.number(n)).map(|number| number.to_string()).collect();
        let text = format!("E {word} {}", numbers.join(","));
        assert_eq!(Fault::read(text.as_bytes()), Some(Fault::Own(fault)), "{text}");
    }
    for none in ["E cycle 13,0,0", "E cycle 4", "E pin", "E pin 3,1", "E0"] {
        assert_eq!(Fault::<CycleFault>::read(none.as_bytes()), None, "{none}");
    }
}

#[test]
fn a_report_is_read() {
    let text = b"2,7,16000000,4,0,31,1,0,3,19,300,6,16,5,-30000000,50000000,9,0,0,4,0";
    let report = CycleReport::read(text).expect("a report");
    assert!(report.running && report.paused);
    assert_eq!((report.number, report.time, report.longest), (7, 16_000_000, 31));
    assert_eq!(report.error, Some(CycleError::MotorError { motor: 2 }));
    assert_eq!(report.acts, [Some(0), None, Some(2)]);
    assert_eq!(report.home_refusal(1), Some(Refusal::NoMotor));
    assert_eq!(report.count, 2);
    let [first, second, ..] = report.motors;
    assert_eq!((first.status, first.faults, first.fault_at), (2, 16, Some(4)));
    assert_eq!((first.position, first.max), (-30_000_000, Some(50_000_000)));
    assert_eq!((second.status, second.position, second.max), (1, 4, None));
    assert!(second.uncertain && !first.uncertain);
    for bad in ["", "E", "1,2,3", "0,0,0,0,0,0,0,0,0,0,0", "0,0,0,0,0,0,0,0,0,0,0,1,0,0,4"] {
        assert_eq!(CycleReport::read(bad.as_bytes()), None, "{bad}");
    }
}
