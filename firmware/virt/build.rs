//! Tells the linker where the board's memory is.

fn main() {
    let folder = std::env::var("CARGO_MANIFEST_DIR").expect("cargo names the package's folder");
    println!("cargo:rustc-link-search={folder}");
    if std::env::var("CARGO_CFG_TARGET_OS").is_ok_and(|system| system == "none") {
        // `link.x` comes from `riscv-rt`.
        println!("cargo:rustc-link-arg-bins=-Tmemory.x");
        println!("cargo:rustc-link-arg-bins=-Tlink.x");
        // For its macros: the registers that an interrupt saves.
        println!("cargo:rustc-env=RISCV_RT_BASE_ISA=rv32i");
    }
    for file in ["build.rs", "memory.x"] {
        println!("cargo:rerun-if-changed={file}");
    }
}
