//! The files that stand beside a sweep in the folder of a campaign or run: a measured motion, a policy.

use std::path::Path;

use sha2::{Digest as _, Sha256};

use super::settings::SweepSettings;
use crate::error::Result;
use crate::files::write;
use crate::measured_deck::SERIES;
use crate::place::Place;
use crate::policy::{POLICY_FILE, PolicyFile};

/// The files, as they were read.
#[derive(Clone, Debug, Default)]
pub(super) struct FilesBeside {
    pub(super) series: Option<Vec<u8>>,
    pub(super) policy: Option<PolicyFile>,
}

impl FilesBeside {
    /// The files by their names.
    pub(super) fn named(&self) -> impl Iterator<Item = (&'static str, &[u8])> {
        let series = self.series.iter().map(|bytes| (SERIES, bytes.as_slice()));
        let policy = self.policy.iter();
        series.chain(policy.map(|policy| (POLICY_FILE, policy.bytes.as_slice())))
    }

    /// Copies those of a campaign's settings from its place into a folder.
    ///
    /// # Errors
    /// A file that is not there, or a folder that cannot be written.
    pub(super) fn copy(settings: &SweepSettings, place: &Place, folder: &Path) -> Result<()> {
        let series = settings.series.as_ref().map(|_| SERIES);
        let policy = settings.policy.as_ref().map(|_| POLICY_FILE);
        let mut names = series.into_iter().chain(policy);
        names.try_for_each(|name| write(&folder.join(name), &place.read(name)?))
    }

    /// Makes the files part of what identifies a sweep.
    pub(super) fn put_into(&self, hash: &mut Sha256) {
        hash.update(Sha256::digest(self.series.as_deref().unwrap_or_default()));
        if let Some(policy) = &self.policy {
            hash.update(Sha256::digest(&policy.bytes));
        }
    }
}
