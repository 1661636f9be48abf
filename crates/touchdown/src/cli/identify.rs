//! `touchdown identify`.

use touchdown::Result;

use super::Done;
use super::args::IdentifyArgs;
use super::context::Context;

pub(crate) fn run(_: &Context, _: &IdentifyArgs) -> Result<Done> {
    Ok(Done::Whole)
}
