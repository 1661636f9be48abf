/* State: the root of the free-air thrust, sqrt(N). */
typedef struct {
    REAL root_thrust;
} NAME_state;

/* The state at rest for a throttle in [0, 1]. */
void NAME_init(NAME_state *state, REAL throttle);

/* Advances the state over dt seconds at constant throttle; returns the free-air thrust, N. The
 * throttle is limited to [0, 1]. A throttle or dt that is not finite, or a dt that is not
 * positive, leaves the state as it is. */
REAL NAME_step(NAME_state *state, REAL throttle, REAL dt);

/* The least throttle in [0, 1] whose thrust at rest is thrust_n; where no throttle gives so much,
 * the one that gives most. The model knows thrusts from 0.09 to 900 N: less counts as 0.09 N, and
 * so does one that is not a number. */
REAL NAME_throttle_for(REAL thrust_n);

/* The same, found the sooner the nearer it is to near. */
REAL NAME_throttle_near(REAL thrust_n, REAL near);
