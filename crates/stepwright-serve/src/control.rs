//! Who moves the motors: one at a time, who is heard of again and again.
//!
//! ```text
//!   take ──► Grant { hand, key } ──► beat, beat, beat … ──► release
//!                                      │ silence of LEASE
//!                                      ▼
//!                    a run without end is braked; others may take control
//! ```
//!
//! The key is the right to give orders. A hand that has fallen silent keeps it until another
//! one takes control, so a program may order a travel, wait, and order the next one. While a
//! request of its waits for the end of an order, a hand is there, also without a beat: nobody takes
//! control without taking it over. A run needs the beats all the same, because a program that hangs
//! can keep a request open.

use std::time::{Duration, Instant};

use subtle::ConstantTimeEq;

use crate::secret;
use stepwright_keeper::{Declined, Hand};

/// A hand counts as lost after this much silence.
pub const LEASE: Duration = Duration::from_millis(1000);

/// A name has this many characters at most.
const LONGEST: usize = 40;

/// Control, as it is given.
#[derive(Clone, Debug)]
pub struct Grant {
    /// Whose it is.
    pub hand: Hand,
    /// What orders are to carry.
    pub key: String,
}

/// Who controls.
#[derive(Clone, Debug)]
struct Holder {
    hand: Hand,
    key: String,
    name: String,
    heard: Instant,
    /// Its requests that wait for the end of an order.
    waits: usize,
}

/// Who controls the board, if anyone.
#[derive(Debug, Default)]
pub struct ControlLease {
    holder: Option<Holder>,
    given: u64,
}

impl ControlLease {
    /// Gives control to a new hand. One who is heard of keeps it, unless it is taken over.
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

    /// The hand whose key this is, which is heard of with it.
    ///
    /// # Errors
    /// It is the key of none who controls.
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
    /// It is the key of none who controls.
    pub fn release(&mut self, key: Option<&str>, now: Instant) -> Result<(), Declined> {
        self.hear(key, now)?;
        self.holder = None;
        Ok(())
    }

    /// Whether this is the key of who controls; it is not heard of with it.
    pub fn is_key(&self, key: &str) -> bool {
        self.holder.as_ref().is_some_and(|holder| holder.has(key))
    }

    /// Whether this hand has control and was heard of a moment ago.
    pub fn is_live(&self, hand: Hand, now: Instant) -> bool {
        self.holder.as_ref().is_some_and(|holder| holder.hand == hand && holder.is_live(now))
    }

    /// Whether this hand has control, and was heard of a moment ago or waits for an answer.
    pub fn is_there(&self, hand: Hand, now: Instant) -> bool {
        self.holder.as_ref().is_some_and(|holder| holder.hand == hand && holder.is_there(now))
    }

    /// The hand that has control, its name, and whether it is there.
    pub fn holder(&self, now: Instant) -> Option<(Hand, &str, bool)> {
        self.holder.as_ref().map(|holder| (holder.hand, holder.name.as_str(), holder.is_there(now)))
    }

    /// A request of this hand begins to wait for the end of an order.
    pub fn wait(&mut self, hand: Hand) {
        if let Some(holder) = self.holder.as_mut().filter(|holder| holder.hand == hand) {
            holder.waits += 1;
        }
    }

    /// A request of this hand waits no longer; the hand was there until now.
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
        // Silent, and nobody has taken control: its key is good still.
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
        // The end of an answer to one who has lost control says nothing of the next one.
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
