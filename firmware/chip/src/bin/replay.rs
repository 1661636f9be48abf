//! Replays a recording on the chip, counting instructions and painting the stack.
#![no_std]
#![no_main]

use core::panic::PanicInfo;

use cortex_m_rt::entry;
use touchdown_chip::{fail, run};
use touchdown_replay::replay;

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    fail()
}

#[entry]
fn main() -> ! {
    run(|port| replay(port))
}
