//! `touchdown validate`.

use touchdown::Result;

use super::Done;
use super::args::ValidateArgs;
use super::context::Context;

pub(crate) fn run(_: &Context, _: &ValidateArgs) -> Result<Done> {
    Ok(Done::Whole)
}
