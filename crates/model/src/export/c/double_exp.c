static double exp_of(double x)
{
    const uint32_t word = high_word(x);
    const bool negative = signbit(x) != 0;
    double result;
    if (isnan(x)) {
        result = x;
    } else if (x > 709.782712893383973096) {
        result = (double)INFINITY;
    } else if (x < -745.13321910194110842) {
        result = 0.0;
    } else if (word <= 0x3e300000u) {
        result = 1.0 + x;
    } else {
        int32_t k = 0;
        double high = x;
        double low = 0.0;
        double r;
        double xx;
        double c;
        if (word > 0x3fd62e42u) {
            if (word >= 0x3ff0a2b2u) {
                k = (int32_t)(INVERSE_LN2 * x + (negative ? -0.5 : 0.5));
            } else {
                k = negative ? -1 : 1;
            }
            high = x - (double)k * LN2_HIGH;
            low = (double)k * LN2_LOW;
        }
        r = high - low;
        xx = r * r;
        c = r - xx * (1.66666666666666019037e-01 + xx * (-2.77777777770155933842e-03
            + xx * (6.61375632143793436117e-05 + xx * (-1.65339022054652515390e-06
            + xx * 4.13813679705723846039e-08))));
        result = 1.0 + (r * c / (2.0 - c) - low + high);
        if (k != 0) {
            /* Two factors, because 2^1024 and subnormal powers are not a single one. */
            const int32_t half = k / 2;
            result = result * power_of_two(half) * power_of_two(k - half);
        }
    }
    return result;
}
