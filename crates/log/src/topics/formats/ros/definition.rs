//! Message definitions of ROS 1 and ROS 2: text such as `float64[3] position`, the definitions of
//! inner messages below lines of `=`.

use crate::limits::NameBudget;
use crate::topics::fields::make_unique;
use crate::topics::sink::Scalar;
use std::collections::HashMap;

/// No message is longer, in bytes.
const LONGEST: usize = 64 << 20;
/// Deepest nesting of messages in messages.
const DEEPEST: usize = 16;
/// Most numbers that one message yields.
const MOST_NUMBERS: usize = 4096;
/// Most parts of a definition with all that it refers to.
const MOST_NODES: usize = 20_000;
/// Elements of arrays that become fields: of numbers of a fixed length, of numbers of any length, and
/// of messages.
const TOLD_FIXED: usize = 64;
const TOLD_ANY: usize = 16;
const TOLD_MESSAGES: usize = 8;

/// A part of a message, and the count of numbers that it yields.
#[derive(Debug, Clone)]
pub(super) struct Node {
    pub(super) kind: NodeContent,
    pub(super) width: usize,
}

#[derive(Debug, Clone)]
pub(super) enum NodeContent {
    Scalar(Scalar),
    Text,
    Message(Vec<Node>),
    Array {
        element: Box<Node>,
        /// `None` where the message itself states it.
        length: Option<usize>,
        /// Elements that become fields.
        told: usize,
    },
}

impl Node {
    /// Least possible number of bytes.
    fn least(&self) -> usize {
        match &self.kind {
            NodeContent::Scalar(scalar) => scalar.size(),
            NodeContent::Text => 4,
            NodeContent::Message(nodes) => nodes
                .iter()
                .fold(0, |sum: usize, node| sum.saturating_add(node.least())),
            NodeContent::Array {
                element, length, ..
            } => length.map_or(4, |length| length.saturating_mul(element.least())),
        }
    }
}

/// A definition, prepared for decoding.
#[derive(Debug)]
pub(super) struct Definition {
    pub(super) root: Node,
    /// Names of the numbers, in the order of the message.
    pub(super) names: Vec<String>,
    pub(super) texts: Vec<String>,
}

struct Field<'t> {
    name: &'t str,
    base: &'t str,
    array: Array,
}

#[derive(Clone, Copy)]
enum Array {
    One,
    Fixed(usize),
    Any,
}

/// The messages of a definition, by their full names.
#[derive(Default)]
struct Messages<'t> {
    fields: HashMap<&'t str, Vec<Field<'t>>>,
    /// Full names by their last part, in the order of the text.
    by_last: HashMap<&'t str, Vec<&'t str>>,
}

impl<'t> Messages<'t> {
    /// The fields of a message, which is known from now on.
    fn of(&mut self, name: &'t str) -> &mut Vec<Field<'t>> {
        self.fields.entry(name).or_insert_with(|| {
            let last = name.rsplit('/').next().unwrap_or_default();
            self.by_last.entry(last).or_default().push(name);
            Vec::new()
        })
    }

    /// The full name of a message that another of this package refers to.
    fn full(&self, base: &str, package: &str) -> Option<&'t str> {
        let candidates = [
            base.to_owned(),
            format!("{package}/{base}"),
            format!("{package}/msg/{base}"),
        ];
        let exact = candidates
            .iter()
            .find_map(|name| self.fields.get_key_value(name.as_str()));
        // `Header` means that of std_msgs, and `pkg/Type` means `pkg/msg/Type`.
        let (owner, last) = base.rsplit_once('/').unwrap_or(("", base));
        let owner = owner.trim_end_matches("/msg");
        exact.map(|(name, _)| *name).or_else(|| {
            let mut alike = self.by_last.get(last)?.iter().copied();
            alike.find(|name| {
                let within = name.strip_prefix(owner);
                owner.is_empty() || within.is_some_and(|rest| rest.starts_with('/'))
            })
        })
    }
}

/// Reads the definition of a message of this type; `None` where it is not whole, circular or
/// oversize.
pub(super) fn parse(
    kind: &str,
    text: &str,
    ros1: bool,
    budget: &mut NameBudget,
) -> Option<Definition> {
    let mut messages = Messages::default();
    let mut current = Some(kind);
    for line in text.lines() {
        let line = line.trim();
        if line.len() >= 3 && line.bytes().all(|b| b == b'=') {
            current = None;
        } else if let Some(name) = line.strip_prefix("MSG:") {
            current = Some(name.trim());
            messages.of(name.trim());
        } else if let (Some(name), Some(field)) = (current, parse_field(line)?) {
            messages.of(name).push(field);
        }
    }
    messages.of(kind);
    let mut builder = Builder {
        messages: &messages,
        ros1,
        left: MOST_NODES,
        budget,
    };
    let root = builder.message(kind, package(kind), DEEPEST)?;
    if root.width > MOST_NUMBERS {
        return None;
    }
    let mut naming = Naming {
        messages: &messages,
        ros1,
        names: Vec::new(),
        texts: Vec::new(),
        budget,
    };
    naming.message(kind, package(kind), "")?;
    let Naming {
        mut names,
        mut texts,
        ..
    } = naming;
    make_unique(&mut names);
    make_unique(&mut texts);
    (names.len() == root.width).then_some(Definition { root, names, texts })
}

fn package(kind: &str) -> &str {
    kind.split('/').next().unwrap_or_default()
}

/// A line without its comment: a field, or `Some(None)` for a constant or an empty line.
fn parse_field(line: &str) -> Option<Option<Field<'_>>> {
    let line = line.split('#').next().unwrap_or_default().trim();
    if line.is_empty() {
        return Some(None);
    }
    let (kind, rest) = line.split_once(char::is_whitespace)?;
    let rest = rest.trim_start();
    let name = rest.split(|c: char| c.is_whitespace() || c == '=').next()?;
    if rest[name.len()..].trim_start().starts_with('=') {
        return Some(None);
    }
    let (base, array) = match kind.split_once('[') {
        None => (kind, Array::One),
        Some((base, length)) => match length.strip_suffix(']')? {
            length if length.is_empty() || length.starts_with("<=") => (base, Array::Any),
            length => (base, Array::Fixed(length.parse().ok()?)),
        },
    };
    let base = base.split("<=").next()?;
    (!name.is_empty() && !base.is_empty()).then_some(Some(Field { name, base, array }))
}

fn scalar(base: &str, ros1: bool) -> Option<Scalar> {
    Some(match base {
        "bool" => Scalar::Bool,
        "byte" if ros1 => Scalar::I8,
        "byte" | "char" | "uint8" => Scalar::U8,
        "int8" => Scalar::I8,
        "int16" => Scalar::I16,
        "uint16" => Scalar::U16,
        "int32" => Scalar::I32,
        "uint32" => Scalar::U32,
        "int64" => Scalar::I64,
        "uint64" => Scalar::U64,
        "float32" => Scalar::F32,
        "float64" => Scalar::F64,
        _ => return None,
    })
}

/// The two numbers of a time of ROS 1.
fn time(base: &str, ros1: bool) -> Option<[(&'static str, Scalar); 2]> {
    match base {
        "time" if ros1 => Some([("sec", Scalar::U32), ("nsec", Scalar::U32)]),
        "duration" if ros1 => Some([("sec", Scalar::I32), ("nsec", Scalar::I32)]),
        _ => None,
    }
}

fn told(array: Array, is_message: bool) -> usize {
    match array {
        Array::One => 1,
        Array::Fixed(length) if is_message => length.min(TOLD_MESSAGES),
        Array::Fixed(length) => length.min(TOLD_FIXED),
        Array::Any if is_message => TOLD_MESSAGES,
        Array::Any => TOLD_ANY,
    }
}

struct Builder<'m, 't> {
    messages: &'m Messages<'t>,
    ros1: bool,
    left: usize,
    budget: &'m mut NameBudget,
}

impl Builder<'_, '_> {
    fn message(&mut self, name: &str, package: &str, depth: usize) -> Option<Node> {
        let depth = depth.checked_sub(1)?;
        let fields = self.messages.fields.get(name)?;
        let mut nodes = Vec::new();
        for field in fields {
            self.left = self.left.checked_sub(1)?;
            self.budget.node()?;
            nodes.push(self.field(field, package, depth)?);
        }
        let width = nodes.iter().map(|node| node.width).sum();
        Some(Node {
            kind: NodeContent::Message(nodes),
            width,
        })
    }

    fn field(&mut self, field: &Field<'_>, owner: &str, depth: usize) -> Option<Node> {
        let one = |scalar| Node {
            kind: NodeContent::Scalar(scalar),
            width: 1,
        };
        let mut is_message = true;
        let element = if let Some(scalar) = scalar(field.base, self.ros1) {
            is_message = false;
            one(scalar)
        } else if let Some(parts) = time(field.base, self.ros1) {
            Node {
                kind: NodeContent::Message(parts.map(|(_, scalar)| one(scalar)).into()),
                width: 2,
            }
        } else if field.base == "string" {
            Node {
                kind: NodeContent::Text,
                width: 0,
            }
        } else {
            let name = self.messages.full(field.base, owner)?;
            self.message(name, package(name), depth)?
        };
        if matches!(field.array, Array::One) {
            return Some(element);
        }
        // Elements without bytes would allow arrays of any length, which cost only time.
        let least = element.least();
        let fits = |length: usize| length.saturating_mul(least) <= LONGEST;
        if least == 0 || matches!(field.array, Array::Fixed(length) if !fits(length)) {
            return None;
        }
        let told = told(field.array, is_message);
        let length = match field.array {
            Array::Fixed(length) => Some(length),
            _ => None,
        };
        // An array of any length yields its length too.
        let width = element.width.checked_mul(told)? + usize::from(length.is_none());
        let kind = NodeContent::Array {
            element: Box::new(element),
            length,
            told,
        };
        (width <= MOST_NUMBERS).then_some(Node { kind, width })
    }
}

/// Names in the order in which the nodes yield their numbers.
struct Naming<'m, 't> {
    messages: &'m Messages<'t>,
    ros1: bool,
    names: Vec<String>,
    texts: Vec<String>,
    budget: &'m mut NameBudget,
}

impl Naming<'_, '_> {
    /// The names of a message's fields, with this before them; `None` if they are too many or too long.
    fn message(&mut self, name: &str, owner: &str, prefix: &str) -> Option<()> {
        for field in self.messages.fields.get(name).into_iter().flatten() {
            let is_message = scalar(field.base, self.ros1).is_none();
            let label = format!("{prefix}{}", field.name);
            match field.array {
                Array::One => {
                    self.field(field, owner, label)?;
                    continue;
                }
                _ if field.base == "string" => self.field(field, owner, format!("{label}[]"))?,
                array => {
                    for k in 0..told(array, is_message) {
                        self.field(field, owner, format!("{label}[{k}]"))?;
                    }
                }
            }
            if matches!(field.array, Array::Any) {
                self.number(format!("{label}.length"))?;
            }
        }
        Some(())
    }

    /// The names of one element of a field.
    fn field(&mut self, field: &Field<'_>, owner: &str, label: String) -> Option<()> {
        if scalar(field.base, self.ros1).is_some() {
            self.number(label)?;
        } else if let Some(parts) = time(field.base, self.ros1) {
            for (part, _) in parts {
                self.number(format!("{label}.{part}"))?;
            }
        } else if field.base == "string" {
            self.budget.name(&label)?;
            self.texts.push(label);
        } else if let Some(inner) = self.messages.full(field.base, owner) {
            // A message without numbers and texts has a name for each of its elements all the same.
            self.budget.node()?;
            self.message(inner, package(inner), &format!("{label}."))?;
        }
        Some(())
    }

    fn number(&mut self, label: String) -> Option<()> {
        self.budget.name(&label)?;
        self.names.push(label);
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ODOMETRY: &str = "std_msgs/Header header # when
string child_frame_id
Pose pose
float64[<=4] speeds 0
uint8 KIND=3
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
================================================================================
MSG: test_msgs/Pose
float32[2] xy
Point[] points
================================================================================
MSG: test_msgs/Point
float32 z
";

    #[test]
    fn analytic_names_of_a_nested_definition() {
        let found = parse(
            "test_msgs/msg/Odometry",
            ODOMETRY,
            false,
            &mut NameBudget::default(),
        )
        .unwrap();
        assert_eq!(
            found.names[..4],
            [
                "header.stamp.sec",
                "header.stamp.nanosec",
                "pose.xy[0]",
                "pose.xy[1]"
            ]
        );
        assert_eq!(found.names[4], "pose.points[0].z");
        assert_eq!(found.names[12], "pose.points.length");
        assert_eq!(found.names[13], "speeds[0]");
        assert_eq!(found.names.last().unwrap(), "speeds.length");
        assert_eq!(found.texts, ["header.frame_id", "child_frame_id"]);
    }

    #[test]
    fn prop_what_is_circular_unknown_or_oversize_is_refused() {
        let parsed = |kind, text, ros1| parse(kind, text, ros1, &mut NameBudget::default());
        assert!(parsed("a/A", "A a", false).is_none());
        assert!(parsed("a/A", "B b\n===\nMSG: a/B\nA a", false).is_none());
        assert!(parsed("a/A", "Unknown b", false).is_none());
        assert!(parsed("a/A", "float32[x] b", false).is_none());
        let wide = "B[8] b\n===\nMSG: a/B\nC[8] c\n===\nMSG: a/C\nfloat32[65] x\nfloat32[65] y";
        assert!(parsed("a/A", wide, false).is_none());
        // Arrays of nothing would take time without end.
        let nothing = "B[18446744073709551615] b\n===\nMSG: a/B\n";
        assert!(parsed("a/A", nothing, true).is_none());
        assert!(parsed("a/A", "B[] b\n===\nMSG: a/B\nuint8[0] x", false).is_none());
        assert!(parsed("a/A", "float64[9000000] b", false).is_none());
        assert!(parsed("a/A", "", true).unwrap().names.is_empty());
    }
}
