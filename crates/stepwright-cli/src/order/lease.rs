//! `--lease`: the board brakes by itself when this program falls silent.

use stepwright_protocol::{Ability, Command, LeaseMillis};

use crate::failure::Failure;
use stepwright_host::Session;

/// The option that asks for a lease.
#[derive(clap::Args, Clone, Debug)]
#[command(next_help_heading = "Board")]
pub struct LeaseArgs {
    /// Have the board brake if it receives nothing from this command for this time: 500ms,
    /// 2s; from 200ms to 60s [default: never]
    #[arg(long = "lease", value_name = "TIME", value_parser = stepwright_machine::lease)]
    lease: Option<LeaseMillis>,
}

/// The lease of a jog, whose keys are polled every 20 ms.
const HANDS: LeaseMillis = LeaseMillis::clamped(500);

/// Whether a board grants leases.
fn grants(session: &Session) -> bool {
    session.info().and_then(|info| info.can).is_some_and(|can| can.has(Ability::Safety))
}

impl LeaseArgs {
    /// Whether a lease was requested: then the motor must be watched.
    pub fn is_asked(&self) -> bool {
        self.lease.is_some()
    }

    /// The lease of a jog: the requested one, or [`HANDS`]. `None` if none was requested and the
    /// board grants none.
    pub fn or_hands(&self, session: &Session) -> Result<Option<LeaseMillis>, Failure> {
        let mut lines = Vec::new();
        if self.is_asked() {
            self.before(session, &mut lines)?;
            return Ok(self.lease);
        }
        Ok(grants(session).then_some(HANDS))
    }

    /// Puts the lease before the lines of an order, so that every attempt to send the order renews
    /// the lease.
    pub fn before(&self, session: &Session, lines: &mut Vec<Command>) -> Result<(), Failure> {
        let Some(lease) = self.lease else { return Ok(()) };
        if !grants(session) {
            let name = session.name();
            return Err(Failure::new(format!("{name} grants no lease, which --lease asks for"))
                .hint(format!(
                    "leave --lease out, or have it brake by its settings: `stepwright settings \
                     set timeout-ms={} --port {name}`",
                    lease.get()
                )));
        }
        lines.insert(0, Command::Lease(lease));
        Ok(())
    }

    /// Returns the lease at the end, if there was one.
    pub fn give_back(&self, session: &mut Session) {
        if self.is_asked() {
            give_back(session);
        }
    }
}

/// Returns a lease. If that fails, the lease expires by itself.
pub fn give_back(session: &mut Session) {
    let _ = session.ask(Command::Lease(LeaseMillis::SMALLEST));
}

#[cfg(test)]
mod tests {
    use stepwright_machine::lease as millis;

    #[test]
    fn a_lease_lasts_longer_than_a_few_polls_and_at_most_a_minute() {
        for (text, ms) in [("500ms", 500), ("0.2", 200), ("1min", 60_000)] {
            assert_eq!(millis(text).map(|lease| lease.get()), Ok(ms), "{text}");
        }
        for wrong in ["", "0", "199ms", "60.001s", "5x", "99999999999999min"] {
            assert!(millis(wrong).is_err(), "{wrong}");
        }
    }
}
