//! Boards of 32 bits: the folders of `firmware` whose manifests say so. A new one is its folder.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};
use serde_json::Value;

use crate::elf;
use crate::toolchain::{Chip, Cross};
use crate::workspace::{Workspace, alone_in, cargo_path, output, put, run};

/// A board: `[package.metadata.board]` of its manifest, and its programs.
pub struct SmallBoard {
    /// Its folder.
    pub name: String,
    folder: PathBuf,
    triple: String,
    /// What the linker is told besides its scripts.
    flags: String,
    /// Whether QEMU has it.
    pub in_qemu: bool,
    /// Bytes of flash and of RAM that the chip has.
    room: [u64; 2],
    /// What the controller may take of both; all, if nothing is said.
    most: [u64; 2],
    programs: Vec<String>,
}

impl SmallBoard {
    /// All of them, by name.
    pub fn all(ws: &Workspace) -> Result<Vec<SmallBoard>> {
        let mut all = Vec::new();
        for entry in fs::read_dir(ws.root.join("firmware"))? {
            let folder = entry?.path();
            let manifest = folder.join("Cargo.toml");
            // `cargo metadata` takes a tenth of a second, and not all folders have a board.
            if fs::read_to_string(&manifest)
                .is_ok_and(|text| text.contains("\n[package.metadata.board]"))
            {
                all.push(SmallBoard::of(folder)?);
            }
        }
        all.sort_by(|a, b| a.name.cmp(&b.name));
        Ok(all)
    }

    /// The one with this name.
    pub fn named(ws: &Workspace, name: &str) -> Result<SmallBoard> {
        let mut all = SmallBoard::all(ws)?;
        match all.iter().position(|board| board.name == name) {
            Some(at) => Ok(all.swap_remove(at)),
            None => {
                let names: Vec<_> = all.iter().map(|board| &*board.name).collect();
                bail!("no board {name} of 32 bits; there are {}", names.join(", "))
            }
        }
    }

    fn of(folder: PathBuf) -> Result<SmallBoard> {
        let mut cargo = Command::new(cargo_path());
        cargo.args(["metadata", "--no-deps", "--format-version=1", "--manifest-path"]);
        let metadata: Value = serde_json::from_str(&output(cargo.arg(folder.join("Cargo.toml")))?)?;
        let package = &metadata["packages"][0];
        let board = &package["metadata"]["board"];
        let name = folder.file_name().context("a folder")?.to_string_lossy().into_owned();
        let bytes = |value: &Value, key: &str| value[key].as_u64();
        let room =
            ["flash", "ram"].map(|key| bytes(board, key).with_context(|| format!("{name}: {key}")));
        let [flash, ram] = room;
        let room = [flash?, ram?];
        let most = [("flash", room[0]), ("ram", room[1])]
            .map(|(key, room)| bytes(&board["most"], key).unwrap_or(room));
        let targets = package["targets"].as_array().into_iter().flatten();
        let programs = targets.filter(|target| target["kind"][0] == "bin");
        let programs = programs.filter_map(|target| Some(target["name"].as_str()?.to_owned()));
        Ok(SmallBoard {
            triple: board["triple"].as_str().with_context(|| format!("{name}: triple"))?.to_owned(),
            flags: board["flags"].as_str().unwrap_or("").to_owned(),
            in_qemu: board["qemu"].is_array(),
            programs: programs.collect(),
            name,
            folder,
            room,
            most,
        })
    }

    /// Its folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Builds its programs: one `.elf` each in `target/firmware`.
    pub fn build(&self, ws: &Workspace) -> Result<Vec<PathBuf>> {
        let cross =
            Cross::find().context("no compiler for small chips: run `cargo xtask setup`")?;
        let triple: &'static str = self.triple.clone().leak();
        let flags: &'static str = self.flags.clone().leak();
        let built = ws.target.join("chips");
        let _alone = alone_in(&built)?;
        let mut cargo = cross.cargo_in(ws, "build", &[&Chip { triple, flags }], &built);
        link(&mut cargo, triple);
        run(cargo.current_dir(&self.folder).args(["--release", "--bins"]))?;
        let to = ws.target.join("firmware");
        fs::create_dir_all(&to)?;
        let mut elves = Vec::new();
        for program in &self.programs {
            let elf = to.join(format!("{}-{}.elf", self.name, program.replace('_', "-")));
            put(&built.join(triple).join("release").join(program), &elf)?;
            elves.push(elf);
        }
        Ok(elves)
    }

    /// Says what a program of it takes, in a line. An error if the controller takes more than it may.
    pub fn tell_size(&self, file: &Path) -> Result<()> {
        let program = file.file_stem().unwrap_or_default().to_string_lossy();
        let data = fs::read(file)?;
        let sizes = elf::sizes(&data).with_context(|| format!("reading {}", file.display()))?;
        println!("{program:<20}{:>7} bytes of flash {:>6} of RAM", sizes[0], sizes[1]);
        if program.ends_with("-controller") {
            for (what, (size, most)) in ["flash", "RAM"].iter().zip(sizes.iter().zip(&self.most)) {
                ensure!(
                    size <= most,
                    "{program} takes {size} bytes of {what}; {most} are its bound"
                );
            }
        }
        for (what, (size, room)) in ["flash", "RAM"].iter().zip(sizes.iter().zip(&self.room)) {
            ensure!(size <= room, "{program} takes {size} bytes of {what}; the chip has {room}");
        }
        Ok(())
    }
}

/// Has cargo link for a chip by LLVM's linker.
pub fn link(cargo: &mut Command, triple: &str) {
    if let Some(linker) = linker() {
        let name = triple.to_uppercase().replace('-', "_");
        cargo.env(format!("CARGO_TARGET_{name}_LINKER"), linker);
    }
}

/// LLVM's linker: the compiler's own, else that of any toolchain that rustup has. `None` if the
/// compiler is to look for it.
fn linker() -> Option<PathBuf> {
    let active = output(Command::new("rustc").args(["--print", "sysroot"])).ok()?;
    let host = output(Command::new("rustc").arg("-vV")).ok()?;
    let host = host.lines().find_map(|line| line.strip_prefix("host: "))?.to_owned();
    let own = Path::new(active.trim()).join("lib/rustlib").join(host).join("bin/rust-lld");
    own.is_file().then_some(own)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whoever adds a folder need not list it anywhere.
    #[test]
    fn boards_are_found_by_their_manifests() {
        let ws = Workspace::load().unwrap();
        let names: Vec<_> = SmallBoard::all(&ws).unwrap().into_iter().map(|one| one.name).collect();
        assert!(["nrf51", "rp2040", "virt"].iter().all(|name| names.iter().any(|one| one == name)));
        assert!(SmallBoard::named(&ws, "pdp11").is_err());
    }
}
