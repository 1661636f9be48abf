//! Landings as rows of a table.

use serde::Serialize;
use toml::Value;
use touchdown_flight::touch::TouchClass;
use touchdown_log::{LogError, ParquetValues, to_parquet};
use touchdown_sim::landing::space::{CrashSettings, SpaceLanding, SpaceOutcome};

use super::points::Sweep;
use super::seal::{SEAL, UNSEALED, is_intact, sealed};
use crate::error::{Error, Result};
use crate::place::Place;

/// Names of [`LandingRow::numbers`].
pub(super) const NUMBERS: [&str; 14] = [
    "t_l_s",
    "v_l_mps",
    "s_l_m",
    "tilt_rad",
    "lateral_m",
    "lateral_mps",
    "touch_s",
    "before_descent_s",
    "waited_s",
    "slide_m",
    "greatest_foot_n",
    "end_s",
    "impact_mps",
    "impact_tilt_rad",
];
/// Names of [`LandingRow::counts`].
const COUNTS: [&str; 4] = ["descents", "aborts", "bounces", "steps"];
/// Names of the columns of whole numbers that make a row: its place, and its counts.
const WHOLES: [&str; 5] = ["landing", COUNTS[0], COUNTS[1], COUNTS[2], COUNTS[3]];
/// Names of the columns of text.
const TEXTS: [&str; 3] = ["outcome", "why", "abort_reasons"];
/// Outcome of a landing that never began.
pub(super) const NOT_FLOWN: &str = "not_flown";
/// Key of the metadata that names the file's sweep.
const SWEEP: &str = "touchdown.sweep_sha256";

/// A landing of a campaign.
#[derive(Clone, Debug, PartialEq)]
pub struct LandingRow {
    /// Its place in the campaign.
    pub landing: u64,
    /// `landed`, `crashed`, `tipped_over`, `given_up` or `timed_out`; under an autopilot also `not_flown` or
    /// `autopilot_failed`.
    pub outcome: String,
    /// Cause of a crash, why it was given up, or the phase in which its time was up and what it waited for.
    pub why: Option<String>,
    /// Why descents were broken off, or hovers that sank climbed away from, in their order, joined by ` `.
    pub abort_reasons: Option<String>,
    /// Descents, aborts, bounces, steps of the integration.
    pub counts: [u64; 4],
    /// T_L, V_L, S_L, tilt, lateral distance and speed and the time of the last descent's touch; time before the
    /// descent, waiting time, way that feet slid, greatest force on a foot, time of the end; greatest speed towards the
    /// deck and greatest tilt of all touches, those of descents that were broken off too.
    pub numbers: [Option<f64>; 14],
}

/// A unit variant's name in results.
fn name<T: Serialize>(of: &T) -> Option<String> {
    serde_json::to_value(of).ok()?.as_str().map(str::to_owned)
}

/// The phase in which a landing's time was up and, of one that had not begun to descend, what it waited for: `hold (wind)`.
fn late(flown: &SpaceLanding) -> Option<String> {
    let phase = flown.last_phase.as_ref().and_then(name)?;
    Some(match flown.waits_for.as_ref().and_then(name) {
        Some(reason) => format!("{phase} ({reason})"),
        None => phase,
    })
}

impl LandingRow {
    /// The row of a landing.
    #[must_use]
    pub fn of(landing: u64, flown: &SpaceLanding) -> Self {
        let (outcome, why) = match &flown.outcome {
            SpaceOutcome::Landed { .. } => ("landed", None),
            SpaceOutcome::Crashed { cause } => ("crashed", name(cause)),
            SpaceOutcome::TippedOver => ("tipped_over", None),
            SpaceOutcome::GivenUp { reason } => ("given_up", reason.as_ref().and_then(name)),
            SpaceOutcome::TimedOut => ("timed_out", late(flown)),
        };
        let reasons: Vec<String> = flown
            .aborts
            .iter()
            .map(|abort| {
                abort
                    .reason
                    .as_ref()
                    .and_then(name)
                    .unwrap_or_else(|| "none".into())
            })
            .collect();
        let touch = flown.touch.as_ref();
        let numbers = [
            touch.map(|t| t.t_l_s),
            touch.map(|t| t.v_l_mps),
            touch.map(|t| t.s_l_m),
            touch.map(|t| t.tilt_rad),
            touch.map(|t| t.lateral_m),
            touch.map(|t| t.lateral_mps),
            touch.map(|t| t.time_s),
            flown.before_descent_s,
            Some(flown.waited_s),
            Some(flown.slide_m),
            Some(flown.greatest_foot_n),
            Some(flown.end_s),
            flown.impact.map(|impact| impact.speed_mps),
            flown.impact.map(|impact| impact.tilt_rad),
        ];
        Self {
            landing,
            outcome: outcome.to_string(),
            why,
            abort_reasons: (!reasons.is_empty()).then(|| reasons.join(" ")),
            counts: [
                u64::from(flown.descents),
                reasons.len() as u64,
                u64::from(flown.bounces),
                flown.steps,
            ],
            numbers: numbers.map(|n| n.filter(|n| n.is_finite())),
        }
    }

    /// The row of a landing that was not judged.
    fn without_result(landing: u64, outcome: &str, why: &str) -> Self {
        Self {
            landing,
            outcome: outcome.to_string(),
            why: Some(why.to_string()),
            abort_reasons: None,
            counts: [0; 4],
            numbers: [None; 14],
        }
    }

    /// The row of a landing that never began, because the vehicle did not come to hold above the deck. It is in no share
    /// and no mean.
    #[must_use]
    pub fn not_flown(landing: u64, why: &str) -> Self {
        Self::without_result(landing, NOT_FLOWN, why)
    }

    /// The row of a landing whose autopilot failed: neither landed nor crashed.
    #[must_use]
    pub fn autopilot_failed(landing: u64, why: &str) -> Self {
        Self::without_result(landing, "autopilot_failed", why)
    }

    /// Whether the landing began.
    #[must_use]
    pub fn flown(&self) -> bool {
        self.outcome != NOT_FLOWN
    }

    /// Whether it landed.
    #[must_use]
    pub fn landed(&self) -> bool {
        self.outcome == "landed"
    }

    /// Whether it landed, and the hardest of its touches was hard.
    #[must_use]
    pub fn landed_hard(&self, crash: &CrashSettings) -> bool {
        let hard = |speed_mps| crash.class(speed_mps) != TouchClass::Soft;
        self.landed() && self.number("impact_mps").is_some_and(hard)
    }

    /// Whether it landed in its first descent.
    #[must_use]
    pub fn landed_at_first(&self) -> bool {
        self.landed() && self.counts[0] == 1
    }

    /// Whether it came to wait for a window, or began a descent without a wait.
    #[must_use]
    pub fn came_to_wait(&self) -> bool {
        self.counts[0] > 0
            || self
                .number("waited_s")
                .is_some_and(|waited_s| waited_s > 0.0)
    }

    /// Whether it crashed or tipped over.
    #[must_use]
    pub fn crashed(&self) -> bool {
        self.outcome == "crashed" || self.outcome == "tipped_over"
    }

    /// The columns of [`Self::cells`].
    #[must_use]
    pub fn header() -> Vec<&'static str> {
        TEXTS.into_iter().chain(COUNTS).chain(NUMBERS).collect()
    }

    /// The row as cells of a table; an absent value is empty.
    #[must_use]
    pub fn cells(&self) -> Vec<String> {
        let text = |of: &Option<String>| of.clone().unwrap_or_default();
        let texts = [
            self.outcome.clone(),
            text(&self.why),
            text(&self.abort_reasons),
        ];
        let counts = self.counts.iter().map(u64::to_string);
        let number = |n: &Option<f64>| n.map_or_else(String::new, |n| n.to_string());
        let numbers = self.numbers.iter().map(number);
        texts.into_iter().chain(counts).chain(numbers).collect()
    }

    /// A number by its name in the table.
    #[must_use]
    pub fn number(&self, name: &str) -> Option<f64> {
        NUMBERS
            .iter()
            .position(|n| *n == name)
            .and_then(|place| self.numbers[place])
    }
}

/// A swept or random setting, as numbers if all of its values are numbers.
fn setting(numeric: bool, values: impl Iterator<Item = Value>) -> ParquetValues {
    if numeric {
        ParquetValues::Numbers(values.map(|v| number(&v).unwrap_or(f64::NAN)).collect())
    } else {
        ParquetValues::Texts(values.map(|v| Some(text(&v))).collect())
    }
}

/// A setting's value as a number.
pub fn number(value: &Value) -> Option<f64> {
    value
        .as_float()
        .or_else(|| value.as_integer().map(|v| v as f64))
}

/// A setting's value in tables: text without quotes, everything else as in TOML.
#[must_use]
pub fn text(value: &Value) -> String {
    value
        .as_str()
        .map_or_else(|| value.to_string(), str::to_owned)
}

/// The columns of a block.
fn columns(sweep: &Sweep, rows: &[LandingRow]) -> Vec<(String, ParquetValues)> {
    let trials = sweep.trials();
    let whole = |pick: &dyn Fn(&LandingRow) -> u64| {
        ParquetValues::Whole(rows.iter().map(|r| pick(r) as i64).collect())
    };
    let mut columns = vec![
        ("landing".to_string(), whole(&|r| r.landing)),
        ("point".to_string(), whole(&|r| r.landing / trials)),
        ("trial".to_string(), whole(&|r| r.landing % trials)),
    ];
    for (k, (key, values)) in sweep.grid().iter().enumerate() {
        let numeric = values.iter().all(|v| number(v).is_some());
        let at = |r: &LandingRow| values[sweep.places(r.landing / trials)[k]].clone();
        columns.push((key.clone(), setting(numeric, rows.iter().map(at))));
    }
    let draws: Vec<Vec<Value>> = rows
        .iter()
        .map(|r| sweep.draws(r.landing % trials))
        .collect();
    for (k, key) in sweep.drawn().enumerate() {
        let column = || draws.iter().map(|d| d[k].clone());
        columns.push((key.to_string(), setting(sweep.draws_numbers(k), column())));
    }
    let text = |pick: &dyn Fn(&LandingRow) -> Option<String>| {
        ParquetValues::Texts(rows.iter().map(pick).collect())
    };
    columns.push(("outcome".into(), text(&|r| Some(r.outcome.clone()))));
    columns.push(("why".into(), text(&|r| r.why.clone())));
    columns.push(("abort_reasons".into(), text(&|r| r.abort_reasons.clone())));
    for (k, name) in COUNTS.iter().enumerate() {
        columns.push(((*name).to_string(), whole(&|r| r.counts[k])));
    }
    for (k, name) in NUMBERS.iter().enumerate() {
        columns.push((
            (*name).to_string(),
            ParquetValues::Numbers(
                rows.iter()
                    .map(|r| r.numbers[k].unwrap_or(f64::NAN))
                    .collect(),
            ),
        ));
    }
    columns
}

/// The bytes of a block's file.
pub(super) fn encode(sweep: &Sweep, rows: &[LandingRow]) -> Result<Vec<u8>> {
    let program = concat!("touchdown ", env!("CARGO_PKG_VERSION"));
    let notes = [(SWEEP, sweep.sha256()), (SEAL, UNSEALED)];
    let bytes = to_parquet("landings", program, &notes, &columns(sweep, rows));
    let refused = |e| Error::Arguments(format!("the landings cannot be written as Parquet: {e}"));
    bytes.map(sealed).map_err(refused)
}

/// Reads a block; `landings` are those that it has to hold, `name` is its name in the campaign's place.
pub(super) fn decode(
    sweep: &Sweep,
    (place, name): (&Place, &str),
    landings: std::ops::Range<u64>,
) -> Result<Vec<LandingRow>> {
    let path = place.path(name);
    let at = path.display().to_string();
    let broken = |error: LogError| {
        let expected = "a block of landings (Parquet; without the file, --resume runs them again)";
        match error {
            LogError::Read { source, .. } => Error::file(&path, source),
            LogError::NotALog { found, .. } => Error::data(&at, expected, found),
            other => Error::data(&at, expected, other.to_string()),
        }
    };
    let bytes = place.read(name)?;
    if !is_intact(&bytes) {
        let expected =
            "the block as it was written (without the file, --resume runs its landings again)";
        return Err(Error::data(&at, expected, "another content"));
    }
    let file = place.parquet(name, &bytes).map_err(broken)?;
    let of = file.note(SWEEP).unwrap_or("none");
    if of != sweep.sha256() {
        return Err(Error::data(
            &at,
            format!("landings of the sweep {}", sweep.sha256()),
            format!("those of {of}"),
        ));
    }
    let others = || Error::data(&at, "the columns of a landing", "others");
    let columns = file.columns();
    let place = |name: &str| columns.iter().position(|column| column.name() == name);
    let names = TEXTS.into_iter().chain(WHOLES).chain(NUMBERS);
    let places: Option<Vec<usize>> = names.map(place).collect();
    let columns = file.read(&places.ok_or_else(others)?).map_err(broken)?;
    let rows: Option<Vec<LandingRow>> = (0..file.rows()).map(|row| parsed(&columns, row)).collect();
    let rows = rows.ok_or_else(others)?;
    if !rows.iter().map(|row| row.landing).eq(landings.clone()) {
        let found = match rows.first() {
            Some(first) => format!("{} of them, from {} on", rows.len(), first.landing),
            None => "none".to_owned(),
        };
        return Err(Error::data(
            &at,
            format!("the landings {} to {}", landings.start, landings.end - 1),
            found,
        ));
    }
    Ok(rows)
}

/// A row of the columns [`TEXTS`], [`WHOLES`] and [`NUMBERS`].
fn parsed(columns: &[ParquetValues], row: usize) -> Option<LandingRow> {
    let (texts, rest) = columns.split_at(TEXTS.len());
    let (wholes, numbers) = rest.split_at(WHOLES.len());
    let text = |column: &ParquetValues| match column {
        ParquetValues::Texts(values) => values.get(row).cloned(),
        _ => None,
    };
    let number = |column: &ParquetValues| match column {
        ParquetValues::Numbers(values) => values.get(row).copied(),
        _ => None,
    };
    let whole = |column| number(column).filter(|n| *n >= 0.0).map(|n| n as u64);
    let mut counts = [0; COUNTS.len()];
    for (count, column) in counts.iter_mut().zip(&wholes[1..]) {
        *count = whole(column)?;
    }
    let mut found = [None; NUMBERS.len()];
    for (found, column) in found.iter_mut().zip(numbers) {
        *found = Some(number(column)?).filter(|n| !n.is_nan());
    }
    Some(LandingRow {
        landing: whole(&wholes[0])?,
        outcome: text(&texts[0])??,
        why: text(&texts[1])?,
        abort_reasons: text(&texts[2])?,
        counts,
        numbers: found,
    })
}
