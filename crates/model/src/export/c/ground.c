/* The input with every value that is not finite taken from the last one. */
static NAME_input input_or_last(const NAME_input *input, const NAME_input *last)
{
    NAME_input result;
    result.thrust_n = finite_or(input->thrust_n, last->thrust_n);
    result.throttle = finite_or(input->throttle, last->throttle);
    result.height_m = finite_or(input->height_m, last->height_m);
    result.vehicle_velocity_mps = finite_or(input->vehicle_velocity_mps, last->vehicle_velocity_mps);
    result.deck_velocity_mps = finite_or(input->deck_velocity_mps, last->deck_velocity_mps);
    return result;
}

/* What the model is given: heights within the box of the data. */
static NAME_input input_within(const NAME_input *input)
{
    NAME_input result = *input;
    result.thrust_n = max_of(input->thrust_n, R(0.0));
    result.throttle = clamp_of(input->throttle, R(0.0), R(1.0));
    result.height_m = clamp_of(input->height_m, HEIGHT_MIN_M, HEIGHT_MAX_M);
@VELOCITY@    return result;
}

void NAME_init(NAME_state *state, const NAME_input *input)
{
    const NAME_input unknown = {R(0.0), R(0.0), HEIGHT_MAX_M, R(0.0), R(0.0)};
    NAME_input inner;
    state->input = input_or_last(input, &unknown);
    inner = input_within(&state->input);
    state->value = family_limit(family_rest(&inner), inner.thrust_n);
}

NAME_lift NAME_step(NAME_state *state, const NAME_input *input, REAL dt)
{
    NAME_input inner;
    NAME_lift lift;
    REAL remaining = R(1.0);
    state->input = input_or_last(input, &state->input);
    inner = input_within(&state->input);
    state->value = family_limit(family_advance(state->value, &inner, usable_dt(dt)), inner.thrust_n);
    lift = family_lift(state->value, &inner);
@OUTSIDE@    lift.ratio = finite_or(remaining * clamp_of(lift.ratio, RATIO_MIN, RATIO_MAX), R(0.0));
    lift.force_n = finite_or(remaining * clamp_of(lift.force_n, RATIO_MIN * inner.thrust_n,
        RATIO_MAX * inner.thrust_n), R(0.0));
    return lift;
}
