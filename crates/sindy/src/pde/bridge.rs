//! Single missing samples of a field, from their neighbours.

use super::data::{Axis, FieldData};

/// Weights of the four nearest neighbours along an axis: exact for cubics. Of white noise they leave 34/36 of the variance, so
/// a filled sample is about as noisy as a measured one.
const NEAREST: [(isize, f64); 4] = [
    (-2, -1.0 / 6.0),
    (-1, 4.0 / 6.0),
    (1, 4.0 / 6.0),
    (2, -1.0 / 6.0),
];
/// Samples on which an axis is tried, about.
const TRIED: usize = 4096;

/// The data with those missing samples filled that have two neighbours on either side along an axis, measured or filled before,
/// and how many were filled. Of several axes that is taken along which neighbours tell measured samples best.
pub(super) fn bridged(data: &FieldData) -> (FieldData, usize) {
    let (mut out, mut filled) = (data.clone(), 0);
    for field in 0..data.names().len() {
        let values = data.values(field);
        let mut missing: Vec<usize> = (0..values.len()).filter(|&i| values[i].is_nan()).collect();
        let mut axes: Vec<(f64, usize)> = (0..data.axes().len())
            .map(|axis| (roughness(data, field, axis), axis))
            .collect();
        axes.sort_by(|a, b| a.0.total_cmp(&b.0));
        loop {
            let value = |&i: &usize| {
                let by_axis = axes.iter();
                let mut found = by_axis.map(|(_, axis)| from_neighbours(&out, field, *axis, i));
                found.find(|v| v.is_finite())
            };
            let found: Vec<(usize, Option<f64>)> = missing.iter().map(|i| (*i, value(i))).collect();
            let left = found.iter().filter(|(_, v)| v.is_none()).count();
            if left == missing.len() {
                break;
            }
            filled += missing.len() - left;
            missing.clear();
            for (i, value) in found {
                match value {
                    Some(value) => out.set(field, i, value),
                    None => missing.push(i),
                }
            }
        }
    }
    (out, filled)
}

/// What the neighbours along an axis say of sample `i`; NaN where one is missing, or beyond the edge.
fn from_neighbours(data: &FieldData, field: usize, axis: usize, i: usize) -> f64 {
    let inner: usize = data.axes()[axis + 1..].iter().map(Axis::points).product();
    let place = i / inner % data.axes()[axis].points();
    let parts = NEAREST.map(|(offset, weight)| {
        let inside = place.checked_add_signed(offset);
        match inside.filter(|p| *p < data.axes()[axis].points()) {
            Some(_) => weight * data.values(field)[i.wrapping_add_signed(offset * inner as isize)],
            None => f64::NAN,
        }
    });
    parts.iter().sum()
}

/// Mean square of how far neighbours along an axis miss a measured sample; infinite where none can be tried.
fn roughness(data: &FieldData, field: usize, axis: usize) -> f64 {
    let values = data.values(field);
    // Odd strides do not follow the lines of grids of even sizes.
    let stride = (values.len() / TRIED) | 1;
    let (mut sum, mut count) = (0.0, 0_usize);
    for i in (0..values.len()).step_by(stride) {
        let miss = values[i] - from_neighbours(data, field, axis, i);
        if miss.is_finite() {
            sum += miss * miss;
            count += 1;
        }
    }
    match count {
        0 => f64::INFINITY,
        _ => sum / count as f64,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_cubics_are_filled_exactly_along_the_smoother_axis() {
        // A cubic in time, zigzag in space.
        let (n, m) = (20, 16);
        let truth: Vec<f64> = (0..n * m)
            .map(|i| {
                let (t, x) = ((i / m) as f64, i % m);
                0.01 * t.powi(3) - t + if x % 2 == 0 { 5.0 } else { -5.0 }
            })
            .collect();
        let mut values = truth.clone();
        // Inside, at an edge of space, at an edge of time, two in a row of time.
        let holes = [5 * m + 7, 9 * m, 3, 12 * m + 4, 13 * m + 4];
        holes.iter().for_each(|&i| values[i] = f64::NAN);
        let axes = vec![
            Axis::even("t", 1.0, n).unwrap(),
            Axis::even("x", 1.0, m).unwrap(),
        ];
        let data = FieldData::new(axes, vec![("u".to_owned(), values)]).unwrap();
        let (filled, count) = bridged(&data);
        let found = filled.values(0);
        // Rounding of numbers below 100.
        assert!((found[holes[0]] - truth[holes[0]]).abs() < 1e-12);
        assert!((found[holes[1]] - truth[holes[1]]).abs() < 1e-12);
        // Along space alone there are neighbours: they are there, and poor.
        assert!(found[holes[2]].is_finite() && found[holes[3]].is_finite());
        assert_eq!(count, 5);
        let measured = (0..n * m).filter(|i| !holes.contains(i));
        assert!(measured.into_iter().all(|i| found[i] == truth[i]));
    }

    #[test]
    fn prop_larger_holes_stay() {
        let axes = vec![
            Axis::even("t", 1.0, 12).unwrap(),
            Axis::even("x", 1.0, 12).unwrap(),
        ];
        let hole = |i: usize| (3..7).contains(&(i / 12)) && (3..7).contains(&(i % 12));
        let values = (0..144)
            .map(|i| if hole(i) { f64::NAN } else { 1.0 })
            .collect();
        let data = FieldData::new(axes, vec![("u".to_owned(), values)]).unwrap();
        let (filled, count) = bridged(&data);
        assert_eq!(count, 0);
        assert_eq!(filled.values(0).iter().filter(|v| v.is_nan()).count(), 16);
    }
}
