//! Coefficients of the models that fly by default, identified on the virtual rig's rich data
//! (default plant, seed 1). Written by a command, not by hand:
//! `cargo run --release -p touchdown --example default_models -- crates/lander/src/models/fitted.rs`

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
/// μ of eq. (2).
pub(super) const MU: f64 = 1.9596460703718388;
/// The lag form's map h of height.
pub(super) const LAG_H: [f64; 4] = [
    -0.00848041864498241,
    0.05207259747301607,
    0.12175658075586876,
    0.03579022671947123,
];
/// The lag form's terms in deck velocity, s/m.
pub(super) const LAG_K: [f64; 2] = [-0.02976100956849577, 0.09328845451017813];
/// The lag form's time constant, s.
pub(super) const LAG_TAU_S: f64 = 0.15578333176117823;
