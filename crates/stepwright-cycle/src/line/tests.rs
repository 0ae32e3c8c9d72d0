extern crate std;
use std::format;
use std::string::ToString;

use stepwright::run::Run;

use super::*;
use crate::Clock;
use crate::homing::Homing;
use crate::motor::{Calibration, End, Motor};
use crate::program::{DelayRamp, Leg};
use crate::strategy::{
    AtHardEnd, AtSmallDelay, AtSoftEnd, AtTiming, CycleError, Refusal, Strategies,
};

const RAMP: DelayRamp = DelayRamp { from: 3_000, to: 600, by: 10 };

fn planned(interval: u64, growth: i32, count: u16, forward: bool) -> Leg {
    Leg::Run { run: Run::new(interval, growth, count), forward }
}

fn lines() -> std::vec::Vec<CycleLine> {
    let motor = Motor::new(7_500, 1_000).braking(u32::MAX).inverted();
    let mut lines = std::vec![
        CycleLine::Info,
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
        assert_eq!(CycleLine::read(text.as_bytes(), 3, 24), Ok(line), "{text}");
    }
}

#[test]
fn a_number_out_of_range_is_refused_with_what_is_allowed() {
    for (line, number, least, most) in [
        ("S3,0,1,1", 1, 0, 2),
        ("S0,3,1,1", 2, 0, 2),
        ("S0,0,80000000,1", 3, i32::MIN.into(), i32::MAX.into()),
        ("S0,0,1,100000000", 4, 0, u32::MAX.into()),
        ("S0,0,1,-1", 4, 0, u32::MAX.into()),
        ("H0,0,2,1", 3, 0, 1),
        ("A18,1,1", 1, 0, 23),
        ("L0,0,18,1", 4, 0, 0),
        ("L0,0,3,16", 4, 0, 21),
        ("M0,0,1,0,0,0,0,0", 2, 1, u32::MAX.into()),
        ("M0,1,0,0,0,0,0,0", 3, 1, u32::MAX.into()),
        ("M0,1,1,0,0,3,5,4", 8, 5, i64::MAX),
        ("P0,8000000000000000", 2, i64::MIN + 1, i64::MAX),
        ("W0,100,0,0,0,0", 2, 0, 255),
        ("CF4241,2,1,2,1", 1, 0, 1_000_000),
        ("C0,4,1,2,1", 2, 0, 3),
        ("T3,0", 1, 0, 2),
        ("T0,-1", 2, 0, i64::MAX),
        ("G0", 1, 1, 255),
        ("G100", 1, 1, 255),
        ("U1,3,0,0,0,0,0", 2, 0, 2),
        ("X18,1,1,0", 1, 0, 23),
        ("X0,10000,1,0", 2, -65_535, 65_535),
        ("X0,1,-1,0", 3, 0, (1 << 47) - 1),
        ("X0,1,800000000000,0", 3, 0, (1 << 47) - 1),
        ("X0,1,1,80000000", 4, i32::MIN.into(), i32::MAX.into()),
        // Ten intervals down from 900.
        ("X0,B,384,-5B", 4, -90, ((1 << 47) - 1 - 900) / 10),
    ] {
        let fault = LineFault::Range { number, least, most };
        assert_eq!(CycleLine::read(line.as_bytes(), 3, 24), Err(fault), "{line}");
    }
}

#[test]
fn what_is_no_line_is_not_read() {
    for line in ["", "?1", "V0", "S", "S0", "S0,0,1", "S0,0,1,1,1", "S0,0,1,", "S0,,1,1", "X"] {
        let read = CycleLine::read(line.as_bytes(), 3, 24);
        assert_eq!(read, Err(LineFault::Unknown), "{line}");
    }
    for line in ["S0,0,--1,1", "S0,0,g,1", "S0,0, 1,1", "s0,0,1,1", "P0,-"] {
        let read = CycleLine::read(line.as_bytes(), 3, 24);
        assert_eq!(read, Err(LineFault::Unknown), "{line}");
    }
}

/// Within a line a line feed is a byte that noise has made.
#[test]
fn a_line_feed_stands_between_lines_alone() {
    let mut line = Incoming::new();
    let mut take = |text: &[u8]| {
        text.iter().for_each(|byte| assert!(!line.take(Some(*byte))));
        assert!(line.take(Some(b'\r')));
        line.whole().map(<[u8]>::to_vec)
    };
    assert_eq!(take(b"V"), Some(b"V".to_vec()));
    assert_eq!(take(b"\nV"), Some(b"V".to_vec()));
    assert_eq!(take(b"V\n1"), None);
    assert_eq!(take(b"\n\nV1"), Some(b"V1".to_vec()));
}

#[test]
fn a_fault_comes_back() {
    let (motor, needs) = (2, 300);
    let mut faults = std::vec![
        LineFault::Unknown,
        LineFault::Sum,
        LineFault::Range { number: 8, least: i64::MIN + 1, most: i64::MAX },
        LineFault::Pin { number: 3 },
    ];
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
        .map(LineFault::Refused),
    );
    for fault in faults {
        let [a, b, c, d] = fault.numbers();
        let text = [a, b, c, d].map(|number| {
            format!("{}{:X}", if number < 0 { "-" } else { "" }, number.unsigned_abs())
        });
        assert_eq!(LineFault::read(text.join(",").as_bytes()), Some(fault));
    }
    assert_eq!(LineFault::read(b"5,0,0,0"), None);
    assert_eq!(LineFault::read(b"4,D,0,0"), None);
    assert_eq!(LineFault::read(b"0"), None);
}

#[test]
fn a_report_is_read() {
    let text = b"2,7,F42400,4,0,1F,1,0,3,13,12C,6,10,5,-1C9C380,2FAF080,1,0,0,4,0";
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
    for bad in ["", "E", "1,2,3", "0,0,0,0,0,0,0,0,0,0,0", "0,0,0,0,0,0,0,0,0,0,0,1,0,0,4"] {
        assert_eq!(CycleReport::read(bad.as_bytes()), None, "{bad}");
    }
}
