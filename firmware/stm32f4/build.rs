//! Tells the linker where the chip's memory is.

fn main() {
    let folder = std::env::var("CARGO_MANIFEST_DIR").expect("cargo names the package's folder");
    println!("cargo:rustc-link-search={folder}");
    if std::env::var("CARGO_CFG_TARGET_OS").is_ok_and(|system| system == "none") {
        // `link.x` comes from `cortex-m-rt`, and includes `memory.x`.
        println!("cargo:rustc-link-arg-bins=-Tlink.x");
    }
    for file in ["build.rs", "memory.x"] {
        println!("cargo:rerun-if-changed={file}");
    }
}
