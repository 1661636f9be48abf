//! Thrust and ground effect as model cards.

use std::path::Path;

use serde::Serialize;
use touchdown_campaign::settings_file;
use touchdown_identify::flights::result::FlightResult;
use touchdown_identify::flights::{
    Routed, ground_effect_by_routes, thrust_of_flights, with_thrust,
};
use touchdown_identify::forms::FormScore;
use touchdown_identify::rig::{self, GroundTrial};
use touchdown_identify::settings::VehicleSettings;
use touchdown_identify::{FittedCard, IdentificationSettings, Origin, thrust};
use touchdown_log::{Findings, Map};
use touchdown_model::card::{Input, Vehicle};
use touchdown_model::{Card, Form};
use touchdown_trial::Trial;

use crate::inspect::parse_map;
use crate::plot::{Plot, Series, Style};
use crate::request::{Data, Error, Result};

/// Points of a curve of thrust over throttle: enough for a smooth line.
const CURVE: usize = 200;
/// Name of the settings in messages.
const SETTINGS: &str = "the settings";

/// What an identification returns.
#[derive(Debug, Serialize)]
pub(crate) struct Identified {
    cards: Vec<Fit>,
    /// Forms that could not be fitted, with the reason.
    failed: Vec<[String; 2]>,
    /// What flights identify beside the cards: numbers, curve, routes, refusals.
    flight: Option<FlightResult>,
    plots: Vec<Plot>,
    /// What a user should know of the logs.
    warnings: Vec<String>,
    rows_dropped: usize,
}

/// A card and how its fit went.
#[derive(Debug, Serialize)]
struct Fit {
    card: Card,
    /// The card as its file has it.
    toml: String,
    rmse: f64,
    rmse_unit: &'static str,
    rows_used: usize,
    lag_s: Option<f64>,
    forms: Vec<FormScore>,
}

impl Fit {
    fn of(made: FittedCard) -> Result<Self> {
        Ok(Self {
            toml: made.card.to_toml()?,
            rmse: made.rmse,
            rmse_unit: made.rmse_unit,
            rows_used: made.rows_used,
            lag_s: made.lag_s,
            forms: made.forms,
            card: made.card,
        })
    }
}

/// Logs, read and mapped, with the settings of their identification.
struct Logs {
    map: Option<Map>,
    settings: IdentificationSettings,
    trials: Vec<Trial>,
    findings: Vec<Findings>,
}

impl Logs {
    fn read(data: &Data) -> Result<Self> {
        let map = data.map.as_deref().map(parse_map).transpose()?;
        let settings: IdentificationSettings = settings_file::parse(&data.settings, SETTINGS)?;
        settings.check(SETTINGS)?;
        let of_map = map.as_ref().map(Map::vehicle).unwrap_or_default();
        let mut settings = settings.of_vehicle(VehicleSettings {
            mass_kg: of_map.mass_kg,
            rotor_radius_m: of_map.rotor_radius_m,
            arm_m: of_map.arm_m,
            rotors: of_map.rotors,
            measured_rotors: of_map.measured_rotors,
        });
        let flight = &mut settings.flight;
        flight.mass_kg = flight.mass_kg.or(map.as_ref().and_then(Map::mass_kg));
        let mut trials = Vec::new();
        let mut findings = Vec::new();
        for path in &data.logs {
            let (trial, found) = touchdown_log::read_trial(path, map.as_ref())?;
            trials.push(trial.with_name(stem(path)));
            findings.push(found);
        }
        if trials.is_empty() {
            return Err(Error::Data("expected at least one log".to_string()));
        }
        Ok(Self {
            map,
            settings,
            trials,
            findings,
        })
    }

    /// Whether nothing measured the thrust of any log.
    fn are_flights(&self) -> bool {
        self.trials.iter().all(|t| t.channel("thrust_n").is_none())
    }

    fn origin(&self, data: &Data) -> Result<Origin> {
        let known = &self.settings.vehicle;
        let vehicle = Vehicle {
            name: self.map.as_ref().map_or("", Map::description).to_string(),
            mass_kg: known.mass_kg,
            rotor_radius_m: known.rotor_radius_m,
            rotors: known.rotors,
            arm_m: known.arm_m,
        };
        let mut origin = Origin::of(&self.trials, vehicle);
        origin
            .provenance
            .inputs
            .extend(data.map.as_ref().map(|text| Input {
                name: "map.toml".to_string(),
                sha256: touchdown_log::sha256(text.as_bytes()),
            }));
        let text = settings_file::to_toml(&self.settings)?;
        origin.provenance.settings_sha256 = Some(touchdown_log::sha256(text.as_bytes()));
        Ok(origin)
    }

    fn identified(
        &self,
        cards: Vec<FittedCard>,
        flight: Option<FlightResult>,
        plots: Vec<Plot>,
    ) -> Result<Identified> {
        let warnings = self
            .trials
            .iter()
            .zip(&self.findings)
            .flat_map(|(trial, findings)| {
                let all = findings.warnings.iter().cloned().chain(findings.loss());
                all.map(|text| format!("{}: {text}", trial.name()))
            });
        Ok(Identified {
            cards: cards.into_iter().map(Fit::of).collect::<Result<_>>()?,
            failed: Vec::new(),
            flight,
            plots,
            warnings: warnings.collect(),
            rows_dropped: self.findings.iter().map(Findings::rows_dropped).sum(),
        })
    }
}

/// The file's name without its extension.
fn stem(path: &Path) -> String {
    path.file_stem()
        .map_or_else(|| "log".to_string(), |s| s.to_string_lossy().into_owned())
}

/// The thrust card of logs of a stand, a rig or flights.
pub(crate) fn thrust(data: &Data) -> Result<Identified> {
    let mut logs = Logs::read(data)?;
    let flights = logs.are_flights();
    if flights {
        for trial in &mut logs.trials {
            *trial = with_thrust(trial, &logs.settings.flight, None)?;
        }
    }
    let origin = logs.origin(data)?;
    let (mut made, flight) = if flights && logs.settings.thrust.form.is_none() {
        let (made, flight) = thrust_of_flights(&logs.trials, &logs.settings, &origin)?;
        (made, Some(flight))
    } else {
        (thrust::fit(&logs.trials, &logs.settings, &origin)?, None)
    };
    if let [one] = &logs.trials[..] {
        made.card.name = one.name().to_string();
    }
    let plots = thrust_plots(&made.card, &logs.trials)?;
    logs.identified(vec![made], flight, plots)
}

/// Thrust over throttle, and measured thrust with the free run and its residual over the time of the first log.
fn thrust_plots(card: &Card, trials: &[Trial]) -> Result<Vec<Plot>> {
    let mut over_throttle = Vec::new();
    let mut battery_v = f64::NAN;
    for trial in trials {
        let throttle = thrust::throttle(trial)?;
        let measured = trial.require("thrust_n")?;
        over_throttle.push(Series::new(
            trial.name(),
            Style::Points,
            &throttle,
            measured,
        ));
        if let Some(volts) = trial.channel("battery_v") {
            let known: Vec<f64> = volts.iter().copied().filter(|v| v.is_finite()).collect();
            battery_v = known.iter().sum::<f64>() / known.len() as f64;
        }
    }
    if let Some([low, high]) = card.validity.inputs.get("s").copied() {
        let throttle: Vec<f64> = (0..CURVE)
            .map(|i| low + (high - low) * i as f64 / (CURVE - 1) as f64)
            .collect();
        if let Ok(curve) = thrust::at_rest(card, &throttle, &vec![battery_v; CURVE]) {
            over_throttle.push(Series::new(
                "at rest, by the card",
                Style::Line,
                &throttle,
                &curve,
            ));
        }
    }
    let mut plots = vec![Plot {
        title: "Thrust over throttle".to_string(),
        x: "Throttle",
        y: "Thrust (N)",
        series: over_throttle,
    }];
    let trial = &trials[0];
    let measured = trial.require("thrust_n")?;
    if let Ok(run) = thrust::predict(card, trial) {
        let residual: Vec<f64> = measured.iter().zip(&run).map(|(m, p)| m - p).collect();
        let time_s = trial.time_s();
        plots.push(Plot {
            title: format!("Free run over {}", trial.name()),
            x: "Time (s)",
            y: "Thrust (N)",
            series: vec![
                Series::new("measured", Style::Line, time_s, measured),
                Series::new("free run", Style::Line, time_s, &run),
            ],
        });
        plots.push(Plot {
            title: "Residual".to_string(),
            x: "Time (s)",
            y: "Measured − free run (N)",
            series: vec![Series::new("residual", Style::Line, time_s, &residual)],
        });
    }
    Ok(plots)
}

/// The ground effect of flights, or of a force rig with the thrust card of its vehicle.
pub(crate) fn ground_effect(data: &Data, thrust: Option<&str>) -> Result<Identified> {
    let logs = Logs::read(data)?;
    let card = thrust
        .map(|text| Card::parse(text, "the thrust card"))
        .transpose()?;
    if logs.are_flights() {
        of_flights(&logs, data, card.as_ref())
    } else {
        let card = card.ok_or_else(|| {
            Error::Data(
                "expected a thrust card, found none: the logs have the channel `thrust_n`, and the card gives the thrust out \
                 of ground effect that is subtracted. Identify the thrust first."
                    .to_string(),
            )
        })?;
        of_rig(&logs, data, &card)
    }
}

fn of_flights(logs: &Logs, data: &Data, thrust: Option<&Card>) -> Result<Identified> {
    let settings = &logs.settings;
    let trials: Vec<&Trial> = logs.trials.iter().collect();
    let Routed {
        flights,
        found,
        routes,
        warnings,
    } = ground_effect_by_routes(&trials, &settings.flight, thrust)?;
    let origin = logs.origin(data)?;
    let mut cards = vec![found.card(settings, &origin).with_warnings(warnings)];
    cards.extend(found.thrust_card(settings, &origin));
    let mut result = found.result(&flights, &settings.flight);
    result.routes = routes;
    let plots = vec![ratio_plot(&result)];
    let mut identified = logs.identified(cards, Some(result), plots)?;
    let notes = flights.iter().flat_map(|f| &f.notes);
    identified.warnings.extend(notes.map(ToString::to_string));
    Ok(identified)
}

/// Extra lift over height with its interval, and the hovers that it is from.
fn ratio_plot(result: &FlightResult) -> Plot {
    let height: Vec<f64> = result.ratio.iter().map(|at| at.height_m).collect();
    let percent = |of: fn(&touchdown_identify::Estimate) -> f64| -> Vec<f64> {
        let each = result.ratio.iter();
        each.map(|at| 100.0 * of(&at.ratio)).collect()
    };
    let mut series = vec![
        Series::new(
            "95 % interval",
            Style::Low,
            &height,
            &percent(|e| e.ci95[0]),
        ),
        Series::new(
            "95 % interval",
            Style::High,
            &height,
            &percent(|e| e.ci95[1]),
        ),
        Series::new("extra lift", Style::Line, &height, &percent(|e| e.value)),
    ];
    if !result.hovers.is_empty() {
        let at: Vec<f64> = result.hovers.iter().map(|h| h.height_m).collect();
        let lift: Vec<f64> = result
            .hovers
            .iter()
            .map(|h| 100.0 * (h.ratio - 1.0))
            .collect();
        series.push(Series::new("hovers", Style::Points, &at, &lift));
    }
    Plot {
        title: "Extra lift over height".to_string(),
        x: "Height (m)",
        y: "Extra lift (%)",
        series,
    }
}

fn of_rig(logs: &Logs, data: &Data, thrust: &Card) -> Result<Identified> {
    let mut settings = logs.settings.clone();
    let radius_m = &mut settings.ground_effect.rotor_radius_m;
    *radius_m = settings.vehicle.rotor_radius_m.unwrap_or(*radius_m);
    let trials: Vec<GroundTrial> = logs
        .trials
        .iter()
        .map(|trial| {
            let (whole, _) = rig::without_gaps(trial)?;
            Ok(rig::prepare(&whole, thrust)?)
        })
        .collect::<Result<_>>()?;
    let mut origin = logs.origin(data)?;
    origin.vehicle.rotor_radius_m = Some(settings.ground_effect.rotor_radius_m);
    let (mut cards, mut failed) = (Vec::new(), Vec::new());
    for form in Form::GROUND_EFFECT {
        match rig::fit(form, &trials, &settings, &origin) {
            Ok(made) if made.card.terms.is_empty() => failed.push([
                form.name().to_string(),
                "no term of it is supported by the data".to_string(),
            ]),
            Ok(made) => cards.push(made),
            Err(error) => failed.push([form.name().to_string(), error.to_string()]),
        }
    }
    if cards.is_empty() {
        let reasons: Vec<String> = failed
            .iter()
            .map(|[f, why]| format!("{f}: {why}"))
            .collect();
        return Err(Error::Data(format!(
            "no form could be fitted: {}",
            reasons.join("; ")
        )));
    }
    let plots = rig_plots(&cards, &trials);
    let mut identified = logs.identified(cards, None, plots)?;
    identified.failed = failed;
    Ok(identified)
}

/// Force over height of all trials, measured and by the free run of each form.
fn rig_plots(cards: &[FittedCard], trials: &[GroundTrial]) -> Vec<Plot> {
    let height: Vec<f64> = trials.iter().flat_map(|t| t.height_m.clone()).collect();
    let measured: Vec<f64> = trials.iter().flat_map(|t| t.force_n.clone()).collect();
    let plot = |made: &FittedCard| {
        let runs: Vec<Vec<f64>> = trials
            .iter()
            .map(|trial| rig::predict(&made.card, trial))
            .collect::<touchdown_identify::Result<_>>()
            .ok()?;
        let run = runs.concat();
        let residual: Vec<f64> = measured.iter().zip(&run).map(|(m, p)| m - p).collect();
        Some(Plot {
            title: format!("Ground effect over height: {}", made.card.name),
            x: "Height (m)",
            y: "Force (N)",
            series: vec![
                Series::new("measured", Style::Points, &height, &measured),
                Series::new("free run", Style::Points, &height, &run),
                Series::new("residual", Style::Points, &height, &residual),
            ],
        })
    };
    cards.iter().filter_map(plot).collect()
}
