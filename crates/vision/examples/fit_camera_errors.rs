//! Measures the detector on rendered images and prints the tables of the fast
//! camera's error model.
//!
//! ```text
//! cargo run --release -p touchdown-vision --example fit_camera_errors [FRAMES] [SEED] > errors.csv
//! ```
//!
//! The tables in the repository, `crates/sim/src/sensors/camera/errors.csv`, are those of
//! the defaults. Another camera, lens, noise or detector wants tables of its own.
#![allow(clippy::print_stdout)]

#[path = "../tests/common/mod.rs"]
mod common;

use common::{Pipeline, deck_tags, noise, vehicle};
use touchdown_sim::deck::rigid::DeckPose;
use touchdown_sim::random::Stream;
use touchdown_sim::sensors::camera::CameraSettings;
use touchdown_sim::sensors::camera::errors::{MODES, Modes};
use touchdown_sim::sensors::camera::view::View;
use touchdown_vision::detect::DetectorSettings;
use touchdown_vision::locate::LocatorSettings;
use touchdown_vision::pad::Pad;

/// Nodes: dense where the detector goes over from coarse to fine corners, at
/// cells of 3.3 px, and where motion begins to matter.
const CELL_PX: [f64; 15] = [
    0.9, 1.15, 1.4, 1.7, 2.1, 2.6, 3.0, 3.3, 3.36, 3.42, 3.7, 5.0, 8.0, 14.0, 28.0,
];
const MOTION_PX: [f64; 11] = [0.0, 2.0, 3.0, 4.0, 5.0, 6.5, 8.0, 10.0, 12.5, 15.0, 18.0];

/// A corner that is further off than this many standard deviations, as location
/// takes them, is wild: a mistake of the detector's, for location to find.
const WILD: f64 = 8.0;

#[derive(Clone, Copy, Default)]
struct Node {
    frames: f64,
    found: f64,
    scale: f64,
    squares: [f64; MODES],
}

fn main() {
    let argument = |i: usize, default: u64| {
        let text = std::env::args().nth(i);
        text.map_or(default, |n| n.parse().expect("a whole number"))
    };
    let (frames, seed) = (argument(1, 24_000), argument(2, 1));
    let camera = CameraSettings::default();
    let pad = Pad::default();
    let mut pipeline = Pipeline::new(&camera, &pad);
    // Around the change from coarse to fine corners, at 3.3 px, both are expected.
    let location = LocatorSettings {
        fine_cell_px: 3.4 / 0.94,
        ..LocatorSettings::default()
    };
    let placed = deck_tags(&pad);
    let mut nodes = [[[Node::default(); MOTION_PX.len()]; CELL_PX.len()]; 2];
    let (mut wild, mut all) = (0_u64, 0_u64);
    for frame in 0..frames {
        let mut stream = noise(seed, frame);
        let (open, shut) = sight(&camera, &pad, &mut stream);
        let middle = open.towards(&shut, 0.5);
        let tags = pipeline.detect(&open, &shut, &mut stream);
        for (tag, placed) in pad.tags.iter().zip(&placed) {
            let nested = usize::from(placed.nested);
            let seen = |view: &View| {
                let corners = tag
                    .corners_m()
                    .map(|place| camera.project(view.point(place)));
                let corners: Option<Vec<[f64; 2]>> = corners.into_iter().collect();
                corners.map(|c| [c[0], c[1], c[2], c[3]])
            };
            let (Some(before), Some(truth), Some(after)) =
                (seen(&open), seen(&middle), seen(&shut))
            else {
                continue;
            };
            let margin = |[u, v]: [f64; 2]| u.min(v).min(640.0 - u).min(480.0 - v);
            if truth
                .iter()
                .any(|&corner| margin(corner) < location.border_px)
            {
                continue;
            }
            let apart = |a: [f64; 2], b: [f64; 2]| (b[0] - a[0]).hypot(b[1] - a[1]);
            let sides = (0..4).map(|k| apart(truth[k], truth[(k + 1) % 4]));
            let cell = sides.sum::<f64>() / 32.0;
            let motion = (0..4)
                .map(|k| apart(before[k], after[k]))
                .fold(0.0, f64::max);
            if cell < CELL_PX[0] || motion > MOTION_PX[MOTION_PX.len() - 1] {
                continue;
            }
            let found = tags.iter().find(|found| found.id == tag.id);
            let mut sizes = [(0, 0.0); 8];
            if let Some(found) = found {
                let off: [[f64; 2]; 4] =
                    std::array::from_fn(|k| [0, 1].map(|i| found.corners_px[k][i] - truth[k][i]));
                let most = WILD * location.sd_px(8.0 * cell, motion);
                all += 1;
                if off.iter().flatten().any(|x| x.abs() > most) {
                    wild += 1;
                    continue;
                }
                sizes = Modes::of(&truth).all().map(|(mode, moves)| {
                    let size = (0..4).map(|k| off[k][0] * moves[k][0] + off[k][1] * moves[k][1]);
                    (mode, size.sum())
                });
            }
            for (i, by_cell) in near(&CELL_PX, cell, f64::ln) {
                for (j, by_motion) in near(&MOTION_PX, motion, |x| x) {
                    let node = &mut nodes[nested][i][j];
                    let weight = by_cell * by_motion;
                    node.frames += weight;
                    if found.is_some() {
                        node.found += weight;
                        for (mode, size) in sizes {
                            node.squares[mode] += weight * size * size;
                        }
                        node.scale += weight * sizes[2].1;
                    }
                }
            }
        }
    }
    let run = format!("{frames} frames, seed {seed}; {wild} of {all} tags left out as wild");
    print_tables(&nodes, &run, &camera);
}

/// Two nodes and their shares.
fn near(nodes: &[f64], x: f64, measure: impl Fn(f64) -> f64) -> [(usize, f64); 2] {
    let below = nodes.partition_point(|&node| node <= x).saturating_sub(1);
    let below = below.min(nodes.len() - 2);
    let (low, high) = (measure(nodes[below]), measure(nodes[below + 1]));
    let share = ((measure(x) - low) / (high - low)).clamp(0.0, 1.0);
    [(below, 1.0 - share), (below + 1, share)]
}

/// Views at the start and the end of an exposure in which one of the tags has
/// cells of a size, log-uniform but for a fifth between 3.1 and 3.7 px, and a
/// motion, half of them below 4 px.
fn sight(camera: &CameraSettings, pad: &Pad, stream: &mut Stream) -> (View, View) {
    // Half of them see the first tag, which is not nested.
    let index = (2.0 * stream.uniform() - 1.0) * pad.tags.len() as f64;
    let tag = &pad.tags[index.max(0.0) as usize];
    let cell = if stream.uniform() < 0.2 {
        3.1 + 0.6 * stream.uniform()
    } else {
        0.9 * (34.0_f64 / 0.9).powf(stream.uniform())
    };
    let motion = if stream.uniform() < 0.5 {
        4.0 * stream.uniform()
    } else {
        4.0 + 14.0 * stream.uniform()
    };
    let height = camera.focal_px[0] * tag.size_m / (8.0 * cell);
    let free = (0.6 * height - 0.5 * tag.size_m).clamp(0.02 * height, 0.4 * height);
    let mut symmetric = |most: f64| most * (2.0 * stream.uniform() - 1.0);
    let place = [symmetric(free), symmetric(free), height + 0.02];
    let yaw = symmetric(std::f64::consts::PI);
    let heading = symmetric(std::f64::consts::PI);
    let turning = symmetric(1.0) > 0.0;
    let tilt = [0.08 * stream.normal(), 0.08 * stream.normal()];
    // Over the whole exposure; turns about the camera's horizontal axes move
    // the image as far as places do.
    let along = [heading.cos(), heading.sin()];
    let shift = if turning {
        0.0
    } else {
        motion * height / camera.focal_px[0]
    };
    let turn = if turning {
        motion / camera.focal_px[0]
    } else {
        0.0
    };
    let at = |s: f64| {
        let place = [
            place[0] + s * shift * along[0],
            place[1] + s * shift * along[1],
            place[2],
        ];
        let angles = [
            yaw,
            tilt[0] + s * turn * along[0],
            tilt[1] + s * turn * along[1],
        ];
        View::of(camera, &vehicle(place, angles), &DeckPose::default())
    };
    (at(-0.5), at(0.5))
}

fn print_tables(
    nodes: &[[[Node; MOTION_PX.len()]; CELL_PX.len()]; 2],
    run: &str,
    camera: &CameraSettings,
) {
    println!("# Corner errors and detection of AprilTags 36h11 on rendered images, made by");
    println!("#   cargo run --release -p touchdown-vision --example fit_camera_errors");
    println!("# {run}; {:?}", DetectorSettings::default());
    println!(
        "# camera: {} x {} px, lens {} px, noise {} of white {} levels; pad: the default",
        camera.width_px, camera.height_px, camera.lens_sd_px, camera.noise_sd, camera.white_level
    );
    println!(
        "# Tags within 5 px of the border left out; wild: a corner off by more than {WILD} sd."
    );
    println!("# Hat-weighted means at the nodes; px for modes of unit length.");
    println!(
        "nested,cell_px,motion_px,found,scale_mean_px,shift_px,scale_px,turn_px,stretch_px,keystone_px"
    );
    let grids = nodes.iter().enumerate();
    let rows =
        grids.flat_map(|(nested, grid)| CELL_PX.iter().zip(grid).map(move |row| (nested, row)));
    for (nested, (cells, row)) in rows {
        // Where nothing is found, the errors of the last motion that was.
        let mut last = Node::default();
        for (motion, node) in MOTION_PX.iter().zip(row) {
            if node.found > 3.0 {
                last = *node;
            }
            let n = last.found.max(1.0);
            let mean = last.scale / n;
            // Two modes share a table but for scale and turn.
            let sd = |mode: usize, modes: f64| (last.squares[mode] / (n * modes)).sqrt();
            let scale = (last.squares[1] / n - mean * mean).max(0.0).sqrt();
            println!(
                "{nested},{cells},{motion},{:.4},{mean:.4},{:.4},{scale:.4},{:.4},{:.4},{:.4}",
                node.found / node.frames.max(1e-9),
                sd(0, 2.0),
                sd(2, 1.0),
                sd(3, 2.0),
                sd(4, 2.0),
            );
        }
    }
}
