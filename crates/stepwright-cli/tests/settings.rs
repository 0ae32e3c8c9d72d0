//! `stepwright settings`, with a virtual board on a pseudo-terminal.
#![cfg(unix)]

use crate::common::{Ended, Running, Scratch, stepwright};

struct Board {
    _running: Running,
    path: String,
}

impl Board {
    fn start() -> Board {
        let mut running = Running::start(&["board", "--pty"]);
        let first = running.wait_out("");
        let path = first.strip_prefix("pty ").expect("the first line").to_owned();
        Board { _running: running, path }
    }

    #[track_caller]
    fn settings(&self, words: &[&str]) -> Ended {
        stepwright(&[&["settings"], words, &["--port", &self.path]].concat())
    }
}

#[test]
fn settings_are_read_and_set() {
    let board = Board::start();
    board.settings(&["get", "pulse-us"]).assert(0, "2");
    let ended = board.settings(&["set", "pulse-us=3", "idle-ms=60_000"]);
    assert_eq!(ended.code(), Some(0), "{ended:?}");
    let rows: Vec<_> = ended.stdout.lines().map(|row| row.split_whitespace().take(3)).collect();
    let rows: Vec<Vec<_>> = rows.into_iter().map(Iterator::collect).collect();
    assert_eq!(rows, [["pulse-us", "3", "µs"], ["idle-ms", "60000", "ms"]]);
    let ended = board.settings(&["get"]);
    assert_eq!(ended.stdout.lines().count(), 27, "{ended:?}");
    assert!(ended.stdout.contains("\nidle-ms             60000 ms "), "{ended:?}");
    let ended = board.settings(&["get", "--format", "json"]);
    let json: serde_json::Value = serde_json::from_str(&ended.stdout).unwrap();
    assert_eq!((&json["pulse-us"], &json["max-speed"]), (&3.into(), &1_000_000.into()));
    board.settings(&["get", "idle-ms", "--format", "json"]).assert(0, r#"{"idle-ms":60000}"#);
    board.settings(&["reset"]).assert(0, "all settings have their defaults");
    board.settings(&["get", "pulse-us"]).assert(0, "2");
}

/// `status` names those that differ from their defaults.
#[test]
fn status_says_what_was_set() {
    let board = Board::start();
    let status = |format| stepwright(&["status", "--format", format, "--port", &board.path]).stdout;
    assert!(!status("text").contains("settings"));
    board.settings(&["set", "switches=3", "pulse-us=2", "idle-ms=500"]);
    assert!(status("text").ends_with("settings    idle-ms=500 switches=3\n"));
    let json: serde_json::Value = serde_json::from_str(&status("json")).unwrap();
    assert_eq!(json["settings"], serde_json::json!({ "idle-ms": 500, "switches": 3 }));
}

#[test]
fn nothing_is_sent_that_is_not_allowed() {
    let board = Board::start();
    for (wrong, says) in [
        ("pulse-us=21", "1 to 20 µs"),
        ("pulse-us=fast", "1 to 20 µs"),
        ("pulse=2", "there are max-speed, max-accel"),
        ("pulse-us", "NAME=VALUE"),
    ] {
        let ended = board.settings(&["set", "hold-us=7", wrong]);
        assert_eq!(ended.code(), Some(2), "{ended:?}");
        ended.assert_error(says);
    }
    let ended = board.settings(&["get", "pulse"]);
    assert_eq!(ended.code(), Some(2), "{ended:?}");
    ended.assert_error("there is no setting \"pulse\"");
    board.settings(&["get", "hold-us"]).assert(0, "1");
}

#[test]
fn a_file_takes_settings_from_board_to_board() {
    let (one, other) = (Board::start(), Board::start());
    let file = Scratch::new("board.toml");
    one.settings(&["set", "switches=5", "timeout-ms=2000"]);
    let ended = one.settings(&["save", file.path()]);
    assert_eq!((ended.code(), ended.stdout.as_str()), (Some(0), ""), "{ended:?}");
    other.settings(&["load", file.path()]).assert(0, "2 of 27 settings changed");
    other.settings(&["get", "switches"]).assert(0, "5");
    other.settings(&["load", file.path()]).assert(0, "0 of 27 settings changed");
    let saved = other.settings(&["save", "-"]).stdout;
    let numbers = |text: &str| {
        let lines = text.lines().filter(|line| !line.starts_with('#'));
        lines.map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(numbers(&saved), numbers(&std::fs::read_to_string(&file.0).unwrap()));
}

#[test]
fn a_byte_order_mark_before_a_file_is_passed_over() {
    let (board, file) = (Board::start(), Scratch::new("marked.toml"));
    std::fs::write(&file.0, "\u{feff}hold-us = 7\n").unwrap();
    board.settings(&["load", file.path()]).assert(0, "1 of 1 settings changed");
}

/// The old file is whole until the new one is, which takes its name: who holds the old
/// one, here by a second name, finds it unchanged.
#[test]
fn a_file_is_replaced_as_a_whole() {
    use std::fs::{self, Permissions};
    use std::os::unix::fs::{PermissionsExt, symlink};
    let board = Board::start();
    let folder = Scratch::new("save");
    fs::create_dir(&folder.0).unwrap();
    let at = |name: &str| folder.0.join(name);
    let save = |name: &str| board.settings(&["save", at(name).to_str().unwrap()]);
    let mode = |name: &str| fs::metadata(at(name)).unwrap().permissions().mode() & 0o777;
    fs::write(at("mill.toml"), "old\n").unwrap();
    fs::set_permissions(at("mill.toml"), Permissions::from_mode(0o640)).unwrap();
    fs::hard_link(at("mill.toml"), at("held")).unwrap();
    symlink("mill.toml", at("link.toml")).unwrap();
    assert_eq!(save("link.toml").code(), Some(0));
    assert_eq!(fs::read_to_string(at("held")).unwrap(), "old\n");
    assert!(fs::read_to_string(at("mill.toml")).unwrap().contains("\npulse-us = 2\n"));
    assert!(at("link.toml").is_symlink());
    assert_eq!(mode("mill.toml"), 0o640);
    // One that is protected stays, and nothing is left beside it.
    fs::set_permissions(at("held"), Permissions::from_mode(0o444)).unwrap();
    save("held").assert_error("can't write");
    assert_eq!(fs::read_to_string(at("held")).unwrap(), "old\n");
    // What is said names no file beside it.
    let lost = save("nope/new.toml").stderr;
    assert!(
        lost.contains("nope/new.toml: No such file") && !lost.contains("/.stepwright-"),
        "{lost}"
    );
    // A new one is as any program would make it.
    assert_eq!(save("new.toml").code(), Some(0));
    fs::write(at("plain"), "").unwrap();
    assert_eq!(mode("new.toml"), mode("plain"));
    assert_eq!(fs::read_dir(&folder.0).unwrap().count(), 5);
    assert_eq!(board.settings(&["save", "/dev/null"]).code(), Some(0));
    board.settings(&["save", "/dev/full"]).assert_error("can't write /dev/full");
    assert!(
        fs::metadata("/dev/null").unwrap().file_type()
            != fs::metadata(at("plain")).unwrap().file_type()
    );
    fs::remove_dir_all(&folder.0).unwrap();
}

#[test]
fn a_file_of_settings_has_a_bound() {
    let board = Board::start();
    board.settings(&["load", "/dev/zero"]).assert_error("it has more than 100000 bytes");
}

#[test]
fn a_file_with_bad_lines_sets_nothing() {
    let board = Board::start();
    let file = Scratch::new("bad.toml");
    std::fs::write(&file.0, "hold-us = 9\npulse-us = 99\nnothing\nspeed = 1\n").unwrap();
    let ended = board.settings(&["load", file.path()]);
    assert_eq!(ended.code(), Some(1), "{ended:?}");
    for part in ["line 2: ", "1 to 20 µs", "line 3: ", "line 4: ", "nothing was set"] {
        assert!(ended.stderr.contains(part), "{part}: {ended:?}");
    }
    board.settings(&["get", "hold-us"]).assert(0, "1");
    let ended = board.settings(&["load", "/nowhere/at/all.toml"]);
    assert_eq!(ended.code(), Some(1), "{ended:?}");
    ended.assert_error("can't read /nowhere/at/all.toml");
}

#[test]
fn nothing_is_set_while_a_motor_moves() {
    let board = Board::start();
    assert_eq!(stepwright(&["send", "--port", &board.path, "g+"]).code(), Some(0));
    let ended = board.settings(&["set", "pulse-us=3"]);
    assert_eq!(ended.code(), Some(1), "{ended:?}");
    ended.assert_error("the board refuses $pulse-us=3");
    assert!(ended.stderr.contains("still travelling"), "{ended:?}");
    board.settings(&["get", "pulse-us"]).assert(0, "2");
}

#[test]
fn settings_ask_for_a_board() {
    for order in [&["get"][..], &["set", "pulse-us=3"], &["reset"], &["save", "-"]] {
        let ended = stepwright(&[&["settings"], order].concat());
        assert_eq!(ended.code(), Some(2), "{ended:?}");
        ended.assert_error("needs a board: --port PATH");
    }
}

#[test]
fn shells_complete_the_names() {
    let ended = stepwright(&["completions", "bash"]);
    assert!(ended.stdout.contains("switch-forward=") && ended.stdout.contains("idle-ms"));
}
