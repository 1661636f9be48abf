//! `touchdown land`.

pub(super) mod outcomes;
mod space;
mod vertical;

use touchdown::Result;
use touchdown_terminal::Done;

use super::args::land::LandArgs;
use super::context::Context;
use super::output;

pub(crate) fn run(context: &Context, args: &LandArgs) -> Result<Done> {
    // Before any work is done.
    output::must_not_be_a_campaign(&args.out)?;
    if args.space {
        space::run(context, args)
    } else {
        vertical::run(context, args)
    }
}
