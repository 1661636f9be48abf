//! Colours that stay apart for every reader.

/// A colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Color {
    /// The n-th of sixteen colours that people with any colour vision can tell apart; wraps round.
    Cycle(usize),
    /// Red, green, blue.
    Rgb(u8, u8, u8),
}

impl Color {
    /// Near black, for references.
    pub const BLACK: Self = Self::Rgb(0x22, 0x22, 0x22);
    /// Grey, for what stands in the background.
    pub const GREY: Self = Self::Rgb(0x80, 0x80, 0x80);

    /// Red, green, blue. The palette begins with that of Okabe & Ito (2008), strongest on white first. The eight that follow
    /// are as far from those, from each other and from white as those are among themselves (CIELAB distance 17), as seen
    /// with and without red or green cones.
    pub fn rgb(self) -> [u8; 3] {
        const PALETTE: [[u8; 3]; 16] = [
            [0x00, 0x72, 0xB2], // blue
            [0xD5, 0x5E, 0x00], // vermillion
            [0x00, 0x9E, 0x73], // bluish green
            [0xCC, 0x79, 0xA7], // reddish purple
            [0xE6, 0x9F, 0x00], // orange
            [0x56, 0xB4, 0xE9], // sky blue
            [0x00, 0x00, 0x00], // black
            [0xF0, 0xE4, 0x42], // yellow
            [0x66, 0x33, 0x11], // brown
            [0x00, 0x00, 0xFF], // pure blue
            [0xAA, 0xCC, 0x77], // light green
            [0x44, 0x22, 0x55], // violet
            [0xEE, 0xBB, 0xBB], // pink
            [0x44, 0x55, 0x55], // slate
            [0x00, 0x77, 0xFF], // azure
            [0x00, 0x00, 0x88], // navy
        ];
        match self {
            Self::Cycle(n) => PALETTE[n % PALETTE.len()],
            Self::Rgb(r, g, b) => [r, g, b],
        }
    }

    /// See [`hex`].
    pub(crate) fn hex(self) -> String {
        hex(self.rgb())
    }
}

/// `#rrggbb`.
pub(crate) fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// CIELAB (D65) of linear red, green, blue.
    fn lab(linear: [f64; 3]) -> [f64; 3] {
        let of = |row: [f64; 3], white: f64| {
            let v = row.iter().zip(linear).map(|(a, b)| a * b).sum::<f64>() / white;
            if v > 0.008_856 {
                v.cbrt()
            } else {
                7.787 * v + 16.0 / 116.0
            }
        };
        let x = of([0.4124, 0.3576, 0.1805], 0.9505);
        let y = of([0.2126, 0.7152, 0.0722], 1.0);
        let z = of([0.0193, 0.1192, 0.9505], 1.089);
        [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
    }

    /// As seen with all cones, without green and without red ones (Machado, Oliveira & Fernandes 2009, severity 1).
    fn seen(color: Color) -> [[f64; 3]; 3] {
        let linear = color.rgb().map(|c| {
            let c = f64::from(c) / 255.0;
            if c <= 0.040_45 {
                c / 12.92
            } else {
                ((c + 0.055) / 1.055).powf(2.4)
            }
        });
        let without_green = [
            [0.367_322, 0.860_646, -0.227_968],
            [0.280_085, 0.672_501, 0.047_413],
            [-0.011_820, 0.042_940, 0.968_881],
        ];
        let without_red = [
            [0.152_286, 1.052_583, -0.204_868],
            [0.114_503, 0.786_281, 0.099_216],
            [-0.003_882, -0.048_116, 1.051_998],
        ];
        let through = |m: [[f64; 3]; 3]| {
            m.map(|row| {
                let v: f64 = row.iter().zip(linear).map(|(a, b)| a * b).sum();
                v.clamp(0.0, 1.0)
            })
        };
        [
            lab(linear),
            lab(through(without_green)),
            lab(through(without_red)),
        ]
    }

    #[test]
    fn analytic_sixteen_colours_are_apart() {
        let apart = |a: usize, b: usize| {
            let (a, b) = (seen(Color::Cycle(a)), seen(Color::Cycle(b)));
            let each = a.iter().zip(&b).map(|(a, b)| {
                let squares = a.iter().zip(b).map(|(a, b)| (a - b).powi(2));
                squares.sum::<f64>().sqrt()
            });
            each.fold(f64::INFINITY, f64::min)
        };
        for a in 0..16 {
            for b in 0..a {
                // The closest two of Okabe and Ito's are 17.03 apart.
                assert!(apart(a, b) > 17.0, "{a} {b} {}", apart(a, b));
            }
        }
        assert_eq!(Color::Cycle(16).rgb(), Color::Cycle(0).rgb());
    }
}
