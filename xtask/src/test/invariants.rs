//! Checks the invariants of ARCHITECTURE.md that can be read from the code.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

use crate::workspace::Workspace;

/// A crate, and the only crates on which it may depend.
const ONLY: &[(&str, &[&str])] = &[
    ("stepwright", &["critical-section", "embedded-hal"]),
    ("stepwright-embassy", &["embassy-sync", "stepwright"]),
    ("stepwright-port-test", &["stepwright"]),
    ("stepwright-selftest", &["stepwright", "crc"]),
    (
        "stepwright-tmc2209",
        &[
            "embassy-futures",
            "embedded-hal-async",
            "embedded-io-async",
            "stepwright",
            "stepwright-embassy",
            "tmc2209",
        ],
    ),
    ("stepwright-sink", &["critical-section", "stepwright"]),
    ("stepwright-protocol", &["stepwright"]),
    ("stepwright-stream", &["stepwright"]),
    ("stepwright-feeder", &["stepwright", "stepwright-stream"]),
    ("stepwright-device", &["stepwright", "stepwright-protocol", "stepwright-stream"]),
];

/// A crate, the crates on which it must not depend, and the invariant.
const NEVER: &[(&str, &[&str], &str)] = &[
    ("stepwright-path", LINE, "a source sees no bytes"),
    ("stepwright-timed", HOSTS, "no layer calls up"),
    ("stepwright-austin", HOSTS, "no layer calls up"),
    ("stepwright-cycle", HOSTS, "no layer calls up"),
    ("stepwright-avr", HOSTS, "no layer calls up"),
    ("stepwright-sim", HOSTS, "no layer calls up"),
    ("stepwright-host", &["stepwright-cli", "stepwright-serve"], "no layer calls up"),
    ("stepwright-stress", LINE, "a judge shares no code with what it judges"),
];

/// The crates that know the serial line.
const LINE: &[&str] = &["stepwright-protocol", "stepwright-device", "stepwright-host"];

/// The crates that run only on a computer.
const HOSTS: &[&str] =
    &["stepwright-cli", "stepwright-host", "stepwright-path", "stepwright-serve"];

/// A file or a folder, the words that its code must not contain, and the invariant.
const UNSAID: &[(&str, &[&str], &str)] = &[
    ("crates/stepwright/src", &["target_arch", "target_os"], "the core knows no chip"),
    ("crates/stepwright-serve/src", &["Master", "Script", "Slave"], "a front end says no line"),
    ("python/src", &["Master", "Script", "Slave"], "a front end says no line"),
    ("crates/stepwright-host/src/conversation.rs", IO, "the host's conversation does no I/O"),
    ("crates/stepwright-host/src/motion.rs", IO, "the host's conversation does no I/O"),
    ("crates/stepwright-host/src/home.rs", IO, "the host's conversation does no I/O"),
    ("crates/stepwright-host/src/homing.rs", IO, "the host's conversation does no I/O"),
];

/// Names of the outside world.
const IO: &[&str] =
    &["std::fs", "std::net", "std::thread", "std::process", "serial2", "Instant", "SystemTime"];

/// Crates that run on a chip: they have no standard library, allocator or floating point.
const SMALL: &[&str] = &[
    "stepwright",
    "stepwright-austin",
    "stepwright-cycle",
    "stepwright-device",
    "stepwright-embassy",
    "stepwright-port-test",
    "stepwright-protocol",
    "stepwright-selftest",
    "stepwright-sink",
    "stepwright-stream",
    "stepwright-timed",
    "stepwright-tmc2209",
];

/// The files of the core that may contain unsafe blocks, each with its proof beside it.
const UNSAFE: &[&str] = &[
    "format/compact.rs",
    "num/external.rs",
    "ordered.rs",
    "queue/entries.rs",
    "shared.rs",
    "steppers.rs",
];

/// Checks all invariants.
pub fn run(ws: &Workspace) -> Result<()> {
    let mut faults = Vec::new();
    for (own, allowed) in ONLY {
        for other in dependencies(&ws.root, own)? {
            if !allowed.contains(&other.as_str()) {
                faults.push(format!("{own} depends on {other}: it may on {allowed:?} alone"));
            }
        }
    }
    for (own, barred, invariant) in NEVER {
        for other in dependencies(&ws.root, own)? {
            if barred.contains(&other.as_str()) {
                faults.push(format!("{own} depends on {other}: {invariant}"));
            }
        }
    }
    for (place, words, invariant) in UNSAID {
        for (name, text) in sources(&ws.root, &ws.root.join(place))? {
            let found = said(code(&text), words);
            faults.extend(found.map(|word| format!("{name} says {word}: {invariant}")));
        }
    }
    for own in SMALL {
        let src = ws.root.join("crates").join(own).join("src");
        let lib = fs::read_to_string(src.join("lib.rs")).with_context(|| (*own).to_owned())?;
        if !lib.contains("#![no_std]") && !lib.contains("not(test), no_std") {
            faults.push(format!("{own} takes the standard library: it runs on a chip"));
        }
        for (name, text) in sources(&ws.root, &src)? {
            let found = said(code(&text), &["f32", "f64", "alloc"]);
            faults.extend(found.map(|word| format!("{name} says {word}: it runs on a chip")));
            let file = name.strip_prefix("crates/stepwright/src/");
            if file.is_some_and(|file| !UNSAFE.contains(&file))
                && said(code(&text), &["unsafe"]).next().is_some()
            {
                faults.push(format!("{name} is unsafe: of the core {UNSAFE:?} may be, alone"));
            }
        }
    }
    for name in without_program(&ws.root)? {
        faults
            .push(format!("{name} is in no test program: tests/all.rs beside it names the others"));
    }
    for fault in &faults {
        println!("{fault}");
    }
    if faults.is_empty() { Ok(()) } else { bail!("{} broken invariants", faults.len()) }
}

/// The test files that belong to no program, where cargo does not make a program of each file.
fn without_program(root: &Path) -> Result<Vec<String>> {
    let mut lost = Vec::new();
    for place in ["crates", "firmware"] {
        for entry in fs::read_dir(root.join(place))? {
            let tests = entry?.path().join("tests");
            let Ok(all) = fs::read_to_string(tests.join("all.rs")) else { continue };
            let manifest = fs::read_to_string(tests.join("../Cargo.toml"))?;
            let mut names = Vec::new();
            for file in fs::read_dir(&tests)? {
                let file = file?.file_name().to_string_lossy().into_owned();
                names.extend(file.strip_suffix(".rs").map(str::to_owned));
            }
            let folder = tests.strip_prefix(root).unwrap_or(&tests).display();
            let unnamed = names.iter().filter(|name| !has_program(name, &all, &manifest));
            lost.extend(unnamed.map(|name| format!("{folder}/{name}.rs")));
        }
    }
    Ok(lost)
}

/// Whether the program of all tests contains this file, or the file is a separate program.
fn has_program(name: &str, all: &str, manifest: &str) -> bool {
    all.lines().any(|line| line == format!("mod {name};"))
        || manifest.lines().any(|line| line == format!("path = \"tests/{name}.rs\""))
}

/// The dependencies of a crate, without those of its tests.
fn dependencies(root: &Path, own: &str) -> Result<Vec<String>> {
    let manifest = root.join("crates").join(own).join("Cargo.toml");
    let text = fs::read_to_string(&manifest).with_context(|| manifest.display().to_string())?;
    Ok(depends(&text))
}

/// The names in the tables of dependencies of a manifest.
fn depends(manifest: &str) -> Vec<String> {
    let (mut inside, mut names) = (false, Vec::new());
    for line in manifest.lines() {
        if let Some(table) = line.strip_prefix('[') {
            let table = table.trim_end_matches(']');
            inside = table == "dependencies"
                || table.starts_with("target.") && table.ends_with(".dependencies");
        } else if inside
            && let Some((name, _)) = line.split_once(['=', '.'])
            && !line.starts_with(['#', ' '])
        {
            names.push(name.trim().to_owned());
        }
    }
    names
}

/// The source files at or under a path, with their names, without test files.
fn sources(root: &Path, place: &Path) -> Result<Vec<(String, String)>> {
    let (mut left, mut found) = (vec![PathBuf::from(place)], Vec::new());
    while let Some(path) = left.pop() {
        if path.is_dir() {
            for entry in fs::read_dir(&path).with_context(|| path.display().to_string())? {
                left.push(entry?.path());
            }
        } else if path.extension().is_some_and(|extension| extension == "rs")
            && !path.ends_with("tests.rs")
        {
            let text = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
            found.push((path.strip_prefix(root).unwrap_or(&path).display().to_string(), text));
        }
    }
    Ok(found)
}

/// The code of a file before the tests at its end.
fn code(text: &str) -> &str {
    let tests = text.find("\n#[cfg(test)]\nmod ").or(text.find("\n#[cfg(test)]\npub(crate) mod "));
    tests.map_or(text, |at| &text[..at])
}

/// The words that occur in the code, outside comments.
fn said<'w>(text: &str, words: &[&'w str]) -> impl Iterator<Item = &'w str> {
    let lines = text.lines().map(|line| line.find("//").map_or(line, |at| &line[..at]));
    let code: String = lines.collect::<Vec<_>>().join("\n");
    let part = |c: char| c.is_alphanumeric() || c == '_';
    words.iter().copied().filter(move |word| {
        code.match_indices(word).any(|(at, found)| {
            let (before, after) = (&code[..at], &code[at + found.len()..]);
            !before.ends_with(part) && !after.starts_with(part)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_whole_and_in_code() {
        let words = ["f64", "unsafe", "std::fs"];
        let found = |text| said(text, &words).collect::<Vec<_>>();
        assert_eq!(found("let x: f64 = 1; // unsafe"), ["f64"]);
        assert_eq!(found("let unsafe_f64x = 0;\n/// f64"), [""; 0]);
        assert_eq!(found("use std::fs;\nunsafe { f() }"), ["unsafe", "std::fs"]);
        assert_eq!(code("a\n#[cfg(test)]\nmod tests {\n f64"), "a");
    }

    #[test]
    fn a_test_file_is_a_module_or_a_program() {
        let all = "mod common;\n\nmod line;\n";
        let manifest = "[[test]]\nname = \"all\"\npath = \"tests/all.rs\"\n";
        assert!(has_program("line", all, manifest));
        assert!(has_program("all", all, manifest));
        assert!(!has_program("lin", all, manifest));
        assert!(!has_program("stop", all, manifest));
    }

    #[test]
    fn a_manifest_tells_its_dependencies() {
        let manifest = "[package]\nname = \"x\"\n[dependencies]\na.workspace = true\n# b = 1\n\
                        c = { path = \"c\" }\n[dev-dependencies]\nd = \"1\"\n\
                        [target.'cfg(unix)'.dependencies]\ne = \"1\"\n";
        assert_eq!(depends(manifest), ["a", "c", "e"]);
    }
}
