/* exp(x) - 1 without loss of digits near zero. */
static float exp_m1_of(float x)
{
    float result;
    if (isnan(x)) {
        result = x;
    } else if (x > 88.0f) {
        result = exp_of(x) - 1.0f;
    } else if (x < -18.0f) {
        result = -1.0f;
    } else {
        int32_t exponent;
        const float rise = exponential_parts(x, &exponent);
        const float scale = power_of_two(exponent);
        result = scale * rise + (scale - 1.0f);
    }
    return result;
}
