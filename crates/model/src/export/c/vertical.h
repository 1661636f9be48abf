/* The control law. */
typedef enum {
    NAME_COMPOSITE, /* eq. (10) with the ground effect fed forward */
    NAME_IMBC,      /* internal model of a deck of known period, reconstructed */
    NAME_SSC        /* smooth sliding control, reconstructed */
} NAME_law;

/* Settings. NAME_defaults holds those of the export; change a copy of them. */
typedef struct {
    REAL mass_kg;
    REAL gravity_mps2;
    NAME_law law;
    REAL k_p;                    /* K_P, N s/m */
    REAL gamma;                  /* Gamma, 1/s */
    REAL k_i;                    /* composite: K_I, N/m */
    REAL integral_limit_n;       /* composite: greatest integral force, N */
    REAL imbc_angular_frequency; /* imbc: frequency of the deck, rad/s */
    REAL imbc_poles_per_s[3];    /* imbc: rates of the internal model's filter, 1/s */
    REAL ssc_rho_n;              /* ssc: greatest switching force, N */
    REAL ssc_phi_mps;            /* ssc: boundary layer, m/s */
    REAL ssc_filter_s;           /* ssc: time constant of the filter, s */
    REAL c_per_s;                /* rate C of the descent, eq. (13), 1/s */
    REAL start_height_m;         /* height at which the descent begins, m */
    REAL end_height_m;           /* height at which it ends, m */
    bool deck_filter;            /* whether the deck's acceleration is estimated and fed forward */
    REAL deck_angular_frequency; /* deck filter: frequency of the heave, rad/s */
    REAL deck_measurement_sd;    /* deck filter: standard deviation of the measured velocity, m/s */
    REAL deck_process_sd;        /* deck filter: process noise, m/s/sqrt(s) */
    REAL deck_enable_after_s;    /* deck filter: time before its output is used, s */
    REAL deck_lead_s;            /* deck filter: time by which the output is predicted ahead, s */
    REAL thrust_min_n;           /* limits of the command: thrust, N, and throttle */
    REAL thrust_max_n;
    REAL throttle_min;
    REAL throttle_max;
} NAME_settings;

/* What the sensors measured. z is up. */
typedef struct {
    REAL height_m;              /* of the vehicle's reference point above the deck, m */
    REAL relative_velocity_mps; /* of the vehicle, relative to the deck, m/s */
    REAL vehicle_velocity_mps;  /* of the vehicle, m/s */
} NAME_measurement;

/* What the controller asks of the rotors until the next step. */
typedef struct {
    REAL thrust_n;        /* free-air thrust, within the limits, N */
    REAL throttle;        /* in [0, 1] */
    REAL ground_effect_n; /* ground-effect force that the law counts on, N */
} NAME_command;

/* Exact rotation of the deck's displacement and velocity over a time. */
typedef struct {
    REAL angular_frequency;
    REAL time_s;
    REAL cosine;
    REAL sine_over_w;
    REAL w_sine;
} NAME_turn;

/* A sum that keeps its lost digits. */
typedef struct {
    REAL value;
    REAL carry;
} NAME_sum;

/* State of the deck filter. */
typedef struct {
    REAL displacement_m;
    REAL velocity_mps;
    REAL covariance[3];
    NAME_sum elapsed;
    NAME_turn turn;
    NAME_turn ahead;
} NAME_deck;

/* State of the controller. */
typedef struct {
    NAME_sum time;
    REAL integral_n; /* composite */
    REAL xi[3];      /* imbc */
    REAL filtered_n; /* ssc */
    REAL thrust_n;   /* the last command */
    REAL throttle;
    NAME_measurement measurement; /* the last one, every value finite */
    NAME_deck deck;
    @THRUST@state rotors;
@GROUND_STATE@} NAME_state;

/* Settings of the export. */
extern const NAME_settings NAME_defaults;

/* Whether every setting can be used. */
bool NAME_settings_are_valid(const NAME_settings *settings);

/* The state at the start of the descent: rotors and air at rest at throttle, which is being sent. */
void NAME_init(NAME_state *state, const NAME_settings *settings, const NAME_measurement *measurement,
    REAL throttle);

/* One control period: takes the measurement at its beginning, returns the command for its dt
 * seconds. Values that are not finite are replaced by the last ones that were. The command is
 * finite and within the limits, if the settings are valid. */
NAME_command NAME_step(NAME_state *state, const NAME_settings *settings,
    const NAME_measurement *measurement, REAL dt);
