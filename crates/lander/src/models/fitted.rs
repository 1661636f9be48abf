//! Coefficients of the models that fly by default, identified on the virtual rig's rich data
//! (default plant, seed 1). Written by a command, not by hand:
//! `cargo run --release -p touchdown --example default_models -- crates/lander/src/models/fitted.rs`

/// Models of the ground effect.
pub(super) struct GroundEffect {
    /// μ of eq. (2).
    pub(super) mu: f64,
    /// The lag form's map h of height.
    pub(super) h: [f64; 4],
    /// The lag form's terms in deck velocity, s/m.
    pub(super) k: [f64; 2],
    /// The lag form's time constant, s.
    pub(super) tau_s: f64,
}

/// Eq. (8), in the order of `Library::TERMS`.
pub(super) const THRUST: [f64; 8] = [
    7.134452055562685,
    -11.427231847614854,
    112.5925621737698,
    -55.082085254901315,
    -0.11944492490176446,
    0.8368360880601786,
    -56.644292420903646,
    2.0497232783070696,
];
/// At the paper's ground effect.
pub(super) const PAPER: GroundEffect = GroundEffect {
    mu: 1.9596460703718388,
    h: [
        -0.00848041864498241,
        0.05207259747301607,
        0.12175658075586876,
        0.03579022671947123,
    ],
    k: [-0.02976100956849577, 0.09328845451017813],
    tau_s: 0.15578333176117823,
};
/// At 0.5 of it.
pub(super) const MEASURED: GroundEffect = GroundEffect {
    mu: 1.017551469141098,
    h: [
        -0.004070263160991595,
        0.01757796334567168,
        0.05810661550635473,
        0.018372418498558585,
    ],
    k: [-0.01424477151676164, 0.06845871593437518],
    tau_s: 0.16399863730688022,
};
