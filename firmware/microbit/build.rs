//! Links for the chip: `link.x` is of `cortex-m-rt`, and takes `memory.x` of `firmware/nrf51`.

fn main() {
    println!("cargo:rustc-link-arg-bins=-Tlink.x");
    println!("cargo:rerun-if-changed=build.rs");
}
