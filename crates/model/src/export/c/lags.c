/* y' = a + b y over dt; holds y where the result is not finite. */
static REAL advance_linear(REAL y, REAL a, REAL b, REAL dt)
{
    const REAL bdt = b * dt;
    const REAL scale = (fabsR(bdt) <= R(0.0)) ? R(1.0) : (exp_m1_of(bdt) / bdt);
    return finite_or(y + (a + b * y) * dt * scale, y);
}

/* The rest of y' = a + b y where it is stable, otherwise zero. */
static REAL linear_rest(REAL a, REAL b)
{
    return (b < R(0.0)) ? finite_or(-a / b, R(0.0)) : R(0.0);
}
