//! Running text: its two marks, and the terms that a page explains where they first stand.

use std::cell::RefCell;
use std::collections::BTreeSet;

use maud::{Markup, html};

/// A technical term with its definition.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Term {
    /// How the term is written: singular, plural, symbol. The first is its headword.
    pub names: &'static [&'static str],
    /// The definition in a sentence or two; plain text.
    pub meaning: &'static str,
}

/// Sets text and keeps account of the terms that a reader has met.
#[derive(Debug)]
pub(crate) struct Words<'a> {
    terms: &'a [Term],
    /// Terms that were marked since the last heading.
    marked: RefCell<BTreeSet<usize>>,
    /// Terms that were explained on the page.
    explained: RefCell<BTreeSet<usize>>,
    /// Terms that the next explanation holds.
    waiting: RefCell<Vec<usize>>,
}

impl<'a> Words<'a> {
    pub(crate) fn new(terms: &'a [Term]) -> Self {
        Self {
            terms,
            marked: RefCell::default(),
            explained: RefCell::default(),
            waiting: RefCell::default(),
        }
    }

    /// A heading was set: each term is marked once more below it.
    pub(crate) fn heading(&self) {
        self.marked.borrow_mut().clear();
    }

    /// The definitions of the terms that stood for the first time since the last call.
    pub(crate) fn explanations(&self) -> Markup {
        let waiting = self.waiting.take();
        html! {
            @if !waiting.is_empty() {
                ul.terms { @for index in waiting {
                    li { dfn { (self.terms[index].names[0]) } ": " (self.terms[index].meaning) }
                } }
            }
        }
    }

    /// Plain text with `` `code` ``, `**strong**` and marked terms.
    pub(crate) fn set(&self, text: &str) -> Markup {
        alternate(
            text,
            "`",
            &|part| html! { code { (self.mark(part)) } },
            &|part| {
                alternate(
                    part,
                    "**",
                    &|part| html! { strong { (self.mark(part)) } },
                    &|part| self.mark(part),
                )
            },
        )
    }

    /// Text in which the first of every term carries its definition.
    pub(crate) fn mark(&self, text: &str) -> Markup {
        let Some((index, start, end)) = self.first_term(text) else {
            return html! { (text) };
        };
        if !self.marked.borrow_mut().insert(index) {
            return html! { (text[..end]) (self.mark(&text[end..])) };
        }
        if self.explained.borrow_mut().insert(index) {
            self.waiting.borrow_mut().push(index);
        }
        html! {
            (text[..start]) abbr title=(self.terms[index].meaning) { (text[start..end]) } (self.mark(&text[end..]))
        }
    }

    /// The term that stands first in a text, with its place; the longest of those that begin there.
    fn first_term(&self, text: &str) -> Option<(usize, usize, usize)> {
        let terms = self.terms.iter().enumerate();
        terms
            .flat_map(|(index, term)| {
                let names = term.names.iter();
                names.filter_map(move |name| Some((index, find_word(text, name)?, name.len())))
            })
            .min_by_key(|&(_, start, length)| (start, std::cmp::Reverse(length)))
            .map(|(index, start, length)| (index, start, start + length))
    }
}

/// Where a name stands as a word of its own; a name of small letters may begin with a capital.
fn find_word(text: &str, name: &str) -> Option<usize> {
    let word = |c: char| c.is_alphanumeric() || c == '_';
    let (first, rest) = name.split_at(name.chars().next()?.len_utf8());
    text.char_indices().map(|(at, _)| at).find(|&at| {
        let tail = &text[at..];
        let same = tail.get(..name.len()).is_some_and(|found| {
            found.get(first.len()..) == Some(rest)
                && (found.starts_with(first) || found.starts_with(&first.to_uppercase()))
        });
        same && !text[..at].ends_with(word) && !tail[name.len()..].starts_with(word)
    })
}

/// Text between marks in turn; a mark without a partner is text.
fn alternate(
    text: &str,
    mark: &str,
    inside: &dyn Fn(&str) -> Markup,
    outside: &dyn Fn(&str) -> Markup,
) -> Markup {
    let parts: Vec<&str> = text.split(mark).collect();
    if parts.len().is_multiple_of(2) {
        return outside(text);
    }
    html! {
        @for (index, part) in parts.into_iter().enumerate() {
            @if index % 2 == 1 { (inside(part)) } @else { (outside(part)) }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TERMS: [Term; 3] = [
        Term {
            names: &["free run", "free runs"],
            meaning: "A simulation.",
        },
        Term {
            names: &["T_L"],
            meaning: "A time.",
        },
        Term {
            names: &["T_L+V_L"],
            meaning: "A time and a speed.",
        },
    ];

    #[test]
    fn analytic_marks_in_text() {
        let words = Words::new(&[]);
        let set = |text| words.set(text).into_string();
        assert_eq!(
            set("a `b<c` **d** & e"),
            "a <code>b&lt;c</code> <strong>d</strong> &amp; e"
        );
        assert_eq!(set("5 ` and 2**3"), "5 ` and 2**3");
    }

    #[test]
    fn analytic_a_term_is_explained_once_and_marked_once_below_a_heading() {
        let words = Words::new(&TERMS);
        let set = |text| words.set(text).into_string();
        assert_eq!(
            set("Free runs give `T_L`; a free run, xT_L."),
            "<abbr title=\"A simulation.\">Free runs</abbr> give <code><abbr title=\"A time.\">T_L</abbr></code>; a free run, xT_L."
        );
        let explained = words.explanations().into_string();
        assert!(explained.contains("<dfn>free run</dfn>: A simulation."));
        assert!(explained.contains("<dfn>T_L</dfn>"));
        assert_eq!(set("free run"), "free run");
        words.heading();
        assert!(set("free run").contains("<abbr"));
        assert_eq!(words.explanations().into_string(), "");
    }

    #[test]
    fn regress_a_term_within_a_longer_one_is_not_marked() {
        let words = Words::new(&TERMS);
        assert!(words.mark("T_L+V_L").into_string().contains("<abbr"));
        assert_eq!(words.mark("T_L+V_L").into_string(), "T_L+V_L");
        assert!(words.mark("T_L").into_string().contains("A time."));
    }
}
