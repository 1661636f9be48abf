//! `touchdown reproduce`.

use touchdown::Result;

use super::Done;
use super::args::ReproduceArgs;
use super::context::Context;

pub(crate) fn run(_: &Context, _: &ReproduceArgs) -> Result<Done> {
    Ok(Done::Whole)
}
