/* x' = (c0 s + c1 - x) / T_m, x = sqrt(T): eq. (7). C: c0, c1, T_m. */
static REAL family_rest(REAL s)
{
    return C[0] * s + C[1];
}

static REAL family_step(REAL x, REAL s, REAL dt)
{
    return advance_lag(x, family_rest(s), C[2], dt);
}

static REAL family_throttle_for(REAL x, REAL near)
{
    const REAL p[4] = {C[1] - x, C[0], R(0.0), R(0.0)};
    return first_rise(p, near);
}
