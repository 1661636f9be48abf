//! Thrust models from stands with known truth: a share of the example `thrust_truth`, which draws the same stands in
//! larger numbers from other seeds.

use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, Normal};
use rand_pcg::Pcg64;
use touchdown_identify::settings::{DeadTime, ThrustForm};
use touchdown_identify::warning::Warning;
use touchdown_identify::{FittedCard, IdentificationSettings, Origin, thrust};
use touchdown_model::Mark;
use touchdown_model::card::Term;
use touchdown_trial::Trial;

#[allow(dead_code, reason = "the example uses what this test does not")]
#[path = "../examples/thrust_truth/stand.rs"]
mod stand;

use stand::{Command, Noise, Stand};

const WHITE: Noise = Noise {
    sd_share: 0.01,
    memory_s: 0.0,
};

fn normal(random: &mut Pcg64, sd: f64) -> f64 {
    Normal::new(0.0, sd).map_or(0.0, |law| law.sample(random))
}

fn between(random: &mut Pcg64, [low, high]: [f64; 2]) -> f64 {
    random.random_range(low..high)
}

fn stand(seed: u64, command: Command) -> Stand {
    Stand::draw(Pcg64::seed_from_u64(seed), command)
}

fn fit(trial: Trial, form: Option<ThrustForm>, dead_time: DeadTime) -> FittedCard {
    let mut settings = IdentificationSettings::default();
    settings.thrust.form = form;
    settings.thrust.dead_time = dead_time;
    thrust::fit(&[trial], &settings, &Origin::default()).unwrap()
}

fn term<'a>(made: &'a FittedCard, of: &str) -> Option<&'a Term> {
    made.card.terms.iter().find(|t| t.of == of)
}

#[test]
fn prop_lag_and_dead_time_are_found_together_at_all_rates() {
    let cases = [
        (50.0, Command::Steps, ThrustForm::FirstOrder),
        (100.0, Command::Steps, ThrustForm::FirstOrder),
        (200.0, Command::Sines, ThrustForm::FirstOrder),
        (100.0, Command::Motors, ThrustForm::LaggedMotors),
    ];
    let (mut held, mut count) = (0, 0);
    for (k, (rate_hz, command, form)) in cases.into_iter().enumerate() {
        for seed in 0..4 {
            let stand = stand(40 + 10 * k as u64 + seed, command);
            let log = stand.log(command, rate_hz, WHITE).unwrap();
            let made = fit(log, Some(form), DeadTime::Estimate);
            let (lag, dead_time) = (
                term(&made, "T_m").unwrap(),
                term(&made, "dead_time").unwrap(),
            );
            // The noise of a hundredth of the thrust over 30 to 60 steps leaves below 1.5 ms in either.
            assert!(
                (lag.value - stand.lag_s).abs() < 3e-3,
                "{lag:?} {}",
                stand.lag_s
            );
            assert!(
                (dead_time.value - stand.dead_time_s).abs() < 3e-3,
                "{dead_time:?}"
            );
            for (term, truth) in [(lag, stand.lag_s), (dead_time, stand.dead_time_s)] {
                let [low, high] = term.ci95.unwrap();
                held += usize::from(low <= truth && truth <= high);
                count += 1;
            }
        }
    }
    // 95 % of 32 intervals: fewer than 28 has a probability of 0.4 %.
    assert!(held >= 28, "{held} of {count}");
}

#[test]
fn prop_eq_8_takes_the_dead_time_of_free_run() {
    let stand = stand(7, Command::Steps);
    let log = stand.log(Command::Steps, 50.0, WHITE).unwrap();
    let made = fit(log.clone(), Some(ThrustForm::Library), DeadTime::Estimate);
    let dead_time = term(&made, "dead_time").unwrap();
    // A quarter of a period; the regression on derivatives errs by more than a period here.
    assert!(
        (dead_time.value - stand.dead_time_s).abs() < 5e-3,
        "{dead_time:?}"
    );
    let without = fit(log, Some(ThrustForm::Library), DeadTime::None);
    assert!(made.rmse < without.rmse);
}

#[test]
fn prop_slow_ramps_give_an_upper_bound() {
    for (rate_hz, seed) in [(2.0, 1), (8.0, 2), (50.0, 3)] {
        let stand = stand(seed, Command::Ramp);
        let log = stand.log(Command::Ramp, rate_hz, WHITE).unwrap();
        let made = fit(log, Some(ThrustForm::FirstOrder), DeadTime::Auto);
        let lag = term(&made, "T_m").unwrap();
        assert!(lag.ci95.is_none() && lag.std_error.is_none(), "{lag:?}");
        assert!(made.lag_s.is_none() && !made.warnings.is_empty());
        if lag.mark == Some(Mark::UpperBound) {
            assert!(
                lag.upper_bound.unwrap() >= stand.lag_s,
                "{lag:?} {}",
                stand.lag_s
            );
        }
    }
}

#[test]
fn prop_rows_for_a_clock_give_no_lag() {
    let stand = stand(5, Command::Steps);
    let log = stand.log(Command::Steps, 50.0, WHITE).unwrap();
    let rows = (0..log.len()).map(|i| i as f64).collect();
    let mut counted = Trial::new("rows", rows).unwrap();
    for (name, values) in log.channels() {
        counted.insert(name, values.to_vec()).unwrap();
    }
    let mut settings = IdentificationSettings::default();
    let made = thrust::fit(
        std::slice::from_ref(&counted),
        &settings,
        &Origin::default(),
    )
    .unwrap();
    assert!(term(&made, "T_m").is_none() && made.lag_s.is_none());
    settings.thrust.form = Some(ThrustForm::FirstOrder);
    let error = thrust::fit(&[counted], &settings, &Origin::default()).unwrap_err();
    assert!(
        error.to_string().contains("times that count rows"),
        "{error}"
    );
}

#[test]
fn prop_steps_get_a_lag_without_being_asked() {
    let stand = stand(11, Command::Steps);
    let log = stand.log(Command::Steps, 100.0, WHITE).unwrap();
    let made = fit(log, None, DeadTime::Auto);
    // Of noise of a hundredth of the thrust in 3000 rows.
    assert!((made.lag_s.unwrap() - stand.lag_s).abs() < 3e-3);
    let chosen: Vec<_> = made.forms.iter().filter(|f| f.chosen).collect();
    let best = made
        .forms
        .iter()
        .filter_map(|f| f.held_out_rmse_n)
        .fold(f64::INFINITY, f64::min);
    assert_eq!(chosen.len(), 1);
    assert!(chosen[0].lag && chosen[0].held_out_rmse_n.unwrap() <= 1.05 * best);
}

#[test]
fn prop_grams_that_are_named_newtons_are_warned_of() {
    let table = |factor: f64| {
        let throttle: Vec<f64> = (1..=10).map(|k| 0.1 * f64::from(k)).collect();
        // A rotor of 9 N, with a hundredth of noise.
        let thrust = throttle.iter().enumerate();
        let thrust = thrust
            .map(|(k, s)| factor * 9.0 * s * s * (1.0 + 0.01 * (3.0 * k as f64).sin()))
            .collect();
        let time = (0..10).map(f64::from).collect();
        let trial = Trial::new("bench", time)
            .and_then(|t| t.with_channel("throttle", throttle))
            .and_then(|t| t.with_channel("thrust_n", thrust))
            .unwrap();
        let mut settings = IdentificationSettings::default();
        settings.vehicle.measured_rotors = Some(1);
        let made = thrust::fit(&[trial], &settings, &Origin::default()).unwrap();
        let of_grams = |w: &&Warning| matches!(w, Warning::Grams { .. });
        let found = made.warnings.iter().find(of_grams).map(ToString::to_string);
        assert_eq!(
            found.is_some(),
            made.card.warnings.iter().any(|w| w.contains("grams"))
        );
        found
    };
    // 918 g for 9 N, and a hundredth of noise; the greatest single rotors of multirotors lift 100 N.
    let warned = table(1.0 / 9.80665e-3).expect("a warning");
    assert!(
        warned.contains("927 N from one rotor") && warned.contains("9.80665e-3"),
        "{warned}"
    );
    assert_eq!(table(1.0), None);
}
