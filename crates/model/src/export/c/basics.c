#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "compile without -ffast-math and -ffinite-math-only: results would be wrong, and NaN would pass"
#endif

static REAL max_of(REAL a, REAL b)
{
    return ((a > b) || isnan(b)) ? a : b;
}

/* Not a number stays so. */
static REAL clamp_of(REAL x, REAL low, REAL high)
{
    REAL result = x;
    if (x < low) {
        result = low;
    } else if (x > high) {
        result = (high < low) ? low : high;
    } else {
        /* within the limits */
    }
    return result;
}

static REAL finite_or(REAL x, REAL fallback)
{
    return isfinite(x) ? x : fallback;
}

/* dt if it is finite and positive, otherwise zero. */
static REAL usable_dt(REAL dt)
{
    return (isfinite(dt) && (dt > R(0.0))) ? dt : R(0.0);
}
