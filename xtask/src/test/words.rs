//! Checks the style: one name for one thing, plain words, short files.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

use crate::workspace::Workspace;

/// Words and phrases that are hard to read, and plain ones. A word stands for all that begin with
/// it.
const WORDS: &[(&str, &str)] = &[
    ("reckon", "compute"),
    ("gather", "accumulate"),
    ("anew", "again"),
    ("heed", "obey, check"),
    ("so many", "n, this many"),
    ("lay out", "set up, arrange"),
    ("lays out", "sets up, arranges"),
    ("laid out", "set up, arranged"),
    ("laying out", "setting up, arranging"),
    ("gone on with", "continued"),
    ("in vain", "without success"),
    ("for so long", "for this time"),
    ("after so long", "after this time"),
    ("so far forward", "this far forward"),
    ("so far backward", "this far backward"),
    ("can so much", "has these features"),
    ("document 00", "the title of the document: docs/sources.md"),
];

/// Public types of the libraries that share a name on purpose, and why.
const PAIRS: &[(&str, &str)] = &[
    ("AvrEngine", "on an AVR, what moves the motors: in each module that does, in its own way"),
    ("About", "what a program on a board says of itself; what a key of a machine file is about"),
    ("Arc", "of a path in steps; of G-code, in a plane of the machine"),
    ("AsyncAxis", "of a board from a PC, of motors on a chip: the same words"),
    ("Axis", "of `Steppers` on a chip, and of a board from a PC: the same words"),
    ("Board", "what the core knows of it; a board from a PC"),
    (
        "Change",
        "of a motion in the core; of a motor's lines on the virtual board; by another program",
    ),
    ("Clock", "of a motor cycle; the milliseconds of an AVR"),
    (
        "Control",
        "the engine's handle in the core; the control byte of the Arduino driver's document",
    ),
    ("Curve", "Austin's trait of a ramp stands for what the S-curve is in the core"),
    ("Eeprom", "of a chip; of the virtual board"),
    ("Error", "of a board from a PC; of a line of G-code"),
    ("Fault", "why a program on a board refuses a line; what is wrong with a line of G-code"),
    ("Law", "delays from delays in Austin's crate; time from distance on a path"),
    ("Levels", "the pins of an Uno; those of a Mega"),
    ("Line", "a piece of a path; a line of the timed driver's serial protocol"),
    ("Machine", "what a slave orders to move; what stands in a machine file"),
    ("Mark", "of a step on a path; what RAM remembers over a reset"),
    ("Motor", "of a motor cycle; on an AVR also one of the timed driver, and one that a law moves"),
    ("MotorIo", "what motor cycles ask of their board, and an AVR's"),
    ("NotHomed", "why an axis is not homed: by a switch from a PC, by a stall on a chip"),
    ("Order", "a move as the core takes it; the same as the serial line can carry it"),
    ("Motors", "those of an executor's tasks; on an AVR those of motor cycles"),
    ("Move", "of a cycle file's motor; of a machine's axes, by G-code"),
    ("Outcome", "what became of an order from a PC, of a move on a chip: the same words"),
    ("Pace", "how fast a cycle's leg, a path and the timed driver's motor go"),
    ("Pins", "of a drive; of an Uno, of a Mega; of any port of an AVR"),
    ("Probe", "a value under the mouse in a plot; what ends a move of G-code"),
    ("Ramp", "of the core, of the serial line, of Austin's crate: from one speed to another"),
    ("Report", "what the engine says of its axes; what a board with the timed driver says"),
    ("RampSteps", "a ramp's length as the line carries it; a profile whose ramps have it"),
    ("Refusal", "each crate's reasons to refuse: a move, a line, a cycle"),
    ("Scale", "of fixed-point slopes; from values to pixels of a plot"),
    ("Status", "of a cycle's motor; the status byte of the Arduino driver's document"),
    ("Steppers", "motors; on an AVR those of the CNC shield"),
    ("Steps", "of a run; of a path"),
    ("Timer", "the step timer of an AVR; any of its timers"),
    ("Travel", "how far an order goes, in the core and on the line; a way of Austin's ramps"),
];

/// The most lines of a source file.
const LONGEST: usize = 600;

/// Runs all checks before the verdict.
pub fn run(ws: &Workspace) -> Result<()> {
    let mut files = Vec::new();
    for folder in ["crates", "docs", "examples", "firmware", "python", "xtask"] {
        collect(&ws.root.join(folder), &mut files)?;
    }
    for entry in fs::read_dir(&ws.root)? {
        files.push(entry?.path());
    }
    let mut faults = Vec::new();
    let mut types: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for file in files {
        let name = file.strip_prefix(&ws.root).unwrap_or(&file).display().to_string();
        let code = match file.extension().and_then(|extension| extension.to_str()) {
            Some("rs") => true,
            Some("md") => false,
            _ => continue,
        };
        let text = fs::read_to_string(&file).with_context(|| name.clone())?;
        // This file has all these words in its table.
        if !name.ends_with("test/words.rs") {
            faults.extend(words(&text, code).into_iter().map(|fault| format!("{name}:{fault}")));
        }
        let lines = text.lines().count();
        if code && lines > LONGEST {
            faults.push(format!("{name}: {lines} lines, of at most {LONGEST}: split it"));
        }
        if code && is_library(&ws.root, &name) {
            for public in public_types(&text) {
                types.entry(public.to_owned()).or_default().push(name.clone());
            }
        }
    }
    faults.extend(names(&types, PAIRS));
    for fault in &faults {
        println!("{fault}");
    }
    if faults.is_empty() { Ok(()) } else { bail!("{} faults of style", faults.len()) }
}

/// Collects the files under a folder, except build outputs.
fn collect(folder: &Path, files: &mut Vec<PathBuf>) -> Result<()> {
    for entry in fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        if !path.is_dir() {
            files.push(path);
        } else if !path.ends_with("target") && !path.ends_with("node_modules") {
            collect(&path, files)?;
        }
    }
    Ok(())
}

/// Whether this file is part of a library for users.
fn is_library(root: &Path, name: &str) -> bool {
    let mut parts = name.split('/');
    let (Some("crates"), Some(own), Some("src")) = (parts.next(), parts.next(), parts.next())
    else {
        return false;
    };
    let src = root.join("crates").join(own).join("src");
    // `stepwright-stress` is a tool of the tests.
    own != "stepwright-stress" && src.join("lib.rs").exists()
}

/// The lines with a word of the list: in prose, which is the comments in code.
fn words(text: &str, code: bool) -> Vec<String> {
    let mut faults = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        let prose = match line.find("//") {
            _ if !code => line,
            Some(at) => &line[at..],
            None => continue,
        };
        let prose = prose.to_lowercase();
        for (word, plain) in WORDS {
            let found = prose
                .match_indices(word)
                .any(|(at, _)| !prose[..at].chars().next_back().is_some_and(char::is_alphanumeric));
            if found {
                faults.push(format!("{number}: \"{word}\": write {plain}"));
            }
        }
    }
    faults
}

/// The types that a file declares `pub`.
fn public_types(text: &str) -> impl Iterator<Item = &str> {
    text.lines().filter_map(|line| {
        let (kind, rest) = line.strip_prefix("pub ")?.split_once(' ')?;
        let is_type = ["struct", "enum", "trait", "type", "union"].contains(&kind);
        let end = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
        is_type.then(|| &rest[..end])
    })
}

/// Names that occur twice without a reason, and reasons for names that don't.
fn names(types: &BTreeMap<String, Vec<String>>, pairs: &[(&str, &str)]) -> Vec<String> {
    let is_paired = |name: &str| pairs.iter().any(|(pair, _)| *pair == name);
    let twice = types.iter().filter(|(name, files)| files.len() > 1 && !is_paired(name));
    let unused = pairs.iter().filter(|(name, _)| types.get(*name).is_none_or(|f| f.len() < 2));
    twice
        .map(|(name, files)| format!("{name}: a public type in {}", files.join(" and ")))
        .chain(unused.map(|(name, _)| format!("{name}: no longer twice: take it from PAIRS")))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_found_in_prose_alone() {
        assert_eq!(words("It is laid out.\nUnheeded.", false).len(), 1);
        assert_eq!(words("let anew = 1;\n/// Reckoned anew.", true).len(), 2);
        assert_eq!(words("Gathers errors", false), ["1: \"gather\": write accumulate"]);
    }

    #[test]
    fn a_type_that_stands_twice_needs_a_reason() {
        let found: Vec<_> = public_types(
            "pub struct A<T>(T);\npub(crate) struct B;\n    pub enum C {}\npub trait D {",
        )
        .collect();
        assert_eq!(found, ["A", "D"]);
        let types = BTreeMap::from([
            ("A".to_owned(), vec!["x".to_owned(), "y".to_owned()]),
            ("D".to_owned(), vec!["x".to_owned()]),
        ]);
        assert_eq!(names(&types, &[]), ["A: a public type in x and y"]);
        assert_eq!(names(&types, &[("A", "why")]), Vec::<String>::new());
        assert_eq!(names(&types, &[("A", "why"), ("D", "why")]).len(), 1);
    }
}
