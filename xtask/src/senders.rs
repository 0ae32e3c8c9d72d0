//! Tests `stepwright grbl` with other projects' senders of G-code.

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use anyhow::Result;
use clap::ValueEnum;

use crate::firmware;
use crate::node;
use crate::python;
use crate::setup::{self, Need};
use crate::sim;
use crate::small::SmallBoard;
use crate::test::pico;
use crate::workspace::{Workspace, run, run_within};

/// The needs of the senders.
pub const NEEDS: &[&Need] = &[setup::PYTHON, setup::NODE];

/// The time limit of a sender, which moves motors in real time.
const LIMIT: Duration = Duration::from_secs(900);

/// The lines of a job in the tests.
const FEW: u32 = 800;

/// Have foreign senders of G-code run a job each on `stepwright grbl`
#[derive(clap::Args)]
pub struct Senders {
    /// Which; all if none is named: pygrbl-streamer, grbl-streamer, gantrix,
    /// grbl-link, cncjs, bcnc
    sender: Vec<String>,
    /// Lines of the job
    #[arg(long, default_value_t = 5_000)]
    lines: u32,
    /// A board that plays streams has the motors, also `cargo xtask sim uno --program stream`
    #[arg(long, value_name = "PATH")]
    port: Option<PathBuf>,
    /// CNCjs alone runs a job with limited jerk, and a simulated board has the motors, in its own
    /// time: 19 ms a line
    #[arg(long, value_name = "BOARD", conflicts_with_all = ["port", "sender"])]
    on: Option<On>,
}

/// A simulated board that plays streams.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum On {
    Uno,
    Mega,
    /// Some four times slower than real time
    Pico,
}

impl Senders {
    /// Runs the senders one after another.
    pub fn run(&self, ws: &Workspace) -> Result<()> {
        setup::ensure(NEEDS)?;
        if let Some(board) = self.on {
            return on_board(ws, board, self.lines);
        }
        if self.sender.is_empty() || self.sender.iter().any(|name| name == "bcnc") {
            setup::ensure(&[setup::BCNC])?;
        }
        drive(ws, self.lines, &self.sender, self.port.as_deref())
    }
}

/// Runs two senders with a short job.
pub fn test(ws: &Workspace) -> Result<()> {
    drive(ws, FEW, &["pygrbl-streamer".to_owned(), "cncjs".to_owned()], None)
}

/// Lets CNCjs run a job of this many chords on a board.
pub fn on_board(ws: &Workspace, board: On, chords: u32) -> Result<()> {
    let mut modules = vec![node::CNCJS.modules(ws)];
    node::CNCJS.prepare(ws)?;
    let words = match board {
        On::Uno => sim::in_its_own_time(ws, firmware::Board::Uno, "stream")?,
        On::Mega => sim::in_its_own_time(ws, firmware::Board::Mega, "stream")?,
        On::Pico => {
            node::RP2040JS.prepare(ws)?;
            setup::ensure(pico::NEEDS)?;
            SmallBoard::named(ws, "rp2040")?.build(ws)?;
            modules.push(node::RP2040JS.modules(ws));
            pico::in_its_own_time(ws)
        }
    };
    python::PIO.prepare(ws)?;
    let mut job = Command::new(python::PIO.interpreter(ws));
    job.env("NODE_PATH", env::join_paths(modules)?);
    job.arg(ws.root.join("crates/stepwright-cli/tests/senders/on_board.py"));
    run(job.arg(ws.shipped()?).arg(chords.to_string()).args(words))
}

fn drive(ws: &Workspace, lines: u32, senders: &[String], port: Option<&Path>) -> Result<()> {
    python::SENDERS.prepare(ws)?;
    node::CNCJS.prepare(ws)?;
    let command = ws.shipped()?;
    let script = ws.root.join("crates/stepwright-cli/tests/senders/senders.py");
    let mut python = Command::new(python::SENDERS.interpreter(ws));
    python.arg(script).arg(command).arg(lines.to_string()).args(senders);
    if let Some(port) = port {
        python.env("STEPWRIGHT_PORT", port);
    }
    run_within(LIMIT, python.env("NODE_PATH", node::CNCJS.modules(ws)))
}
