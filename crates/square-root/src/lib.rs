//! Square root in single precision by the processor's own instruction.
//!
//! `core` has no stable square root, and that of `libm` is software on a Cortex-M. This crate
//! holds the one instruction that it takes, so that the crates that fly can forbid `unsafe`.
//! IEEE 754 rounds a square root correctly, so all targets return the same bits.
#![no_std]

/// Square root, correctly rounded; NaN for a negative argument.
///
/// On a hard-float ARM it is `vsqrt.f32` (14 cycles on a Cortex-M4) between two moves of a
/// register. The software of `libm` takes about 100 instructions there.
#[must_use]
#[inline]
pub fn square_root(x: f32) -> f32 {
    #[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
    {
        let root: u32;
        // SAFETY: the instructions read and write the registers named here alone, and the
        // hard-float ABI guarantees that the processor has them. The operands are in core
        // registers, because the compiler does not offer those of the floating-point unit
        // for this target.
        #[allow(unsafe_code)]
        unsafe {
            core::arch::asm!(
                "vmov s0, {x}",
                "vsqrt.f32 s0, s0",
                "vmov {root}, s0",
                x = in(reg) x.to_bits(),
                root = lateout(reg) root,
                out("s0") _,
                options(pure, nomem, nostack, preserves_flags),
            );
        }
        f32::from_bits(root)
    }
    #[cfg(not(all(target_arch = "arm", target_abi = "eabihf")))]
    libm::sqrtf(x)
}

#[cfg(test)]
mod tests {
    use super::square_root;

    #[test]
    fn analytic_square_root_is_correctly_rounded() {
        // Every 997th non-negative number (a prime, so that all low bits occur), against the
        // root in double precision, whose rounding to f32 is exact for a square root.
        for bits in (0..=f32::INFINITY.to_bits()).step_by(997) {
            let x = f32::from_bits(bits);
            #[allow(clippy::cast_possible_truncation)]
            let expected = f64::from(x).sqrt() as f32;
            assert_eq!(square_root(x).to_bits(), expected.to_bits(), "{x}");
        }
        assert!(square_root(-1.0).is_nan());
    }
}
