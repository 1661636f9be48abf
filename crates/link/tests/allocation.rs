//! The companion in control allocates nothing, so that no allocator delays a setpoint; and any script of messages, bytes
//! and pauses keeps the rules of the fuzz target.
#![allow(unsafe_code)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::atomic::{AtomicUsize, Ordering};

use proptest::prelude::*;

#[path = "../fuzz/src/lib.rs"]
#[allow(unreachable_pub)]
mod bench;

use bench::Bench;

thread_local! {
    /// Whether this thread is in the companion.
    static INSIDE: Cell<bool> = const { Cell::new(false) };
}
static COUNT: AtomicUsize = AtomicUsize::new(0);

struct Counting;

// SAFETY: every call goes to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: the caller's promise.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller's promise.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        // SAFETY: the caller's promise.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn count() {
    if INSIDE.get() {
        COUNT.fetch_add(1, Ordering::Relaxed);
    }
}

#[test]
fn prop_nothing_is_allocated_while_in_control() {
    // Before control the checklist is written anew twice a second: so the counter counts.
    let mut bench = Bench::start(false);
    bench.probe = |inside| INSIDE.set(inside);
    bench.run(300);
    assert!(COUNT.load(Ordering::Relaxed) > 0);
    let mut bench = Bench::start(true);
    bench.probe = |inside| INSIDE.set(inside);
    // The inbox and the decoder have filled their buffers after a second.
    bench.run(100);
    COUNT.store(0, Ordering::Relaxed);
    bench.run(500);
    assert!(bench.in_control());
    assert_eq!(COUNT.load(Ordering::Relaxed), 0);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    #[test]
    fn prop_any_script_keeps_the_rules(
        flies in any::<bool>(),
        script in proptest::collection::vec(any::<u8>(), 0..200),
    ) {
        Bench::start(flies).script(&script);
    }
}
