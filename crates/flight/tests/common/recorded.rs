//! Figures of a run, compared with those of an earlier one.

use std::fmt::Write as _;
use std::path::Path;

/// Mean figures of equal spans of a run. Every step counts, and the file stays small.
#[derive(Debug)]
pub struct Means {
    columns: &'static [&'static str],
    steps: usize,
    sums: Vec<f64>,
    counted: usize,
    rows: Vec<Vec<f64>>,
}

impl Means {
    /// Spans of `steps` steps.
    pub fn new(columns: &'static [&'static str], steps: usize) -> Self {
        Self {
            columns,
            steps,
            sums: vec![0.0; columns.len()],
            counted: 0,
            rows: Vec::new(),
        }
    }

    /// Takes the figures of a step.
    pub fn add(&mut self, figures: &[f64]) {
        assert_eq!(figures.len(), self.columns.len());
        for (sum, figure) in self.sums.iter_mut().zip(figures) {
            *sum += figure;
        }
        self.counted += 1;
        if self.counted == self.steps {
            self.end_of_span();
        }
    }

    fn end_of_span(&mut self) {
        if self.counted > 0 {
            let count = self.counted as f64;
            self.rows
                .push(self.sums.iter().map(|sum| sum / count).collect());
            self.sums.fill(0.0);
            self.counted = 0;
        }
    }

    /// Compares the means with the file `tests/recorded/NAME.csv` of the crate in `manifest`.
    /// With `TOUCHDOWN_RECORD` set, writes that file instead.
    pub fn compare(mut self, manifest: &str, name: &str) {
        self.end_of_span();
        let file = Path::new(manifest).join(format!("tests/recorded/{name}.csv"));
        if std::env::var_os("TOUCHDOWN_RECORD").is_some() {
            std::fs::create_dir_all(file.parent().unwrap()).unwrap();
            std::fs::write(&file, self.text()).unwrap();
            return;
        }
        let text = std::fs::read_to_string(&file)
            .unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        let mut lines = text.lines();
        assert_eq!(lines.next().unwrap(), self.columns.join(","));
        let recorded: Vec<Vec<f64>> = lines
            .map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect())
            .collect();
        assert_eq!(self.rows.len(), recorded.len(), "{name}: number of spans");
        for (i, column) in self.columns.iter().enumerate() {
            let greatest = recorded.iter().map(|row| row[i].abs()).fold(0.0, f64::max);
            // Another platform's sine and exponential differ in the last bit; a landing, which
            // is stable, does not amplify that to a millionth of the figure.
            let tolerance = 1e-6 * greatest.max(1e-3);
            for (k, (now, before)) in self.rows.iter().zip(&recorded).enumerate() {
                assert!(
                    (now[i] - before[i]).abs() <= tolerance,
                    "{name}: {column} in span {k}: {} now, {} recorded. If the change is \
                     meant, run the test with TOUCHDOWN_RECORD=1 and say in the commit what moved",
                    now[i],
                    before[i]
                );
            }
        }
    }

    fn text(&self) -> String {
        let mut text = self.columns.join(",");
        for row in &self.rows {
            for (i, figure) in row.iter().enumerate() {
                let between = if i == 0 { '\n' } else { ',' };
                write!(text, "{between}{figure:.8e}").unwrap();
            }
        }
        text.push('\n');
        text
    }
}
