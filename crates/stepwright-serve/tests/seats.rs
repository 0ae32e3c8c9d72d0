//! The number of pages at once. A test program of its own, as the seats belong to the process.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::thread;
use std::time::Duration;

use serde_json::Value;
use stepwright_serve::{Guard, ServeDesk};
use tungstenite::WebSocket;
use tungstenite::client::IntoClientRequest;

const PAGES: usize = 32;

fn connect(address: SocketAddr) -> TcpStream {
    let stream = TcpStream::connect(address).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(30))).unwrap();
    stream
}

/// Takes control, and returns the key.
fn take_control(address: SocketAddr) -> String {
    let mut stream = connect(address);
    let head = "Content-Type: application/json\r\nContent-Length: 2\r\nConnection: close";
    write!(stream, "POST /api/control HTTP/1.1\r\nHost: {address}\r\n{head}\r\n\r\n{{}}").unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    let (_, body) = answer.split_once("\r\n\r\n").unwrap();
    let given: Value = serde_json::from_str(body).unwrap_or_else(|_| panic!("{answer}"));
    given["key"].as_str().unwrap_or_else(|| panic!("{answer}")).to_owned()
}

#[test]
fn every_seat_is_given_and_given_again() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let desk = Arc::new(ServeDesk::default());
    thread::spawn(move || stepwright_serve::serve(listener, desk, Guard { token: None }));
    let enter = |query: &str| -> Option<WebSocket<TcpStream>> {
        let request = format!("ws://{address}/api/live{query}").into_client_request().unwrap();
        tungstenite::client(request, connect(address)).ok().map(|(page, _)| page)
    };
    let join = || enter("");
    let mut pages: Vec<_> =
        (0..PAGES).map(|n| join().unwrap_or_else(|| panic!("page {n}"))).collect();
    assert!(join().is_none(), "one page too many");
    // A page that leaves makes room for another.
    drop(pages.pop());
    let again = (0..300).find_map(|_| {
        thread::sleep(Duration::from_millis(50));
        join()
    });
    assert!(again.is_some(), "a seat that was left is taken again");
    assert!(join().is_none(), "one page too many again");

    // One more seat is kept for the controlling client alone.
    let key = take_control(address);
    assert!(enter("?control=wrong").is_none(), "a page with another key");
    let controlling = enter(&format!("?control={key}"));
    assert!(controlling.is_some(), "the page of who controls finds a seat");
    assert!(enter(&format!("?control={key}")).is_none(), "one seat, not two");
    assert!(join().is_none(), "and none for who watches");
}
