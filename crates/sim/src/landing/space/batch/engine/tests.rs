//! What holding the rotors' shares of the plate costs.

use super::*;
use crate::air::wind::{DrydenSettings, WindSettings};
use crate::landing::space::{Case, SpaceScenario};
use crate::number::vector::dot;

/// Greatest differences of place, m, and velocity, m/s, up to the first touch; then those of its
/// time T_L, s, and speed V_L, m/s.
type Apart = [f64; 4];

fn length(a: [f64; 3], b: [f64; 3]) -> f64 {
    let d = crate::number::vector::sub(a, b);
    dot(d, d).sqrt()
}

/// Flies a trial with the shares held and, beside it, with shares of every step.
fn apart(held: &Batch, trial: u64) -> Apart {
    let mut fresh = held.clone();
    fresh.steps.held = 1;
    let [mut a, mut b] = [held, &fresh].map(|batch| Engine::new(batch, trial..trial + 1, 3, 0.0));
    let mut apart = [0.0_f64; 4];
    let step = |engine: &mut Engine<f64>, batch: &Batch| {
        engine.advance(batch).expect("a checked scenario")
    };
    while step(&mut a, held) & step(&mut b, &fresh) {
        if a.stopped + b.stopped == 0.0 {
            apart[0] = apart[0].max(length(a.state.position_m, b.state.position_m));
            apart[1] = apart[1].max(length(a.state.velocity_mps, b.state.velocity_mps));
        }
    }
    let [a, b] = [(a, held), (b, &fresh)].map(|(engine, batch)| {
        engine
            .run(batch)
            .expect("a checked scenario")
            .swap_remove(0)
    });
    assert_eq!(a.outcome, b.outcome, "trial {trial}");
    let (a, b) = a.touch.zip(b.touch).expect("both touch");
    apart[2] = (a.t_l_s - b.t_l_s).abs();
    apart[3] = (a.v_l_mps - b.v_l_mps).abs();
    apart
}

#[test]
fn prop_shares_held_move_no_landing() {
    let paper = Case::Paper.scenario();
    let calm = SpaceScenario {
        turbulence: false,
        ..paper.clone()
    };
    let sea = SpaceScenario {
        wind: WindSettings {
            steady_mps: [1.0, 0.5, 0.0],
            dryden: DrydenSettings::low_altitude(6.0, 3.0).ok(),
            gust: None,
            airwake: None,
        },
        ..Case::Sea.scenario()
    };
    for (name, scenario) in [("calm", calm), ("turbulent", paper), ("sea", sea)] {
        let batch = Batch::new(&scenario).expect("a valid scenario");
        let all: Vec<Apart> = (0..40).map(|trial| apart(&batch, trial)).collect();
        let sorted = |k: usize| {
            let mut values: Vec<f64> = all.iter().map(|apart| apart[k]).collect();
            values.sort_by(f64::total_cmp);
            values
        };
        let [place_m, velocity_mps, t_l_s, v_l_mps] = [0, 1, 2, 3].map(sorted);
        // 7e-6 m and 3e-5 m/s are usual; the start of a block instead of its middle costs more.
        assert!(place_m[20] < 9e-6, "{name}: {place_m:?}");
        assert!(velocity_mps[20] < 4e-5, "{name}: {velocity_mps:?}");
        // Below a certain height the controller freezes its estimates. In a few landings it passes that
        // height one control period (10 ms) earlier or later. Below it, positions then differ by up to
        // 0.05 m/s × 10 ms = 0.5 mm and velocities by up to 0.1 m/s² × 10 ms = 1 mm/s.
        assert!(place_m[39] < 5e-4, "{name}: {place_m:?}");
        assert!(velocity_mps[39] < 1e-3, "{name}: {velocity_mps:?}");
        assert!(t_l_s[39] < 0.0105, "{name}: {t_l_s:?}");
        assert!(v_l_mps[39] < 1e-3, "{name}: {v_l_mps:?}");
    }
}
