//! The landing computer in flight: loss and return of what it sees, decks that move,
//! headings, delays.

mod loop_delays;
mod memory;
mod world;
