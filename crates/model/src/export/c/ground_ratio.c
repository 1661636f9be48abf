/* y = f / T, y' = C0 + C1 y + C2 psi1 + C3 psi2 + C4 psi3 + C5 v_p + C6 v_p^2 + C7 v_p psi2
 * + C8 v_p psi3; C9 to C11 are the lengths of psi. The state is y. */
static REAL drive(const NAME_input *input)
{
    const REAL p1 = psi(input->height_m, C[9]);
    const REAL p2 = psi(input->height_m, C[10]);
    const REAL p3 = psi(input->height_m, C[11]);
    const REAL deck = input->deck_velocity_mps;
    return C[0] + C[2] * p1 + C[3] * p2 + C[4] * p3
        + deck * (C[5] + C[6] * deck + C[7] * p2 + C[8] * p3);
}

static REAL family_rest(const NAME_input *input)
{
    return linear_rest(drive(input), C[1]);
}

static NAME_lift family_lift(REAL value, const NAME_input *input)
{
    const NAME_lift lift = {value, R(0.0)};
    (void)input;
    return lift;
}

static REAL family_advance(REAL value, const NAME_input *input, REAL dt)
{
    return advance_linear(value, drive(input), C[1], dt);
}

static REAL family_limit(REAL value, REAL thrust_n)
{
    (void)thrust_n;
    return clamp_of(value, RATIO_MIN, RATIO_MAX);
}
