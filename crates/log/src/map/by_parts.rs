//! The channels of a map while a table is read part by part: of its columns none is held.

use super::Map;
use super::apply::{MappedFile, trial_of};
use super::evaluate::{evaluate, is_known};
use super::resolve::Resolved;
use super::rows::{Rows as _, TableRows};
use crate::tables::{SPARE, TablePart};
use crate::{Findings, LogError, Table, limits};
use std::collections::BTreeSet;
use touchdown_trial::Trial;

/// The channels of the parts so far.
pub(crate) struct MappedParts<'a> {
    map: &'a Map,
    path: String,
    /// Size of the file.
    bytes: u64,
    /// Size of the file over that of its first part, for the number of rows.
    parts: f64,
    /// Names of all columns so far.
    names: Vec<String>,
    /// The map as it was resolved with the first part, and its names that are columns of numbers there.
    first: Option<(Resolved, BTreeSet<&'a str>)>,
    /// Channels, then the row filter.
    channels: Vec<(String, Vec<f64>)>,
    rows: usize,
    /// Why no further part is evaluated.
    end: Option<End>,
}

enum End {
    /// The channels would take too much memory.
    Excess,
    /// A column of the first part became one of text, or the other way round: another map would be resolved.
    OtherColumns,
    Error(LogError),
}

impl<'a> MappedParts<'a> {
    pub(crate) fn new(map: &'a Map, path: &str, bytes: u64, parts: f64) -> Self {
        Self {
            map,
            path: path.to_owned(),
            bytes,
            parts,
            names: Vec::new(),
            first: None,
            channels: Vec::new(),
            rows: 0,
            end: None,
        }
    }

    /// Evaluates the map over the rows of the next part.
    pub(crate) fn add(&mut self, part: TablePart) {
        self.rows += part.row_numbers.len();
        for (at, column) in part.columns.iter().enumerate() {
            if self.names.get(at) != Some(&column.name) && !self.names.contains(&column.name) {
                self.names.push(column.name.clone());
            }
        }
        if matches!(self.end, Some(End::OtherColumns)) {
            return;
        }
        let table = Table {
            path: self.path.clone(),
            sha256: String::new(),
            bytes: self.bytes,
            row_numbers: part.row_numbers,
            columns: part.columns,
            names: self.names.clone(),
        };
        self.end = self.evaluate(&table).err().or(self.end.take());
        if self.end.is_some() {
            self.channels = Vec::new();
        }
    }

    fn evaluate(&mut self, table: &Table) -> Result<(), End> {
        let mut rows = TableRows::new(table);
        let map = self.map;
        let known = |name: &str| is_known(map, name) || rows.place(name).is_some();
        let names: BTreeSet<&str> = map.names().into_iter().filter(|name| known(name)).collect();
        let (resolved, first) = self
            .first
            .get_or_insert_with(|| (map.resolve(&known, &|_| None), names.clone()));
        if *first != names {
            return Err(End::OtherColumns);
        }
        let columns = 2 * map.channels.len();
        limits::values(self.rows, columns, self.bytes).map_err(|_| End::Excess)?;
        if self.end.is_some() {
            return Ok(());
        }
        evaluate(&mut rows, &resolved.map, &mut self.channels).map_err(End::Error)?;
        // Channels that grow row by row would be copied, and take twice their memory while they are.
        let expected = (SPARE * self.parts.max(1.0) * table.len() as f64) as usize;
        if self.rows == table.len() && limits::values(expected, columns, self.bytes).is_ok() {
            for (_, values) in &mut self.channels {
                values.reserve_exact(expected.saturating_sub(values.len()));
            }
        }
        Ok(())
    }

    /// The trial of all parts, as [`apply`](crate::apply()) makes it of the whole table. Nothing where columns changed between numbers
    /// and text: the map has to be applied to the whole.
    pub(crate) fn trial(self, sha256: &str) -> Option<Result<(Trial, Findings), LogError>> {
        match self.end {
            Some(End::OtherColumns) => return None,
            Some(End::Error(error)) => return Some(Err(error)),
            Some(End::Excess) | None => {}
        }
        let columns = 2 * self.map.channels.len();
        if let Err(excess) = limits::values(self.rows, columns, self.bytes) {
            return Some(Err(LogError::excess(&self.path, excess)));
        }
        let (resolved, _) = self.first?;
        let file = MappedFile {
            path: &self.path,
            sha256,
            rows: self.rows,
        };
        let made = trial_of(self.channels, &file, &resolved.map, &[]);
        Some(made.map(|(trial, mut findings)| {
            findings.warnings.extend(resolved.warnings());
            (trial, findings)
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tables::csv::each_part;
    use crate::{apply, parse_csv};

    /// Reads a text table by a map in parts of so many bytes.
    fn by_parts(text: &str, map: &Map, part: usize) -> Option<Result<(Trial, Findings), LogError>> {
        let parts = text.len() as f64 / part as f64;
        let mut mapped = MappedParts::new(map, "t.csv", text.len() as u64, parts);
        let read = each_part("t.csv", text.as_bytes(), part, &mut |part| mapped.add(part));
        mapped.trial(&read.unwrap().0)
    }

    /// Stamps, a row of units, corrupt rows, and columns that begin empty: one of numbers, one of text.
    fn table() -> String {
        let mut text = "Timestamp,a,b,who,late\ns,V,A,name,\n".to_owned();
        for i in 0..60 {
            let (b, late) = if i < 20 { ("", "") } else { ("1.5", "word") };
            text += &format!("2020-01-01 00:{i:02}:00,{i},{b},x,{late}\n");
            text += match i {
                11 => "2020-01-01 00:00:00,0,,x,\n",
                23 => "2020-01-01 00:00:00,word,1,x,\n",
                _ => "",
            };
        }
        text
    }

    const HEAD: &str = "schema = 1\n[channels]\ntime_s = 'Timestamp'\n";

    #[test]
    fn prop_a_map_in_parts_of_any_size_makes_the_trial_of_the_whole() {
        let text = table();
        let (whole, _) = parse_csv("t.csv", text.as_bytes()).unwrap();
        for rest in [
            "x = 'a + 2 * b + row'\n[filter]\nkeep = 'a != 7'\nmedian = { x = 3 }\n",
            "x = ['absent', 'a']\n[[windows]]\nfrom_s = 60\nto_s = 600\n[[windows]]\nfrom_s = 1200\nto_s = 1300\n",
            "x = 'a / b'\n[resample]\nperiod_s = 30\n",
        ] {
            let map = Map::parse("map.toml", &format!("{HEAD}{rest}")).unwrap();
            let (expected, findings) = apply(&whole, &map).unwrap();
            for part in [200, 333, 512, 1 << 20] {
                let (trial, found) = by_parts(&text, &map, part).unwrap().unwrap();
                assert_eq!(found, findings, "{part}");
                assert_eq!(trial.provenance(), expected.provenance());
                assert_eq!(trial.time_s(), expected.time_s());
                let bits = |of: &Trial| -> Vec<(String, Vec<u64>)> {
                    let channels = of.channels();
                    let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect();
                    channels
                        .map(|(name, v)| (name.to_owned(), bits(v)))
                        .collect()
                };
                assert_eq!(bits(&trial), bits(&expected), "{part}");
            }
        }
    }

    #[test]
    fn prop_what_the_map_lacks_in_parts_is_what_it_lacks_in_the_whole() {
        let text = table();
        let (whole, _) = parse_csv("t.csv", text.as_bytes()).unwrap();
        for rest in ["x = 'c'", "x = 'who'", "x = 'a'\ny = 'absent + b'"] {
            let map = Map::parse("map.toml", &format!("{HEAD}{rest}\n")).unwrap();
            let expected = apply(&whole, &map).unwrap_err().to_string();
            for part in [200, 1 << 20] {
                let found = by_parts(&text, &map, part).unwrap().unwrap_err();
                assert_eq!(found.to_string(), expected, "{part}");
            }
        }
    }

    #[test]
    fn analytic_a_column_that_turns_out_to_be_text_asks_for_the_whole_table() {
        let map = Map::parse("map.toml", &format!("{HEAD}x = ['late', 'a']\n")).unwrap();
        assert!(by_parts(&table(), &map, 512).is_none());
    }
}
