//! Curves as polylines: steps, gaps, and what is visible of them.

use crate::shape::Rect;

/// Adds the corner of each step: a value holds until the next sample.
pub(crate) fn steps(samples: impl Iterator<Item = Option<[f64; 2]>>) -> Vec<Option<[f64; 2]>> {
    let mut out: Vec<Option<[f64; 2]>> = Vec::new();
    for sample in samples {
        if let (Some(Some([_, before])), Some([x, _])) = (out.last(), sample) {
            out.push(Some([x, *before]));
        }
        out.push(sample);
    }
    out
}

/// The samples before and after one.
pub(crate) fn neighbours(points: &[Option<[f64; 2]>], i: usize) -> [Option<[f64; 2]>; 2] {
    let before = i.checked_sub(1).and_then(|i| points[i]);
    [before, points.get(i + 1).copied().flatten()]
}

/// Polylines of what is visible: broken at gaps, cut at the rectangle.
pub(crate) fn visible_runs(points: &[Option<[f64; 2]>], room: &Rect) -> Vec<Vec<[f32; 2]>> {
    let mut runs: Vec<Vec<[f32; 2]>> = Vec::new();
    let mut end: Option<[f64; 2]> = None;
    for pair in points.windows(2) {
        let [Some(a), Some(b)] = [pair[0], pair[1]] else {
            continue;
        };
        let Some((from, to)) = cut(a, b, room) else {
            continue;
        };
        let narrow = |[x, y]: [f64; 2]| [x as f32, y as f32];
        // Continue the last run only where this piece begins at the very sample where that one ended.
        match runs.last_mut() {
            Some(run) if end == Some(from) && from == a => run.push(narrow(to)),
            _ => runs.push(vec![narrow(from), narrow(to)]),
        }
        end = (to == b).then_some(to);
    }
    runs
}

/// The part of a straight line within a rectangle (Liang & Barsky 1984).
fn cut(a: [f64; 2], b: [f64; 2], room: &Rect) -> Option<([f64; 2], [f64; 2])> {
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    let step = [b[0] - a[0], b[1] - a[1]];
    let sides = [
        (-step[0], a[0] - f64::from(room.left)),
        (step[0], f64::from(room.right) - a[0]),
        (-step[1], a[1] - f64::from(room.top)),
        (step[1], f64::from(room.bottom) - a[1]),
    ];
    for (toward, distance) in sides {
        if toward == 0.0 {
            if distance < 0.0 {
                return None;
            }
        } else if toward < 0.0 {
            enter = enter.max(distance / toward);
        } else {
            leave = leave.min(distance / toward);
        }
    }
    let along = |t: f64| [a[0] + t * step[0], a[1] + t * step[1]];
    let from = if enter > 0.0 { along(enter) } else { a };
    let to = if leave < 1.0 { along(leave) } else { b };
    (enter <= leave && from.iter().chain(&to).all(|v| v.is_finite())).then_some((from, to))
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROOM: Rect = Rect {
        left: 0.0,
        top: 0.0,
        right: 10.0,
        bottom: 10.0,
    };

    #[test]
    fn analytic_a_gap_breaks_the_line() {
        let points = [
            Some([1.0, 1.0]),
            Some([2.0, 2.0]),
            None,
            Some([4.0, 4.0]),
            Some([5.0, 5.0]),
        ];
        assert_eq!(
            visible_runs(&points, &ROOM),
            [vec![[1.0, 1.0], [2.0, 2.0]], vec![[4.0, 4.0], [5.0, 5.0]]]
        );
    }

    #[test]
    fn analytic_lines_are_cut_where_they_leave() {
        let points = [
            Some([5.0, 5.0]),
            Some([5.0, 1e9]),
            Some([6.0, 1e9]),
            Some([6.0, 5.0]),
        ];
        let runs = visible_runs(&points, &ROOM);
        assert_eq!(
            runs,
            [vec![[5.0, 5.0], [5.0, 10.0]], vec![[6.0, 10.0], [6.0, 5.0]]]
        );
    }

    #[test]
    fn analytic_steps_hold_their_value() {
        let points =
            steps([Some([0.0, 1.0]), Some([2.0, 3.0]), None, Some([4.0, 5.0])].into_iter());
        assert_eq!(
            points,
            [
                Some([0.0, 1.0]),
                Some([2.0, 1.0]),
                Some([2.0, 3.0]),
                None,
                Some([4.0, 5.0])
            ]
        );
    }
}
