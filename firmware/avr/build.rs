//! Lets the linker replace calls and jumps by their short forms, which saves 300 bytes. (The
//! compiler marks its objects as suitable.)
//!
//! A short call reaches 4 KB, an eighth of an Uno's flash. So the linker is told to place callers
//! near the routines that they share, which saves another 250 bytes.

use std::path::PathBuf;
use std::process::Command;
use std::{env, fs};

/// The order of the code after the assembly, by parts of its symbols' names: a path in the source,
/// each name with its length before it. Other code comes last.
const ORDER: &[&str] = &[
    "9main_loop6answer",
    "9main_loop6listen",
    "19stepwright_protocol",
    // All of its modules except the main loop, whose planning is placed beside the planner.
    "17stepwright_device[!9]",
    "avr_device_rt_main",
    "5slave5start",
    "14stepwright_avr4step",
    "9main_loop4plan",
    "10stepwright5group",
    "10stepwright5board",
    "10stepwright3num",
    "stepwright_numbers",
    "10stepwright7planner",
    "memcpy",
    "10stepwright5motor",
    "10stepwright5entry",
];

fn main() {
    println!("cargo:rustc-link-arg=-Wl,--relax");
    println!("cargo:rerun-if-changed=build.rs");
    // Without the linker the link fails, and says so.
    if let Some(script) = script() {
        let folder = env::var_os("OUT_DIR").expect("cargo names a folder for what is built");
        let path = PathBuf::from(folder).join("order.x");
        fs::write(&path, script).expect("the linker's script is written to cargo's folder");
        println!("cargo:rustc-link-arg=-Wl,-T,{}", path.display());
    }
}

/// The linker's own script, with this order inserted.
fn script() -> Option<String> {
    // For the chip's family, as `avr-gcc` names it.
    let mega = env::var_os("CARGO_FEATURE_MEGA").is_some();
    let family = if mega { "avr6" } else { "avr5" };
    let linker = Command::new("avr-ld").args(["-m", family, "--verbose"]).output().ok()?;
    let text = String::from_utf8(linker.stdout).ok()?;
    // It is printed between two lines of `=`, and places functions in the order of the object.
    let script = text.split("======\n").nth(1)?.trim_end_matches('=');
    let (before, behind) = script.split_once("*(.text.*)")?;
    let order: String = ORDER.iter().map(|part| format!("*(.text.*{part}*)\n")).collect();
    Some(format!("{before}{order}*(.text.*){behind}"))
}
