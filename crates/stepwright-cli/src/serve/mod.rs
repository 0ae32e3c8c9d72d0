//! `stepwright serve`: serves a board to browsers.
//!
//! ```text
//!   browser ─► stepwright-serve ─► ServeDesk ─► Keeper, on a thread ─► Session ─► tap ─► Link
//! ```
//!
//! | module | what |
//! | --- | --- |
//! | [`board`] | the board's thread: its line, also when the board is lost and returns |
//! | [`tap`] | the lines as they are sent |
//! | [`paths`] | cycle files and G-code jobs |
//!
//! [`stepwright_keeper`] carries out the requests.

mod board;
mod paths;
mod tap;

use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener};
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::{Arc, mpsc};
use std::thread;

use stepwright_protocol::{AxisId, MAX_AXES};
use stepwright_serve::{DeskEnd, Guard, ServeDesk, Token};

use crate::calc;
use crate::failure::Failure;
use crate::interrupt::{self, While};
use crate::machine::{self, MachineArgs, MachineAxes};
use crate::order::target::PortArgs;
use crate::quantity::GeometryArgs;
use crate::say;
use board::{BoardThread, ServedBoard};
use paths::{PathBoards, PathFiles};
use stepwright_sim::{AxisDrive, Switch};

/// The default TCP port of the page.
const PORT: u16 = 8480;

/// The default switch of a virtual machine.
const SWITCH: &str = "1:-1000";

/// Drive a board from a browser, and from programs over HTTP
#[derive(clap::Args)]
#[command(after_help = "\
The first line on standard output is `page ADDRESS`: open it in a browser. Without --port
a virtual board is served: the real engine with simulated pins.

One page controls, others watch, and every page may stop. A motor that runs without end
brakes when the page that runs it is closed, or silent for a second. A board that was
unplugged is found again when it is back; nothing moves by itself then.

A program can request everything that the page can do: `GET /api/openapi.json` describes
the requests. Orders need a key, which `POST /api/control` gives.

Only this computer reaches the page, unless --bind says otherwise. Other computers need a
token then, which is part of the address that is printed. The connection is not encrypted.

Ctrl-C brakes every axis, and ends when they rest; a second Ctrl-C kills.

Examples:
  stepwright serve
  stepwright serve --port /dev/ttyUSB0 --mm-per-rev 8
  stepwright serve --port /dev/ttyUSB0 --bind 0.0.0.0
  curl http://127.0.0.1:8480/api/state
  curl --json '{}' http://127.0.0.1:8480/api/stop")]
pub struct Args {
    /// Address to serve at: 192.168.0.7, 0.0.0.0:80; port 0: any free port
    /// [default: 127.0.0.1:8480]
    #[arg(long, value_name = "ADDR", default_value_t = Bind::LOOPBACK, hide_default_value = true)]
    bind: Bind,
    #[command(flatten)]
    geometry: GeometryArgs,
    #[command(flatten)]
    port: PortArgs,
    /// Serve a virtual board even if the machine file names a port
    #[arg(id = "virtual", long = "virtual", conflicts_with = "port", help_heading = "Board")]
    _virtual_board: bool,
    /// Serial port of another board, which runs the program `cycles`: the page's cycle files are
    /// run on it, not on a virtual board
    #[arg(long, value_name = "PATH", help_heading = "Board")]
    cycles: Option<PathBuf>,
    /// Serial port of another board, which runs the program `stream`: the page's G-code jobs are
    /// run on it, not on a virtual board
    #[arg(long, value_name = "PATH", help_heading = "Board")]
    stream: Option<PathBuf>,
    /// Limit switch of the virtual board that the axis closes at this position and beyond, in
    /// steps; the board uses it if its setting `switches` has the axis [default: 1:-1000]
    #[arg(long, value_name = "AXIS:PLACE", conflicts_with = "port", help_heading = "Board")]
    switch: Vec<Switch>,
    /// Drive of an axis of the virtual board in place of STEP and DIR: unipolar, bridge, each
    /// also with -wave or -half, shield
    #[arg(long, value_name = "AXIS:DRIVE", conflicts_with = "port", help_heading = "Board")]
    drive: Vec<AxisDrive>,
}

/// An address to listen at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Bind(SocketAddr);

impl Bind {
    const LOOPBACK: Bind = Bind(SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), PORT));
}

impl FromStr for Bind {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Bind, &'static str> {
        let address = text
            .parse()
            .or_else(|_| text.parse().map(|address: IpAddr| SocketAddr::new(address, PORT)));
        address.map(Bind).map_err(|_| "an IP address, with or without a port: 127.0.0.1:8480")
    }
}

impl std::fmt::Display for Bind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.fmt(f)
    }
}

/// Serves until Ctrl-C or another signal.
pub fn run(args: Args, machine: &MachineArgs) -> Result<(), Failure> {
    let ports =
        [("--port", &args.port.port), ("--cycles", &args.cycles), ("--stream", &args.stream)];
    for (n, (name, port)) in ports.into_iter().enumerate() {
        let same = ports[..n].iter().find(|(_, other)| port.is_some() && *other == port);
        if let Some((other, _)) = same {
            let what = format!("{other} and {name} are two boards, each with its own program");
            return Err(
                Failure::usage(what).hint("leave --port out: a virtual board is served then")
            );
        }
    }
    let boards = PathBoards { cycles: args.cycles, stream: args.stream };
    let paths = Arc::new(PathFiles::on(boards, machine));
    let home_within = machine::home_within(machine, &args.geometry)?;
    let file = MachineAxes::quiet(machine)?;
    let unit = |axis| Ok((axis, file.geometry(axis, &args.geometry).page_unit()?));
    let units = AxisId::first(MAX_AXES).map(unit).collect::<Result<Vec<_>, Failure>>()?;
    let machine = machine::shown(machine)?;
    let listener = TcpListener::bind(args.bind.0).map_err(|error| {
        Failure::new(format!("can't serve at {}: {error}", args.bind))
            .hint("another address: --bind 127.0.0.1:0 takes any port that is free")
    })?;
    let failed = |error: std::io::Error| Failure::new(format!("can't serve: {error}"));
    let address = listener.local_addr().map_err(failed)?;
    interrupt::listen(While::Holding)?;
    let desk = Arc::new(ServeDesk::default());
    desk.calculate_by(calc::calculators());
    desk.read_paths_by(paths.clone());
    let switches = match args.switch.is_empty() {
        true => SWITCH.parse().into_iter().collect(),
        false => args.switch,
    };
    let (port, drives) = (args.port, args.drive);
    let served = ServedBoard { port, units, switches, drives, home_within, machine };
    let (tell, met) = mpsc::channel();
    let board = thread::spawn({
        let desk = desk.clone();
        move || {
            let _end = DeskEnd(desk.clone());
            BoardThread::begin(served, desk).and_then(|(board, session)| {
                // The main thread only waits for this message.
                let _ = tell.send(());
                board.keep(session)
            })
        }
    });
    // Without a board there is nothing to serve.
    if met.recv().is_ok() {
        let guard = Guard { token: (!address.ip().is_loopback()).then(Token::new) };
        greet(address, &guard);
        stepwright_serve::serve(listener, desk, guard).map_err(failed)?;
    }
    paths.finish();
    board.join().unwrap_or_else(|_| Err(Failure::new("the conversation with the board broke off")))
}

fn greet(address: SocketAddr, guard: &Guard) {
    match &guard.token {
        None => say::result(format_args!("page http://{address}/")),
        Some(token) => {
            say::result(format_args!("page http://{address}/#token={}", token.text()));
            say::note("whoever has this address can move the motors; it is not encrypted");
            if address.ip().is_unspecified() {
                say::note(format_args!(
                    "on another machine put this machine's address in the place of {}",
                    address.ip()
                ));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Bind;

    #[test]
    fn an_address_has_a_port_or_the_usual_one() {
        for (text, address) in [
            ("127.0.0.1", "127.0.0.1:8480"),
            ("0.0.0.0:80", "0.0.0.0:80"),
            ("::1", "[::1]:8480"),
            ("[::]:0", "[::]:0"),
        ] {
            assert_eq!(text.parse::<Bind>().map(|bind| bind.to_string()), Ok(address.to_owned()));
        }
        for wrong in ["", "localhost", "127.0.0.1:65536", ":80", "8480"] {
            assert!(wrong.parse::<Bind>().is_err(), "{wrong}");
        }
    }
}
