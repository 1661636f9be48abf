//! `touchdown land`.

pub(super) mod outcomes;
mod space;
mod vertical;

use touchdown::Result;
use touchdown_terminal::Done;

use super::args::land::LandArgs;
use super::context::Context;

pub(crate) fn run(context: &Context, args: &LandArgs) -> Result<Done> {
    if args.space {
        space::run(context, args)
    } else {
        vertical::run(context, args)
    }
}
