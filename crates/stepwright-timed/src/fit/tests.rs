//! The Arduino driver's spreadsheet and its worked example, and the rule as written in the article.

extern crate std;
use super::*;
use proptest::prelude::*;
use std::string::ToString;

/// A number of 10⁻⁹, rounded to this many decimals, as it would be printed.
fn rounded(nano: u64, decimals: u32) -> u64 {
    let unit = 10u64.pow(9 - decimals);
    (nano + unit / 2) / unit
}

const UNO: Hardware = Hardware::avr16(16_000_000);

#[test]
fn the_spreadsheet_by_steps_per_second() {
    let fit = UNO.fit(UNO.virtual_top_of(180).unwrap()).unwrap();
    assert_eq!((fit.virtual_top(), fit.top(), fit.prescaler()), (88_888, 11_111, 8));
    assert_eq!(rounded(fit.nanosteps(), 4), 1_800_018);
    assert_eq!(rounded(fit.nanorpm(200), 8), 5_400_054_001);
    assert_eq!(fit.deviation_ppb(180 * NANO), 10_000); // 0.00100 %
}

#[test]
fn the_spreadsheet_by_turns_per_minute() {
    // 10 rpm of 200 steps are 33.3 steps/s, rounded down.
    let fit = UNO.fit(UNO.virtual_top_of(10 * 200 / 60).unwrap()).unwrap();
    assert_eq!((fit.virtual_top(), fit.top(), fit.prescaler()), (484_848, 60_606, 8));
    assert_eq!(fit.nanosteps(), 33_000_033_000);
    assert_eq!(rounded(fit.nanorpm(200), 7), 99_000_099);
    assert_eq!(deviation_ppb(fit.nanorpm(200), 10 * NANO), -9_999_010); // −0.999901 %
    assert_eq!(fit.deviation_ppb(33 * NANO), 1_000); // 0.00010 %
}

/// The example says 0x12345 and computes 0xE2345.
#[test]
fn the_worked_example() {
    let fit = UNO.fit(0xE_2345).unwrap();
    assert_eq!((fit.top(), fit.prescaler()), (14_477, 64));
    assert_eq!((fit.interval(), fit.virtual_top()), (926_528, 926_533));
    assert_eq!(u64::from(fit.interval()) * 100_000 / u64::from(fit.virtual_top()), 99_999); // 99.999 %
}

#[test]
fn the_range_of_the_timers() {
    assert_eq!(UNO.max_top(), 0x3FF_FFFF);
    assert_eq!(UNO.slowest_nanosteps(), 238_418_579);
    assert_eq!(UNO.fastest_nanosteps(), 25_000 * NANO);
    // 838.8608 s for a turn of 200 steps.
    assert_eq!(UNO.span() * 200 * 10_000 / 16_000_000, 8_388_608);
    // Section 6: the lowest step rate with a prescaler of 1.
    let alone = Hardware::new(16_000_000, &[0], 16).unwrap();
    assert_eq!(alone.slowest_nanosteps(), 244_140_625_000);
    // Timer 2 at 255 counts: 61.27451 steps/s.
    let timer2 = Hardware::avr8_timer2(16_000_000);
    let slowest = timer2.fit(255 << 10).unwrap();
    assert_eq!((slowest.top(), slowest.prescaler()), (255, 1024));
    assert_eq!(rounded(slowest.nanosteps(), 5), 6_127_451);
    assert_eq!(rounded(slowest.nanorpm(200), 5), 1_838_235);
}

#[test]
fn what_does_not_fit_says_what_does() {
    assert_eq!(UNO.fit(0x3FF_FFFF).unwrap().top(), 0xFFFF);
    assert_eq!(UNO.fit(0x400_0000), Err(Misfit::TooSlow { max: 0x3FF_FFFF }));
    assert_eq!(UNO.fit(u32::MAX), Err(Misfit::TooSlow { max: 0x3FF_FFFF }));
    assert_eq!(UNO.fit(640).unwrap().interval(), 640);
    assert_eq!(UNO.fit(639), Err(Misfit::TooFast { min: 640 }));
    assert_eq!(UNO.fit(0), Err(Misfit::TooFast { min: 640 }));
    assert_eq!(UNO.virtual_top_of(0), Err(Misfit::TooSlow { max: 0x3FF_FFFF }));
    assert_eq!(UNO.virtual_top_of_speed(Speed::ZERO), Err(Misfit::TooSlow { max: 0x3FF_FFFF }));
    assert!(UNO.virtual_top_of(25_001).unwrap_err().to_string().contains("640"));
    let wide = Hardware::wide32(84_000_000);
    assert_eq!(wide.fit(0x7FFF_FFFF).unwrap().interval(), 0x7FFF_FFFF);
    assert_eq!(wide.fit(0x8000_0000), Err(Misfit::TooSlow { max: 0x7FFF_FFFF }));
    assert!(Hardware::new(1, &[], 16).is_err());
    assert!(Hardware::new(1, &[3, 3], 16).is_err());
    assert!(Hardware::new(1, &[0, 17], 16).is_err());
    assert!(Hardware::new(1, &[0], 33).is_err());
}

/// Austin: 120 and 300 rpm of 200 steps are 2500 and 1000 counts at 1 MHz.
#[test]
fn a_capture_module_at_1_mhz() {
    let module = Hardware::capture16(1_000_000);
    for (steps, counts) in [(400, 2_500), (1_000, 1_000)] {
        let fit = module.fit(module.virtual_top_of(steps).unwrap()).unwrap();
        assert_eq!((fit.top(), fit.prescaler()), (counts, 1));
    }
    assert_eq!(module.max_top(), 0x7_FFFF);
    let slow = Speed::from_millisteps(2_500).unwrap();
    assert_eq!(module.virtual_top_of_speed(slow), Ok(400_000));
}

#[test]
fn the_clock_comes_from_fuses_and_clkpr() {
    // The low fuses of Uno and Mega, and of chips as they come from the factory.
    assert_eq!(Oscillator::from_low_fuse(0xFF), Oscillator::Crystal);
    assert_eq!(Oscillator::from_low_fuse(0x62), Oscillator::Rc);
    assert_eq!(Oscillator::from_low_fuse(0xE3), Oscillator::Slow);
    let dividers: std::vec::Vec<_> = (0..=8).map(|clkpr| divider_of(clkpr).unwrap()).collect();
    assert_eq!(dividers, [1, 2, 4, 8, 16, 32, 64, 128, 256]);
    assert_eq!(divider_of(9), None);
    assert_eq!(divider_of(0x83), Some(8)); // the bit CLKPCE is no part of it
    assert_eq!(io_clock(Oscillator::Slow.hz(), 256), Ok(500));
    for divider in [0, 3, 512, u16::MAX] {
        assert!(io_clock(16_000_000, divider).is_err());
    }
}

/// The article's `if` after `if`.
fn the_documents_rule(top: u32) -> Option<(u32, u32)> {
    let (mut top, mut prescaler) = (top, 1);
    for (shift, next) in [(3, 8), (3, 64), (2, 256), (2, 1024)] {
        if top & 0xFFFF_0000 != 0 {
            (top, prescaler) = (top >> shift, next);
        }
    }
    (top & 0xFFFF_0000 == 0).then_some((top, prescaler))
}

proptest! {
    #[test]
    fn every_top_fits_as_the_document_says(bits in 10u32..=32, low: u32) {
        let top = (low >> (32 - bits)).max(MIN_TOP);
        let fit = UNO.fit(top).ok();
        prop_assert_eq!(fit.map(|fit| (fit.top(), fit.prescaler())), the_documents_rule(top));
    }

    #[test]
    fn the_interval_is_short_by_less_than_a_count(top in MIN_TOP..=0x3FF_FFFF, hz in 500u32..) {
        let fit = Hardware::avr16(hz).fit(top).unwrap();
        prop_assert!(fit.interval() <= top && top - fit.interval() < fit.prescaler());
        prop_assert!(u64::from(top - fit.interval()) << 13 <= u64::from(top));
        let real = f64::from(hz) / f64::from(fit.interval());
        let off = fit.nanosteps() as f64 - real * 1e9;
        prop_assert!(off.abs() <= 0.5 + real * 1e9 * 1e-15, "{off}");
        let rpm = fit.nanorpm(200) as f64 - real * 0.3e9;
        prop_assert!(rpm.abs() <= 0.5 + real * 0.3e9 * 1e-15, "{rpm}");
    }
}
