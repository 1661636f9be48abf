//! Tests over sockets with peers that keep time, in a program of their own: no long computation runs beside them.

mod common;

mod campaign_in_the_loop;
mod fly;
mod simulator;
