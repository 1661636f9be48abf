//! The table of the armed intervals.

use touchdown_identify::flights::armed_interval_result::ArmedIntervalResult;
use touchdown_report::{Cell, Table};

use crate::page::show;

/// A row for every armed interval. Columns that none of them fills do not stand.
pub(super) fn table(runs: &[ArmedIntervalResult]) -> Table {
    let lifts = runs.iter().any(|r| r.extra_lift.is_some());
    let heights = runs.iter().any(|r| r.height_error_m.is_some());
    let mut table = Table::new("Armed intervals.")
        .text_column("log")
        .number_column("on", "s")
        .number_column("off", "s")
        .number_column("rows used", "")
        .number_column("thrust scale", "");
    let by_speed = runs
        .iter()
        .filter_map(|r| r.hover)
        .any(|h| h.throttle.is_none());
    table = match by_speed {
        false => table.number_column("hover throttle", ""),
        true => table.number_column("hover speed", "1/min"),
    }
    .number_column("hovered", "s");
    if heights {
        table = table
            .number_column("stood at", "mm")
            .number_column("height error", "mm");
    }
    if lifts {
        table = table
            .number_column("extra lift", "%")
            .number_column("95 % interval", "%");
    }
    for r in runs {
        let (on, off) = r.run.span("");
        let mut row = vec![
            Cell::text(format!("{}, interval {}", r.log, r.number)),
            Cell::text(on),
            Cell::text(off),
            Cell::count(r.rows_used),
            Cell::maybe(r.thrust_scale, 4),
            match by_speed {
                false => Cell::maybe(r.hover.and_then(|h| h.throttle), 3),
                true => Cell::maybe(r.hover.and_then(|h| h.rotor_rpm), 0),
            },
            Cell::maybe(r.hover.map(|h| h.hovered_s), 1),
        ];
        if heights {
            for height_m in [r.run.stood_m, r.height_error_m] {
                // To a tenth of a millimetre: what is less is none.
                row.push(Cell::maybe(height_m.map(|m| 0.1 * (1e4 * m).round()), 1));
            }
        }
        if lifts {
            let percent = |v: f64| show(100.0 * v, 1);
            let lift = r.extra_lift.map(|l| l.share);
            row.push(Cell::maybe(lift.map(|l| 100.0 * l.value), 1));
            row.push(lift.map_or_else(Cell::missing, |l| {
                let [low, high] = l.ci95.map(percent);
                Cell::text(format!("{low} … {high}"))
            }));
        }
        table = table.row(row);
    }
    let mut note =
        "Hover is steady, for a second or more, out of ground effect where heights are known."
            .to_string();
    if lifts {
        note += " Extra lift is the mean at 1.25 to 2 rotor radii less that out of ground effect, as measured in the run, with motors, \
                 drift and scale of the model; its interval is that of the run's own noise.";
    }
    table.note(note)
}
