//! Colours that stay apart for every reader.

/// A colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Color {
    /// The n-th of eight colours that people with any colour vision can tell apart (Okabe & Ito 2008); wraps round.
    Cycle(usize),
    /// Red, green, blue.
    Rgb(u8, u8, u8),
}

impl Color {
    /// Near black, for references.
    pub const BLACK: Self = Self::Rgb(0x22, 0x22, 0x22);
    /// Grey, for what stands in the background.
    pub const GREY: Self = Self::Rgb(0x80, 0x80, 0x80);

    /// Red, green, blue. The palette is that of Okabe & Ito (2008), strongest on white first.
    pub fn rgb(self) -> [u8; 3] {
        const OKABE_ITO: [[u8; 3]; 8] = [
            [0x00, 0x72, 0xB2], // blue
            [0xD5, 0x5E, 0x00], // vermillion
            [0x00, 0x9E, 0x73], // bluish green
            [0xCC, 0x79, 0xA7], // reddish purple
            [0xE6, 0x9F, 0x00], // orange
            [0x56, 0xB4, 0xE9], // sky blue
            [0x00, 0x00, 0x00], // black
            [0xF0, 0xE4, 0x42], // yellow
        ];
        match self {
            Self::Cycle(n) => OKABE_ITO[n % OKABE_ITO.len()],
            Self::Rgb(r, g, b) => [r, g, b],
        }
    }

    /// `#rrggbb`.
    pub(crate) fn hex(self) -> String {
        let [r, g, b] = self.rgb();
        format!("#{r:02x}{g:02x}{b:02x}")
    }
}
