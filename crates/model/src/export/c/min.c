static REAL min_of(REAL a, REAL b)
{
    return ((a < b) || isnan(b)) ? a : b;
}
