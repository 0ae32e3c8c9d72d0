//! Tells the linker where a simulated chip's memory is.

use std::path::PathBuf;
use std::{env, fs};

/// The micro:bit, with a Cortex-M0, with more RAM than the real one: see the manifest.
const SMALL: &str = "MEMORY {
  FLASH : ORIGIN = 0x00000000, LENGTH = 256K
  RAM : ORIGIN = 0x20000000, LENGTH = 64K
}";

/// ARM's MPS2, with a larger Cortex-M.
const ARM: &str = "MEMORY {
  FLASH : ORIGIN = 0x00000000, LENGTH = 1M
  RAM : ORIGIN = 0x20000000, LENGTH = 256K
}";

/// QEMU's `virt`, whose code begins at the bottom of its RAM.
const RISC_V: &str = "MEMORY {
  FLASH : ORIGIN = 0x80000000, LENGTH = 1M
  RAM : ORIGIN = 0x80100000, LENGTH = 1M
}
REGION_ALIAS(\"REGION_TEXT\", FLASH);
REGION_ALIAS(\"REGION_RODATA\", FLASH);
REGION_ALIAS(\"REGION_DATA\", RAM);
REGION_ALIAS(\"REGION_BSS\", RAM);
REGION_ALIAS(\"REGION_HEAP\", RAM);
REGION_ALIAS(\"REGION_STACK\", RAM);";

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let var = |name| env::var(name).unwrap_or_default();
    let memory = match (&*var("CARGO_CFG_TARGET_OS"), &*var("CARGO_CFG_TARGET_ARCH")) {
        ("none", "arm") if var("TARGET").starts_with("thumbv6m") => SMALL,
        ("none", "arm") => ARM,
        ("none", "riscv32") => RISC_V,
        (_, "avr") => return println!("cargo:rustc-link-arg=-Wl,--relax"),
        _ => return,
    };
    let folder = PathBuf::from(env::var_os("OUT_DIR").expect("cargo names a folder"));
    fs::write(folder.join("memory.x"), memory).expect("the linker's script is written");
    println!("cargo:rustc-link-search={}", folder.display());
    // `link.x` comes from the chip's start-up crate; ARM's includes `memory.x` itself.
    if memory == RISC_V {
        println!("cargo:rustc-link-arg-bins=-Tmemory.x");
    }
    println!("cargo:rustc-link-arg-bins=-Tlink.x");
}
