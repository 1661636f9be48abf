//! `touchdown campaign slurm`: a campaign as a job array.

use std::path::{Path, PathBuf};

use serde::Serialize;
use touchdown::{Error, Result};
use touchdown_campaign::sweep::Sweep;
use touchdown_files::is_address;
use touchdown_terminal::Done;

use super::args::land::SlurmArgs;
use super::campaign::smaller_blocks;
use super::context::Context;
use super::identify::load::word;

/// The script as an object.
#[derive(Serialize)]
struct JobScript {
    schema: u32,
    version: &'static str,
    script: String,
}

/// What the script does after its first lines.
const BODY: &str = r#"set -euo pipefail

if [ "${1:-}" = merge ]; then
  exec "$touchdown" campaign merge "$out" --out "$out" --quiet
fi

if [ -z "${SLURM_ARRAY_TASK_ID:-}" ]; then
  mkdir -p "$out/slurm"
  array=$(sbatch --parsable --output="$out/slurm/%A_%a.log" "$@" "$0")
  array=${array%%;*}
  # After all tasks have ended, however: a merge says which blocks are missing.
  merge=$(sbatch --parsable --array=1 --job-name=touchdown-merge --dependency="afterany:$array" \
    --output="$out/slurm/%A_merge.log" "$@" "$0" merge)
  echo "submitted: $tasks tasks as job $array, their merge as job ${merge%%;*}; logs in $out/slurm"
  exit
fi

blocks() { find "$out/landings" -name 'block-*' 2>/dev/null | wc -l || true; }

# Shortly before the time ends. Every new turn needs a new block of the campaign, so turns end.
requeue() {
  kill -TERM "$campaign" 2>/dev/null || true
  wait "$campaign" || true
  if [ "$(blocks)" -le "$before" ]; then
    echo "no block was written in the time of this task: it needs more time (--time), or the sweep a smaller block"
    exit 1
  fi
  scontrol requeue "${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID"
  # Slurm ends the task.
  sleep 60
  exit 1
}

before=$(blocks)
"$touchdown" campaign "$sweep" --shard "$SLURM_ARRAY_TASK_ID/$tasks" --threads "${SLURM_CPUS_PER_TASK:-1}" \
  --out "$out" --resume --quiet "${draws[@]}" &
campaign=$!
trap requeue USR1
wait "$campaign"
"#;

pub(crate) fn run(context: &Context, args: &SlurmArgs) -> Result<Done> {
    if is_address(&args.out) {
        return Err(Error::Arguments(format!(
            "--out {}: expected a folder on a disk that all nodes see, found an address; tasks that fly into object storage are \
             `touchdown campaign SWEEP --blocks A..B --resume --out {}`",
            args.out.display(),
            word(&args.out.display().to_string())
        )));
    }
    let sweep = Sweep::read(&args.sweep, args.trials, args.seed)?;
    if args.tasks > sweep.blocks() {
        return Err(Error::Arguments(format!(
            "--tasks {}: expected at most {}, one for each block of landings. {}",
            args.tasks,
            sweep.blocks(),
            smaller_blocks(&sweep, args.tasks)
        )));
    }
    let script = script(args, &sweep)?;
    match context.wants_json() {
        true => context.object(&JobScript {
            schema: 1,
            version: env!("CARGO_PKG_VERSION"),
            script,
        }),
        false => context.print(&script),
    }
    Ok(Done::Whole)
}

fn script(args: &SlurmArgs, sweep: &Sweep) -> Result<String> {
    let program = std::env::current_exe().map_err(|e| Error::file(Path::new("touchdown"), e))?;
    let absolute = |path: &Path| -> Result<String> {
        let path: PathBuf = std::path::absolute(path).map_err(|e| Error::file(path, e))?;
        Ok(word(&path.display().to_string()))
    };
    let draws: Vec<String> = [("--trials", args.trials), ("--seed", args.seed)]
        .into_iter()
        .filter_map(|(name, value)| Some(format!("{name} {}", value?)))
        .collect();
    let time = match &args.time {
        Some(time) => format!("#SBATCH --time={time}\n"),
        None => String::new(),
    };
    Ok(format!(
        "#!/bin/bash
# {landings} landings in {blocks} blocks, flown by {tasks} tasks of Slurm. Written by `touchdown campaign slurm` {version}.
#
#   bash THIS_FILE [options of sbatch]
#
# submits the tasks, and behind them the job that merges. All write into one folder, on a disk that all nodes see. A task
# that is preempted, loses its node or runs out of time is queued again, and flies only what is missing.
#SBATCH --job-name=touchdown
#SBATCH --array=1-{tasks}
#SBATCH --cpus-per-task={cpus}
{time}#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --signal=B:USR1@60
touchdown=${{TOUCHDOWN:-{program}}}
sweep={sweep}
out={out}
tasks={tasks}
draws=({draws})
{BODY}",
        landings = sweep.landings(),
        blocks = sweep.blocks(),
        tasks = args.tasks,
        version = env!("CARGO_PKG_VERSION"),
        cpus = args.cpus,
        program = absolute(&program)?,
        sweep = absolute(&args.sweep)?,
        out = absolute(&args.out)?,
        draws = draws.join(" "),
    ))
}

/// A time limit as `sbatch` takes it: minutes, minutes:seconds, hours:minutes:seconds, or with days and a dash before.
pub(super) fn time_limit(text: &str) -> std::result::Result<String, String> {
    let number = |part: &str| !part.is_empty() && part.bytes().all(|b| b.is_ascii_digit());
    let (days, clock) = text.split_once('-').unwrap_or(("0", text));
    let parts: Vec<&str> = clock.split(':').collect();
    if number(days) && parts.len() <= 3 && parts.into_iter().all(number) {
        return Ok(text.to_string());
    }
    Err("expected a time as sbatch takes it, such as 30, 02:00:00 or 1-12".to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_times_are_those_of_sbatch() {
        for good in ["30", "30:00", "02:00:00", "1-12", "1-12:30", "2-00:00:30"] {
            assert_eq!(time_limit(good).as_deref(), Ok(good));
        }
        for bad in ["", "1h", "1:", "-5", "1:2:3:4", "5\n#SBATCH --x", "1-"] {
            assert!(time_limit(bad).is_err(), "{bad}");
        }
    }
}
