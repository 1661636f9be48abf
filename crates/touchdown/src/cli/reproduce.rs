//! `touchdown reproduce`.

use touchdown::Result;
use touchdown_reproduce::experiments;
use touchdown_reproduce::experiments::results::Results;
use touchdown_reproduce::folder;
use touchdown_reproduce::settings::{Overrides, ReproduceSettings};
use touchdown_sim::landing::space::Case;

use super::args::ReproduceArgs;
use super::context::Context;
use super::output;
use touchdown_terminal::Done;

pub(crate) fn run(context: &Context, args: &ReproduceArgs) -> Result<Done> {
    let settings = load(args)?;
    // A folder that cannot be written to is better known before the work than after it.
    output::must_not_be_a_campaign(&args.out)?;
    output::folder(&args.out)?;
    let run = experiments::run(&settings, context)?;
    let results = Results::of(&run)?;
    output::announce_results(context, &args.out);
    folder::write(&run, &results, &args.out, context)?;
    context.reported(&summary(&results), &args.out, &results);
    Ok(Done::Whole)
}

fn load(args: &ReproduceArgs) -> Result<ReproduceSettings> {
    let file = args.settings.as_deref();
    let given = file.map(ReproduceSettings::from_file).transpose()?;
    let overrides = Overrides {
        quick: args.quick,
        seed: args.seed,
        trials: args.trials,
    };
    let settings = overrides.of(given);
    let named = file.map_or_else(
        || "arguments".to_string(),
        |file| file.display().to_string(),
    );
    experiments::check(&settings, &named)?;
    Ok(settings)
}

/// The main figures in a few lines.
fn summary(results: &Results) -> String {
    let mut out = String::new();
    let mut line = |text: String| {
        out.push_str(&text);
        out.push('\n');
    };
    let number = |v: Option<f64>| v.map_or_else(|| "–".to_string(), |v| format!("{v:.3}"));
    line("throttle to thrust, plate removed, mean absolute error in free run [N]".into());
    for (model, kinds) in &results.thrust.plate_removed {
        let figures: Vec<String> = kinds
            .iter()
            .map(|(kind, e)| format!("{kind} {}", number(e.mae_n)))
            .collect();
        line(format!("  {model:<18} {}", figures.join("   ")));
    }
    line("ground effect, rich data, mean absolute error in free run [N]".into());
    for (form, kinds) in &results.ground_effect.rich_data {
        let figures: Vec<String> = kinds
            .iter()
            .map(|(kind, e)| format!("{kind} {}", number(e.mae_n)))
            .collect();
        line(format!("  {form:<18} {}", figures.join("   ")));
    }
    for (title, methods) in [
        ("landing on the ground", &results.ground_landing),
        (
            "landing on the deck, its acceleration fed forward",
            &results.deck_landing.with_acceleration,
        ),
        (
            "landing on the deck, its acceleration not fed forward",
            &results.deck_landing.without_acceleration,
        ),
    ] {
        line(title.into());
        for (method, f) in methods {
            let mean =
                |s: Option<touchdown_campaign::statistics::Summary>| number(s.map(|s| s.mean));
            line(format!(
                "  {method:<10} landed {:>3} of {:<3} (hard {}, crashed {})  T_L {} s   V_L {} m/s   S_L {} m",
                f.landed,
                f.trials,
                f.hard,
                f.crashed,
                mean(f.t_l_s),
                mean(f.v_l_mps),
                mean(f.s_l_m)
            ));
        }
    }
    line("  imbc takes no deck acceleration: both blocks show the same landings of it".into());
    let mut cases = Vec::new();
    line("at sea, in six degrees of freedom, as planned".into());
    let decks = results.sea.decks.iter();
    let planned = decks.filter_map(|(deck, ways)| Some((deck, ways.get("planned")?)));
    for (case, f) in planned.chain(&results.sea.faults) {
        let count = |of: Option<touchdown_campaign::statistics::Share>| of.map_or(0, |s| s.count);
        line(format!(
            "  {case:<13} landed {:>3} of {:<3}  hard {:<3} crashed {:<3} T_L {} s   V_L {} m/s   lateral {} m",
            count(f.landed),
            f.trials,
            count(f.hard),
            count(f.crashed),
            number(f.t_l_s.mean),
            number(f.v_l_mps.mean),
            number(f.lateral_m.mean)
        ));
        cases.extend(Case::named(case));
    }
    line("  where".into());
    for case in cases {
        line(format!("    {:<13} {}", case.name(), case.description()));
    }
    out.pop();
    out
}
