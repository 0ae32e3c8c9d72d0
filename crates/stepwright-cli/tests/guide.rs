//! The guide's commands work, page by page, and say what it shows.
#![cfg(unix)]

mod common;

use std::fs::{self, read_to_string};
use std::path::{Path, PathBuf};
use std::process::Command;

use common::{Running, Scratch};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/guide/src")
}

/// A block of code: its language, and its lines.
type Block = (String, Vec<String>);

/// The blocks of a page, also those that are indented in a list.
fn blocks(page: &str) -> Vec<Block> {
    let (mut blocks, mut open) = (Vec::new(), None::<Block>);
    for line in page.lines() {
        open = match (open, line.trim_start().strip_prefix("```")) {
            (None, Some(language)) => Some((language.to_owned(), Vec::new())),
            (Some(block), Some(_)) => {
                blocks.push(block);
                None
            }
            (Some((language, mut lines)), None) => {
                lines.push(line.trim_end().to_owned());
                Some((language, lines))
            }
            (None, None) => None,
        };
    }
    assert!(open.is_none(), "a block without an end");
    blocks
}

/// Plays a page in a folder of its own, with a board behind its port; how many commands.
fn play(page: &Path) -> usize {
    let mut board = Running::start(&["board", "--pty", "--switch", "1:-300"]);
    let port = board.wait_out("").strip_prefix("pty ").expect("the first line").to_owned();
    let name = page.file_stem().unwrap().to_str().unwrap();
    let folder = Scratch::new(&format!("guide-{name}"));
    fs::create_dir(folder.path()).unwrap();
    let (mut said, mut tried) = (String::new(), 0);
    for (language, lines) in blocks(&read_to_string(page).unwrap()) {
        match &*language {
            "sh" => {
                for line in lines {
                    said = command(&line, &port, folder.path());
                    tried += 1;
                }
            }
            // What the last command says, to the letter.
            "text" => assert_eq!(said.lines().collect::<Vec<_>>(), lines, "{name}"),
            // A file that a command of the page has written.
            "toml" => {
                let file = read_to_string(folder.0.join("stepwright.toml")).unwrap();
                assert_eq!(file.lines().collect::<Vec<_>>(), lines, "{name}");
            }
            "" | "python" => {}
            other => panic!("{name}: what is {other}?"),
        }
    }
    fs::remove_dir_all(folder.path()).unwrap();
    board.signal(rustix::process::Signal::INT);
    board.end();
    tried
}

/// Runs a command in a folder; what it says.
fn command(line: &str, port: &str, folder: &str) -> String {
    let words = line.trim().strip_prefix("stepwright ").unwrap_or_else(|| panic!("{line}"));
    let mut words: Vec<_> = words.split_whitespace().collect();
    if let Some(at) = words.iter().position(|word| *word == "--port") {
        words[at + 1] = port;
    }
    let output = Command::new(env!("CARGO_BIN_EXE_stepwright"))
        .args(words)
        .current_dir(folder)
        .env_remove("STEPWRIGHT_MACHINE")
        .env("XDG_CONFIG_HOME", folder)
        .output()
        .unwrap();
    assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn every_page_is_in_the_summary_and_its_commands_work() {
    let summary = read_to_string(folder().join("SUMMARY.md")).unwrap();
    let mut tried = 0;
    for entry in folder().read_dir().unwrap() {
        let page = entry.unwrap().path();
        let name = page.file_name().unwrap().to_str().unwrap().to_owned();
        if name == "SUMMARY.md" {
            continue;
        }
        assert!(summary.contains(&format!("]({name})")), "{name} is not in the summary");
        tried += play(&page);
    }
    assert!(tried > 25, "{tried}");
}

/// Python's example does what it says.
#[test]
fn the_lines_of_the_python_page_are_answered_as_it_says() {
    let page = read_to_string(folder().join("python.md")).unwrap();
    let list = page.split("for line in [").nth(1).unwrap().split(']').next().unwrap();
    let lines: Vec<_> = list.split(", ").map(|line| line.trim_matches('"')).collect();
    let script = lines.iter().map(|line| format!("{line}\r")).collect::<String>();
    let ended =
        common::stepwright_with(&["board", "--stdio", "--fast"], format!("{script}F\r").as_bytes());
    assert_eq!(ended.stdout, format!("{}B\r", "Y\r".repeat(lines.len())));
    assert!(ended.stderr.contains("position 4000 ready"), "{ended:#?}");
}
