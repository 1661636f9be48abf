//! Fields from files: NumPy arrays, or tables with a row for each point.

use std::fs::File;
use std::io::{BufReader, Cursor, Read};
use std::path::Path;

use sindy::pde::{Axis, FieldData};
use touchdown_log::Findings;
use zip::ZipArchive;

use super::args::PdeArgs;
use crate::error::{Error, Result};
use crate::table::{Format, NpyArray, Table};

/// Numbers in the arrays of a file at most: 1.6 GB.
const MOST_POINTS: u64 = 200_000_000;

/// Reads the fields of a file.
pub(super) fn field(path: &Path, args: &PdeArgs) -> Result<(FieldData, Findings)> {
    if !args.axes.contains(&args.time) {
        return Err(Error::Arguments(format!(
            "--axes: expected the axis of time `{}` among them (--time names another), found {}",
            args.time,
            args.axes.join(", ")
        )));
    }
    match Format::of(path)? {
        Format::Zip => Ok((
            of_arrays(path, args, &archive(path, args)?)?,
            Findings::default(),
        )),
        Format::Npy => {
            let name = match &args.fields[..] {
                [] => "u".to_owned(),
                [one] => one.clone(),
                many => {
                    return Err(Error::Arguments(format!(
                        "--fields: expected one name for the array of a .npy, found {}",
                        many.join(", ")
                    )));
                }
            };
            let file = File::open(path).map_err(|e| Error::file(path, e))?;
            let length = file.metadata().map_err(|e| Error::file(path, e))?.len();
            let array = NpyArray::read(BufReader::new(file), path, length)?;
            Ok((
                of_arrays(path, args, &[(name, array)])?,
                Findings::default(),
            ))
        }
        Format::Text | Format::Parquet => of_table(path, args),
    }
}

/// The arrays of an archive that `numpy.savez` wrote: those that are named, or all that hold numbers.
fn archive(path: &Path, args: &PdeArgs) -> Result<Vec<(String, NpyArray)>> {
    let fault = |e: zip::result::ZipError| Error::file(path, std::io::Error::other(e));
    let file = File::open(path).map_err(|e| Error::file(path, e))?;
    let mut archive = ZipArchive::new(BufReader::new(file)).map_err(fault)?;
    let mut out = Vec::new();
    let mut left = 8 * MOST_POINTS;
    let mut fault_of_other = None;
    for i in 0..archive.len() {
        let entry = archive.by_index(i).map_err(fault)?;
        let name = entry.name().map_err(fault)?;
        let Some(name) = name.strip_suffix(".npy").map(str::to_owned) else {
            continue;
        };
        let named = args.axes.contains(&name) || args.fields.contains(&name);
        if !named && !args.fields.is_empty() {
            continue;
        }
        // What an entry says of its size is not believed: so many bytes are read at most, of all entries together.
        let mut bytes = Vec::new();
        let read = entry.take(left).read_to_end(&mut bytes);
        let length = read.map_err(|e| Error::file(path, e))? as u64;
        if length == left {
            return Err(too_many(path, &name));
        }
        left -= length;
        match NpyArray::read(Cursor::new(bytes), path, length) {
            Ok(array) => out.push((name, array)),
            Err(error) if named => return Err(error),
            // Texts and objects beside the fields do not matter.
            Err(error) => fault_of_other = Some(error),
        }
    }
    let has_field = out.iter().any(|(name, _)| !args.axes.contains(name));
    match fault_of_other {
        Some(error) if !has_field => Err(error),
        _ => Ok(out),
    }
}

fn too_many(path: &Path, name: &str) -> Error {
    let found = format!("`{name}` with more");
    let at = path.display().to_string();
    Error::data(
        at,
        format!("at most {MOST_POINTS} numbers in all arrays"),
        found,
    )
}

/// The place of time among the axes, and the axes of space.
fn order(args: &PdeArgs) -> Vec<usize> {
    let time = args.axes.iter().position(|a| *a == args.time).unwrap_or(0);
    let space = (0..args.axes.len()).filter(|a| *a != time);
    [time].into_iter().chain(space).collect()
}

fn of_arrays(path: &Path, args: &PdeArgs, arrays: &[(String, NpyArray)]) -> Result<FieldData> {
    let at = || path.display().to_string();
    let find = |name: &String| arrays.iter().find(|(n, _)| n == name).map(|(_, a)| a);
    let names: Vec<String> = match args.fields.is_empty() {
        true => {
            let free = arrays.iter().filter(|(n, _)| !args.axes.contains(n));
            let fields = free.filter(|(_, a)| a.shape.len() == args.axes.len());
            fields.map(|(n, _)| n.clone()).collect()
        }
        false => args.fields.clone(),
    };
    let shapes = || {
        let shown = arrays.iter().map(|(n, a)| format!("{n} {:?}", a.shape));
        shown.collect::<Vec<_>>().join(", ")
    };
    let expected = |name: &str| {
        format!(
            "an array `{name}` with the axes {} (--axes, --fields)",
            args.axes.join(", ")
        )
    };
    let Some(first) = names.first() else {
        return Err(Error::data(at(), expected("u"), shapes()));
    };
    let first = find(first).ok_or_else(|| Error::data(at(), expected(first), shapes()))?;
    let axes = args.axes.iter().enumerate().map(|(place, name)| {
        let length = first.shape.get(place).copied().unwrap_or(0);
        if let Ok(step) = given(&args.spacing, name, "--spacing") {
            return Axis::even(name, step, length).map_err(Error::refused(at()));
        }
        let coordinates = find(name).ok_or_else(|| {
            let expected = format!("an array `{name}` of coordinates, or --spacing {name}=STEP");
            Error::data(at(), expected, shapes())
        })?;
        Axis::new(name, &coordinates.values).map_err(Error::refused(at()))
    });
    let axes = axes.collect::<Result<Vec<Axis>>>()?;
    let lengths: Vec<usize> = axes.iter().map(Axis::points).collect();
    let order = order(args);
    let mut fields = Vec::new();
    for name in names {
        let array = find(&name).ok_or_else(|| Error::data(at(), expected(&name), shapes()))?;
        if array.shape != lengths {
            let expected = format!(
                "`{name}` with {lengths:?} points along {}",
                args.axes.join(", ")
            );
            let found = format!(
                "{:?}; --axes gives the order of the array's axes",
                array.shape
            );
            return Err(Error::data(at(), expected, found));
        }
        fields.push((name, transposed(&array.values, &lengths, &order)));
    }
    let axes = order.iter().map(|&a| axes[a].clone()).collect();
    FieldData::new(axes, fields).map_err(Error::refused(at()))
}

/// An array in the order of C with its axes in another order.
fn transposed(values: &[f64], lengths: &[usize], order: &[usize]) -> Vec<f64> {
    if order.is_sorted() {
        return values.to_vec();
    }
    let stride = |axis: usize| lengths[axis + 1..].iter().product::<usize>();
    let strides: Vec<usize> = order.iter().map(|&a| stride(a)).collect();
    let lengths: Vec<usize> = order.iter().map(|&a| lengths[a]).collect();
    let mut out = Vec::with_capacity(values.len());
    let mut place = vec![0; order.len()];
    for _ in 0..values.len() {
        out.push(
            values[place
                .iter()
                .zip(&strides)
                .map(|(p, s)| p * s)
                .sum::<usize>()],
        );
        for axis in (0..order.len()).rev() {
            place[axis] += 1;
            if place[axis] < lengths[axis] {
                break;
            }
            place[axis] = 0;
        }
    }
    out
}

/// The number that an argument gives for an axis.
pub(super) fn given(all: &[(String, f64)], axis: &str, argument: &str) -> Result<f64> {
    let found = all.iter().find(|(name, _)| name == axis);
    found.map(|(_, value)| *value).ok_or_else(|| {
        let names: Vec<&str> = all.iter().map(|(name, _)| name.as_str()).collect();
        Error::Arguments(format!(
            "{argument}: expected a number for the axis `{axis}`, found those of {}",
            names.join(", ")
        ))
    })
}

/// A table with a column for each axis and field.
fn of_table(path: &Path, args: &PdeArgs) -> Result<(FieldData, Findings)> {
    let at = || path.display().to_string();
    let table = Table::open(path, &[])?;
    let names: Vec<String> = match args.fields.is_empty() {
        true => {
            let bare = |n: &String| crate::table::without_unit(n).unwrap_or(n).to_owned();
            let all = table.names().iter().map(bare);
            all.filter(|n| !args.axes.contains(n)).collect()
        }
        false => args.fields.clone(),
    };
    let order = order(args);
    let mut places = Vec::new();
    for &axis in &order {
        places.push(table.find(&args.axes[axis], "--axes")?);
    }
    for name in &names {
        places.push(table.find(name, "--fields")?);
    }
    let columns = table.numbers(&places)?;
    let (coordinates, values) = columns.split_at(order.len());
    let rows = coordinates[0].len();
    let mut axes = Vec::new();
    let mut at_point = vec![0_usize; rows];
    let mut points = 1_usize;
    for (&axis, column) in order.iter().zip(coordinates) {
        let name = &args.axes[axis];
        if let Some(row) = column.iter().position(|v| !v.is_finite()) {
            return Err(Error::data(table.place(row, name), "a coordinate", "none"));
        }
        let mut distinct = column.clone();
        distinct.sort_by(f64::total_cmp);
        distinct.dedup();
        points = points.saturating_mul(distinct.len());
        // Points that are missing have no row; a table that is no grid has far more of them than rows.
        if points > rows.saturating_mul(4) {
            let expected = "a grid: a row for (nearly) each point of time and space";
            let found = format!("{rows} rows and at least {points} points");
            return Err(Error::data(at(), expected, found));
        }
        for (place, value) in at_point.iter_mut().zip(column) {
            *place = *place * distinct.len() + distinct.partition_point(|d| d < value);
        }
        axes.push(Axis::new(name, &distinct).map_err(Error::refused(at()))?);
    }
    let mut taken = vec![false; points];
    for (row, &place) in at_point.iter().enumerate() {
        if std::mem::replace(&mut taken[place], true) {
            let found = "a second one for the same point";
            return Err(Error::data(
                table.place(row, &args.time),
                "one row for each point",
                found,
            ));
        }
    }
    let fields = names.into_iter().zip(values).map(|(name, column)| {
        let mut field = vec![f64::NAN; points];
        at_point
            .iter()
            .zip(column)
            .for_each(|(&place, v)| field[place] = *v);
        (name, field)
    });
    let data = FieldData::new(axes, fields.collect()).map_err(Error::refused(at()))?;
    Ok((data, table.findings))
}
