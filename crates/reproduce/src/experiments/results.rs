//! `results.json`: the shape is an interface. Keys may be added; absent figures are null, never zero.

use std::collections::BTreeMap;

use serde::Serialize;
use touchdown_sim::landing::space::Case;
use touchdown_sim::rig::sets::VALIDATION_KINDS;

use crate::error::Result;
use crate::experiments::landing::MethodLandings;
use crate::experiments::sea::SeaExperiment;
use crate::experiments::{Run, thrust};
use crate::settings::{ReproduceSettings, to_toml};
use touchdown_campaign::sweep::Figures;
use touchdown_campaign::vertical::landings::LandingFigures;
use touchdown_flight::Method;
use touchdown_flight::method::{C_DECK_PER_S, C_GROUND_PER_S};
use touchdown_identify::FittedCard;
use touchdown_identify::front::Front;
use touchdown_identify::rig::identifiability::Identifiability;
use touchdown_identify::rig::levels::Level;
use touchdown_identify::rig::relative::RelativeVelocity;
use touchdown_identify::scores::Errors;
use touchdown_model::Form;

/// Version of the shape.
pub const SCHEMA: u32 = 1;

/// A mean and a largest error (N); null where there is none.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ErrorFigure {
    /// Mean absolute error (N).
    pub mae_n: Option<f64>,
    /// Largest absolute error (N).
    pub worst_n: Option<f64>,
    /// Mean absolute error against the raw measurement, which its own noise dominates (N).
    pub raw_mae_n: Option<f64>,
}

impl ErrorFigure {
    fn of(errors: Option<Errors>, raw: Option<Errors>) -> Self {
        let finite = |v: f64| v.is_finite().then_some(v);
        Self {
            mae_n: errors.and_then(|e| finite(e.mae)),
            worst_n: errors.and_then(|e| finite(e.worst)),
            raw_mae_n: raw.and_then(|e| finite(e.mae)),
        }
    }
}

type Table = BTreeMap<&'static str, BTreeMap<&'static str, ErrorFigure>>;

/// Everything that `reproduce` found.
#[derive(Clone, Debug, Serialize)]
pub struct Results {
    /// [`SCHEMA`].
    pub schema: u32,
    /// Version of the tool.
    pub version: &'static str,
    /// Seed.
    pub seed: u64,
    /// Landings of every method.
    pub trials: usize,
    /// Whether this was the fast look.
    pub quick: bool,
    /// SHA-256 of the settings as TOML.
    pub settings_sha256: String,
    /// IV-B.1.
    pub thrust: ThrustResults,
    /// IV-B.2.
    pub ground_effect: GroundEffectResults,
    /// IV-C.
    pub ground_landing: BTreeMap<&'static str, LandingFigures>,
    /// IV-D.
    pub deck_landing: DeckResults,
    /// Landings at sea, in six degrees of freedom.
    pub sea: SeaResults,
    /// The paper's own figures.
    pub published: Published,
    /// What was calibrated to the paper.
    pub calibrated: BTreeMap<&'static str, String>,
    /// What is a reconstruction.
    pub reconstructed: BTreeMap<&'static str, &'static str>,
}

/// Throttle to thrust: `model -> trial -> errors`.
#[derive(Clone, Debug, Serialize)]
pub struct ThrustResults {
    /// Plate removed.
    pub plate_removed: Table,
    /// Plate at 0.75 m.
    pub plate_present: Table,
    /// The best subset of every size beside the terms of eq. (8), by state of the plate.
    pub fronts: BTreeMap<&'static str, Front>,
}

/// Ground effect: `form -> kind of trial -> errors`.
#[derive(Clone, Debug, Serialize)]
pub struct GroundEffectResults {
    /// Fitted on the paper's data.
    pub paper_data: Table,
    /// Fitted on the rich data.
    pub rich_data: Table,
    /// The measurement's own noise, by kind of trial.
    pub noise_floor: BTreeMap<&'static str, ErrorFigure>,
    /// The lag of each dynamic form (s), by data set and form.
    pub lag_s: BTreeMap<&'static str, BTreeMap<&'static str, Option<f64>>>,
    /// What the data can carry, by data set.
    pub identifiability: BTreeMap<&'static str, Identifiability>,
    /// The best subset of every size beside the terms of eq. (9), by data set; `moving_data` are trials in which vehicle
    /// and plate both move.
    pub fronts: BTreeMap<&'static str, Front>,
    /// The levels of identification side by side, by data set.
    pub levels: BTreeMap<&'static str, Vec<Level>>,
    /// Eq. (9) with the velocities apart and with the relative velocity alone: on `moving_data`, and on
    /// trajectories of the printed eq. (12) itself.
    pub relative_velocity: BTreeMap<&'static str, RelativeVelocity>,
}

/// Landings on the deck.
#[derive(Clone, Debug, Serialize)]
pub struct DeckResults {
    /// With the deck's acceleration fed forward.
    pub with_acceleration: BTreeMap<&'static str, LandingFigures>,
    /// Without.
    pub without_acceleration: BTreeMap<&'static str, LandingFigures>,
}

/// Landings at sea, in six degrees of freedom.
#[derive(Clone, Debug, Serialize)]
pub struct SeaResults {
    /// `deck -> how it is flown -> figures`.
    pub decks: BTreeMap<&'static str, BTreeMap<&'static str, Figures>>,
    /// `fault -> figures`, above the paper's deck, as `planned`.
    pub faults: BTreeMap<&'static str, Figures>,
    /// SHA-256 of the measured motion of the deck `sea`; null where its waves are drawn from a spectrum.
    pub series_sha256: Option<String>,
}

impl SeaResults {
    fn of(sea: &SeaExperiment) -> Self {
        let (mut decks, mut faults) = (BTreeMap::<_, BTreeMap<_, _>>::new(), BTreeMap::new());
        for l in &sea.landings {
            let figures = l.figures.clone();
            if Case::FAULTS.contains(&l.case) {
                faults.insert(l.case.name(), figures);
            } else {
                let deck = decks.entry(l.case.name()).or_default();
                deck.insert(l.how.name(), figures);
            }
        }
        Self {
            decks,
            faults,
            series_sha256: sea.series.as_deref().map(touchdown_log::sha256),
        }
    }
}

/// Published figures of one method; null where none was published.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PublishedFigures {
    /// Landing time (s).
    pub t_l_s: Option<f64>,
    /// Landing speed (m/s).
    pub v_l_mps: Option<f64>,
    /// Total variation, in the paper's own unit (it cannot be metres).
    pub s_l_published_unit: Option<f64>,
    /// Hover height (m).
    pub hover_height_m: Option<f64>,
}

/// The paper's own figures.
#[derive(Clone, Debug, Serialize)]
pub struct Published {
    /// Fig. 5(c).
    pub ground_landing: BTreeMap<&'static str, PublishedFigures>,
    /// Table I.
    pub deck_landing: BTreeMap<&'static str, PublishedFigures>,
    /// Mean absolute error that the ground-effect model is said to stay within (N).
    pub ground_effect_mae_n: f64,
}

impl Published {
    /// The figures as printed.
    #[must_use]
    pub fn figures() -> Self {
        let hover = PublishedFigures {
            hover_height_m: Some(0.15),
            ..PublishedFigures::default()
        };
        let time = |t| PublishedFigures {
            t_l_s: Some(t),
            ..PublishedFigures::default()
        };
        let row = |t, v, s| PublishedFigures {
            t_l_s: Some(t),
            v_l_mps: Some(v),
            s_l_published_unit: Some(s),
            hover_height_m: None,
        };
        Self {
            ground_landing: [
                (Method::Feedback.name(), hover),
                (Method::Empirical.name(), time(7.1)),
                (Method::Dynamic.name(), time(5.1)),
            ]
            .into(),
            deck_landing: [
                (Method::Imbc.name(), row(7.46, 0.086, 23.69)),
                (Method::Ssc.name(), row(7.69, 0.084, 16.52)),
                (Method::Dynamic.name(), row(5.38, 0.036, 12.89)),
            ]
            .into(),
            ground_effect_mae_n: 0.2,
        }
    }
}

/// SHA-256 of settings as TOML text, in hexadecimal; where a file lies makes no difference to it.
///
/// # Errors
/// Settings that TOML cannot hold.
pub fn settings_sha256(settings: &ReproduceSettings) -> Result<String> {
    Ok(touchdown_log::sha256(
        to_toml(&settings.with_files_here())?.as_bytes(),
    ))
}

impl Results {
    /// The results of a run.
    ///
    /// # Errors
    /// Settings that TOML cannot hold.
    pub fn of(run: &Run) -> Result<Self> {
        let [present, removed] = &run.thrust;
        let [paper, rich] = [0, 1].map(|set| forms(run, set));
        let ge = &run.ground_effect;
        let landing = &run.landing;
        let lag_s = ge.sets.iter().map(|s| {
            let of_form = Form::GROUND_EFFECT
                .iter()
                .zip(&s.models)
                .map(|(f, m)| (f.name(), m.lag_s));
            (s.name, of_form.collect())
        });
        Ok(Self {
            schema: SCHEMA,
            version: env!("CARGO_PKG_VERSION"),
            seed: run.settings.seed,
            trials: run.settings.trials,
            quick: run.settings.quick,
            settings_sha256: settings_sha256(&run.settings)?,
            thrust: ThrustResults {
                plate_removed: plate(removed),
                plate_present: plate(present),
                fronts: [("plate_removed", removed), ("plate_present", present)]
                    .into_iter()
                    .filter_map(|(name, state)| Some((name, front(&state.models)?)))
                    .collect(),
            },
            ground_effect: GroundEffectResults {
                paper_data: paper,
                rich_data: rich,
                noise_floor: VALIDATION_KINDS
                    .into_iter()
                    .map(|kind| (kind, ErrorFigure::of(ge.pooled_floor(kind), None)))
                    .collect(),
                lag_s: lag_s.collect(),
                identifiability: ge.sets.iter().map(|s| (s.name, s.before.clone())).collect(),
                fronts: ge
                    .sets
                    .iter()
                    .filter_map(|s| Some((s.name, front(&s.models)?)))
                    .chain(ge.moving.made.front.clone().map(|f| ("moving_data", f)))
                    .collect(),
                levels: ge.sets.iter().map(|s| (s.name, s.levels.clone())).collect(),
                relative_velocity: [
                    ("moving_data", ge.moving.relative),
                    ("printed_eq12", ge.moving.printed),
                ]
                .into(),
            },
            ground_landing: figures(&landing.ground),
            deck_landing: DeckResults {
                with_acceleration: figures(&landing.with_acceleration),
                without_acceleration: figures(&landing.without_acceleration),
            },
            sea: SeaResults::of(&run.sea),
            published: Published::figures(),
            calibrated: calibrated(&run.settings),
            reconstructed: reconstructed(),
        })
    }
}

/// The front of the first model that has one.
fn front(models: &[FittedCard]) -> Option<Front> {
    models.iter().find_map(|m| m.front.clone())
}

fn plate(state: &thrust::PlateState) -> Table {
    thrust::MODELS
        .into_iter()
        .zip(&state.runs)
        .map(|(model, runs)| {
            (
                model,
                runs.iter()
                    .map(|r| (r.kind, ErrorFigure::of(Some(r.errors), Some(r.raw))))
                    .collect(),
            )
        })
        .collect()
}

fn forms(run: &Run, set: usize) -> Table {
    Form::GROUND_EFFECT
        .iter()
        .enumerate()
        .map(|(model, form)| {
            let of_kind = VALIDATION_KINDS.into_iter().map(|kind| {
                (
                    kind,
                    ErrorFigure::of(
                        run.ground_effect.pooled(set, model, kind),
                        run.ground_effect.pooled_raw(set, model, kind),
                    ),
                )
            });
            (form.name(), of_kind.collect())
        })
        .collect()
}

fn figures(methods: &[MethodLandings]) -> BTreeMap<&'static str, LandingFigures> {
    methods
        .iter()
        .map(|m| (m.method.name(), m.figures.clone()))
        .collect()
}

/// What was calibrated to the paper, and how.
#[must_use]
pub fn calibrated(settings: &ReproduceSettings) -> BTreeMap<&'static str, String> {
    let (ground, deck) = (
        settings.ground_landing.control.c_per_s,
        settings.deck_landing.control.c_per_s,
    );
    let rate = if (ground, deck) == (C_GROUND_PER_S, C_DECK_PER_S) {
        format!(
            "the rate of descent C, {ground} 1/s on the ground and {deck} 1/s on the deck, is set so that the reference itself reaches \
             0.1 m at the paper's own landing times of 5.1 s and 5.38 s; the printed C = 0.1 would take 36 s. The landing time of \
             `dynamic` is therefore no evidence; times relative to it are"
        )
    } else {
        format!(
            "the rate of descent C is {ground} 1/s on the ground and {deck} 1/s on the deck, by these settings; \
             {C_GROUND_PER_S} and {C_DECK_PER_S} 1/s make the reference itself reach 0.1 m at the paper's landing times"
        )
    };
    [
        ("c_per_s", rate),
        (
            "ground_effect_strength",
            "the default plant's strength of ground effect (literature values for a quadrotor of this size, rotor plane 0.05 m \
             above the reference point) was chosen with the paper's hover height of 15 cm in view"
                .to_string(),
        ),
        (
            "mu",
            "mu of eq. (2) is fitted to our own rig data; the paper does not print it".to_string(),
        ),
    ]
    .into()
}

/// What is a reconstruction, and of what.
#[must_use]
pub fn reconstructed() -> BTreeMap<&'static str, &'static str> {
    [
        (
            "imbc",
            "internal-model-based control after Marconi, Isidori and Serrani (2002): the law and the gains that the \
             paper used are not printed; a canonical internal model for a constant and one known sine, with eq. (10)'s gains",
        ),
        (
            "ssc",
            "smooth sliding control: neither law nor gains are printed; a tanh sliding term behind a first-order \
             filter, with eq. (10)'s gains",
        ),
        (
            "deck_reference",
            "the paper leaves open whether the deck's acceleration is fed forward; both are shown",
        ),
    ]
    .into()
}
