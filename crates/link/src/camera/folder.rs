//! A folder of images: their order and their times.
//!
//! Images are taken in the order of their names. Their times are either their names without the ending, in seconds
//! (`0012.345.png`), or stand in a CSV file with the columns `file` and `time_s`. Times count from any beginning.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::files::EXTENSIONS;
use super::stream::seconds_to_us;

/// Where the times of the images stand.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(from = "String", into = "String")]
pub enum Times {
    /// In their names.
    Names,
    /// In a CSV file in the folder.
    Table(String),
}

/// The setting for times in names.
const NAMES: &str = "names";

impl From<String> for Times {
    fn from(text: String) -> Self {
        if text == NAMES {
            Self::Names
        } else {
            Self::Table(text)
        }
    }
}

impl From<Times> for String {
    fn from(times: Times) -> Self {
        match times {
            Times::Names => NAMES.to_string(),
            Times::Table(file) => file,
        }
    }
}

/// An image and its time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TimedImage {
    /// Its name in the folder.
    pub name: String,
    /// Time since the first image, µs.
    pub time_us: i64,
}

/// The images among the names of a folder, in their order, with the times of a table's text or of their names.
///
/// # Errors
/// No image; an image without a time, or one that is not later than the one before; a table without its columns.
pub fn images(names: &[String], table: Option<&str>) -> Result<Vec<TimedImage>, String> {
    let table = table.map(rows).transpose()?;
    let mut names: Vec<&String> = names.iter().filter(|name| is_image(name)).collect();
    names.sort();
    let mut images: Vec<TimedImage> = Vec::with_capacity(names.len());
    let mut first_us = None;
    for name in names {
        let time_us = match &table {
            Some(table) => *table.get(name.as_str()).ok_or_else(|| {
                format!("expected a time for every image, found none for `{name}`")
            })?,
            None => time_of(name).ok_or_else(|| {
                format!(
                    "expected names that are times in seconds, as `0012.345.png`, found `{name}`"
                )
            })?,
        };
        let time_us = time_us - *first_us.get_or_insert(time_us);
        if let Some(before) = images.last().filter(|before| before.time_us >= time_us) {
            return Err(format!(
                "expected times that increase with the names, found `{name}` no later than `{}`",
                before.name
            ));
        }
        images.push(TimedImage {
            name: name.clone(),
            time_us,
        });
    }
    if images.is_empty() {
        return Err(format!(
            "expected images ({}), found none",
            EXTENSIONS.join(", ")
        ));
    }
    Ok(images)
}

fn is_image(name: &str) -> bool {
    let end = name
        .rsplit_once('.')
        .map(|(_, end)| end.to_ascii_lowercase());
    end.is_some_and(|end| EXTENSIONS.contains(&end.as_str()))
}

fn time_of(name: &str) -> Option<i64> {
    seconds_to_us(name.rsplit_once('.')?.0)
}

/// The rows of a table of times.
fn rows(text: &str) -> Result<BTreeMap<&str, i64>, String> {
    let mut lines = text.lines().enumerate();
    let head = lines
        .next()
        .map_or("", |(_, line)| line.trim_start_matches('\u{feff}'));
    let column = |name: &str| {
        let place = head.split(',').position(|column| column.trim() == name);
        place.ok_or_else(|| format!("expected the columns `file` and `time_s`, found `{head}`"))
    };
    let (file, time) = (column("file")?, column("time_s")?);
    let mut rows = BTreeMap::new();
    for (number, line) in lines.filter(|(_, line)| !line.trim().is_empty()) {
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        let row = cells.get(file).zip(cells.get(time));
        let row = row.and_then(|(file, time)| Some((*file, seconds_to_us(time)?)));
        let (file, time_us) = row.ok_or_else(|| {
            format!(
                "line {}: expected a file and a time in seconds, found `{line}`",
                number + 1
            )
        })?;
        if rows.insert(file, time_us).is_some() {
            return Err(format!(
                "line {}: expected each file once, found `{file}` again",
                number + 1
            ));
        }
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(names: &[&str]) -> Vec<String> {
        names.iter().map(|name| (*name).to_string()).collect()
    }

    #[test]
    fn analytic_times_stand_in_names_or_in_a_table_and_count_from_the_first() {
        let found = images(
            &names(&["12.50.png", "times.csv", "12.25.PNG", "notes"]),
            None,
        )
        .unwrap();
        let expected = |names: [&str; 2]| {
            let image = |(name, time_us): (&str, i64)| TimedImage {
                name: name.to_string(),
                time_us,
            };
            names
                .into_iter()
                .zip([0, 250_000])
                .map(image)
                .collect::<Vec<_>>()
        };
        assert_eq!(found, expected(["12.25.PNG", "12.50.png"]));
        let table = "\u{feff}time_s, file, note\n100.5,b.pgm,\n\n100.25,a.jpeg,first\n";
        let found = images(&names(&["b.pgm", "a.jpeg"]), Some(table)).unwrap();
        assert_eq!(found, expected(["a.jpeg", "b.pgm"]));
    }

    #[test]
    fn prop_folders_without_images_or_times_are_refused_in_one_sentence() {
        let refused = |list: &[&str], table: Option<&str>| images(&names(list), table).unwrap_err();
        assert!(refused(&["a.txt"], None).contains("found none"));
        assert!(refused(&["frame1.png"], None).contains("`frame1.png`"));
        assert!(refused(&["nan.png"], None).contains("`nan.png`"));
        assert!(refused(&["1.0.png", "1.00.png"], None).contains("no later than `1.0.png`"));
        // Names are sorted as text.
        assert!(refused(&["9.0.png", "10.0.png"], None).contains("`9.0.png` no later"));
        let list = &["a.png"];
        assert!(refused(list, Some("")).contains("columns"));
        assert!(refused(list, Some("file,t\na.png,1\n")).contains("`file,t`"));
        assert!(refused(list, Some("file,time_s\nb.png,1\n")).contains("`a.png`"));
        assert!(refused(list, Some("file,time_s\na.png,x\n")).contains("line 2"));
        assert!(refused(list, Some("file,time_s\na.png\n")).contains("line 2"));
        assert!(refused(list, Some("file,time_s\na.png,1\na.png,2\n")).contains("line 3"));
    }
}
