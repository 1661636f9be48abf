/* Eq. (8), x' = C0 + C1 x + C2 s + C3 s^2 + C4 x^3 + C5 s^3 + C6 exp(-x) s + C7 sin(x) s. */

/* The model at a given x, as a cubic in s. */
static void library_cubic(REAL x, REAL p[4])
{
    REAL sine;
    REAL cosine;
    sin_cos_of(x, &sine, &cosine);
    p[0] = C[0] + x * (C[1] + C[4] * x * x);
    p[1] = C[2] + C[6] * exp_of(-x) + C[7] * sine;
    p[2] = C[3];
    p[3] = C[5];
}

static REAL library_derivative(REAL x, REAL s)
{
    REAL p[4];
    library_cubic(x, p);
    return cubic_at(p, s);
}

/* The derivative close to a state: exp and sin as a Taylor series about it. */
static REAL near_derivative(const REAL series[7], REAL state, REAL by, REAL s)
{
    const REAL x = state + by;
    REAL result;
    if (fabsR(by) <= R(0.02)) {
        const REAL drive = C[2] + series[0] + by * (series[1] + by * (series[2] + by * (series[3]
            + by * (series[4] + by * (series[5] + by * series[6])))));
        result = C[0] + x * (C[1] + C[4] * x * x) + s * (drive + s * (C[3] + s * C[5]));
    } else {
        result = library_derivative(x, s);
    }
    return result;
}

static REAL limit(REAL x);

/* Runge-Kutta steps of order four, of at most 20 ms, at most 256 of them. */
static REAL family_step(REAL state, REAL s, REAL dt)
{
    const REAL wanted = min_of(dt / R(0.02), R(256.0));
    REAL x = state;
    REAL h;
    int32_t steps = 1;
    int32_t i;
    while ((REAL)steps < wanted) {
        steps++;
    }
    h = dt / (REAL)steps;
    for (i = 0; i < steps; i++) {
        const REAL half = R(0.5) * h;
        const REAL sixth = h / R(6.0);
        const REAL falling = C[6] * exp_of(-x);
        REAL sine;
        REAL cosine;
        REAL series[7];
        REAL k1;
        REAL k2;
        REAL k3;
        REAL k4;
        sin_cos_of(x, &sine, &cosine);
        sine = C[7] * sine;
        cosine = C[7] * cosine;
        series[0] = falling + sine;
        series[1] = cosine - falling;
        series[2] = (falling - sine) * R(0.5);
        series[3] = -(falling + cosine) * R(0.16666666666666666);
        series[4] = (falling + sine) * R(0.041666666666666664);
        series[5] = (cosine - falling) * R(0.008333333333333333);
        series[6] = (falling - sine) * R(0.001388888888888889);
        k1 = near_derivative(series, x, R(0.0), s);
        k2 = near_derivative(series, x, half * k1, s);
        k3 = near_derivative(series, x, half * k2, s);
        k4 = near_derivative(series, x, h * k3, s);
        x = limit(finite_or(x + sixth * (k1 + R(2.0) * (k2 + k3) + k4), x));
    }
    return x;
}

/* The greatest root of the derivative above which x falls: the greatest stable one. Where x rises everywhere, the greatest x. */
static REAL family_rest(REAL s)
{
    REAL high = R(30.0);
    REAL low = high;
    int32_t i;
    bool falls = library_derivative(low, s) < R(0.0);
    while ((!falls) && (low > R(0.3))) {
        low = low * R(0.9);
        falls = (low > R(0.3)) && (library_derivative(low, s) < R(0.0));
    }
    if (falls) {
        while (falls) {
            high = low;
            low = low * R(0.9);
            falls = (low > R(0.3)) && (library_derivative(low, s) < R(0.0));
        }
        if (low <= R(0.3)) {
            low = R(0.3);
        }
        for (i = 0; i < 60; i++) {
            const REAL middle = R(0.5) * (low + high);
            if (library_derivative(middle, s) < R(0.0)) {
                high = middle;
            } else {
                low = middle;
            }
        }
    } else {
        low = high;
    }
    return low;
}

static REAL family_throttle_for(REAL x, REAL near)
{
    REAL p[4];
    library_cubic(x, p);
    return first_rise(p, near);
}
