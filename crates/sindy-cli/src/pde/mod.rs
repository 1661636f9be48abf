//! `sindy pde`.

pub(crate) mod args;
mod object;
mod read;
mod show;

use sindy::pde::{FieldData, FieldLibrary, IdentifyField};
use touchdown_report::{Callout, Report};
use touchdown_terminal::{Done, Terminal};

use crate::error::{Error, Result};
use crate::fit::figure::{coefficients, front};
use crate::{drawing, output};
use args::PdeArgs;
use object::PdeObject;

pub(crate) fn run(terminal: &Terminal, args: &PdeArgs) -> Result<Done> {
    output::check(args.figure.iter(), args.data.iter())?;
    if let Some(path) = &args.figure {
        drawing::check(path)?;
    }
    terminal.busy("reading");
    let (mut data, mut warnings, mut lossy) = (Vec::new(), Vec::new(), false);
    for path in &args.data {
        let (field, findings) = read::field(path, args)?;
        let at = path.display();
        warnings.extend(findings.warnings.iter().map(|w| format!("{at}: {w}")));
        lossy |= findings.is_lossy();
        data.push(field);
    }
    let identify = identify(args, &data[0])?;
    let points: usize = data.iter().map(FieldData::points).sum();
    terminal.busy(&format!("weak form of {points} points"));
    let files: Vec<String> = args.data.iter().map(|p| p.display().to_string()).collect();
    let found = identify
        .run(&data)
        .map_err(Error::refused(files.join(", ")))?;
    let object = PdeObject::new(&found, &data, warnings);
    if let Some(path) = &args.figure {
        let page = || {
            let mut page = Report::new("Partial differential equations");
            page.fact("sindy", env!("CARGO_PKG_VERSION"));
            let lines: Vec<String> = object.text.iter().map(|line| format!("`{line}`")).collect();
            let kind = match object.warnings.is_empty() {
                true => Callout::Success,
                false => Callout::Warning,
            };
            page.verdict(kind, format!("The data follow {}.", lines.join(" and ")));
            page.table(coefficients(&object.equations))?;
            for warning in &object.warnings {
                page.callout(Callout::Warning, warning);
            }
            page.section("Terms against error")
                .figure(&front(&object.front))?;
            page.section("As text").code(show::text(&object));
            Ok(page)
        };
        drawing::write(path, || front(&object.front), page)?;
    }
    terminal.finish();
    terminal.say(&show::text(&object));
    for warning in &object.warnings {
        terminal.warn(warning);
    }
    terminal.object(&object);
    Ok(Done::with_loss(lossy))
}

/// The identification with the arguments' candidates, for fields and axes as they were read.
fn identify(args: &PdeArgs, data: &FieldData) -> Result<IdentifyField> {
    let fields: Vec<&str> = data.names().iter().map(String::as_str).collect();
    let space: Vec<&str> = data.axes()[1..]
        .iter()
        .map(sindy::pde::Axis::name)
        .collect();
    let order = args.order.unwrap_or(FieldLibrary::usual_order(space.len()));
    let library = match args.term.is_empty() {
        true => FieldLibrary::polynomial(&fields, args.degree, &space, order),
        false => {
            let terms: Vec<&str> = args.term.iter().map(String::as_str).collect();
            FieldLibrary::parse(&fields, &space, &terms)
        }
    };
    let library = library.map_err(Error::refused("candidates"))?;
    for (argument, given) in [
        ("--spacing", &args.spacing),
        ("--half-width", &args.half_width),
    ] {
        if let Some((axis, _)) = given.iter().find(|(axis, _)| !args.axes.contains(axis)) {
            return Err(Error::Arguments(format!(
                "{argument}: expected one of the axes {}, found `{axis}`",
                args.axes.join(", ")
            )));
        }
    }
    let mut identify = IdentifyField::new(library)
        .time_order(args.time_order)
        .map_err(Error::refused("--time-order"))?;
    if !args.half_width.is_empty() {
        let axes = data.axes().iter();
        let widths = axes.map(|axis| read::given(&args.half_width, axis.name(), "--half-width"));
        let widths = widths.collect::<Result<Vec<f64>>>()?;
        identify = identify
            .half_widths(widths)
            .map_err(Error::refused("--half-width"))?;
    }
    Ok(identify)
}
