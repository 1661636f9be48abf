//! The fast camera beside detection on rendered images, band by band.
//!
//! ```text
//! cargo run --release -p touchdown-vision --example compare_fast_camera [FRAMES]
//! ```
#![allow(clippy::print_stdout)]

#[path = "../tests/common/mod.rs"]
mod common;

use common::compare::{AGAIN, BANDS, NAMES, both};

fn main() {
    let frames: u64 = std::env::args()
        .nth(1)
        .map_or(400, |n| n.parse().expect("a number of frames"));
    println!("{frames} frames a band; detection, fast camera, their ratio");
    println!("lateral and range over the height, tilt and its stated sd in rad");
    for (heights_m, fast) in BANDS {
        let [seen, drawn] = both(heights_m, fast, frames);
        let share = |fixes: u64, n: u64| 100.0 * fixes as f64 / n as f64;
        let (a, b) = (
            share(seen.fixes, frames),
            share(drawn.fixes, AGAIN * frames),
        );
        println!("{heights_m:?} m, speed {fast}: found {a:.1} % {b:.1} %");
        for (k, name) in NAMES.iter().enumerate() {
            let (a, b) = (seen.figures(k), drawn.figures(k));
            let pair = |i: usize| format!("{:.2e} {:.2e} ({:.2})", a[i], b[i], b[i] / a[i]);
            println!(
                "  {name:8} mean {:+.2e} {:+.2e}   sd {}   median {}   90 % {}",
                a[0],
                b[0],
                pair(1),
                pair(2),
                pair(3)
            );
        }
    }
}
