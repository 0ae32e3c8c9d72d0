//! How many pages are told at once. One process, for the seats are the process's.

use std::net::{TcpListener, TcpStream};
use std::sync::Arc;
use std::thread;
use std::time::Duration;

use stepwright_serve::{Guard, ServeDesk};
use tungstenite::WebSocket;
use tungstenite::client::IntoClientRequest;

const PAGES: usize = 32;

#[test]
fn every_seat_is_given_and_given_again() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let desk = Arc::new(ServeDesk::default());
    thread::spawn(move || stepwright_serve::serve(listener, desk, Guard { token: None }));
    let join = || -> Option<WebSocket<TcpStream>> {
        let request = format!("ws://{address}/api/live").into_client_request().unwrap();
        let stream = TcpStream::connect(address).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(30))).unwrap();
        tungstenite::client(request, stream).ok().map(|(page, _)| page)
    };
    let mut pages: Vec<_> =
        (0..PAGES).map(|n| join().unwrap_or_else(|| panic!("page {n}"))).collect();
    assert!(join().is_none(), "one page too many");
    // One that leaves makes room for one.
    drop(pages.pop());
    let again = (0..300).find_map(|_| {
        thread::sleep(Duration::from_millis(50));
        join()
    });
    assert!(again.is_some(), "a seat that was left is taken again");
    assert!(join().is_none(), "one page too many again");
}
