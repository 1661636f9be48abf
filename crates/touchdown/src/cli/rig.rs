//! `touchdown rig`.

use touchdown::Result;

use super::Done;
use super::args::RigArgs;
use super::context::Context;

pub(crate) fn run(_: &Context, _: &RigArgs) -> Result<Done> {
    Ok(Done::Whole)
}
