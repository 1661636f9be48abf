/* Ground effect f = ratio T + force_n. */
typedef @GROUND@lift lift_of_air;

static @GROUND@input air_input(const NAME_state *state, REAL thrust_n)
{
    const NAME_measurement *m = &state->measurement;
    @GROUND@input input;
    input.thrust_n = thrust_n;
    input.throttle = state->throttle;
    input.height_m = m->height_m;
    input.vehicle_velocity_mps = m->vehicle_velocity_mps;
    input.deck_velocity_mps = m->vehicle_velocity_mps - m->relative_velocity_mps;
    return input;
}

static void air_init(NAME_state *state, REAL thrust_n)
{
    const @GROUND@input input = air_input(state, thrust_n);
    @GROUND@init(&state->air, &input);
}

static lift_of_air air_step(NAME_state *state, REAL thrust_n, REAL dt)
{
    const @GROUND@input input = air_input(state, thrust_n);
    return @GROUND@step(&state->air, &input, dt);
}
