/* y' = (target - y) / tau over dt; holds y where the result is not finite. */
static REAL advance_lag(REAL y, REAL target, REAL tau, REAL dt)
{
    return finite_or(y - (target - y) * exp_m1_of(-dt / tau), y);
}
