//! `touchdown campaign block`: how many landings take a given time.

use std::time::Instant;

use serde::Serialize;
use touchdown::{Error, Result};
use touchdown_campaign::sweep::{LandingBackend, Simulation, Sweep};
use touchdown_terminal::Done;

use super::args::land::BlockArgs;
use super::campaign::state;
use super::context::Context;

/// Landings that are timed, evenly spread over the campaign: their mean is then within a quarter of that of all, where landings take
/// up to twice as long as others.
const TIMED: u64 = 16;

/// The answer as an object.
#[derive(Serialize)]
struct BlockSize {
    schema: u32,
    version: &'static str,
    /// Landings that were timed, each on one core.
    timed: u64,
    landing_s: f64,
    fastest_landing_s: f64,
    slowest_landing_s: f64,
    /// Landings of a block.
    block: u64,
    blocks: u64,
    block_s: f64,
}

pub(crate) fn run(context: &Context, args: &BlockArgs) -> Result<Done> {
    let sweep = Sweep::read(&args.sweep, args.trials, args.seed)?;
    if sweep.settings().autopilot.is_some() {
        return Err(Error::Arguments(
            "a landing under an autopilot takes as long as it takes in flight: divide the seconds by that".into(),
        ));
    }
    state(context, &sweep)?;
    let timed = TIMED.min(sweep.landings());
    context.stage("landings", timed);
    let mut seconds = Vec::new();
    for k in 0..timed {
        let begun = Instant::now();
        Simulation.land(&sweep, k * sweep.landings() / timed)?;
        seconds.push(begun.elapsed().as_secs_f64());
        context.step();
    }
    context.finish();
    let size = size(&seconds, args.seconds, sweep.landings());
    context.say(&format!(
        "{timed} landings of the campaign took {:.2} s each on one core ({:.2} to {:.2}).\nSet `block = {}` in the sweep (now {}): {} {} of \
         about {:.0} s",
        size.landing_s,
        size.fastest_landing_s,
        size.slowest_landing_s,
        size.block,
        sweep.settings().block,
        size.blocks,
        if size.blocks == 1 { "block" } else { "blocks" },
        size.block_s
    ));
    context.object(&size);
    Ok(Done::Whole)
}

/// The block of about so many seconds, by the times of some landings.
fn size(seconds: &[f64], wanted_s: f64, landings: u64) -> BlockSize {
    let mean = seconds.iter().sum::<f64>() / seconds.len() as f64;
    let [fastest, slowest] = seconds
        .iter()
        .fold([f64::INFINITY, 0.0_f64], |[low, high], s| {
            [low.min(*s), high.max(*s)]
        });
    let block = (wanted_s / mean).round().clamp(1.0, landings as f64) as u64;
    BlockSize {
        schema: 1,
        version: env!("CARGO_PKG_VERSION"),
        timed: seconds.len() as u64,
        landing_s: mean,
        fastest_landing_s: fastest,
        slowest_landing_s: slowest,
        block,
        blocks: landings.div_ceil(block),
        block_s: block as f64 * mean,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_a_block_takes_the_wanted_time() {
        let of = |wanted, landings| size(&[0.1, 0.2, 0.3], wanted, landings);
        let found = of(30.0, 1000);
        assert_eq!((found.block, found.blocks), (150, 7));
        assert!((found.block_s - 30.0).abs() < 1e-9);
        assert_eq!(
            (found.fastest_landing_s, found.slowest_landing_s),
            (0.1, 0.3)
        );
        // One landing at least, and no more than there are.
        assert_eq!((of(0.01, 1000).block, of(0.01, 1000).blocks), (1, 1000));
        assert_eq!((of(1e9, 1000).block, of(1e9, 1000).blocks), (1000, 1));
    }
}
