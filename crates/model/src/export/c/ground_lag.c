/* y = f / T = G + (k0 + k1 psi3(z)) v_p, G' = (h(z) - G) / tau. C: h0 to h3, L1 to L3, k0, k1,
 * tau. The state is G. */
static REAL map_ratio(REAL z)
{
    return C[0] + C[1] * psi(z, C[4]) + C[2] * psi(z, C[5]) + C[3] * psi(z, C[6]);
}

static REAL family_rest(const NAME_input *input)
{
    return map_ratio(input->height_m);
}

static NAME_lift family_lift(REAL value, const NAME_input *input)
{
    NAME_lift lift = {R(0.0), R(0.0)};
    lift.ratio = value + (C[7] + C[8] * psi(input->height_m, C[6])) * input->deck_velocity_mps;
    return lift;
}

static REAL family_advance(REAL value, const NAME_input *input, REAL dt)
{
    return advance_lag(value, map_ratio(input->height_m), C[9], dt);
}

static REAL family_limit(REAL value, REAL thrust_n)
{
    (void)thrust_n;
    return clamp_of(value, RATIO_MIN, RATIO_MAX);
}
