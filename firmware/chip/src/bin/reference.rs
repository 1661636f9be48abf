//! Replays a recording with the laws in C (`reference/reference.c`), counting their instructions.
//! Its results are near those of the library, which integrates exactly where this does not.
#![no_std]
#![no_main]

use core::hint::black_box;
use core::panic::PanicInfo;

use cortex_m_rt::entry;
use touchdown_chip::{ChipPort, fail, run};
use touchdown_flight::control::Law;
use touchdown_flight::deck::HarmonicFilter;
use touchdown_flight::ground_effect::{
    GroundEffect, GroundEffectInput, GroundEffectModel, Guarded, Polynomial,
};
use touchdown_flight::reference::Reference;
use touchdown_flight::thrust::{Library, ThrustModel};
use touchdown_flight::{Measurement, Real};
use touchdown_lander::models::FlightModels;
use touchdown_replay::{Callee, ModelCall, Port, Reader, VerticalRecording, Writer};

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    fail()
}

/// Eq. (8).
#[repr(C)]
struct CThrust([f32; 8]);

/// The lag.
#[repr(C)]
struct CLag {
    h: [f32; 4],
    inverse_length: [f32; 3],
    k: [f32; 2],
    inverse_tau: f32,
    height: [f32; 2],
    ratio: [f32; 2],
}

/// The vertical controller.
#[repr(C)]
struct CSettings {
    thrust: CThrust,
    lag: CLag,
    mass: f32,
    gravity: f32,
    k_p: f32,
    k_i: f32,
    gamma: f32,
    integral_max: f32,
    thrust_limits: [f32; 2],
    throttle_limits: [f32; 2],
    descent_rate: f32,
    start_height: f32,
    end_height: f32,
    deck: CDeck,
}

/// The deck filter; zeros without it.
#[repr(C)]
#[derive(Default)]
struct CDeck {
    w: f32,
    turn: [f32; 2],
    lead: [f32; 2],
    process_variance: f32,
    measurement_variance: f32,
    enable_after: f32,
}

#[repr(C)]
struct CState {
    root_thrust: f32,
    ratio: f32,
    integral: f32,
    throttle: f32,
    time: f32,
    deck: [f32; 2],
    covariance: [f32; 3],
}

#[repr(C)]
#[derive(Default)]
struct CCommand {
    thrust: f32,
    throttle: f32,
    ground_effect: f32,
}

// SAFETY: the functions of `reference/reference.c`, with the types of its header.
unsafe extern "C" {
    safe fn reference_polynomial_step(
        theta: &[f32; 11],
        force: &mut f32,
        s: f32,
        z: f32,
        vq: f32,
        vp: f32,
        dt: f32,
    ) -> f32;
    safe fn reference_lag_step(m: &CLag, ratio: &mut f32, z: f32, vp: f32, dt: f32) -> f32;
    safe fn reference_guarded_lag_step(m: &CLag, ratio: &mut f32, z: f32, vp: f32, dt: f32) -> f32;
    safe fn reference_thrust_step(m: &CThrust, x: &mut f32, s: f32, dt: f32) -> f32;
    safe fn reference_vertical_step(
        m: &CSettings,
        state: &mut CState,
        measurement: &[f32; 3],
        dt: f32,
        command: &mut CCommand,
    );
}

fn library(m: &Library<f32>) -> CThrust {
    CThrust([m.one, m.x, m.s, m.s2, m.x3, m.s3, m.exp_neg_x_s, m.sin_x_s])
}

fn lag(guarded: &Guarded<f32>) -> Option<CLag> {
    let GroundEffectModel::Lag(m) = guarded.model else {
        return None;
    };
    let limits = guarded.validity;
    Some(CLag {
        h: m.map.h,
        inverse_length: m.map.length_m.map(|length| 1.0 / length),
        k: m.k,
        inverse_tau: 1.0 / m.tau_s,
        height: [limits.height_min_m, limits.height_max_m],
        ratio: [limits.ratio_min, limits.ratio_max],
    })
}

/// A call of one model after another; results as those of the library.
fn models(call: ModelCall, port: &mut ChipPort) -> Option<()> {
    let models = FlightModels::<f32>::default();
    let ThrustModel::Library(eq_8) = models.thrust else {
        return None;
    };
    let (thrust, lag) = (library(&eq_8), lag(&models.dynamic)?);
    let theta = Polynomial::published().theta;
    let start = GroundEffectInput {
        height_m: 0.8,
        thrust_n: 13.4,
        throttle: 0.5,
        ..GroundEffectInput::default()
    };
    let mut state = match call {
        ModelCall::Polynomial => 0.0,
        ModelCall::Lag | ModelCall::GuardedLag => {
            models
                .dynamic
                .lift(&models.dynamic.rest(&start), &start)
                .ratio
        }
        ModelCall::ThrustLibrary => models.thrust.rest(0.5),
    };
    while let Some(dt) = port.number() {
        let [s, _, z, vq, vp] = port.numbers()?;
        let (theta, lag, thrust) = black_box((&theta, &lag, &thrust));
        port.begin();
        let result = match call {
            ModelCall::Polynomial => reference_polynomial_step(theta, &mut state, s, z, vq, vp, dt),
            ModelCall::Lag => reference_lag_step(lag, &mut state, z, vp, dt),
            ModelCall::GuardedLag => reference_guarded_lag_step(lag, &mut state, z, vp - vq, dt),
            ModelCall::ThrustLibrary => reference_thrust_step(thrust, &mut state, s, dt),
        };
        port.end();
        // Ratio and force, or the root of the thrust: as the library's.
        match call {
            ModelCall::Polynomial => {
                port.put(0.0);
                port.put(result);
            }
            ModelCall::Lag | ModelCall::GuardedLag => {
                port.put(result);
                port.put(0.0);
            }
            ModelCall::ThrustLibrary => port.put(result),
        }
    }
    Some(())
}

/// Steps of the vertical controller.
fn vertical(port: &mut ChipPort) -> Option<()> {
    let recording = VerticalRecording::read(port)?;
    let controller = recording.controller()?;
    let (ThrustModel::Library(eq_8), Law::Composite(law), Reference::Exponential(descent)) =
        (controller.thrust, controller.law, controller.reference)
    else {
        return None;
    };
    let deck = controller.deck.map_or(CDeck::default(), |filter| {
        let HarmonicFilter {
            angular_frequency: w,
            lead_s,
            ..
        } = filter;
        let turned = |t: f32| [Real::sin(w * t), Real::cos(w * t)];
        CDeck {
            w,
            turn: turned(0.01),
            lead: turned(lead_s),
            process_variance: filter.process_sd * filter.process_sd,
            measurement_variance: filter.measurement_sd * filter.measurement_sd,
            // Half a period earlier: a sum of periods is rounded.
            enable_after: filter.enable_after_s - 0.005,
        }
    });
    let limits = controller.limits;
    let settings = CSettings {
        thrust: library(&eq_8),
        lag: lag(&controller.ground_effect)?,
        mass: controller.mass_kg,
        gravity: controller.gravity_mps2,
        k_p: law.gains.k_p,
        k_i: law.gains.k_i,
        gamma: law.gains.gamma,
        integral_max: law.gains.integral_limit_n,
        thrust_limits: [limits.thrust_min_n, limits.thrust_max_n],
        throttle_limits: [limits.throttle_min, limits.throttle_max],
        descent_rate: descent.c_per_s,
        start_height: descent.start_height_m,
        end_height: descent.end_height_m,
        deck,
    };
    let start = Measurement {
        height_m: recording.start_height_m,
        ..Measurement::default()
    };
    let hover = controller.thrust.throttle_for(1.37 * 9.81);
    let initial = controller.initial(&start, hover);
    let sd = 0.3_f32;
    let sd_p = if settings.deck.w > 0.0 {
        sd / settings.deck.w
    } else {
        0.0
    };
    let mut state = CState {
        root_thrust: initial.vertical.thrust.x,
        ratio: initial.vertical.command.ground_effect_n / initial.vertical.thrust.thrust_n(),
        integral: 0.0,
        throttle: hover,
        time: 0.0,
        deck: [0.0; 2],
        covariance: [sd_p * sd_p, 0.0, sd * sd],
    };
    let mut command = CCommand::default();
    while let Some(dt) = port.number() {
        let [height, relative, vehicle, _] = port.numbers::<4>()?;
        let measurement = black_box([height, relative, vehicle]);
        port.begin();
        reference_vertical_step(&settings, &mut state, &measurement, dt, &mut command);
        port.end();
        port.put(command.thrust);
        port.put(command.throttle);
        port.put(command.ground_effect);
    }
    Some(())
}

#[entry]
fn main() -> ! {
    run(|port| {
        match port.word().and_then(Callee::of_word) {
            Some(Callee::Model(call)) => models(call, port),
            Some(Callee::Vertical) => vertical(port),
            _ => None,
        }
        .is_some()
    })
}
