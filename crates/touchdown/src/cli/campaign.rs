//! `touchdown campaign`.

use std::path::{Path, PathBuf};

use serde::Serialize;
use touchdown::files::write;
use touchdown::sweep::{
    self, CampaignResults, LandingRow, SampleSummary, Shard, Store, Sweep, summarise,
};
use touchdown::{Error, Result, pages, recording};
use touchdown_sim::landing::space::SpaceTrace;

use super::args::{CampaignArgs, CampaignCommand};
use super::context::Context;
use super::output;
use touchdown_terminal::Done;

/// What a run says that did not complete the campaign.
#[derive(Serialize)]
struct Part<'a> {
    schema: u32,
    version: &'static str,
    sweep_sha256: &'a str,
    shard: String,
    complete: bool,
    blocks: u64,
    blocks_there: u64,
}

pub(crate) fn run(context: &Context, args: &CampaignArgs) -> Result<Done> {
    match &args.command {
        Some(CampaignCommand::Merge { folders, out, mcap }) => {
            mcap.as_deref().map_or(Ok(()), output::folder)?;
            let (sweep, store) = sweep::merge(folders, out)?;
            return report(context, &sweep, &store, out, mcap.as_deref());
        }
        Some(CampaignCommand::Replay {
            sweep,
            landings,
            mcap,
        }) => {
            return replay(context, &Sweep::read(sweep, None, None)?, landings, mcap);
        }
        None => {}
    }
    let Some(path) = &args.sweep else {
        return Err(Error::Arguments("expected a sweep file".into()));
    };
    let sweep = Sweep::read(path, args.trials, args.seed)?;
    let store = Store::open(&args.out, &sweep, args.resume)?;
    output::results_folder(&args.out)?;
    let shard = args.shard.unwrap_or(Shard::WHOLE);
    // Before the landings are flown that it is for; a shard writes no records.
    if let (None, Some(folder)) = (args.shard, &args.mcap) {
        output::folder(folder)?;
    }
    let there = sweep::fly(&sweep, &store, shard, context)?;
    if there < sweep.blocks() {
        context.finish();
        if args.mcap.is_some() {
            context.warn(
                "--mcap: no records are written, for which landings are the worst is known when all are flown; \
                 `touchdown campaign merge --mcap` writes them",
            );
        }
        context.say(&format!(
            "shard {shard}: {there} of {} blocks of landings are in {}; `touchdown campaign merge` puts shards together",
            sweep.blocks(),
            args.out.display()
        ));
        context.object(&Part {
            schema: 1,
            version: env!("CARGO_PKG_VERSION"),
            sweep_sha256: sweep.sha256(),
            shard: shard.to_string(),
            complete: false,
            blocks: sweep.blocks(),
            blocks_there: there,
        });
        return Ok(Done::Whole);
    }
    report(context, &sweep, &store, &args.out, args.mcap.as_deref())
}

/// Figures, tables and the report of a complete campaign.
fn report(
    context: &Context,
    sweep: &Sweep,
    store: &Store,
    out: &Path,
    mcap: Option<&Path>,
) -> Result<Done> {
    let rows: Vec<LandingRow> = store.read_all(sweep)?;
    let results = summarise(sweep, &rows)?;
    write(&out.join("summary.csv"), results.csv()?.as_bytes())?;
    let landings: Vec<u64> = results.worst.iter().map(|worst| worst.landing).collect();
    let worst = sweep::replay(sweep, &landings)?;
    if let Some(folder) = mcap {
        records(&landings, &worst, folder)?;
    }
    pages::campaign(sweep, &rows, &results, &worst, out)?;
    write(
        &out.join("results.json"),
        output::json(&results)?.as_bytes(),
    )?;
    context.finish();
    context.say(&table(&results));
    context.say(&format!("report: {}", out.join("report.html").display()));
    context.object(&results);
    Ok(Done::Whole)
}

/// What a replay has written.
#[derive(Serialize)]
struct Replayed {
    schema: u32,
    version: &'static str,
    files: Vec<PathBuf>,
}

fn replay(context: &Context, sweep: &Sweep, landings: &[u64], mcap: &Path) -> Result<Done> {
    output::folder(mcap)?;
    let files = records(landings, &sweep::replay(sweep, landings)?, mcap)?;
    for file in &files {
        context.say(&file.display().to_string());
    }
    context.object(&Replayed {
        schema: 1,
        version: env!("CARGO_PKG_VERSION"),
        files,
    });
    Ok(Done::Whole)
}

/// Writes records of landings as MCAP files.
fn records(landings: &[u64], traces: &[SpaceTrace], folder: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for (landing, trace) in landings.iter().zip(traces) {
        files.push(record(*landing, trace, folder, Recording::Mcap)?);
    }
    Ok(files)
}

/// Kinds of files that landings are recorded in.
#[derive(Clone, Copy)]
pub(crate) enum Recording {
    Mcap,
    Ulog,
}

/// Writes the record of a landing.
pub(crate) fn record(
    landing: u64,
    trace: &SpaceTrace,
    folder: &Path,
    kind: Recording,
) -> Result<PathBuf> {
    let (extension, bytes) = match kind {
        Recording::Mcap => ("mcap", recording::mcap(trace)?),
        Recording::Ulog => ("ulg", recording::ulog(trace)?),
    };
    let path = folder.join(format!("landing-{landing:06}.{extension}"));
    write(&path, &bytes)?;
    Ok(path)
}

/// The summary for people, a line for every point.
pub(crate) fn table(results: &CampaignResults) -> String {
    let width = results
        .points
        .iter()
        .map(|p| p.of.label().chars().count())
        .max()
        .unwrap_or(0)
        .max(5);
    let mut lines = vec![format!(
        "{:<width$}  {:>7} {:>7} {:>7} {:>7}  {:>13}  {:>15} {:>6}  {:>11} {:>6}",
        "point",
        "trials",
        "landed",
        "first",
        "crashed",
        "T_L [s]",
        "V_L [m/s]",
        "99 %",
        "lateral [m]",
        "95 %"
    )];
    for p in &results.points {
        let count = |share: Option<touchdown::statistics::Share>| share.map_or(0, |s| s.count);
        let spread = |s: &SampleSummary, digits: usize| match (s.mean, s.sd) {
            (Some(mean), Some(sd)) => format!("{mean:.digits$} ± {sd:.digits$}"),
            (Some(mean), None) => format!("{mean:.digits$}"),
            _ => "–".to_string(),
        };
        let one = |value: Option<f64>| value.map_or("–".to_string(), |v| format!("{v:.3}"));
        lines.push(format!(
            "{:<width$}  {:>7} {:>7} {:>7} {:>7}  {:>13}  {:>15} {:>6}  {:>11} {:>6}",
            p.of.label(),
            p.figures.trials,
            count(p.figures.landed),
            count(p.figures.landed_at_first),
            count(p.figures.crashed),
            spread(&p.figures.t_l_s, 2),
            spread(&p.figures.v_l_mps, 3),
            one(p.figures.v_l_mps.p99),
            one(p.figures.lateral_m.mean),
            one(p.figures.lateral_m.p95),
        ));
    }
    lines.join("\n")
}
