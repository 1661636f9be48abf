//! Campaigns: landings in space over grids and random draws of any setting.
//!
//! A campaign is a list of landings in a fixed order: point by point of the grid, trial by trial. A landing is a
//! pure function of the settings and its place in the list; trial k has the same seed, and the same draws, at every
//! point, so that points are compared in the same air. The list is cut into blocks of a fixed length. A block is one
//! Parquet file, written whole or not at all, so that any number of threads, any split into shards and any
//! interruption give the same bytes.
//!
//! | module | what it holds |
//! | --- | --- |
//! | `settings` | the sweep file |
//! | `axes`, `keys`, `draw` | what is varied: dotted keys, distributions |
//! | `redraw` | draws of vehicles that do not lift themselves |
//! | `points`, `recent` | a checked sweep: points, draws, landers and those that trials share |
//! | `beside` | the files that stand beside a sweep |
//! | `row`, `endings`, `seal`, `store` | landings as rows, how they ended, blocks as files and what tells a changed one, merging |
//! | `packed` | a sweep and landings of it as bytes, for another process |
//! | `air` | the wind of the points beside the airspeeds in which the vehicle can land |
//! | `noise` | the noise of the sensors beside the belief of the landing computer |
//! | `deck_warnings` | seas that are steeper than waves can be, heaves that exceed gravity |
//! | `part` | which blocks one run flies: all, a shard, a range |
//! | `status` | what of a campaign is there |
//! | `run` | flying what is missing, in the simulation or by another backend |
//! | `policy` | which landings a learned policy flies |
//! | `vehicle`, `stated` | the vehicle of `[vehicle]` and the cards, and the keys that the file states itself |
//! | `software_in_the_loop` | settings of an autopilot in the loop |
//! | `summary`, `names`, `point_table` | figures of every point, and what it is called |

mod air;
mod axes;
mod beside;
mod check;
mod deck_warnings;
mod draw;
mod endings;
mod keys;
mod names;
mod noise;
mod packed;
mod part;
mod point_table;
mod points;
mod policy;
mod recent;
mod redraw;
mod row;
mod run;
mod seal;
mod settings;
mod software_in_the_loop;
mod stated;
mod status;
mod store;
mod summary;
mod vehicle;

pub use crate::measured_deck::{SERIES, SeriesSettings};
pub use draw::Distribution;
pub use endings::counted;
pub use packed::{pack, unpack};
pub use part::{BlockRange, CampaignPart, Shard};
pub use points::Sweep;
pub use row::number;
pub use row::{LandingRow, text};
pub use run::{LandingBackend, MissingBlocks, Simulation, fly, missing, replay, rows};
pub use settings::SweepSettings;
pub use software_in_the_loop::{AutopilotProgram, CompanionSource, LoopSettings};
pub use stated::StatedKeys;
pub use status::{BrokenBlock, CampaignStatus, status};
pub use store::{SWEEP, Store, merge, must_not_be_a_campaign};
pub use summary::{
    CampaignResults, Figures, PointFigures, PointOf, SampleSummary, WorstLanding, summarise,
};
