#include "reference.h"

static inline float limited(float x, float low, float high)
{
    return (x < low) ? low : ((x > high) ? high : x);
}

/* exp(x) for |x| below 87: 2^k times a polynomial of the rest. */
static float exponential(float x)
{
    const int32_t k = (int32_t)(x * 1.44269504f + ((x < 0.0f) ? -0.5f : 0.5f));
    const float r = x - (float)k * 0.69314718f;
    const float y = 1.0f + r * (1.0f + r * (0.5f + r * (0.16666667f + r * (0.041666667f
        + r * 0.0083333333f))));
    const uint32_t bits = (uint32_t)(k + 127) << 23;
    float power;
    __builtin_memcpy(&power, &bits, sizeof power);
    return y * power;
}

/* sin(x) for some turns: the rest after half turns, by its series. */
static float sine_of(float x)
{
    const int32_t k = (int32_t)(x * 0.31830989f + ((x < 0.0f) ? -0.5f : 0.5f));
    const float r = x - (float)k * 3.14159265f;
    const float z = r * r;
    const float y = r * (1.0f + z * (-0.16666667f + z * (0.0083333333f + z * (-1.984127e-4f
        + z * 2.7557e-6f))));
    return ((k & 1) != 0) ? -y : y;
}

float reference_polynomial_step(const float c[11], float *force, float s, float z, float vq,
    float vp, float dt)
{
    *force += dt * (c[0] + c[1] * *force + s * (c[2] + c[6] * s) + z * (c[3] + c[8] * z)
        + vp * (c[4] + c[9] * vp + c[7] * vq) + vq * (c[5] + c[10] * vq));
    return *force;
}

static inline float psi(float z, float inverse_length)
{
    const float u = z * inverse_length;
    return 1.0f / (1.0f + u * u);
}

float reference_lag_step(const reference_lag *m, float *ratio, float z, float vp, float dt)
{
    const float psi3 = psi(z, m->inverse_length[2]);
    const float target = m->h[0] + m->h[1] * psi(z, m->inverse_length[0])
        + m->h[2] * psi(z, m->inverse_length[1]) + m->h[3] * psi3;
    *ratio += dt * m->inverse_tau * (target - *ratio);
    return *ratio + (m->k[0] + m->k[1] * psi3) * vp;
}

float reference_guarded_lag_step(const reference_lag *m, float *ratio, float z, float vp, float dt)
{
    const float height = limited(z, m->height_min, m->height_max);
    const float y = reference_lag_step(m, ratio, height, vp, dt);
    *ratio = limited(*ratio, m->ratio_min, m->ratio_max);
    return limited(y, m->ratio_min, m->ratio_max);
}

/* Eq. (8) as a cubic of throttle. */
static inline void cubic_of(const reference_thrust *m, float x, float p[2])
{
    p[0] = m->c[0] + x * (m->c[1] + m->c[4] * x * x);
    p[1] = m->c[2] + m->c[6] * exponential(-x) + m->c[7] * sine_of(x);
}

float reference_thrust_step(const reference_thrust *m, float *x, float s, float dt)
{
    float p[2];
    cubic_of(m, *x, p);
    *x = limited(*x + dt * (p[0] + s * (p[1] + s * (m->c[3] + s * m->c[5]))), 0.3f, 30.0f);
    return *x;
}

/* The throttle of a thrust: three steps of Newton's method from the last one. */
static float throttle_for(const reference_thrust *m, float thrust, float near)
{
    float p[2];
    float s = near;
    int32_t i;
    cubic_of(m, limited(__builtin_sqrtf(thrust), 0.3f, 30.0f), p);
    for (i = 0; i < 3; i++) {
        const float y = p[0] + s * (p[1] + s * (m->c[3] + s * m->c[5]));
        const float slope = p[1] + s * (2.0f * m->c[3] + s * 3.0f * m->c[5]);
        s -= y / slope;
    }
    return s;
}

/* Kalman filter of a harmonic heave; the acceleration ahead. */
static float deck_acceleration(const reference_settings *m, reference_state *state, float measured,
    float dt)
{
    const float w = m->w;
    const float s = m->sine / w;
    const float t = -m->sine * w;
    const float c = m->cosine;
    const float p = c * state->deck + s * state->deck_velocity;
    const float v = c * state->deck_velocity + t * state->deck;
    const float *k = state->covariance;
    const float a = c * k[0] + s * k[1];
    const float b = c * k[1] + s * k[2];
    const float d = t * k[0] + c * k[1];
    const float e = t * k[1] + c * k[2];
    const float q = m->process_variance * dt;
    const float pp = c * a + s * b + q / (w * w);
    const float pv = c * d + s * e;
    const float vv = t * d + c * e + q;
    const float share = 1.0f / (vv + m->measurement_variance);
    const float innovation = measured - v;
    state->deck = p + pv * share * innovation;
    state->deck_velocity = v + vv * share * innovation;
    state->covariance[0] = pp - pv * pv * share;
    state->covariance[1] = pv * m->measurement_variance * share;
    state->covariance[2] = vv * m->measurement_variance * share;
    if (state->time + dt < m->enable_after) {
        return 0.0f;
    }
    return -(w * w) * (m->lead_cosine * state->deck + m->lead_sine / w * state->deck_velocity);
}

void reference_vertical_step(const reference_settings *m, reference_state *state,
    const reference_measurement *in, float dt, reference_command *out)
{
    const float vp = in->vehicle_velocity - in->relative_velocity;
    const float x = reference_thrust_step(&m->thrust, &state->root_thrust, state->throttle, dt);
    const float ratio = reference_guarded_lag_step(&m->lag, &state->ratio, in->height,
        -in->relative_velocity, dt);
    const float deck = (m->w > 0.0f) ? deck_acceleration(m, state, vp, dt) : 0.0f;
    const float c = m->descent_rate;
    const float u = c * state->time;
    const float scale = (m->start_height - m->end_height) * exponential(-u);
    const float velocity = in->relative_velocity + scale * c * u;
    const float sliding = velocity + m->gamma * (in->height - (m->end_height + scale * (1.0f + u)));
    const float acceleration = deck + scale * c * c * (u - 1.0f) - m->gamma * velocity;
    const float base = m->mass * (acceleration + m->gravity) - m->k_p * sliding - state->integral;
    out->thrust = limited(base / (1.0f + ratio), m->thrust_min, m->thrust_max);
    out->throttle = limited(throttle_for(&m->thrust, out->thrust, state->throttle), m->throttle_min,
        m->throttle_max);
    out->ground_effect = ratio * x * x;
    state->integral = limited(state->integral + m->k_i * sliding * dt, -m->integral_max,
        m->integral_max);
    state->throttle = out->throttle;
    state->time += dt;
}
