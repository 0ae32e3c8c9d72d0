//! The connections. There is always room for one more, as it may be for a stop.
//!
//! ```text
//!   accept ─► enter ─► Silent ◄─► Asking          (HTTP)
//!               │         └─────► Watching        (a page's WebSocket)
//!               │                 Waiting         (a request until the end of its order)
//!               │                 Controlling     (a request or a page with the key)
//!               └─ no room: the oldest connection of the lowest standing is closed
//! ```
//!
//! A connection that takes too long to send its request is closed even when there is room.

use std::io;
use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::{Arc, Weak};
use std::time::Duration;

use axum::Router;
use axum::extract::Request;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::Notify;
use tokio::time::sleep;
use tower::ServiceExt;

/// The most connections at once: half of the descriptors of a small system.
const CONNECTIONS: usize = 64;

/// The newest connections, whose requests may not have been read yet.
const NEWEST: usize = 16;

/// The longest time for the headers of a request, for its body, and for the pause before the next request.
pub(crate) const PATIENCE: Duration = Duration::from_secs(10);

/// The time between two attempts to accept while the system has no descriptors.
const AGAIN: Duration = Duration::from_millis(10);

/// The importance of a connection; the lowest is closed first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub(crate) enum Standing {
    /// It has sent no request yet, or was answered.
    Silent,
    /// A request of it is being answered.
    Asking,
    /// It belongs to a page that watches.
    Watching,
    /// A request of the controlling client waits on it for the end of its order.
    Waiting,
    /// It belongs to the controlling client.
    Controlling,
}

/// The place of a connection; free once the last reference is dropped.
#[derive(Debug, Default)]
pub(crate) struct Place {
    /// A [`Standing`], silent at first.
    standing: AtomicU8,
    leave: Notify,
}

impl Place {
    pub fn stand(&self, standing: Standing) {
        self.standing.store(standing as u8, Ordering::Relaxed);
    }

    /// Waits until the place is needed for another connection.
    pub async fn wanted(&self) {
        self.leave.notified().await;
    }
}

/// The occupied places, the oldest first.
#[derive(Debug, Default)]
struct Crowd(Vec<Weak<Place>>);

impl Crowd {
    /// Makes a place for a new connection.
    fn enter(&mut self) -> Arc<Place> {
        self.0.retain(|place| place.strong_count() > 0);
        while self.0.len() >= CONNECTIONS {
            self.make_room();
        }
        let place = Arc::<Place>::default();
        self.0.push(Arc::downgrade(&place));
        place
    }

    /// Closes the oldest connection of the lowest standing. The newest count as asking.
    fn make_room(&mut self) {
        let heard = self.0.len().saturating_sub(NEWEST);
        let standing = |at: usize| {
            let standing = self.0[at].upgrade()?.standing.load(Ordering::Relaxed);
            Some(if at < heard { standing } else { standing.max(Standing::Asking as u8) })
        };
        let lowest = (0..self.0.len()).min_by_key(|&at| standing(at));
        if let Some(place) = lowest.and_then(|at| self.0.remove(at).upgrade()) {
            place.leave.notify_one();
        }
    }
}

/// Accepts connections, and answers their requests.
pub(crate) async fn serve(listener: TcpListener, app: Router) -> io::Result<()> {
    let mut crowd = Crowd::default();
    loop {
        match listener.accept().await {
            Ok((stream, _)) => {
                tokio::spawn(answer(stream, app.clone(), crowd.enter()));
            }
            // Either the other side is gone already, or the system has no descriptors.
            Err(_) => {
                crowd.make_room();
                sleep(AGAIN).await;
            }
        }
    }
}

/// Answers a connection until it ends, is silent for too long, or has to make room.
async fn answer(stream: TcpStream, app: Router, place: Arc<Place>) {
    let wanted = place.clone();
    let service = service_fn(move |mut request: Request<Incoming>| {
        let (app, place) = (app.clone(), place.clone());
        async move {
            place.stand(Standing::Asking);
            request.extensions_mut().insert(place.clone());
            let answer = app.oneshot(request).await;
            place.stand(Standing::Silent);
            answer
        }
    });
    let mut http = http1::Builder::new();
    http.timer(TokioTimer::new()).header_read_timeout(PATIENCE);
    let connection = http.serve_connection(TokioIo::new(stream), service).with_upgrades();
    tokio::select! {
        // Errors of a connection concern only the other side.
        _ = connection => {}
        () = wanted.wanted() => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_wanted(place: &Place) -> bool {
        // A stored permit is available at once.
        let mut wanted = std::pin::pin!(place.wanted());
        let mut context = std::task::Context::from_waker(std::task::Waker::noop());
        wanted.as_mut().poll(&mut context).is_ready()
    }

    /// The newest connection has had no time to send its stop.
    #[test]
    fn who_came_last_is_spared_though_all_others_ask() {
        let mut crowd = Crowd::default();
        let others: Vec<_> = (1..CONNECTIONS).map(|_| crowd.enter()).collect();
        others.iter().for_each(|place| place.stand(Standing::Asking));
        let stop = crowd.enter();
        // The system has no descriptors, and more connections come.
        crowd.make_room();
        let more: Vec<_> = (1..NEWEST).map(|_| crowd.enter()).collect();
        assert!(!is_wanted(&stop));
        assert!(is_wanted(&others[0]));
        drop(more);
        // The newest is not spared before the controlling client.
        let mut few = Crowd::default();
        let places = [few.enter(), few.enter()];
        places[0].stand(Standing::Controlling);
        few.make_room();
        assert!(is_wanted(&places[1]) && !is_wanted(&places[0]));
    }

    #[test]
    fn the_oldest_that_is_of_least_use_makes_room() {
        use Standing::{Asking, Controlling, Waiting, Watching};
        let mut crowd = Crowd::default();
        let places: Vec<_> = (0..CONNECTIONS).map(|_| crowd.enter()).collect();
        for (at, place) in places.iter().enumerate() {
            assert!(!is_wanted(place));
            match at {
                0 => place.stand(Controlling),
                1 => place.stand(Watching),
                2 => {}
                4 => place.stand(Waiting),
                _ => place.stand(Asking),
            }
        }
        let mut newer = vec![crowd.enter()];
        assert!(is_wanted(&places[2]));
        newer[0].stand(Asking);
        newer.push(crowd.enter());
        assert!(is_wanted(&places[3]));
        // A connection that is gone leaves room.
        newer.pop();
        newer.push(crowd.enter());
        assert!(places.iter().chain(&newer).all(|place| !is_wanted(place)));
        // From then on only connections of the lowest standing are replaced.
        for _ in 0..2 * CONNECTIONS {
            newer.push(crowd.enter());
            newer.last().unwrap().stand(Asking);
        }
        assert!([0, 1, 4].iter().all(|at| !is_wanted(&places[*at])));
        assert_eq!(crowd.0.len(), CONNECTIONS);
        // Waiting requests never take the place of the controlling client.
        for _ in 0..2 * CONNECTIONS {
            newer.push(crowd.enter());
            newer.last().unwrap().stand(Waiting);
        }
        assert!(!is_wanted(&places[0]) && is_wanted(&places[1]) && is_wanted(&places[4]));
    }
}
