//! What identification from many files costs: processor time, memory and traffic of each part, measured, and from them the cost of 10⁹
//! rows on 1, 8 and 64 workers, computed.
//!
//! `cargo run --release -p sindy --example 09_partial_sums [FILES] [ROWS]`
//!
//! Each file holds Lorenz's system with noise: time and three states as raw numbers of 8 bytes. A worker has one thread. The
//! library is `poly(3)`, 20 terms for each state.
#![allow(clippy::print_stdout)]

use std::cell::Cell;
use std::error::Error;
use std::fs::File;
use std::io::{BufWriter, Read as _, Write as _};
use std::path::{Path, PathBuf};

use rand::SeedableRng as _;
use rand_distr::{Distribution as _, StandardNormal};
use rand_pcg::Pcg64;
use rustix::time::{ClockId, clock_gettime};
use sindy::identify::{Columns, PartialSums};
use sindy::{Block, BlockSource, Identify, Library};

const NAMES: [&str; 4] = ["t", "x", "y", "z"];
/// Rows that are read at a time.
const BLOCK: usize = 50_000;
/// Rows of the computed table.
const ALL: f64 = 1e9;

fn main() -> Result<(), Box<dyn Error>> {
    let mut numbers = std::env::args().skip(1).map(|a| a.parse::<usize>());
    let files = numbers.next().transpose()?.unwrap_or(8);
    let rows = numbers.next().transpose()?.unwrap_or(1_000_000);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let folder = tempfile::tempdir()?;
    let paths: Vec<PathBuf> = (0..files)
        .map(|k| folder.path().join(k.to_string()))
        .collect();
    for (seed, path) in paths.iter().enumerate() {
        write(path, rows, seed as u64)?;
    }
    let measured = pool
        .install(|| measure(&paths))
        .map_err(|e| e.to_string())?;
    measured.print(files * rows);
    Ok(())
}

/// Seconds and bytes of the parts.
#[derive(Debug, Default)]
struct Measured {
    /// The plan from the first rows, by every worker.
    plan: f64,
    /// The pass, and in it the reading of files.
    pass: f64,
    reading: f64,
    /// Partial sums: their text, in bytes, made and read back, and merged.
    bytes: f64,
    written: f64,
    read: f64,
    merged: f64,
    /// The end of the identification.
    end: f64,
    /// The most memory that the process has held, in MB, where the system says so.
    peak: Option<f64>,
}

fn measure(paths: &[PathBuf]) -> Result<Measured, Box<dyn Error + Send + Sync>> {
    let mut out = Measured::default();
    let identify = Identify::new(Library::polynomial(&NAMES[1..], 3)?);
    let columns = Columns::new("t", &NAMES[1..], &[])?;
    let sources: Vec<Raw> = paths.iter().map(|p| Raw::new(p)).collect();
    let all: Vec<&dyn BlockSource> = sources.iter().map(|s| s as _).collect();
    let names: Vec<String> = paths.iter().map(|p| p.display().to_string()).collect();
    let (empty, time) = timed(|| identify.partial_sums(&columns, &names, &all[..]));
    let empty = empty?;
    // The plan needs the first block alone; this source reads its file to the end.
    out.plan = time - sources[0].seconds.take();
    // A worker for each half of the files.
    let mut parts = [empty.clone(), empty];
    for (k, source) in sources.iter().enumerate() {
        let part = &mut parts[2 * k / sources.len()];
        let (added, time) = timed(|| part.add(k, source));
        added?;
        out.pass += time;
        out.reading += source.seconds.get();
    }
    out.peak = peak();
    let mut total: Option<PartialSums> = None;
    for part in &parts {
        let (text, time) = timed(|| part.to_json());
        let text = text?;
        out.written += 0.5 * time;
        out.bytes += 0.5 * text.len() as f64;
        let (part, time) = timed(|| PartialSums::from_json(&text));
        out.read += 0.5 * time;
        match &mut total {
            None => total = Some(part?),
            Some(total) => {
                let (merged, time) = timed(|| total.merge(part.clone()?));
                merged?;
                out.merged = time;
            }
        }
    }
    let total = total.ok_or("no part")?;
    let (found, time) = timed(|| total.identify(&mut |_| ()));
    out.end = time;
    println!("{:.3}\n", found?.model);
    Ok(out)
}

impl Measured {
    fn print(&self, rows: usize) {
        let per = |seconds: f64| 1e9 * seconds / rows as f64;
        println!("measured over {rows} rows, one thread, processor time");
        println!(
            "  plan from the first rows   {:>9.2} s for each worker",
            self.plan
        );
        println!(
            "  pass                       {:>9.0} ns a row",
            per(self.pass)
        );
        println!(
            "    reading of raw numbers   {:>9.0} ns a row",
            per(self.reading)
        );
        println!(
            "    slopes and sums          {:>9.0} ns a row",
            per(self.pass - self.reading)
        );
        println!("  partial sums               {:>9.1} MB", self.bytes / 1e6);
        println!(
            "    written, read            {:>9.3} s, {:.3} s",
            self.written, self.read
        );
        println!(
            "    merged                   {:>9.3} s for each",
            self.merged
        );
        println!("  end of the identification  {:>9.2} s", self.end);
        if let Some(peak) = self.peak {
            println!("  most memory of the process {peak:>9.0} MB");
        }
        println!(
            "\ncomputed from that for 1e9 rows, {:.0} GB of raw numbers",
            32.0 * ALL / 1e9
        );
        println!("| workers | plan | pass | merge | end | time | rows a worker | results sent |");
        println!("| --- | --- | --- | --- | --- | --- | --- | --- |");
        for workers in [1.0, 8.0, 64.0] {
            let pass = self.pass / rows as f64 * ALL / workers;
            let merge = self.written + workers * self.read + (workers - 1.0) * self.merged;
            let time = self.plan + pass + merge + self.end;
            let share = |seconds: f64| format!("{seconds:.1} s ({:.1} %)", 100.0 * seconds / time);
            println!(
                "| {workers} | {} | {} | {} | {} | {time:.0} s | {:.3e} | {:.1} MB |",
                share(self.plan),
                share(pass),
                share(merge),
                share(self.end),
                ALL / workers,
                workers * self.bytes / 1e6
            );
        }
    }
}

/// A result and its processor time in seconds: on a machine with other work it says more than the clock.
fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = processor();
    let out = work();
    (out, processor() - start)
}

/// Processor time of this process in seconds.
fn processor() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

/// A file of blocks: of each column [`BLOCK`] numbers, the last block shorter.
struct Raw {
    names: Vec<String>,
    path: PathBuf,
    /// Time of the last pass that went into reading.
    seconds: Cell<f64>,
}

impl Raw {
    fn new(path: &Path) -> Self {
        Self {
            names: NAMES.map(str::to_owned).into(),
            path: path.to_owned(),
            seconds: Cell::default(),
        }
    }

    fn columns(&self, bytes: &[u8]) -> Vec<Vec<f64>> {
        let rows = bytes.len() / 8 / NAMES.len();
        let numbers: Vec<f64> = bytes
            .chunks_exact(8)
            .filter_map(|b| b.try_into().ok().map(f64::from_le_bytes))
            .collect();
        numbers.chunks(rows.max(1)).map(<[f64]>::to_vec).collect()
    }
}

impl BlockSource for Raw {
    fn names(&self) -> &[String] {
        &self.names
    }

    fn groups(&self) -> usize {
        1
    }

    fn for_each_block(&self, visit: &mut dyn FnMut(Block<'_>)) {
        self.seconds.set(0.0);
        let Ok(mut file) = File::open(&self.path) else {
            return;
        };
        loop {
            let (columns, time) = timed(|| {
                let mut bytes = Vec::new();
                let length = (8 * NAMES.len() * BLOCK) as u64;
                let read = (&mut file).take(length).read_to_end(&mut bytes);
                read.map_or(Vec::new(), |_| self.columns(&bytes))
            });
            self.seconds.set(self.seconds.get() + time);
            if columns.is_empty() {
                return;
            }
            let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
            visit(Block {
                group: 0,
                columns: &columns,
            });
        }
    }
}

/// Lorenz's system by Runge-Kutta's fourth order, with noise of 0.1 % of the states' spread (8, 9 and 9).
fn write(path: &Path, rows: usize, seed: u64) -> std::io::Result<()> {
    let mut random = Pcg64::seed_from_u64(seed);
    let mut file = BufWriter::new(File::create(path)?);
    let mut state = [1.0 + seed as f64, 1.0, 20.0];
    let dt = 0.002;
    let slope = |[x, y, z]: [f64; 3]| [10.0 * (y - x), x * (28.0 - z) - y, x * y - 8.0 / 3.0 * z];
    let step = |s: [f64; 3], h: f64, d: [f64; 3]| [0, 1, 2].map(|i| s[i] + h * d[i]);
    for start in (0..rows).step_by(BLOCK) {
        let mut columns = vec![Vec::new(); NAMES.len()];
        for row in start..rows.min(start + BLOCK) {
            columns[0].push(dt * row as f64);
            for (i, spread) in [8.0, 9.0, 9.0].into_iter().enumerate() {
                let noise: f64 = StandardNormal.sample(&mut random);
                columns[1 + i].push(state[i] + 1e-3 * spread * noise);
            }
            let a = slope(state);
            let b = slope(step(state, 0.5 * dt, a));
            let c = slope(step(state, 0.5 * dt, b));
            let d = slope(step(state, dt, c));
            state = [0, 1, 2].map(|i| state[i] + dt / 6.0 * (a[i] + 2.0 * (b[i] + c[i]) + d[i]));
        }
        for value in columns.iter().flatten() {
            file.write_all(&value.to_le_bytes())?;
        }
    }
    file.flush()
}

/// The most memory that this process has held, in MB.
fn peak() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    let number: f64 = line.trim().trim_end_matches("kB").trim().parse().ok()?;
    Some(number / 1024.0)
}
