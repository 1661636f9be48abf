/* 1.5 2^23: a small number that is added to it is rounded to an integer, in the low bits. */
static const float TO_INTEGER = 12582912.0f;

/* 2^k for k in [-126, 127]. */
static float power_of_two(int32_t k)
{
    return float_of((uint32_t)(k + 127) << 23);
}

/* exp(r) - 1 and k, with x = r + k ln 2 and |r| at most half of ln 2. */
static float exponential_parts(float x, int32_t *exponent)
{
    const float shifted = x * 1.44269504f + TO_INTEGER;
    const float k = shifted - TO_INTEGER;
    const float r = (x - k * 0.693359375f) - k * -2.12194440e-4f;
    const float tail = 4.1665796e-2f + r * (8.333452e-3f + r * (1.3982e-3f + r * 1.9875692e-4f));
    const float curve = 0.5f + r * (1.6666665e-1f + r * tail);
    *exponent = (int32_t)(bits_of(shifted) - bits_of(TO_INTEGER));
    return r + r * r * curve;
}

static float exp_of(float x)
{
    float result;
    if (x > 88.72284f) {
        result = INFINITY;
    } else if (x < -103.97208f) {
        result = 0.0f;
    } else {
        int32_t exponent;
        const float rise = exponential_parts(x, &exponent);
        /* Floor of a half, also for negative numbers. */
        const int32_t half = ((exponent + 256) / 2) - 128;
        result = (rise + 1.0f) * power_of_two(half) * power_of_two(exponent - half);
    }
    return isnan(x) ? x : result;
}
