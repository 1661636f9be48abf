//! The tables of pooled sets.

use std::collections::BTreeMap;

use crate::vertical::found::QUANTITIES;

/// The coverage that has to lie in the binomial interval: a little below 0.95, as a finite number of sets can show no more.
const LEAST: f64 = 0.93;

/// What came of one quantity.
#[derive(Default)]
struct Tally {
    errors: Vec<f64>,
    half_widths: Vec<f64>,
    held: usize,
    missing: usize,
}

/// Sets of a cell, and how many of them were refused.
#[derive(Default)]
struct Refused {
    sets: usize,
    refused: usize,
}

/// A table's row: accelerometer ("both" for pooled), noise (mm), quantity.
type Row = (String, String, String);

/// Reads the lines of the files and prints what they say.
pub(crate) fn print(files: &[String]) -> std::io::Result<()> {
    let mut tallies: BTreeMap<Row, Tally> = BTreeMap::new();
    let mut cells: BTreeMap<Row, Refused> = BTreeMap::new();
    for file in files {
        for line in std::fs::read_to_string(file)?.lines() {
            let words: Vec<&str> = line.split(' ').collect();
            let [_, accelerometer, noise, hz, law, quantity, rest @ ..] = &words[..] else {
                continue;
            };
            let sensor = if *accelerometer == "true" {
                "with"
            } else {
                "without"
            };
            if *quantity == "refused" || quantity.replace('_', " ") == QUANTITIES[0] {
                let cell = cells.entry((sensor.into(), (*noise).into(), (*hz).into()));
                let cell = cell.or_default();
                cell.sets += 1;
                cell.refused += usize::from(*quantity == "refused");
            }
            if *quantity == "refused" {
                continue;
            }
            let numbers: Vec<f64> = rest.iter().filter_map(|n| n.parse().ok()).collect();
            for (sensor, noise) in [
                (sensor, *noise),
                ("both", *noise),
                (sensor, "all"),
                ("both", "all"),
                (*law, "all"),
            ] {
                let row = (sensor.into(), noise.into(), (*quantity).into());
                tallies.entry(row).or_default().count(&numbers);
            }
        }
    }
    println!(
        "| accelerometer | range noise (mm) | quantity | bias | RMSE | half width | held | coverage, binomial interval | not given |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- |");
    for ((sensor, noise, quantity), tally) in &tallies {
        println!(
            "| {sensor} | {noise} | {} | {}",
            quantity.replace('_', " "),
            tally.cells()
        );
    }
    println!(
        "\n| accelerometer | range noise (mm) | rate (Hz) | sets | refused |\n| --- | --- | --- | --- | --- |"
    );
    for ((sensor, noise, hz), cell) in &cells {
        println!(
            "| {sensor} | {noise} | {hz} | {} | {} |",
            cell.sets, cell.refused
        );
    }
    Ok(())
}

impl Tally {
    /// Counts truth, value and interval; an interval that is missing has the truth alone.
    fn count(&mut self, numbers: &[f64]) {
        let &[truth, value, low, high] = numbers else {
            self.missing += 1;
            return;
        };
        self.errors.push(value - truth);
        self.half_widths.push(0.5 * (high - low));
        self.held += usize::from(low <= truth && truth <= high);
    }

    /// The cells behind the row's name.
    fn cells(&self) -> String {
        let count = self.errors.len();
        if count == 0 {
            return format!("| | | | | | {} |", self.missing);
        }
        let n = count as f64;
        let mean = |values: &[f64]| values.iter().sum::<f64>() / n;
        let squares: Vec<f64> = self.errors.iter().map(|e| e * e).collect();
        let [low, high] = wilson(self.held, count);
        let mark = if high < LEAST { " **below**" } else { "" };
        format!(
            "{:+.4} | {:.4} | {:.4} | {} of {count} | {:.3} ({low:.3} to {high:.3}){mark} | {} |",
            mean(&self.errors),
            mean(&squares).sqrt(),
            mean(&self.half_widths),
            self.held,
            self.held as f64 / n,
            self.missing,
        )
    }
}

/// The 95 % interval of a share (E. B. Wilson, J. Am. Stat. Assoc. 22, 1927).
fn wilson(held: usize, count: usize) -> [f64; 2] {
    let (z, n) = (1.96, count as f64);
    let share = held as f64 / n;
    let middle = share + z * z / (2.0 * n);
    let half = z * (share * (1.0 - share) / n + z * z / (4.0 * n * n)).sqrt();
    [middle - half, middle + half].map(|v| v / (1.0 + z * z / n))
}
