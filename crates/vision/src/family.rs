//! The tags: AprilTag's family 36h11.
//!
//! A tag is a square of 8 × 8 cells: a black border of one cell around 6 × 6
//! cells of data, white for one and black for zero, read row by row from the
//! top left with the code word's highest bit first (Olson 2011; Wang & Olson
//! 2016). Around it there has to be a white margin of at least a cell. The
//! detector knows all 587 codes of the family; [`cells`] knows those that are of
//! use for nested pads, to draw them.

/// Number of ids of the family.
pub const IDS: u32 = 587;

/// Cells along a side, with the border.
pub const CELLS: usize = 8;

/// Code words, ascending by id: the first ones, those whose four middle cells
/// are white and those whose four corner cells are.
const CODES: &[(u32, u64)] = &[
    (0, 0xd5d628584),
    (1, 0xd97f18b49),
    (2, 0xdd280910e),
    (3, 0xe479e9c98),
    (25, 0xadc58d9eb),
    (39, 0x9f53856b5),
    (63, 0xa708d89fb),
    (72, 0xa76c4b1b7),
    (77, 0x5e6b3d231),
    (96, 0x6e079cc9b),
    (111, 0xe0439ceee),
    (112, 0xfd8b1fd16),
    (122, 0x94f5af4b5),
    (128, 0x95bc9442d),
    (154, 0xa40c81aef),
    (162, 0xb6c475339),
    (164, 0x844e351eb),
    (176, 0x07c3fd502),
    (177, 0xe768b5caf),
    (200, 0x9c7b5cc92),
    (207, 0xd60717437),
    (212, 0xad154c067),
    (217, 0xd5e21ea23),
    (229, 0x875b73bab),
    (236, 0xc25f9df96),
    (241, 0x5acf8c455),
    (256, 0xf2ff6c116),
    (273, 0x992f8c531),
    (287, 0x9ed9d672b),
    (288, 0x96cdd15f3),
    (301, 0xfb57dcd11),
    (309, 0x8b63fe66f),
    (323, 0xf63b3e129),
    (331, 0xae9182db3),
    (339, 0x76a73fd59),
    (349, 0x092fcecda),
    (352, 0xb6948e627),
    (371, 0x7ca7fe2bd),
    (384, 0x7c6b4c86c),
    (385, 0xfd492e071),
    (399, 0xbb770e22e),
    (402, 0xa5fd27b3b),
    (406, 0xcd3ca50b1),
    (409, 0xec2655277),
    (412, 0xa4b01eb69),
    (415, 0x877ec3e25),
    (438, 0xe5a86d2ff),
    (461, 0x367bcddcd),
    (463, 0xa7f5b853d),
    (473, 0x34770d903),
    (482, 0x353f1e6a0),
    (486, 0xd66faf540),
    (487, 0x44831e652),
    (527, 0xa4d7338a7),
    (531, 0x97ae260bb),
    (543, 0x3817ac8f5),
    (548, 0xb4bf69677),
    (549, 0xae21868ed),
    (552, 0x8eee297a9),
    (555, 0xac69e0a3d),
    (556, 0x9ed83a1e1),
    (559, 0x50dfbc6bf),
    (568, 0x2fe70e053),
    (583, 0x3347ac48a),
];

/// The cells of the tag `id`, row by row from the top left of the print, true
/// for white; `None` for an id that is not in the table here.
#[must_use]
pub fn cells(id: u32) -> Option<[[bool; CELLS]; CELLS]> {
    let found = CODES.binary_search_by_key(&id, |&(known, _)| known).ok()?;
    let code = CODES[found].1;
    let mut cells = [[false; CELLS]; CELLS];
    for row in 0..6 {
        for column in 0..6 {
            cells[row + 1][column + 1] = code >> (35 - 6 * row - column) & 1 == 1;
        }
    }
    Some(cells)
}

/// The ids of which [`cells`] knows the print, ascending.
pub fn drawable() -> impl Iterator<Item = u32> {
    CODES.iter().map(|&(id, _)| id)
}

/// The four middle cells are white: a smaller tag may stand there.
#[must_use]
pub fn holds_a_tag(id: u32) -> bool {
    cells(id).is_some_and(|c| c[3][3] && c[3][4] && c[4][3] && c[4][4])
}

/// The four corner cells of the data are white: inside another tag's middle,
/// at [`NEST`] of its size, white is where that tag's cells are sampled.
#[must_use]
pub fn stands_in_a_tag(id: u32) -> bool {
    cells(id).is_some_and(|c| c[1][1] && c[1][6] && c[6][1] && c[6][6])
}

/// Size of a tag over that of the tag in whose middle it stands: 1.6 of the two
/// white cells, so that a white margin of one of its own cells is left.
pub const NEST: f64 = 0.2;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn xval_prints_are_those_of_the_published_images() {
        // Read off the published pictures tag36_11_00000.png and tag36_11_00323.png.
        for (id, picture) in [
            (
                0,
                ["..#.#.", "#...#.", "#..###", ".#.###", "#.#..#", "###.##"],
            ),
            (
                323,
                ["....#.", ".###..", ".#..##", ".....#", "###.##", ".#.##."],
            ),
        ] {
            let cells = cells(id).unwrap();
            for (row, line) in picture.iter().enumerate() {
                for (column, cell) in line.bytes().enumerate() {
                    assert_eq!(cells[row + 1][column + 1], cell == b'.');
                }
            }
            assert!(cells[0] == [false; CELLS] && cells[7] == [false; CELLS]);
            assert!(cells.iter().all(|row| !row[0] && !row[7]));
        }
        assert!(cells(IDS).is_none());
    }

    #[test]
    fn prop_codes_are_far_apart_however_they_are_turned() {
        // The family's distance of 11 holds between any two and against turns.
        let turned = |code: u64| {
            let bit = |row: usize, column: usize| code >> (35 - 6 * row - column) & 1;
            (0..36).fold(0, |all, i| all << 1 | bit(5 - i % 6, i / 6))
        };
        for (i, &(id, code)) in CODES.iter().enumerate() {
            assert!(id < IDS && code < 1 << 36);
            assert!(i == 0 || CODES[i - 1].0 < id);
            let mut turn = code;
            for quarter in 0..4 {
                for &(other, word) in CODES {
                    let far = (word ^ turn).count_ones() >= 11;
                    assert!(far || (other == id && quarter == 0), "{id} and {other}");
                }
                turn = turned(turn);
            }
            assert_eq!(turn, code);
        }
    }

    #[test]
    fn prop_some_tags_nest() {
        assert_eq!(drawable().filter(|&id| holds_a_tag(id)).count(), 27);
        assert!(holds_a_tag(323) && stands_in_a_tag(323));
        assert!(holds_a_tag(77) && stands_in_a_tag(25) && !stands_in_a_tag(77));
    }
}
