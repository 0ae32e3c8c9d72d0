//! The answer to a request that is not carried out.

use std::time::Duration;

use serde::Serialize;

/// The most bytes of a request's body.
pub const BODY: usize = 4096;

/// A request that was not carried out, with the reason and the remedy.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
pub struct Declined {
    /// The HTTP status.
    #[serde(skip)]
    status: u16,
    /// What was wrong.
    pub what: String,
    /// What is allowed instead.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub allowed: Option<String>,
    /// What the user can do.
    #[serde(rename = "do", skip_serializing_if = "Option::is_none")]
    pub remedy: Option<String>,
}

impl Declined {
    fn of(status: u16, what: impl Into<String>) -> Declined {
        Declined { status, what: what.into(), allowed: None, remedy: None }
    }

    /// The body is not valid JSON: 400.
    pub fn malformed(what: impl Into<String>) -> Declined {
        Declined::of(400, what)
    }

    /// The token is missing or wrong: 401.
    pub fn unknown(what: impl Into<String>) -> Declined {
        Declined::of(401, what)
    }

    /// The request comes from another page: 403.
    pub fn foreign(what: impl Into<String>) -> Declined {
        Declined::of(403, what)
    }

    /// There is nothing at this address: 404.
    pub fn nowhere(what: impl Into<String>) -> Declined {
        Declined::of(404, what)
    }

    /// The address takes another method: 405.
    pub fn otherwise(what: impl Into<String>) -> Declined {
        Declined::of(405, what)
    }

    /// The body took longer than this to arrive: 408.
    pub fn slow(limit: Duration) -> Declined {
        Declined::of(408, "the body of the request did not come")
            .allowed(format!("at most {} s", limit.as_secs()))
            .remedy("does Content-Length say how long it is?")
    }

    /// The board can't do this, or not now: 409.
    pub fn refused(what: impl Into<String>) -> Declined {
        Declined::of(409, what)
    }

    /// A value is outside its range: 422.
    pub fn range(what: impl Into<String>) -> Declined {
        Declined::of(422, what)
    }

    /// The board can't be reached: 503.
    pub fn away(what: impl Into<String>) -> Declined {
        Declined::of(503, what)
    }

    /// Adds what is allowed.
    pub fn allowed(self, allowed: impl Into<String>) -> Declined {
        Declined { allowed: Some(allowed.into()), ..self }
    }

    /// Adds what the user can do.
    pub fn remedy(self, remedy: impl Into<String>) -> Declined {
        Declined { remedy: Some(remedy.into()), ..self }
    }

    /// The HTTP status: 400 to 503.
    pub fn status(&self) -> u16 {
        self.status
    }
}

#[cfg(feature = "http")]
mod http {
    use axum::Json;
    use axum::extract::rejection::JsonRejection;
    use axum::http::StatusCode;
    use axum::response::{IntoResponse, Response};

    use super::{BODY, Declined};

    impl IntoResponse for Declined {
        fn into_response(self) -> Response {
            let status = StatusCode::from_u16(self.status).unwrap_or(StatusCode::BAD_REQUEST);
            (status, Json(self)).into_response()
        }
    }

    /// A body that is not the expected JSON.
    impl From<JsonRejection> for Declined {
        fn from(rejection: JsonRejection) -> Declined {
            let declined = Declined::of(rejection.status().as_u16(), plain(&rejection.body_text()));
            match rejection.status() {
                StatusCode::PAYLOAD_TOO_LARGE => declined.allowed(format!("at most {BODY} bytes")),
                StatusCode::UNSUPPORTED_MEDIA_TYPE => {
                    declined.remedy("send JSON, with the header `Content-Type: application/json`")
                }
                _ => declined.remedy("GET /api/openapi.json describes the fields of every request"),
            }
        }
    }

    /// The message of serde or axum, without the names of Rust types.
    fn plain(said: &str) -> String {
        const WORDS: [(&str, &str); 9] = [
            ("Failed to deserialize the JSON body into the target type: ", ""),
            ("Failed to parse the request body as JSON: ", "no JSON: "),
            ("Failed to buffer the request body: length limit exceeded", "the body is too long"),
            // Only axes are of type u8.
            (" expected u8 ", " expected the number of an axis "),
            (" expected i64 ", " expected a whole number "),
            (" expected f64 ", " expected a number "),
            ("invalid type: sequence", "invalid type: a list"),
            (" expected a sequence ", " expected a list "),
            ("invalid type: map", "invalid type: an object"),
        ];
        // A client's own text is quoted in the message and may contain such words too, so each is replaced
        // once.
        WORDS.iter().fold(said.to_owned(), |said, (from, to)| said.replacen(from, to, 1))
    }
}
