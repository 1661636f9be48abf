static float tanh_of(float x)
{
    /* exp(-2|x|) - 1 is in (-1, 0]: nothing cancels or overflows. */
    const float fall = exp_m1_of(-2.0f * fabsf(x));
    const float magnitude = -fall / (fall + 2.0f);
    return (x < 0.0f) ? -magnitude : magnitude;
}
