/* f / T = h0 + h1 psi1(z) + h2 psi2(z) + h3 psi3(z). C: h0 to h3, L1 to L3. */
static NAME_lift family_lift(REAL value, const NAME_input *input)
{
    const REAL z = input->height_m;
    NAME_lift lift = {R(0.0), R(0.0)};
    (void)value;
    lift.ratio = C[0] + C[1] * psi(z, C[4]) + C[2] * psi(z, C[5]) + C[3] * psi(z, C[6]);
    return lift;
}
