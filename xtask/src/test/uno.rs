//! Runs `examples/uno.sh`: the command moves a motor of a simulated Uno from two terminals. Then
//! runs the commands of the guide on the same chip.

use std::env;
use std::process::Command;
use std::time::Duration;

use anyhow::Result;

use crate::firmware::{Board, Build};
use crate::rig;
use crate::workspace::{self, Workspace, run_within};

/// The time limit; the motor moves in real time for half a minute.
const LIMIT: Duration = Duration::from_secs(300);

/// The script checks its results itself.
pub fn run(ws: &Workspace) -> Result<()> {
    Build { board: Board::Uno, timer: 1, bench: false }.controller(ws)?;
    let sim = rig::program(ws, "sim")?;
    let built = ws.shipped()?;
    let mut path = built.parent().map(|folder| folder.as_os_str().to_owned()).unwrap_or_default();
    path.push(":");
    path.push(env::var_os("PATH").unwrap_or_default());
    let mut script = Command::new("bash");
    rig::with_firmware(ws, &mut script);
    script.arg(ws.root.join("examples/uno.sh")).env("SIM", &sim).env("PATH", path);
    run_within(LIMIT, &mut script)?;
    let mut guide = ws.cargo(["test", "--workspace", "--test", "guide"]);
    rig::with_firmware(ws, &mut guide);
    workspace::run(guide.env("STEPWRIGHT_GUIDE_SIM", sim))
}
