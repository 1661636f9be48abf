//! `touchdown export`.

use serde::Serialize;
use touchdown::{Error, Result};
use touchdown_flight::Method;
use touchdown_model::export::{ExportedFile, VERTICAL_NAME, export, export_vertical};
use touchdown_model::{Card, Kind};
use touchdown_terminal::Done;

use super::args::export::{ExportArgs, To};
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
    let mut cards = Vec::new();
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
        cards.push(card);
    }
    if let Some(files) = vertical(args, &cards)? {
        // No card's folder has this name: it is taken.
        folders.push((String::new(), VERTICAL_NAME.to_owned(), files));
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

/// The files of the vertical controller, where one is asked for.
fn vertical(args: &ExportArgs, cards: &[Card]) -> Result<Option<Vec<ExportedFile>>> {
    let Some(name) = &args.method else {
        return Ok(None);
    };
    let method = Method::VERTICAL
        .into_iter()
        .find(|method| method.name() == name);
    let (Some(method), To::C) = (method, args.to) else {
        return Err(Error::Arguments(format!(
            "--method {name} writes C99 only; expected --to c"
        )));
    };
    let (thrust, air): (Vec<_>, Vec<_>) = cards.iter().partition(|card| card.kind == Kind::Thrust);
    let ([thrust], [] | [_]) = (&thrust[..], &air[..]) else {
        return Err(Error::Arguments(format!(
            "--method {name} expects one thrust card and at most one ground-effect card; found {} and {}",
            thrust.len(),
            air.len()
        )));
    };
    let files = export_vertical(thrust, air.first().copied(), method, args.precision.into())?;
    Ok(Some(files))
}

/// A file's name without its extension.
fn stem(name: &str) -> &str {
    name.split_once('.').map_or(name, |(stem, _)| stem)
}
