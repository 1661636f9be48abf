//! `touchdown campaign`.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::Serialize;
use touchdown::{Error, Result};
use touchdown_campaign::files::write;
use touchdown_campaign::sweep::{
    self, CampaignPart, CampaignResults, CampaignStatus, LandingRow, SampleSummary, Shard,
    Simulation, Store, Sweep, summarise,
};
use touchdown_campaign::{Place, recording};
use touchdown_sim::landing::space::SpaceTrace;

use super::args::land::{CampaignArgs, CampaignCommand};
use super::block_size;
use super::context::Context;
use super::identify::load::word;
use super::land::outcomes;
use super::output;
use super::slurm;
use super::software_in_the_loop::{AutopilotBackend, Autopilots};
use touchdown_terminal::Done;

/// Ranges of missing blocks that are printed; --json has all of them. Ten fill a line.
const SHOWN_RANGES: usize = 10;

/// Report of a run that flew a part of the campaign.
#[derive(Serialize)]
struct PartialCampaign<'a> {
    schema: u32,
    version: &'static str,
    sweep_sha256: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    shard: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    range: Option<String>,
    complete: bool,
    blocks: u64,
    blocks_there: u64,
}

pub(crate) fn run(context: &Context, args: &CampaignArgs) -> Result<Done> {
    match &args.command {
        Some(CampaignCommand::Merge { folders, out, mcap }) => {
            mcap.as_deref().map_or(Ok(()), output::folder)?;
            context.writes_into(out);
            let shards: Vec<Place> = folders
                .iter()
                .map(|folder| place(folder))
                .collect::<Result<_>>()?;
            let (sweep, store) = sweep::merge(&shards, &place(out)?)?;
            report(context, &sweep, &store, mcap.as_deref())
        }
        Some(CampaignCommand::Status { folder }) => {
            let place = place(folder)?;
            print_status(context, &place, &sweep::status(&place)?)
        }
        Some(CampaignCommand::Block(args)) => block_size::run(context, args),
        Some(CampaignCommand::Slurm(args)) => slurm::run(context, args),
        Some(CampaignCommand::Replay {
            sweep,
            landings,
            mcap,
        }) => replay(context, &Sweep::read(sweep, None, None)?, landings, mcap),
        None => fly(context, args),
    }
}

/// Where the files of a campaign are. Keys and endpoints of object storage are those of the environment.
fn place(out: &Path) -> Result<Place> {
    Ok(touchdown_storage::place(out, std::env::vars_os())?)
}

/// States what of the vehicle and the deck follows from the files, and the air in which the vehicle can land.
pub(crate) fn state(context: &Context, sweep: &Sweep) -> Result<()> {
    for text in [sweep.vehicle(), sweep.motion()].into_iter().flatten() {
        context.aside(text);
    }
    for warning in sweep.warnings().iter().chain(&sweep.lift_warning()) {
        context.warn(warning);
    }
    for warning in sweep
        .noise_warnings()?
        .iter()
        .chain(&sweep.deck_warnings()?)
    {
        context.warn(warning);
    }
    if let Some(text) = sweep.air()? {
        context.aside(&text);
    }
    Ok(())
}

fn fly(context: &Context, args: &CampaignArgs) -> Result<Done> {
    let Some(path) = &args.sweep else {
        return Err(Error::Arguments("expected a sweep file".into()));
    };
    output::must_not_be_a_file(Some(&args.out))?;
    let place = place(&args.out)?;
    let part = args.part();
    let sweep = Sweep::read_part(path, args.trials, args.seed, part)?;
    state(context, &sweep)?;
    if let CampaignPart::Shard(shard) = part {
        warn_of_empty_shards(context, &sweep, shard);
    }
    let with_autopilot = sweep.settings().autopilot.is_some();
    if with_autopilot {
        sweep.check_in_the_loop()?;
    }
    if let (true, Some(_)) = (with_autopilot, &args.mcap) {
        return Err(Error::Arguments(
            "--mcap: a landing under an autopilot cannot be flown again; `software_in_the_loop.record = true` records it while \
             it is flown"
                .into(),
        ));
    }
    if let (true, Place::Storage(_)) = (with_autopilot, &place) {
        return Err(Error::Arguments(format!(
            "--out {place}: expected a folder, because an autopilot in the loop writes records and logs, found an address"
        )));
    }
    // Before the place is begun; a part writes no records.
    if part == CampaignPart::Whole {
        args.mcap.as_deref().map_or(Ok(()), output::folder)?;
    }
    let backend = AutopilotBackend::of(context, &sweep, &args.out)?;
    let store = Arc::new(Store::open(&place, &sweep, part, args.resume)?);
    // Before anything is removed: a broken block ends the command.
    let missing = sweep::missing(&sweep, &store, part)?;
    if part == CampaignPart::Whole {
        place.begin_results()?;
        output::announce_results(context, &args.out);
    }
    let (resume, out) = (resume(args, path), args.out.display().to_string());
    let (blocks, written) = (sweep.blocks(), Arc::clone(&store));
    let autopilots = backend.as_ref().map(AutopilotBackend::autopilots);
    context.if_interrupted(move || {
        autopilots.iter().for_each(Autopilots::interrupt);
        let there = written.present().map_or(0, |blocks| blocks.len());
        format!("{there} of {blocks} blocks of landings are in {out}; `{resume}` runs the others")
    });
    let there = side_by_side(args.threads, || match &backend {
        Some(backend) => sweep::fly(backend, &sweep, &store, &missing, context),
        None => Ok(sweep::fly(&Simulation, &sweep, &store, &missing, context)?),
    })?;
    if part == CampaignPart::Whole {
        return report(context, &sweep, &store, args.mcap.as_deref());
    }
    part_flown(context, args, &sweep, there);
    Ok(Done::Whole)
}

/// Reports a run that flew a part of the campaign.
fn part_flown(context: &Context, args: &CampaignArgs, sweep: &Sweep, there: u64) {
    let blocks = sweep.blocks();
    context.finish();
    if args.mcap.is_some() {
        context.warn(
            "--mcap: a part writes no records, because only the whole campaign knows its worst landings; `touchdown campaign \
             merge --mcap` writes them",
        );
    }
    let (named, out) = (named(args.part()), args.out.display());
    context.say(&match there == blocks {
        true => format!(
            "{named}: all {blocks} blocks of landings are in {out}; `touchdown campaign merge {0} --out {0}` writes figures and \
             report",
            word(&out.to_string())
        ),
        false => format!(
            "{named}: {there} of {blocks} blocks of landings are in {out}; `touchdown campaign merge` combines the shards"
        ),
    });
    context.object(&PartialCampaign {
        schema: 1,
        version: env!("CARGO_PKG_VERSION"),
        sweep_sha256: sweep.sha256(),
        shard: args.shard.map(|shard| shard.to_string()),
        range: args.blocks.map(|range| range.to_string()),
        complete: there == blocks,
        blocks,
        blocks_there: there,
    });
}

/// A part in words.
fn named(part: CampaignPart) -> String {
    match part {
        CampaignPart::Whole => "campaign".to_string(),
        CampaignPart::Shard(shard) => format!("shard {shard}"),
        CampaignPart::Blocks(range) => format!("blocks {range}"),
    }
}

/// Warns of shards that have nothing to fly: a block is not cut.
fn warn_of_empty_shards(context: &Context, sweep: &Sweep, shard: Shard) {
    let (shards, blocks) = (shard.count(), sweep.blocks());
    if shards <= blocks {
        return;
    }
    context.warn(&format!(
        "--shard {shard}: the campaign has {blocks} {} of landings, so {} of {shards} shards fly nothing. {}",
        if blocks == 1 { "block" } else { "blocks" },
        shards - blocks,
        smaller_blocks(sweep, shards),
    ));
}

/// What to do where a campaign has fewer blocks than parts are wanted.
pub(crate) fn smaller_blocks(sweep: &Sweep, parts: u64) -> String {
    let (landings, block) = (sweep.landings(), sweep.settings().block);
    match landings / parts {
        0 => format!("It has {landings} landings: fewer than {parts}"),
        least => format!("Set `block = {least}` in the sweep (now {block})"),
    }
}

/// What is there, what is missing as `--blocks` takes it, and what to do next. A broken block is lost input.
fn print_status(context: &Context, place: &Place, status: &CampaignStatus) -> Result<Done> {
    let out = word(&place.to_string());
    let mut lines = vec![format!(
        "{place}: {} of {} blocks are there, with {} of {} landings",
        status.blocks_there, status.blocks, status.rows, status.landings
    )];
    let shown = &status.missing[..status.missing.len().min(SHOWN_RANGES)];
    let ranges: Vec<String> = shown.iter().map(|[a, b]| format!("{a}..{b}")).collect();
    if !ranges.is_empty() {
        let more = if shown.len() < status.missing.len() {
            ", …"
        } else {
            ""
        };
        lines.push(format!("missing blocks: {}{more}", ranges.join(", ")));
        let sweep = match place {
            Place::Folder(_) => format!("{out}/sweep.toml"),
            Place::Storage(_) => "SWEEP".to_owned(),
        };
        lines.push(format!(
            "`touchdown campaign {sweep} --out {out} --resume` flies them"
        ));
    } else if status.complete && !place.has(output::RESULTS)? {
        lines.push(format!(
            "`touchdown campaign merge {out} --out {out}` writes figures and report"
        ));
    }
    context.say(&lines.join("\n"));
    for broken in &status.broken {
        context.warn(&format!(
            "block {} is broken: {}. Delete its file, then --resume",
            broken.block, broken.error
        ));
    }
    context.object(status);
    Ok(Done::with_loss(!status.broken.is_empty()))
}

/// Runs a computation on as many threads as were asked for.
fn side_by_side<T: Send>(
    threads: Option<u16>,
    run: impl FnOnce() -> Result<T> + Send,
) -> Result<T> {
    let Some(threads) = threads else {
        return run();
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.into());
    let pool = pool
        .build()
        .map_err(|e| Error::Arguments(format!("--threads: {e}")))?;
    pool.install(run)
}

/// The command that flies the landings that are missing.
fn resume(args: &CampaignArgs, sweep: &Path) -> String {
    let path = |p: &Path| word(&p.display().to_string());
    let mut words = vec!["touchdown campaign".to_string(), path(sweep)];
    let mut option = |name: &str, value: Option<String>| {
        words.extend(value.map(|value| format!("{name} {value}")));
    };
    option("--shard", args.shard.map(|s| s.to_string()));
    option("--blocks", args.blocks.map(|b| b.to_string()));
    option("--threads", args.threads.map(|n| n.to_string()));
    option("--trials", args.trials.map(|n| n.to_string()));
    option("--seed", args.seed.map(|n| n.to_string()));
    option("--mcap", args.mcap.as_deref().map(path));
    option("--out", Some(path(&args.out)));
    words.join(" ") + " --resume"
}

/// Figures, tables and the report of a complete campaign.
fn report(context: &Context, sweep: &Sweep, store: &Store, mcap: Option<&Path>) -> Result<Done> {
    let rows: Vec<LandingRow> = store.read_all(sweep)?;
    let results = summarise(sweep, &rows)?;
    let landings: Vec<u64> = results.worst.iter().map(|worst| worst.landing).collect();
    let worst = match results.autopilot {
        // No landing under an autopilot is flown twice alike.
        Some(_) => Vec::new(),
        None => sweep::replay(sweep, &landings)?,
    };
    if let Some(folder) = mcap {
        records(&landings, &worst, folder)?;
    }
    store.place().publish(|out| {
        write(&out.join("summary.csv"), results.csv()?.as_bytes())?;
        write_report(sweep, &rows, &results, &worst, out)
    })?;
    let out = PathBuf::from(store.place().to_string());
    Ok(print_report(context, sweep, &rows, &results, &out))
}

/// Writes the report and the results.
pub(crate) fn write_report(
    sweep: &Sweep,
    rows: &[LandingRow],
    results: &CampaignResults,
    worst: &[SpaceTrace],
    out: &Path,
) -> Result<()> {
    touchdown_pages::campaign(sweep, rows, results, worst, out)?;
    output::results(out, results)
}

/// Prints the summary, why landings did not land, and where the report is.
pub(crate) fn print_report(
    context: &Context,
    sweep: &Sweep,
    rows: &[LandingRow],
    results: &CampaignResults,
    out: &Path,
) -> Done {
    let mut lines = vec![table(results)];
    lines.extend(outcomes::not_flown(sweep, rows, results));
    lines.extend(outcomes::failures(sweep, rows, results));
    lines.extend(results.redrawn_texts());
    context.reported(&lines.join("\n"), out, results);
    Done::Whole
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
    context.writes_into(mcap);
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
        "{:<width$}  {:>7} {:>7} {:>7} {:>7} {:>7}  {:>13}  {:>15} {:>6}  {:>11} {:>6}",
        "point",
        "trials",
        "landed",
        "first",
        "hard",
        "crashed",
        "T_L [s]",
        "V_L [m/s]",
        "99 %",
        "lateral [m]",
        "95 %"
    )];
    for p in &results.points {
        let count =
            |share: Option<touchdown_campaign::statistics::Share>| share.map_or(0, |s| s.count);
        let spread = |s: &SampleSummary, digits: usize| match (s.mean, s.sd) {
            (Some(mean), Some(sd)) => format!("{mean:.digits$} ± {sd:.digits$}"),
            (Some(mean), None) => format!("{mean:.digits$}"),
            _ => "–".to_string(),
        };
        let one = |value: Option<f64>| value.map_or("–".to_string(), |v| format!("{v:.3}"));
        lines.push(format!(
            "{:<width$}  {:>7} {:>7} {:>7} {:>7} {:>7}  {:>13}  {:>15} {:>6}  {:>11} {:>6}",
            p.of.label(),
            p.figures.trials,
            count(p.figures.landed),
            count(p.figures.landed_at_first),
            count(p.figures.hard),
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
