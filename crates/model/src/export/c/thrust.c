/* The state sqrt(T) within its limits, 0.3 and 30 sqrt(N). */
static REAL limit(REAL x)
{
    return clamp_of(x, R(0.3), R(30.0));
}

void NAME_init(NAME_state *state, REAL throttle)
{
    state->root_thrust = limit(family_rest(clamp_of(finite_or(throttle, R(0.0)), R(0.0), R(1.0))));
}

REAL NAME_step(NAME_state *state, REAL throttle, REAL dt)
{
    const REAL h = usable_dt(dt);
    if (isfinite(throttle) && (h > R(0.0))) {
        const REAL s = clamp_of(throttle, R(0.0), R(1.0));
        state->root_thrust = limit(finite_or(family_step(state->root_thrust, s, h), state->root_thrust));
    }
    return state->root_thrust * state->root_thrust;
}

REAL NAME_throttle_near(REAL thrust_n, REAL near)
{
    return family_throttle_for(limit(sqrtR(max_of(thrust_n, R(0.0)))), near);
}

REAL NAME_throttle_for(REAL thrust_n)
{
    return NAME_throttle_near(thrust_n, R(0.5));
}
