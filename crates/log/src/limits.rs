//! Limits of the readers: a small file must not ask for much memory or time. The crate's documentation has their
//! table.

/// Longest name with its parents, bytes. Half of it is still six times the longest known; names of twice
/// the length double the memory for the names of a hostile log.
pub(crate) const NAME_BYTES: usize = 512;
/// All names of one log, bytes; each is held up to four times.
const NAMES_BYTES: usize = 16 << 20;
/// Fields of all topics of one log.
const FIELDS: usize = 1 << 18;
/// Parts of all definitions of ROS of one log. They bound the time for definitions.
const NODES: usize = 1 << 20;
/// Columns of a table.
pub(crate) const COLUMNS: usize = 16_384;
/// Channels and definitions of a map, and bytes of its text.
pub(crate) const MAP_RULES: usize = 1024;
pub(crate) const MAP_BYTES: usize = 1 << 20;
/// Longest record and chunk, bytes.
pub(crate) const RECORD_BYTES: usize = 64 << 20;
/// Longest message of JSON, bytes.
pub(crate) const JSON_BYTES: usize = 8 << 20;
/// Unpacked bytes, in all and for each packed byte. With half the ratio, a recording of a camera before a
/// blank wall is refused; with twice the ratio a hostile file costs twice the time.
const UNPACKED_FREE: u64 = 64 << 20;
const UNPACKED_RATIO: u64 = 100;
/// Memory of values, in all and for each byte of the file. Half the ratio refuses tables of single digits.
const MEMORY_FREE: u64 = 256 << 20;
const MEMORY_RATIO: u64 = 64;

/// What a file asks for beyond a limit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Excess {
    pub(crate) most: String,
    pub(crate) found: String,
}

/// Checks the number of columns of a table.
pub(crate) fn columns(found: usize) -> Result<(), Excess> {
    if found <= COLUMNS {
        return Ok(());
    }
    Err(Excess {
        most: format!("{COLUMNS} columns"),
        found: found.to_string(),
    })
}

/// Checks the length of a column's name.
pub(crate) fn column_name(name: &str) -> Result<(), Excess> {
    if name.len() <= NAME_BYTES {
        return Ok(());
    }
    Err(Excess {
        most: format!("{NAME_BYTES} bytes in the name of a column"),
        found: format!("{} bytes in {:?} …", name.len(), start(name)),
    })
}

/// The start of a long name.
fn start(name: &str) -> String {
    name.chars().take(40).collect()
}

/// Bytes of values that a file of this size may take in memory.
pub(crate) fn memory(file_bytes: u64) -> u64 {
    MEMORY_FREE.saturating_add(file_bytes.saturating_mul(MEMORY_RATIO))
}

/// Checks the memory for so many rows of so many columns of numbers.
pub(crate) fn values(rows: usize, columns: usize, file_bytes: u64) -> Result<(), Excess> {
    let bytes = (rows as u64)
        .saturating_mul(columns as u64)
        .saturating_mul(8);
    let most = memory(file_bytes);
    if bytes <= most {
        return Ok(());
    }
    Err(Excess {
        found: format!("{rows} rows of {columns} columns, {} MB", bytes / 1_000_000),
        ..too_many_values(most)
    })
}

/// The refusal of more bytes of values than these.
pub(crate) fn too_many_values(most: u64) -> Excess {
    Excess {
        most: format!("{} MB of values from a file of this size", most / 1_000_000),
        found: "more".to_owned(),
    }
}

/// Checks the unpacked size of data of a packed size.
pub(crate) fn unpacked(packed: u64, unpacked: u64) -> Result<(), Excess> {
    if unpacked <= allowance(packed) {
        return Ok(());
    }
    Err(Excess {
        most: format!("{UNPACKED_RATIO} unpacked bytes for each packed byte, after 64 MiB"),
        found: format!("at least {unpacked} bytes from {packed}"),
    })
}

/// Bytes to which so many packed bytes may unpack.
pub(crate) fn allowance(packed: u64) -> u64 {
    UNPACKED_FREE.saturating_add(packed.saturating_mul(UNPACKED_RATIO))
}

/// What the definitions of one log may still use, and the first thing that was beyond it.
#[derive(Debug)]
pub(crate) struct NameBudget {
    fields: usize,
    bytes: usize,
    nodes: usize,
    excess: Option<Excess>,
}

impl Default for NameBudget {
    fn default() -> Self {
        Self {
            fields: FIELDS,
            bytes: NAMES_BYTES,
            nodes: NODES,
            excess: None,
        }
    }
}

impl NameBudget {
    /// Takes the name of a topic or of a field with its parents. `None` if it is too long, or one too many.
    #[must_use]
    pub(crate) fn name(&mut self, name: &str) -> Option<()> {
        if name.len() > NAME_BYTES {
            let most = format!("{NAME_BYTES} bytes in a name");
            return self.refuse(most, format!("{} in {:?} …", name.len(), start(name)));
        }
        match (
            self.fields.checked_sub(1),
            self.bytes.checked_sub(name.len()),
        ) {
            (Some(fields), Some(bytes)) => {
                (self.fields, self.bytes) = (fields, bytes);
                Some(())
            }
            (None, _) => self.refuse(format!("{FIELDS} fields in a log"), "more".to_owned()),
            (_, None) => {
                let most = format!("{} MiB of names in a log", NAMES_BYTES >> 20);
                self.refuse(most, "more".to_owned())
            }
        }
    }

    /// Takes a part of a definition; `None` if it is one too many.
    #[must_use]
    pub(crate) fn node(&mut self) -> Option<()> {
        match self.nodes.checked_sub(1) {
            Some(nodes) => {
                self.nodes = nodes;
                Some(())
            }
            None => self.refuse(
                format!("{NODES} parts of the definitions of a log"),
                "more".to_owned(),
            ),
        }
    }

    fn refuse(&mut self, most: String, found: String) -> Option<()> {
        self.excess.get_or_insert(Excess { most, found });
        None
    }

    /// The first thing that was beyond a limit.
    pub(crate) fn check(&self) -> Result<(), Excess> {
        self.excess.clone().map_or(Ok(()), Err)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_what_is_at_a_limit_passes_and_one_more_does_not() {
        assert!(columns(COLUMNS).is_ok() && columns(COLUMNS + 1).is_err());
        assert!(column_name(&"n".repeat(NAME_BYTES)).is_ok());
        assert!(column_name(&"n".repeat(NAME_BYTES + 1)).is_err());
        // 256 MiB and 64 bytes for each of 1 MiB are 2²² · 10 numbers.
        assert!(values(1 << 22, 10, 1 << 20).is_ok());
        assert!(values((1 << 22) + 1, 10, 1 << 20).is_err());
        assert!(values(usize::MAX, usize::MAX, u64::MAX - 1).is_ok());
        assert!(unpacked(10, (64 << 20) + 1000).is_ok());
        assert!(unpacked(10, (64 << 20) + 1001).is_err());
        let mut budget = NameBudget::default();
        assert!(budget.name(&"n".repeat(NAME_BYTES + 1)).is_none());
        assert!(budget.check().unwrap_err().found.starts_with("513 in"));
        let name = "n".repeat(NAME_BYTES);
        let taken = (0..).take_while(|_| budget.name(&name).is_some()).count();
        assert_eq!(taken, NAMES_BYTES / NAME_BYTES);
        let mut budget = NameBudget::default();
        let taken = (0..).take_while(|_| budget.name("n").is_some()).count();
        assert_eq!(taken, FIELDS);
        assert!(budget.check().is_err());
    }
}
