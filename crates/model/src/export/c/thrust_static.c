/* x' = (a0 + a1 s + a2 s^2 + a3 s^3 - x) / T_m, x = sqrt(T). C: a0 to a3, T_m. */
static REAL family_rest(REAL s)
{
    return cubic_at(C, s);
}

static REAL family_step(REAL x, REAL s, REAL dt)
{
    return advance_lag(x, family_rest(s), C[4], dt);
}

static REAL family_throttle_for(REAL x, REAL near)
{
    const REAL p[4] = {C[0] - x, C[1], C[2], C[3]};
    return first_rise(p, near);
}
