//! The tests in one program: what they share is compiled once. `memory.rs` measures its own process.

mod common;

mod bad_input;
mod conserve;
mod constraint;
mod diffusion;
mod explicit_time;
mod fit;
mod implicit;
mod known;
mod partial;
mod past;
mod pde;
mod rates;
mod sign;
mod simulate;
mod stable;
mod stream;
