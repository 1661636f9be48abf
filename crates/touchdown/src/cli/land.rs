//! `touchdown land`.

use touchdown::Result;

use super::Done;
use super::args::LandArgs;
use super::context::Context;

pub(crate) fn run(_: &Context, _: &LandArgs) -> Result<Done> {
    Ok(Done::Whole)
}
