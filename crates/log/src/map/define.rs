//! Substitution of definitions in expressions.

use sindy_expr::Expr;

/// The map's own names and their expressions, in which all definitions are substituted.
#[derive(Default)]
pub(super) struct Definitions(Vec<(String, Expr)>);

impl Definitions {
    pub(super) fn contains(&self, name: &str) -> bool {
        self.0.iter().any(|(known, _)| known == name)
    }

    /// The latest definition of a name counts.
    pub(super) fn insert(&mut self, name: &str, expr: Expr) {
        self.0.retain(|(known, _)| known != name);
        self.0.push((name.to_owned(), expr));
    }

    /// The expression with all definitions substituted simultaneously, so that a name inside one
    /// definition is not replaced by another.
    pub(super) fn expand(&self, expr: &Expr) -> Expr {
        let used = expr.variables();
        let used: Vec<&(String, Expr)> = self
            .0
            .iter()
            .filter(|(name, _)| used.contains(&name.as_str()))
            .collect();
        // Unique placeholder names separate substituted parts from names still to be substituted.
        let taken = |name: &str| {
            let mut all = used.iter().map(|(_, by)| by).chain([expr]);
            all.any(|expr| expr.variables().contains(&name))
        };
        let fresh = |name: &str| {
            let mut fresh = format!("{name}'");
            while taken(&fresh) {
                fresh.push('\'');
            }
            fresh
        };
        let apart: Vec<String> = used.iter().map(|(name, _)| fresh(name)).collect();
        let renamed = used
            .iter()
            .zip(&apart)
            .fold(expr.clone(), |expr, ((name, _), fresh)| {
                expr.substitute(name, &Expr::variable(fresh))
            });
        used.iter()
            .zip(&apart)
            .fold(renamed, |expr, ((_, by), fresh)| expr.substitute(fresh, by))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_definitions_are_put_in_at_once() {
        let parse = |text: &str| Expr::parse(text).unwrap();
        let mut definitions = Definitions::default();
        // Two that swap names, and one that a fresh name could be taken for.
        definitions.insert("a", parse("b + 1"));
        definitions.insert("b", parse("a * \"b'\""));
        assert_eq!(
            definitions.expand(&parse("a / b - \"a'\"")),
            parse("(b + 1) / (a * \"b'\") - \"a'\"")
        );
    }
}
