//! The exact share of every pixel that polygons cover.
//!
//! Each edge adds, per row, the change from pixel to pixel of the area to its
//! right; the running sum along the row is then the covered share, however small
//! or many the polygons are. Weights add up, so what lies on top of something is
//! drawn by the difference in brightness, and instants of an exposure by a share.

/// Covered shares, times weights, before the sum along rows.
#[derive(Clone, Debug)]
pub(super) struct Coverage {
    width: usize,
    height: usize,
    /// Rows of `width + 1`: the last takes what is right of the image.
    change: Vec<f32>,
}

impl Coverage {
    pub(super) fn new(width: usize, height: usize) -> Self {
        Self {
            width,
            height,
            change: vec![0.0; (width + 1) * height],
        }
    }

    pub(super) fn clear(&mut self) {
        self.change.fill(0.0);
    }

    /// Adds a polygon (px) with a weight; clockwise on the screen is positive.
    pub(super) fn add(&mut self, corners: &[[f64; 2]], weight: f64) {
        for (i, &from) in corners.iter().enumerate() {
            self.edge(from, corners[(i + 1) % corners.len()], weight);
        }
    }

    fn edge(&mut self, from: [f64; 2], to: [f64; 2], weight: f64) {
        // Up on the screen has its inside to the right.
        let (top, low, sign) = if from[1] > to[1] {
            (to, from, weight)
        } else {
            (from, to, -weight)
        };
        let (y0, y1) = (top[1].max(0.0), low[1].min(self.height as f64));
        if !(y0 < y1) {
            return;
        }
        let slope = (low[0] - top[0]) / (low[1] - top[1]);
        let x_at = |y: f64| top[0] + slope * (y - top[1]);
        let mut y = y0;
        for row in y0 as usize..self.height {
            let next = y1.min((row + 1) as f64);
            if !(y < next) {
                break;
            }
            self.segment(row, x_at(y), x_at(next), sign * (next - y));
            y = next;
        }
    }

    /// A piece of an edge within a row, between two abscissas, of a height
    /// (signed, weighted).
    fn segment(&mut self, row: usize, xa: f64, xb: f64, height: f64) {
        let width = self.width as f64;
        let (mut low, mut high) = (xa.min(xb), xa.max(xb));
        let mut height = height;
        let line = &mut self.change[row * (self.width + 1)..(row + 1) * (self.width + 1)];
        if low < 0.0 {
            // What is left of the image has all of the row to its right.
            let share = (-low / (high - low)).min(1.0);
            line[0] += (height * share) as f32;
            if high <= 0.0 {
                return;
            }
            height *= 1.0 - share;
            low = 0.0;
        }
        if high > width {
            if low >= width {
                return;
            }
            height *= (width - low) / (high - low);
            high = width;
        }
        // Mean over the piece of the area right of it and left of t, for a row
        // of height 1.
        let area = |t: f64| {
            if t <= low {
                0.0
            } else if t >= high {
                t - 0.5 * (low + high)
            } else {
                (t - low) * (t - low) / (2.0 * (high - low))
            }
        };
        let (first, last) = (low as usize, (high as usize).min(self.width - 1));
        let mut before = 0.0;
        let mut left = area(first as f64);
        for i in first..=last {
            let right = area((i + 1) as f64);
            let covered = right - left;
            line[i] += (height * (covered - before)) as f32;
            (before, left) = (covered, right);
        }
        if first <= last {
            line[last + 1] += (height * (1.0 - before)) as f32;
        }
    }

    /// The sums along rows, into an image of `width × height`.
    pub(super) fn sum_into(&self, image: &mut [f32]) {
        let rows = self.change.chunks_exact(self.width + 1);
        for (line, out) in rows.zip(image.chunks_exact_mut(self.width)) {
            let mut sum = 0.0;
            for (change, out) in line.iter().zip(out) {
                sum += change;
                *out = sum;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(corners: &[[f64; 2]], width: usize, height: usize) -> Vec<f32> {
        let mut coverage = Coverage::new(width, height);
        coverage.add(corners, 1.0);
        let mut image = vec![0.0; width * height];
        coverage.sum_into(&mut image);
        image
    }

    /// Sums of up to a hundred numbers of f32.
    const ROUNDING: f32 = 1e-5;

    #[test]
    fn analytic_rectangle_covers_its_share_of_pixels() {
        // From (1.25, 0.5) to (3.5, 2).
        let image = drawn(&[[1.25, 0.5], [3.5, 0.5], [3.5, 2.0], [1.25, 2.0]], 5, 3);
        let expected = [
            [0.0, 0.375, 0.5, 0.25, 0.0],
            [0.0, 0.75, 1.0, 0.5, 0.0],
            [0.0; 5],
        ];
        for (found, expected) in image.iter().zip(expected.as_flattened()) {
            assert!((found - expected).abs() < ROUNDING, "{image:?}");
        }
    }

    #[test]
    fn analytic_triangle_covers_half_of_the_diagonal_pixels() {
        let image = drawn(&[[0.0, 0.0], [4.0, 4.0], [0.0, 4.0]], 4, 4);
        for row in 0..4 {
            for column in 0..4 {
                let expected = match column.cmp(&row) {
                    std::cmp::Ordering::Less => 1.0,
                    std::cmp::Ordering::Equal => 0.5,
                    std::cmp::Ordering::Greater => 0.0,
                };
                assert!((image[4 * row + column] - expected).abs() < ROUNDING);
            }
        }
    }

    #[test]
    fn prop_area_is_kept_wherever_the_polygon_lies() {
        // A turned square of side 3.1, cut by each side of the image in turn.
        let square = |x: f64, y: f64| {
            let (s, c) = 0.4_f64.sin_cos();
            [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
                .map(|[a, b]: [f64; 2]| [x + 1.55 * (c * a - s * b), y + 1.55 * (s * a + c * b)])
        };
        let sum = |x, y| drawn(&square(x, y), 12, 9).iter().sum::<f32>();
        // 108 sums of f32.
        assert!((sum(6.0, 4.3) - 3.1 * 3.1).abs() < 1e-4);
        // A square's halves by a line through its centre are equal.
        for (x, y) in [(0.0, 4.3), (12.0, 4.3), (6.0, 0.0), (6.0, 9.0)] {
            assert!((sum(x, y) - 0.5 * 3.1 * 3.1).abs() < 1e-4, "{x} {y}");
        }
        for (x, y) in [(-5.0, 4.0), (20.0, 4.0), (6.0, -9.0), (6.0, 30.0)] {
            assert_eq!(sum(x, y), 0.0);
        }
        // A polygon that holds the whole image covers it.
        let all = drawn(&[[-1e6, -1e6], [1e6, -1e6], [1e6, 1e6], [-1e6, 1e6]], 12, 9);
        assert!(all.iter().all(|&share| (share - 1.0).abs() < ROUNDING));
    }
}
