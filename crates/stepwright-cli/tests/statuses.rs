//! The guide's page of exit statuses: each of its commands ends as it says.
#![cfg(unix)]

use std::path::Path;
use std::process::Command;

use crate::common::{self, Running};
use rustix::process::Signal;

fn page() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/guide/src/exit-statuses.md");
    std::fs::read_to_string(path).unwrap()
}

/// A row of the page's second table: a command, whether Ctrl-C ends it, and its status.
struct Row {
    words: Vec<String>,
    ctrl_c: bool,
    status: i32,
}

fn rows(page: &str) -> Vec<Row> {
    let row = |line: &str| {
        let (command, rest) = line.strip_prefix("| `stepwright ")?.split_once('`')?;
        let mut cells = rest.split('|').map(str::trim);
        let ctrl_c = match cells.next()? {
            "" => false,
            ", Ctrl-C" => true,
            other => panic!("what is {other:?} in {line}?"),
        };
        let status = cells.next()?.parse().unwrap_or_else(|_| panic!("{line}"));
        let words = command.split(' ').map(str::to_owned).collect();
        Some(Row { words, ctrl_c, status })
    };
    page.lines().filter_map(row).collect()
}

/// The command without a machine file, in a folder where nothing is.
fn start(words: &[String]) -> Running {
    let mut command = Command::new(common::program());
    command.args(words).env("STEPWRIGHT_MACHINE", "none").current_dir(env!("CARGO_TARGET_TMPDIR"));
    Running::of(&mut command)
}

#[test]
fn each_command_of_the_page_ends_with_its_status() {
    let rows = rows(&page());
    for Row { words, ctrl_c, status } in &rows {
        let mut running = start(words);
        if *ctrl_c {
            // It is at work once it says so.
            match words[0].as_str() {
                "board" => drop(running.wait_out("pty ")),
                _ => drop(running.wait_err("position ")),
            }
            running.signal(Signal::INT);
        }
        let ended = running.end();
        assert_eq!(ended.code(), Some(*status), "{words:?}: {ended:?}");
        if matches!(status, 1 | 2) {
            assert!(ended.stderr.lines().any(|line| line.starts_with("error: ")), "{ended:?}");
        }
    }
    for status in [0, 1, 2, 130] {
        let examples = rows.iter().filter(|row| row.status == status).count();
        assert!(examples > 1, "{examples} examples of {status}");
    }
}

/// What the page's first table says is what the help does, and no status is missing there.
#[test]
fn the_rule_is_that_of_the_help() {
    let help = common::stepwright(&["--help"]).stdout;
    let (_, rule) = help.split_once("Exit status:\n").unwrap();
    let in_help: Vec<_> = (rule.lines())
        .filter_map(|line| line.strip_prefix("  ")?.split_whitespace().next()?.parse::<u8>().ok())
        .collect();
    let page = page();
    let in_page: Vec<_> = (page.lines())
        .filter_map(|line| line.strip_prefix("| ")?.split_once(" |")?.0.parse::<u8>().ok())
        .collect();
    assert_eq!((&in_page, &in_help), (&vec![0, 1, 2, 130], &in_page));
}

#[test]
fn the_failure_for_programs_is_the_one_shown() {
    let page = page();
    let shown = page.split("```json\n").nth(1).unwrap().split("```").next().unwrap();
    let words = "move 400 --axis 4 --fast --format json";
    assert!(page.contains(&format!("`stepwright {words}`")));
    let words: Vec<_> = words.split(' ').map(str::to_owned).collect();
    let ended = start(&words).end();
    assert_eq!(ended.stderr.lines().last(), shown.lines().last(), "{ended:?}");
}
