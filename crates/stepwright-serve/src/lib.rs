//! A board in a browser: a page and an API, and the checks between them and the motors.
//!
//! ```text
//!   browser ─► crowd ─► guard ─► api ─► Wish ─► ServeDesk ─► the board's thread
//!     (Host, Origin,  (JSON,                    (the `stepwright` command:
//!      token, size)    ranges, control)          lines, ramps, safety)
//!   browser ◄─ live ◄───────────────── ServeDesk ◄─ LiveState, Exchange, PlannedCurve
//! ```
//!
//! This crate knows HTTP, JSON and the rights of clients; it opens no port and says no line. Its user takes
//! [`Job`](stepwright_keeper::Job)s from a [`ServeDesk`] on a thread of its own, and reports the board's state
//! to the desk. If the board vanishes, its requests are still answered. If a page vanishes, no motor runs on: a
//! page that runs a motor endlessly must be heard from.
//!
//! | module | what |
//! | --- | --- |
//! | [`guard`] | who may send requests at all |
//! | [`control`] | who moves the motors, and sends beats |
//! | [`calc`] | the calculators |
//! | [`scope`] | the pins of the last seconds |
//! | [`path`] | lines and arcs of a file |
//! | [`desk`] | the link between the server and the board's thread |
//! | `wait` | answers that wait for the end of an order |
//! | `crowd` | connections, and which is closed if there are too many |

mod api;
pub mod calc;
pub mod control;
mod crowd;
pub mod desk;
pub mod guard;
mod live;
mod page;
pub mod path;
pub mod scope;
mod secret;
#[cfg(test)]
mod tests;
mod wait;

use std::io;
use std::net::TcpListener;
use std::sync::Arc;

use axum::extract::DefaultBodyLimit;
use axum::http::header::{
    CACHE_CONTROL, CONTENT_SECURITY_POLICY, HeaderValue, REFERRER_POLICY, X_CONTENT_TYPE_OPTIONS,
};
use axum::response::Response;
use axum::{Router, middleware};

pub use desk::{DeskEnd, ServeDesk};
pub use guard::Guard;
pub use secret::Token;

use stepwright_keeper::Declined;
use stepwright_keeper::decline::BODY;

/// All addresses of the server.
pub(crate) fn router(desk: Arc<ServeDesk>, guard: Guard) -> Router {
    let guard = Arc::new(guard);
    api::routes()
        .merge(page::routes())
        .fallback(async || Declined::nowhere("there is nothing at this address"))
        .layer(DefaultBodyLimit::max(BODY))
        .layer(middleware::from_fn_with_state(desk.clone(), api::known))
        .layer(middleware::from_fn_with_state(guard, guard::judge))
        .layer(middleware::map_response(with_headers))
        .with_state(desk)
}

/// Adds headers to every answer: the page loads nothing from elsewhere, and no other page shows it in a frame.
async fn with_headers(mut response: Response) -> Response {
    let headers = response.headers_mut();
    let policy = "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self'; \
                  img-src 'self' data:; connect-src 'self'; base-uri 'none'; \
                  form-action 'none'; frame-ancestors 'none'";
    headers.insert(CONTENT_SECURITY_POLICY, HeaderValue::from_static(policy));
    headers.insert(X_CONTENT_TYPE_OPTIONS, HeaderValue::from_static("nosniff"));
    headers.insert(REFERRER_POLICY, HeaderValue::from_static("no-referrer"));
    headers.insert(CACHE_CONTROL, HeaderValue::from_static("no-cache"));
    response
}

/// Serves on this listener until the board's thread [ends](ServeDesk::end).
///
/// # Errors
/// The listener can't be used.
pub fn serve(listener: TcpListener, desk: Arc<ServeDesk>, guard: Guard) -> io::Result<()> {
    listener.set_nonblocking(true)?;
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    let served = runtime.block_on(async {
        let listener = tokio::net::TcpListener::from_std(listener)?;
        let app = router(desk.clone(), guard);
        tokio::select! {
            served = crowd::serve(listener, app) => served,
            () = desk.until_ended() => Ok(()),
        }
    });
    // What is still drawn is wanted no more.
    runtime.shutdown_background();
    served
}
