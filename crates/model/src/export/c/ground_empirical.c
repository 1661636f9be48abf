/* Eq. (2), f = q / (1 - q) T with q = mu (R / 4z)^2, at most 0.6. C: mu, R, rotor offset. */
static NAME_lift family_lift(REAL value, const NAME_input *input)
{
    const REAL height_m = input->height_m + C[2];
    const REAL u = C[1] / (R(4.0) * max_of(height_m, R(0.001) * C[1]));
    const REAL q = min_of(C[0] * u * u, R(0.6));
    const NAME_lift lift = {q / (R(1.0) - q), R(0.0)};
    (void)value;
    return lift;
}
