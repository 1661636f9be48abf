//! Both programs side by side.

use crate::problems::Problem;
use crate::pysindy::{Fits, Setting};
use crate::score::{Difference, Fitted, median};

/// What the table has beside our columns.
pub(crate) const HEADER: [&str; 2] = [
    " PySINDy's defaults: exact | median error | its best of grid: exact | median error | setting |",
    " --- | --- | --- | --- | --- |",
];

/// So many seeds more are a difference.
const MORE: usize = 2;

/// Errors are smaller from this share of ours on: regressions of the same terms differ by rounding.
const CLOSER: f64 = 0.99;

/// The cells of a problem.
pub(crate) fn cells(fits: Option<&Fits>) -> String {
    let Some(fits) = fits else {
        return " - | - | - | - | - |".into();
    };
    let of = |s: &Setting| match (&s.failure, s.error().is_finite()) {
        (Some(why), false) => format!(" PySINDy: {why} | - |"),
        _ => format!(" {} of {} | {:.1e} |", s.exact(), s.fits.len(), s.error()),
    };
    format!(
        "{}{} {} |",
        of(&fits.default),
        of(&fits.best),
        fits.best.name
    )
}

/// One problem that both programs were given.
struct Pair<'a> {
    problem: &'a Problem,
    ours: Vec<Difference>,
    theirs: &'a Fits,
}

impl Pair<'_> {
    /// Our exact fits.
    fn exact(&self) -> usize {
        self.ours.iter().filter(|d| d.is_exact()).count()
    }

    fn error(&self) -> f64 {
        median(self.ours.iter().map(|d| d.error).collect())
    }
}

/// The table by class, and the problems where PySINDy is better.
pub(crate) fn report(chosen: &[&Problem], ours: &[Vec<Fitted>], theirs: &[Option<Fits>]) -> String {
    let pairs: Vec<Pair<'_>> = chosen
        .iter()
        .zip(ours)
        .zip(theirs)
        .filter_map(|((problem, ours), theirs)| {
            Some(Pair {
                problem,
                ours: ours.iter().map(|f| f.difference).collect(),
                theirs: theirs.as_ref()?,
            })
        })
        .collect();
    let mut out = String::from(
        "| class | fits | exact: ours | PySINDy's defaults | its best of grid | median error: ours | PySINDy's defaults \
         | its best of grid |\n| --- | --- | --- | --- | --- | --- | --- | --- |\n",
    );
    let mut classes: Vec<&str> = Vec::new();
    for pair in &pairs {
        if !classes.contains(&pair.problem.class()) {
            classes.push(pair.problem.class());
        }
    }
    for class in classes {
        let own: Vec<&Pair<'_>> = pairs
            .iter()
            .filter(|p| p.problem.class() == class)
            .collect();
        out += &line(class, &own);
    }
    out += &line("all", &pairs.iter().collect::<Vec<_>>());
    out += &better("defaults", &pairs, |fits| &fits.default);
    out += &better("best of grid", &pairs, |fits| &fits.best);
    out
}

/// A line of the table by class.
fn line(class: &str, pairs: &[&Pair<'_>]) -> String {
    let fits: [Vec<Difference>; 3] = [
        pairs.iter().flat_map(|p| p.ours.clone()).collect(),
        pairs
            .iter()
            .flat_map(|p| p.theirs.default.fits.clone())
            .collect(),
        pairs
            .iter()
            .flat_map(|p| p.theirs.best.fits.clone())
            .collect(),
    ];
    let exact = |of: &[Difference]| of.iter().filter(|d| d.is_exact()).count();
    let error = |of: &[Difference]| median(of.iter().map(|d| d.error).collect());
    let [ours, default, best] = &fits;
    format!(
        "| {class} | {} | {} | {} | {} | {:.1e} | {:.1e} | {:.1e} |\n",
        ours.len(),
        exact(ours),
        exact(default),
        exact(best),
        error(ours),
        error(default),
        error(best),
    )
}

/// Where PySINDy is better.
fn better(name: &str, pairs: &[Pair<'_>], of: fn(&Fits) -> &Setting) -> String {
    let more: Vec<String> = pairs
        .iter()
        .filter(|p| of(p.theirs).exact() >= p.exact() + MORE)
        .map(|p| {
            let theirs = of(p.theirs).exact();
            format!("{} ({theirs} to {})", p.problem.name(), p.exact())
        })
        .collect();
    let closer: Vec<String> = pairs
        .iter()
        .filter(|p| of(p.theirs).error() < CLOSER * p.error())
        .map(|p| {
            let theirs = of(p.theirs).error();
            format!("{} ({theirs:.1e} to {:.1e})", p.problem.name(), p.error())
        })
        .collect();
    let list = |names: &[String]| match names {
        [] => "none".into(),
        names => format!("{}: {}", names.len(), names.join("; ")),
    };
    format!(
        "\nPySINDy's {name}, of {} problems:\n- exact in at least {MORE} seeds more than ours: {}\n- median error smaller \
         than ours: {}\n",
        pairs.len(),
        list(&more),
        list(&closer),
    )
}
