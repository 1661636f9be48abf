static bool is_positive(REAL x)
{
    return isfinite(x) && (x > R(0.0));
}

static bool is_not_negative(REAL x)
{
    return isfinite(x) && (x >= R(0.0));
}

/* Both finite, and the first below the second. */
static bool are_ordered(REAL low, REAL high)
{
    return isfinite(low) && isfinite(high) && (low < high);
}

static bool law_is_valid(const NAME_settings *s)
{
    bool valid;
    if (s->law == NAME_IMBC) {
        valid = is_positive(s->imbc_angular_frequency) && is_positive(s->imbc_poles_per_s[0])
            && is_positive(s->imbc_poles_per_s[1]) && is_positive(s->imbc_poles_per_s[2]);
    } else if (s->law == NAME_SSC) {
        valid = is_not_negative(s->ssc_rho_n) && is_positive(s->ssc_phi_mps) && is_positive(s->ssc_filter_s);
    } else {
        valid = (s->law == NAME_COMPOSITE) && is_not_negative(s->k_i) && is_not_negative(s->integral_limit_n);
    }
    return valid && is_positive(s->k_p) && is_positive(s->gamma);
}

static bool deck_is_valid(const NAME_settings *s)
{
    return !s->deck_filter
        || (is_positive(s->deck_angular_frequency) && is_positive(s->deck_measurement_sd)
            && is_not_negative(s->deck_process_sd) && is_not_negative(s->deck_enable_after_s)
            && is_not_negative(s->deck_lead_s));
}

bool NAME_settings_are_valid(const NAME_settings *settings)
{
    const NAME_settings *s = settings;
    return is_positive(s->mass_kg) && is_positive(s->gravity_mps2) && law_is_valid(s) && deck_is_valid(s)
        && is_positive(s->c_per_s) && are_ordered(s->end_height_m, s->start_height_m)
        && is_not_negative(s->thrust_min_n) && are_ordered(s->thrust_min_n, s->thrust_max_n)
        && is_not_negative(s->throttle_min) && are_ordered(s->throttle_min, s->throttle_max)
        && (s->throttle_max <= R(1.0));
}

/* A measurement with every value that is not finite taken from the last one. */
static NAME_measurement finite_measurement(const NAME_measurement *latest, const NAME_measurement *last)
{
    NAME_measurement result;
    result.height_m = finite_or(latest->height_m, last->height_m);
    result.relative_velocity_mps = finite_or(latest->relative_velocity_mps, last->relative_velocity_mps);
    result.vehicle_velocity_mps = finite_or(latest->vehicle_velocity_mps, last->vehicle_velocity_mps);
    return result;
}

static REAL rotor_thrust(const NAME_state *state)
{
    return state->rotors.root_thrust * state->rotors.root_thrust;
}

void NAME_init(NAME_state *state, const NAME_settings *settings, const NAME_measurement *measurement,
    REAL throttle)
{
    const NAME_sum zero = {R(0.0), R(0.0)};
    NAME_measurement start = {R(0.0), R(0.0), R(0.0)};
    start.height_m = descent_at(settings, R(0.0)).height_m;
    state->measurement = finite_measurement(measurement, &start);
    state->time = zero;
    state->integral_n = R(0.0);
    state->xi[0] = R(0.0);
    state->xi[1] = R(0.0);
    state->xi[2] = R(0.0);
    state->throttle = clamp_of(finite_or(throttle, R(0.0)), settings->throttle_min, settings->throttle_max);
    @THRUST@init(&state->rotors, state->throttle);
    state->thrust_n = rotor_thrust(state);
    state->filtered_n = state->thrust_n;
    air_init(state, state->thrust_n);
    deck_init(&state->deck, settings);
}

/* Limits of the actuators: the thrust that was sent and its throttle go into the state. */
static limits_met sent_within(NAME_state *state, const NAME_settings *settings, REAL asked_n)
{
    const REAL thrust_n = clamp_of(asked_n, settings->thrust_min_n, settings->thrust_max_n);
    const REAL throttle = clamp_of(@THRUST@throttle_near(thrust_n, state->throttle), settings->throttle_min,
        settings->throttle_max);
    limits_met met = WITHIN_LIMITS;
    /* At the end of the throttle the rotors may not give what is asked for. */
    if ((asked_n > thrust_n) || (throttle >= settings->throttle_max)) {
        met = LESS_WAS_SENT;
    } else if ((asked_n < thrust_n) || (throttle <= settings->throttle_min)) {
        met = MORE_WAS_SENT;
    } else {
        /* sent as asked for */
    }
    state->thrust_n = thrust_n;
    state->throttle = throttle;
    return met;
}

NAME_command NAME_step(NAME_state *state, const NAME_settings *settings,
    const NAME_measurement *measurement, REAL dt)
{
    const REAL h = usable_dt(dt);
    /* As it was measured: the deck filter ignores what is not finite. */
    const REAL deck_mps = measurement->vehicle_velocity_mps - measurement->relative_velocity_mps;
    REAL deck_mps2 = R(0.0);
    NAME_command command;
    lift_of_air lift;
    demand_of_law demand;
    limits_met met;
    state->measurement = finite_measurement(measurement, &state->measurement);
    (void)@THRUST@step(&state->rotors, state->throttle, h);
    lift = air_step(state, rotor_thrust(state), h);
    if (settings->deck_filter) {
        deck_mps2 = deck_step(&state->deck, settings, deck_mps, h);
    }
    demand = law_demand(state, settings, lift, deck_mps2, h);
    met = sent_within(state, settings, finite_or(demand.thrust_n, state->thrust_n));
    law_advance(state, settings, &demand, met, h);
    sum_add(&state->time, h);
    command.thrust_n = state->thrust_n;
    command.throttle = state->throttle;
    command.ground_effect_n = R(0.0);
    if (settings->law == NAME_COMPOSITE) {
        command.ground_effect_n = finite_or(lift.ratio * rotor_thrust(state) + lift.force_n, R(0.0));
    }
    return command;
}
