//! A firmware outside the repository: the README's first program on `stepwright-avr`, built as
//! that crate's README says, without anything of `firmware/avr`.

use std::fs;

use anyhow::{Context, Result, ensure};

use crate::firmware;
use crate::toolchain::{ATMEGA328P, Cross};
use crate::workspace::{Workspace, alone_in, put, run};

/// The program's name in `target/firmware`: `uno-outside.elf`.
const NAME: &str = "outside";

/// The most bytes of its flash, which the README rounds to 22 KB.
const MOST: u32 = 22_999;

/// Builds it for an Uno. (A build for a Mega differs in a feature and the chip. It would take a
/// minute more and show nothing new.)
pub fn make(ws: &Workspace) -> Result<()> {
    let guide = fs::read_to_string(ws.root.join("crates/stepwright-avr/README.md"))?;
    let manifest = block(&guide, "toml").context("stepwright-avr's README has no manifest")?;
    let flags = format!("{} -C link-arg=-Wl,--relax", ATMEGA328P.flags);
    for flag in flags.split("-C ").map(str::trim) {
        ensure!(guide.contains(flag), "stepwright-avr's README does not build with {flag}");
    }
    let source = fs::read_to_string(ws.root.join("README.md"))?;
    let source = block(&source, "rust").context("the README has no first program")?;

    let folder = ws.target.join("xtask").join(NAME);
    fs::create_dir_all(folder.join("src"))?;
    let manifest = manifest.replace("\"../stepwright/", &format!("\"{}/", ws.root.display()));
    let package = format!("[package]\nname = \"{NAME}\"\nedition = \"2024\"\n\n[workspace]\n\n");
    fs::write(folder.join("Cargo.toml"), package + &manifest)?;
    fs::write(folder.join("src/main.rs"), source)?;

    let cross = Cross::find().context("no compiler for small chips: run `cargo xtask setup`")?;
    // With the versions and the target folder of the project's firmware, so that the crates for
    // this machine are built once.
    fs::copy(ws.root.join("firmware/avr/Cargo.lock"), folder.join("Cargo.lock"))?;
    let built = ws.target.join(firmware::AVR);
    let _alone = alone_in(&built)?;
    let mut cargo = cross.cargo_plain(ws, "build", &built);
    cargo.args(["--release", "--target", "avr-none"]).current_dir(&folder);
    run(cargo.env("CARGO_TARGET_AVR_NONE_RUSTFLAGS", flags))?;
    let elf = built.join("avr-none/release").join(NAME).with_extension("elf");
    let (flash, _) = firmware::size(&elf)?;
    ensure!(flash <= MOST, "{flash} bytes of flash, and stepwright-avr's README promises {MOST}");
    let place = ws.target.join("firmware");
    fs::create_dir_all(&place)?;
    put(&elf, &place.join(format!("uno-{NAME}.elf")))
}

/// The first block of code in this language.
fn block<'a>(text: &'a str, language: &str) -> Option<&'a str> {
    let (_, rest) = text.split_once(&format!("```{language}\n"))?;
    rest.split("```").next()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_block_of_a_language() {
        let text = "```toml\na = 1\n```\n```rust\nfn a() {}\n```\n```rust\nfn b() {}\n```\n";
        assert_eq!(block(text, "rust"), Some("fn a() {}\n"));
        assert_eq!(block(text, "toml"), Some("a = 1\n"));
        assert_eq!(block(text, "python"), None);
    }
}
