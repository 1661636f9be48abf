/* A point of the descent. */
typedef struct {
    REAL height_m;
    REAL velocity_mps;
    REAL acceleration_mps2;
} descent_point;

/* Eq. (13), z_r = h + (z0 - h) (1 + C t) exp(-C t). */
static descent_point descent_at(const NAME_settings *settings, REAL time_s)
{
    const REAL c = settings->c_per_s;
    const REAL u = max_of(c * time_s, R(0.0));
    const REAL scale = (settings->start_height_m - settings->end_height_m) * exp_of(-u);
    descent_point point;
    point.height_m = settings->end_height_m + scale * (R(1.0) + u);
    point.velocity_mps = -scale * c * u;
    point.acceleration_mps2 = scale * c * c * (u - R(1.0));
    return point;
}

/* Thrust that a law asks for, N, and the sliding variable s = (v - z_r') + Gamma (z - z_r), m/s. */
typedef struct {
    REAL thrust_n;
    REAL sliding_mps;
} demand_of_law;

/* How a demand met the limits. */
typedef enum {
    WITHIN_LIMITS,
    MORE_WAS_SENT,
    LESS_WAS_SENT
} limits_met;

/* Whether a thrust pushes further into the limit. */
static bool resists(limits_met met, REAL push_n)
{
    return ((met == MORE_WAS_SENT) && (push_n < R(0.0))) || ((met == LESS_WAS_SENT) && (push_n > R(0.0)));
}

/* The internal model's contribution, N. */
static REAL internal_n(const NAME_settings *settings, const REAL xi[3])
{
    const REAL *p = settings->imbc_poles_per_s;
    const REAL w = settings->imbc_angular_frequency;
    const REAL c0 = p[0] * p[1] * p[2];
    const REAL c1 = p[0] * p[1] + p[1] * p[2] + p[2] * p[0];
    const REAL c2 = p[0] + p[1] + p[2];
    return c0 * xi[0] + (c1 - w * w) * xi[1] + c2 * xi[2];
}

static demand_of_law law_demand(const NAME_state *state, const NAME_settings *settings, lift_of_air lift,
    REAL deck_mps2, REAL dt)
{
    const descent_point point = descent_at(settings, state->time.value);
    const REAL gamma = settings->gamma;
    const REAL error_mps = state->measurement.relative_velocity_mps - point.velocity_mps;
    const REAL s = error_mps + gamma * (state->measurement.height_m - point.height_m);
    const REAL relative_mps2 = point.acceleration_mps2 - gamma * error_mps;
    const REAL weight_n = settings->mass_kg * settings->gravity_mps2;
    demand_of_law demand;
    demand.sliding_mps = s;
    if (settings->law == NAME_IMBC) {
        demand.thrust_n = weight_n + settings->mass_kg * relative_mps2 - settings->k_p * s
            + internal_n(settings, state->xi);
    } else if (settings->law == NAME_SSC) {
        const REAL u = weight_n + settings->mass_kg * (deck_mps2 + relative_mps2) - settings->k_p * s
            - settings->ssc_rho_n * tanh_of(s / settings->ssc_phi_mps);
        demand.thrust_n = advance_lag(state->filtered_n, u, settings->ssc_filter_s, dt);
    } else {
        const REAL base = settings->mass_kg * (deck_mps2 + relative_mps2) - settings->k_p * s
            - state->integral_n + weight_n;
        demand.thrust_n = (base - lift.force_n) / (R(1.0) + lift.ratio);
    }
    return demand;
}

/* Advances the internal model, exactly for a constant push; its contribution is at most 20 N. */
static void internal_advance(NAME_state *state, const NAME_settings *settings, REAL sliding_mps,
    limits_met met, REAL dt)
{
    const REAL w = settings->imbc_angular_frequency;
    const REAL limit_n = R(20.0);
    const REAL *xi = state->xi;
    REAL next[3];
    REAL u = -settings->k_p * sliding_mps;
    REAL sine;
    REAL cosine;
    REAL half_sine;
    REAL unused;
    REAL s1;
    REAL s2;
    REAL s3;
    REAL size;
    if (resists(met, u)) {
        u = R(0.0);
    }
    sin_cos_of(w * dt, &sine, &cosine);
    sin_cos_of(R(0.5) * w * dt, &half_sine, &unused);
    s1 = sine / w;
    s2 = R(2.0) * half_sine * half_sine / (w * w);
    s3 = (dt - s1) / (w * w);
    next[0] = xi[0] + s1 * xi[1] + s2 * xi[2] + s3 * u;
    next[1] = cosine * xi[1] + s1 * xi[2] + s2 * u;
    next[2] = cosine * xi[2] - w * sine * xi[1] + s1 * u;
    size = fabsR(internal_n(settings, next));
    if (size > limit_n) {
        int32_t i;
        for (i = 0; i < 3; i++) {
            next[i] = next[i] * (limit_n / size);
        }
    }
    if (isfinite(next[0]) && isfinite(next[1]) && isfinite(next[2])) {
        (void)memcpy(state->xi, next, sizeof next);
    }
}

/* Advances the law's state, once it is known what was sent. */
static void law_advance(NAME_state *state, const NAME_settings *settings, const demand_of_law *demand,
    limits_met met, REAL dt)
{
    if (settings->law == NAME_IMBC) {
        internal_advance(state, settings, demand->sliding_mps, met, dt);
    } else if (settings->law == NAME_SSC) {
        /* What was sent, so that the filter does not wind up beyond the limits. */
        state->filtered_n = finite_or(state->thrust_n, state->filtered_n);
    } else {
        const REAL change = settings->k_i * demand->sliding_mps * dt;
        const REAL limit_n = settings->integral_limit_n;
        if (!resists(met, -change)) {
            state->integral_n = finite_or(clamp_of(state->integral_n + change, -limit_n, limit_n),
                state->integral_n);
        }
    }
}
