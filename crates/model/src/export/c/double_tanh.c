static double tanh_of(double x)
{
    const double magnitude = fabs(x);
    const uint32_t word = high_word(x);
    double t;
    if (word > 0x40340000u) {
        t = 1.0 - 0.0 / magnitude;
    } else if (word > 0x3fe193eau) {
        t = 1.0 - 2.0 / (exp_m1_of(2.0 * magnitude) + 2.0);
    } else if (word > 0x3fd058aeu) {
        t = exp_m1_of(2.0 * magnitude);
        t = t / (t + 2.0);
    } else if (word >= 0x00100000u) {
        t = exp_m1_of(-2.0 * magnitude);
        t = -t / (t + 2.0);
    } else {
        t = magnitude;
    }
    return (signbit(x) != 0) ? -t : t;
}
