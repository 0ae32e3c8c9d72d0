//! The messages to a page over its WebSocket, and how often they come.

use std::net::{TcpListener, TcpStream};
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use serde_json::Value;
use stepwright_keeper::KeeperDesk;
use stepwright_keeper::report::LiveState;
use stepwright_serve::{Guard, ServeDesk};
use tungstenite::Message;
use tungstenite::client::IntoClientRequest;

/// Of any number of states a page gets a hundred per second, and always the last one.
#[test]
fn a_page_is_told_no_more_than_it_can_draw_and_the_newest() {
    const STATES: u32 = 1000;
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let desk = Arc::new(ServeDesk::default());
    let served = desk.clone();
    thread::spawn(move || stepwright_serve::serve(listener, served, Guard { token: None }));
    let request = format!("ws://{address}/api/live").into_client_request().unwrap();
    let stream = TcpStream::connect(address).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(30))).unwrap();
    let (mut page, _) = tungstenite::client(request, stream).unwrap();
    let begin = Instant::now();
    let telling = thread::spawn(move || {
        for late in 1..=STATES {
            desk.publish(LiveState { late, ..LiveState::default() });
            thread::sleep(Duration::from_millis(1));
        }
    });
    let mut heard = 0;
    loop {
        let Message::Text(text) = page.read().unwrap() else { continue };
        let state: Value = serde_json::from_str(&text).unwrap();
        heard += 1;
        if state["late"] == STATES {
            break;
        }
    }
    let most = begin.elapsed().as_millis() / 10 + 2;
    assert!(heard > 10 && heard <= most, "{heard} in {:?}", begin.elapsed());
    telling.join().unwrap();
}
