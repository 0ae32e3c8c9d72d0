//! What the README says, held against what there is: its figures, its commands and its code.

#![cfg(unix)]

use std::collections::HashMap;
use std::error::Error;
use std::fs::read_to_string;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::common::{self, Running, Scratch, stepwright, stepwright_with};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn readme() -> String {
    read_to_string(root().join("README.md")).unwrap()
}

/// The rows of the table that begins with this line, as cells.
fn table(head: &str) -> Vec<Vec<String>> {
    let readme = readme();
    let (_, rest) = readme.split_once(head).unwrap_or_else(|| panic!("no table {head:?}"));
    let rows = rest.lines().skip(2).take_while(|line| line.starts_with('|'));
    let cells = |row: &str| row.trim_matches('|').split('|').map(|c| c.trim().to_owned()).collect();
    rows.map(cells).collect()
}

/// The lines of all blocks of code, without those that are marked with a language.
fn blocks() -> Vec<Vec<String>> {
    let (mut blocks, mut open) = (Vec::new(), None::<(bool, Vec<String>)>);
    for line in readme().lines() {
        open = match (open, line.strip_prefix("```")) {
            (None, Some(language)) => Some((language.is_empty(), Vec::new())),
            (Some((plain, lines)), Some(_)) => {
                if plain {
                    blocks.push(lines);
                }
                None
            }
            (Some((plain, mut lines)), None) => {
                lines.push(line.to_owned());
                Some((plain, lines))
            }
            (None, None) => None,
        };
    }
    blocks
}

/// The first number of a text: `**116,927 steps/s**`, `1.30`.
fn number(text: &str) -> Option<f64> {
    let from = text.find(|c: char| c.is_ascii_digit())?;
    let digits = text[from..].chars().take_while(|c| c.is_ascii_digit() || ",.".contains(*c));
    digits.filter(|c| *c != ',').collect::<String>().trim_end_matches('.').parse().ok()
}

// ---- Figures ----

/// A row of the README, and what it is called in `bench/avr.json`.
const FIGURES: [(&str, &str, u64, &str); 13] = [
    ("1 axis, ramps planned on the chip", "rate_ramps", 1, "queued"),
    ("2 axes, each", "rate_ramps", 2, "queued"),
    ("3 axes, each", "rate_ramps", 3, "queued"),
    ("3 axes at constant speed, each", "rate_constant", 3, "queued"),
    ("one step by itself", "isolated", 1, "queued"),
    ("… behind another, constant speed", "back_to_back_constant", 1, "queued"),
    ("a step of a motor cycle, 3 motors at once", "cycle_step", 3, "cycle"),
    ("longest piece of planning", "planning_burst", 3, "queued"),
    ("RMS error of the intervals", "interval_rms", 1, "queued"),
    ("acceleration, peak over nominal", "accel_peak", 1, "queued"),
    ("… by the deadlines", "accel_peak_deadlines", 1, "queued"),
    ("flash, everything on", "flash", 3, "queued"),
    ("RAM", "ram", 3, "queued"),
];

/// The table of figures is the stored measurement, which `cargo xtask bench avr --check`
/// holds against the firmware; and an aim is missed where it says so.
#[test]
fn its_figures_are_the_measured_ones() {
    let stored = read_to_string(root().join("bench/avr.json")).unwrap();
    let stored: serde_json::Value = serde_json::from_str(&stored).unwrap();
    let stored: HashMap<_, _> = stored
        .as_array()
        .unwrap()
        .iter()
        .map(|row| {
            let key = (row["name"].as_str().unwrap(), row["axes"].as_u64(), row["feed"].as_str());
            (key, row["value"].as_f64().unwrap())
        })
        .collect();
    let rows = table("| | Stepwright | best peer | aim |");
    assert_eq!(rows.len(), FIGURES.len());
    let mut wrong = Vec::new();
    for (row, (label, name, axes, feed)) in rows.iter().zip(FIGURES) {
        assert_eq!(row[0], label);
        let measured = stored[&(name, Some(axes), Some(feed))];
        let said = number(&row[1]).unwrap();
        // To as many decimals as it is said with.
        let text = row[1].trim_start_matches('*').split([' ', '*']).next().unwrap();
        let decimals = text.split_once('.').map_or(0, |(_, decimals)| decimals.len());
        let rounded: f64 = format!("{measured:.decimals$}").parse().unwrap();
        if said != rounded {
            wrong.push(format!("{label}: {said}, and {rounded} in bench/avr.json"));
        }
        let Some(aim) = number(&row[3]) else { continue };
        let missed = if name.starts_with("rate") { measured < aim } else { measured > aim };
        if missed != row[3].contains("missed") {
            wrong.push(format!("{label}: {measured} and the aim {}", row[3]));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// `The board refuses orders beyond …`: exactly beyond.
#[test]
fn its_highest_speeds_are_those_that_are_admitted() {
    let readme = readme();
    let (_, rest) = readme.split_once("The board refuses orders beyond ").unwrap();
    let inside = rest.split_once(". ").unwrap().0;
    // `128,000 steps/s`, `one axis, 43,478 each`, `two, 21,248 each`, `three`.
    let speeds: Vec<_> = inside.split("for ").map(number).collect();
    for (axes, speed) in (1..).zip(&speeds[..3]) {
        let speed = speed.unwrap() as u32;
        assert!(admits(2, axes, speed) && !admits(2, axes, speed + 1), "{axes} at {speed}");
    }
    // Beside slow axes.
    let (_, rest) = readme.split_once("the fastest may reach ").unwrap();
    for (axes, speed) in (2..).zip(rest.split("beside ").take(2).map(number)) {
        let speed = speed.unwrap() as u32;
        let goes = |fastest| {
            takes(2, axes, &|axis| {
                let speed = if axis == 1 { fastest } else { 100 };
                format!("s{speed}\rt{speed}\rG+9\r")
            })
        };
        assert!(goes(speed) && !goes(speed + 1), "{axes} at {speed}");
    }
    // With a longer pulse, to two figures.
    let (_, rest) = readme.split_once("With pulses from ").unwrap();
    let pulse = number(rest).unwrap() as u32;
    let (_, rest) = rest.split_once("axes reach ").unwrap();
    for (axes, speed) in (1..).zip(rest.split(" steps/s").next().unwrap().split(", ")) {
        let speed = number(speed).unwrap() as u32;
        let above = speed + speed / 40;
        assert!(admits(pulse, axes, speed) && !admits(pulse, axes, above), "{axes} at {speed}");
    }
}

/// `A ramp of four or more steps may have some …`: at every top speed, and hardly more.
#[test]
fn its_steepest_ramps_are_those_that_are_admitted() {
    let readme = readme();
    let (_, rest) = readme.split_once("A ramp of four or more steps\nmay have some ").unwrap();
    let highest = [128_000u32, 43_478, 21_248];
    for ((axes, accel), highest) in (1..).zip(rest.split(", ").map(number)).zip(highest) {
        let accel = accel.unwrap() as u32;
        let goes = |accel: u32, top: u32| {
            takes(2, axes, &|_| format!("s0\rt{top}\ra{accel}\rd{accel}\rG+90000\r"))
        };
        // The speed behind four steps, and from there up to the highest.
        let least = (8.0 * f64::from(accel)).sqrt().ceil() as u32;
        for part in 0..=12 {
            let top = least + (highest - least) * part / 12;
            assert!(goes(accel - accel / 40, top), "{axes} axes to {top}");
        }
        assert!(!goes(accel + accel / 20, highest), "{axes} axes");
    }
}

/// Whether a board takes an order for axes of this speed, with pulses of this many µs.
fn admits(pulse: u32, axes: usize, top: u32) -> bool {
    takes(pulse, axes, &|_| format!("s{top}\rt{top}\rG+9\r"))
}

/// Whether a board takes an order whose lines for each axis are these.
fn takes(pulse: u32, axes: usize, lines: &dyn Fn(usize) -> String) -> bool {
    let mut script = format!("$pulse-us={pulse}\rPO\r");
    for axis in 1..=axes {
        script += &format!("A{axis}\r{}", lines(axis));
    }
    let count = script.matches('\r').count();
    script += "E\r";
    let ended = stepwright_with(&["board", "--stdio", "--fast"], script.as_bytes());
    let answers: Vec<_> = ended.stdout.split('\r').collect();
    assert!(answers[..count].iter().all(|answer| *answer == "Y"), "{script:?}: {}", ended.stdout);
    answers[count] == "Y"
}

// ---- Commands ----

/// What the first command answers stands there to the letter.
#[test]
fn its_first_command_says_what_it_shows() {
    let blocks = blocks();
    let shown = blocks.iter().find(|block| block[0].starts_with("axis 1 by +4000")).unwrap();
    let ended = stepwright(&["move", "4000", "--fast"]);
    assert_eq!(ended.stdout.lines().collect::<Vec<_>>(), *shown);
}

/// Every command of it works: on a virtual board, or on one behind a pseudo-terminal.
#[test]
fn its_commands_work() {
    let mut board = Running::start(&["board", "--pty"]);
    let port = board.wait_out("").strip_prefix("pty ").expect("the first line").to_owned();
    let folder = Scratch::new("readme");
    std::fs::create_dir(folder.path()).unwrap();
    let mut tried = 0;
    for line in blocks().concat() {
        let line = line.trim_start_matches("$ ").split("  #").next().unwrap().trim().to_owned();
        let Some(line) = line.strip_prefix("stepwright ") else { continue };
        let mut words: Vec<_> = line.split_whitespace().map(str::to_owned).collect();
        match (&*words[0], words.iter().position(|word| word == "--port")) {
            // Tests of their own: it waits for a program, for a switch, for keys,
            // for a boot loader, for a browser, for a chip.
            ("board" | "home" | "jog" | "flash" | "serve" | "selftest", _) => continue,
            (_, Some(at)) => words[at + 1] = port.clone(),
            ("move" | "run" | "line", None) => words.push("--fast".to_owned()),
            _ => {}
        }
        let output = Command::new(common::program())
            .args(&words)
            .current_dir(folder.path())
            .output()
            .unwrap();
        assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
        tried += 1;
    }
    assert!(tried > 12, "{tried}");
    std::fs::remove_dir_all(folder.path()).unwrap();
    board.signal(rustix::process::Signal::INT);
    board.end();
}

/// `printf … | stepwright board --stdio --fast`, and every line that the paragraph names.
#[test]
fn its_lines_are_those_of_the_protocol() {
    let readme = readme();
    let (_, rest) = readme.split_once("$ printf '").unwrap();
    let script = rest.split_once('\'').unwrap().0.replace("\\r", "\r");
    assert!(rest.contains("| stepwright board --stdio --fast"));
    let ended = stepwright_with(&["board", "--stdio", "--fast"], script.as_bytes());
    assert!(ended.stdout.starts_with("Y\rY\rY\rY\rY\rY\r"), "{}", ended.stdout);
    let more = "F\rV1\rZ\rK\rI1\rg+\rK\rI1\rA2\rs5\rt50\ra500\rd500\r?\r$\rA1\rPO\rG+4000*0B\r";
    let ended = stepwright_with(&["board", "--stdio", "--fast"], more.as_bytes());
    let answers: Vec<_> = ended.stdout.split('\r').collect();
    assert_eq!(answers[..13].join(" "), "R 0 Y Y Y Y Y Y Y Y Y Y Y", "{}", ended.stdout);
    assert!(answers[13].starts_with("stepwright 0.1 ") && answers[14].starts_with("max-speed="));
    assert_eq!(answers[15..18], ["Y", "Y", "Y*88"]);
}

/// It is linked with nothing but what every program of the system is.
#[test]
#[cfg(target_os = "linux")]
fn the_command_needs_no_system_library() {
    let Ok(output) = Command::new("ldd").arg(common::program()).output() else {
        panic!("ldd tells what a program is linked with, and is part of the C library");
    };
    let listed = String::from_utf8_lossy(&output.stdout).into_owned();
    let names = listed.lines().filter_map(|line| line.split_whitespace().next());
    let known = ["linux-vdso", "libgcc_s", "libc.", "libm.", "libpthread", "libdl", "librt", "ld-"];
    for name in names {
        let name = name.rsplit('/').next().unwrap();
        assert!(known.iter().any(|known| name.starts_with(known)), "{name}");
    }
    assert!(listed.contains("libc."), "{listed}");
}

// ---- Code and links ----

#[allow(clippy::never_loop, unused_variables)]
mod library {
    use super::*;

    pub fn example() -> Result<(), Box<dyn Error>> {
        use stepwright::{Accel, Rate, Speed, profile::Trapezoid};

        let law = Trapezoid::new(
            Rate::of::<16_000_000>(),
            Speed::ZERO,
            Speed::of::<4_000>(),
            Accel::of::<10_000>(),
        );
        for delay in law.delays(4000)? {
            // ticks until the next step
        }
        Ok(())
    }
}

/// The blocks of Rust, line by line, without their indentation.
fn rust() -> Vec<Vec<String>> {
    let readme = readme();
    let blocks = readme.split("```rust\n").skip(1);
    blocks.map(|rest| lines(rest.split_once("```").unwrap().0)).collect()
}

fn lines(text: &str) -> Vec<String> {
    text.trim().lines().map(|line| line.trim().to_owned()).collect()
}

/// Its first code, of at most 20 lines, is a program of the firmware, whose edges a test on
/// the simulated chip judges; the second is an example that is run; the third is the function
/// above, which compiles and runs.
#[test]
fn its_code_compiles() {
    library::example().unwrap();
    let [chip, board, law] = rust().try_into().unwrap();
    let file = |path: &str| lines(&read_to_string(root().join(path)).unwrap());
    assert_eq!(chip, file("firmware/avr/examples/first_move.rs"));
    assert!(chip.len() <= 20, "{} lines", chip.len());
    for (code, path) in [
        (board, "crates/stepwright-sim/examples/04_virtual_board.rs"),
        (law, "crates/stepwright-cli/tests/readme.rs"),
    ] {
        let there = file(path);
        assert!(there.windows(code.len()).any(|part| part == code), "{path}: {code:#?}");
    }
}

/// Every file that ARCHITECTURE.md names with its folder is there.
#[test]
fn the_architecture_names_files_that_are_there() {
    let architecture = read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    let words: Vec<_> = architecture.split('`').skip(1).step_by(2).collect();
    let begins = ["stepwright", "firmware/", "xtask/"];
    let paths = words.iter().filter(|word| {
        word.contains('/') && !word.contains(' ') && begins.iter().any(|b| word.starts_with(b))
    });
    let mut seen = 0;
    for path in paths {
        let there = [root(), root().join("crates")].iter().any(|top| top.join(path).exists());
        assert!(there, "{path}");
        seen += 1;
    }
    assert!(seen > 30, "{seen}");
}

/// Every file that `docs/promises.md` names is there and has a test, and every function is there.
#[test]
fn its_promises_name_tests_that_are_there() {
    let mut sources = Vec::new();
    for folder in
        ["crates", "firmware/rig", "firmware/qemu", "firmware/rp2040", "python", "xtask/src"]
    {
        collect(&root().join(folder), &mut sources);
    }
    let promises = read_to_string(root().join("docs/promises.md")).unwrap();
    let rows = promises.lines().filter_map(|line| line.strip_prefix('|')?.split('|').nth(1));
    let names: Vec<_> = rows.flat_map(|cell| cell.split('`').skip(1).step_by(2)).collect();
    assert!(names.len() > 100, "{}", names.len());
    for name in names {
        let is_file = CODE.iter().any(|end| name.ends_with(end));
        let there = |(path, text): &(String, String)| match is_file {
            true => path.ends_with(&format!("/{name}")) && is_test(path, text),
            // `a_line_shows…`: one that begins so.
            false => text.contains(&format!("fn {}", name.trim_end_matches('…'))),
        };
        let is_word = is_file || name.contains('_') && !name.contains(['/', ' ']);
        assert!(!is_word || sources.iter().any(there), "{name}");
    }
}

/// The ends of the names of sources.
const CODE: [&str; 4] = [".rs", ".py", ".mjs", ".cjs"];

/// Whether a file is a test, or has one.
fn is_test(path: &str, text: &str) -> bool {
    path.contains("/tests/") || path.contains("/test/") || text.contains("#[test]")
}

/// The sources below a folder, with their text.
fn collect(folder: &Path, sources: &mut Vec<(String, String)>) {
    for entry in folder.read_dir().unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() && !path.ends_with("target") {
            collect(&path, sources);
        } else if CODE.iter().any(|end| path.to_string_lossy().ends_with(end)) {
            sources.push((path.to_string_lossy().into_owned(), read_to_string(&path).unwrap()));
        }
    }
}
