//! Lands cases in double and in single precision and prints what came of it:
//! `cargo run -p touchdown-record --example landings -- TRIALS CASE...`
#![allow(clippy::print_stdout, reason = "an example")]

use std::error::Error;

use touchdown_record::{SEED, space};
use touchdown_sim::landing::space::{Case, SpaceLander, SpaceLanding};

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args().skip(1);
    let trials: u64 = args
        .next()
        .ok_or("usage: landings TRIALS CASE...")?
        .parse()?;
    println!(
        "case, precision: landed, at the first descent, crashed; means of T_L s, V_L m/s, waited s"
    );
    for name in args {
        let case = Case::named(&name).ok_or("unknown case")?;
        let lander = SpaceLander::new(&case.scenario())?;
        let double: Result<Vec<_>, _> = (0..trials).map(|i| lander.land(i, SEED, false)).collect();
        summary(&name, "f64", &double?);
        let single: Result<Vec<_>, _> = (0..trials)
            .map(|i| Ok::<_, Box<dyn Error>>(space(case, &lander, i)?.landing))
            .collect();
        summary(&name, "f32", &single?);
    }
    Ok(())
}

fn summary(case: &str, precision: &str, landings: &[SpaceLanding]) {
    let landed: Vec<_> = landings.iter().filter(|l| l.outcome.landed()).collect();
    let first = landed.iter().filter(|l| l.descents == 1).count();
    let crashed = landings.iter().filter(|l| l.outcome.crashed()).count();
    let count = landed.len().max(1) as f64;
    let mean =
        |of: &dyn Fn(&SpaceLanding) -> f64| landed.iter().map(|l| of(l)).sum::<f64>() / count;
    let touch_s = mean(&|l| l.touch.map_or(0.0, |touch| touch.t_l_s));
    let touch_mps = mean(&|l| l.touch.map_or(0.0, |touch| touch.v_l_mps));
    let waited_s = mean(&|l| l.waited_s);
    println!(
        "{case}, {precision}: {}, {first}, {crashed}, {touch_s:.3}, {touch_mps:.4}, {waited_s:.3}",
        landed.len()
    );
}
