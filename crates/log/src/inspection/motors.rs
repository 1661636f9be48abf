//! Recognises commands and speeds of motors, common or one for each motor.

use super::recognise::{Guess, plain};
use super::suggest::quoted;
use super::units::quantity_of;
use crate::ColumnSummary;
use std::collections::HashMap;

/// Names of motor commands. With a number at its end, a name means one motor.
const MOTORS: [&str; 17] = [
    "throttle",
    "thr",
    "pwm",
    "motor",
    "motors",
    "esc",
    "escsignal",
    "motorpwm",
    "duty",
    "motorout",
    "gas",
    "cmd",
    "motorcmd",
    "motorcommand",
    "esccmd",
    "thrustcmd",
    "actuatorthrust",
];
const NUMBERED: [&str; 11] = [
    "m",
    "motor",
    "pwm",
    "esc",
    "motorpwm",
    "motorm",
    "throttle",
    "output",
    "motorout",
    "actuator",
    "actuators",
];
/// Those of the names that may also be forces.
const FORCES: [&str; 2] = ["thrustcmd", "actuatorthrust"];
/// Number of motors of most vehicles. Autopilots log eight or more outputs, of which some are
/// not connected.
const USUAL: usize = 4;

/// Part of the greatest speed among rotors below which one is dead. Rotors of one vehicle that fly differ by less than
/// a half; a sensor without a rotor gives a percent.
const DEAD: f64 = 0.05;

/// Columns of numbers whose names differ by a number.
pub(crate) struct Groups {
    /// By the name without its digits.
    rotors: HashMap<String, Vec<usize>>,
    /// By the name in letters and digits, without the number of one byte at its end.
    motors: HashMap<String, Vec<usize>>,
}

impl Groups {
    pub(crate) fn of(columns: &[ColumnSummary]) -> Self {
        let mut groups = Self {
            rotors: HashMap::new(),
            motors: HashMap::new(),
        };
        for (at, column) in columns.iter().enumerate() {
            if column.text.is_some() || column.count == 0 {
                continue;
            }
            let stem = without_digits(&column.name);
            groups.rotors.entry(stem).or_default().push(at);
            let name = plain(&column.name);
            if let Some(stem) = numbered(&name) {
                groups.motors.entry(stem.to_owned()).or_default().push(at);
            }
        }
        groups
    }
}

fn without_digits(name: &str) -> String {
    name.replace(|c: char| c.is_ascii_digit(), "")
}

/// The stem of a name that ends in a number of one byte.
fn numbered(name: &str) -> Option<&str> {
    let stem = name.trim_end_matches(|c: char| c.is_ascii_digit());
    name[stem.len()..].parse::<u8>().ok().map(|_| stem)
}

/// Numbered outputs that have a motor. With many outputs, constant ones count as not connected.
fn connected(group: Vec<usize>, columns: &[ColumnSummary]) -> Vec<usize> {
    let vary = group.iter().copied().filter(|&i| !columns[i].constant);
    let vary: Vec<usize> = vary.collect();
    if group.len() > USUAL && !vary.is_empty() {
        vary
    } else {
        group
    }
}

/// The mean speed of rotors whose columns differ by a number in their names, without those that
/// never turn.
pub(crate) fn rotors(at: usize, columns: &[ColumnSummary], groups: &Groups) -> Option<Guess> {
    let own = &columns[at].name;
    let stem = without_digits(own);
    let (base, unit) = quantity_of(&stem, columns[at].unit.as_deref());
    let is_speed = base.contains("rpm") && matches!(unit.as_str(), "" | "rpm")
        || unit == "rpm"
            && ["speed", "rotor", "motor", "esc"]
                .iter()
                .any(|word| base.contains(word));
    if stem == *own || !is_speed {
        return None;
    }
    let all = groups.rotors.get(&stem)?;
    // A rotor that never turns, or whose sensor gives noise about zero, would lower the mean.
    let fastest = |i: usize| {
        columns[i]
            .max
            .unwrap_or(0.0)
            .max(-columns[i].min.unwrap_or(0.0))
    };
    let most = all.iter().map(|&i| fastest(i)).fold(0.0, f64::max);
    let turn = |&i: &usize| fastest(i) > DEAD * most;
    let turning: Vec<usize> = all.iter().copied().filter(turn).collect();
    let group = if turning.is_empty() { all } else { &turning };
    // Speeds whose sign is the sense of rotation would cancel.
    let has_sense = group.iter().any(|&i| columns[i].min < Some(0.0));
    let term = |&i: &usize| {
        let quoted = quoted(&columns[i].name);
        if has_sense {
            format!("abs({quoted})")
        } else {
            quoted
        }
    };
    let terms: Vec<String> = group.iter().map(term).collect();
    let expression = match &terms[..] {
        [one] => one.clone(),
        many => format!("({}) / {}", many.join(" + "), many.len()),
    };
    Some(Guess {
        channel: "rotor_rpm",
        expression,
        averaged: terms.len(),
        columns: all.clone(),
        ..Guess::default()
    })
}

/// The mean of the commands of all motors, or the command of all.
pub(crate) fn motors(at: usize, columns: &[ColumnSummary], groups: &Groups) -> Option<Guess> {
    let name = plain(&columns[at].name);
    let stem = name.trim_end_matches(|c: char| c.is_ascii_digit());
    let group: Vec<usize> = if stem.len() < name.len() {
        if !NUMBERED.contains(&stem) || numbered(&name).is_none() {
            return None;
        }
        connected(groups.motors.get(stem)?.clone(), columns)
    } else if MOTORS.contains(&name.as_str()) || name.contains("throttle") {
        vec![at]
    } else {
        return None;
    };
    let most = group
        .iter()
        .filter_map(|&i| columns[i].max)
        .fold(f64::NAN, f64::max);
    let least = group
        .iter()
        .filter_map(|&i| columns[i].min)
        .fold(f64::NAN, f64::min);
    let is_force = FORCES.contains(&name.as_str());
    let (low, range, what) = match most {
        _ if least < 0.0 => return None,
        // A column that may also be in newtons counts only if its size excludes that.
        _ if is_force && most > 1.0 && most <= 20_000.0 => return None,
        _ if name == "cmd" && (least < 800.0 || most > 2300.0) => return None,
        ..=0.0 => return None,
        ..=1.0 => (0.0, 1.0, "of 1"),
        ..=100.0 => (0.0, 100.0, "of 100"),
        ..=255.0 => (0.0, 255.0, "of 255"),
        900.0..=2300.0 => (1000.0, 1000.0, "µs from 1000 to 2000"),
        ..=1000.0 => (0.0, 1000.0, "of 1000"),
        ..=65_535.0 => (0.0, 65_535.0, "of 65535"),
        _ => return None,
    };
    let term = |&i: &usize| {
        let quoted = quoted(&columns[i].name);
        if low > 0.0 {
            format!("max({quoted} - {low}, 0)")
        } else {
            quoted
        }
    };
    let terms: Vec<String> = group.iter().map(term).collect();
    let divisor = range * group.len() as f64;
    let expression = match (&terms[..], divisor == 1.0) {
        ([one], true) => one.clone(),
        ([one], false) => format!("{one} / {divisor}"),
        (all, _) => format!("({}) / {divisor}", all.join(" + ")),
    };
    let scale = (range != 1.0 || is_force).then(|| format!("{what} by its size"));
    Some(Guess {
        channel: "throttle",
        expression,
        check: scale,
        averaged: group.len(),
        columns: group,
        ..Guess::default()
    })
}
