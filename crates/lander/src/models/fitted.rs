//! Coefficients of the models that fly by default.

/// Eq. (8), in the order of `Library::TERMS`.
pub(super) const THRUST: [f64; 8] = [
    7.134_375,
    -11.427_189,
    112.592_380,
    -55.082_173,
    -0.119_445,
    0.836_960,
    -56.642_801,
    2.049_671,
];
/// μ of eq. (2).
pub(super) const MU: f64 = 1.958;
/// The lag form's map h of height.
pub(super) const LAG_H: [f64; 4] = [-0.007_458, 0.041_323, 0.130_612, 0.031_397];
/// The lag form's terms in deck velocity, s/m.
pub(super) const LAG_K: [f64; 2] = [-0.035_058, 0.103_208];
/// The lag form's time constant, s.
pub(super) const LAG_TAU_S: f64 = 0.176_759;
