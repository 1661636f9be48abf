//! Reading of files that NumPy and pyarrow wrote (`tests/data/make.py`).

use std::path::{Path, PathBuf};

use super::{Table, without_unit};

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data")
        .join(name)
}

fn open(name: &str, columns: &[&str]) -> Result<Table, String> {
    let columns: Vec<String> = columns.iter().map(ToString::to_string).collect();
    Table::open(&data(name), &columns).map_err(|e| e.to_string())
}

fn column(table: &Table, name: &str) -> Vec<f64> {
    let place = table.find(name, "a test").unwrap();
    table.numbers(&[place]).unwrap().remove(0)
}

/// The rows that every fixture holds.
fn truth() -> [Vec<f64>; 3] {
    let t: Vec<f64> = (0..12).map(|i| 0.25 * f64::from(i)).collect();
    let x = t.iter().map(|t| (-t).exp()).collect();
    let y = t.iter().map(|t| t.sin()).collect();
    [t, x, y]
}

#[track_caller]
fn close(found: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(found.len(), expected.len());
    for (a, b) in found.iter().zip(expected) {
        assert!((a - b).abs() <= tolerance, "{found:?}");
    }
}

#[test]
fn xval_arrays_written_by_numpy() {
    let [t, x, y] = truth();
    // exp and sin of two libraries may differ in the last place; float32 keeps 24 bits.
    for (file, tolerance) in [
        ("c_order.npy", 1e-15),
        ("fortran_order.npy", 1e-15),
        ("big_endian.npy", 1e-15),
        ("float32.npy", 2e-7),
    ] {
        let table = open(file, &["t", "x", "y"]).unwrap();
        assert_eq!(table.rows(), 12);
        close(&column(&table, "t"), &t, 0.0);
        close(&column(&table, "x"), &x, tolerance);
        close(&column(&table, "y"), &y, tolerance);
    }
    let table = open("integers.npy", &["t", "x", "y"]).unwrap();
    let thousands: Vec<f64> = x.iter().map(|x| (1000.0 * x).round()).collect();
    close(&column(&table, "x"), &thousands, 0.0);
    close(
        &column(&open("one_dimension.npy", &["x"]).unwrap(), "x"),
        &x,
        1e-15,
    );
}

#[test]
fn prop_arrays_that_do_not_fit_are_refused() {
    let refused = |name: &str, columns: &[&str]| open(name, columns).err().unwrap();
    let teaches = refused("c_order.npy", &[]);
    assert!(
        teaches.contains("12 rows by 3 columns") && teaches.contains("--columns"),
        "{teaches}"
    );
    assert!(refused("c_order.npy", &["t", "x"]).contains("2 names"));
    assert!(refused("cube.npy", &["a"]).contains("[2, 3, 4]"));
    let complex = refused("complex.npy", &["t", "x", "y"]);
    assert!(complex.contains("'<c16'"), "{complex}");
}

#[test]
fn prop_broken_arrays_and_parquet_files_are_errors() {
    let folder = tempfile::tempdir().unwrap();
    let names: Vec<String> = ["t", "x", "y"].map(String::from).to_vec();
    for file in ["c_order.npy", "kinds.parquet"] {
        let whole = std::fs::read(data(file)).unwrap();
        for cut in [7, 9, whole.len() / 2, whole.len() - 1] {
            let path = folder.path().join(file);
            std::fs::write(&path, &whole[..cut]).unwrap();
            let read = Table::open(&path, &names).and_then(|t| t.numbers(&[1]));
            assert!(read.is_err(), "{file} cut after {cut} bytes");
        }
    }
    // A header that promises what no memory holds.
    let path = folder.path().join("large.npy");
    let whole = std::fs::read(data("c_order.npy")).unwrap();
    let header = String::from_utf8_lossy(&whole[10..128]).into_owned();
    let larger = header.replacen("(12, 3), }      ", "(999999999, 3), }", 1);
    let mut bytes = whole[..10].to_vec();
    bytes.extend_from_slice(&larger.as_bytes()[..118]);
    bytes.extend_from_slice(&whole[128..]);
    std::fs::write(&path, bytes).unwrap();
    let error = Table::open(&path, &names).err().unwrap().to_string();
    assert!(error.contains("999999999 rows by 3 columns"), "{error}");
}

#[test]
fn xval_parquet_written_by_pyarrow() {
    let [t, x, y] = truth();
    let table = open("kinds.parquet", &[]).unwrap();
    assert_eq!(table.rows(), 12);
    assert!(
        !table.names().contains(&"list".to_owned()),
        "nested columns are no columns"
    );
    close(&column(&table, "t"), &t, 0.0);
    // Stamps of 250 ms are exact in nanoseconds.
    close(&column(&table, "stamp"), &t, 0.0);
    let found = column(&table, "x");
    assert!(found[5].is_nan(), "a null is a gap");
    let without = |v: &[f64]| [&v[..5], &v[6..]].concat();
    close(&without(&found), &without(&x), 1e-15);
    close(&column(&table, "y"), &y, 1e-7);
    let count: Vec<f64> = (0..12).map(f64::from).collect();
    close(&column(&table, "count"), &count, 0.0);
    assert_eq!(column(&table, "on")[..2], [1.0, 0.0]);
    let labels = |name: &str| table.labels(table.find(name, "a test").unwrap()).unwrap();
    assert_eq!(labels("run")[4..8], ["first", "first", "second", "second"]);
    assert_eq!(labels("count")[10..], ["10", "11"]);
    for name in ["run", "day"] {
        let place = table.find(name, "a test").unwrap();
        let error = table.numbers(&[place]).unwrap_err().to_string();
        assert!(
            error.contains(&format!("column `{name}`: expected numbers")),
            "{error}"
        );
    }
}

#[test]
fn xval_every_codec_of_parquet() {
    let [t, ..] = truth();
    for codec in ["zstd", "gzip", "lz4", "none"] {
        let table = open(&format!("{codec}.parquet"), &[]).unwrap();
        close(&column(&table, "t"), &t, 0.0);
    }
}

#[test]
fn analytic_columns_are_found_with_their_units() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("units.csv");
    std::fs::write(
        &path,
        "time (s),x [m],v (m/s),v (km/h)\n0,1,2,7.2\n1,3,4,14.4\n",
    )
    .unwrap();
    let table = Table::open(&path, &[]).unwrap();
    assert_eq!(column(&table, "x"), [1.0, 3.0]);
    assert_eq!(column(&table, "v (m/s)"), [2.0, 4.0]);
    let ambiguous = table.find("v", "--states").unwrap_err().to_string();
    assert!(ambiguous.contains("`v` (--states)"), "{ambiguous}");
    let case = table.find("X [m]", "--states").unwrap_err().to_string();
    assert!(case.contains("did you mean `x [m]`?"), "{case}");
}

#[test]
fn analytic_units_behind_names() {
    assert_eq!(without_unit("x (m)"), Some("x"));
    assert_eq!(without_unit("v_z [m/s]"), Some("v_z"));
    for name in ["x", "(m)", "", "x)"] {
        assert_eq!(without_unit(name), None);
    }
}
