//! `stepwright serve` in a crowd: connections that say nothing keep nobody out.

#![cfg(unix)]

use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::process::Command;
use std::time::Duration;

use crate::common::{Running, program};
use crate::served::{Served, answered, next};
use serde_json::json;
use tungstenite::client::IntoClientRequest;

/// Descriptors of the server, and connections that would take more than that.
const DESCRIPTORS: u32 = 128;
const CROWD: usize = 300;

/// Longer than the server takes for anything here, on a loaded machine as well.
const LONG: Duration = Duration::from_secs(60);

/// A server with few descriptors.
fn narrow() -> Served {
    let serve = format!("ulimit -n {DESCRIPTORS} && exec \"$0\" \"$@\"");
    let words = ["serve", "--machine", "none", "--virtual", "--bind", "127.0.0.1:0"];
    Served::by(Running::of(Command::new("sh").args(["-c", &serve]).arg(program()).args(words)))
}

/// Connections to it that have said this, and say no more.
fn crowd(served: &Served, said: &str) -> Vec<TcpStream> {
    let connect = |_| {
        let mut stream = TcpStream::connect(&served.address).unwrap();
        stream.set_read_timeout(Some(LONG)).unwrap();
        // One that was sent away already hears nothing.
        let _ = stream.write_all(said.as_bytes());
        stream
    };
    (0..CROWD).map(connect).collect()
}

/// Whether the server has ended this connection.
fn is_ended(mut stream: &TcpStream) -> bool {
    let mut bytes = [0; 4096];
    loop {
        match stream.read(&mut bytes) {
            Ok(0) => return true,
            Ok(_) => {}
            Err(error) => {
                return !matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut);
            }
        }
    }
}

/// What somebody says who then says nothing more.
const BEGINNINGS: [&str; 4] = [
    "",
    "GET /api/state HTTP/1.1\r\nHost: localhost\r\n",
    "GET /api/control HTTP/1.1\r\nHost: localhost\r\n\r\n",
    "POST /api/move HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n\
     Content-Length: 4000\r\n\r\n{",
];

#[test]
fn a_stop_gets_through_a_crowd_of_silent_connections() {
    let mut served = narrow();
    let key = std::mem::take(&mut served.key);
    for said in BEGINNINGS {
        served.key.clone_from(&key);
        served.order("/api/move", json!({"axis": 1, "by": 1_000_000, "accel": 20000}));
        served.key.clear();
        let crowd = crowd(&served, said);
        served.order("/api/stop", json!({}));
        assert_eq!(served.rest(1)["stop"]["name"], "stop", "{said:?}");
        drop(crowd);
    }
}

/// A crowd takes its place from nobody who waits, and who waits takes none from a stop.
#[test]
fn who_waits_is_answered_in_a_crowd() {
    let served = narrow();
    for path in ["/api/move", "/api/home"] {
        served.order("/api/set", json!({"name": "switches", "value": 1}));
        let body = match path {
            "/api/move" => json!({"axis": 1, "by": 1_000_000, "accel": 20000}),
            _ => json!({"axis": 1, "within": 1_000_000, "speed": 100}),
        };
        let waits = served.waiting(path, &body);
        served.wait(1, |axis| axis["moving"] == true);
        let crowd = crowd(&served, "");
        served.order("/api/stop", json!({}));
        let (status, said) = answered(waits);
        assert_eq!((status, &said["ended"]["outcome"]), (200, &json!("stopped")), "{said}");
        drop(crowd);
    }
}

#[test]
fn who_says_nothing_is_sent_away() {
    let served = narrow();
    for said in BEGINNINGS {
        let silent = crowd(&served, said).pop().unwrap();
        assert!(is_ended(&silent), "{said:?}");
    }
}

#[test]
fn the_page_that_controls_keeps_its_place_in_a_crowd() {
    let served = narrow();
    let mut live = served.live();
    let mut beat = || {
        live.send(tungstenite::Message::text(json!({"beat": served.key}).to_string())).unwrap();
        next(&mut live, "state")
    };
    beat();
    let crowd = crowd(&served, "");
    served.order("/api/zero", json!({"axis": 1}));
    while beat()["axes"][0]["origin"] != 1 {}
    drop(crowd);
    // Also where every other page's place is taken.
    let mut pages = Vec::new();
    let join = |query: &str| {
        let url = format!("ws://{}/api/live{query}", served.address);
        let stream = TcpStream::connect(&served.address).unwrap();
        stream.set_read_timeout(Some(LONG)).unwrap();
        tungstenite::client(url.into_client_request().unwrap(), stream).ok().map(|(page, _)| page)
    };
    while let Some(page) = join("") {
        beat();
        pages.push(page);
        assert!(pages.len() < CROWD);
    }
    assert!(join("?control=0123456789abcdef0123456789abcdef").is_none());
    assert!(join(&format!("?control={}", served.key)).is_some());
}
