//! A landing computer for multirotors that land on ground or on decks that move:
//! estimators, planner, state machine, guidance and control in space.
//!
//! `no_std`, no allocation, no clock, no output, like `touchdown-flight`, whose models and
//! control laws it flies. Everything is generic over `f32` and `f64`
//! ([`Real`](touchdown_flight::Real)). Settings are checked once, by `validate`.
//!
//! | module | what it holds |
//! | --- | --- |
//! | [`estimate`] | the vehicle relative to the deck; heave of unknown frequency; latency |
//! | [`planner`] | when to descend onto a moving deck, and how |
//! | [`state_machine`] | phases of a landing, with aborts and go-arounds |
//! | [`guidance`] | from the state machine's manoeuvres to the controller's targets |
//! | [`control`] | horizontal law, disturbance observer, adaptation |
//! | [`space_controller`] | motion in, thrust and attitude out |
//! | [`computer`] | the landing computer: readings in, commands out |
//! | [`settings`], [`models`] | tuned defaults and fitted models; the computer built from them |
#![no_std]
#![forbid(unsafe_code)]

mod check;
pub mod computer;
pub mod control;
pub mod estimate;
pub mod guidance;
pub mod models;
pub mod planner;
pub mod settings;
pub mod space_controller;
pub mod state_machine;
