static double double_of(uint64_t bits)
{
    double x;
    (void)memcpy(&x, &bits, sizeof x);
    return x;
}

static uint64_t bits_of(double x)
{
    uint64_t bits;
    (void)memcpy(&bits, &x, sizeof bits);
    return bits;
}

/* High word without the sign. */
static uint32_t high_word(double x)
{
    return (uint32_t)(bits_of(x) >> 32) & 0x7fffffffu;
}

/* 2^k for k in [-1022, 1023]. */
static double power_of_two(int32_t k)
{
    return double_of((uint64_t)(uint32_t)(k + 1023) << 52);
}
