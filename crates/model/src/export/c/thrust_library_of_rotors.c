#undef family_step
#undef family_rest
#undef family_throttle_for

/* C8^2 times as many rotors as eq. (8) is of: X = C8 x. */
static REAL family_step(REAL state, REAL s, REAL dt)
{
    return C[8] * library_step(state / C[8], s, dt);
}

static REAL family_rest(REAL s)
{
    return C[8] * library_rest(s);
}

static REAL family_throttle_for(REAL x, REAL near)
{
    return library_throttle_for(x / C[8], near);
}
