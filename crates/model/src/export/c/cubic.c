/* a + b s + c s^2 + d s^3 */
static REAL cubic_at(const REAL p[4], REAL s)
{
    return p[0] + s * (p[1] + s * (p[2] + s * p[3]));
}

static REAL unit_of(REAL s)
{
    return isfinite(s) ? clamp_of(s, R(0.0), R(1.0)) : R(1.0);
}

/* The root of a rising cubic in a bracket: Newton's method from near, kept inside by bisection. */
static REAL bracketed_root(const REAL p[4], REAL from, REAL to, REAL near)
{
    REAL low = from;
    REAL high = to;
    REAL s = ((near > low) && (near < high)) ? near : (R(0.5) * (low + high));
    REAL result = s;
    bool found = false;
    int32_t i;
    for (i = 0; (i < 60) && !found; i++) {
        const REAL y = cubic_at(p, s);
        REAL newton;
        if (y >= R(0.0)) {
            high = s;
        } else {
            low = s;
        }
        newton = s - y / (p[1] + s * (R(2.0) * p[2] + s * R(3.0) * p[3]));
        result = ((newton > low) && (newton < high)) ? newton : (R(0.5) * (low + high));
        found = fabsR(result - s) <= EPSILON * fabsR(s);
        s = result;
    }
    return result;
}

/* The least s in [0, 1] at which the cubic reaches zero; where it stays below, the s of its
 * greatest value. */
static REAL first_rise(const REAL p[4], REAL near)
{
    const REAL three_d = R(3.0) * p[3];
    const REAL discriminant = p[2] * p[2] - three_d * p[1];
    REAL ends[3] = {R(1.0), R(1.0), R(1.0)};
    REAL low = R(0.0);
    REAL best = R(0.0);
    REAL best_value = cubic_at(p, low);
    bool done = best_value >= R(0.0);
    int32_t i;
    if ((discriminant > R(0.0)) && isfinite(discriminant)) {
        const REAL root = sqrtR(discriminant);
        const REAL q = (p[2] < R(0.0)) ? (root - p[2]) : -(root + p[2]);
        const REAL first = unit_of(q / three_d);
        const REAL second = unit_of(p[1] / q);
        ends[0] = (first <= second) ? first : second;
        ends[1] = (first <= second) ? second : first;
    }
    for (i = 0; (i < 3) && !done; i++) {
        if (ends[i] > low) {
            const REAL value = cubic_at(p, ends[i]);
            if (value >= R(0.0)) {
                best = bracketed_root(p, low, ends[i], near);
                done = true;
            } else if (value > best_value) {
                best = ends[i];
                best_value = value;
            } else {
                /* not a better end */
            }
            low = ends[i];
        }
    }
    return best;
}
