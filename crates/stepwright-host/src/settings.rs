//! Settings of a board that affect an order: a law without S-curves, and settings that may cause a refusal.

use stepwright_protocol::{Ability, Command, Listed, Order, Refusal, Reply, Setting};

use crate::conversation::{Conversation, LinkError};

/// Why a board would not keep a jerk limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoCurves {
    /// The board has no S-curves.
    Board,
    /// Its setting `law` is 0: the board would ignore the limit.
    Law,
}

/// The settings of a board that differ from their defaults.
#[derive(Clone, Debug, Default)]
pub struct ChangedSettings(Option<Listed>);

impl ChangedSettings {
    /// Those of `settings` that were changed, as `soft-limits=1 ahead-x=100`; `None` if none was.
    pub fn words(&self, settings: &[Setting]) -> Option<String> {
        let values = self.0.as_ref()?.values();
        let changed = values.filter(|value| {
            settings.contains(&value.setting()) && value.number() != value.setting().default()
        });
        let words: Vec<_> =
            changed.map(|value| format!("{}={}", value.setting().name(), value.number())).collect();
        (!words.is_empty()).then(|| words.join(" "))
    }
}

/// The steepest ramps that an Uno or a Mega can plan, to explain [`Refusal::TooSteep`]. Measured (`steepest` in
/// docs/benchmarks.md, and the stories of docs/reliability.md).
pub const STEEPEST: &str = "one axis takes ramps of up to some 500,000 steps/s², two at once \
                            120,000, three 40,000, and less beside a fast one; with a limit of \
                            jerk 16,000, 3,900 and 1,200, and a jerk of some 100,000 steps/s³ for \
                            two, 20,000 for three";

/// The steepest ramps of two and of three axes, in steps/s², as [`STEEPEST`] says them: without and with a limit
/// of jerk.
pub const STEEPEST_TOGETHER: [[u32; 2]; 2] = [[120_000, 40_000], [3_900, 1_200]];

/// The settings that may cause a refusal.
pub const fn behind(why: Refusal) -> &'static [Setting] {
    match why {
        Refusal::TooFast => &[Setting::MaxSpeed],
        Refusal::Ramp => &[Setting::MaxAccel],
        Refusal::NoJerk => &[Setting::Law],
        Refusal::Limit => &[
            Setting::SoftLimits,
            Setting::AheadX,
            Setting::AheadY,
            Setting::AheadZ,
            Setting::BehindX,
            Setting::BehindY,
            Setting::BehindZ,
        ],
        Refusal::Stopped => &[Setting::SafeStart],
        Refusal::Uncertain => &[Setting::HomeFirst],
        Refusal::Fault => &[Setting::Switches, Setting::Emergency, Setting::DriverFault],
        _ => &[],
    }
}

impl Conversation {
    /// Asks for the settings that differ from their defaults; none for a board without settings.
    ///
    /// # Errors
    /// The line is gone.
    pub async fn changed_settings(&mut self) -> Result<ChangedSettings, LinkError> {
        Ok(ChangedSettings(match self.once(Command::Settings).await? {
            Some(Reply::Settings(settings)) => Some(settings),
            _ => None,
        }))
    }

    /// Why the board would not keep the jerk limit of this order; `None` if it would, or if the order has no
    /// limit.
    ///
    /// # Errors
    /// The board is silent, or its line is gone.
    pub async fn no_curves(&mut self, order: &Order) -> Result<Option<NoCurves>, LinkError> {
        if order.jerk.is_none() {
            return Ok(None);
        }
        let can = match self.info() {
            None => Some(false),
            // A board that does not list its features is asked for the law: it refuses an order that it can't
            // do.
            Some(info) => info.can.map(|can| can.has(Ability::Jerk)),
        };
        if can == Some(false) {
            return Ok(Some(NoCurves::Board));
        }
        // A board without settings answers E, and keeps the limit.
        Ok(match self.ask(Command::Setting(Setting::Law)).await? {
            Reply::Setting(value) if value.setting() == Setting::Law && value.number() == 0 => {
                Some(NoCurves::Law)
            }
            _ => None,
        })
    }
}
