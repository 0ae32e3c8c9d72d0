//! Links for the chip: `link.x` comes from `cortex-m-rt`, and includes `memory.x` of
//! `firmware/nrf51`.

fn main() {
    println!("cargo:rustc-link-arg-bins=-Tlink.x");
    println!("cargo:rerun-if-changed=build.rs");
}
