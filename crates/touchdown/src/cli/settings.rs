//! `touchdown settings`.

use touchdown::Result;

use super::Done;
use super::args::SettingsArgs;
use super::context::Context;

pub(crate) fn run(_: &Context, _: &SettingsArgs) -> Result<Done> {
    Ok(Done::Whole)
}
