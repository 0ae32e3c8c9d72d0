//! A board that is served, and the way to it: over HTTP, and over its WebSocket.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket};

use crate::common::{LIMIT, Running};

/// A served board, and the key of who controls.
pub struct Served {
    pub command: Running,
    pub address: String,
    pub key: String,
}

impl Served {
    /// Without a machine file.
    pub fn start(args: &[&str]) -> Served {
        Served::on(&[&["--machine", "none"], args].concat())
    }

    /// With these options.
    pub fn on(args: &[&str]) -> Served {
        let args = [&["serve", "--bind", "127.0.0.1:0"], args].concat();
        Served::by(Running::start(&args))
    }

    /// By this command, which is starting.
    pub fn by(mut command: Running) -> Served {
        let page = command.wait_out("page ");
        let address = page.trim_start_matches("page http://").trim_end_matches('/').to_owned();
        let mut served = Served { command, address, key: String::new() };
        served.key = served.taken(false);
        served
    }

    pub fn board() -> Served {
        Served::start(&["--virtual"])
    }

    /// The key of a new hand.
    pub fn taken(&self, over: bool) -> String {
        let (status, given) = self.post("/api/control", json!({"take_over": over}));
        assert_eq!(status, 200, "{given}");
        given["key"].as_str().unwrap().to_owned()
    }

    pub fn ask(&self, method: &str, path: &str, body: &str) -> (u16, Value) {
        answered(self.send(method, path, body))
    }

    /// Asks, and leaves the answer to [`answered`].
    pub fn send(&self, method: &str, path: &str, body: &str) -> TcpStream {
        let mut stream = TcpStream::connect(&self.address).unwrap();
        stream.set_read_timeout(Some(LIMIT)).unwrap();
        let (address, key, length) = (&self.address, &self.key, body.len());
        write!(
            stream,
            "{method} {path} HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\
             Stepwright-Control: {key}\r\nContent-Type: application/json\r\n\
             Content-Length: {length}\r\n\r\n{body}"
        )
        .unwrap();
        stream
    }

    /// An order whose answer waits until it has ended.
    pub fn waiting(&self, path: &str, body: &Value) -> TcpStream {
        self.send("POST", &format!("{path}?wait=true"), &body.to_string())
    }

    pub fn get(&self, path: &str) -> Value {
        let (status, said) = self.ask("GET", path, "");
        assert_eq!(status, 200, "{path}: {said}");
        said
    }

    pub fn post(&self, path: &str, body: Value) -> (u16, Value) {
        self.ask("POST", path, &body.to_string())
    }

    /// What has to be taken.
    #[track_caller]
    pub fn order(&self, path: &str, body: Value) -> Value {
        let (status, said) = self.post(path, body);
        assert_eq!(status, 200, "{path}: {said}");
        said
    }

    /// What has to be declined; the reason.
    #[track_caller]
    pub fn declined(&self, path: &str, body: Value, as_status: u16) -> String {
        let (status, said) = self.post(path, body);
        assert_eq!(status, as_status, "{path}: {said}");
        said["what"].as_str().unwrap().to_owned()
    }

    pub fn axis(&self, number: usize) -> Value {
        self.get("/api/state")["axes"][number - 1].clone()
    }

    /// Waits until an axis does this; how it was then.
    #[track_caller]
    pub fn wait(&self, number: usize, until: impl Fn(&Value) -> bool) -> Value {
        let begin = Instant::now();
        loop {
            let axis = self.axis(number);
            if until(&axis) {
                return axis;
            }
            assert!(begin.elapsed() < LIMIT, "{axis}");
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    #[track_caller]
    pub fn rest(&self, number: usize) -> Value {
        self.wait(number, |axis| axis["moving"] == false)
    }

    pub fn live(&self) -> WebSocket<TcpStream> {
        let request = format!("ws://{}/api/live", self.address).into_client_request().unwrap();
        let stream = TcpStream::connect(&self.address).unwrap();
        stream.set_read_timeout(Some(LIMIT)).unwrap();
        tungstenite::client(request, stream).unwrap().0
    }
}

/// The status and the body of an answer.
pub fn answered(mut stream: TcpStream) -> (u16, Value) {
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    let status = answer.split(' ').nth(1).unwrap().parse().unwrap();
    let body = answer.split_once("\r\n\r\n").unwrap().1;
    (status, serde_json::from_str(body).unwrap_or(Value::Null))
}

/// The next message of a kind. Others come all the time.
pub fn next(live: &mut WebSocket<TcpStream>, kind: &str) -> Value {
    let begun = Instant::now();
    loop {
        assert!(begun.elapsed() < LIMIT, "there is no message of the kind {kind} any more");
        if let Message::Text(text) = live.read().unwrap() {
            let message: Value = serde_json::from_str(&text).unwrap();
            if message["type"] == kind {
                return message;
            }
        }
    }
}
