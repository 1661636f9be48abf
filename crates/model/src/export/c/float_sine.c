/* Angles up to 12 800 rad; not a number beyond, which no state within its limits reaches. */
static void sin_cos_of(float x, float *sine, float *cosine)
{
    float angle = x;
    float lost = -0.0f;
    uint32_t quarters = 0u;
    float s;
    float c;
    float z;
    float cube;
    float tail;
    if (!(fabsf(x) <= 12800.0f)) {
        angle = NAN;
    } else if (fabsf(x) > 0.785398163f) {
        const float shifted = x * 0.636619772f + TO_INTEGER;
        const float turns = shifted - TO_INTEGER;
        const float coarse = (x - turns * 1.5703125f) - turns * 4.837513e-4f;
        angle = coarse - turns * 7.5495336e-8f;
        lost = ((coarse - angle) - turns * 7.5495336e-8f) - turns * 2.563344e-12f;
        quarters = bits_of(shifted) & 3u;
    } else {
        /* nothing to reduce */
    }
    z = angle * angle;
    cube = angle * z * (-1.6666655e-1f + z * (8.332161e-3f + z * -1.9515296e-4f));
    s = (fabsf(angle) < 2.4414063e-4f) ? (angle + lost) : (angle + (cube + lost));
    tail = z * z * (4.1666646e-2f + z * (-1.3887316e-3f + z * 2.4433157e-5f));
    c = 1.0f - (0.5f * z - (tail - angle * lost));
    *sine = ((quarters & 1u) == 0u) ? s : c;
    *cosine = ((quarters & 1u) == 0u) ? c : s;
    if ((quarters & 2u) != 0u) {
        *sine = -*sine;
    }
    if ((quarters == 1u) || (quarters == 2u)) {
        *cosine = -*cosine;
    }
}
