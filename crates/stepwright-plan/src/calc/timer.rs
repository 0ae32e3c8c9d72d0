//! A speed on a hardware timer (the Arduino driver, sections 4 and 6).

use stepwright::Geometry;
use stepwright_timed::fit::{Hardware, deviation_ppb};
use stepwright_units::SpeedArg;

use super::CalcError;
use super::clock::virtual_top;
use crate::sheet::{Cell, Sheet};

/// What the timer has to make.
#[derive(Clone, Debug)]
pub enum TimerSpeed {
    /// A speed, rounded down to whole steps/s unless it is `exact`.
    Speed {
        /// The speed.
        speed: SpeedArg,
        /// Whether the speed is not rounded.
        exact: bool,
    },
    /// A virtual top.
    Top(u32),
}

/// The virtual top, the prescaler and the real rate.
///
/// # Errors
/// The timer can't make the speed; the speed is less than one step/s; its unit is not known.
pub fn timer(
    target: &TimerSpeed,
    hardware: &Hardware,
    geometry: &Geometry,
) -> Result<Sheet, CalcError> {
    let turn = geometry.steps_per_turn();
    let mut sheet;
    // In steps/s: the rate to make, and the rate that was asked for.
    let (wanted, asked, top) = match target {
        TimerSpeed::Speed { speed, exact } => {
            let asked = speed.steps(geometry, "SPEED")?;
            // Adds 5·10⁻¹⁰ steps/s before rounding down: 54 rpm of 200 steps are 180 steps/s.
            let whole = if *exact { asked } else { (asked + 5e-10).floor() };
            let given = speed.given();
            if whole == 0.0 && asked > 0.0 {
                return Err(CalcError::BelowOne { given: given.to_owned() });
            }
            sheet = Sheet::new(format!("{given} on a timer of {} bits", hardware.bits()));
            sheet.fact("asked_steps_s", "asked for", Cell::digits(asked, 10), "steps/s");
            if whole != asked {
                let note =
                    "rounded down to whole steps/s, as the Arduino driver does; --exact does not";
                sheet.notes.push(note.into());
            }
            if !*exact {
                sheet.fact("wanted_steps_s", "whole", Cell::digits(whole, 10), "steps/s");
            }
            (whole, asked, virtual_top(hardware, whole, given)?)
        }
        &TimerSpeed::Top(top) => {
            sheet = Sheet::new(format!("virtual top {top} on a timer of {} bits", hardware.bits()));
            let rate = f64::from(hardware.hz()) / f64::from(top);
            sheet.fact("wanted_steps_s", "wanted", Cell::digits(rate, 10), "steps/s");
            (rate, rate, top)
        }
    };
    let fit =
        hardware.fit(top).map_err(|why| CalcError::Misfit { what: sheet.title.clone(), why })?;
    let nano = |steps: f64| (steps * 1e9).round() as u64;
    let percent = |ppb: i64| Cell::fixed(ppb as f64 / 1e7, 6);
    let seconds = f64::from(fit.interval()) / f64::from(hardware.hz());
    let (rate, rpm) = (1.0 / seconds, 60.0 / seconds / f64::from(turn));

    sheet.fact("io_clock_hz", "I/O clock", hardware.hz(), "Hz");
    sheet.fact("virtual_top", "virtual top", top, "clocks");
    sheet.fact("top", "top", fit.top(), "");
    sheet.fact("prescaler", "prescaler", fit.prescaler(), "");
    sheet.fact("interval", "interval", fit.interval(), "clocks");
    let part = f64::from(fit.interval()) / f64::from(top) * 100.0;
    sheet.fact("interval_percent", "… of the wanted", Cell::fixed(part, 3), "%");
    sheet.fact("interval_ms", "… in time", Cell::digits(seconds * 1e3, 8), "ms");
    sheet.fact("rate_steps_s", "real rate", Cell::digits(rate, 10), "steps/s");
    let deviation = percent(fit.deviation_ppb(nano(wanted)));
    sheet.fact("deviation_percent", "… deviation", deviation, "%");
    sheet.fact("rpm", "real speed", Cell::digits(rpm, 10), "rpm");
    if matches!(target, TimerSpeed::Speed { .. }) {
        let asked = nano(asked * 60.0 / f64::from(turn));
        let deviation = percent(deviation_ppb(fit.nanorpm(turn), asked));
        sheet.fact("rpm_deviation_percent", "… deviation", deviation, "%");
    }
    sheet.fact("turns_s", "turns", Cell::digits(rpm / 60.0, 6), "rev/s");
    sheet.fact("turn_s", "one turn takes", Cell::digits(60.0 / rpm, 8), "s");
    Ok(sheet)
}
