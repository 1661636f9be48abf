//! Gives the program the stack of a usual thread.

use std::env::var;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    if var("CARGO_CFG_TARGET_FAMILY").is_ok_and(|family| family == "wasm") {
        // Readers and landings are tested with the 8 MiB of a main thread; the linker's default is 1 MiB.
        println!("cargo:rustc-link-arg-bins=-zstack-size=8388608");
    }
}
