static const double HALF_PI_HIGH = 1.57079632673412561417e+00;
static const double HALF_PI_LOW = 6.07710050650619224932e-11;

/* x less n quarter turns by more and more parts of a quarter turn; what is lost in *lost. */
static double reduced_medium(double x, double n, double *lost)
{
    const int32_t exponent = (int32_t)(high_word(x) >> 20);
    double r = x - n * HALF_PI_HIGH;
    double w = n * HALF_PI_LOW;
    double y = r - w;
    if ((exponent - (int32_t)(high_word(y) >> 20)) > 16) {
        double t = r;
        w = n * 6.07710050630396597660e-11;
        r = t - w;
        w = n * 2.02226624879595063154e-21 - ((t - r) - w);
        y = r - w;
        if ((exponent - (int32_t)(high_word(y) >> 20)) > 49) {
            t = r;
            w = n * 2.02226624871116645580e-21;
            r = t - w;
            w = n * 8.47842766036889956997e-32 - ((t - r) - w);
            y = r - w;
        }
    }
    *lost = (r - y) - w;
    return y;
}

/* x in [pi/4, 1.6e6] less the nearest number of quarter turns n. */
static double reduced(double x, double *lost, int32_t *n)
{
    static const uint32_t LAST[4] = {0x4002d97cu, 0x400f6a7au, 0x4015fdbcu, 0x401c463bu};
    static const uint32_t NEAR[4] = {0x3ff921fbu, 0x400921fbu, 0x4012d97cu, 0x401921fbu};
    const uint32_t word = high_word(x);
    int32_t turns = 1;
    double angle;
    while ((turns <= 4) && (word > LAST[turns - 1])) {
        turns++;
    }
    if ((turns <= 4) && (word != NEAR[turns - 1])) {
        const double z = x - (double)turns * HALF_PI_HIGH;
        angle = z - (double)turns * HALF_PI_LOW;
        *lost = (z - angle) - (double)turns * HALF_PI_LOW;
    } else {
        /* The nearest integer, by the rounding of a large number. */
        const double whole = (x * 6.36619772367581382433e-01 + 6755399441055744.0) - 6755399441055744.0;
        angle = reduced_medium(x, whole, lost);
        turns = (int32_t)whole;
    }
    *n = turns;
    return angle;
}

static double sine_near_zero(double x, double lost, bool is_exact)
{
    const double z = x * x;
    const double w = z * z;
    const double r = 8.33333333332248946124e-03 + z * (-1.98412698298579493134e-04 + z * 2.75573137070700676789e-06)
        + z * w * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10);
    const double v = z * x;
    const double first = -1.66666666666666324348e-01;
    return is_exact ? (x + v * (first + z * r)) : (x - ((z * (0.5 * lost - v * r) - lost) - v * first));
}

static double cosine_near_zero(double x, double lost)
{
    const double z = x * x;
    const double w = z * z;
    const double r = z * (4.16666666666666019037e-02 + z * (-1.38888888888741095749e-03 + z * 2.48015872894767294178e-05))
        + w * w * (-2.75573143513906633035e-07 + z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11));
    const double half = 0.5 * z;
    const double rest = 1.0 - half;
    return rest + (((1.0 - rest) - half) + (z * r - x * lost));
}

/* Angles up to 1.6e6 rad; not a number beyond, which no state within its limits reaches. */
static void sin_cos_of(double x, double *sine, double *cosine)
{
    const double magnitude = fabs(x);
    const uint32_t word = high_word(x);
    double s;
    double c;
    if (!(magnitude < 1.6e6)) {
        s = (double)NAN;
        c = (double)NAN;
    } else if (word <= 0x3fe921fbu) {
        s = (word < 0x3e500000u) ? magnitude : sine_near_zero(magnitude, 0.0, true);
        c = (word < 0x3e46a09eu) ? 1.0 : cosine_near_zero(magnitude, 0.0);
    } else {
        double lost;
        int32_t n;
        const double angle = reduced(magnitude, &lost, &n);
        const double near_s = sine_near_zero(angle, lost, false);
        const double near_c = cosine_near_zero(angle, lost);
        const uint32_t quarters = (uint32_t)n & 3u;
        s = ((quarters & 1u) == 0u) ? near_s : near_c;
        c = ((quarters & 1u) == 0u) ? near_c : near_s;
        if ((quarters & 2u) != 0u) {
            s = -s;
        }
        if ((quarters == 1u) || (quarters == 2u)) {
            c = -c;
        }
    }
    *sine = (signbit(x) != 0) ? -s : s;
    *cosine = c;
}
