//! Thinning of long series for display.

use crate::figure::{Figure, Kind, Series};

/// A series with more points than this is thinned for display: 1000 buckets of consecutive samples keep their first
/// and last sample, their extremes and their gaps.
pub const MAX_DRAWN_POINTS: usize = 4000;

/// Samples that a curve over ordered time keeps of a bucket, at most: so 1000 buckets, one to a pixel at usual widths.
const KEPT: usize = 4;

/// Indices to draw, ascending; all of them when there are at most [`MAX_DRAWN_POINTS`].
///
/// `channels` are columns of equal length that are drawn together (x and y, or x and both edges of a band). Each bucket
/// of consecutive samples keeps its first and last whole sample, the smallest and the largest value of each channel, and
/// its first and last gap (a sample with any channel not finite), so that no extreme and no gap vanishes.
pub(crate) fn keep(channels: &[&[f64]]) -> Vec<usize> {
    keep_about(MAX_DRAWN_POINTS, channels)
}

/// As [`keep`], with another number of points.
fn keep_about(points: usize, channels: &[&[f64]]) -> Vec<usize> {
    let len = channels.iter().map(|c| c.len()).min().unwrap_or(0);
    if len <= points {
        return (0..len).collect();
    }
    let buckets = (points / KEPT).max(1);
    let mut kept = Vec::with_capacity(points);
    let mut bucket_kept = Vec::with_capacity(KEPT + 2 * channels.len());
    for bucket in 0..buckets {
        let range = bucket * len / buckets..(bucket + 1) * len / buckets;
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

impl Figure {
    /// Thins every series of more than so many points, in the way of those of more than [`MAX_DRAWN_POINTS`]: for
    /// pages that hold many figures.
    #[must_use]
    pub fn thinned(mut self, points: usize) -> Self {
        let panels = self.panels.iter_mut();
        panels
            .flat_map(|panel| &mut panel.series)
            .for_each(|series| series.thin(points));
        self
    }
}

impl Series {
    fn thin(&mut self, points: usize) {
        let kept = match &self.kind {
            // A line across the panel has no samples.
            Kind::HorizontalLine | Kind::VerticalLine => return,
            Kind::Band { lower, upper } => keep_about(points, &[&self.x, lower, upper]),
            Kind::ErrorBars { plus_minus } => keep_about(points, &[&self.x, &self.y, plus_minus]),
            _ => keep_about(points, &[&self.x, &self.y]),
        };
        let thin = |column: &mut Vec<f64>| {
            if !column.is_empty() {
                *column = kept.iter().map(|i| column[*i]).collect();
            }
        };
        thin(&mut self.x);
        thin(&mut self.y);
        match &mut self.kind {
            Kind::Band { lower, upper } => [lower, upper].into_iter().for_each(thin),
            Kind::ErrorBars { plus_minus } => thin(plus_minus),
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::Panel;

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
        assert!(kept.len() <= MAX_DRAWN_POINTS + 2, "{} kept", kept.len());
        for index in [0, 123_456, 654_321, 777_777, 999_999] {
            assert!(kept.binary_search(&index).is_ok(), "{index} lost");
        }
        assert!(kept.is_sorted());
    }

    #[test]
    fn analytic_a_thinned_figure_keeps_peaks_and_lines() {
        let x: Vec<f64> = (0..10_000).map(f64::from).collect();
        let mut y = vec![0.0; x.len()];
        y[1234] = 7.0;
        let panel = Panel::new("x", "y")
            .series(Series::line("peak", &x, &y))
            .series(Series::band("band", &x, &y, &x))
            .series(Series::error_bars("bars", &x, &x, &y))
            .series(Series::horizontal("zero", 0.0))
            .series(Series::points("few", &x[..9], &y[..9]));
        let thinned = Figure::new("f", "F").panel(panel).thinned(400);
        thinned.check().unwrap();
        let series = &thinned.panels[0].series;
        // Each of 100 buckets keeps at most four samples, that with three columns six.
        assert!(series[0].x.len() <= 400, "{}", series[0].x.len());
        assert!(series[1].x.len() <= 600, "{}", series[1].x.len());
        assert!(series[0].y.contains(&7.0) && series[0].x.contains(&1234.0));
        assert_eq!(series[0].x.last(), Some(&9999.0));
        assert!(matches!(&series[1].kind, Kind::Band { lower, .. } if lower.contains(&7.0)));
        assert!(
            matches!(&series[2].kind, Kind::ErrorBars { plus_minus } if plus_minus.contains(&7.0))
        );
        assert_eq!((series[3].y.as_slice(), series[4].x.len()), (&[0.0][..], 9));
    }
}
