//! The chip's side of a replay: files of the host by semihosting, instructions and stack of the calls.
//!
//! QEMU runs with `-icount shift=6`: an instruction takes 64 ns, and SysTick counts 40 ns.
#![no_std]

use core::arch::asm;

use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_semihosting::{debug, syscall};
use touchdown_replay::Port;

/// Period of a word of the paint.
const PAINT: u32 = 0x5a5a_a5a5;
/// Words that are painted below the stack pointer: 128 kB.
const PAINTED: usize = 32 * 1024;
/// Words of a buffer of a file.
const BUFFER: usize = 256;

/// A file of the host.
struct HostFile {
    handle: usize,
    buffer: [u32; BUFFER],
    next: usize,
    end: usize,
}

impl HostFile {
    /// Opens a file in a mode of C's `fopen`: 1 is "rb", 5 is "wb".
    fn open(name: &[u8], mode: usize) -> Self {
        // SAFETY: the name ends with a zero, which its length does not count.
        let handle = unsafe { syscall!(OPEN, name.as_ptr(), mode, name.len() - 1) };
        Self {
            handle,
            buffer: [0; BUFFER],
            next: 0,
            end: 0,
        }
    }

    fn read(&mut self) -> Option<u32> {
        if self.next == self.end {
            let bytes = 4 * BUFFER;
            // SAFETY: the buffer has that many bytes.
            let left = unsafe { syscall!(READ, self.handle, self.buffer.as_mut_ptr(), bytes) };
            self.end = (bytes - left.min(bytes)) / 4;
            self.next = 0;
        }
        let word = *self.buffer[..self.end].get(self.next)?;
        self.next += 1;
        Some(word)
    }

    fn write(&mut self, word: u32) {
        self.buffer[self.next] = word;
        self.next += 1;
        if self.next == BUFFER {
            self.flush();
        }
    }

    fn flush(&mut self) {
        // SAFETY: the buffer has that many bytes.
        unsafe { syscall!(WRITE, self.handle, self.buffer.as_ptr(), 4 * self.next) };
        self.next = 0;
    }
}

/// The chip's side of a replay.
pub struct ChipPort {
    recording: HostFile,
    results: HostFile,
    counts: HostFile,
    syst: SYST,
    began: u32,
    /// Ticks of an empty call.
    empty: u32,
    stack: Option<Paint>,
}

/// The paint below the stack of the calls.
struct Paint {
    top: *mut u32,
}

impl Paint {
    /// Paints below the present stack pointer.
    #[inline(never)]
    fn new() -> Self {
        let top: *mut u32;
        // SAFETY: reads the stack pointer; what lies below is unused, because no interrupt
        // is enabled, and 4 MB of RAM hold it.
        unsafe {
            asm!("mov {}, sp", out(reg) top);
            for i in 1..=PAINTED {
                top.sub(i).write_volatile(PAINT);
            }
        }
        Self { top }
    }

    /// Bytes between the painting function's stack pointer and the deepest use.
    fn deepest(&self) -> usize {
        let used = |i: usize| {
            // SAFETY: within the painted words.
            unsafe { self.top.sub(i).read_volatile() != PAINT }
        };
        4 * (1..=PAINTED).rev().find(|&i| used(i)).unwrap_or(0)
    }
}

impl Port for ChipPort {
    fn word(&mut self) -> Option<u32> {
        self.recording.read()
    }

    fn write(&mut self, word: u32) {
        self.results.write(word);
    }

    #[inline(never)]
    fn begin(&mut self) {
        if self.stack.is_none() {
            self.stack = Some(Paint::new());
        }
        self.began = SYST::get_current();
    }

    #[inline(never)]
    fn end(&mut self) {
        let ticks = self.began.wrapping_sub(SYST::get_current()) & 0x00ff_ffff;
        self.counts
            .write(ticks.saturating_sub(self.empty) * 40 / 64);
    }
}

/// Runs a replay on the chip and ends QEMU: with success if `replay` returned true.
pub fn run(replay: impl FnOnce(&mut ChipPort) -> bool) -> ! {
    let Some(core) = cortex_m::Peripherals::take() else {
        fail();
    };
    let mut syst = core.SYST;
    syst.set_clock_source(SystClkSource::Core);
    syst.set_reload(0x00ff_ffff);
    syst.clear_current();
    syst.enable_counter();
    let mut port = ChipPort {
        recording: HostFile::open(b"replay.in\0", 1),
        results: HostFile::open(b"replay.out\0", 5),
        counts: HostFile::open(b"replay.counts\0", 5),
        syst,
        began: 0,
        empty: 0,
        stack: None,
    };
    port.begin();
    port.end();
    port.begin();
    let ticks = port.began.wrapping_sub(SYST::get_current()) & 0x00ff_ffff;
    port.empty = ticks;
    port.counts.next = 0;
    port.stack = None;
    let done = replay(&mut port);
    let deepest = port.stack.as_ref().map_or(0, Paint::deepest);
    port.counts.write(deepest as u32);
    port.results.flush();
    port.counts.flush();
    port.syst.disable_counter();
    debug::exit(if done {
        debug::EXIT_SUCCESS
    } else {
        debug::EXIT_FAILURE
    });
    loop {}
}

/// Ends QEMU with a failure.
pub fn fail() -> ! {
    debug::exit(debug::EXIT_FAILURE);
    loop {}
}
