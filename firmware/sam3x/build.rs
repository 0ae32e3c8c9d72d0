//! Tells the linker where the chip's memory is, and which vectors have no handler.

fn main() {
    let folder = std::env::var("CARGO_MANIFEST_DIR").expect("cargo names the package's folder");
    println!("cargo:rustc-link-search={folder}");
    println!("cargo:rustc-link-search={folder}/vectors");
    if std::env::var("CARGO_CFG_TARGET_OS").is_ok_and(|system| system == "none") {
        // `link.x` comes from `cortex-m-rt`, and includes `memory.x` and `device.x`.
        println!("cargo:rustc-link-arg-bins=-Tlink.x");
    }
    for file in ["build.rs", "memory.x", "vectors/device.x"] {
        println!("cargo:rerun-if-changed={file}");
    }
}
