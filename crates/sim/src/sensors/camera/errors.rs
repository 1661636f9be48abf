//! Errors of a detector at the corners of a tag, as tables.
//!
//! The tables hold the share of detected tags and the errors of their corners. Their axes
//! are the mean size of the tag's cells and its motion during the exposure, both in pixels.
//! Tags inside another tag have separate tables. The eight coordinates of four corners are
//! decomposed into modes of unit length, which act differently on a pose:
//!
//! | mode | corners move | the pose |
//! | --- | --- | --- |
//! | shift (2) | alike | moves to the side |
//! | scale (1) | outwards; has a mean | is nearer or farther |
//! | turn (1) | around the middle | yaws |
//! | stretch (2) | apart along one axis, together along the other | – (residual) |
//! | keystone (2) | apart on one side, together on the other | tilts |
//!
//! [`ErrorModel::fitted`] was measured on rendered images; the head of its file
//! gives the command.

use std::sync::LazyLock;

use crate::error::SimError;

/// Modes with a table of their own.
pub const MODES: usize = 5;

/// Names of the columns.
const COLUMNS: [&str; 10] = [
    "nested",
    "cell_px",
    "motion_px",
    "found",
    "scale_mean_px",
    "shift_px",
    "scale_px",
    "turn_px",
    "stretch_px",
    "keystone_px",
];

/// The measured model.
const FITTED: &str = include_str!("errors.csv");

/// Errors at one size and motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CornerErrors {
    /// Share of detected tags among those in view.
    pub found: f64,
    /// Mean of the mode "scale", px.
    pub scale_mean_px: f64,
    /// Standard deviations of shift, scale, turn, stretch and keystone, px.
    pub sd_px: [f64; MODES],
}

/// The tables.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorModel {
    cell_px: Vec<f64>,
    motion_px: Vec<f64>,
    /// Tables of single tags, then of nested ones.
    nodes: [Vec<CornerErrors>; 2],
}

impl ErrorModel {
    /// The model that comes with this crate; its file is read once.
    ///
    /// # Errors
    /// Those of [`Self::from_csv`]; the file of this crate has none.
    pub fn fitted() -> Result<Self, SimError> {
        static MODEL: LazyLock<Result<ErrorModel, SimError>> =
            LazyLock::new(|| ErrorModel::from_csv(FITTED));
        MODEL.clone()
    }

    /// Reads tables: a header, then a row for every node, first of tags by
    /// themselves (`nested` 0), then of nested ones (1), motion running faster
    /// than cells, both ascending. Lines that begin with `#` are remarks.
    ///
    /// # Errors
    /// Names the column and the row of the first value that cannot be.
    pub fn from_csv(text: &str) -> Result<Self, SimError> {
        let mut lines = text.lines().filter(|line| !line.starts_with('#'));
        let header = lines.next().unwrap_or_default();
        if header != COLUMNS.join(",") {
            return Err(fail("header", 0, &COLUMNS.join(","), header));
        }
        let rows = lines.enumerate().map(|(i, line)| row_of(i + 1, line));
        let rows: Vec<Row> = rows.collect::<Result<_, _>>()?;
        let half = rows.len() / 2;
        let first = rows.first().copied().unwrap_or_default();
        let motions = rows[..half].iter().take_while(|row| row[1] == first[1]);
        let motions = motions.count().max(1);
        let model = Self {
            cell_px: rows[..half]
                .iter()
                .step_by(motions)
                .map(|row| row[1])
                .collect(),
            motion_px: rows[..motions.min(half)].iter().map(|row| row[2]).collect(),
            nodes: [&rows[..half], &rows[half..]]
                .map(|rows| rows.iter().map(CornerErrors::of).collect()),
        };
        let ascending = |nodes: &[f64]| nodes.windows(2).all(|pair| pair[0] < pair[1]);
        let whole = rows.len() == 2 * motions * model.cell_px.len();
        let enough = model.motion_px.len() > 1 && model.cell_px.len() > 1 && first[1] > 0.0;
        if !(whole && enough && ascending(&model.cell_px) && ascending(&model.motion_px)) {
            let expected = "two grids of 2 × 2 nodes or more, ascending";
            return Err(fail(
                "cell_px",
                0,
                expected,
                &format!("{} rows", rows.len()),
            ));
        }
        for (i, row) in rows.iter().enumerate() {
            let (nested, node) = (i / half, i % half);
            let (cell, motion) = (
                model.cell_px[node / motions],
                model.motion_px[node % motions],
            );
            if row[..3] != [nested as f64, cell, motion] {
                let expected = format!("node {nested}, {cell}, {motion} of the grid");
                return Err(fail(
                    "cell_px",
                    i + 1,
                    &expected,
                    &format!("{:?}", &row[..3]),
                ));
            }
        }
        Ok(model)
    }

    /// The model between its nodes: linear in the logarithm of the cell and in
    /// the motion; as at the rim beyond it.
    #[must_use]
    pub fn at(&self, nested: bool, cell_px: f64, motion_px: f64) -> CornerErrors {
        let nodes = &self.nodes[usize::from(nested)];
        let (i, s) = place(&self.cell_px, cell_px, f64::ln);
        let (j, t) = place(&self.motion_px, motion_px, |x| x);
        let mut sum = CornerErrors::default();
        for (di, by_cell) in [(0, 1.0 - s), (1, s)] {
            for (dj, by_motion) in [(0, 1.0 - t), (1, t)] {
                let node = &nodes[(i + di) * self.motion_px.len() + j + dj];
                let weight = by_cell * by_motion;
                sum.found += weight * node.found;
                sum.scale_mean_px += weight * node.scale_mean_px;
                for k in 0..MODES {
                    sum.sd_px[k] += weight * node.sd_px[k];
                }
            }
        }
        sum
    }
}

impl CornerErrors {
    fn of(row: &Row) -> Self {
        Self {
            found: row[3],
            scale_mean_px: row[4],
            sd_px: [row[5], row[6], row[7], row[8], row[9]],
        }
    }
}

/// A row of the tables.
type Row = [f64; COLUMNS.len()];

fn fail(key: &str, row: usize, expected: &str, found: &str) -> SimError {
    SimError::Series {
        key: key.to_owned(),
        row,
        expected: expected.to_owned(),
        found: found.to_owned(),
    }
}

fn row_of(number: usize, line: &str) -> Result<Row, SimError> {
    let fields: Vec<&str> = line.split(',').collect();
    if fields.len() != COLUMNS.len() {
        return Err(fail("columns", number, "10 numbers", line));
    }
    let mut row = Row::default();
    for ((value, field), key) in row.iter_mut().zip(fields).zip(COLUMNS) {
        *value = field
            .trim()
            .parse()
            .ok()
            .filter(|x: &f64| x.is_finite() && (*x >= 0.0 || key == "scale_mean_px"))
            .filter(|&x| x <= 1.0 || key != "found")
            .ok_or_else(|| fail(key, number, "a number in its range", field))?;
    }
    Ok(row)
}

/// Index of the node below, and the share of the way to the next one.
fn place(nodes: &[f64], x: f64, measure: impl Fn(f64) -> f64) -> (usize, f64) {
    let last = nodes.len() - 2;
    let below = nodes.partition_point(|&node| node <= x).saturating_sub(1);
    let below = below.min(last);
    let (low, high) = (measure(nodes[below]), measure(nodes[below + 1]));
    (below, ((measure(x) - low) / (high - low)).clamp(0.0, 1.0))
}

/// The eight coordinates of four corners, in modes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Modes {
    right: [f64; 2],
    down: [f64; 2],
}

/// Right and down of each corner in the print: top left, top right, bottom
/// right, bottom left.
const SIGNS: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];

impl Modes {
    /// The modes of a tag whose corners are seen there, px.
    #[must_use]
    pub fn of(corners_px: &[[f64; 2]; 4]) -> Self {
        let mean = |axis: usize| {
            let mut sum = [0.0; 2];
            for (corner, sign) in corners_px.iter().zip(SIGNS) {
                sum[0] += sign[axis] * corner[0];
                sum[1] += sign[axis] * corner[1];
            }
            let length = sum[0].hypot(sum[1]);
            [sum[0] / length, sum[1] / length]
        };
        Self {
            right: mean(0),
            down: mean(1),
        }
    }

    /// Every mode: its place in [`CornerErrors::sd_px`] and how the corners move.
    #[must_use]
    pub fn all(&self) -> [(usize, [[f64; 2]; 4]); 8] {
        let mix = |along: fn([f64; 2]) -> [f64; 2], length: f64| {
            SIGNS.map(|sign| {
                let [a, b] = along(sign);
                [0, 1].map(|k| (a * self.right[k] + b * self.down[k]) / length)
            })
        };
        let root = 8.0_f64.sqrt();
        [
            (0, mix(|_| [1.0, 0.0], 2.0)),
            (0, mix(|_| [0.0, 1.0], 2.0)),
            (1, mix(|[r, d]| [r, d], root)),
            (2, mix(|[r, d]| [-d, r], root)),
            (3, mix(|[r, d]| [r, -d], root)),
            (3, mix(|[r, d]| [d, r], root)),
            (4, mix(|[r, d]| [r * d, 0.0], 2.0)),
            (4, mix(|[r, d]| [0.0, r * d], 2.0)),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: &str = "# a remark\n\
        nested,cell_px,motion_px,found,scale_mean_px,shift_px,scale_px,turn_px,stretch_px,keystone_px\n\
        0,1,0,0.5,-0.2,1,2,3,4,5\n\
        0,1,10,0,-0.2,1,2,3,4,5\n\
        0,4,0,1,0.2,0,0,0,0,0\n\
        0,4,10,0.5,0.2,0,0,0,0,0\n\
        1,1,0,0.25,0,1,2,3,4,5\n\
        1,1,10,0.25,0,1,2,3,4,5\n\
        1,4,0,0.25,0,1,2,3,4,5\n\
        1,4,10,0.25,0,1,2,3,4,5\n";

    #[test]
    fn analytic_between_nodes_and_beyond() {
        let model = ErrorModel::from_csv(TABLE).unwrap();
        // Halfway in the logarithm, a quarter in motion.
        let there = model.at(false, 2.0, 2.5);
        // Rounding only.
        assert!((there.found - (0.5 * 0.375 + 0.5 * 0.875)).abs() < 1e-12);
        assert!(there.scale_mean_px.abs() < 1e-12 && (there.sd_px[4] - 2.5).abs() < 1e-12);
        assert_eq!(model.at(false, 0.1, -1.0), model.at(false, 1.0, 0.0));
        assert_eq!(model.at(false, 100.0, 99.0), model.at(false, 4.0, 10.0));
        assert_eq!(model.at(false, 4.0, 10.0).found, 0.5);
        assert_eq!(model.at(true, 4.0, 10.0).found, 0.25);
    }

    #[test]
    fn prop_tables_that_cannot_be_are_refused() {
        let refused = |from: &str, to: &str| {
            assert!(TABLE.contains(from));
            let error = ErrorModel::from_csv(&TABLE.replacen(from, to, 1));
            error.unwrap_err().to_string()
        };
        assert!(refused("found", "seen").contains("found"));
        assert!(refused("0,4,10,0.5", "0,4,10,1.5").contains("row 4, `found`"));
        assert!(refused("0,1,0,0.5,-0.2,1", "0,1,0,0.5,-0.2,-1").contains("row 1, `shift_px`"));
        assert!(refused("0,1,0,0.5,-0.2,1", "0,1,0,0.5,-0.2,nan").contains("nan"));
        assert!(refused("0,4,10,0.5,0.2,0,0,0,0,0\n", "").contains("7 rows"));
        assert!(refused("1,1,0,", "0,1,0,").contains("row 5"));
        assert!(refused("1,4,10,", "1,4,11,").contains("row 8"));
        assert!(refused("0,4,0,1,", "0,0.5,0,1,").contains("ascending"));
        for text in ["", &COLUMNS.join(",")] {
            assert!(ErrorModel::from_csv(text).is_err());
        }
    }

    #[test]
    fn prop_the_fitted_model_is_whole_and_sensible() {
        let model = ErrorModel::fitted().unwrap();
        for nested in [false, true] {
            // Large still tags are found, to a few hundredths of a pixel; tiny or
            // smeared ones are not.
            let large = model.at(nested, 10.0, 0.0);
            assert!(large.found > 0.99 && large.sd_px.iter().all(|&sd| sd < 0.06));
            assert!(model.at(nested, 0.9, 0.0).found < 0.2);
            assert!(model.at(nested, 3.0, 15.0).found < 0.05);
            assert!(model.at(nested, 10.0, 8.0).sd_px[4] > 3.0 * large.sd_px[4]);
        }
    }

    #[test]
    fn analytic_modes_are_orthonormal() {
        let (s, c) = 0.3_f64.sin_cos();
        let corners = SIGNS.map(|[a, b]| {
            [
                100.0 + 20.0 * (c * a - s * b),
                50.0 + 20.0 * (s * a + c * b),
            ]
        });
        let modes = Modes::of(&corners).all();
        for (i, (_, a)) in modes.iter().enumerate() {
            for (j, (_, b)) in modes.iter().enumerate() {
                let dot: f64 = (0..4).map(|k| a[k][0] * b[k][0] + a[k][1] * b[k][1]).sum();
                // Rounding only.
                assert!((dot - f64::from(u8::from(i == j))).abs() < 1e-12, "{i} {j}");
            }
        }
        // Scale moves the corners outwards.
        let outwards = modes[2].1[0];
        let from_middle = [corners[0][0] - 100.0, corners[0][1] - 50.0];
        assert!(outwards[0] * from_middle[0] + outwards[1] * from_middle[1] > 0.0);
    }
}
