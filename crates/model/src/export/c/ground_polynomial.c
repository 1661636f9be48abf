/* Eq. (9), f' = C0 + C1 f + C2 s + C3 z + C4 v_p + C5 v_q + C6 s^2 + C7 v_p v_q + C8 z^2
 * + C9 v_p^2 + C10 v_q^2. The state is f, N. */
static REAL polynomial(const NAME_input *input)
{
    const REAL s = input->throttle;
    const REAL z = input->height_m;
    const REAL deck = input->deck_velocity_mps;
    const REAL vehicle = input->vehicle_velocity_mps;
    return C[0] + s * (C[2] + C[6] * s) + z * (C[3] + C[8] * z)
        + deck * (C[4] + C[9] * deck + C[7] * vehicle) + vehicle * (C[5] + C[10] * vehicle);
}

static REAL family_rest(const NAME_input *input)
{
    return linear_rest(polynomial(input), C[1]);
}

static NAME_lift family_lift(REAL value, const NAME_input *input)
{
    const NAME_lift lift = {R(0.0), value};
    (void)input;
    return lift;
}

static REAL family_advance(REAL value, const NAME_input *input, REAL dt)
{
    return advance_linear(value, polynomial(input), C[1], dt);
}

static REAL family_limit(REAL value, REAL thrust_n)
{
    return clamp_of(value, RATIO_MIN * thrust_n, RATIO_MAX * thrust_n);
}
