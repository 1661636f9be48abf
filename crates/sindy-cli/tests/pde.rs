//! `sindy pde`: fields from NumPy arrays and tables, equations as text and as an object, clear errors.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use tempfile::TempDir;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use crate::common::{fails, json, says, words};

const POINTS: (usize, usize) = (60, 80);
const STEPS: (f64, f64) = (0.05, 0.1);

/// `u_t = 0.1 u_xx` exactly: two modes that decay.
fn value(i: usize, j: usize) -> f64 {
    let (t, x) = (STEPS.0 * i as f64, STEPS.1 * j as f64);
    (-0.1 * t).exp() * x.sin() + (-0.4 * t).exp() * (2.0 * x).cos()
}

/// An array as NumPy writes it.
fn npy(shape: &[usize], values: impl Iterator<Item = f64>) -> Vec<u8> {
    let shape: Vec<String> = shape.iter().map(|n| format!("{n},")).collect();
    let header = format!(
        "{{'descr': '<f8', 'fortran_order': False, 'shape': ({}), }}\n",
        shape.join(" ")
    );
    let mut out = b"\x93NUMPY\x01\x00".to_vec();
    out.extend((header.len() as u16).to_le_bytes());
    out.extend(header.as_bytes());
    values.for_each(|v| out.extend(v.to_le_bytes()));
    out
}

fn archive(path: &Path, arrays: &[(&str, Vec<u8>)]) {
    let mut zip = ZipWriter::new(fs::File::create(path).unwrap());
    for (name, bytes) in arrays {
        let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
        zip.start_file(format!("{name}.npy"), options).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap();
}

/// The field as an archive, time first or last, in a folder of its own.
fn field(time_first: bool) -> (TempDir, PathBuf) {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("heat.npz");
    let (n, m) = POINTS;
    let u = match time_first {
        true => npy(&[n, m], (0..n * m).map(|k| value(k / m, k % m))),
        false => npy(&[m, n], (0..n * m).map(|k| value(k % n, k / n))),
    };
    let axis = |n: usize, step: f64| npy(&[n], (0..n).map(move |i| step * i as f64));
    archive(
        &path,
        &[("t", axis(n, STEPS.0)), ("x", axis(m, STEPS.1)), ("u", u)],
    );
    (folder, path)
}

#[test]
fn analytic_the_heat_equation_is_found_in_every_format() {
    let (folder, npz) = field(true);
    let (_other, turned) = field(false);
    let (n, m) = POINTS;
    let plain = folder.path().join("heat.npy");
    fs::write(
        &plain,
        npy(&[n, m], (0..n * m).map(|k| value(k / m, k % m))),
    )
    .unwrap();
    let table = folder.path().join("heat.csv");
    let mut text = "x (m),t [s],u\n".to_owned();
    // Any order of the rows; and one of them missing.
    for k in (0..n * m).rev().filter(|k| *k != 77) {
        let (i, j) = (k % n, k / n);
        text += &format!(
            "{},{},{}\n",
            STEPS.1 * j as f64,
            STEPS.0 * i as f64,
            value(i, j)
        );
    }
    fs::write(&table, text).unwrap();
    for (command, path) in [
        ("pde {}", &npz),
        ("pde {} --axes x,t", &turned),
        ("pde {} --spacing t=0.05,x=0.1", &plain),
        ("pde {}", &table),
    ] {
        let found = json(0, &words(command, &[path]));
        let terms = found["equations"]["u"].as_array().unwrap();
        assert_eq!(
            (terms.len(), terms[0]["term"].as_str()),
            (1, Some("u_xx")),
            "{command}: {found}"
        );
        // No noise: the digits that sums lose.
        assert!((terms[0]["coefficient"].as_f64().unwrap() - 0.1).abs() < 1e-7);
        assert_eq!(found["data"][0]["points"]["t"], 60);
        let warnings = found["warnings"].as_array().unwrap();
        let filled = "1 of 4800 samples are missing";
        match *path == table {
            true => assert!(warnings[0].as_str().unwrap().starts_with(filled), "{found}"),
            false => assert!(warnings.is_empty(), "{found}"),
        }
    }
    let page = folder.path().join("heat.html");
    let said = says(&words("pde {} --figure {}", &[&npz, &page]));
    assert!(said.starts_with("u_t = 0.10000*u_xx\n"), "{said}");
    assert!(fs::read_to_string(&page).unwrap().contains("u_xx"));
    // Other windows, other candidates, two files.
    let command = "pde {} {} --term u_x --term u_xx --half-width t=1,x=2";
    let later = folder.path().join("later.npz");
    let u = npy(&[n, m], (0..n * m).map(|k| value(k / m + n, k % m)));
    let axis = |n: usize, step: f64| npy(&[n], (0..n).map(move |i| step * i as f64));
    // Texts beside the fields do not matter.
    let note =
        b"\x93NUMPY\x01\x00\x36\x00{'descr': '<U1', 'fortran_order': False, 'shape': (), }\nabcd"
            .to_vec();
    archive(
        &later,
        &[
            ("note", note),
            ("t", axis(n, STEPS.0)),
            ("x", axis(m, STEPS.1)),
            ("u", u),
        ],
    );
    let found = json(0, &words(command, &[&npz, &later]));
    assert_eq!(found["data"][1]["half_widths"]["t"], 1.0);
    assert_eq!(found["text"][0], "u_t = 0.10000*u_xx");
}

#[test]
fn prop_fields_that_cannot_be_used_are_refused_by_name() {
    let (folder, npz) = field(true);
    let path = |name: &str| folder.path().join(name);
    let whole = fs::read(&npz).unwrap();
    fs::write(path("cut.npz"), &whole[..whole.len() / 2]).unwrap();
    let huge = npy(&[1 << 40, 1 << 40], [1.0].into_iter());
    archive(&path("huge.npz"), &[("u", huge)]);
    archive(
        &path("large.npz"),
        &[("u", npy(&[1 << 20, 1 << 20], [1.0].into_iter()))],
    );
    fs::write(path("plain.npy"), npy(&[4, 4], (0..16).map(|_| 1.0))).unwrap();
    fs::write(
        path("twice.csv"),
        "t,x,u\n0,0,1\n0,1,1\n0,0,2\n1,0,1\n1,1,1\n",
    )
    .unwrap();
    fs::write(
        path("list.csv"),
        "t,x,u\n0,0,1\n1,1,2\n2,2,2\n3,3,3\n4,4,4\n",
    )
    .unwrap();
    let uneven = [0.0, 1.0, 3.0].into_iter();
    let u = npy(&[3, 3], (0..9).map(f64::from));
    let axis = || npy(&[3], (0..3).map(f64::from));
    archive(
        &path("uneven.npz"),
        &[("t", axis()), ("x", npy(&[3], uneven)), ("u", u)],
    );
    for (command, name, status, expected) in [
        (
            "pde {} --axes x,t",
            "heat.npz",
            2,
            "found [60, 80]; --axes gives the order",
        ),
        ("pde {} --fields w", "heat.npz", 2, "expected an array `w`"),
        (
            "pde {} --axes x",
            "heat.npz",
            2,
            "the axis of time `t` among them",
        ),
        (
            "pde {} --term u_y",
            "heat.npz",
            2,
            "derivatives by x, found `y`",
        ),
        (
            "pde {} --spacing X=1",
            "heat.npz",
            2,
            "one of the axes t, x, found `X`",
        ),
        (
            "pde {} --term u*u_x",
            "heat.npz",
            2,
            "a derivative of a product",
        ),
        (
            "pde {} --half-width t=1",
            "heat.npz",
            2,
            "a number for the axis `x`",
        ),
        ("pde {}", "plain.npy", 2, "--spacing t=STEP"),
        (
            "pde {} --fields u,v --spacing t=1,x=1",
            "plain.npy",
            2,
            "one name for the array",
        ),
        (
            "pde {} --spacing t=1,x=1",
            "plain.npy",
            2,
            "at least 9, found 4",
        ),
        ("pde {}", "cut.npz", 1, "cut.npz"),
        ("pde {}", "huge.npz", 2, "of a shape that can be counted"),
        ("pde {}", "large.npz", 2, "expected an array of shape"),
        ("pde {}", "uneven.npz", 2, "even steps"),
        ("pde {}", "twice.csv", 2, "a second one for the same point"),
        ("pde {}", "list.csv", 2, "expected a grid"),
        ("pde {}", "none.npz", 1, "none.npz"),
    ] {
        let said = fails(status, &words(command, &[&path(name)]));
        assert!(said.contains(expected), "{command} {name}: {said}");
    }
    for (figure, expected) in [("heat.npz", "one of the inputs"), ("heat.txt", ".html")] {
        let said = fails(2, &words("pde {} --figure {}", &[&npz, &path(figure)]));
        assert!(said.contains(expected), "{said}");
    }
    let said = fails(2, &words("pde {} {}", &[&npz, &npz]));
    assert!(said.contains("number 2 again"), "{said}");
    let said = fails(2, &words("fit {} --states u", &[&npz]));
    assert!(said.contains("`sindy pde`"), "{said}");
    assert_eq!(fs::read(&npz).unwrap(), whole);
}
