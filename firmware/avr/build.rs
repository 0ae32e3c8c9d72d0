//! Has the linker replace calls and jumps by their short forms: 300 bytes less.
//! (The compiler marks its objects as fit for that.)

fn main() {
    println!("cargo:rustc-link-arg-bins=-Wl,--relax");
    println!("cargo:rerun-if-changed=build.rs");
}
