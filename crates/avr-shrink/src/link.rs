//! The linker that rustc calls: it makes a program's assembly smaller, and calls avr-gcc to link
//! it.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::{Spared, shrink};

/// Links with rustc's arguments for `avr-gcc`. It accepts these in addition:
///
/// | argument | meaning |
/// | --- | --- |
/// | `--busy=PART`, `--whole=PART` | functions of [`Spared`] |
/// | `--shrunk-by=…` | ignored; another value makes cargo link again |
///
/// The assembly is beside the program, where rustc puts it with `--emit=asm`. The result is written
/// there too: `NAME.small.s`.
///
/// # Errors
/// A text for the user: an argument or a file is missing, a function is unknown, or a tool fails.
pub fn link(args: impl IntoIterator<Item = String>) -> Result<(), String> {
    let (mut rest, mut spared) = (Vec::new(), Spared::default());
    for arg in args {
        match arg.split_once('=') {
            Some(("--busy", part)) => spared.busy.push(part.into()),
            Some(("--whole", part)) => spared.whole.push(part.into()),
            Some(("--shrunk-by", _)) => {}
            _ => rest.push(arg),
        }
    }
    let output = rest.iter().position(|arg| arg == "-o").and_then(|at| rest.get(at + 1));
    let elf = PathBuf::from(output.ok_or("the linker's arguments have no -o FILE")?);
    let chip = rest.iter().find(|arg| arg.starts_with("-mmcu=")).cloned();
    let chip = chip.ok_or("the linker's arguments have no -mmcu=CHIP: rustc's `-C target-cpu`")?;
    let mut objects = rest.iter_mut().filter(|arg| arg.ends_with(".rcgu.o"));
    let object = objects.next().ok_or("the linker's arguments have no object of rustc's")?;
    if objects.next().is_some() {
        return Err("rustc made several objects: set `lto = true` and `codegen-units = 1`".into());
    }
    *object = assemble(&elf, &chip, &spared)?;
    run(Command::new("avr-gcc").args(rest))
}

/// Makes the assembly beside a program smaller, and assembles it. Returns the object.
fn assemble(elf: &Path, chip: &str, spared: &Spared) -> Result<String, String> {
    let from = elf.with_extension("s");
    let failed = |what: &str, path: &Path, error: io::Error| {
        format!("can't {what} {}: {error}; rustc needs `--emit=asm`", path.display())
    };
    let text = fs::read_to_string(&from).map_err(|error| failed("read", &from, error))?;
    let small = shrink(&text, spared)?;
    let to = elf.with_extension("small.s");
    fs::write(&to, small).map_err(|error| failed("write", &to, error))?;
    let object = elf.with_extension("small.o");
    run(Command::new("avr-as")
        .args([chip, "-mlink-relax", "--no-warn", "-o"])
        .arg(&object)
        .arg(to))?;
    Ok(object.to_string_lossy().into())
}

/// Runs a tool and waits for its end.
fn run(command: &mut Command) -> Result<(), String> {
    let name = command.get_program().to_string_lossy().into_owned();
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("{name}: {status}; it says above why")),
        Err(error) => Err(format!("can't start {name}: {error}; it comes with avr-gcc")),
    }
}
