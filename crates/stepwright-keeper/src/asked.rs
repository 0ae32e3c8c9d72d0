//! Requests by their address: those of `stepwright serve` over HTTP, for front ends without HTTP.

use crate::request::home::HomeRequest;
use crate::request::line::LineRequest;
use crate::request::{
    EmptyRequest, MoveRequest, RetargetRequest, RunRequest, SetRequest, StopRequest, ZeroRequest,
};
use crate::{Declined, Hand, Wish};
use serde::de::DeserializeOwned;

/// The wish of `POST /api/NAME` by this hand, and whether the answer waits for the end of the order:
/// `?wait=true`.
///
/// # Errors
/// There is no such address, or the body is invalid.
pub fn wish(name: &str, body: &str, hand: Hand) -> Result<(Wish, bool), Declined> {
    let (name, waits) = match name.strip_suffix("?wait=true") {
        Some(name) => (name, true),
        None => (name, false),
    };
    let wish = match name {
        "move" => read::<MoveRequest>(body)?.wish(),
        "line" => read::<LineRequest>(body)?.wish(),
        "run" => read::<RunRequest>(body)?.wish(hand),
        "home" => read::<HomeRequest>(body)?.wish(hand),
        "retarget" => read::<RetargetRequest>(body)?.wish(),
        "stop" => read::<StopRequest>(body)?.wish(),
        "kill" => read::<EmptyRequest>(body).map(|_| Wish::Kill),
        "zero" => read::<ZeroRequest>(body)?.wish(),
        "set" => read::<SetRequest>(body)?.wish(),
        "acknowledge" => read::<EmptyRequest>(body).map(|_| Wish::Acknowledge),
        _ => Err(Declined::nowhere(format!("there is no {name} here"))
            .remedy("`stepwright serve` has all that GET /api/openapi.json lists")),
    }?;
    Ok((wish, waits))
}

fn read<T: DeserializeOwned>(body: &str) -> Result<T, Declined> {
    serde_json::from_str(body).map_err(|error| Declined::malformed(error.to_string()))
}

#[cfg(test)]
mod tests {
    use stepwright_protocol::Selection;

    use super::*;

    fn wish(name: &str, body: &str) -> Result<(Wish, bool), Declined> {
        super::wish(name, body, Hand(1))
    }

    #[test]
    fn a_request_is_a_wish() {
        assert!(matches!(wish("stop", "{}"), Ok((Wish::Stop(Selection::All), false))));
        let moved = wish("move?wait=true", r#"{"axis":2,"to":-400}"#);
        assert!(matches!(moved, Ok((Wish::Travel(axis, ..), true)) if axis.number() == 2));
        for (name, body, status) in [
            ("jump", "{}", 404),
            ("move", "{", 400),
            ("move", r#"{"axis":1,"by":1,"speed":9}"#, 400),
            ("move", r#"{"axis":1,"by":1,"top_speed":0}"#, 422),
            ("move?wait=yes", r#"{"axis":1,"by":1}"#, 404),
        ] {
            assert_eq!(wish(name, body).unwrap_err().status(), status, "{name} {body}");
        }
    }
}
