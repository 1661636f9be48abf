/* No ground effect is fed forward. */
typedef struct {
    REAL ratio;
    REAL force_n;
} lift_of_air;

static void air_init(NAME_state *state, REAL thrust_n)
{
    (void)state;
    (void)thrust_n;
}

static lift_of_air air_step(NAME_state *state, REAL thrust_n, REAL dt)
{
    const lift_of_air none = {R(0.0), R(0.0)};
    (void)state;
    (void)thrust_n;
    (void)dt;
    return none;
}
