//! Prime numbers, for points that are spread evenly.

/// The prime of this place, from 0: 2, 3, 5, 7, ...
pub(crate) fn prime(place: usize) -> usize {
    let is_prime = |n: &usize| (2..*n).all(|d| !n.is_multiple_of(d));
    (2..).filter(is_prime).nth(place).unwrap_or(2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_the_first_primes() {
        let found: Vec<usize> = (0..8).map(prime).collect();
        assert_eq!(found, [2, 3, 5, 7, 11, 13, 17, 19]);
    }
}
