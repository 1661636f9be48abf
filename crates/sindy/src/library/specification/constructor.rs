//! The constructors in a text: their arguments, and the library that they make.

use super::scan::TokenKind;
use super::{Reader, error};
use crate::error::SindyError;
use crate::library::{Interaction, Library, Polynomial};

/// The arguments of a constructor.
#[derive(Default)]
struct Arguments {
    numbers: Vec<Number>,
    options: Vec<KeyValue>,
    /// Those that are named, else all.
    variables: Vec<String>,
}

/// A constructor with the tokens of its name and its closing parenthesis.
struct Call<'a> {
    first: usize,
    close: usize,
    arguments: &'a Arguments,
}

/// A library, or why its own rules refuse the arguments.
type Refusable = Result<Library, SindyError>;

impl Arguments {
    fn values(&self) -> Vec<f64> {
        self.numbers.iter().map(|n| n.value).collect()
    }
}

#[derive(Clone, Copy)]
struct Number {
    at: usize,
    value: f64,
}

/// `key=value`.
struct KeyValue {
    at: usize,
    key: String,
    value: String,
}

impl Reader<'_> {
    /// The constructor whose name is at `first` and whose parentheses close at `close`.
    pub(super) fn constructor(
        &mut self,
        first: usize,
        close: usize,
    ) -> Result<Library, SindyError> {
        let arguments = self.arguments(first, close)?;
        let call = Call {
            first,
            close,
            arguments: &arguments,
        };
        let library = match self.word(&self.tokens[first]) {
            "poly" => self.polynomial(&call)?,
            "fourier" => self.fourier(&call)?,
            "exp" => self.exponentials(&call)?,
            _ => self.rationals(&call)?,
        };
        let library = library.map_err(|refused| match refused {
            SindyError::Setting {
                key,
                expected,
                found,
            } => {
                let start = self.tokens[first].start;
                let expected = match key {
                    "library" => expected,
                    key => format!("{key}: {expected}"),
                };
                error(self.text, start, expected, found)
            }
            other => other,
        })?;
        self.spend(library.len())?;
        Ok(library)
    }

    fn polynomial(&self, call: &Call<'_>) -> Result<Refusable, SindyError> {
        let [degree] = call.arguments.numbers[..] else {
            return Err(self.count(call, "one number, the degree: `poly(degree)`"));
        };
        let mut library = Polynomial::new(self.whole(degree, "the degree")?);
        for option in &call.arguments.options {
            library = match (option.key.as_str(), option.value.as_str()) {
                ("bias", "true") => library.bias(true),
                ("bias", "false") => library.bias(false),
                ("interaction", "all") => library.interaction(Interaction::All),
                ("interaction", "none") => library.interaction(Interaction::None),
                ("interaction", "only") => library.interaction(Interaction::Only),
                _ => {
                    let expected = "`bias=true` or `false`, `interaction=all`, `none` or `only`";
                    return Err(self.fail(option.at, expected));
                }
            };
        }
        Ok(library.library(&call.arguments.variables))
    }

    fn fourier(&self, call: &Call<'_>) -> Result<Refusable, SindyError> {
        let [frequencies] = call.arguments.numbers[..] else {
            let expected = "one number, of frequencies: `fourier(frequencies)`";
            return Err(self.count(call, expected));
        };
        let frequencies = self.whole(frequencies, "the number of frequencies")? as usize;
        let mut base = 1.0;
        for option in &call.arguments.options {
            base = match (option.key.as_str(), option.value.parse()) {
                ("base", Ok(base)) => base,
                _ => return Err(self.fail(option.at, "`base=`, a frequency")),
            };
        }
        let names = &call.arguments.variables;
        Ok(Library::fourier_of_base(names, frequencies, base))
    }

    fn exponentials(&self, call: &Call<'_>) -> Result<Refusable, SindyError> {
        if let Some(option) = call.arguments.options.first() {
            return Err(self.fail(option.at, "rates, then names of variables"));
        }
        let rates = call.arguments.values();
        Ok(Library::exponentials(&call.arguments.variables, &rates))
    }

    fn rationals(&self, call: &Call<'_>) -> Result<Refusable, SindyError> {
        let scales = call.arguments.values();
        if scales.is_empty() {
            return Err(self.count(call, "scales: `rational(scale, …)`"));
        }
        let mut powers = Vec::new();
        for option in &call.arguments.options {
            match (option.key.as_str(), option.value.parse::<u32>()) {
                ("power", Ok(power)) => powers.push(power),
                _ => return Err(self.fail(option.at, "`power=`, a whole number")),
            }
        }
        if powers.is_empty() {
            powers.push(1);
        }
        let names = &call.arguments.variables;
        Ok(Library::bounded_rationals(names, &scales, &powers))
    }

    fn arguments(&self, first: usize, close: usize) -> Result<Arguments, SindyError> {
        let mut read = Arguments::default();
        let inside = first + 2..close;
        let parts = if inside.is_empty() {
            Vec::new()
        } else {
            self.split(inside, ",")
        };
        for part in parts {
            let at = part.start;
            let (negative, digits) = match self.is(at, "-") {
                true => (true, at + 1),
                false => (false, at),
            };
            let number = self.tokens[..part.end].get(digits);
            if let Some(token) = number.filter(|t| t.kind == TokenKind::Number) {
                let one = digits + 1 == part.end;
                let alone = read.variables.is_empty() && read.options.is_empty();
                let value = self
                    .word(token)
                    .parse()
                    .ok()
                    .filter(|v: &f64| v.is_finite());
                let (true, true, Some(value)) = (one, alone, value) else {
                    let expected = "a number before the names, or a name of a variable";
                    return Err(self.fail(if one { at } else { digits + 1 }, expected));
                };
                let value: f64 = if negative { -value } else { value };
                read.numbers.push(Number { at, value });
            } else if part.len() >= 3 && self.is(at + 1, "=") {
                let value = part.start + 2..part.end;
                read.options.push(KeyValue {
                    at,
                    key: self.word(&self.tokens[at]).into(),
                    value: value.map(|at| self.word(&self.tokens[at])).collect(),
                });
            } else {
                let name = self.tokens[..part.end].get(at);
                let name = name.and_then(|t| t.name(self.text));
                match name.filter(|n| part.len() == 1 && self.variables.contains(n)) {
                    Some(name) if read.variables.contains(&name) => {
                        return Err(self.fail(at, "each variable once"));
                    }
                    Some(name) => read.variables.push(name),
                    None => {
                        let expected = format!("a number or a variable ({})", self.known());
                        return Err(self.fail(at, expected));
                    }
                }
            }
        }
        if read.variables.is_empty() {
            read.variables.clone_from(&self.variables);
        }
        Ok(read)
    }

    fn whole(&self, number: Number, what: &str) -> Result<u32, SindyError> {
        let whole = number.value.trunc() == number.value;
        if whole && (0.0..=f64::from(u32::MAX)).contains(&number.value) {
            return Ok(number.value as u32);
        }
        Err(self.fail(number.at, format!("a whole number, {what}")))
    }

    /// The error of a wrong number of numbers: at the second, or where the first is missing.
    fn count(&self, call: &Call<'_>, expected: &str) -> SindyError {
        let inside = call.first + 2;
        let missing = if call.close == inside {
            call.close
        } else {
            inside
        };
        let numbers = &call.arguments.numbers;
        self.fail(numbers.get(1).map_or(missing, |n| n.at), expected)
    }
}
