//! Converts the options to an order for the driver.

use stepwright::Speed;
use stepwright_play::timed::TimedOrder;
use stepwright_sim::timed::published;
use stepwright_timed::fit::Hardware;
use stepwright_timed::{Control, SetSpeed};

use crate::calc::misfit;
use crate::failure::Failure;
use crate::quantity::{GeometryArgs, SpeedArg, whole_in};

/// What is asked of the driver.
#[derive(clap::Args)]
#[command(group(clap::ArgGroup::new("change").args(["faster", "slower"])))]
pub struct OrderArgs {
    /// Virtual top at the start: the clocks between two steps; 0 stops the motor
    #[arg(long, value_name = "CLOCKS", conflicts_with_all = ["speed", "case"])]
    top: Option<u32>,
    /// Speed at the start: 250, 75rpm … (a bare number is steps/s); 0 stops the motor
    #[arg(long, value_name = "SPEED", allow_hyphen_values = true, conflicts_with = "case")]
    speed: Option<SpeedArg>,
    /// A validation case of the Arduino driver, 1 to 3, in place of --speed and the other options of
    /// the order
    #[arg(long, value_name = "N", value_parser = whole_in::<u8>(1..=3))]
    #[arg(conflicts_with_all = ["steps", "millis", "faster", "slower", "double"])]
    case: Option<u8>,
    /// Stop after this many steps
    #[arg(long, value_name = "N", conflicts_with = "millis")]
    #[arg(value_parser = whole_in::<u32>(1..=u32::MAX))]
    steps: Option<u32>,
    /// Stop after this many milliseconds
    #[arg(long, value_name = "MS", value_parser = whole_in::<u32>(1..=u32::MAX))]
    millis: Option<u32>,
    /// Take this many clocks from the virtual top with each update
    #[arg(long, value_name = "CLOCKS", conflicts_with = "slower", requires = "updates")]
    faster: Option<u32>,
    /// Add this many clocks to it
    #[arg(long, value_name = "CLOCKS", requires = "updates")]
    slower: Option<u32>,
    /// Halve (faster) or double (slower) these clocks with each update
    #[arg(long, requires = "change")]
    double: bool,
    /// Milliseconds from update to update
    #[arg(long, value_name = "MS", default_value_t = 1000, conflicts_with = "case")]
    #[arg(value_parser = whole_in::<u16>(1..=u16::MAX))]
    every_ms: u16,
    /// Greatest number of updates
    #[arg(long, value_name = "N", conflicts_with = "case", requires = "change")]
    updates: Option<u16>,
    /// Have the main program check for updates at this interval in ms, instead of the step
    /// interrupt; then it is called back
    #[arg(long, value_name = "MS", value_parser = whole_in::<u32>(1..=60_000))]
    poll_ms: Option<u32>,
    /// Play the motor's pattern backwards
    #[arg(long, conflicts_with = "case")]
    reverse: bool,
    #[command(flatten)]
    geometry: GeometryArgs,
}

impl OrderArgs {
    /// The order for the core.
    pub fn order(&self, hardware: &Hardware) -> Result<TimedOrder, Failure> {
        let geometry = self.geometry.geometry()?;
        let steps_per_turn = geometry.steps_per_turn();
        if let Some(case) = self.case {
            let (published, poll_ms) = match case {
                1 => (published::CASE_1, self.poll_ms),
                2 => (published::CASE_2, self.poll_ms),
                _ => (published::CASE_3, self.poll_ms.or(Some(published::POLL_MS))),
            };
            let mut set_speed = published.order;
            if poll_ms.is_some() && case != 3 {
                let bits = set_speed.control.bits() & !Control::IRQ_TIMING.bits();
                set_speed.control = Control::from_bits(bits);
            }
            return Ok(TimedOrder { set_speed, poll_ms, case: Some(case), steps_per_turn });
        }
        let stop =
            TimedOrder { set_speed: SetSpeed::STOP, poll_ms: None, case: None, steps_per_turn };
        let top = match (&self.speed, self.top) {
            (None, Some(0)) => return Ok(stop),
            (Some(speed), _) => {
                let held = speed.resolve(&geometry, "--speed")?;
                if held.value == Speed::default() {
                    return Ok(stop);
                }
                let top = hardware.virtual_top_of_speed(held.value);
                top.map_err(|error| misfit(&format!("--speed {held}"), error))?
            }
            (None, Some(top)) => {
                hardware.check(top).map_err(|error| misfit(&format!("--top {top}"), error))?
            }
            (None, None) => {
                return Err(Failure::usage("no speed: give --speed, --top or --case").hint(
                    "`stepwright timed --speed 250 --steps 1000` makes 1000 steps at 250 steps/s; \
                     `stepwright timed --help` has more examples",
                ));
            }
        };
        let mut control = Control::DRV_EN;
        let mut set = |bit, on| {
            if on {
                control = control | bit;
            }
        };
        set(Control::DIRECTION, self.reverse);
        set(Control::ENDPOINT_MILLIS, self.millis.is_some());
        set(Control::IRQ_TIMING, self.poll_ms.is_none());
        set(Control::SPEED_VARIABLE, self.faster.or(self.slower).is_some());
        set(Control::FASTER, self.faster.is_some());
        set(Control::VARIABLE_PWR, self.double);
        let set_speed = SetSpeed {
            control,
            top,
            limit: self.steps.or(self.millis).unwrap_or(0),
            modification: self.faster.or(self.slower).unwrap_or(0),
            update_ms: self.every_ms,
            mod_counts: self.updates.unwrap_or(0),
        };
        Ok(TimedOrder { set_speed, poll_ms: self.poll_ms, case: None, steps_per_turn })
    }
}
