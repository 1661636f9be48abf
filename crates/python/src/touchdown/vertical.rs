//! Landings of the vertical vehicle, as `touchdown land` flies them.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use touchdown_campaign::measured_deck::MeasuredDeck;
use touchdown_campaign::settings_file;
use touchdown_campaign::vehicle::check_lift;
use touchdown_campaign::vertical::controllers::{Cards, controller_over};
use touchdown_campaign::vertical::landings::{self, LandingFigures};
use touchdown_campaign::vertical::scenario::LandScenario;
use touchdown_campaign::vertical::vehicle;
use touchdown_campaign::{Error, Result, files};
use touchdown_flight::Method;
use touchdown_model::Card as ModelCard;
use touchdown_reproduce::experiments::landing::MethodLandings;
use touchdown_reproduce::pages;
use touchdown_sim::deck::DeckMotion;
use touchdown_sim::landing::vertical::{Landing, LandingTrace};

use super::card::Card;
use super::land::{Given, Heeding, local};
use super::of_campaign;
use super::reproduce::of_run;
use crate::error::{self, fault};
use crate::run::{self, Cancel};

/// Landings of the vertical vehicle.
#[pyclass(frozen, module = "sindy._native")]
pub(crate) struct VerticalLandings {
    methods: Vec<MethodLandings>,
    scenario: LandScenario,
    toml: String,
    /// What of the vehicle follows from the cards, in a line.
    vehicle: Option<String>,
    warnings: Vec<String>,
}

impl VerticalLandings {
    fn all(&self) -> impl Iterator<Item = (Method, &Landing)> {
        let of = self.methods.iter();
        of.flat_map(|m| m.landings.iter().map(|landing| (m.method, landing)))
    }
}

/// What the command's arguments say.
struct Order {
    given: Given,
    thrust: ModelCard,
    empirical: Option<ModelCard>,
    dynamic: Option<ModelCard>,
    controllers: Vec<Method>,
    trials: Option<usize>,
    seed: Option<u64>,
    deck_acceleration: bool,
    traces: usize,
}

impl Order {
    fn scenario(&self) -> Result<LandScenario> {
        let (mut scenario, file) = match &self.given {
            Given::File(path) => {
                let mut scenario = settings_file::read::<LandScenario>(path)?;
                if let Some(series) = &mut scenario.series {
                    let folder = path.parent().unwrap_or(Path::new("."));
                    series.file = folder.join(&series.file);
                }
                (scenario, path.display().to_string())
            }
            Given::Keys(text) => (settings_file::parse(text, "scenario")?, "scenario".into()),
            Given::None => (LandScenario::default(), "scenario".to_owned()),
        };
        if !self.controllers.is_empty() {
            scenario.controllers.clone_from(&self.controllers);
        }
        scenario.trials = self.trials.unwrap_or(scenario.trials);
        scenario.seed = self.seed.unwrap_or(scenario.seed);
        scenario.deck_acceleration &= self.deck_acceleration;
        scenario.check(&file)?;
        Ok(scenario)
    }

    fn fly(self, cancel: &Cancel) -> Result<VerticalLandings> {
        let mut scenario = self.scenario()?;
        let measured = match &mut scenario.series {
            Some(series) => Some(MeasuredDeck::read(series, Path::new(""))?),
            None => None,
        };
        if measured.is_some() {
            scenario.scenario.deck = DeckMotion::Still;
        }
        let all = [
            Some(&self.thrust),
            self.empirical.as_ref(),
            self.dynamic.as_ref(),
        ];
        let mut vehicle = None;
        if let Some(followed) = vehicle::follow(&scenario, all[0], all[2])? {
            scenario = followed.scenario;
            scenario.check("the vehicle of the cards")?;
            vehicle = Some(followed.text);
        }
        let mut warnings = vehicle::mismatches(&all, &scenario.scenario.plant);
        warnings.extend(measured.iter().flat_map(|deck| deck.warnings.clone()));
        let cards = Cards {
            vehicle: scenario.vehicle,
            thrust: self.thrust,
            empirical: self.empirical,
            dynamic: self.dynamic,
        };
        let weight_n = scenario.scenario.plant.weight_n();
        check_lift(&cards.thrust, &cards.thrust_model()?, weight_n)?;
        let land = scenario.land();
        let measured_frequency = measured
            .as_ref()
            .and_then(|m| m.mean_period_s)
            .map(|s| TAU / s);
        let frequency = measured_frequency.or(land.scenario.deck.angular_frequency());
        let motion = measured.as_ref().and_then(MeasuredDeck::spline);
        let mut methods = Vec::new();
        for &method in &scenario.controllers {
            let acceleration = scenario.deck_acceleration;
            let controller = controller_over(method, &cards, &land, acceleration, frequency)?;
            let (trials, seed) = (scenario.trials, scenario.seed);
            let progress = Heeding(cancel.clone());
            let landings = landings::run(
                &land.scenario,
                motion,
                &controller,
                trials,
                seed,
                self.traces,
                &progress,
            )?;
            let figures = LandingFigures::of(&landings, land.scenario.crash_speed_mps);
            methods.push(MethodLandings {
                method,
                landings,
                figures,
            });
        }
        Ok(VerticalLandings {
            methods,
            toml: settings_file::to_toml(&scenario)?,
            scenario,
            vehicle,
            warnings,
        })
    }
}

/// Lands the vertical vehicle with every controller.
#[pyfunction]
#[pyo3(signature = (file, json, thrust, empirical, dynamic, controllers, trials, seed, deck_acceleration, traces, jobs))]
#[expect(clippy::too_many_arguments, reason = "one for each of the command's")]
pub(crate) fn land_vertically(
    py: Python<'_>,
    file: Option<PathBuf>,
    json: Option<&str>,
    thrust: &Card,
    empirical: Option<&Card>,
    dynamic: Option<&Card>,
    controllers: Vec<String>,
    trials: Option<usize>,
    seed: Option<u64>,
    deck_acceleration: bool,
    traces: usize,
    jobs: Option<usize>,
) -> PyResult<VerticalLandings> {
    let method = |name: &String| {
        let found = Method::VERTICAL.into_iter().find(|m| m.name() == name);
        found.ok_or_else(|| {
            let expected = format!("some of {}", Method::VERTICAL.map(Method::name).join(", "));
            let message =
                format!("controllers: expected {expected}, found {name} (space=True flies it)");
            fault(message, "controllers", &expected, name)
        })
    };
    let order = Order {
        given: Given::of(file, json)?,
        thrust: thrust.card.clone(),
        empirical: empirical.map(|c| c.card.clone()),
        dynamic: dynamic.map(|c| c.card.clone()),
        controllers: controllers.iter().map(method).collect::<PyResult<_>>()?,
        trials,
        seed,
        deck_acceleration,
        traces,
    };
    let flown = run::owned(py, jobs, move |cancel| Ok(order.fly(cancel)))?;
    flown.map_err(|error| match error {
        Error::Arguments(text) => fault(
            text.clone(),
            "cards",
            "those that the controllers need",
            &text,
        ),
        other => of_campaign(&other),
    })
}

#[pymethods]
impl VerticalLandings {
    /// Landings.
    fn __len__(&self) -> usize {
        self.all().count()
    }

    /// The table of `landings.csv`: numbers as arrays (an absent one is NaN), texts as lists.
    fn columns<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let table = PyDict::new(py);
        let all = || self.all();
        let numbers = |of: &dyn Fn(&Landing) -> Option<f64>| {
            PyArray1::from_iter(py, all().map(|(_, l)| of(l).unwrap_or(f64::NAN)))
        };
        let controllers: Vec<&str> = all().map(|(m, _)| m.name()).collect();
        table.set_item("controller", controllers)?;
        table.set_item(
            "trial",
            PyArray1::from_iter(py, all().map(|(_, l)| l.trial_index as i64)),
        )?;
        let outcomes: Vec<&str> = all().map(|(_, l)| l.outcome.name()).collect();
        table.set_item("outcome", outcomes)?;
        table.set_item("t_l_s", numbers(&|l| l.t_l_s))?;
        table.set_item("v_l_mps", numbers(&|l| l.v_l_mps))?;
        table.set_item("s_l_m", numbers(&|l| l.t_l_s.is_some().then_some(l.s_l_m)))?;
        table.set_item("final_height_m", numbers(&|l| Some(l.final_height_m)))?;
        Ok(table)
    }

    /// Figures of every controller, in JSON: those of `results.json`.
    fn results(&self) -> PyResult<String> {
        let named = self.methods.iter().map(|m| {
            let figures = serde_json::to_value(&m.figures)?;
            Ok((m.method.name().to_owned(), figures))
        });
        named
            .collect::<serde_json::Result<serde_json::Map<_, _>>>()
            .and_then(|named| serde_json::to_string(&named))
            .map_err(|e| error::settings("results", &e))
    }

    /// The scenario that was flown, as TOML.
    fn scenario_toml(&self) -> &str {
        &self.toml
    }

    /// What a user should know of the cards.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    /// Writes `report.html` and `figures/` into a folder, as the command does.
    fn report(&self, py: Python<'_>, folder: PathBuf) -> PyResult<()> {
        local(&folder)?;
        let written = py.detach(|| -> std::result::Result<(), touchdown_reproduce::Error> {
            files::folder(&folder)?;
            let (methods, vehicle) = (&self.methods, self.vehicle.as_deref());
            pages::land(methods, &self.scenario, vehicle, &self.warnings, &folder)
        });
        written.map_err(of_run)
    }

    /// The time series of the landings that keep them, by the row of the landing.
    fn traces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let out = PyDict::new(py);
        for (row, (_, landing)) in self.all().enumerate() {
            if let Some(trace) = &landing.trace {
                out.set_item(row, series(py, trace)?)?;
            }
        }
        Ok(out)
    }
}

/// The time series of one landing as arrays by name.
fn series<'py>(py: Python<'py>, trace: &LandingTrace) -> PyResult<Bound<'py, PyDict>> {
    let LandingTrace {
        time_s,
        height_m,
        relative_velocity_mps,
        deck_height_m,
        vehicle_height_m,
        throttle,
        commanded_thrust_n,
        ground_effect_n,
        ground_effect_estimate_n,
    } = trace;
    let out = PyDict::new(py);
    for (name, values) in [
        ("time_s", time_s),
        ("height_m", height_m),
        ("relative_velocity_mps", relative_velocity_mps),
        ("deck_height_m", deck_height_m),
        ("vehicle_height_m", vehicle_height_m),
        ("throttle", throttle),
        ("commanded_thrust_n", commanded_thrust_n),
        ("ground_effect_n", ground_effect_n),
        ("ground_effect_estimate_n", ground_effect_estimate_n),
    ] {
        out.set_item(name, PyArray1::from_slice(py, values))?;
    }
    Ok(out)
}
