//! The landing that the book shows in three dimensions: that of the report of `touchdown reproduce`, on a page of its own.
//!
//! ```sh
//! cargo run -p touchdown --example book_landing -- landing.html
//! ```

use touchdown_report::Report;
use touchdown_reproduce::experiments::sea;
use touchdown_reproduce::pages::reproduce::watched;
use touchdown_reproduce::settings::ReproduceSettings;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = std::env::args()
        .nth(1)
        .ok_or("expected the page's file name")?;
    let cells = sea::cells(&ReproduceSettings::default(), None, "defaults")?;
    let mut report = Report::new("A deck that heaves by 0.3 m");
    report.scene(watched(&sea::tracks(&cells)?)?)?;
    report.write(file)?;
    Ok(())
}
