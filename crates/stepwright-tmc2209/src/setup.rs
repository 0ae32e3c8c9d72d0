//! The set-up of a driver.

use embedded_hal_async::delay::DelayNs;
use embedded_io_async::{Read, Write};
use stepwright::{OutOfRange, Speed};
use tmc2209::data::MicroStepResolution;
use tmc2209::reg;

use crate::current::Scale;
use crate::error::DriverError;
use crate::faults::DriverFaults;
use crate::line::Tmc2209;

/// The chip's own clock, in Hz.
const CLOCK: u64 = 12_000_000;
/// The highest value of a register of 20 bits.
const LONGEST: u64 = (1 << 20) - 1;
/// The version that every TMC2209 reports so far.
const VERSION: u8 = 0x21;

/// The settings of a driver.
///
/// ```
/// use stepwright::Speed;
/// use stepwright_tmc2209::DriverSetup;
///
/// // A sense resistor of 0.11 Ω, 800 mA; 400 mA at rest, 16 microsteps. Stalls are detected
/// // from 2,000 steps/s on.
/// let setup = DriverSetup::new(110, 800).hold(400).microsteps(16).stall(60, Speed::of::<2_000>());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DriverSetup {
    sense_milliohms: u16,
    run: u16,
    /// The current at rest; `None` stands for half of `run`.
    hold: Option<u16>,
    microsteps: u16,
    stall: u8,
    stall_from: Option<Speed>,
}

impl DriverSetup {
    /// Settings for a sense resistor in mΩ, as the board's maker states it (0.11 Ω is usual), and
    /// for a motor current in mA (rms). The current at rest is half of that, or the chip's lowest
    /// step; 16 microsteps, no stall detection.
    pub const fn new(sense_milliohms: u16, milliamps: u16) -> DriverSetup {
        DriverSetup {
            sense_milliohms,
            run: milliamps,
            hold: None,
            microsteps: 16,
            stall: 0,
            stall_from: None,
        }
    }

    /// Sets the current at rest in mA; 0 is the chip's lowest step.
    #[must_use]
    pub const fn hold(self, milliamps: u16) -> DriverSetup {
        DriverSetup { hold: Some(milliamps), ..self }
    }

    /// Sets the microsteps per full step: 1, 2, 4 … 256.
    #[must_use]
    pub const fn microsteps(self, microsteps: u16) -> DriverSetup {
        DriverSetup { microsteps, ..self }
    }

    /// Has DIAG report stalls from a speed in (micro)steps/s on; below it StallGuard can't detect
    /// them. The higher the threshold, the lower the load that counts as a stall. Find the
    /// threshold by trial ([`load`](Tmc2209::load) helps), at the speed and the current of the
    /// application.
    #[must_use]
    pub const fn stall(self, threshold: u8, from: Speed) -> DriverSetup {
        DriverSetup { stall: threshold, stall_from: Some(from), ..self }
    }

    /// The CS of the current at rest.
    fn hold_steps(&self, scale: Scale) -> Result<u8, OutOfRange> {
        match self.hold {
            // Half of a valid current may be below the lowest step, but is never above the highest.
            None => Ok(scale.steps(self.run / 2).unwrap_or(0)),
            Some(0) => Ok(0),
            Some(given) => scale.steps(given).map_err(|range| OutOfRange {
                what: "current at rest",
                unit: "mA, or 0",
                ..range
            }),
        }
    }

    /// The exponent of the microsteps per full step.
    fn resolution(&self) -> Result<MicroStepResolution, OutOfRange> {
        if self.microsteps.is_power_of_two() && self.microsteps <= 256 {
            Ok(MicroStepResolution::from_microsteps(self.microsteps.into()))
        } else {
            Err(OutOfRange { what: "microsteps", min: 1, max: 256, unit: "(a power of two)" })
        }
    }

    /// TSTEP at the speed from which stalls are detected: the chip's clock ticks in 1/256 of a full
    /// step.
    fn stall_ticks(&self) -> Result<u32, OutOfRange> {
        let Some(from) = self.stall_from else { return Ok(0) };
        let millis = 256 * u64::from(from.millisteps());
        let ticks = (1_000 * CLOCK * u64::from(self.microsteps)).checked_div(millis).unwrap_or(0);
        if (1..=LONGEST).contains(&ticks) {
            Ok(ticks as u32)
        } else {
            let rate = CLOCK * u64::from(self.microsteps) / 256;
            let (min, max) = (rate / LONGEST + 1, rate);
            Err(OutOfRange { what: "speed of stalls", min, max, unit: "steps/s" })
        }
    }
}

impl<U: Read + Write, D: DelayNs> Tmc2209<U, D> {
    /// Sets the driver up: StealthChop, which StallGuard requires; the current from these settings
    /// and not from the pin VREF. Clears the faults that the driver remembers.
    ///
    /// # Errors
    /// [`DriverError`]. A range error is returned before anything is written. After any other, the
    /// registers not reached yet keep their settings, and the driver counts as not set up.
    pub async fn set_up(&mut self, setup: &DriverSetup) -> Result<(), DriverError<U::Error>> {
        let scale = Scale::reaching(setup.run, setup.sense_milliohms);
        let mut currents = reg::IHOLD_IRUN::default();
        currents.set_irun(scale.steps(setup.run)?);
        currents.set_ihold(setup.hold_steps(scale)?);
        currents.set_ihold_delay(8);
        let (resolution, stall_ticks) = (setup.resolution()?, setup.stall_ticks()?);

        let version = self.read::<reg::IOIN>().await?.version();
        if version != VERSION {
            return Err(DriverError::OtherChip(version));
        }
        self.scale = None;
        self.forget_faults().await?;
        let mut answers = reg::SLAVECONF::default();
        // Three times 8 bits after the request. With less, other drivers on the wire may take the
        // answer for a fault of the line.
        answers.set_send_delay(2);
        self.write(answers).await?;
        let mut general = reg::GCONF::default();
        general.set_i_scale_analog(false);
        general.set_en_spread_cycle(false);
        general.set_pdn_disable(true);
        general.set_mstep_reg_select(true);
        general.set_multistep_filt(true);
        self.write(general).await?;
        let mut chopper = reg::CHOPCONF::default();
        chopper.set_vsense(scale.sensitive);
        chopper.set_mres(resolution);
        chopper.set_tbl(2);
        // The motor current never exceeds the larger of the old and the new one, whatever was set
        // before: the high sensitivity lowers any current, and the low one must find the right CS.
        if scale.sensitive {
            self.write(chopper).await?;
            self.write(currents).await?;
        } else {
            self.write(currents).await?;
            self.write(chopper).await?;
        }
        let mut seconds = reg::TPOWERDOWN::default();
        seconds.set(20);
        self.write(seconds).await?;
        self.write(reg::TPWMTHRS(0)).await?;
        self.write(reg::COOLCONF(0)).await?;
        self.write(reg::SGTHRS(setup.stall.into())).await?;
        self.write(reg::TCOOLTHRS(stall_ticks)).await?;
        // What was written before a reset is lost, and the counter of writes begins again.
        if self.read::<reg::GSTAT>().await?.reset() {
            return Err(DriverError::Reset);
        }
        (self.scale, self.currents) = (Some(scale), currents);
        Ok(())
    }

    /// Changes the motor current while moving, in mA, until
    /// [`restore_current`](Tmc2209::restore_current). The current at rest stays.
    ///
    /// # Errors
    /// [`DriverError::NotSetUp`]; [`DriverError::Range`] above the highest current at the
    /// sensitivity of the set-up; and those of [`write`](Tmc2209::write).
    pub async fn set_run_current(&mut self, milliamps: u16) -> Result<(), DriverError<U::Error>> {
        let scale = self.scale.ok_or(DriverError::NotSetUp)?;
        let mut currents = self.currents;
        currents.set_irun(scale.steps(milliamps)?);
        self.write(currents).await
    }

    /// Restores the current of the set-up.
    ///
    /// # Errors
    /// [`DriverError::NotSetUp`], and those of [`write`](Tmc2209::write).
    pub async fn restore_current(&mut self) -> Result<(), DriverError<U::Error>> {
        self.scale.ok_or(DriverError::NotSetUp)?;
        self.write(self.currents).await
    }

    /// The present faults, and those since the faults were last cleared.
    ///
    /// # Errors
    /// Those of [`read`](Tmc2209::read).
    pub async fn faults(&mut self) -> Result<DriverFaults, DriverError<U::Error>> {
        Ok(DriverFaults::of(self.read().await?, self.read().await?))
    }

    /// Clears past faults. A driver that was [reset](crate::DriverFault::Reset) must be set up
    /// again instead.
    ///
    /// # Errors
    /// Those of [`write`](Tmc2209::write).
    pub async fn forget_faults(&mut self) -> Result<(), DriverError<U::Error>> {
        // Writing a 1 clears a bit.
        self.write(reg::GSTAT(0b111)).await
    }

    /// How freely the motor turns, from 0 (a stall) to 510. A value up to twice the threshold
    /// counts as a stall.
    ///
    /// # Errors
    /// Those of [`read`](Tmc2209::read).
    pub async fn load(&mut self) -> Result<u16, DriverError<U::Error>> {
        Ok(self.read::<reg::SG_RESULT>().await?.get())
    }
}
