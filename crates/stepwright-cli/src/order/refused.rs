//! Why a board refused an order: its reason, and the setting, switch or missing feature
//! behind it.

use std::fmt::Display;

use stepwright::Speed;
use stepwright_protocol::{Order, Refusal, Setting, Stop};

use super::motion::{longest_wait, seconds};
use crate::failure::Failure;
use stepwright_host::Session;
use stepwright_host::settings::{ChangedSettings, STEEPEST, behind};

/// The failure of an order whose line was refused for this reason.
pub fn by(session: &mut Session, line: &dyn Display, why: Refusal) -> Failure {
    let name = session.name();
    let failure = Failure::new(format!("{name} refused {line}: {why}"));
    match hint(session, &name, why) {
        Some(hint) => failure.hint(hint),
        None => failure,
    }
}

/// The failure of an order whose steps are further apart than the board can wait.
pub fn as_slow(name: &str, order: &Order) -> Failure {
    let (wait, top) = (seconds(longest_wait(order)), order.top);
    let what = format!("{name} refuses it as slower than the board can wait: {wait}");
    let most = "a board waits for 2^32 ticks of its timer at most, 268 s on an Uno or a Mega, 34 s on a \
                Pico: raise the top speed";
    if order.start == Speed::ZERO {
        let what =
            format!("{what} for the first step and the last from rest, and one at {top} steps/s");
        Failure::new(what).hint(format!(
            "{most} or --accel, or leave the ramp out by a --start-speed of a step/s or more"
        ))
    } else {
        Failure::new(format!("{what} between two steps at {top} steps/s"))
            .hint(format!("{most} to 0.004 steps/s or more, on a Pico to 0.03"))
    }
}

/// The cause of the refusal, and what to do about it.
fn hint(session: &mut Session, name: &str, why: Refusal) -> Option<String> {
    let set = session.changed_settings().unwrap_or_default();
    let port = if name.starts_with("the ") { String::new() } else { format!(" --port {name}") };
    let change = |what: &str| format!("`stepwright settings set {what}{port}`");
    Some(match why {
        Refusal::TooSteep => STEEPEST.into(),
        Refusal::TooFast => match set.words(behind(why)) {
            Some(words) => format!(
                "the setting {words} refuses more: lower the speed, or {}",
                change("max-speed=N")
            ),
            None => {
                let max = session.info().map_or(0, |info| info.max);
                let slow = set.words(&[Setting::Pulse]);
                let slow = slow.map(|words| format!("; the setting {words} makes it slower"));
                let slow = slow.unwrap_or_default();
                format!(
                    "one axis alone makes at most {max} steps/s here, several together less{slow}"
                )
            }
        },
        Refusal::Ramp => match set.words(behind(why)) {
            Some(words) => format!(
                "the setting {words} refuses steeper ramps: a lower --accel or a longer --ramp, \
                 or {}",
                change("max-accel=N")
            ),
            None => "give another --ramp or --accel".to_owned(),
        },
        Refusal::TooSlow => {
            "a ramp from rest begins slower than its top speed; a --start-speed of \
                             a step/s or more, not below the top speed, leaves the ramp out"
                .to_owned()
        }
        Refusal::TooGentle => {
            "give a steeper --accel and --decel, or a lower --top-speed".to_owned()
        }
        Refusal::NoJerk => match set.words(behind(why)) {
            Some(words) => {
                format!("the setting {words} refuses --jerk: leave it out, or {}", change("law=1"))
            }
            None => "the board has no S-curves: leave --jerk out".to_owned(),
        },
        Refusal::Limit => {
            let words = set.words(behind(why));
            let words = words.unwrap_or_else(|| "soft-limits".to_owned());
            format!("the range is that of the settings {words}: go less far, or {}", change("…"))
        }
        Refusal::Stopped => format!(
            "the setting safe-start=1 asks for a word after a stop: look what it was \
             (`stepwright status{port}`), then `stepwright send{port} '!'`"
        ),
        Refusal::Uncertain => {
            let words = set.words(behind(why));
            let words = words.map(|words| format!("the setting {words} asks for it: "));
            format!(
                "{}`stepwright home{port}`, or `stepwright zero{port}` where it stands",
                words.unwrap_or_default()
            )
        }
        Refusal::Fault => fault(session, &set, &port),
        Refusal::Busy => format!("`stepwright watch{port}` waits, `stepwright stop{port}` brakes"),
        _ => return None,
    })
}

/// The input that blocks the axis.
fn fault(session: &mut Session, set: &ChangedSettings, port: &str) -> String {
    let stops = session.ask_info().ok().flatten().and_then(|info| info.stops);
    let inputs = [
        (Setting::Switches, Stop::Switch, "a limit switch is closed; the way back from it is free"),
        (Setting::Emergency, Stop::Emergency, "the emergency stop is pressed"),
        (Setting::DriverFault, Stop::Driver, "a driver has a fault"),
    ];
    let known = inputs.iter().filter_map(|(setting, stop, words)| {
        let held = set.words(&[*setting])?;
        Some((held, stops.is_some_and(|stops| stops.letters().contains(&stop.letter())), *words))
    });
    let known: Vec<_> = known.collect();
    // The inputs that have stopped an axis, else all that are in use.
    let seen: Vec<_> = known.iter().filter(|(_, stopped, _)| *stopped).collect();
    let said = if seen.is_empty() { known.iter().collect() } else { seen };
    let said: Vec<_> = said.iter().map(|(held, _, words)| format!("{words} ({held})")).collect();
    let look = format!("`stepwright status{port}` says more");
    if said.is_empty() { look } else { format!("{}; {look}", said.join(", or ")) }
}
