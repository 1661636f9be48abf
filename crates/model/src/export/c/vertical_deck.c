/* Adds a term if the result is finite. */
static void sum_add(NAME_sum *sum, REAL term)
{
    const REAL y = term - sum->carry;
    const REAL total = sum->value + y;
    if (isfinite(total)) {
        sum->carry = (total - sum->value) - y;
        sum->value = total;
    }
}

static NAME_turn turn_of(REAL angular_frequency, REAL time_s)
{
    NAME_turn turn;
    REAL sine;
    sin_cos_of(angular_frequency * time_s, &sine, &turn.cosine);
    turn.angular_frequency = angular_frequency;
    turn.time_s = time_s;
    turn.sine_over_w = sine / angular_frequency;
    turn.w_sine = angular_frequency * sine;
    return turn;
}

/* The rotation of these numbers: the last one if it is. */
static NAME_turn turn_or_new(const NAME_turn *last, REAL angular_frequency, REAL time_s)
{
    const bool same = (last->angular_frequency >= angular_frequency)
        && (last->angular_frequency <= angular_frequency) && (last->time_s >= time_s)
        && (last->time_s <= time_s);
    return same ? *last : turn_of(angular_frequency, time_s);
}

static void turned(const NAME_turn *turn, REAL p, REAL v, REAL *next_p, REAL *next_v)
{
    *next_p = turn->cosine * p + turn->sine_over_w * v;
    *next_v = turn->cosine * v - turn->w_sine * p;
}

static void deck_init(NAME_deck *deck, const NAME_settings *settings)
{
    const REAL w = settings->deck_angular_frequency;
    const NAME_sum zero = {R(0.0), R(0.0)};
    /* 0.3 m/s: standard deviation of the deck's velocity before any measurement. */
    const REAL sd = R(0.3);
    const REAL sd_p = sd / w;
    deck->displacement_m = R(0.0);
    deck->velocity_mps = R(0.0);
    deck->covariance[0] = sd_p * sd_p;
    deck->covariance[1] = R(0.0);
    deck->covariance[2] = sd * sd;
    deck->elapsed = zero;
    deck->turn = turn_of(w, R(0.0));
    deck->ahead = turn_of(w, settings->deck_lead_s);
}

/* Kalman filter of p'' = -w^2 p: the exact rotation over dt. */
static void deck_propagate(NAME_deck *deck, const NAME_settings *settings, REAL dt)
{
    const REAL w = settings->deck_angular_frequency;
    const REAL q = settings->deck_process_sd * settings->deck_process_sd * dt;
    REAL a;
    REAL b;
    REAL c;
    REAL d;
    REAL pp;
    REAL pv;
    REAL unused;
    REAL vv;
    deck->turn = turn_or_new(&deck->turn, w, dt);
    turned(&deck->turn, deck->displacement_m, deck->velocity_mps, &a, &b);
    deck->displacement_m = a;
    deck->velocity_mps = b;
    turned(&deck->turn, deck->covariance[0], deck->covariance[1], &a, &b);
    turned(&deck->turn, deck->covariance[1], deck->covariance[2], &c, &d);
    turned(&deck->turn, a, c, &pp, &pv);
    turned(&deck->turn, b, d, &unused, &vv);
    deck->covariance[0] = pp + q / (w * w);
    deck->covariance[1] = pv;
    deck->covariance[2] = vv + q;
    sum_add(&deck->elapsed, dt);
}

/* Its correction by a measured velocity. */
static void deck_correct(NAME_deck *deck, const NAME_settings *settings, REAL velocity_mps)
{
    const REAL pp = deck->covariance[0];
    const REAL pv = deck->covariance[1];
    const REAL vv = deck->covariance[2];
    const REAL variance = settings->deck_measurement_sd * settings->deck_measurement_sd;
    const REAL total = vv + variance;
    const REAL innovation = velocity_mps - deck->velocity_mps;
    deck->displacement_m += pv / total * innovation;
    deck->velocity_mps += vv / total * innovation;
    deck->covariance[0] = max_of(pp - pv * pv / total, R(0.0));
    deck->covariance[1] = pv * variance / total;
    deck->covariance[2] = vv * variance / total;
}

static bool deck_is_finite(const NAME_deck *deck)
{
    return isfinite(deck->displacement_m) && isfinite(deck->velocity_mps)
        && isfinite(deck->covariance[0]) && isfinite(deck->covariance[1])
        && isfinite(deck->covariance[2]);
}

/* Acceleration of the deck when the rotors act, m/s^2; zero before it is used. */
static REAL deck_step(NAME_deck *deck, const NAME_settings *settings, REAL velocity_mps, REAL dt)
{
    const REAL w = settings->deck_angular_frequency;
    NAME_deck next = *deck;
    REAL result = R(0.0);
    deck_propagate(&next, settings, dt);
    if (isfinite(velocity_mps)) {
        deck_correct(&next, settings, velocity_mps);
    }
    if (deck_is_finite(&next)) {
        *deck = next;
    }
    if (!(deck->elapsed.value < settings->deck_enable_after_s)) {
        const NAME_turn ahead = turn_or_new(&deck->ahead, w, settings->deck_lead_s);
        REAL p;
        REAL v;
        turned(&ahead, deck->displacement_m, deck->velocity_mps, &p, &v);
        result = -(w * w) * p;
    }
    return result;
}
