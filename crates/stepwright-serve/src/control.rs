//! Control of the motors: one client at a time, which must send beats.
//!
//! ```text
//!   take ──► Grant { hand, key } ──► beat, beat, beat … ──► release
//!                                      │ silence of LEASE
//!                                      ▼
//!                    a run without end is braked; others may take control
//! ```
//!
//! The key is the right to give orders. A silent hand keeps control until another one takes it, so a program
//! may order a travel, wait, and order the next one. While a request of the hand waits for the end of an order,
//! the hand counts as present without beats: another client gets control only by taking it over. A run needs
//! the beats all the same, because a program that hangs may keep a request open.

use std::time::{Duration, Instant};

use subtle::ConstantTimeEq;

use crate::secret;
use stepwright_keeper::{Declined, Hand};

/// After this much silence a hand counts as lost.
pub const LEASE: Duration = Duration::from_millis(1000);

/// The most characters of a name.
const LONGEST: usize = 40;

/// Control that was given.
#[derive(Clone, Debug)]
pub struct Grant {
    /// The hand that has control.
    pub hand: Hand,
    /// The key for its orders.
    pub key: String,
}

/// The controlling client.
#[derive(Clone, Debug)]
struct Holder {
    hand: Hand,
    key: String,
    name: String,
    heard: Instant,
    /// The number of its requests that wait for the end of an order.
    waits: usize,
}

/// The control of the board.
#[derive(Debug, Default)]
pub struct ControlLease {
    holder: Option<Holder>,
    given: u64,
}

impl ControlLease {
    /// Gives control to a new hand. A hand that is present keeps control, unless it is taken over.
    ///
    /// # Errors
    /// Another hand has control; or the name is too long.
    pub fn take(&mut self, name: &str, over: bool, now: Instant) -> Result<Grant, Declined> {
        if name.chars().count() > LONGEST || name.chars().any(char::is_control) {
            return Err(Declined::range("the name is too long, or has control characters")
                .allowed(format!("at most {LONGEST} characters")));
        }
        if let Some(holder) = self.holder.as_ref().filter(|h| !over && h.is_there(now)) {
            return Err(Declined::refused(format!("{} controls the board", holder.name))
                .allowed("watching; stop and kill are for everybody")
                .remedy("ask again with \"take_over\": true; a run without end is braked then"));
        }
        self.given += 1;
        let (hand, key) = (Hand(self.given), secret::random());
        let name = if name.is_empty() { format!("page {}", self.given) } else { name.to_owned() };
        self.holder = Some(Holder { hand, key: key.clone(), name, heard: now, waits: 0 });
        Ok(Grant { hand, key })
    }

    /// The hand with this key, whose lease is renewed.
    ///
    /// # Errors
    /// No controlling hand has this key.
    pub fn hear(&mut self, key: Option<&str>, now: Instant) -> Result<Hand, Declined> {
        let Some(holder) = &mut self.holder else {
            return Err(Declined::refused("nobody controls the board").remedy(
                "POST /api/control, then send its key in the header `Stepwright-Control`",
            ));
        };
        if key.is_some_and(|key| holder.has(key)) {
            holder.heard = now;
            return Ok(holder.hand);
        }
        Err(Declined::refused(format!("{} controls the board", holder.name))
            .allowed("watching; stop and kill are for everybody")
            .remedy("POST /api/control, then send its key in the header `Stepwright-Control`"))
    }

    /// Gives control back.
    ///
    /// # Errors
    /// No controlling hand has this key.
    pub fn release(&mut self, key: Option<&str>, now: Instant) -> Result<(), Declined> {
        self.hear(key, now)?;
        self.holder = None;
        Ok(())
    }

    /// Whether this is the key of the controlling hand. Does not renew the lease.
    pub fn is_key(&self, key: &str) -> bool {
        self.holder.as_ref().is_some_and(|holder| holder.has(key))
    }

    /// Whether this hand has control, and was heard from within [`LEASE`].
    pub fn is_live(&self, hand: Hand, now: Instant) -> bool {
        self.holder.as_ref().is_some_and(|holder| holder.hand == hand && holder.is_live(now))
    }

    /// Whether this hand has control, and was heard from within [`LEASE`] or waits for an answer.
    pub fn is_there(&self, hand: Hand, now: Instant) -> bool {
        self.holder.as_ref().is_some_and(|holder| holder.hand == hand && holder.is_there(now))
    }

    /// The hand that has control, its name, and whether it is present.
    pub fn holder(&self, now: Instant) -> Option<(Hand, &str, bool)> {
        self.holder.as_ref().map(|holder| (holder.hand, holder.name.as_str(), holder.is_there(now)))
    }

    /// Notes that a request of this hand waits for the end of an order.
    pub fn wait(&mut self, hand: Hand) {
        if let Some(holder) = self.holder.as_mut().filter(|holder| holder.hand == hand) {
            holder.waits += 1;
        }
    }

    /// Notes that a request of this hand no longer waits. The hand was present until now.
    pub fn wait_no_longer(&mut self, hand: Hand, now: Instant) {
        if let Some(holder) = self.holder.as_mut().filter(|holder| holder.hand == hand) {
            holder.waits = holder.waits.saturating_sub(1);
            holder.heard = now;
        }
    }
}

impl Holder {
    fn has(&self, key: &str) -> bool {
        key.as_bytes().ct_eq(self.key.as_bytes()).into()
    }

    fn is_live(&self, now: Instant) -> bool {
        now.saturating_duration_since(self.heard) < LEASE
    }

    fn is_there(&self, now: Instant) -> bool {
        self.waits > 0 || self.is_live(now)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_controls_until_it_is_silent_or_another_takes_over() {
        let (mut control, begin) = (ControlLease::default(), Instant::now());
        let at = |ms| begin + Duration::from_millis(ms);
        assert!(control.hear(None, begin).is_err());
        let first = control.take("bench", false, begin).unwrap();
        assert!(control.take("phone", false, at(999)).is_err());
        assert_eq!(control.hear(Some(&first.key), at(999)), Ok(first.hand));
        assert!(control.take("phone", false, at(1998)).is_err());
        assert!(control.is_live(first.hand, at(1998)));
        assert!(!control.is_live(first.hand, at(1999)));
        // The hand was silent, and no other has taken control: its key is still valid.
        assert_eq!(control.hear(Some(&first.key), at(5000)), Ok(first.hand));
        let second = control.take("phone", true, at(5001)).unwrap();
        assert!(!control.is_live(first.hand, at(5001)));
        assert!(control.hear(Some(&first.key), at(5002)).is_err());
        assert!(control.release(Some(&first.key), at(5002)).is_err());
        assert_eq!(control.holder(at(5002)), Some((second.hand, "phone", true)));
        control.release(Some(&second.key), at(5003)).unwrap();
        assert!(control.holder(at(5003)).is_none());
    }

    #[test]
    fn a_silent_hand_loses_control_to_who_asks() {
        let (mut control, begin) = (ControlLease::default(), Instant::now());
        control.take("", false, begin).unwrap();
        assert!(control.take("", false, begin + LEASE).is_ok());
    }

    #[test]
    fn who_waits_for_an_answer_is_there_but_runs_nothing() {
        let (mut control, begin) = (ControlLease::default(), Instant::now());
        let at = |s| begin + Duration::from_secs(s);
        let first = control.take("script", false, begin).unwrap().hand;
        control.wait(first);
        assert!(control.is_there(first, at(60)) && !control.is_live(first, at(60)));
        assert!(control.take("page", false, at(60)).is_err());
        control.wait_no_longer(first, at(60));
        assert!(control.is_live(first, at(60)) && !control.is_there(first, at(61)));
        // The answer to a hand that has lost control does not renew the next hand's lease.
        control.wait(first);
        let second = control.take("page", true, at(62)).unwrap().hand;
        control.wait_no_longer(first, at(70));
        assert!(!control.is_there(first, at(62)) && !control.is_there(second, at(70)));
    }

    #[test]
    fn a_part_of_a_key_is_no_key() {
        let (mut control, now) = (ControlLease::default(), Instant::now());
        let grant = control.take("", false, now).unwrap();
        for wrong in ["", &grant.key[1..], &format!("{}0", grant.key)] {
            assert!(control.hear(Some(wrong), now).is_err(), "{wrong}");
        }
        assert!(control.take(&"n".repeat(41), true, now).is_err());
    }
}
