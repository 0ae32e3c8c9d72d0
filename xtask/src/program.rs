//! The programs of the AVR firmware, as its manifest and its folders say: `firmware/avr/src/bin`
//! and `firmware/avr/examples`. `package.metadata.programs` there says what is special of some.

use std::fs;
use std::process::Command;

use anyhow::{Context, Result, bail};
use serde_json::{Map, Value};

use crate::firmware::{Board, Build};
use crate::workspace::{Workspace, cargo_path, output};

/// The controller, which has the names of the boards.
pub const CONTROLLER: &str = "slave";
/// What must not build for a Mega.
pub const REFUSED: &str = "stacked";

/// One of the firmware's programs.
pub struct Program {
    /// As in file names.
    pub name: String,
    /// Its file's first sentence.
    pub what: String,
    /// As cargo knows it.
    target: String,
    /// In `examples`, and not in `src/bin`.
    example: bool,
    /// What the manifest says of it.
    data: Value,
}

impl Program {
    /// All of them, in the order of their names.
    ///
    /// # Errors
    /// The manifest speaks of a program that is not there, or in words that it has not.
    pub fn all(ws: &Workspace) -> Result<Vec<Program>> {
        let manifest = ws.root.join("firmware/avr/Cargo.toml");
        let mut cargo = Command::new(cargo_path());
        cargo.args(["metadata", "--no-deps", "--format-version=1", "--manifest-path"]);
        let metadata: Value = serde_json::from_str(&output(cargo.arg(manifest))?)?;
        let package = &metadata["packages"][0];
        let none = Map::new();
        let data = package["metadata"]["programs"].as_object().unwrap_or(&none);
        let mut programs = Vec::new();
        for target in package["targets"].as_array().into_iter().flatten() {
            let kind = target["kind"][0].as_str().unwrap_or_default();
            if !matches!(kind, "bin" | "example") {
                continue;
            }
            let text = |key: &str| target[key].as_str().context("cargo metadata: a target");
            let source = fs::read_to_string(text("src_path")?)?;
            let name = text("name")?.replace('_', "-");
            let row = data.iter().find(|(key, _)| covers(key, &name));
            programs.push(Program {
                what: first_sentence(&source),
                target: text("name")?.into(),
                example: kind == "example",
                data: row.map_or(Value::Null, |(_, data)| data.clone()),
                name,
            });
        }
        for (key, row) in data {
            let Some(of) = row["of"].as_str() else { continue };
            let other = programs.iter().find(|program| program.name == of);
            let (target, example) = match other {
                Some(program) => (program.target.clone(), program.example),
                None => bail!("firmware/avr/Cargo.toml: {key}: there is no program {of}"),
            };
            let what = row["what"].as_str().unwrap_or_default().into();
            programs.push(Program { name: key.clone(), what, target, example, data: row.clone() });
        }
        for (key, row) in data {
            if !programs.iter().any(|program| covers(key, &program.name)) {
                bail!("firmware/avr/Cargo.toml: there is no program {key}");
            }
            for word in row.as_object().into_iter().flat_map(Map::keys) {
                if !WORDS.contains(&word.as_str()) {
                    bail!("firmware/avr/Cargo.toml: {key}: `{word}` is none of {WORDS:?}");
                }
            }
        }
        programs.sort_by(|a, b| a.name.cmp(&b.name));
        Ok(programs)
    }

    /// The program of a name.
    ///
    /// # Errors
    /// There is none, and the error names those that there are.
    pub fn named(ws: &Workspace, name: &str) -> Result<Program> {
        let mut programs = Program::all(ws)?;
        match programs.iter().position(|program| program.name == name) {
            Some(at) => Ok(programs.swap_remove(at)),
            None => {
                let names: Vec<_> = programs.iter().map(|program| &*program.name).collect();
                bail!("there is no program `{name}`; there are {}", names.join(", "))
            }
        }
    }

    /// Whether it is for a board with this step timer.
    pub fn fits(&self, build: &Build) -> bool {
        let board = match &self.data["boards"] {
            Value::Null => true,
            boards => strings(boards).any(|name| name == build.board.name()),
        };
        board && (build.timer == 1 || self.says("timers"))
    }

    /// The features that it wants on a board, the board's own left out.
    pub fn features(&self, board: Board) -> impl Iterator<Item = &str> {
        let features = &self.data["features"];
        strings(if features.is_object() { &features[board.name()] } else { features })
    }

    /// Whether it is a controller, which is made smaller before it is linked.
    pub fn is_controller(&self) -> bool {
        self.says("controller")
    }

    /// Functions that are called often, by parts of their symbols (`avr_shrink::Spared`).
    pub fn busy(&self) -> impl Iterator<Item = &str> {
        strings(&self.data["busy"])
    }

    /// Functions that save registers by themselves, likewise.
    pub fn whole(&self) -> impl Iterator<Item = &str> {
        strings(&self.data["whole"])
    }

    /// Whether its step interrupt may divide.
    pub fn divides(&self) -> bool {
        self.says("divides")
    }

    /// Whether its step interrupt is that of the timer's overflow.
    pub fn overflows(&self) -> bool {
        self.data["vector"] == "overflow"
    }

    /// Whether `stepwright flash` carries it for a board. To a Nano it writes an Uno's.
    pub fn is_carried(&self, board: Board) -> bool {
        let build = Build { board, timer: 1, bench: false };
        self.says("carried") && self.fits(&build) && board != Board::Nano
    }

    /// The name of its files: that of the board, and its own, which the controller has not.
    pub fn on(&self, board: Board) -> String {
        match &*self.name {
            CONTROLLER => board.name().into(),
            name => format!("{}-{name}", board.name()),
        }
    }

    /// Whether it is for tests alone.
    pub fn is_test(&self) -> bool {
        self.says("test")
    }

    /// What cargo builds.
    pub fn target(&self) -> [&str; 2] {
        [if self.example { "--example" } else { "--bin" }, &self.target]
    }

    /// Where cargo puts it, in the folder of its profile.
    pub fn place(&self) -> String {
        let folder = if self.example { "examples/" } else { "" };
        format!("{folder}{}.elf", self.target)
    }

    fn says(&self, word: &str) -> bool {
        self.data[word] == true
    }
}

/// What the manifest may say of a program.
const WORDS: [&str; 12] = [
    "boards",
    "timers",
    "features",
    "of",
    "what",
    "controller",
    "busy",
    "whole",
    "divides",
    "vector",
    "carried",
    "test",
];

/// Whether a row of the manifest is for a program: by its name, or by how that begins.
fn covers(key: &str, name: &str) -> bool {
    match key.strip_suffix('*') {
        Some(beginning) => name.starts_with(beginning),
        None => key == name,
    }
}

fn strings(list: &Value) -> impl Iterator<Item = &str> {
    list.as_array().into_iter().flatten().filter_map(Value::as_str)
}

/// The first sentence of a file's documentation, without its full stop.
fn first_sentence(source: &str) -> String {
    let lines = source.lines().map_while(|line| line.strip_prefix("//! "));
    let text = lines.collect::<Vec<_>>().join(" ");
    let end = text.find(". ").unwrap_or(text.len());
    text[..end].trim_end_matches('.').into()
}

#[cfg(test)]
mod tests {
    use clap::ValueEnum;

    use super::*;

    fn program(name: &str, data: Value) -> Program {
        let target = name.replace('-', "_");
        Program { name: name.into(), what: String::new(), target, example: true, data }
    }

    fn build(board: Board, timer: u8) -> Build {
        Build { board, timer, bench: false }
    }

    #[test]
    fn a_program_is_for_the_boards_that_its_row_names() {
        let plain = program("first-move", Value::Null);
        assert!(Board::value_variants().iter().all(|board| plain.fits(&build(*board, 1))));
        assert!(!plain.fits(&build(Board::Mega, 3)), "its timer is the first");
        let data = serde_json::json!({ "boards": ["mega"], "timers": true });
        let shields = program("shields", data);
        assert!(shields.fits(&build(Board::Mega, 3)) && !shields.fits(&build(Board::Uno, 1)));
    }

    #[test]
    fn features_are_for_all_boards_or_for_each_its_own() {
        let all = program("a", serde_json::json!({ "features": ["constant"] }));
        assert_eq!(all.features(Board::Nano).collect::<Vec<_>>(), ["constant"]);
        let each = program("b", serde_json::json!({ "features": { "mega": ["jerk"] } }));
        assert_eq!(each.features(Board::Mega).collect::<Vec<_>>(), ["jerk"]);
        assert_eq!(each.features(Board::Uno).count(), 0);
    }

    #[test]
    fn a_nano_takes_an_unos_image() {
        let laws =
            program("laws", serde_json::json!({ "carried": true, "features": ["constant"] }));
        assert!(laws.is_carried(Board::Uno) && !laws.is_carried(Board::Nano));
        assert!(!program("demo", Value::Null).is_carried(Board::Uno));
        assert_eq!(laws.on(Board::Mega), "mega-laws");
        assert_eq!(program(CONTROLLER, Value::Null).on(Board::Mega), "mega");
    }

    #[test]
    fn a_row_is_for_one_program_or_a_family() {
        assert!(covers("laws-*", "laws-power") && !covers("laws-*", "lawless"));
        assert!(covers("demo", "demo") && !covers("demo", "demos"));
        assert_eq!(program("laws-power", Value::Null).place(), "examples/laws_power.elf");
    }

    #[test]
    fn the_first_sentence_says_what_it_is() {
        let source = "//! A motor\n//! moves. It stops.\n#![no_std]\n//! No.";
        assert_eq!(first_sentence(source), "A motor moves");
        assert_eq!(first_sentence("#![no_std]"), "");
    }
}
