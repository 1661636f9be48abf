//! `touchdown export`.

use serde::Serialize;
use touchdown::{Error, Result};
use touchdown_model::Card;
use touchdown_model::export::export;
use touchdown_terminal::Done;

use super::args::export::ExportArgs;
use super::context::Context;
use super::output;

#[derive(Serialize)]
struct Exported {
    schema: u32,
    version: &'static str,
    files: Vec<String>,
}

pub(crate) fn run(context: &Context, args: &ExportArgs) -> Result<Done> {
    output::must_not_be_a_file(Some(&args.out))?;
    let mut folders = Vec::new();
    for path in &args.cards {
        let card = Card::read(path)?;
        let files = export(&card, args.to.into(), args.precision.into())?;
        // The files' own name, which is that of the card as an identifier.
        let name = files.first().map_or("", |file| stem(&file.name)).to_owned();
        if let Some((other, ..)) = folders.iter().find(|(_, taken, _)| *taken == name) {
            return Err(Error::Arguments(format!(
                "cards {other} and {} are both named `{name}`; expected cards of different names",
                path.display()
            )));
        }
        folders.push((path.display().to_string(), name, files));
    }
    let mut written = Vec::new();
    for (_, name, files) in &folders {
        let folder = args.out.join(name);
        output::folder(&folder)?;
        for file in files {
            output::write(&folder.join(&file.name), file.text.as_bytes())?;
            written.push(format!("{name}/{}", file.name));
        }
        context.say(&format!("{}: {} files", folder.display(), files.len()));
    }
    context.object(&Exported {
        schema: 1,
        version: env!("CARGO_PKG_VERSION"),
        files: written,
    });
    Ok(Done::Whole)
}

/// A file's name without its extension.
fn stem(name: &str) -> &str {
    name.split_once('.').map_or(name, |(stem, _)| stem)
}
