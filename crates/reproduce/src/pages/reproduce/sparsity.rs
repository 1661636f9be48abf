//! How many terms eq. (9) needs: the levels of identification side by side, the best subset of every size, and whether
//! both velocities are needed.

use touchdown_identify::rig::relative::RelativeVelocity;

use super::identifiability::title;
use crate::error::Result;
use crate::experiments::ground_effect::GroundEffectExperiment;
use touchdown_pages::front;
use touchdown_pages::page::{Page, show};

pub(super) fn write(page: &mut Page, ge: &GroundEffectExperiment) -> Result<()> {
    page.report
        .subsection("Levels of identification side by side");
    page.text(
        "Level 1 is the published procedure to the letter: SR3 of eq. (6) on unscaled sums. The paper prints neither λ nor ν, so those of the \
         settings stand in, by default PySINDy's (a threshold of 0.1, ν = 1). Level 2 scales the columns, chooses λ and ν on held-out trials and refits; beside it \
         the best subset by exact search, and the weak form, which needs no derivative. Level 3 is judged by free run: the terms of level 2 refined by \
         multiple shooting, and the forms with bounded functions of height.",
    );
    let sets: Vec<_> = ["Paper's", "Rich"]
        .into_iter()
        .zip(&ge.sets)
        .map(|(name, set)| (name, set.levels.as_slice()))
        .collect();
    page.table(front::levels(
        "Errors on the validation trials, by level.",
        &sets,
    ))?;
    page.report
        .subsection("How many terms: the best subset of every size");
    page.text(
        "A library of p terms has 2^p subsets. For each number of terms an exact search by branch and bound finds the subset that fits f' best, and proves \
         that there is no better one. The rig holds the vehicle still, so eight of the eleven terms are identifiable. On a third set of trials \
         the vehicle moves on its carriage as well as the plate below it, and all eleven can be. Free runs are those of the validation trials at the least, \
         the middle and the largest thrust; of the third set, trials at other throttles.",
    );
    let moving = &ge.moving;
    let sets = ge
        .sets
        .iter()
        .map(|s| {
            (
                title(s),
                s.name,
                s.models.iter().find_map(|m| m.front.as_ref()),
            )
        })
        .chain([(
            "Vehicle and plate in motion",
            "moving_data",
            moving.made.front.as_ref(),
        )]);
    for (title, name, found) in sets {
        let Some(found) = found else { continue };
        page.text(format!("{title}: {}", front::words(found)));
        let id = format!("front-{}", name.replace('_', "-"));
        page.figure(front::figure(
            &id,
            &format!("{title}: error of f' over the number of terms"),
            found,
        ))?;
        page.table(front::table(
            &format!("{title}: the best subset of every size."),
            found,
        ))?;
    }
    page.text(velocities(&moving.relative, &moving.printed));
    Ok(())
}

/// The residuals of the two libraries in words.
fn velocities(moving: &RelativeVelocity, printed: &RelativeVelocity) -> String {
    let number = |v: f64| show(v, 4);
    let left_out = |v: Option<f64>| number(v.unwrap_or(f64::NAN));
    let same = |a: Option<f64>, b: Option<f64>| a.zip(b).is_some_and(|(a, b)| a <= 1.01 * b);
    let needed = if same(
        moving.relative.left_out_rmse_n_per_s,
        moving.apart.left_out_rmse_n_per_s,
    ) {
        "within a hundredth of each other: these data do not need the velocities apart"
    } else {
        "more than a hundredth apart: here the two velocities do act differently"
    };
    format!(
        "Are both velocities needed? The velocity terms of the printed eq. (12) are those of v_q - v_p: on trajectories of that equation itself, {} terms of \
         the relative velocity leave {} N/s of f' (root mean square {} N/s), so that three of its eleven coefficients say nothing. On our moving \
         trials {} terms of the relative velocity leave {} N/s on trials left out, all {} terms {} N/s: {needed}.",
        printed.relative.terms,
        number(printed.relative.training_rmse_n_per_s),
        number(printed.target_rms_n_per_s),
        moving.relative.terms,
        left_out(moving.relative.left_out_rmse_n_per_s),
        moving.apart.terms,
        left_out(moving.apart.left_out_rmse_n_per_s),
    )
}
