//! The report of `touchdown reproduce`.

mod coefficients;
mod deck;
mod first_page;
mod ground_effect;
mod ground_effect_figures;
mod ground_landing;
mod identifiability;
mod last_page;
mod printed;
mod sea;
mod sparsity;
mod thrust;
mod verdict;

pub use sea::watched;

use std::path::Path;

use crate::error::Result;
use crate::experiments::Run;
use crate::experiments::results::Results;
use touchdown_pages::page::Page;

/// Writes `figures/*.svg`, `figures/*.png` and `report.html` into the folder `out`.
///
/// # Errors
/// Files that cannot be written, or figures that cannot be drawn.
pub fn reproduce(run: &Run, results: &Results, out: &Path) -> Result<()> {
    let mut page = Page::new(
        "Landing with an identified ground effect",
        "The paper's four experiments on a virtual rig and a virtual vehicle, and landings at sea",
        out,
    );
    page.report
        .fact("Seed", results.seed.to_string())
        .fact("Landings of each method", results.trials.to_string());
    if results.quick {
        page.report.fact("Extent", "quick: fewer rig trials");
    }
    first_page::write(&mut page, run, results)?;
    thrust::write(&mut page, run)?;
    ground_effect::write(&mut page, run, results)?;
    ground_landing::write(&mut page, run, results)?;
    deck::write(&mut page, run, results)?;
    sea::write(&mut page, run)?;
    last_page::write(&mut page, run, results)?;
    Ok(page.finish()?)
}
