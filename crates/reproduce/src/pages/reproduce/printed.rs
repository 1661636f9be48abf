//! What becomes of the printed equations.

use touchdown_flight::reference::Exponential;
use touchdown_model::{Card, Form};
use touchdown_sim::body::plant::Plant;

use super::coefficients::{eq_11, eq_12};
use super::verdict::Claim;
use crate::error::Result;
use crate::experiments::Run;
use touchdown_pages::page::show;

/// Coefficients agree within this relative difference.
const COEFFICIENT_TOLERANCE: f64 = 0.25;
/// Heights at which eq. (12) is looked at (m).
const HEIGHTS_M: [f64; 4] = [0.15, 0.3, 0.5, 0.75];
/// The printed rate of eq. (13) (1/s) and the landing time that the paper has with it (s).
const PRINTED_C_PER_S: f64 = 0.1;
const PRINTED_T_L_S: f64 = 5.1;

pub(super) fn claims(run: &Run) -> Result<[Claim; 4]> {
    let (eq_11, eq_12) = (eq_11()?, eq_12()?);
    let ground = run.ground_effect.card(0, Form::Derivative);
    let pairs = [
        (Some(&run.thrust[1].models[2].card), &eq_11),
        (ground, &eq_12),
    ];
    Ok([
        feedforward(run, &eq_12)?,
        coefficients(pairs),
        sparsity(run, pairs),
        rate(run),
    ])
}

fn feedforward(run: &Run, eq_12: &Card) -> Result<Claim> {
    let plant = Plant::new(&run.settings.rig.plant)?;
    let hover = plant.motor().throttle_for(plant.weight_n());
    let forces = HEIGHTS_M.map(|z| rest_force(eq_12, hover, z));
    // Forces that round to nothing are nothing here.
    let rounded = |f: f64| show((10.0 * f).round() / 10.0 + 0.0, 1);
    let shown = forces.map(rounded).join(", ");
    let lowest = forces.iter().copied().fold(f64::INFINITY, f64::min);
    Ok(Claim {
        what: "Eq. (12): force at rest, 0.5 m",
        paper: "fed forward".into(),
        here: format!("{} N", rounded(forces[2])),
        verdict: if lowest < 0.0 {
            "**cannot be fed forward**"
        } else {
            "can be fed forward"
        },
        words: format!(
            "Eq. (12) as printed rests, at hover throttle and 0.15, 0.3, 0.5, 0.75 m, at {shown} N{}.",
            if lowest < 0.0 {
                ": fed forward, it holds the vehicle up where landings start"
            } else {
                ""
            }
        ),
    })
}

fn coefficients(pairs: [(Option<&Card>, &Card); 2]) -> Claim {
    let (mut shared, mut agree) = (0, 0);
    for (ours, printed) in pairs.into_iter().filter_map(|(a, b)| Some((a?, b))) {
        for term in &printed.terms {
            let value = ours.coefficient(&term.of, &term.expression);
            if value != 0.0 {
                shared += 1;
                agree += usize::from((value / term.value - 1.0).abs() <= COEFFICIENT_TOLERANCE);
            }
        }
    }
    Claim {
        what: "Coefficients of eq. (11), eq. (12)",
        paper: "printed".into(),
        here: format!("{agree} of {shared} within 25 %"),
        verdict: if 2 * agree > shared {
            "agree"
        } else {
            "**not reproducible**"
        },
        words: format!(
            "The printed equations and those of the paper's procedure here have {shared} coefficients in common; within 25 % of each other: {agree}. The \
             printed ones belong to a rig whose data are not public; only the procedure can be repeated."
        ),
    }
}

/// Terms of the libraries that the paper prints: Θ_T has seven, Θ_GEF ten.
const PRINTED_LIBRARIES: [usize; 2] = [7, 10];

fn sparsity(run: &Run, pairs: [(Option<&Card>, &Card); 2]) -> Claim {
    let identification = &run.settings.identification;
    let library = [
        identification.thrust.library.len(),
        identification.ground_effect.library.len(),
    ];
    let printed = pairs.map(|(_, card)| card.terms.len());
    let ours = pairs.map(|(card, _)| {
        card.map_or(0, |c| {
            c.terms.iter().filter(|t| t.of.ends_with('\'')).count()
        })
    });
    let of =
        |n: [usize; 2], all: [usize; 2]| format!("{} of {}, {} of {}", n[0], all[0], n[1], all[1]);
    Claim {
        what: "Sparsity: terms of eq. (11), eq. (12)",
        paper: of(printed, PRINTED_LIBRARIES),
        here: of(ours, library),
        verdict: "printed models are not sparse",
        words: format!(
            "The printed equations have {} and {} terms, more than the libraries of {} and {} that they are said to be chosen from (s³ and v_p v_q \
             are in no printed library). From a library of all printed terms, the same procedure here keeps {} (terms in v_q are zero on a rig and \
             left out before).{}",
            printed[0],
            printed[1],
            PRINTED_LIBRARIES[0],
            PRINTED_LIBRARIES[1],
            of(ours, library),
            certificate(run)
        ),
    }
}

/// The result of exact search for the terms of eq. (12), where both velocities differ significantly from zero.
fn certificate(run: &Run) -> String {
    let Some(front) = &run.ground_effect.moving.made.front else {
        return String::new();
    };
    let all = front.sizes.len() - 1;
    let error = |k: usize| show(front.sizes[k].left_out_rmse.unwrap_or(f64::NAN), 4);
    format!(
        " On trials in which vehicle and plate both move, exact search through all {} subsets of its {all} terms ({}) finds {} that do as \
         well on trials left out as all {all} ({} and {} N/s).",
        front.certificate.subsets,
        if front.certificate.proven {
            "proven"
        } else {
            "not proven"
        },
        front.chosen_terms,
        error(front.chosen_terms),
        error(all)
    )
}

fn rate(run: &Run) -> Claim {
    let scenario = &run.settings.ground_landing.scenario;
    let reference = Exponential {
        c_per_s: PRINTED_C_PER_S,
        start_height_m: scenario.start_height_m,
        end_height_m: 0.0,
    };
    let time = reference.time_to_height_s(scenario.landed_height_m);
    let shown = show(time.unwrap_or(f64::NAN), 1);
    let impossible = time.is_none_or(|t| t > 2.0 * PRINTED_T_L_S);
    Claim {
        what: "Eq. (13) with C = 0.1: time to land",
        paper: format!("{PRINTED_T_L_S} s"),
        here: format!("{shown} s"),
        verdict: if impossible {
            "**impossible**; C calibrated"
        } else {
            "possible"
        },
        words: format!(
            "With the printed C = {PRINTED_C_PER_S} the reference of eq. (13) alone needs {shown} s from {} m to {} m; the paper's vehicle lands in 5.1 s.",
            show(scenario.start_height_m, 1),
            show(scenario.landed_height_m, 1)
        ),
    }
}

/// The force at which f' of eq. (12) vanishes, everything at rest (N).
fn rest_force(eq_12: &Card, throttle: f64, z: f64) -> f64 {
    let c = |expression| eq_12.coefficient("f'", expression);
    let (s, s2) = (throttle, throttle * throttle);
    -(c("1") + c("s") * s + c("s^2") * s2 + c("z") * z + c("z^2") * z * z) / c("f")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paper_eq_12_at_rest_pulls_down_from_half_a_metre() {
        let eq_12 = eq_12().unwrap();
        // Reference values at 12 N (throttle 0.4324) to two digits, as f' = 0 gives them.
        for (z, force) in [(0.05, 0.49), (0.15, 0.59), (0.5, -3.56), (0.75, -10.8)] {
            let found = rest_force(&eq_12, 0.4324, z);
            // Half a unit of the last digit, and the throttle's own rounding.
            assert!((found - force).abs() < 0.06, "{z} m: {found}");
        }
    }
}
