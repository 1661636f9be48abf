//! Landings in six degrees of freedom by the hundred, on all cores:
//!
//! ```text
//! cargo run --release -p touchdown-sim --example space_campaign -- CASE [TRIALS [SEED]] [KEY=VALUE]...
//! ```
//!
//! Cases are those of [`Case`] by name. Keys are those of the scenario, dotted (`control.planner=false`); values are TOML.
//!
//! `series=FILE` lands on a measured heave in place of the case's deck: a table with the columns
//! `hour`, `min`, `sec`, `msec` and `z(m)`, as wave buoys give it, scaled to the significant height
//! `height=METRES` (0.5 without).
#![allow(clippy::print_stdout)]

use rayon::prelude::*;
use touchdown_sim::deck::rigid::{Axis, RigidDeck};
use touchdown_sim::deck::series::{Channel, Column, MotionSeries, SeriesFormat};
use touchdown_sim::landing::space::{Case, SpaceLander, SpaceLanding, SpaceOutcome, SpaceScenario};

/// Sets a dotted key.
fn set(table: &mut toml::Table, key: &str, value: &str) -> Result<(), Box<dyn std::error::Error>> {
    let parsed: toml::Table = toml::from_str(&format!("value = {value}"))?;
    let mut parts: Vec<&str> = key.split('.').collect();
    let last = parts.pop().ok_or("an empty key")?;
    let mut here = table;
    for part in parts {
        here = here
            .get_mut(part)
            .and_then(toml::Value::as_table_mut)
            .ok_or_else(|| format!("no table `{part}` in `{key}`"))?;
    }
    here.insert(last.to_owned(), parsed["value"].clone());
    Ok(())
}

/// A buoy's heave as a deck.
fn measured(file: &str, height_m: f64) -> Result<RigidDeck, Box<dyn std::error::Error>> {
    let part = |column: &str, factor: f64| Column {
        column: column.to_owned(),
        factor,
    };
    let format = SeriesFormat {
        time: vec![
            part("hour", 3600.0),
            part("min", 60.0),
            part("sec", 1.0),
            part("msec", 1e-3),
        ],
        channels: vec![Channel {
            axis: Axis::Heave,
            column: "z(m)".to_owned(),
            factor: 1.0,
        }],
        longest_step_s: 0.5,
        greatest_excursion_m: 15.0,
        greatest_angle_rad: 0.8,
    };
    let series = MotionSeries::read_csv(std::fs::File::open(file)?, &format)?;
    Ok(series.scaled_to(height_m)?.deck())
}

fn quantile(sorted: &[f64], share: f64) -> f64 {
    let last = sorted.len().saturating_sub(1) as f64;
    sorted
        .get((share * last).round() as usize)
        .copied()
        .unwrap_or(f64::NAN)
}

fn line(name: &str, mut values: Vec<f64>) {
    values.sort_by(f64::total_cmp);
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    println!(
        "{name:16} mean {mean:8.4}  50% {:8.4}  95% {:8.4}  99% {:8.4}  max {:8.4}",
        quantile(&values, 0.5),
        quantile(&values, 0.95),
        quantile(&values, 0.99),
        quantile(&values, 1.0)
    );
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (settings, words): (Vec<String>, Vec<String>) =
        std::env::args().skip(1).partition(|arg| arg.contains('='));
    let name = words.first().map_or("paper", String::as_str);
    let number = |k: usize, or: u64| words.get(k).map_or(Ok(or), |word| word.parse::<u64>());
    let (trials, seed) = (number(1, 100)?, number(2, 1)?);
    let case = Case::named(name).ok_or_else(|| format!("no case `{name}`"))?;
    let mut table = toml::Table::try_from(case.scenario())?;
    let (mut series, mut height_m) = (None, 0.5);
    for setting in &settings {
        match setting.split_once('=').unwrap_or((setting, "")) {
            ("series", file) => series = Some(file),
            ("height", metres) => height_m = metres.parse()?,
            (key, value) => set(&mut table, key, value)?,
        }
    }
    let scenario: SpaceScenario = table.try_into()?;
    let mut lander = SpaceLander::new(&scenario)?;
    if let Some(file) = series {
        lander = lander.with_deck(measured(file, height_m)?)?;
    }
    if words.get(3).is_some_and(|word| word == "trace") {
        return trace(&lander, trials, seed);
    }
    let landings: Vec<SpaceLanding> = (0..trials)
        .into_par_iter()
        .map(|trial| lander.land(trial, seed, false))
        .collect::<Result<_, _>>()?;
    report(name, &landings);
    Ok(())
}

/// Prints one landing row by row.
fn trace(lander: &SpaceLander, trial: u64, seed: u64) -> Result<(), Box<dyn std::error::Error>> {
    let landing = lander.land(trial, seed, true)?;
    println!(
        "# {:?} {:?} {:?}",
        landing.outcome, landing.touch, landing.aborts
    );
    println!(
        "time,phase,z,v,ez,ev,x,y,ex,ey,deck_v,edeck_v,edeck_sd,deck_a,edeck_a,thrust,gef,gef_hat,dz,tilt,feet,sd_z,rz,rv,latency"
    );
    for row in landing.trace.iter().flat_map(|trace| &trace.rows) {
        let feet: f64 = row.feet_n.iter().sum();
        let [w, x, y, z] = row.attitude;
        let tilt = 2.0 * (x * x + y * y).sqrt().atan2((w * w + z * z).sqrt());
        println!(
            "{:.2},{:?},{:.4},{:.4},{:.4},{:.4},{:.4},{:.4},{:.4},{:.4},{:.3},{:.3},{:.3},{:.3},{:.3},{:.3},{:.3},{:.3},{:.3},{:.4},{:.1},{:.4},{:.4},{:.4},{:.4}",
            row.time_s,
            row.phase,
            row.relative_m[2],
            row.relative_mps[2],
            row.estimated_m[2],
            row.estimated_mps[2],
            row.relative_m[0],
            row.relative_m[1],
            row.estimated_m[0],
            row.estimated_m[1],
            row.deck_mps[2],
            row.estimated_deck_mps,
            row.estimated_deck_sd_mps,
            row.deck_mps2[2],
            row.estimated_deck_mps2,
            row.thrust_n.unwrap_or(0.0),
            row.ground_effect_n,
            row.counted_ground_effect_n,
            row.disturbance_n[2],
            tilt,
            feet,
            row.estimated_sd_m[2],
            row.target.unwrap_or_default()[0],
            row.target.unwrap_or_default()[1],
            row.estimated_latency_s,
        );
    }
    Ok(())
}

fn report(name: &str, landings: &[SpaceLanding]) {
    let count = |of: &dyn Fn(&SpaceLanding) -> bool| landings.iter().filter(|l| of(l)).count();
    let landed = count(&|l| l.outcome.landed());
    let first = count(&|l| l.outcome == SpaceOutcome::Landed { attempts: 1 });
    let crashed = count(&|l| l.outcome.crashed());
    let without = count(&|l| l.outcome.crashed() && l.aborts.is_empty());
    println!(
        "{name}: {} trials, landed {landed} (first attempt {first}), crashed {crashed} (without an abort {without})",
        landings.len()
    );
    for landing in landings.iter().filter(|l| !l.outcome.landed()).take(10) {
        println!(
            "  {}: {:?} {:?} {:?}",
            landing.trial_index, landing.outcome, landing.touch, landing.aborts
        );
    }
    let mut reasons = std::collections::BTreeMap::<String, usize>::new();
    for abort in landings.iter().flat_map(|l| &l.aborts) {
        *reasons.entry(format!("{:?}", abort.reason)).or_default() += 1;
    }
    println!("  aborts {reasons:?}");
    let touches = || {
        landings
            .iter()
            .filter(|l| l.outcome.landed())
            .filter_map(|l| l.touch)
    };
    line("  T_L s", touches().map(|t| t.t_l_s).collect());
    line("  V_L m/s", touches().map(|t| t.v_l_mps).collect());
    line("  S_L m", touches().map(|t| t.s_l_m).collect());
    line("  lateral m", touches().map(|t| t.lateral_m).collect());
    line("  lateral m/s", touches().map(|t| t.lateral_mps).collect());
    line("  tilt rad", touches().map(|t| t.tilt_rad).collect());
    let of = |value: fn(&SpaceLanding) -> f64| landings.iter().map(value).collect();
    line(
        "  before s",
        landings.iter().filter_map(|l| l.before_descent_s).collect(),
    );
    line("  waited s", of(|l| l.waited_s));
    line("  end s", of(|l| l.end_s));
    line("  latency s", of(|l| l.estimated_latency_s));
    line("  bounces", of(|l| f64::from(l.bounces)));
    line("  foot N", of(|l| l.greatest_foot_n));
    let mut worst: Vec<_> = landings
        .iter()
        .filter_map(|l| Some((l.touch?.v_l_mps, l.trial_index)))
        .collect();
    worst.sort_by(|a, b| b.0.total_cmp(&a.0));
    println!("  hardest {:?}", &worst[..worst.len().min(5)]);
    println!("  steps {}", landings.iter().map(|l| l.steps).sum::<u64>());
}
