//! A Parquet file of any bytes is a table or an error.
#![no_main]

use libfuzzer_sys::fuzz_target;
use touchdown_log::read_parquet;

fuzz_target!(|bytes: &[u8]| {
    let path = std::env::temp_dir().join(format!("touchdown-fuzz-{}.parquet", std::process::id()));
    std::fs::write(&path, bytes).unwrap();
    if let Ok((table, findings)) = read_parquet(&path, None) {
        assert_eq!(table.len(), findings.rows_used);
    }
});
