/* Touchdown: the vertical controller and the landing computer, in single precision.
 *
 * Written by cbindgen from crates/ffi/src, not by hand:
 * TOUCHDOWN_WRITE_HEADER=1 cargo test -p touchdown-ffi --test header
 *
 * The caller gives the memory: nothing allocates. z is up, SI units, throttle in [0, 1]. Pointers must point to
 * memory of their type that nothing else uses during a call. Every function may be called from any thread, but two
 * calls at once must not use the same handle.
 *
 * The functions of the simulator exist where TOUCHDOWN_WORLD is defined and the library was built with its feature
 * `world`.
 */

#ifndef TOUCHDOWN_H
#define TOUCHDOWN_H

#include <stddef.h>
#include <stdint.h>

// Size of the memory of a `td_computer` on every target, bytes; `td_computer_size` returns that
// of this one, which is less.
#define TD_COMPUTER_SIZE 24576

// Alignment of that memory, bytes.
#define TD_COMPUTER_ALIGN 8

// Most readings of a step. 100 Hz and sensors of at most 50 Hz bring a handful, also after a gap.
#define TD_READINGS_MAX 16

// Size of the name of a setting, with its final zero.
#define TD_SETTING_NAME_SIZE 64

// Size of `expected` of a setting, with its final zero.
#define TD_SETTING_EXPECTED_SIZE 96

// Size of the memory of a `td_vertical` on every target, bytes; `td_vertical_size` returns that
// of this one, which is less.
#define TD_VERTICAL_SIZE 512

// Alignment of that memory, bytes.
#define TD_VERTICAL_ALIGN 8

// What a function returns. Beyond `TD_ERROR_NONE` and `TD_ERROR_SENSOR_NOT_FINITE` nothing was
// written but the refused setting.
enum td_error
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // No error.
  TD_ERROR_NONE = 0,
  // A value of the sensors is not finite. The step was made without it; its output holds.
  TD_ERROR_SENSOR_NOT_FINITE = 1,
  // A pointer is null.
  TD_ERROR_NULL_POINTER = 2,
  // A pointer is not aligned for its type.
  TD_ERROR_MISALIGNED = 3,
  // The memory is smaller than the size that is required.
  TD_ERROR_TOO_SMALL = 4,
  // The memory behind a handle has not been initialised.
  TD_ERROR_NOT_INITIALIZED = 5,
  // A setting is not usable; `td_setting` has its field and what is expected there.
  TD_ERROR_SETTING = 6,
  // The time step is not a finite number above 0.
  TD_ERROR_TIME_STEP = 7,
  // A number is none of its enumeration's constants. In settings, `td_setting` has its field.
  TD_ERROR_UNKNOWN_VALUE = 8,
  // More than `TD_READINGS_MAX` readings in a step.
  TD_ERROR_TOO_MANY_READINGS = 9,
  // The simulator refuses the scenario.
  TD_ERROR_WORLD = 10,
  // The function that flies in the simulator returned an error.
  TD_ERROR_PILOT = 11,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum td_error td_error;
#else
typedef uint32_t td_error;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// A method of landing. The last two need an inertial unit: the landing computer alone has them.
enum td_method
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // Feedback without a model of the ground effect.
  TD_METHOD_FEEDBACK = 0,
  // The empirical law of height is fed forward.
  TD_METHOD_EMPIRICAL = 1,
  // The identified dynamic model is fed forward.
  TD_METHOD_DYNAMIC = 2,
  // Internal-model control, for a deck of known period.
  TD_METHOD_IMBC = 3,
  // Smooth sliding control.
  TD_METHOD_SSC = 4,
  // A disturbance observer in place of a model.
  TD_METHOD_OBSERVER = 5,
  // The dynamic model and a disturbance observer.
  TD_METHOD_DYNAMIC_OBSERVER = 6,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum td_method td_method;
#else
typedef uint32_t td_method;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Form of a thrust model: what its coefficients are, in the order of a card.
enum td_thrust_form
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // `first-order`, eq. (7): c0, c1, time constant in s.
  TD_THRUST_FORM_FIRST_ORDER = 0,
  // `library`, eq. (8): those of 1, x, s, s^2, x^3, s^3, exp(-x) s, sin(x) s.
  TD_THRUST_FORM_LIBRARY = 1,
  // A cubic of throttle with a lag: four coefficients, time constant in s.
  TD_THRUST_FORM_STATIC = 2,
  // A cubic of lagged throttle for the thrust: four coefficients, time constant in s.
  TD_THRUST_FORM_LAGGED_THROTTLE = 3,
  // As library, then the root of the number of rotors over that of the card.
  TD_THRUST_FORM_LIBRARY_OF_ROTORS = 4,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum td_thrust_form td_thrust_form;
#else
typedef uint32_t td_thrust_form;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Form of a ground-effect model: what its coefficients are, in the order of a card.
enum td_ground_effect_form
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // No ground effect.
  TD_GROUND_EFFECT_FORM_NONE = 0,
  // `empirical`, eq. (2): mu, rotor radius in m, height of the rotors above the reference point in m.
  TD_GROUND_EFFECT_FORM_EMPIRICAL = 1,
  // A static map of height: h0 to h3, three lengths in m.
  TD_GROUND_EFFECT_FORM_STATIC_MAP = 2,
  // `polynomial`, eq. (9): eleven coefficients.
  TD_GROUND_EFFECT_FORM_POLYNOMIAL = 3,
  // The derivative form of the ratio: nine coefficients, three lengths in m.
  TD_GROUND_EFFECT_FORM_RATIO = 4,
  // `lag`: h0 to h3, three lengths in m, k0, k1, time constant in s.
  TD_GROUND_EFFECT_FORM_LAG = 5,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum td_ground_effect_form td_ground_effect_form;
#else
typedef uint32_t td_ground_effect_form;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// What a model returns outside of its limits of height.
enum td_outside
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // Its value at the limit.
  TD_OUTSIDE_CLAMP = 0,
  // Less and less, down to zero.
  TD_OUTSIDE_FADE = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum td_outside td_outside;
#else
typedef uint32_t td_outside;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// The velocity of the deck that a model is given.
enum td_velocity_input
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // That of the deck in the world.
  TD_VELOCITY_INPUT_DECK = 0,
  // That of the deck relative to the vehicle.
  TD_VELOCITY_INPUT_NEGATIVE_RELATIVE = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum td_velocity_input td_velocity_input;
#else
typedef uint32_t td_velocity_input;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Which sensor a reading is of.
enum td_reading_kind
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // Range finder.
  TD_READING_KIND_RANGE = 0,
  // Camera that sees the tag on the deck.
  TD_READING_KIND_TAG = 1,
  // Satellite navigation.
  TD_READING_KIND_GNSS = 2,
  // Barometer.
  TD_READING_KIND_BAROMETER = 3,
  // Broadcast of the deck.
  TD_READING_KIND_BEACON = 4,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum td_reading_kind td_reading_kind;
#else
typedef uint32_t td_reading_kind;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Request of the operator; it holds as long as it is set.
enum td_request
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // Land.
  TD_REQUEST_NONE = 0,
  // Do not land: climb away and hold.
  TD_REQUEST_ABORT = 1,
  // Start again after a landing or after giving up.
  TD_REQUEST_RESTART = 2,
  // Stop the rotors now, wherever the vehicle is.
  TD_REQUEST_DISARM = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum td_request td_request;
#else
typedef uint32_t td_request;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Phase of a landing.
enum td_phase
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // Flying to the position above the pad.
  TD_PHASE_APPROACH = 0,
  // Hovering above the pad until the vehicle is ready.
  TD_PHASE_HOLD = 1,
  // Ready; waiting for a good moment.
  TD_PHASE_WAIT = 2,
  // Descending, ready to abort.
  TD_PHASE_DESCEND = 3,
  // Too low to abort for a lost tag.
  TD_PHASE_COMMIT = 4,
  // Probably on the deck; the thrust decreases.
  TD_PHASE_TOUCHDOWN = 5,
  // Rotors off.
  TD_PHASE_DISARMED = 6,
  // Climbing away.
  TD_PHASE_GO_AROUND = 7,
  // The landing is given up; the vehicle holds its position.
  TD_PHASE_GIVEN_UP = 8,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum td_phase td_phase;
#else
typedef uint32_t td_phase;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Why a landing was interrupted.
enum td_reason
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // It was not.
  TD_REASON_NONE = 0,
  // The operator's request.
  TD_REASON_OPERATOR = 1,
  // A number is not finite.
  TD_REASON_NOT_FINITE = 2,
  // The estimator has diverged.
  TD_REASON_DIVERGED = 3,
  // The inertial unit's last sample is too old.
  TD_REASON_IMU_STALE = 4,
  // The range finder's last reading is too old.
  TD_REASON_RANGE_STALE = 5,
  // The last detection of the tag is too old.
  TD_REASON_TAG_LOST = 6,
  // Tilted too far.
  TD_REASON_TILT = 7,
  // Too far from the axis above the pad.
  TD_REASON_LATERAL_ERROR = 8,
  // The closing speed to the deck is too high.
  TD_REASON_CLOSING_SPEED = 9,
  // The demand exceeds what the rotors give.
  TD_REASON_SATURATED = 10,
  // The deck moves or tilts too much, or its motion is not known.
  TD_REASON_DECK = 11,
  // The wind pushes harder than friction holds on the deck.
  TD_REASON_WIND = 12,
  // The battery is low.
  TD_REASON_BATTERY_LOW = 13,
  // Not at the hold height.
  TD_REASON_HEIGHT = 14,
  // Moving too fast relative to the deck to begin a descent.
  TD_REASON_UNSTEADY = 15,
  // A time limit is exceeded.
  TD_REASON_LATE = 16,
  // The thrust was reduced, but nothing carries the vehicle.
  TD_REASON_NOT_SUPPORTED = 17,
  // The vehicle left the deck again.
  TD_REASON_BOUNCE = 18,
  // A reason that this header does not know.
  TD_REASON_OTHER = 19,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum td_reason td_reason;
#else
typedef uint32_t td_reason;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

#if defined(TOUCHDOWN_WORLD)
// How a landing ended.
enum td_outcome
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
#if defined(TOUCHDOWN_WORLD)
  // On the deck.
  TD_OUTCOME_LANDED = 0,
#endif
#if defined(TOUCHDOWN_WORLD)
  // Hit something, hit the deck too hard, or tipped over.
  TD_OUTCOME_CRASHED = 1,
#endif
#if defined(TOUCHDOWN_WORLD)
  // Not down by the end of the time.
  TD_OUTCOME_TIMED_OUT = 2,
#endif
#if defined(TOUCHDOWN_WORLD)
  // Flew away, or its state was no number any more.
  TD_OUTCOME_DIVERGED = 3,
#endif
#if defined(TOUCHDOWN_WORLD)
  // Gave the landing up and holds.
  TD_OUTCOME_GIVEN_UP = 4,
#endif
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum td_outcome td_outcome;
#else
typedef uint32_t td_outcome;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus
#endif

// A landing computer and its state, in the caller's memory.
typedef struct td_computer td_computer;

// A vertical controller and its state, in the caller's memory.
typedef struct td_vertical td_vertical;

#if defined(TOUCHDOWN_WORLD)
// A case of the simulator in six degrees of freedom.
typedef struct td_world td_world;
#endif

// The vehicle.
typedef struct td_vehicle {
  // Mass, kg.
  float mass_kg;
  // Acceleration of gravity, m/s^2.
  float gravity_mps2;
  // Radius of a rotor, m.
  float rotor_radius_m;
  // Greatest thrust of all rotors in free air, N.
  float greatest_thrust_n;
} td_vehicle;

// Throttle to free-air thrust.
typedef struct td_thrust_model {
  // A `td_thrust_form`.
  uint32_t form;
  // Coefficients of the form; the rest is not used.
  float coefficients[9];
} td_thrust_model;

// Ground effect within its limits of validity.
typedef struct td_ground_effect {
  // A `td_ground_effect_form`.
  uint32_t form;
  // Coefficients of the form; the rest is not used.
  float coefficients[12];
  // Least height above the deck, m.
  float height_min_m;
  // Greatest height above the deck, m.
  float height_max_m;
  // Least force over thrust.
  float ratio_min;
  // Greatest force over thrust.
  float ratio_max;
  // A `td_outside`.
  uint32_t outside;
  // A `td_velocity_input`.
  uint32_t velocity;
} td_ground_effect;

// The models that a controller flies with.
typedef struct td_models {
  // Throttle to thrust.
  struct td_thrust_model thrust;
  // Coefficient of eq. (2), for `TD_METHOD_EMPIRICAL`. That method has limits of its own: heights
  // of 0.1 to 0.85 m, force over thrust of at most 0.6, and above the force stays. For other
  // limits or a fade, state eq. (2) as `ground_effect` and fly `TD_METHOD_DYNAMIC`.
  float empirical_mu;
  // Ground effect, for `TD_METHOD_DYNAMIC` and `TD_METHOD_DYNAMIC_OBSERVER`.
  struct td_ground_effect ground_effect;
} td_models;

// What the estimators know of the sensors. Body axes: x forward, y left, z up.
typedef struct td_sensors {
  // Latency of specific force and attitude, s.
  float imu_latency_s;
  // Position of the range finder, m.
  float range_position_m[3];
  // Resolution of the range finder, m; 0 for none.
  float range_quantum_m;
  // Smallest distance of the range finder, m.
  float range_min_m;
  // Greatest distance of the range finder, m.
  float range_max_m;
  // Scale of the range finder's half-normal jitter, s.
  float range_jitter_s;
  // Position of the camera, m.
  float camera_position_m[3];
  // Rotation of the camera about the body's z axis, rad.
  float camera_turn_rad;
  // Scale of the camera's half-normal jitter, s.
  float camera_jitter_s;
} td_sensors;

// Settings of the landing computer. All others have the defaults that campaigns fly, which are
// tuned for the paper's quadrotor.
typedef struct td_computer_settings {
  // The vehicle.
  struct td_vehicle vehicle;
  // Its models.
  struct td_models models;
  // Its sensors.
  struct td_sensors sensors;
  // A `td_method`.
  uint32_t method;
  // Time between two steps, s.
  float period_s;
  // Delay of a command to the attitude control, s.
  float command_delay_s;
  // Height above the deck at which the landing begins, m.
  float start_height_m;
  // 1 if the deck may be under way, 0 if not.
  uint32_t deck_under_way;
  // 1 if the vehicle seeks a deck that is not below, 0 if it hovers then.
  uint32_t seeks_deck;
} td_computer_settings;

// The first setting that is not usable; both texts are empty without such an error.
typedef struct td_setting {
  // Its field, such as `vehicle.mass_kg`, or the argument of the function. Ends with a zero.
  char name[TD_SETTING_NAME_SIZE];
  // What is expected there. Ends with a zero.
  char expected[TD_SETTING_EXPECTED_SIZE];
  // The number that was found there, or follows from it.
  double found;
} td_setting;

// Distance along the range finder's beam.
typedef struct td_range {
  // Slant range, m.
  float distance_m;
} td_range;

// Position of the deck's reference point by the camera.
typedef struct td_tag {
  // Position in camera axes, m.
  float position_m[3];
  // Its covariance in camera axes, row by row, m^2.
  float covariance_m2[9];
} td_tag;

// Velocity of the vehicle by satellite navigation.
typedef struct td_gnss {
  // Velocity, world axes, m/s.
  float velocity_mps[3];
} td_gnss;

// Altitude by air pressure.
typedef struct td_barometer {
  // Altitude above an arbitrary zero, m.
  float altitude_m;
} td_barometer;

// Place and velocity that the deck broadcasts, less the vehicle's own place.
typedef struct td_beacon {
  // Vehicle relative to the deck, world axes, m.
  float position_m[3];
  // Velocity of the deck, world axes, m/s; z is not used.
  float deck_velocity_mps[3];
} td_beacon;

// The reading of one sensor: the member of its kind.
typedef union td_reading_data {
  // Of `TD_READING_KIND_RANGE`.
  struct td_range range;
  // Of `TD_READING_KIND_TAG`.
  struct td_tag tag;
  // Of `TD_READING_KIND_GNSS`.
  struct td_gnss gnss;
  // Of `TD_READING_KIND_BAROMETER`.
  struct td_barometer barometer;
  // Of `TD_READING_KIND_BEACON`.
  struct td_beacon beacon;
} td_reading_data;

// A reading.
typedef struct td_reading {
  // A `td_reading_kind`.
  uint32_t kind;
  // Age of the reading at the end of the step, s.
  float age_s;
  // The reading.
  union td_reading_data data;
} td_reading;

// What has been sensed since the last step. World and body axes: x forward, y left, z up.
typedef struct td_sensed {
  // Specific force, body axes, m/s^2: +9.8 along z at rest.
  float specific_force_mps2[3];
  // Rotation from body to world axes, quaternion w, x, y, z of any length.
  float attitude[4];
  // The readings that have arrived; may be null without any.
  const struct td_reading *readings;
  // How many readings.
  size_t readings_count;
  // The deck's normal by the camera, camera axes.
  float deck_normal[3];
  // Age of that normal, s; below 0 for none.
  float deck_normal_age_s;
  // Remaining energy of the battery, in [0, 1].
  float battery_share;
  // Contact switch in the legs: 1 closed, 0 open, -1 for none.
  int32_t contact;
  // A `td_request`.
  uint32_t request;
} td_sensed;

// Output of a step of the landing computer.
typedef struct td_computer_output {
  // 1: fly thrust and attitude; 0: stop the rotors.
  uint32_t rotors;
  // Free-air thrust along the rotors' axis, N.
  float thrust_n;
  // Throttle that gives this thrust in the steady state.
  float throttle;
  // Commanded rotation from body to world axes, quaternion w, x, y, z.
  float attitude[4];
  // A `td_phase`.
  uint32_t phase;
  // A `td_reason`: why the landing was interrupted.
  uint32_t reason;
  // A `td_reason`: what keeps the vehicle in Approach or Hold.
  uint32_t waits_for;
  // Number of go-arounds, without those that the operator ordered.
  uint32_t go_arounds;
  // Vehicle relative to the deck, m; z is the height.
  float position_m[3];
  // Its standard deviation, m.
  float position_sd_m[3];
  // Velocity of the vehicle, m/s.
  float velocity_mps[3];
  // Velocity of the deck, m/s.
  float deck_velocity_mps[3];
  // Estimated latency of the readings beyond their stamped ages, s.
  float latency_s;
  // Force that no model explains, N.
  float disturbance_n[3];
} td_computer_output;

// Settings of the vertical controller.
typedef struct td_vertical_settings {
  // The vehicle.
  struct td_vehicle vehicle;
  // Its models.
  struct td_models models;
  // A `td_method` up to `TD_METHOD_SSC`.
  uint32_t method;
  // Height above the deck at which the descent begins, m.
  float start_height_m;
  // Height above the deck at which it ends, m.
  float end_height_m;
  // Rate C of the descent, eq. (13), 1/s.
  float descent_rate_per_s;
  // Frequency of the deck's heave, Hz; 0 for a deck at rest.
  float deck_frequency_hz;
} td_vertical_settings;

// What the sensors measured. z is up.
typedef struct td_measurement {
  // Height of the reference point above the deck, m.
  float height_m;
  // Velocity relative to the deck, m/s.
  float relative_velocity_mps;
  // Velocity of the vehicle in the world, m/s.
  float vehicle_velocity_mps;
  // Acceleration of the vehicle, gravity removed, m/s^2.
  float acceleration_mps2;
} td_measurement;

// What the controller asks of the rotors until the next step.
typedef struct td_command {
  // Free-air thrust, N.
  float thrust_n;
  // Throttle in [0, 1].
  float throttle;
  // Ground-effect force that the law counts on, N.
  float ground_effect_n;
} td_command;

#if defined(TOUCHDOWN_WORLD)
// A vertical landing: the paper's quadrotor in turbulent air, with noisy sensors.
typedef struct td_vertical_world {
  // Height above the deck at the start, m.
  double start_height_m;
  // Amplitude of the deck's heave, m.
  double deck_amplitude_m;
  // Frequency of the deck's heave, Hz; 0 for a deck at rest.
  double deck_frequency_hz;
  // Index of the trial; trials differ in vehicle, phase of the deck and noise.
  uint64_t trial;
  // Seed of all random numbers.
  uint64_t seed;
} td_vertical_world;
#endif

#if defined(TOUCHDOWN_WORLD)
// Flies a control period of 10 ms: gives the throttle to hold. `user` is what the caller handed
// over.
typedef float (*td_vertical_pilot)(void *user, const struct td_measurement *measurement);
#endif

#if defined(TOUCHDOWN_WORLD)
// A landing, by the true state.
typedef struct td_landing {
  // A `td_outcome`.
  uint32_t outcome;
  // T_L: time from the start of the descent to the touch, s; NaN without one.
  double landing_time_s;
  // V_L: speed relative to the deck at the touch, m/s; NaN without one.
  double touch_speed_mps;
} td_landing;
#endif

#if defined(TOUCHDOWN_WORLD)
// Flies a step of `dt_s` seconds: fills in the output, as `td_computer_step` does, and returns its
// code. A code other than `TD_ERROR_NONE` and `TD_ERROR_SENSOR_NOT_FINITE` stops the rotors.
typedef uint32_t (*td_space_pilot)(void *user,
                                   const struct td_sensed *sensed,
                                   float dt_s,
                                   struct td_computer_output *output);
#endif

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Size of a `td_computer` on this target, bytes.
size_t td_computer_size(void);

// Alignment of a `td_computer` on this target, bytes.
size_t td_computer_align(void);

// Makes a landing computer in `memory` of `size` bytes, and its handle, in the air. `throttle`
// is what is being sent. `setting` may be null.
td_error td_computer_init(void *memory,
                          size_t size,
                          const struct td_computer_settings *settings,
                          float throttle,
                          struct td_computer **computer,
                          struct td_setting *setting);

// One step, `dt_s` seconds after the last: readings in, thrust and attitude out.
td_error td_computer_step(struct td_computer *computer,
                          const struct td_sensed *sensed,
                          float dt_s,
                          struct td_computer_output *output);

// Starts the landing again with the present estimates. Called before every step, it keeps the
// integrals at zero while somebody else flies.
td_error td_computer_restart(struct td_computer *computer);

// Settings of the paper's quadrotor with the simulator's sensors, at 100 Hz.
td_error td_computer_settings_default(struct td_computer_settings *settings);

// The text of an error code, also of an unknown one. Never null; it is static.
const char *td_error_text(uint32_t code);

// The models that fly by default: those of the paper's quadrotor at half of the paper's ground
// effect.
td_error td_models_default(struct td_models *models);

// The models at the paper's ground effect.
td_error td_models_paper(struct td_models *models);

// The throttle in [0, 1] that carries the vehicle in free air. `setting` may be null.
td_error td_hover_throttle(const struct td_vehicle *vehicle,
                           const struct td_models *models,
                           float *throttle,
                           struct td_setting *setting);

// Size of a `td_vertical` on this target, bytes.
size_t td_vertical_size(void);

// Alignment of a `td_vertical` on this target, bytes.
size_t td_vertical_align(void);

// Settings of the paper's quadrotor, from 0.8 m onto a deck at rest.
td_error td_vertical_settings_default(struct td_vertical_settings *settings);

// Makes a controller in `memory` of `size` bytes, and its handle. `start` is the measurement,
// `throttle` what is being sent when the descent begins. `setting` may be null.
td_error td_vertical_init(void *memory,
                          size_t size,
                          const struct td_vertical_settings *settings,
                          const struct td_measurement *start,
                          float throttle,
                          struct td_vertical **vertical,
                          struct td_setting *setting);

// One control period of `dt_s` seconds: takes the measurement at its beginning, gives the command
// to hold until its end. The command is always finite and within the limits.
td_error td_vertical_step(struct td_vertical *vertical,
                          const struct td_measurement *measurement,
                          float dt_s,
                          struct td_command *command);

#if defined(TOUCHDOWN_WORLD)
// Flies a vertical landing.
td_error td_world_land_vertical(const struct td_vertical_world *world,
                                td_vertical_pilot pilot,
                                void *user,
                                struct td_landing *landing);
#endif

#if defined(TOUCHDOWN_WORLD)
// Makes the world of a case by its name, such as "paper" (`touchdown land --space --help` lists
// them). `td_world_free` ends it.
td_error td_world_new(const char *name, struct td_world **world);
#endif

#if defined(TOUCHDOWN_WORLD)
// Ends a world; null does nothing.
void td_world_free(struct td_world *world);
#endif

#if defined(TOUCHDOWN_WORLD)
// Height above the deck at which landings begin, m; NaN for a null pointer.
float td_world_start_height_m(const struct td_world *world);
#endif

#if defined(TOUCHDOWN_WORLD)
// Throttle at which landings begin; NaN for a null pointer.
float td_world_start_throttle(const struct td_world *world);
#endif

#if defined(TOUCHDOWN_WORLD)
// Flies a landing of a trial and a seed. Returns `TD_ERROR_PILOT` if the pilot's code stopped the
// rotors, and `TD_ERROR_UNKNOWN_VALUE` if its phase did; the landing is written also then.
td_error td_world_land(const struct td_world *world,
                       uint64_t trial,
                       uint64_t seed,
                       td_space_pilot pilot,
                       void *user,
                       struct td_landing *landing);
#endif

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* TOUCHDOWN_H */
