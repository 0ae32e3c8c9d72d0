//! Measures what it costs to send the state of three axes to ten pages, 1,000 times a second.
//!
//! ```text
//! cargo run --release -p stepwright-serve --example rates
//! ```
//!
//! A server without a board publishes a new state every millisecond, and ten WebSockets in another process read
//! the states. Prints the server's share of a core, and the states per second that each page got. Only Linux
//! reports what a process has cost.

use std::io::{BufRead, BufReader};
use std::net::{TcpListener, TcpStream};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};
use std::{env, fs, thread};

use stepwright_keeper::KeeperDesk;
use stepwright_keeper::report::{LiveAxis, LiveState};
use stepwright_serve::{Guard, ServeDesk};
use tungstenite::Message;
use tungstenite::client::IntoClientRequest;

const PAGES: usize = 10;
const AXES: u8 = 3;
const TIME: Duration = Duration::from_secs(10);
/// The times between two states. The second is that of the command.
const EVERY: [Duration; 2] = [Duration::from_millis(1), Duration::from_millis(20)];
/// Ticks per second of a process's times, on every Linux.
const HZ: f64 = 100.0;

fn main() {
    match env::args().nth(1) {
        Some(micros) => serve(Duration::from_micros(micros.parse().unwrap())),
        None => EVERY.iter().for_each(|every| measure(*every)),
    }
}

/// Publishes states until the process ends.
fn serve(every: Duration) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    println!("{}", listener.local_addr().unwrap());
    let desk = Arc::new(ServeDesk::default());
    let telling = desk.clone();
    thread::spawn(move || {
        let begin = Instant::now();
        for n in 1.. {
            let axes = (1..=AXES).map(|axis| axis_at(axis, telling.time())).collect();
            telling.publish(LiveState { axes, connected: true, ..LiveState::default() });
            thread::sleep((begin + every * n).saturating_duration_since(Instant::now()));
        }
    });
    stepwright_serve::serve(listener, desk, Guard { token: None }).unwrap();
}

fn axis_at(axis: u8, time: f64) -> LiveAxis {
    let position = Some((time * 1234.5) as i64);
    let (speed, state) = (1234.5, "busy");
    LiveAxis { axis, position, time, speed, moving: true, state, stop: None, home: None, origin: 0 }
}

fn measure(every: Duration) {
    let own = env::current_exe().unwrap();
    let mut server = Command::new(own);
    let mut server =
        server.arg(every.as_micros().to_string()).stdout(Stdio::piped()).spawn().unwrap();
    let mut address = String::new();
    BufReader::new(server.stdout.take().unwrap()).read_line(&mut address).unwrap();
    let heard = Arc::new(AtomicUsize::new(0));
    for _ in 0..PAGES {
        let request = format!("ws://{}/api/live", address.trim()).into_client_request().unwrap();
        let stream = TcpStream::connect(address.trim()).unwrap();
        let (mut page, _) = tungstenite::client(request, stream).unwrap();
        let heard = heard.clone();
        thread::spawn(move || {
            while let Ok(Message::Text(_)) = page.read() {
                heard.fetch_add(1, Ordering::Relaxed);
            }
        });
    }
    thread::sleep(Duration::from_secs(1));
    let (before, spent, begin) = (heard.load(Ordering::Relaxed), cost(server.id()), Instant::now());
    thread::sleep(TIME);
    let seconds = begin.elapsed().as_secs_f64();
    let rate = (heard.load(Ordering::Relaxed) - before) as f64 / seconds / PAGES as f64;
    let share = (cost(server.id()) - spent) / seconds * 100.0;
    println!(
        "a state every {every:?}: {PAGES} pages hear {rate:.0} a second each, for {share:.1} % of \
         a core"
    );
    server.kill().unwrap();
    server.wait().unwrap();
}

/// The seconds of a core that a process has used.
fn cost(id: u32) -> f64 {
    let stat = fs::read_to_string(format!("/proc/{id}/stat")).unwrap();
    let fields: Vec<_> = stat.rsplit_once(')').unwrap().1.split_whitespace().collect();
    let ticks = |n: usize| fields[n].parse::<f64>().unwrap();
    (ticks(11) + ticks(12)) / HZ
}
