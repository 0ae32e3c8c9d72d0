//! Each subcommand, without a machine file and with one that has every key; stops and kills
//! with files that can't be read.
#![cfg(unix)]

use std::collections::BTreeSet;

use crate::common::{Ended, Running, Scratch, stepwright};
use rustix::process::Signal;

/// Every key that a machine file may have, `PORT` aside.
const EVERY_KEY: &str = "\
baud = 115200
lease = \"2s\"

[axis.1]
steps-per-rev = 3200
mm-per-rev = 8
start-speed = 60
top-speed = 900
accel = 2000
decel = 1500
jerk = 40000
home-speed = 200
home-slow = 40
home-back-off = 20
home-within = 500
";

/// What becomes of a subcommand.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Fate {
    /// It ends by itself with this status.
    Ends(i32),
    /// It stays; a signal ends it, with status 0.
    Stays,
}
use Fate::{Ends, Stays};

/// A subcommand with its words, and what becomes of it on a board whose axis 1 rests. `PORT`
/// stands for the port where no machine file names it.
const CASES: [(&str, Fate); 28] = [
    ("settings set switches=1 PORT", Ends(0)),
    ("home --within 9000 PORT", Ends(0)),
    ("move 40 PORT", Ends(0)),
    ("line 5 -5 PORT", Ends(0)),
    ("run 100 --for 300ms PORT", Ends(0)),
    // Its keys come from a terminal, and there is none.
    ("jog PORT", Ends(1)),
    ("retarget 5 PORT", Ends(1)),
    ("watch PORT", Ends(0)),
    ("stop PORT", Ends(0)),
    ("status PORT", Ends(0)),
    ("position PORT", Ends(0)),
    ("send ? PORT", Ends(0)),
    ("kill PORT", Ends(0)),
    ("zero PORT", Ends(0)),
    ("serve --bind 127.0.0.1:0 PORT", Stays),
    ("ports", Ends(0)),
    ("init --file NEW --top-speed 5", Ends(0)),
    ("board --stdio", Ends(0)),
    ("flash uno --port /nonexistent --dry-run", Ends(0)),
    // No line, and none on standard input.
    ("selftest", Ends(1)),
    ("plan trapezoid --steps 400 --accel 2000 --top-speed 900", Ends(0)),
    ("timed --top 64000 --steps 5", Ends(0)),
    ("cycle CYCLE", Ends(0)),
    ("gcode JOB --plan", Ends(0)),
    ("grbl --stdio --fast", Ends(0)),
    ("figures", Ends(0)),
    ("calc belt --teeth 20", Ends(0)),
    ("completions bash", Ends(0)),
];

fn file(name: &str, text: &str) -> Scratch {
    let file = Scratch::new(name);
    std::fs::write(&file.0, text).unwrap();
    file
}

/// A virtual board with a switch behind its first axis, and its port.
fn board() -> (Running, String) {
    let mut board = Running::start(&["board", "--pty", "--switch", "1:-60"]);
    let port = board.wait_out("pty ").replace("pty ", "");
    (board, port)
}

/// Runs a subcommand; how it ended.
fn run(words: &[String], fate: Fate) -> Ended {
    let mut running = Running::start(words);
    if fate == Stays {
        running.wait_out("page ");
        running.signal(Signal::INT);
    }
    running.end()
}

#[test]
fn each_subcommand_ends_as_it_should_with_and_without_a_machine_file() {
    let help = stepwright(&["help"]).stdout;
    // The list that stands in groups: two spaces, the name, what it does.
    let rows = help.split("Options:\n").next().unwrap().lines();
    let names = rows.filter_map(|row| row.strip_prefix("  ")?.split(' ').next());
    let names: BTreeSet<_> = names.filter(|name| *name != "help").collect();
    let tried = CASES.iter().filter_map(|(line, _)| line.split(' ').next());
    assert_eq!(tried.collect::<BTreeSet<_>>(), names);

    let cycle = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/cycles/readme.toml");
    let job = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/gcode/badge.nc");
    for with_file in [false, true] {
        let (_board, port) = board();
        let machine = file("every-key.toml", &format!("port = \"{port}\"\n{EVERY_KEY}"));
        let new = Scratch::new("every-new.toml");
        let machine = if with_file { machine.path() } else { "none" };
        for (line, fate) in &CASES {
            let mut words: Vec<String> = vec!["--machine".into(), machine.into()];
            for word in line.split(' ') {
                match word {
                    "PORT" if with_file => {}
                    "PORT" => words.extend(["--port".to_owned(), port.clone()]),
                    "NEW" => words.push(new.path().to_owned()),
                    "JOB" => words.push(job.to_owned()),
                    "CYCLE" => words.push(cycle.to_owned()),
                    word => words.push(word.to_owned()),
                }
            }
            let ended = run(&words, *fate);
            assert!(!ended.stderr.contains("panicked"), "{words:?}: {ended:#?}");
            let status = if let Ends(status) = fate { *status } else { 0 };
            assert_eq!(ended.code(), Some(status), "{words:?}: {ended:#?}");
        }
    }
}

/// A stop takes the port of a machine file where it can; nothing in a file holds it up.
#[test]
fn no_stop_and_no_kill_depends_on_a_machine_file() {
    let (_board, port) = board();
    let fifo = Scratch::new("fifo.toml");
    rustix::fs::mknodat(
        rustix::fs::CWD,
        &fifo.0,
        rustix::fs::FileType::Fifo,
        rustix::fs::Mode::RUSR | rustix::fs::Mode::WUSR,
        0,
    )
    .unwrap();
    let no_text = Scratch::new("no-text.toml");
    std::fs::write(&no_text.0, b"port = \"\xff\"\n").unwrap();
    let broken = file("broken.toml", "[axis.1\ntop-speed =");
    let long = file("long.toml", &"#\n".repeat(100_000));
    let wrong = file("wrong-value.toml", "lease = \"1ms\"\nprot = 3\nbaud = 10\n[axis.9]\nx = 1\n");
    let gone = Scratch::new("gone.toml");
    let folder = env!("CARGO_TARGET_TMPDIR");
    let paths = [&fifo, &no_text, &broken, &long, &wrong, &gone].map(Scratch::path);
    for path in paths.into_iter().chain([folder]) {
        for order in ["stop", "kill"] {
            let zeroed = stepwright(&["zero", "--machine", "none", "--port", &port]);
            assert_eq!(zeroed.code(), Some(0), "{zeroed:#?}");
            let moving = ["move", "100000", "--detach", "--machine", "none", "--port", &port];
            assert_eq!(stepwright(&moving).code(), Some(0));
            let ended = stepwright(&[order, "--machine", path, "--port", &port]);
            let at_rest = if order == "stop" { " ready" } else { "position uncertain" };
            let first = ended.stdout.lines().next().unwrap_or_default();
            assert!(first.ends_with(at_rest), "{path}: {ended:#?}");
            assert!(ended.stderr.contains(path), "the file is named: {ended:#?}");
        }
        // Any other command says what is wrong with the file, and touches no board.
        let ended = stepwright(&["move", "10", "--machine", path, "--port", &port]);
        assert_eq!((ended.code(), ended.stdout.as_str()), (Some(1), ""), "{path}: {ended:#?}");
        ended.assert_error(path);
    }
    // A value that is wrong spoils none beside it.
    let text = format!("port = \"{port}\"\n[axis.1]\ntop-speed = \"40mph\"\n");
    let mistaken = file("mistaken.toml", &text);
    assert_eq!(stepwright(&["zero", "--machine", "none", "--port", &port]).code(), Some(0));
    let stop = ["stop", "--axis", "1", "--machine", mistaken.path()];
    stepwright(&stop).assert(0, "position 0 ready");
    // Without a port there is none to stop, and the reason is said.
    let ended = stepwright(&["stop", "--machine", broken.path()]);
    assert_eq!(ended.code(), Some(2), "{ended:#?}");
    ended.assert_error("needs a board: --port PATH");
    assert!(ended.stderr.contains("broken.toml"), "{ended:#?}");
}
