/* 1 / (1 + (z / L)^2): bounded at every height. */
static REAL psi(REAL height_m, REAL length_m)
{
    const REAL u = height_m / length_m;
    return R(1.0) / (R(1.0) + u * u);
}
