//! One cell of a text table: gap, number, date-time stamp or text.

/// Content of a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Cell {
    Gap,
    Number(f64),
    /// A number with a decimal comma.
    CommaNumber(f64),
    /// Nanoseconds from 1970-01-01 00:00 UTC.
    Stamp(i64),
    Text,
}

/// Words for a missing value, in addition to those that parse as NaN.
const GAP_WORDS: [&str; 10] = [
    "na",
    "n/a",
    "#n/a",
    "null",
    "none",
    "-",
    "--",
    "-nan(ind)",
    "nan(ind)",
    "1.#qnan",
];

/// `comma` states whether a comma may be the decimal point, which it cannot where it
/// separates cells.
pub(crate) fn classify(cell: &[u8], comma: bool) -> Cell {
    let Ok(text) = std::str::from_utf8(cell) else {
        return Cell::Text;
    };
    let text = text.trim();
    if text.is_empty() {
        return Cell::Gap;
    }
    if let Ok(number) = text.parse::<f64>() {
        return if number.is_nan() {
            Cell::Gap
        } else {
            Cell::Number(number)
        };
    }
    if GAP_WORDS.iter().any(|word| text.eq_ignore_ascii_case(word)) {
        return Cell::Gap;
    }
    if text.eq_ignore_ascii_case("true") {
        return Cell::Number(1.0);
    }
    if text.eq_ignore_ascii_case("false") {
        return Cell::Number(0.0);
    }
    let one_comma = comma && text.bytes().filter(|&b| b == b',').count() == 1;
    if one_comma
        && !text.contains('.')
        && let Ok(number) = text.replace(',', ".").parse::<f64>()
    {
        return Cell::CommaNumber(number);
    }
    parse_stamp(text).map_or(Cell::Text, Cell::Stamp)
}

/// Whether a text is a number with thousands separators: groups of three digits with a comma, an apostrophe or a blank
/// between them. Points part versions and addresses too, and plain spaces part words: with them a number must have a
/// decimal mark as well.
pub(crate) fn has_thousands_separators(text: &str) -> bool {
    let text = text.trim();
    let text = text.strip_prefix(['+', '-']).unwrap_or(text);
    let has_groups = |whole: &str, separator: char| {
        let digits = |group: &str| group.bytes().all(|b| b.is_ascii_digit());
        let Some((first, others)) = whole.split_once(separator) else {
            return false;
        };
        (1..=3).contains(&first.len())
            && digits(first)
            && others
                .split(separator)
                .all(|group| group.len() == 3 && digits(group))
    };
    let with_decimal = |separator: char, decimal: char| {
        text.split_once(decimal).is_some_and(|(whole, fraction)| {
            has_groups(whole, separator) && fraction.bytes().all(|b| b.is_ascii_digit())
        })
    };
    // An apostrophe, its typographic form, a no-break space and a narrow one separate nothing else within digits.
    let only_of_numbers = ['\'', '\u{2019}', '\u{a0}', '\u{202f}'];
    has_groups(text, ',')
        || only_of_numbers.iter().any(|mark| has_groups(text, *mark))
        || with_decimal(',', '.')
        || with_decimal('.', ',')
        || only_of_numbers
            .iter()
            .chain(&[' '])
            .any(|mark| with_decimal(*mark, '.') || with_decimal(*mark, ','))
}

/// `2019-11-07 18:45:58:868`: year first, `-` or `/`, a space or `T`, seconds with a fraction
/// after `.`, `,` or (three, six or nine digits) `:`, then nothing, `Z` or an offset such as
/// `+02:00`. A stamp without an offset counts as UTC.
fn parse_stamp(text: &str) -> Option<i64> {
    let bytes = text.as_bytes();
    if bytes.len() < 19 || !bytes[..19].is_ascii() {
        return None;
    }
    let separators = matches!(
        (bytes[4], bytes[7], bytes[10], bytes[13], bytes[16]),
        (b'-', b'-', b' ' | b'T' | b't', b':', b':') | (b'/', b'/', b' ' | b'T' | b't', b':', b':')
    );
    let number = |from: usize, to: usize| {
        bytes[from..to].iter().try_fold(0_i64, |sum, &b| {
            b.is_ascii_digit().then(|| sum * 10 + i64::from(b - b'0'))
        })
    };
    let (year, month, day) = (number(0, 4)?, number(5, 7)?, number(8, 10)?);
    let (hour, minute, second) = (number(11, 13)?, number(14, 16)?, number(17, 19)?);
    // The years keep nanoseconds within 64 bits.
    let in_range = (1700..=2200).contains(&year)
        && (1..=12).contains(&month)
        && (1..=days_in_month(year, month)).contains(&day)
        && hour < 24
        && minute < 60
        && second <= 60;
    if !separators || !in_range {
        return None;
    }
    let (nanoseconds, rest) = fraction(&text[19..])?;
    let seconds = days_from_epoch(year, month, day) * 86_400 + hour * 3600 + minute * 60 + second
        - offset_seconds(rest)?;
    Some(seconds * 1_000_000_000 + nanoseconds)
}

/// The fraction of a second in nanoseconds, and what follows it.
fn fraction(text: &str) -> Option<(i64, &str)> {
    let Some(separator) = text.bytes().next().filter(|b| b".,:".contains(b)) else {
        return Some((0, text));
    };
    let digits = text[1..].bytes().take_while(u8::is_ascii_digit).count();
    let whole = separator != b':' || digits.is_multiple_of(3);
    if digits == 0 || digits > 9 || !whole {
        return None;
    }
    let value: i64 = text[1..=digits].parse().ok()?;
    let scale = 10_i64.pow(9 - u32::try_from(digits).ok()?);
    Some((value * scale, &text[1 + digits..]))
}

fn offset_seconds(text: &str) -> Option<i64> {
    let text = text.trim();
    if text.is_empty() || text.eq_ignore_ascii_case("z") || text == "UTC" {
        return Some(0);
    }
    let sign = match text.bytes().next()? {
        b'+' => 1,
        b'-' => -1,
        _ => return None,
    };
    let digits: String = text[1..].chars().filter(|&c| c != ':').collect();
    if digits.len() != 4 || !digits.bytes().all(|b| b.is_ascii_digit()) {
        return None;
    }
    let (hours, minutes): (i64, i64) = (digits[..2].parse().ok()?, digits[2..].parse().ok()?);
    (hours < 24 && minutes < 60).then_some(sign * (hours * 3600 + minutes * 60))
}

fn is_leap(year: i64) -> bool {
    year % 4 == 0 && (year % 100 != 0 || year % 400 == 0)
}

fn days_in_month(year: i64, month: i64) -> i64 {
    match month {
        2 if is_leap(year) => 29,
        2 => 28,
        4 | 6 | 9 | 11 => 30,
        _ => 31,
    }
}

/// Days from 1970-01-01 in the Gregorian calendar.
fn days_from_epoch(year: i64, month: i64, day: i64) -> i64 {
    let leap_days = |y: i64| y / 4 - y / 100 + y / 400;
    let before_year = (year - 1970) * 365 + leap_days(year - 1) - leap_days(1969);
    let before_month: i64 = (1..month).map(|m| days_in_month(year, m)).sum();
    before_year + before_month + day - 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_numbers_and_gaps() {
        assert_eq!(classify(b" -1.5e-3 ", false), Cell::Number(-1.5e-3));
        assert_eq!(classify(b"1,5", true), Cell::CommaNumber(1.5));
        assert_eq!(classify(b"1,5", false), Cell::Text);
        assert_eq!(classify(b"1,234,567", true), Cell::Text);
        assert_eq!(classify(b"TRUE", false), Cell::Number(1.0));
        for gap in ["", "  ", "nan", "-NaN", "N/A", "--", "null"] {
            assert_eq!(classify(gap.as_bytes(), false), Cell::Gap, "{gap:?}");
        }
        assert_eq!(classify(b"\xff\xfe", false), Cell::Text);
        assert_eq!(classify(b"1.5x", false), Cell::Text);
    }

    #[test]
    fn analytic_numbers_with_thousands_separators_are_told_from_other_text() {
        for number in [
            "13,307.3",
            " -1,234 ",
            "1,234,567",
            "13.307,3",
            "1'234.5",
            "1\u{2019}234",
            "13\u{202f}307,3",
            "13 307.3",
            "1\u{a0}234",
        ] {
            assert!(has_thousands_separators(number), "{number}");
        }
        for text in [
            "",
            ",",
            "13307.3",
            "1,23",
            "1234,567",
            "1,2345",
            ",123",
            "192.168.100.200",
            "1.234.567",
            "640 480",
            "1,234 N",
            "a,123",
            "12:30:45",
        ] {
            assert!(!has_thousands_separators(text), "{text}");
        }
    }

    #[test]
    fn xval_stamps() {
        // From GNU date: `date -u -d '2019-11-07 18:45:58' +%s` and so on.
        for (text, seconds, nanoseconds) in [
            ("2019-11-07 18:45:58:868", 1_573_152_358, 868_000_000),
            ("2019-11-07T18:45:58.5Z", 1_573_152_358, 500_000_000),
            ("2019/11/07 20:45:58+02:00", 1_573_152_358, 0),
            ("2000-02-29 00:00:00", 951_782_400, 0),
            ("1969-12-31 23:59:59,25", -1, 250_000_000),
        ] {
            assert_eq!(
                classify(text.as_bytes(), false),
                Cell::Stamp(seconds * 1_000_000_000 + nanoseconds),
                "{text}"
            );
        }
        for text in [
            "2019-02-29 00:00:00",
            "2019-13-01 00:00:00",
            "2019-11-07 18:45:58:86",
            "2019-11-07 18:45:58.",
            "2019-11-07 18:45",
            "2019-11-07 18:45:58 noon",
            "2019-11-07 18:45:58+é0:00",
        ] {
            assert_eq!(classify(text.as_bytes(), false), Cell::Text, "{text}");
        }
    }
}
