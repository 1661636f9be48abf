/* A map of height alone has no state. */
static REAL family_rest(const NAME_input *input)
{
    (void)input;
    return R(0.0);
}

static REAL family_advance(REAL value, const NAME_input *input, REAL dt)
{
    (void)input;
    (void)dt;
    return value;
}

static REAL family_limit(REAL value, REAL thrust_n)
{
    (void)thrust_n;
    return value;
}
