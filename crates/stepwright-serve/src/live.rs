//! `/api/live`: the board's state as it changes, and the beats of the controlling client. With `?control=KEY`
//! the controlling client is let in even if all seats are taken.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use axum::Extension;
use axum::body::Bytes;
use axum::extract::State;
use axum::extract::ws::rejection::WebSocketUpgradeRejection;
use axum::extract::ws::{Message, WebSocket, WebSocketUpgrade};
use axum::http::Uri;
use axum::response::Response;
use serde::Deserialize;
use tokio::sync::broadcast::error::RecvError;
use tokio::time::{Instant, interval, sleep_until, timeout};

use crate::crowd::{PATIENCE, Place, Standing};
use crate::desk::ServeDesk;
use crate::guard::in_query;
use stepwright_keeper::Declined;

/// The most pages at once.
const PAGES: usize = 32;

/// The time between two states for a page: more than it can draw.
const FRAME: Duration = Duration::from_millis(10);

/// The most bytes of a message from a page.
const LONGEST: usize = 512;

/// The number of open pages.
static HERE: AtomicUsize = AtomicUsize::new(0);

/// A message from a page.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "lowercase")]
enum Said {
    /// The client with this key is present.
    Beat(String),
    /// Whether the page wants questions as well as orders.
    Questions(bool),
}

/// A seat for a page, free again when it is dropped.
struct Seat;

impl Seat {
    /// One more seat is kept for the controlling client.
    fn take(controls: bool) -> Option<Seat> {
        let seats = PAGES + usize::from(controls);
        let more = |here| (here < seats).then_some(here + 1);
        HERE.fetch_update(Ordering::Relaxed, Ordering::Relaxed, more).ok().map(|_| Seat)
    }
}

impl Drop for Seat {
    fn drop(&mut self) {
        HERE.fetch_sub(1, Ordering::Relaxed);
    }
}

/// Adds a page.
pub(crate) async fn join(
    State(desk): State<Arc<ServeDesk>>,
    uri: Uri,
    place: Option<Extension<Arc<Place>>>,
    upgrade: Result<WebSocketUpgrade, WebSocketUpgradeRejection>,
) -> Result<Response, Declined> {
    let upgrade = upgrade.map_err(|rejection| {
        Declined::malformed(rejection.body_text()).remedy("open it as a WebSocket")
    })?;
    let key = in_query(&uri, "control");
    let controls = key.is_some_and(|key| desk.control(|control, _| control.is_key(key)));
    let seat = Seat::take(controls).ok_or_else(|| {
        Declined::away("too many pages are open").allowed(format!("at most {PAGES}"))
    })?;
    let upgrade = upgrade.max_message_size(LONGEST).max_frame_size(LONGEST);
    Ok(upgrade.on_upgrade(async move |socket| {
        let place = place.map(|Extension(place)| place).unwrap_or_default();
        place.stand(if controls { Standing::Controlling } else { Standing::Watching });
        let mut page = Page { desk, place: place.clone(), questions: false };
        tokio::select! {
            () = page.follow(socket) => {}
            () = place.wanted() => {}
        }
        drop(seat);
    }))
}

struct Page {
    desk: Arc<ServeDesk>,
    place: Arc<Place>,
    questions: bool,
}

impl Page {
    /// Sends and receives until the page is gone, or sends something invalid.
    async fn follow(&mut self, mut socket: WebSocket) {
        let (mut states, mut lines) = (self.desk.states(), self.desk.lines());
        states.mark_changed();
        let mut due = Instant::now();
        let mut heard = due;
        let mut pings = interval(PATIENCE);
        loop {
            let message = tokio::select! {
                said = socket.recv() => match said {
                    Some(Ok(said)) if self.hear(&said) => {
                        heard = Instant::now();
                        continue;
                    }
                    _ => return,
                },
                // A browser answers a ping by itself.
                _ = pings.tick() => Message::Ping(Bytes::new()),
                () = sleep_until(heard + 3 * PATIENCE) => return,
                // A page gets the newest state, and misses the states before it.
                changed = async {
                    sleep_until(due).await;
                    states.changed().await
                } => match changed {
                    Ok(()) => {
                        due = Instant::now() + FRAME;
                        Message::Text(states.borrow_and_update().1.clone())
                    }
                    Err(_) => return,
                },
                line = lines.recv() => match line {
                    Ok(told) if told.question && !self.questions => continue,
                    Ok(told) => Message::Text(told.text),
                    Err(RecvError::Lagged(_)) => continue,
                    Err(RecvError::Closed) => return,
                },
            };
            // There is no state before the first look at the board.
            if matches!(&message, Message::Text(text) if text.is_empty()) {
                continue;
            }
            // A page that reads nothing is gone.
            if !matches!(timeout(PATIENCE, socket.send(message)).await, Ok(Ok(()))) {
                return;
            }
        }
    }

    /// Handles a message from the page. False if it is invalid.
    fn hear(&mut self, message: &Message) -> bool {
        let Message::Text(text) = message else {
            return matches!(message, Message::Ping(_) | Message::Pong(_));
        };
        match serde_json::from_str(text) {
            Ok(Said::Beat(key)) => {
                // Another client may have taken control meanwhile: the state shows that.
                let heard = self.desk.control(|control, now| control.hear(Some(&key), now));
                let standing = heard.map_or(Standing::Watching, |_| Standing::Controlling);
                self.place.stand(standing);
                true
            }
            Ok(Said::Questions(wanted)) => {
                self.want(wanted);
                true
            }
            Err(_) => false,
        }
    }

    fn want(&mut self, wanted: bool) {
        if wanted && !self.questions {
            self.desk.listeners.fetch_add(1, Ordering::Relaxed);
        } else if !wanted && self.questions {
            self.desk.listeners.fetch_sub(1, Ordering::Relaxed);
        }
        self.questions = wanted;
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        self.want(false);
    }
}
