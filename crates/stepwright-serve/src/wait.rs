//! `?wait=true`: the answer comes when the order has ended, and tells how.
//!
//! ```text
//!   request ─► begun ─► … the axis moves … ─► rests: reached, stopped or uncertain ─► answer
//!                          │ the client hangs up
//!                          └─► the motion is what it is without waiting
//! ```
//!
//! A client that waits is present: a homing goes on, and nobody gets control without taking it over. Its
//! connection has a standing above pages that watch, and below other connections of the controlling client: so
//! a stop finds room, however many requests wait.

use std::sync::Arc;
use std::time::Instant;

use axum::Json;
use axum::extract::FromRequestParts;
use axum::http::request::Parts;

use crate::crowd::{Place, Standing};
use crate::desk::ServeDesk;
use stepwright_keeper::Declined;
use stepwright_keeper::Hand;
use stepwright_keeper::report::Done;
use stepwright_keeper::request::Wish;

/// Whether an answer waits for the end, from the address of its request.
#[derive(Debug)]
pub(crate) struct Wait {
    waits: bool,
    place: Option<Arc<Place>>,
}

impl<S: Sync> FromRequestParts<S> for Wait {
    type Rejection = Declined;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Wait, Declined> {
        let waits = asked(parts.uri.query().unwrap_or_default())?;
        Ok(Wait { waits, place: parts.extensions.get().cloned() })
    }
}

fn asked(query: &str) -> Result<bool, Declined> {
    let mut waits = false;
    for pair in query.split('&').filter(|pair| !pair.is_empty()) {
        waits = match pair.split_once('=') {
            // The guard has read the token.
            Some(("token", _)) => waits,
            Some(("wait", "true")) => true,
            Some(("wait", "false")) => false,
            Some(("wait", said)) => {
                return Err(Declined::range(format!("wait is '{said}'")).allowed("true, false"));
            }
            _ => {
                return Err(Declined::range(format!("'{pair}' is nothing that can be asked"))
                    .allowed("wait=true"));
            }
        };
    }
    Ok(waits)
}

impl Wait {
    /// Gives the board's thread a wish of this hand. The answer comes when the order has begun, or when it has
    /// ended.
    pub async fn wish(
        self,
        desk: &ServeDesk,
        hand: Hand,
        wish: Wish,
    ) -> Result<Json<Done>, Declined> {
        let _here = self.waits.then(|| Here::begin(desk, hand, self.place.as_deref()));
        desk.wish(wish, self.waits).await.map(Json)
    }

    /// Refuses to wait for the end of an endless order.
    pub fn not(&self) -> Result<(), Declined> {
        match self.waits {
            false => Ok(()),
            true => Err(Declined::range("a run has no end that could be waited for")
                .allowed("wait=true of a move, a line and a homing")),
        }
    }
}

/// A hand that waits for an answer, until this is dropped, also when its client hangs up.
struct Here<'a> {
    desk: &'a ServeDesk,
    hand: Hand,
}

impl<'a> Here<'a> {
    fn begin(desk: &'a ServeDesk, hand: Hand, place: Option<&Place>) -> Here<'a> {
        if let Some(place) = place {
            place.stand(Standing::Waiting);
        }
        desk.control(|control, _| control.wait(hand));
        Here { desk, hand }
    }
}

impl Drop for Here<'_> {
    fn drop(&mut self) {
        self.desk.control(|control, now: Instant| control.wait_no_longer(self.hand, now));
    }
}

#[cfg(test)]
mod tests {
    use super::asked;

    #[test]
    fn an_address_says_whether_to_wait() {
        for (query, right) in [
            ("", Some(false)),
            ("wait=true", Some(true)),
            ("wait=false", Some(false)),
            ("token=x&wait=true", Some(true)),
            ("wait=true&token=x", Some(true)),
            ("wait", None),
            ("wait=", None),
            ("wait=1", None),
            ("wait=True", None),
            ("waits=true", None),
        ] {
            assert_eq!(asked(query).ok(), right, "{query}");
        }
    }
}
