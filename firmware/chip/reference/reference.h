/* The vertical control laws as C is written for one vehicle by hand: floats, explicit Euler, no
 * guards beyond limits. What firmware/measure counts beside the library. */
#ifndef REFERENCE_H
#define REFERENCE_H

#include <stdint.h>

/* Eq. (8), in the order of the library's terms. */
typedef struct {
    float c[8];
} reference_thrust;

/* The lag: h0 to h3, 1 / L1 to 1 / L3, k0, k1, 1 / tau; limits of height and ratio. */
typedef struct {
    float h[4];
    float inverse_length[3];
    float k[2];
    float inverse_tau;
    float height_min;
    float height_max;
    float ratio_min;
    float ratio_max;
} reference_lag;

/* The vertical controller: eq. (10), eq. (13), a deck of known frequency. */
typedef struct {
    reference_thrust thrust;
    reference_lag lag;
    float mass;
    float gravity;
    float k_p;
    float k_i;
    float gamma;
    float integral_max;
    float thrust_min;
    float thrust_max;
    float throttle_min;
    float throttle_max;
    float descent_rate;
    float start_height;
    float end_height;
    /* Deck filter: w = 0 without it; sines and cosines of w dt and w lead; variances. */
    float w;
    float sine;
    float cosine;
    float lead_sine;
    float lead_cosine;
    float process_variance;
    float measurement_variance;
    float enable_after;
} reference_settings;

typedef struct {
    float root_thrust;
    float ratio;
    float integral;
    float throttle;
    float time;
    float deck;
    float deck_velocity;
    float covariance[3];
} reference_state;

typedef struct {
    float height;
    float relative_velocity;
    float vehicle_velocity;
} reference_measurement;

typedef struct {
    float thrust;
    float throttle;
    float ground_effect;
} reference_command;

/* Each advances its state by dt; the lags return f / T, the polynomial f, the thrust sqrt(T). */
float reference_polynomial_step(const float theta[11], float *force, float s, float z, float vq,
    float vp, float dt);
float reference_lag_step(const reference_lag *m, float *ratio, float z, float vp, float dt);
float reference_guarded_lag_step(const reference_lag *m, float *ratio, float z, float vp, float dt);
float reference_thrust_step(const reference_thrust *m, float *x, float s, float dt);
void reference_vertical_step(const reference_settings *m, reference_state *state,
    const reference_measurement *in, float dt, reference_command *out);

#endif
