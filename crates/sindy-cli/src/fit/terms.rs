//! Candidate terms from arguments, settings and files.

use std::path::Path;

use sindy::identify::velocity;
use sindy::{Libraries, Library, SindyError};

use super::args::FitArgs;
use super::settings::Settings;
use crate::error::{Error, Result};
use crate::trajectories::TIME_NAMES;

/// The library without any argument.
pub(super) const DEFAULT: &str = "poly(3)";

/// The libraries of the fit: arguments before settings, polynomials without either, cubic or those of a bounded model.
pub(super) fn libraries(
    args: &FitArgs,
    inputs: &[String],
    settings: &Settings,
) -> Result<Vec<Library>> {
    let second_order = settings.identify.second_order.iter();
    let mut states = args.states.clone();
    states.extend(second_order.map(|x| velocity(x)));
    let variables: Vec<&String> = states.iter().chain(inputs).collect();
    let mut texts = Vec::new();
    for text in &args.library {
        Library::specification(text, &variables)
            .map_err(|e| Error::refused("--library")(with_time(args, e)))?;
        texts.push(text.clone());
    }
    if let Some(path) = &args.terms {
        texts.extend(read(path, args, &variables)?);
    }
    let (libraries, why) = match (texts.is_empty(), &settings.library) {
        (false, _) => (&Libraries::shared(texts), "--library"),
        (true, Some(libraries)) => (libraries, "library in the settings"),
        (true, None) if settings.identify.stable => {
            (&Libraries::shared([quadratic(&states, inputs)]), "--stable")
        }
        (true, None) => (&Libraries::shared([DEFAULT]), DEFAULT),
    };
    let built = libraries.build(&states, inputs);
    built.map_err(|e| Error::refused(why)(with_time(args, e)))
}

/// The default of a model that is bounded: degree 2 in the states, and inputs alone.
fn quadratic(states: &[String], inputs: &[String]) -> String {
    let quoted = |names: &[String]| {
        let all = names
            .iter()
            .map(|n| format!("\"{}\"", n.replace('"', "\"\"")));
        all.collect::<Vec<_>>().join(", ")
    };
    match inputs {
        [] => "poly(2)".to_owned(),
        _ => format!("poly(2, {}) + poly(1, {})", quoted(states), quoted(inputs)),
    }
}

/// The error, with how time can stand in a term where the unknown name is that of the time column.
fn with_time(args: &FitArgs, mut error: SindyError) -> SindyError {
    if let SindyError::Specification {
        expected, found, ..
    } = &mut error
    {
        let name = found.trim_matches('`');
        let is_time = match &args.table.time {
            Some(time) => time == name,
            None => TIME_NAMES.concat().contains(&name),
        };
        if is_time {
            expected.push_str(&format!(" (and {name} with --inputs {name})"));
        }
    }
    error
}

/// Candidate terms in a file, one on each line: an expression, or a library such as `poly(2)`. `#` begins a comment.
fn read(path: &Path, args: &FitArgs, variables: &[&String]) -> Result<Vec<String>> {
    let text = touchdown_files::read_text(path).map_err(Error::unread(path))?;
    let mut texts = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default().trim();
        if !line.is_empty() {
            let place = format!("{}, line {}", path.display(), i + 1);
            Library::specification(line, variables)
                .map_err(|e| Error::refused(place)(with_time(args, e)))?;
            texts.push(line.to_owned());
        }
    }
    if texts.is_empty() {
        let at = path.display().to_string();
        return Err(Error::data(at, "a term on each line", "none"));
    }
    Ok(texts)
}
