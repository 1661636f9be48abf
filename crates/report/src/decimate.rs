//! Thinning of long series for display.

/// A series with more points than this is thinned for display: 1000 buckets of consecutive samples keep their first
/// and last sample, their extremes and their gaps.
pub const MAX_DRAWN_POINTS: usize = 4000;

/// Index buckets of a thinned series: a curve of 1000 buckets has at most one to a pixel at usual widths, and a
/// curve over ordered time keeps at most four samples of each.
const BUCKETS: usize = 1000;

/// Indices to draw, ascending; all of them when there are at most [`MAX_DRAWN_POINTS`].
///
/// `channels` are columns of equal length that are drawn together (x and y, or x and both edges of a band). Each bucket
/// of consecutive samples keeps its first and last whole sample, the smallest and the largest value of each channel, and
/// its first and last gap (a sample with any channel not finite), so that no extreme and no gap vanishes.
pub(crate) fn keep(channels: &[&[f64]]) -> Vec<usize> {
    let len = channels.iter().map(|c| c.len()).min().unwrap_or(0);
    if len <= MAX_DRAWN_POINTS {
        return (0..len).collect();
    }
    let mut kept = Vec::with_capacity(4 * BUCKETS);
    let mut bucket_kept = Vec::with_capacity(4 + 2 * channels.len());
    for bucket in 0..BUCKETS {
        let range = bucket * len / BUCKETS..(bucket + 1) * len / BUCKETS;
        bucket_kept.clear();
        keep_of_bucket(channels, range, &mut bucket_kept);
        bucket_kept.sort_unstable();
        bucket_kept.dedup();
        kept.extend_from_slice(&bucket_kept);
    }
    kept
}

fn keep_of_bucket(channels: &[&[f64]], range: std::ops::Range<usize>, out: &mut Vec<usize>) {
    let whole = |i: &usize| channels.iter().all(|c| c[*i].is_finite());
    out.extend(range.clone().find(whole));
    out.extend(range.clone().rev().find(whole));
    out.extend(range.clone().find(|i| !whole(i)));
    out.extend(range.clone().rev().find(|i| !whole(i)));
    for channel in channels {
        let by_value = |a: &usize, b: &usize| channel[*a].total_cmp(&channel[*b]);
        out.extend(range.clone().filter(whole).min_by(by_value));
        out.extend(range.clone().filter(whole).max_by(by_value));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_short_series_is_untouched() {
        let y = vec![0.0; MAX_DRAWN_POINTS];
        assert_eq!(keep(&[&y]), (0..MAX_DRAWN_POINTS).collect::<Vec<_>>());
    }

    #[test]
    fn analytic_single_spikes_and_gaps_survive() {
        let n = 1_000_000;
        let x: Vec<f64> = (0..n).map(f64::from).collect();
        let mut y: Vec<f64> = x.iter().map(|x| (1e-4 * x).sin()).collect();
        y[123_456] = 9.0;
        y[654_321] = -9.0;
        y[777_777] = f64::NAN;
        let kept = keep(&[&x, &y]);
        assert!(kept.len() <= 4 * BUCKETS + 2, "{} kept", kept.len());
        for index in [0, 123_456, 654_321, 777_777, 999_999] {
            assert!(kept.binary_search(&index).is_ok(), "{index} lost");
        }
        assert!(kept.is_sorted());
    }
}
