//! The print on the deck: square tags of black and white cells.

use super::raster::Coverage;
use crate::camera::Pose;
use crate::error::{VisionError, ensure, finite, positive, setting};
use crate::family::{self, CELLS};
use crate::pad::{Pad, PadTag};

/// A tag on the deck.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrintedTag {
    /// Its cells row by row from the top left, true for white.
    pub cells: [[bool; CELLS]; CELLS],
    /// Side of the tag, m.
    pub size_m: f64,
    /// Its centre on the deck x, y (forward, to port), m.
    pub centre_m: [f64; 2],
    /// Turn of the print from "top is forward", to port, rad.
    pub yaw_rad: f64,
}

impl PrintedTag {
    /// The deck's point of a place in the tag, in cells to the right and down
    /// from its top left.
    #[inline]
    #[must_use]
    pub fn point_m(&self, right: f64, down: f64) -> [f64; 2] {
        let cell = self.size_m / CELLS as f64;
        let half = 0.5 * CELLS as f64;
        let (a, b) = (cell * (half - down), cell * (half - right));
        let (sin, cos) = self.yaw_rad.sin_cos();
        let [x, y] = self.centre_m;
        [x + cos * a - sin * b, y + sin * a + cos * b]
    }

    /// Corners of the square that is `margin` cells larger on every side: top
    /// left, top right, bottom right, bottom left of the print.
    #[must_use]
    pub fn corners_m(&self, margin: f64) -> [[f64; 2]; 4] {
        let (low, high) = (-margin, CELLS as f64 + margin);
        [[low, low], [high, low], [high, high], [low, high]].map(|[r, d]| self.point_m(r, d))
    }

    /// Place of a deck's point in this tag, in cells to the right and down.
    fn in_cells(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.yaw_rad.sin_cos();
        let (dx, dy) = (x - self.centre_m[0], y - self.centre_m[1]);
        let (a, b) = (cos * dx + sin * dy, cos * dy - sin * dx);
        let cell = self.size_m / CELLS as f64;
        let half = 0.5 * CELLS as f64;
        [half - b / cell, half - a / cell]
    }

    /// Smallest rectangle of this tag's cells that holds `other` with a margin
    /// of one of its own cells: left, top, right, bottom.
    fn bounds_of(&self, other: &Self) -> [f64; 4] {
        let mut bounds = [
            f64::INFINITY,
            f64::INFINITY,
            f64::NEG_INFINITY,
            f64::NEG_INFINITY,
        ];
        for corner in other.corners_m(1.0) {
            let place = self.in_cells(corner);
            for k in 0..2 {
                bounds[k] = bounds[k].min(place[k]);
                bounds[k + 2] = bounds[k + 2].max(place[k]);
            }
        }
        bounds
    }
}

/// The deck and its print, in reflectances from 0 to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct DeckPrint {
    /// The tags.
    pub tags: Vec<PrintedTag>,
    /// Side of the square deck, m.
    pub side_m: f64,
    /// Reflectance of what is white, of what is black, of the deck, and of what
    /// is seen beside it.
    pub white: f64,
    /// Black cells.
    pub black: f64,
    /// The deck.
    pub deck: f64,
    /// What is seen beside the deck.
    pub beside: f64,
}

impl DeckPrint {
    /// Tags on the default deck of 1.5 m, grey, over something darker.
    #[must_use]
    pub fn new(tags: Vec<PrintedTag>) -> Self {
        Self {
            tags,
            side_m: 1.5,
            white: 0.9,
            black: 0.05,
            deck: 0.45,
            beside: 0.25,
        }
    }

    /// The print of a pad.
    ///
    /// # Errors
    /// The cells of every id must be known ([`family::cells`]).
    pub fn of(pad: &Pad) -> Result<Self, VisionError> {
        let printed = |(i, tag): (usize, &PadTag)| {
            let unknown = || setting(&format!("tags[{i}].id"), "a tag that can be drawn", &tag.id);
            Ok(PrintedTag {
                cells: family::cells(tag.id).ok_or_else(unknown)?,
                size_m: tag.size_m,
                centre_m: tag.centre_m,
                yaw_rad: tag.yaw_rad,
            })
        };
        let tags: Result<_, VisionError> = pad.tags.iter().enumerate().map(printed).collect();
        Ok(Self::new(tags?))
    }

    /// Checks the print.
    ///
    /// # Errors
    /// Sizes are positive, places finite, reflectances within 0..1. A tag with
    /// its white margin of a cell lies within the deck, and either clear of
    /// another tag and its margin or all on that tag's white cells.
    pub fn validate(&self) -> Result<(), VisionError> {
        positive("side_m", self.side_m)?;
        for (key, value) in [
            ("white", self.white),
            ("black", self.black),
            ("deck", self.deck),
            ("beside", self.beside),
        ] {
            let share = (0.0..=1.0).contains(&value);
            ensure(share, key, "a number from 0 to 1", &value)?;
        }
        for (i, tag) in self.tags.iter().enumerate() {
            let key = |name: &str| format!("tags[{i}].{name}");
            positive(&key("size_m"), tag.size_m)?;
            finite(&key("yaw_rad"), tag.yaw_rad)?;
            for x in tag.centre_m {
                finite(&key("centre_m"), x)?;
            }
            for x in tag.corners_m(1.0).into_iter().flatten() {
                // Rounding of a tag that just fits.
                let fits = x.abs() <= 0.5 * self.side_m * (1.0 + 1e-9);
                let expected = "a tag with its margin on the deck";
                ensure(fits, &key("size_m"), expected, &tag.size_m)?;
            }
        }
        for (i, tag) in self.tags.iter().enumerate() {
            for other in &self.tags[..i] {
                let (large, small) = if tag.size_m > other.size_m {
                    (tag, other)
                } else {
                    (other, tag)
                };
                let apart = clear(large, small) || nested(large, small);
                ensure(
                    apart,
                    &format!("tags[{i}].centre_m"),
                    "a place clear of other tags or on their white cells",
                    &tag.centre_m[0],
                )?;
            }
        }
        Ok(())
    }

    /// A tag stands on white cells of a larger one.
    #[must_use]
    pub fn is_nested(&self, tag: &PrintedTag) -> bool {
        let mut others = self.tags.iter();
        others.any(|other| other.size_m > tag.size_m && nested(other, tag))
    }

    /// Draws what a camera sees of the deck and the print, relative to what is
    /// beside the deck; `project` turns camera axes into pixels.
    pub(super) fn draw(
        &self,
        coverage: &mut Coverage,
        pose: &Pose,
        project: &impl Fn([f64; 3]) -> [f64; 2],
        share: f64,
    ) {
        let mut paint = |corners: [[f64; 2]; 4], change: f64| {
            let (seen, n) = ahead(&corners.map(|corner| pose.point(corner)));
            let mut on_screen = [[0.0; 2]; 5];
            for k in 0..n {
                on_screen[k] = project(seen[k]);
            }
            coverage.add(&on_screen[..n], share * change);
        };
        let half = 0.5 * self.side_m;
        // From above with forward up: top left is forward and to port.
        let deck = [[half, half], [half, -half], [-half, -half], [-half, half]];
        paint(deck, self.deck - self.beside);
        for tag in &self.tags {
            if !self.is_nested(tag) {
                paint(tag.corners_m(1.0), self.white - self.deck);
            }
            for (row, cells) in tag.cells.iter().enumerate() {
                let (top, low) = (row as f64, (row + 1) as f64);
                let mut column = 0;
                while column < CELLS {
                    let run = cells[column..].iter().take_while(|&&white| !white).count();
                    if run > 0 {
                        let (left, right) = (column as f64, (column + run) as f64);
                        let corners = [[left, top], [right, top], [right, low], [left, low]];
                        paint(
                            corners.map(|[r, d]| tag.point_m(r, d)),
                            self.black - self.white,
                        );
                    }
                    column += run + 1;
                }
            }
        }
    }
}

/// The margins of two tags do not touch (by their bounds in the larger's axes).
fn clear(large: &PrintedTag, small: &PrintedTag) -> bool {
    let [left, top, right, bottom] = large.bounds_of(small);
    let (low, high) = (-1.0, CELLS as f64 + 1.0);
    right <= low || left >= high || bottom <= low || top >= high
}

/// The small tag with its margin stands on white cells of the large one.
fn nested(large: &PrintedTag, small: &PrintedTag) -> bool {
    let bounds = large.bounds_of(small);
    // A margin may end exactly at the white's edge: rounding.
    let slack = 1e-9;
    if bounds[0] < 0.0 || bounds[1] < 0.0 || bounds[2] > CELLS as f64 || bounds[3] > CELLS as f64 {
        return false;
    }
    let cells = |low: f64, high: f64| {
        let first = (low + slack) as usize;
        let last = ((high - slack) as usize).min(CELLS - 1);
        first..=last
    };
    cells(bounds[1], bounds[3])
        .all(|row| cells(bounds[0], bounds[2]).all(|column| large.cells[row][column]))
}

/// Nearest that anything is drawn, m.
const NEAR_M: f64 = 1e-3;

/// The part of a quadrangle that is ahead of the camera.
fn ahead(corners: &[[f64; 3]; 4]) -> ([[f64; 3]; 5], usize) {
    let (mut kept, mut n) = ([[0.0; 3]; 5], 0);
    for (i, &from) in corners.iter().enumerate() {
        let to = corners[(i + 1) % 4];
        if from[2] >= NEAR_M {
            kept[n] = from;
            n += 1;
        }
        if (from[2] >= NEAR_M) != (to[2] >= NEAR_M) {
            let s = (NEAR_M - from[2]) / (to[2] - from[2]);
            let cut = |k: usize| from[k] + s * (to[k] - from[k]);
            kept[n] = [cut(0), cut(1), NEAR_M];
            n += 1;
        }
    }
    (kept, n)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// White in the middle four cells, else black.
    fn tag(size_m: f64, centre_m: [f64; 2], yaw_rad: f64) -> PrintedTag {
        let mut cells = [[false; CELLS]; CELLS];
        for row in [3, 4] {
            cells[row][3] = true;
            cells[row][4] = true;
        }
        PrintedTag {
            cells,
            size_m,
            centre_m,
            yaw_rad,
        }
    }

    #[test]
    fn analytic_places_in_a_tag() {
        let tag = tag(0.8, [1.0, 2.0], std::f64::consts::FRAC_PI_2);
        // Its top is to port, so its right is forward.
        let [x, y] = tag.point_m(7.0, 4.0);
        // Rounding only.
        assert!((x - 1.3).abs() < 1e-12 && (y - 2.0).abs() < 1e-12);
        let [right, down] = tag.in_cells([x, y]);
        assert!((right - 7.0).abs() < 1e-12 && (down - 4.0).abs() < 1e-12);
    }

    #[test]
    fn prop_prints_that_cannot_be_painted_are_refused() {
        let print = |tags| DeckPrint::new(tags).validate();
        let large = tag(0.4, [0.0; 2], 0.0);
        assert_eq!(print(vec![large, tag(0.08, [0.0; 2], 0.0)]), Ok(()));
        assert_eq!(print(vec![tag(0.08, [0.0; 2], 0.0), large]), Ok(()));
        assert_eq!(print(vec![large, tag(0.1, [0.4, 0.0], 0.3)]), Ok(()));
        for bad in [
            // On black cells, over the edge of the white, turned out of it, off the deck.
            tag(0.08, [0.1, 0.0], 0.0),
            tag(0.09, [0.0; 2], 0.0),
            tag(0.08, [0.0; 2], 0.3),
            tag(0.1, [0.72, 0.0], 0.0),
            tag(0.1, [f64::NAN, 0.0], 0.0),
            tag(0.0, [0.0; 2], 0.0),
        ] {
            let error = print(vec![large, bad]).unwrap_err().to_string();
            assert!(error.contains("tags[1]"), "{error}");
        }
    }

    #[test]
    fn analytic_what_is_behind_the_camera_is_cut_off() {
        let corners = [
            [0.0, 0.0, 1.0],
            [1.0, 0.0, 1.0],
            [1.0, 0.0, -1.0],
            [0.0, 0.0, -1.0],
        ];
        let (kept, n) = ahead(&corners);
        assert_eq!(n, 4);
        assert!(kept[..n].iter().all(|corner| corner[2] >= NEAR_M));
        assert_eq!(ahead(&corners.map(|[x, y, _]| [x, y, -1.0])).1, 0);
        assert_eq!(ahead(&corners.map(|[x, y, _]| [x, y, 2.0])).1, 4);
    }
}
