/* T = a0 + a1 u + a2 u^2 + a3 u^3, u' = (s - u) / T_m, x = sqrt(T). C: a0 to a3, T_m. */
static REAL family_rest(REAL s)
{
    return sqrtR(max_of(cubic_at(C, s), R(0.0)));
}

static REAL family_throttle_for(REAL x, REAL near)
{
    const REAL p[4] = {C[0] - x * x, C[1], C[2], C[3]};
    return first_rise(p, near);
}

static REAL family_step(REAL x, REAL s, REAL dt)
{
    return family_rest(advance_lag(family_throttle_for(x, s), s, C[4], dt));
}
