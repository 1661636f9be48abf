//! The tests in one program: what they share is compiled once.

mod bad_logs;
mod bench_tables;
mod common;
mod defects;
mod inspection;
mod logs_xval;
mod maps;
#[path = "common/mcap.rs"]
mod mcap;
mod odd_logs;
mod reader;
mod real_data;
mod recordings;
mod ros_maps;
mod roundtrip;
mod suggested_time;
mod suggestions;
mod valid;
