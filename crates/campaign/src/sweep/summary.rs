//! Figures of every point of a campaign.

use std::collections::BTreeMap;

use serde::Serialize;
use touchdown_flight::thrust::LEAST_THRUST_TO_WEIGHT;
use touchdown_sim::landing::space::CrashSettings;

use super::names::{names, shown};
use super::points::Sweep;
use super::policy::{CONTROLLER, is_policy};
use super::row::LandingRow;
use super::software_in_the_loop::AutopilotProgram;
use crate::error::Result;
use crate::policy::POLICY;
use crate::statistics::{Share, Summary, percentile};

/// How many of the worst landings are named.
const WORST: usize = 10;

/// A quantity over landings. Absent figures are null.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SampleSummary {
    /// How many landings carry it.
    pub count: u64,
    /// Mean.
    pub mean: Option<f64>,
    /// Standard deviation.
    pub sd: Option<f64>,
    /// 95 % interval of the mean (Student's t).
    pub ci95: Option<[f64; 2]>,
    /// 5 % lie below.
    pub p5: Option<f64>,
    /// Half lie below.
    pub p50: Option<f64>,
    /// 95 % lie below.
    pub p95: Option<f64>,
    /// 99 % lie below.
    pub p99: Option<f64>,
    /// Greatest.
    pub max: Option<f64>,
}

impl SampleSummary {
    /// Mean, standard deviation and interval; none without landings.
    #[must_use]
    pub fn summary(&self) -> Option<Summary> {
        let (sd, ci95) = (self.sd, self.ci95);
        self.mean.map(|mean| Summary { mean, sd, ci95 })
    }

    fn of(mut values: Vec<f64>) -> Self {
        values.sort_by(f64::total_cmp);
        let summary = Summary::of(&values);
        Self {
            count: values.len() as u64,
            mean: summary.map(|s| s.mean),
            sd: summary.and_then(|s| s.sd),
            ci95: summary.and_then(|s| s.ci95),
            p5: percentile(&values, 0.05),
            p50: percentile(&values, 0.5),
            p95: percentile(&values, 0.95),
            p99: percentile(&values, 0.99),
            max: values.last().copied(),
        }
    }
}

/// Which point of the grid.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PointOf {
    /// Its place in the grid, from 0.
    pub point: u64,
    /// The swept settings at it.
    pub settings: BTreeMap<String, toml::Value>,
    /// The controller.
    pub controller: String,
    #[serde(skip)]
    label: String,
}

impl PointOf {
    /// What is changed at the point, in a few words; the controller where nothing is.
    #[must_use]
    pub fn label(&self) -> String {
        self.label.clone()
    }
}

/// Figures of the landings at one point.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PointFigures {
    /// Which point.
    #[serde(flatten)]
    pub of: PointOf,
    /// Its landings.
    #[serde(flatten)]
    pub figures: Figures,
}

fn is_zero(count: &u64) -> bool {
    *count == 0
}

/// Figures of landings.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figures {
    /// Landings, those that never began included.
    pub trials: u64,
    /// Landings that never began, under an autopilot. They are in no share and no mean.
    #[serde(skip_serializing_if = "is_zero")]
    pub not_flown: u64,
    /// Counts of their reasons.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub not_flown_reasons: BTreeMap<String, u64>,
    /// Landed, in whichever descent.
    pub landed: Option<Share>,
    /// Landed hard: the hardest touch of a landing was above half of the crash speed ([`touchdown_flight::touch`]).
    pub hard: Option<Share>,
    /// Landed in the first descent.
    pub landed_at_first: Option<Share>,
    /// Crashed or tipped over.
    pub crashed: Option<Share>,
    /// Crashed without a go-around before.
    pub crashed_without_abort: u64,
    /// Counts of outcomes.
    pub outcomes: BTreeMap<String, u64>,
    /// Counts of the reasons of go-arounds: why descents were broken off, or hovers climbed away from.
    pub aborts: BTreeMap<String, u64>,
    /// T_L: time from the start of the last descent to touch, over those that landed, s.
    pub t_l_s: SampleSummary,
    /// Time spent waiting for a window, over those that came to wait or to descend, s.
    pub waited_s: SampleSummary,
    /// V_L: speed along the deck's normal at the touch, over those that landed, m/s.
    pub v_l_mps: SampleSummary,
    /// S_L = ∫|v| dt, over those that landed, m.
    pub s_l_m: SampleSummary,
    /// Distance from the deck's centre at the touch, over those that landed, m.
    pub lateral_m: SampleSummary,
    /// Speed along the deck at the touch, over those that landed, m/s.
    pub lateral_mps: SampleSummary,
    /// Greatest speed towards the deck of all of a trial's touches, over all trials that touched it: crashes and
    /// descents that were broken off too, m/s.
    pub impact_mps: SampleSummary,
    /// Tilt from the deck's normal at the touch, over those that landed, rad.
    pub tilt_rad: SampleSummary,
    /// Greatest tilt from the deck's normal with a foot on the deck, over every touch, as the impact speed, rad.
    pub impact_tilt_rad: SampleSummary,
}

/// One of the worst landings.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WorstLanding {
    /// Its place in the campaign.
    pub landing: u64,
    /// Which point.
    #[serde(flatten)]
    pub of: PointOf,
    /// The trial.
    pub trial: u64,
    /// How it ended.
    pub outcome: String,
    /// Why.
    pub why: Option<String>,
    /// V_L, m/s.
    pub v_l_mps: Option<f64>,
    /// Speed of its hardest touch, m/s.
    pub impact_mps: Option<f64>,
    /// Distance from the deck's centre, m.
    pub lateral_m: Option<f64>,
}

/// What `touchdown campaign` writes as `results.json`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CampaignResults {
    /// Version of this shape.
    pub schema: u32,
    /// Version of the program.
    pub version: &'static str,
    /// Seed.
    pub seed: u64,
    /// Landings at each point.
    pub trials: u64,
    /// SHA-256 of the sweep.
    pub sweep_sha256: String,
    /// The autopilot in the loop.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub autopilot: Option<AutopilotProgram>,
    /// False with an autopilot in the loop, whose threads run as the machine lets them; absent otherwise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reproducible_to_the_bit: Option<bool>,
    /// Landings in all.
    pub landings: u64,
    /// Draws that were replaced, because their true vehicle has a thrust over weight below 1.3; absent where none was.
    #[serde(skip_serializing_if = "is_zero")]
    pub redrawn: u64,
    /// Drawn starts that were replaced in all landings, because they were too low or lost; absent where none was.
    #[serde(skip_serializing_if = "is_zero")]
    pub redrawn_starts: u64,
    /// Figures of every point.
    pub points: Vec<PointFigures>,
    /// The worst landings: crashes, then what did not land, then the hardest.
    pub worst: Vec<WorstLanding>,
}

impl CampaignResults {
    /// How many draws were replaced, and why, a sentence each.
    #[must_use]
    pub fn redrawn_texts(&self) -> Vec<String> {
        let vehicles = (self.redrawn > 0).then(|| {
            format!(
                "{} draws were replaced: their true vehicle has a greatest thrust below {LEAST_THRUST_TO_WEIGHT} times its weight",
                self.redrawn
            )
        });
        let starts = (self.redrawn_starts > 0).then(|| {
            let count = match self.redrawn_starts {
                1 => "one drawn start was".to_string(),
                count => format!("{count} drawn starts were"),
            };
            format!(
                "{count} replaced: too low above `landed_height_m`, or farther than `crash.lost_m` from the way to the deck"
            )
        });
        vehicles.into_iter().chain(starts).collect()
    }
}

/// The figures of a whole campaign.
///
/// # Errors
/// None that [`Sweep::read`] has not found.
pub fn summarise(sweep: &Sweep, rows: &[LandingRow]) -> Result<CampaignResults> {
    let trials = sweep.trials() as usize;
    let texts: Vec<Vec<String>> = sweep.grid().iter().map(|(_, all)| shown(all)).collect();
    let points = rows
        .chunks(trials)
        .enumerate()
        .map(|(point, rows)| {
            Ok(PointFigures {
                of: point_of(sweep, &texts, point as u64)?,
                figures: Figures::of(rows, &sweep.scenario(point as u64)?.crash),
            })
        })
        .collect::<Result<Vec<_>>>()?;
    let worst = worst(rows).into_iter().map(|row| {
        Ok(WorstLanding {
            landing: row.landing,
            of: point_of(sweep, &texts, row.landing / sweep.trials())?,
            trial: row.landing % sweep.trials(),
            outcome: row.outcome.clone(),
            why: row.why.clone(),
            v_l_mps: row.number("v_l_mps"),
            impact_mps: row.number("impact_mps"),
            lateral_m: row.number("lateral_m"),
        })
    });
    Ok(CampaignResults {
        schema: 1,
        version: env!("CARGO_PKG_VERSION"),
        seed: sweep.settings().seed,
        trials: sweep.trials(),
        sweep_sha256: sweep.sha256().to_string(),
        autopilot: sweep.settings().autopilot,
        reproducible_to_the_bit: sweep.settings().autopilot.map(|_| false),
        landings: rows.len() as u64,
        redrawn: sweep.redrawn(),
        redrawn_starts: sweep.redrawn_starts()?,
        worst: worst.collect::<Result<_>>()?,
        points,
    })
}

/// In the place of a controller's name where every trial draws its own.
const DRAWN: &str = "drawn";

/// A point of the grid; `texts` are those of all values of each key.
fn point_of(sweep: &Sweep, texts: &[Vec<String>], point: u64) -> Result<PointOf> {
    let values = sweep.values(point);
    let controller = if is_policy(&values) {
        POLICY
    } else if sweep.drawn().any(|key| key == CONTROLLER) {
        DRAWN
    } else {
        let method = sweep.scenario(point)?.control.method;
        sweep.settings().lander_name(method)
    };
    let of_grid = sweep.grid().iter().zip(texts).zip(&values);
    let varied = of_grid.filter_map(|(((key, all), texts), (_, value))| {
        let place = all.iter().position(|other| other == *value)?;
        (all.len() > 1).then(|| (key.as_str(), &texts[place]))
    });
    let (keys, texts): (Vec<&str>, Vec<&String>) = varied.unzip();
    let words = names(&keys).into_iter().zip(texts);
    let words: Vec<String> = words.map(|(name, text)| format!("{name} {text}")).collect();
    Ok(PointOf {
        point,
        label: if words.is_empty() {
            controller.to_string()
        } else {
            words.join(", ")
        },
        settings: values
            .iter()
            .map(|(key, value)| ((*key).to_string(), (*value).clone()))
            .collect(),
        controller: controller.to_string(),
    })
}

impl Figures {
    /// The share of an outcome of those that were flown.
    #[must_use]
    pub fn ended(&self, outcome: &str) -> Option<Share> {
        let count = self.outcomes.get(outcome).copied().unwrap_or(0);
        Share::of(count, self.trials - self.not_flown)
    }

    /// The figures of `rows`; `crash` are the limits at their point.
    #[must_use]
    pub fn of(rows: &[LandingRow], crash: &CrashSettings) -> Self {
        let all = rows.len() as u64;
        let count = |which: &dyn Fn(&LandingRow) -> bool| {
            rows.iter().filter(|row| which(row)).count() as u64
        };
        let flown = count(&LandingRow::flown);
        let share = |which: &dyn Fn(&LandingRow) -> bool| Share::of(count(which), flown);
        let over = |name: &str, which: &dyn Fn(&LandingRow) -> bool| {
            SampleSummary::of(
                rows.iter()
                    .filter(|row| which(row))
                    .filter_map(|row| row.number(name))
                    .collect(),
            )
        };
        let landed = |name: &str| over(name, &LandingRow::landed);
        let every = |name: &str| over(name, &|_| true);
        let mut outcomes = BTreeMap::new();
        let mut aborts = BTreeMap::new();
        let mut not_flown_reasons = BTreeMap::new();
        for row in rows {
            *outcomes.entry(row.outcome.clone()).or_insert(0) += 1;
            if let (false, Some(why)) = (row.flown(), &row.why) {
                *not_flown_reasons.entry(why.clone()).or_insert(0) += 1;
            }
            for reason in row
                .abort_reasons
                .iter()
                .flat_map(|reasons| reasons.split(' '))
            {
                *aborts.entry(reason.to_string()).or_insert(0) += 1;
            }
        }
        Self {
            trials: all,
            not_flown: all - flown,
            not_flown_reasons,
            landed: share(&LandingRow::landed),
            hard: share(&|row| row.landed_hard(crash)),
            landed_at_first: share(&LandingRow::landed_at_first),
            crashed: share(&LandingRow::crashed),
            crashed_without_abort: count(&|row| row.crashed() && row.abort_reasons.is_none()),
            outcomes,
            aborts,
            t_l_s: landed("t_l_s"),
            waited_s: over("waited_s", &LandingRow::came_to_wait),
            v_l_mps: landed("v_l_mps"),
            s_l_m: landed("s_l_m"),
            lateral_m: landed("lateral_m"),
            lateral_mps: landed("lateral_mps"),
            impact_mps: every("impact_mps"),
            tilt_rad: landed("tilt_rad"),
            impact_tilt_rad: every("impact_tilt_rad"),
        }
    }
}

fn worst(rows: &[LandingRow]) -> Vec<&LandingRow> {
    let class = |row: &LandingRow| match row.outcome.as_str() {
        "crashed" | "tipped_over" => 0,
        "landed" => 2,
        _ => 1,
    };
    let mut worst: Vec<&LandingRow> = rows.iter().filter(|row| row.flown()).collect();
    worst.sort_by(|a, b| {
        let speed = |row: &LandingRow| row.number("impact_mps").unwrap_or(0.0);
        class(a)
            .cmp(&class(b))
            .then(speed(b).total_cmp(&speed(a)))
            .then(a.landing.cmp(&b.landing))
    });
    worst.truncate(WORST);
    worst
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(landing: u64, outcome: &str, speed: f64, aborts: Option<&str>) -> LandingRow {
        let mut numbers = [None; 14];
        numbers[1] = Some(speed);
        numbers[3] = Some(0.5 * speed);
        // The hardest of its touches, twice as hard as the last, and with three times the tilt.
        numbers[12] = Some(2.0 * speed);
        numbers[13] = Some(1.5 * speed);
        LandingRow {
            landing,
            outcome: outcome.into(),
            why: None,
            abort_reasons: aborts.map(str::to_owned),
            counts: [if aborts.is_some() { 2 } else { 1 }, 0, 0, 1],
            numbers,
        }
    }

    #[test]
    fn prop_outcomes_are_counted_and_crashes_are_worst() {
        let rows = [
            row(0, "landed", 0.1, None),
            row(1, "landed", 0.3, Some("tag_lost deck")),
            row(2, "crashed", 0.2, None),
            row(3, "timed_out", 0.0, None),
        ];
        let figures = Figures::of(&rows, &CrashSettings::default());
        assert_eq!(figures.landed.unwrap().count, 2);
        // Its hardest touch was at 0.6 m/s, above half of the crash speed of 0.6 m/s.
        assert_eq!(figures.hard.unwrap().count, 1);
        assert_eq!(figures.landed_at_first.unwrap().count, 1);
        assert_eq!(figures.crashed.unwrap().count, 1);
        assert_eq!(figures.crashed_without_abort, 1);
        assert_eq!(figures.aborts["tag_lost"], 1);
        // Of what landed, 0.1 and 0.3; of every touch, the crash's and those before the last too.
        assert_eq!((figures.v_l_mps.count, figures.v_l_mps.max), (2, Some(0.3)));
        assert_eq!(
            (figures.impact_mps.count, figures.impact_mps.max),
            (4, Some(0.6))
        );
        let (last, every) = (&figures.tilt_rad, &figures.impact_tilt_rad);
        assert_eq!((last.count, last.max), (2, Some(0.15)));
        assert_eq!(every.count, 4);
        // Rounding of 1.5 times 0.3.
        assert!((every.max.unwrap() - 0.45).abs() < 1e-15);
        let order: Vec<u64> = worst(&rows).iter().map(|row| row.landing).collect();
        assert_eq!(order, [2, 3, 1, 0]);
    }

    #[test]
    fn prop_landings_that_never_began_are_counted_but_in_no_figure() {
        let rows = [
            row(0, "landed", 0.1, None),
            LandingRow::not_flown(1, "never_held"),
            LandingRow::autopilot_failed(2, "autopilot_silent"),
        ];
        let figures = Figures::of(&rows, &CrashSettings::default());
        assert_eq!((figures.trials, figures.not_flown), (3, 1));
        // One of the two that were flown.
        assert_eq!(figures.landed.unwrap().share, 0.5);
        assert_eq!(figures.crashed.unwrap().count, 0);
        assert_eq!(figures.outcomes["not_flown"], 1);
        assert_eq!(figures.v_l_mps.count, 1);
        let order: Vec<u64> = worst(&rows).iter().map(|row| row.landing).collect();
        assert_eq!(order, [2, 0]);
    }
}
