/* exp(x) - 1 from the reduced argument x, what its rounding lost, and the power of two k. */
static double exp_m1_reduced(double x, double lost, int32_t k)
{
    const double half_x = 0.5 * x;
    const double square = x * half_x;
    const double r = 1.0 + square * (-3.33333333333331316428e-02 + square * (1.58730158725481460165e-03
        + square * (-7.93650757867487942473e-05 + square * (4.00821782732936239552e-06
        + square * -2.01099218183624371326e-07))));
    const double t = 3.0 - r * half_x;
    double e = square * ((r - t) / (6.0 - x * t));
    double result;
    if (k == 0) {
        result = x - (x * e - square);
    } else {
        e = x * (e - lost) - lost;
        e -= square;
        if (k == -1) {
            result = 0.5 * (x - e) - 0.5;
        } else if (k == 1) {
            result = (x < -0.25) ? (-2.0 * (e - (x + 0.5))) : (1.0 + 2.0 * (x - e));
        } else if ((k < 0) || (k > 56)) {
            result = x - e + 1.0;
            result = (k == 1024) ? (result * 2.0 * power_of_two(1023)) : (result * power_of_two(k));
            result = result - 1.0;
        } else if (k < 20) {
            result = (x - e + (1.0 - power_of_two(-k))) * power_of_two(k);
        } else {
            result = (x - (e + power_of_two(-k)) + 1.0) * power_of_two(k);
        }
    }
    return result;
}

/* exp(x) - 1 without loss of digits near zero. */
static double exp_m1_of(double x)
{
    const uint32_t word = high_word(x);
    const bool negative = signbit(x) != 0;
    double result;
    if (isnan(x) || (word < 0x3c900000u)) {
        result = x;
    } else if (negative && (word >= 0x4043687Au)) {
        result = -1.0;
    } else if (x > 7.09782712893383973096e+02) {
        result = (double)INFINITY;
    } else if (word > 0x3fd62e42u) {
        int32_t k;
        double high;
        double low;
        double reduced;
        if (word < 0x3ff0a2b2u) {
            k = negative ? -1 : 1;
        } else {
            k = (int32_t)(INVERSE_LN2 * x + (negative ? -0.5 : 0.5));
        }
        high = x - (double)k * LN2_HIGH;
        low = (double)k * LN2_LOW;
        reduced = high - low;
        result = exp_m1_reduced(reduced, (high - reduced) - low, k);
    } else {
        result = exp_m1_reduced(x, 0.0, 0);
    }
    return result;
}
