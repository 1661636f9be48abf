//! Campaigns in object storage.
//!
//! [`place`] makes the [`Place`] of a path or an address. Files below `s3://bucket/prefix` (Amazon S3 and what speaks its
//! protocol), `gs://bucket/prefix` (Google Cloud Storage) and `az://container/prefix` (Azure Blob Storage) are written whole or
//! not at all, as object storage does it.
//!
//! Keys, regions and endpoints are those of the environment that the caller hands over, by the names that the tools of the three
//! use: `AWS_ACCESS_KEY_ID`, `AWS_SECRET_ACCESS_KEY`, `AWS_REGION`, `AWS_ENDPOINT_URL`; `GOOGLE_APPLICATION_CREDENTIALS`,
//! `GOOGLE_BASE_URL`; `AZURE_STORAGE_ACCOUNT_NAME`, `AZURE_STORAGE_ACCOUNT_KEY`, `AZURE_STORAGE_ENDPOINT`.

mod bucket;

use std::ffi::OsString;
use std::path::Path;
use std::sync::Arc;

pub use bucket::Bucket;
use touchdown_campaign::{Place, Result};
use touchdown_files::is_address;

/// The place of a path, which is a folder, or of an address with a scheme, such as `s3://bucket/campaign`.
///
/// # Errors
/// As [`Bucket::open`].
pub fn place(
    path: &Path,
    environment: impl IntoIterator<Item = (OsString, OsString)>,
) -> Result<Place> {
    if !is_address(path) {
        return Ok(path.into());
    }
    // Names and values that are no text are none that object storage knows.
    let text = |(name, value): (OsString, OsString)| {
        Some((name.into_string().ok()?, value.into_string().ok()?))
    };
    let environment = environment.into_iter().filter_map(text);
    let bucket = Bucket::open(&path.to_string_lossy(), environment)?;
    Ok(Place::Storage(Arc::new(bucket)))
}
