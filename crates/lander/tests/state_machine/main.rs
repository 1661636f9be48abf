//! The landing's state machine: its table, its promises, and lying sensors.

mod contact;
mod edges;
mod promises;
mod sight;
mod table;
mod touchdown;
mod wind;
mod world;
