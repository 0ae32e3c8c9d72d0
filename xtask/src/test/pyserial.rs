//! Masters written in Python drive the virtual board through a pseudo-terminal, as with a real
//! board at a serial port.

use std::fs;
use std::io::{self, BufRead, BufReader};
use std::process::{Command, Stdio};
use std::sync::mpsc;
use std::thread;
use std::time::Duration;

use anyhow::{Context, Result, bail, ensure};

use crate::python;
use crate::workspace::{self, Guard, Workspace, output, run_within};

/// One uses the original slave's lines, one uses checksums in noise.
const MASTERS: [&str; 2] = ["examples/master.py", "examples/checksums.py"];
/// The time limit of the board's first answer, which comes at once unless the machine is loaded.
const BOARD_LIMIT: Duration = Duration::from_secs(20);
/// The time limit of a master, which moves a motor in real time.
const MASTER_LIMIT: Duration = Duration::from_secs(180);

/// `stepwright board --pty` prints `pty PATH` first. Then `master.py PATH` and the other masters
/// must end with status 0.
pub fn run(ws: &Workspace) -> Result<()> {
    python::SERIAL.prepare(ws)?;
    ws.shipped()?;

    println!("$ stepwright board --pty");
    let mut board = Guard(
        Command::new(ws.command())
            .args(["board", "--pty"])
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .spawn()
            .context("starting the virtual board")?,
    );
    let mut stdout = BufReader::new(board.0.stdout.take().context("the board has no stdout")?);

    // A thread, because a read can't have a time limit. Afterwards it passes on the board's output,
    // so that the board never waits for a reader.
    let (tell, hear) = mpsc::channel();
    let carrier = thread::spawn(move || {
        let mut line = String::new();
        let first = stdout.read_line(&mut line).map(|_| line);
        if tell.send(first).is_ok() {
            let _ = io::copy(&mut stdout, &mut io::stdout());
        }
    });
    let first = hear.recv_timeout(BOARD_LIMIT).context("the board did not say its path")??;
    let Some(path) = first.trim_end().strip_prefix("pty ") else {
        bail!("the board's first line is {first:?}, not `pty PATH`");
    };

    for master in MASTERS {
        run_within(
            MASTER_LIMIT,
            Command::new(python::SERIAL.interpreter(ws)).current_dir(&ws.root).args([master, path]),
        )?;
        if let Some(status) = board.0.try_wait()? {
            bail!("the board ended under its master: {status}");
        }
    }
    the_guides_own(ws, path)?;
    together(ws, path)?;
    // The board's last output comes before that of this program.
    drop(board);
    let _ = carrier.join();
    Ok(())
}

/// Runs a server, the command and a Python program at this port at once.
fn together(ws: &Workspace, port: &str) -> Result<()> {
    let script = ws.root.join("crates/stepwright-cli/tests/together/together.py");
    let mut script_at = Command::new(python::SERIAL.interpreter(ws));
    script_at.arg(script).arg(ws.command()).arg(port);
    run_within(MASTER_LIMIT, &mut script_at)
}

/// Runs the program of the guide's page at this port: it moves the motor, and prints its position.
fn the_guides_own(ws: &Workspace, port: &str) -> Result<()> {
    let page = fs::read_to_string(ws.root.join("docs/guide/src/serial-line.md"))?;
    let program = page.split("```python\n").nth(1).and_then(|rest| rest.split("```").next());
    let program = program.context("the page has no program")?.replace("/dev/ttyUSB0", port);
    let mut zero = Command::new(ws.command());
    zero.args(["zero", "--port", port]).env("STEPWRIGHT_MACHINE", "none");
    workspace::run(&mut zero)?;
    let said = output(Command::new(python::SERIAL.interpreter(ws)).args(["-c", &program]))?;
    ensure!(said == "4000\n", "the program of serial-line.md says {said:?}");
    Ok(())
}
