//! The line and its judge.

use stepwright::late_after;
use stepwright_selftest::{
    CHIPS, Chip, Crc32, Fault, Found, Line, LineError, MOST_PULSES, NRF51, ORDERS, RP2040,
    STM32F411, judge, plan,
};

/// The results of a chip without faults.
fn found(chip: &Chip) -> Found {
    let (mut sum, mut steps) = (Crc32::new(), 0);
    for number in 0..ORDERS {
        assert!(plan(chip, number, &mut sum, |_| steps += 1), "{}: order {number}", chip.name);
    }
    Found { orders: ORDERS, plan: sum.end(), steps, edges: steps, off: chip.bound, late: 0 }
}

fn good(chip: &'static Chip) -> Line<'static> {
    let khz = chip.has_second_clock.then_some(chip.rate.hz() / 1_000);
    let (version, flash) = ("0.1.0", 0x1a2b3c4d);
    Line { chip: chip.name, version, flash, hz: chip.rate.hz(), found: found(chip), khz }
}

fn told(line: &Line<'_>) -> String {
    let mut text = Vec::new();
    line.tell(|byte| text.push(byte));
    String::from_utf8(text).unwrap()
}

#[test]
fn a_line_is_read_as_it_was_told() {
    for chip in &CHIPS {
        let chip = Chip::named(chip.name).unwrap();
        let line = good(chip);
        assert_eq!(Line::read(&told(&line)), Ok(line));
        assert!(judge(&line).unwrap().is_kept(), "{}", chip.name);
    }
}

/// The checksum matches zlib: `python3 -c 'import zlib; print(hex(zlib.crc32(b"…")))'`.
#[test]
fn its_form_is_this() {
    let found = Found { orders: 16, plan: 0xb5e1c9d, steps: 4711, edges: 4710, off: 74, late: 1 };
    let line = Line { found, ..good(&RP2040) };
    assert_eq!(
        told(&line),
        "stepwright-selftest format=1 chip=rp2040 firmware=0.1.0-1a2b3c4d hz=125000000 orders=16 \
         plan=0b5e1c9d steps=4711 edges=4710 off=74 late=1 khz=125000 crc=50a7a2b8"
    );
    assert!(told(&good(&NRF51)).contains(" khz=- crc="));
}

#[test]
fn a_spoilt_line_is_not_read() {
    let whole = told(&good(&RP2040));
    assert_eq!(Line::read("stepwright-selftes format=1"), Err(LineError::Other));
    assert_eq!(Line::read(&whole.replace("format=1", "format=2")), Err(LineError::Format(2)));
    assert_eq!(
        Line::read(&whole.replace("late=0", "late=zero")),
        Err(LineError::Value("late", "zero"))
    );
    // Wherever it is cut off.
    for end in 0..whole.len() {
        assert!(Line::read(&whole[..end]).is_err(), "{}", &whole[..end]);
    }
    // Whichever letter is wrong.
    for at in 0..whole.len() {
        for other in ['1', '7', 'a', ' '] {
            let mut spoilt = whole.clone();
            spoilt.replace_range(at..=at, &other.to_string());
            assert!(spoilt == whole || Line::read(&spoilt).is_err(), "{spoilt}");
        }
    }
}

#[test]
fn whatever_is_wrong_is_named() {
    let faults = |line: Line<'_>| judge(&line).unwrap().faults().collect::<Vec<_>>();
    for chip in [&RP2040, &NRF51] {
        let line = good(chip);
        let f = line.found;
        let with = |found| faults(Line { found, ..line });
        let late = Found { late: 3, ..f };
        assert_eq!(with(late), [Fault::Late(3)]);
        assert_eq!(with(Found { plan: 5, ..f }), [Fault::Plan(5, f.plan)]);
        assert_eq!(with(Found { orders: 15, ..f }), [Fault::Orders(15)]);
        assert_eq!(with(Found { edges: 7, ..f }), [Fault::Edges(7, f.steps)]);
        let lost = Found { edges: 7, steps: 7, ..f };
        assert_eq!(with(lost), [Fault::Steps(7, f.steps)]);
        assert!(
            matches!(with(Found { off: f.off + 1, ..f })[..], [Fault::Off(is, most)] if is > most)
        );
        assert_eq!(faults(Line { hz: 1, ..line }), [Fault::Rate(1, chip.rate.hz())]);
        assert!(judge(&Line { chip: "z80", ..line }).is_none());
    }
    let line = good(&RP2040);
    assert_eq!(faults(Line { khz: None, ..line }), [Fault::NoClock]);
    assert_eq!(faults(Line { khz: Some(124_874), ..line }), [Fault::Clock(124_874, 125_000)]);
    assert_eq!(faults(Line { khz: Some(124_875), ..line }), []);
    assert_eq!(faults(Line { khz: Some(16_000), ..good(&NRF51) }), [Fault::NoClock]);
}

#[test]
fn an_interrupt_may_be_as_far_off_as_is_not_late() {
    for chip in [&NRF51, &STM32F411] {
        assert_eq!(chip.bound, late_after(chip.rate.hz() / chip.top, chip.rate), "{}", chip.name);
    }
}

#[test]
fn orders_are_of_many_kinds() {
    for chip in &CHIPS {
        let mut lengths = Vec::new();
        for number in 0..ORDERS {
            let mut times = Vec::new();
            assert!(plan(chip, number, &mut Crc32::new(), |time| times.push(time)));
            assert!((4..=MOST_PULSES as usize).contains(&times.len()));
            let least = (u64::from(chip.rate.hz() / chip.top) << 16) - 0x10000;
            assert!(times.windows(2).all(|two| two[1] - two[0] >= least), "{}", chip.name);
            lengths.push(times.len());
            // The time fits a counter that wraps after a minute, and the test is short.
            let seconds = *times.last().unwrap() as f64 / 65_536.0 / f64::from(chip.rate.hz());
            assert!(seconds < 4.0, "{} {number}: {seconds} s", chip.name);
        }
        let all: usize = lengths.iter().sum();
        assert!(all > 2_000, "{lengths:?}");
    }
}
