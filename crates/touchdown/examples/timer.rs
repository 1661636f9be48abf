//! How regularly this computer wakes a program that sleeps until the next 10 ms: what no companion on it can be better than.
//!
//! ```sh
//! cargo run --release -p touchdown --example timer -- 60    # seconds
//! ```

#![expect(
    clippy::print_stdout,
    reason = "a program of its own, which prints what it measures"
)]

use std::time::{Duration, Instant};

const PERIOD: Duration = Duration::from_millis(10);

fn main() -> Result<(), String> {
    let asked = std::env::args().nth(1).unwrap_or_default();
    let Ok(seconds @ 1..=86_400) = asked.parse::<u32>() else {
        return Err(format!("expected 1 to 86400 seconds, found `{asked}`"));
    };
    let mut due = Instant::now();
    let mut last = due;
    let mut deviations_ms: Vec<f64> = (0..100 * seconds)
        .map(|_| {
            due += PERIOD;
            std::thread::sleep(due.saturating_duration_since(Instant::now()));
            let now = Instant::now();
            let deviation_s = (now - last).as_secs_f64() - PERIOD.as_secs_f64();
            last = now;
            1e3 * deviation_s.abs()
        })
        .collect();
    deviations_ms.sort_by(f64::total_cmp);
    let quantile = |share: f64| deviations_ms[((deviations_ms.len() - 1) as f64 * share) as usize];
    println!(
        "deviation of the period from 10 ms: median {:.2} ms, 99 % {:.2} ms, 99.9 % {:.2} ms, greatest {:.2} ms",
        quantile(0.5),
        quantile(0.99),
        quantile(0.999),
        quantile(1.0)
    );
    Ok(())
}
