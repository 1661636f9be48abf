//! The vertical controller as a task of RTIC at 100 Hz, down to the ground.
//!
//! SysTick starts the task. Sensors and rotors are a stub: a point mass over flat ground with the
//! ground effect of eq. (2), whose rotors follow the throttle at once. QEMU ends when it has landed.
#![no_std]
#![no_main]

use core::panic::PanicInfo;

use cortex_m_rt as _;
use touchdown_chip::fail;

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    fail()
}

/// What RTIC asks of a chip's description. The task needs no interrupt of one.
mod device {
    /// Bits of a priority, of QEMU's boards at least.
    pub(crate) const NVIC_PRIO_BITS: u8 = 3;
}

/// The stub of sensors and rotors.
mod stub {
    use touchdown_flight::Measurement;
    use touchdown_flight::ground_effect::{Empirical, GroundEffect, GroundEffectInput};
    use touchdown_flight::thrust::{ThrustModel, ThrustState};

    const MASS_KG: f32 = 1.37;
    const GRAVITY_MPS2: f32 = 9.81;
    /// Height of the reference point with the legs on the ground, m.
    const STANDING_M: f32 = 0.1;
    /// The paper's quadrotor; the coefficient is that which its rig shows.
    const AIR: Empirical<f32> = Empirical {
        mu: 1.96,
        rotor_radius_m: 0.12,
        rotor_offset_m: 0.0,
    };

    /// A vehicle over flat ground.
    pub(crate) struct Vehicle {
        pub(crate) height_m: f32,
        pub(crate) velocity_mps: f32,
        acceleration_mps2: f32,
    }

    impl Vehicle {
        pub(crate) const fn hovering(height_m: f32) -> Self {
            Self {
                height_m,
                velocity_mps: 0.0,
                acceleration_mps2: 0.0,
            }
        }

        pub(crate) fn measure(&self) -> Measurement<f32> {
            Measurement {
                height_m: self.height_m,
                relative_velocity_mps: self.velocity_mps,
                vehicle_velocity_mps: self.velocity_mps,
                acceleration_mps2: self.acceleration_mps2,
            }
        }

        /// Flies on for `dt` seconds.
        pub(crate) fn fly(&mut self, rotors: &ThrustModel<f32>, throttle: f32, dt: f32) {
            let rest = ThrustState {
                x: rotors.rest(throttle),
            };
            let input = GroundEffectInput {
                height_m: self.height_m,
                ..GroundEffectInput::default()
            };
            let lift = 1.0 + AIR.lift(&(), &input).ratio;
            self.acceleration_mps2 = rest.thrust_n() * lift / MASS_KG - GRAVITY_MPS2;
            self.velocity_mps += self.acceleration_mps2 * dt;
            self.height_m += self.velocity_mps * dt;
        }

        pub(crate) fn has_landed(&self) -> bool {
            self.height_m <= STANDING_M
        }
    }
}

#[rtic::app(device = crate::device, peripherals = false)]
mod app {
    use cortex_m::peripheral::syst::SystClkSource;
    use cortex_m_semihosting::{debug, hprintln};
    use touchdown_flight::Method;
    use touchdown_flight::ground_effect::{GroundEffectState, GuardedState};
    use touchdown_flight::vertical_controller::{VerticalController, VerticalControllerState};
    use touchdown_replay::{VerticalRecording, vertical_step};

    use crate::stub::Vehicle;

    /// Clock of QEMU's boards, Hz.
    const CLOCK_HZ: u32 = 25_000_000;
    const RATE_HZ: u32 = 100;
    const PERIOD_S: f32 = 0.01;
    const START_HEIGHT_M: f32 = 0.8;
    /// Throttle that the hover before is flown with.
    const THROTTLE: f32 = 0.5;
    /// The descent from 0.8 m takes 5 s; after four times that it has failed.
    const PERIODS_MAX: u32 = 2000;

    #[shared]
    struct Shared {}

    #[local]
    struct Local {
        controller: VerticalController<f32>,
        state: VerticalControllerState<f32, GuardedState<f32, GroundEffectState<f32>>>,
        vehicle: Vehicle,
        periods: u32,
    }

    #[init]
    fn init(cx: init::Context<'_>) -> (Shared, Local) {
        let settings = VerticalRecording {
            method: Method::Dynamic,
            deck_angular_frequency: None,
            start_height_m: START_HEIGHT_M,
        };
        let Some(controller) = settings.controller() else {
            crate::fail();
        };
        let vehicle = Vehicle::hovering(START_HEIGHT_M);
        let state = controller.initial(&vehicle.measure(), THROTTLE);
        let mut timer = cx.core.SYST;
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(CLOCK_HZ / RATE_HZ - 1);
        timer.clear_current();
        timer.enable_interrupt();
        timer.enable_counter();
        let local = Local {
            controller,
            state,
            vehicle,
            periods: 0,
        };
        (Shared {}, local)
    }

    /// One period: sensors, controller, rotors.
    #[task(binds = SysTick, local = [controller, state, vehicle, periods])]
    fn control(cx: control::Context<'_>) {
        let control::LocalResources {
            controller,
            state,
            vehicle,
            periods,
            ..
        } = cx.local;
        let command = vertical_step(controller, state, &vehicle.measure(), PERIOD_S);
        vehicle.fly(&controller.thrust, command.throttle, PERIOD_S);
        *periods += 1;
        if vehicle.has_landed() {
            let millimetres = (-1000.0 * vehicle.velocity_mps) as i32;
            hprintln!(
                "landed after {} periods of 10 ms at {} mm/s",
                periods,
                millimetres
            );
            debug::exit(debug::EXIT_SUCCESS);
        } else if *periods > PERIODS_MAX {
            crate::fail();
        }
    }
}
