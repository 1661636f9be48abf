//! The terms that pages explain where each first stands: one definition each.

use touchdown_report::Term;

const fn term(names: &'static [&'static str], meaning: &'static str) -> Term {
    Term { names, meaning }
}

/// All terms. The definitions hold for every page.
pub(crate) const TERMS: &[Term] = &[
    // Landings.
    term(
        &["T_L"],
        "The landing time, from the start of the last descent. It ends at the landed height, and in six degrees of freedom at the first touch.",
    ),
    term(
        &["V_L"],
        "The landing speed in m/s. It is the speed of the vehicle relative to the deck at T_L.",
    ),
    term(
        &["S_L"],
        "The landing path in metres. It is ∫|v| dt until T_L, so a vehicle that bobs up and down has a longer one.",
    ),
    term(
        &["CI"],
        "Half the 95 % confidence interval of the mean, by Student's t.",
    ),
    term(
        &["hover height", "Hover"],
        "The mean height over the last 5 s of a trial that has not landed by its timeout.",
    ),
    term(
        &["Wilson"],
        "The Wilson interval is the 95 % confidence interval of a share; it stays between 0 and 100 %.",
    ),
    term(
        &["go-around", "go-arounds"],
        "The landing computer breaks off a descent, or a hover before it, and climbs when a quantity leaves its limits, such as the lateral error.",
    ),
    // Methods.
    term(
        &["feedback"],
        "The paper's Method I: eq. (10) without any model of the ground effect.",
    ),
    term(
        &["empirical"],
        "The ground effect of eq. (2), a function of the height alone. The paper's Method II feeds it forward.",
    ),
    term(
        &["dynamic"],
        "The paper's Method III: eq. (10) with the identified dynamic ground effect fed forward.",
    ),
    term(
        &["imbc"],
        "Internal-model-based control: its controller holds a model of the deck's sine. The paper compares with it; its gains are reconstructed.",
    ),
    term(
        &["ssc"],
        "Smooth sliding control. The paper compares with it; its gains are reconstructed.",
    ),
    term(
        &["observer"],
        "This controller has no model of the ground effect. It estimates the disturbing force from the accelerometer.",
    ),
    term(
        &["dynamic+observer"],
        "This controller feeds the identified ground effect forward, and an observer estimates the rest from the accelerometer.",
    ),
    term(
        &["policy"],
        "A learned network flies the descents. It sees what the landing computer estimates; approach, hover, go-arounds and touchdown remain the computer's.",
    ),
    // Models of thrust and ground effect.
    term(
        &["free run", "free runs", "Free run, unseen trials"],
        "A free run simulates a model from its initial state over a whole log. No measurement corrects it on the way.",
    ),
    term(
        &["eq. (2)"],
        "The empirical law of the ground effect: f = T q/(1 − q) with q = μ (r/4z)². It depends on the height z alone.",
    ),
    term(
        &["eq. (7)"],
        "The paper's linear model of thrust: a first-order lag between throttle and the root of thrust.",
    ),
    term(
        &["eq. (8)"],
        "The paper's nonlinear model of thrust: it sums candidate terms of throttle and the root of thrust.",
    ),
    term(
        &["eq. (9)"],
        "The paper's model of the ground effect: it sums candidate terms to give the rate of change of the force.",
    ),
    term(
        &["static map"],
        "A model without memory: f = T h(z), where h is a sum of bounded functions of the height z.",
    ),
    term(
        &["ratio form"],
        "A model of y = f/T, the ground effect relative to thrust: y' is a sum of terms in y, z and v_p.",
    ),
    term(
        &["lag form"],
        "A model of y = f/T: y = G + k(z) v_p, and G follows its static value h(z) with the time constant τ.",
    ),
    term(
        &["SR3"],
        "Sparse relaxed regularised regression, eq. (6): it fits a sum of candidate terms and drops those that explain little.",
    ),
    term(
        &["best subset"],
        "An exact search over all subsets of the candidate terms. It returns the one of each size that fits best.",
    ),
    term(
        &["weak form"],
        "A regression on integrals of the data, which needs no derivative of noisy signals.",
    ),
    term(
        &["multiple shooting"],
        "A fit of simulated trajectories over short windows, each with a free initial state.",
    ),
    term(
        &["dead time"],
        "The identified delay of the measuring chain: each reading arrives later than what it measures.",
    ),
    term(
        &["held-out", "held out"],
        "Held-out trials take no part in the fit. They judge it.",
    ),
    term(
        &["confounded"],
        "Two terms are confounded when the data cannot separate their effects.",
    ),
    term(&["MAE"], "The mean absolute error."),
    term(&["RMSE"], "The root of the mean square error."),
    // Flights.
    term(
        &["elasticity"],
        "The relative change of thrust for a relative change of throttle, in hover. With 1, one percent more throttle gives one percent more thrust.",
    ),
    term(
        &["specific force"],
        "What an accelerometer measures: all forces but gravity, divided by the mass.",
    ),
    term(
        &["wake"],
        "The air that the rotors drive down. Its flow over the ground takes time to follow a change of height: the lag of the wake.",
    ),
    term(
        &["images"],
        "Mirror images of the rotors below the ground. They model how the ground slows the air through each rotor.",
    ),
    term(
        &["fountain"],
        "The stream of air that rises between the rotors, where their wakes meet over the ground. It lifts the body.",
    ),
    term(
        &["armed interval", "armed intervals"],
        "The part of a log from motors on to motors off.",
    ),
    term(
        &["decay"],
        "How fast the ground effect falls with height, as the rate of an exponential.",
    ),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_every_term_has_one_definition_in_short_sentences() {
        let mut names: Vec<&str> = TERMS.iter().flat_map(|t| t.names).copied().collect();
        let count = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), count);
        for Term { names, meaning } in TERMS {
            assert!(meaning.ends_with('.'), "{names:?}");
            for sentence in meaning.split_inclusive(". ") {
                assert!(sentence.split_whitespace().count() <= 25, "{sentence}");
            }
        }
    }
}
