//! Settings of the landings at sea.

use std::path::Path;

use serde::{Deserialize, Serialize};
use toml::Table;
use touchdown_campaign::sweep::SeriesSettings;
use touchdown_sim::deck::rigid::SeaSettings as Sea;

/// What `reproduce` lands on at sea, in six degrees of freedom.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct SeaSettings {
    /// The sea and the ship of the case `sea`.
    pub wave: Sea,
    /// A measured motion of the deck in place of them.
    pub series: Option<SeriesSettings>,
    /// Keys of the scenario that are changed in all cases.
    pub scenario: Table,
}

impl SeaSettings {
    /// The same with relative paths taken from `folder`.
    #[must_use]
    pub fn from(mut self, folder: &Path) -> Self {
        if let Some(series) = &mut self.series {
            series.file = folder.join(&series.file);
        }
        self
    }
}
