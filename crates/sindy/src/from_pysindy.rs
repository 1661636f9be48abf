#![doc = include_str!("../docs/from_pysindy.md")]
