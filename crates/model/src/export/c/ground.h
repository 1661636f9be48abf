/* Input of the model. */
typedef struct {
    REAL thrust_n;             /* free-air thrust T, N */
    REAL throttle;             /* in [0, 1] */
    REAL height_m;             /* of the vehicle's reference point above the deck, m */
    REAL vehicle_velocity_mps; /* up, m/s */
    REAL deck_velocity_mps;    /* up, m/s */
} NAME_input;

/* Ground effect f = ratio T + force_n. A feed-forward solves T = (V - force_n) / (1 + ratio). */
typedef struct {
    REAL ratio;
    REAL force_n;
} NAME_lift;

/* State: force or ratio, and the last input with every value finite. */
typedef struct {
    REAL value;
    NAME_input input;
} NAME_state;

/* The state at rest under an input. */
void NAME_init(NAME_state *state, const NAME_input *input);

/* Advances the state over dt seconds under a constant input; returns the lift at their end. Heights
 * enter within the range of the data, lift and state stay within the range of ratios; values that
 * are not finite are replaced by the last ones that were. */
NAME_lift NAME_step(NAME_state *state, const NAME_input *input, REAL dt);
