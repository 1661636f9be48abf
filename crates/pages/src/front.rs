//! The Pareto front of a sparse fit, and the levels of identification, as tables, figures and sentences.

use touchdown_identify::front::{Front, Size};
use touchdown_identify::rig::levels::Level;
use touchdown_report::{Cell, Color, Figure, Panel, Series, Table};

use super::colors::{HELD_OUT, OWN_TERMS, TRAINING};
use super::page::show;

/// The best subset of every size: terms and errors.
pub fn table(caption: &str, front: &Front) -> Table {
    let free_run = front.sizes.iter().any(|s| s.free_run_rmse_n.is_some());
    let mut table = Table::new(caption)
        .number_column("Terms", "")
        .text_column("Best subset of this size")
        .number_column("Data of the fit", &front.unit)
        .number_column("Held-out trials", &front.unit);
    if free_run {
        table = table.number_column("Free run, unseen trials", "N");
    }
    table = table.text_column("Proven");
    for (k, size) in front.sizes.iter().enumerate() {
        let mut row = vec![
            Cell::count(k),
            Cell::text(kept(front, size)),
            Cell::number(size.training_rmse, 4),
            Cell::maybe(size.left_out_rmse, 4),
        ];
        if free_run {
            row.push(Cell::text(run(size.free_run_rmse_n)));
        }
        row.push(if size.proven {
            Cell::text("yes")
        } else {
            Cell::text(format!("gap {} %", show(100.0 * size.gap, 1)))
        });
        if k == front.chosen_terms {
            row = row.into_iter().map(Cell::bold).collect();
        }
        table = table.row(row);
    }
    table.note(
        "Root mean square errors. Held-out trials: the whole search is repeated without each of them. Bold: chosen.",
    )
}

/// Errors within this ratio of each other are alike.
const ALIKE: f64 = 1.1;
/// From here on (N) a run has left every force that the ground can add.
const UNSTABLE_N: f64 = 10.0;

/// The error of a free run.
fn run(rmse_n: Option<f64>) -> String {
    match rmse_n {
        Some(v) if v < UNSTABLE_N => show(v, 3),
        _ => "unstable".into(),
    }
}

/// The terms of a subset; those that are missing, where they are fewer.
fn kept(front: &Front, size: &Size) -> String {
    let all = front.library.len();
    if size.terms.is_empty() {
        return "none".into();
    }
    if 2 * size.terms.len() <= all + 1 {
        return size.terms.join(", ");
    }
    let gone: Vec<&str> = front
        .library
        .iter()
        .filter(|t| !size.terms.contains(t))
        .map(String::as_str)
        .collect();
    if gone.is_empty() {
        "all".into()
    } else {
        format!("all but {}", gone.join(", "))
    }
}

/// Error over the number of terms: on the data of the fit and on held-out trials; below, in free run.
pub fn figure(id: &str, title: &str, front: &Front) -> Figure {
    let terms: Vec<f64> = (0..front.sizes.len()).map(|k| k as f64).collect();
    let of = |pick: fn(&Size) -> Option<f64>| -> Vec<f64> {
        let sizes = front.sizes.iter();
        sizes.map(|s| pick(s).unwrap_or(f64::NAN)).collect()
    };
    let left_out = of(|s| s.left_out_rmse);
    let at = front.chosen_terms;
    let mut errors = Panel::new("Terms", format!("RMSE ({})", front.unit))
        .height_weight(1.4)
        .series(
            Series::lines_points(
                "best subsets, data of the fit",
                &terms,
                &of(|s| Some(s.training_rmse)),
            )
            .color(TRAINING),
        )
        .series(
            Series::lines_points("best subsets, held-out trials", &terms, &left_out)
                .color(HELD_OUT),
        );
    if let Some(own) = front.model.left_out_rmse {
        errors = errors.series(
            Series::points(
                "the model's own terms, held-out trials",
                &[front.model.terms as f64],
                &[own],
            )
            .color(OWN_TERMS)
            .width(4.0),
        );
    }
    errors = errors.series(
        Series::points(
            "chosen",
            &[at as f64],
            &[left_out.get(at).copied().unwrap_or(f64::NAN)],
        )
        .color(Color::BLACK)
        .width(2.6),
    );
    let mut figure = Figure::new(id, title)
        .caption(front.says())
        .share_x()
        .size(900, 420)
        .panel(errors);
    let free_run = of(|s| s.free_run_rmse_n);
    if free_run.iter().any(|v| v.is_finite()) {
        figure = figure.size(900, 600).panel(
            Panel::new("Terms", "Free run, unseen (N)")
                .log_y()
                .series(Series::lines_points("", &terms, &free_run).color(HELD_OUT)),
        );
    }
    figure
}

/// What the front shows, in sentences that follow from its figures.
pub fn words(front: &Front) -> String {
    let all = front.sizes.len() - 1;
    let of_all = front.sizes[all].training_rmse / front.sizes[0].training_rmse;
    format!(
        "{} {} {} All {all} explain {} % of the mean square of {}.{}",
        front.says(),
        standing(front),
        fewest(front),
        show(100.0 * (1.0 - of_all * of_all), 1),
        front.of,
        in_free_run(front)
    )
}

/// How the model's terms compare with the best of their number.
fn standing(front: &Front) -> String {
    let (model, p) = (&front.model, front.library.len());
    let kept = format!("The model keeps {} of {p} terms.", model.terms);
    if model.best_of_its_size {
        return format!("{kept} They are the best subset of that size.");
    }
    let less = 100.0 * model.excess / (1.0 + model.excess);
    format!(
        "{kept} The best subset of that size has {} % less residual.",
        show(less, 2)
    )
}

/// How few terms do as well as all on held-out trials.
fn fewest(front: &Front) -> String {
    let (k, all) = (front.chosen_terms, front.sizes.len() - 1);
    let error = |k: usize| {
        let size = front.sizes.get(k);
        let error = size.and_then(|s| s.left_out_rmse);
        format!("{} {}", show(error.unwrap_or(f64::NAN), 4), front.unit)
    };
    if k == all {
        return format!(
            "On held-out trials, all {all} terms have an error of {}, and no fewer do as well.",
            error(all)
        );
    }
    format!(
        "On held-out trials, {k} terms ({}) have an error of {}, and all {all} have {}: fewer do as well.",
        front.sizes[k].terms.join(", "),
        error(k),
        error(all)
    )
}

/// How the chosen terms compare with all in free run; empty where nothing was compared.
fn in_free_run(front: &Front) -> String {
    let (k, all) = (front.chosen_terms, front.sizes.len() - 1);
    let [few, many] = [k, all].map(|k| front.sizes[k].free_run_rmse_n);
    if k == all || (few, many) == (None, None) {
        return String::new();
    }
    let [a, b] = [few, many].map(|rmse_n| rmse_n.unwrap_or(f64::INFINITY));
    let verdict = if a > ALIKE * b {
        "they do worse"
    } else if b > ALIKE * a {
        "they do better"
    } else {
        "they do as well"
    };
    let shown = |rmse_n: Option<f64>| match run(rmse_n).as_str() {
        "unstable" => "unstable".to_string(),
        number => format!("{number} N"),
    };
    format!(
        " In free run on unseen trials, {verdict}: {} against {}.",
        shown(few),
        shown(many)
    )
}

/// What a level's model is called.
fn title(model: &str) -> &'static str {
    match model {
        "static" => "static map T h(z)",
        "sr3_to_the_letter" => "eq. (9), SR3 to the letter",
        "derivative" => "eq. (9), SR3 scaled, chosen",
        "best_subset" => "eq. (9), best subset",
        "weak_form" => "eq. (9), weak form",
        "refined" => "eq. (9), refined in free run",
        "ratio" => "ratio form",
        "lag" => "lag form",
        _ => "other",
    }
}

/// All levels, a row a model, for one or more data sets.
pub fn levels(caption: &str, sets: &[(&str, &[Level])]) -> Table {
    let mut table = Table::new(caption)
        .text_column("Level")
        .text_column("Model");
    for (name, _) in sets {
        let terms = match *name {
            "" => "Terms".to_string(),
            name => format!("{name}: terms"),
        };
        table = table
            .number_column(terms, "")
            .number_column("held-out f'", "N/s")
            .number_column("free-run f", "N");
    }
    let Some((_, first)) = sets.first() else {
        return table;
    };
    for row in *first {
        let level = match row.level {
            0 => "–".to_string(),
            level => level.to_string(),
        };
        let mut cells = vec![Cell::text(level), Cell::text(title(row.model))];
        for (_, rows) in sets {
            let found = rows.iter().find(|r| r.model == row.model);
            cells.push(found.map_or_else(Cell::missing, |r| Cell::count(r.terms)));
            cells.push(Cell::maybe(found.and_then(|r| r.held_out_rmse_n_per_s), 3));
            cells.push(found.map_or_else(Cell::missing, |r| Cell::text(run(r.free_run_rmse_n))));
        }
        table = table.row(cells);
    }
    table.note(
        "Root mean square errors on trials that no model was fitted to. Held-out f': against the smoothed derivative of the trials. Most of it is turbulence and \
         sensor noise. A dash: the form has no equation for f'.",
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use touchdown_identify::front::{Certificate, Standing};

    fn front(model: Standing) -> Front {
        let size = |k: usize, left_out: f64| Size {
            terms: ["a", "b", "c"][..k]
                .iter()
                .map(ToString::to_string)
                .collect(),
            coefficients: vec![1.0; k],
            training_rmse: left_out,
            left_out_rmse: Some(left_out),
            proven: true,
            gap: 0.0,
            free_run_rmse_n: None,
        };
        Front {
            of: "f'".into(),
            unit: "N/s".into(),
            library: ["a", "b", "c"].map(String::from).into(),
            rows: 100,
            groups: 5,
            certificate: Certificate {
                subsets: 8.0,
                nodes: 3,
                proven: true,
                ridge: 0.0,
            },
            sizes: vec![size(0, 1.0), size(1, 0.5), size(2, 0.4), size(3, 0.41)],
            chosen_terms: 1,
            reason: String::new(),
            model,
        }
    }

    #[test]
    fn prop_words_follow_from_the_figures() {
        let model = Standing {
            terms: 2,
            training_rmse: 0.5,
            left_out_rmse: Some(0.5),
            best_of_its_size: false,
            excess: 0.25,
        };
        let mut front = front(model);
        let text = words(&front);
        // 0.25 above is a fifth of the whole.
        assert!(
            text.contains("8 subsets") && text.contains("20.00 % less"),
            "{text}"
        );
        assert!(
            text.contains("1 terms (a)") || text.contains("fewer do as well"),
            "{text}"
        );
        front.chosen_terms = 3;
        assert!(words(&front).contains("no fewer do as well"));
        assert_eq!(kept(&front, &front.sizes[3]), "all");
        assert_eq!(kept(&front, &front.sizes[2]), "a, b");
        assert_eq!(table("t", &front).rows.len(), 4);
    }
}
