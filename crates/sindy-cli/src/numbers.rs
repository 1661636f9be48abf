//! Numbers as text.

/// Decimals that show two digits of an error; `None` where they would be too many.
pub(crate) fn decimals(error: f64) -> Option<usize> {
    let place = 1.0 - error.log10().floor();
    (-6.0..=9.0)
        .contains(&place)
        .then_some(place.max(0.0) as usize)
}

/// A number with so many digits.
pub(crate) fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let place = digits as f64 - 1.0 - value.abs().log10().floor();
    match (-3.0..=9.0).contains(&place) {
        true => format!("{value:.*}", place.clamp(0.0, 9.0) as usize),
        false => format!("{value:.*e}", digits - 1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_numbers_for_people() {
        assert_eq!(significant(0.0, 4), "0");
        assert_eq!(significant(-27.9579, 4), "-27.96");
        assert_eq!(significant(0.01, 3), "0.0100");
        assert_eq!(significant(1.5e-9, 3), "1.50e-9");
        assert_eq!(significant(123_456.0, 4), "123456");
        assert_eq!(significant(1.0e12, 4), "1.000e12");
        assert_eq!(decimals(0.0214), Some(3));
        assert_eq!(decimals(3100.0), Some(0));
        assert_eq!((decimals(0.0), decimals(1e-14)), (None, None));
    }
}
