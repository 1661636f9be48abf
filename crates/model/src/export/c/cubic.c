/* a + b s + c s^2 + d s^3 */
static REAL cubic_at(const REAL p[4], REAL s)
{
    return p[0] + s * (p[1] + s * (p[2] + s * p[3]));
}

static REAL unit_of(REAL s)
{
    return isfinite(s) ? clamp_of(s, R(0.0), R(1.0)) : R(1.0);
}

/* The least s in [0, 1] at which a cubic that begins below zero reaches zero, if Newton's method from near
 * ends there in few steps. */
static bool rise_near(const REAL p[4], REAL near, REAL *rise)
{
    REAL s = near;
    bool inside = (s > R(0.0)) && (s < R(1.0));
    bool found = false;
    int32_t i;
    for (i = 0; (i < 4) && inside && !found; i++) {
        const REAL steeper = s * R(3.0) * p[3];
        const REAL slope = p[1] + s * (R(2.0) * p[2] + steeper);
        if (slope > R(0.0)) {
            const REAL newton = s - cubic_at(p, s) / slope;
            const REAL step = newton - s;
            /* Value of the cubic after the step. */
            const REAL left = (p[2] + steeper + p[3] * step) * (step * step);
            found = fabsR(left) <= EPSILON * s * slope;
            s = newton;
            inside = (s > R(0.0)) && (s < R(1.0));
        } else {
            inside = false;
        }
    }
    if (inside && found) {
        /* The cubic over (s - root) is d s^2 + e s + f, which is above zero at 0 and at the root. */
        const REAL d = p[3];
        const REAL e = p[2] + d * s;
        const REAL f = p[1] + e * s;
        const bool monotone = (e >= R(0.0)) || ((e + R(2.0) * d * s) <= R(0.0));
        found = (d <= R(0.0)) || monotone || ((e * e) < (R(4.0) * d * f));
        found = found && ((f + s * (e + d * s)) > R(0.0));
    }
    found = inside && found;
    if (found) {
        *rise = s;
    }
    return found;
}

/* The root between low, where the cubic is below zero, and high, where it is not. */
static REAL bracketed_root(const REAL p[4], REAL from, REAL to)
{
    REAL low = from;
    REAL high = to;
    bool done = false;
    int32_t i;
    for (i = 0; (i < 60) && !done; i++) {
        const REAL middle = R(0.5) * (low + high);
        if ((middle <= low) || (middle >= high)) {
            done = true;
        } else if (cubic_at(p, middle) >= R(0.0)) {
            high = middle;
        } else {
            low = middle;
        }
    }
    return high;
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
    bool done = (best_value >= R(0.0)) || rise_near(p, near, &best);
    int32_t i;
    if (!done && (discriminant > R(0.0)) && isfinite(discriminant)) {
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
                best = bracketed_root(p, low, ends[i]);
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
