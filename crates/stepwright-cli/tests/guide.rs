//! The guide's commands work, page by page, and say what it shows.
#![cfg(unix)]

mod common;

use std::fs::{self, read_to_string};
use std::path::{Path, PathBuf};
use std::process::Command;

use common::{Running, Scratch};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

fn folder() -> PathBuf {
    root().join("docs/guide/src")
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

/// Blocks that are not commands of `stepwright` alone, and where they are tried.
const ELSEWHERE: &[(&str, &str)] = &[
    ("cargo install --path crates/stepwright-cli", "the step `package`"),
    ("python3 -m pip install ./python", "the step `python`"),
    ("stepwright board --pty", "each page has one behind its port"),
    ("cargo xtask sim uno", "the step `uno`"),
    ("stepwright jog --port /dev/ttyUSB0 --step 0.1mm", "it asks for a terminal: `jog.rs`"),
    ("cargo xtask sim uno --program first-move", "the rig's test `first_move`"),
    ("cargo xtask flash uno --program first-move --port /dev/ttyACM0", "it asks for a board"),
    ("cargo run -p stepwright-sim --example 07_your_own_board", "the step `examples`"),
];

/// The board behind the port of a page: a virtual one, or the simulator that
/// `STEPWRIGHT_GUIDE_SIM` names.
fn board() -> Running {
    match std::env::var_os("STEPWRIGHT_GUIDE_SIM") {
        Some(sim) => Running::of(Command::new(sim).args(["uno", "--switch", "1:-300"])),
        None => Running::start(&["board", "--pty", "--switch", "1:-300"]),
    }
}

/// Plays a page in a folder of its own, with a board behind its port; how many commands.
fn play(page: &Path) -> usize {
    let mut board = board();
    let port = board.wait_out("").strip_prefix("pty ").expect("the first line").to_owned();
    let name = page.file_stem().unwrap().to_str().unwrap();
    let folder = Scratch::new(&format!("guide-{name}"));
    fs::create_dir(folder.path()).unwrap();
    std::os::unix::fs::symlink(root().join("examples"), folder.0.join("examples")).unwrap();
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
            "" => {
                for line in lines {
                    let known = ELSEWHERE.iter().any(|(command, _)| *command == line);
                    assert!(known, "{name}: nothing tries {line}: name its block `sh`");
                }
            }
            "rust" => assert!(is_excerpt(&lines), "{name}: in no program: {lines:#?}"),
            // The next test, the steps `pyserial` and `python`; wires; `statuses.rs`.
            "python" | "drawing" | "json" => {}
            other => panic!("{name}: what is {other}?"),
        }
    }
    fs::remove_dir_all(folder.path()).unwrap();
    board.signal(rustix::process::Signal::INT);
    board.end();
    tried
}

/// Whether these lines follow one another in an example or a program of the firmware, which
/// others compile.
fn is_excerpt(lines: &[String]) -> bool {
    let mut folders = vec![root().join("firmware/avr/src"), root().join("firmware/avr/examples")];
    folders.extend(
        ["stepwright", "stepwright-sim"]
            .map(|own| root().join("crates").join(own).join("examples")),
    );
    while let Some(folder) = folders.pop() {
        for entry in folder.read_dir().into_iter().flatten() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let file = read_to_string(&path).unwrap();
                let file: Vec<_> = file.lines().map(str::trim).collect();
                if file
                    .windows(lines.len())
                    .any(|part| part.iter().zip(lines).all(|(there, here)| *there == here.trim()))
                {
                    return true;
                }
            }
        }
    }
    false
}

/// Runs a command in a folder; what it says.
fn command(line: &str, port: &str, folder: &str) -> String {
    let words = line.trim().strip_prefix("stepwright ").unwrap_or_else(|| panic!("{line}"));
    let mut words: Vec<_> = words.split_whitespace().collect();
    if let Some(at) = words.iter().position(|word| *word == "--port") {
        words[at + 1] = port;
    }
    let output = Command::new(common::program())
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

/// The commands in the sentences are there, and so are their options.
#[test]
fn the_commands_in_its_sentences_are_there() {
    let mut seen = 0;
    for entry in folder().read_dir().unwrap() {
        let page = read_to_string(entry.unwrap().path()).unwrap();
        let prose = page.split("```").step_by(2).collect::<String>();
        for code in prose.split('`').skip(1).step_by(2) {
            let Some(rest) = code.strip_prefix("stepwright ") else { continue };
            let words: Vec<_> = rest.split_whitespace().collect();
            let plain = |word: &&&str| word.chars().all(|c| c.is_ascii_lowercase());
            let nested = ["calc", "plan"].contains(&words[0]);
            let at = usize::from(nested && words.get(1).filter(plain).is_some());
            let ended = common::stepwright(&[&words[..=at], &["--help"]].concat());
            assert_eq!(ended.code(), Some(0), "{code}: {ended:#?}");
            for option in words.iter().filter(|word| word.starts_with("--")) {
                assert!(ended.stdout.contains(*option), "{code}: no {option}");
            }
            seen += 1;
        }
    }
    assert!(seen > 10, "{seen}");
}

/// The example of the serial line does what it says.
#[test]
fn the_lines_of_the_serial_page_are_answered_as_it_says() {
    let page = read_to_string(folder().join("serial-line.md")).unwrap();
    let list = page.split("for line in [").nth(1).unwrap().split(']').next().unwrap();
    let lines: Vec<_> = list.split(", ").map(|line| line.trim_matches('"')).collect();
    let script = lines.iter().map(|line| format!("{line}\r")).collect::<String>();
    let ended =
        common::stepwright_with(&["board", "--stdio", "--fast"], format!("{script}F\r").as_bytes());
    assert_eq!(ended.stdout, format!("{}B\r", "Y\r".repeat(lines.len())));
    assert!(ended.stderr.contains("position 4000 ready"), "{ended:#?}");
}
