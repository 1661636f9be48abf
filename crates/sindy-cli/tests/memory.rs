//! The memory of one pass does not grow with the rows. A file of its own, so that nothing else runs in this process.
#![cfg(target_os = "linux")]

use sindy::identify::{Columns, Identification};
use sindy::{Identify, Library, OwnedBlock, Stream};

/// Rows of a block.
const BLOCK: u32 = 50_000;

/// Van der Pol's oscillator by Runge-Kutta, made block by block.
fn fit(blocks: u32) -> Identification {
    let (mut x, mut y) = (1.0_f64, 0.0_f64);
    let slope = |x: f64, y: f64| (y, 2.0 * (1.0 - x * x) * y - x);
    let dt = 0.01;
    let rows = (0..blocks).map(move |k| {
        let mut columns = vec![Vec::new(); 3];
        for i in 0..BLOCK {
            columns[0].push(dt * f64::from(k * BLOCK + i));
            columns[1].push(x);
            columns[2].push(y);
            let (a, b) = slope(x, y);
            let (c, d) = slope(x + 0.5 * dt * a, y + 0.5 * dt * b);
            let (e, f) = slope(x + 0.5 * dt * c, y + 0.5 * dt * d);
            let (g, h) = slope(x + dt * e, y + dt * f);
            x += dt / 6.0 * (a + 2.0 * c + 2.0 * e + g);
            y += dt / 6.0 * (b + 2.0 * d + 2.0 * f + h);
        }
        Ok(OwnedBlock { group: 0, columns })
    });
    let source = Stream::new(&["t", "x", "y"], 1, rows);
    let library = Library::polynomial(&["x", "y"], 3).unwrap();
    let columns = Columns::new("t", &["x", "y"], &[]).unwrap();
    let found = Identify::new(library).run_stream(&source, &columns, &mut |_| ());
    found.unwrap()
}

/// The most memory that this process has held, in kB.
fn peak() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"));
    let number = line.unwrap().trim().trim_end_matches("kB").trim();
    number.parse().unwrap()
}

#[test]
fn prop_four_million_rows_take_the_memory_of_one_million() {
    let found = fit(20);
    assert_eq!(found.data.rows, 1_000_000);
    let first = peak();
    let found = fit(80);
    assert_eq!(found.data.rows, 4_000_000);
    assert_eq!(found.model.terms(), 4, "{}", found.model);
    let second = peak();
    // Four columns of 8 bytes more for each of three million rows would be 96 MB; the allocator's own holes may be a few.
    assert!(second - first < 16 << 10, "{first} kB, then {second} kB");
    assert!(second < 200 << 10, "{second} kB");
}
