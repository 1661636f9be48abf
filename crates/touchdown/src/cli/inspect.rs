//! `touchdown inspect`.

use touchdown::Result;

use super::Done;
use super::args::InspectArgs;
use super::context::Context;

pub(crate) fn run(_: &Context, _: &InspectArgs) -> Result<Done> {
    Ok(Done::Whole)
}
