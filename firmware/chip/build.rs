//! Puts the memory map of the boards where the linker finds it, and compiles the laws in C.

use std::path::Path;
use std::process::Command;

fn main() {
    let folder = std::env::var("CARGO_MANIFEST_DIR").expect("cargo sets it");
    println!("cargo:rustc-link-search={folder}");
    println!("cargo:rerun-if-changed=memory.x");
    if std::env::var_os("CARGO_FEATURE_REFERENCE").is_some() {
        reference(Path::new(&folder));
    }
}

/// Compiles `reference/reference.c` as the firmware of a Cortex-M4F is.
fn reference(folder: &Path) {
    let out = std::env::var("OUT_DIR").expect("cargo sets it");
    let object = Path::new(&out).join("reference.o");
    let compiled = Command::new("arm-none-eabi-gcc")
        .args(["-mcpu=cortex-m4", "-mthumb", "-mfpu=fpv4-sp-d16"])
        .args(["-mfloat-abi=hard", "-std=c99", "-ffreestanding", "-O2"])
        // Otherwise each square root sets `errno`, which needs a C library.
        .args(["-fno-math-errno", "-Wall", "-Wextra", "-Werror", "-c"])
        .arg(folder.join("reference/reference.c"))
        .arg("-o")
        .arg(&object)
        .status()
        .expect("arm-none-eabi-gcc runs");
    assert!(compiled.success(), "reference.c does not compile");
    println!("cargo:rustc-link-arg-bin=reference={}", object.display());
    println!("cargo:rerun-if-changed=reference");
}
