//! Landings to watch: vehicles above a deck in three dimensions.

use maud::{Markup, PreEscaped, html};
use serde_json::{Value, json};

use crate::Result;
use crate::check::check_id;
use crate::pack::pack_rows;
use crate::words::Words;

/// The player and three.js, which it draws with. `node build.mjs --player` in `web` builds it from `web/src/watch.ts`.
pub(crate) const PLAYER: &str = include_str!("../watch/watch.min.js");

/// Colours of the first vehicle and of its ghost, as the player has them.
const COLORS: [&str; 2] = ["#0072b2", "#d55e00"];

/// One or two landings on the same deck, in three dimensions, with a button that plays them and a bar for the time.
///
/// The player draws with WebGL. On paper, and in a browser without it, the caption stands alone.
#[derive(Debug, Clone)]
pub struct Scene {
    id: String,
    title: String,
    caption: String,
    landings: Vec<(String, Value)>,
}

impl Scene {
    /// An empty scene; `id` names it in the page.
    pub fn new(id: impl Into<String>, title: impl Into<String>) -> Self {
        Self {
            id: id.into(),
            title: title.into(),
            caption: String::new(),
            landings: Vec::new(),
        }
    }

    /// Sets the text below.
    #[must_use]
    pub fn caption(mut self, caption: impl Into<String>) -> Self {
        self.caption = caption.into();
        self
    }

    /// Adds a landing as the player reads it (`Watched` in `web/src/scene.ts`). The deck is that of the first one; the second
    /// flies as a ghost.
    #[must_use]
    pub fn landing(mut self, name: impl Into<String>, landing: Value) -> Self {
        self.landings.push((name.into(), landing));
        self
    }
}

/// A scene as the page needs it.
#[derive(Debug, Clone)]
pub(crate) struct Player {
    id: String,
    title: String,
    caption: String,
    names: Vec<String>,
    /// JSON that cannot end the script element that holds it.
    description: String,
}

impl Player {
    pub(crate) fn of(scene: Scene) -> Result<Self> {
        check_id(&scene.id)?;
        let (names, mut landings): (Vec<String>, Vec<Value>) = scene.landings.into_iter().unzip();
        landings.iter_mut().for_each(pack_rows);
        Ok(Self {
            id: scene.id,
            title: scene.title,
            caption: scene.caption,
            names,
            description: json!({ "landings": landings })
                .to_string()
                .replace('<', "\\u003c"),
        })
    }

    pub(crate) fn markup(&self, number: usize, words: &Words<'_>) -> Markup {
        html! {
            figure.scene id=(format!("figure-{number}")) data-name=(self.id) {
                div.keys {
                    @for (name, color) in self.names.iter().zip(COLORS) {
                        span.key {
                            svg width="26" height="10" viewBox="0 0 26 10" aria-hidden="true" {
                                rect width="26" height="10" fill=(color) {}
                            }
                            (name)
                        }
                    }
                }
                div.view role="group" aria-label=(self.title) {}
                div.scrub {
                    button type="button" disabled { "Play" }
                    input type="range" min="0" max="1" step="0.01" value="0" aria-label="Time" disabled;
                    output {}
                }
                noscript { p.remark { "The landing needs scripts to be watched." } }
                figcaption {
                    b { "Figure " (number) ". " (self.title) @if !self.title.ends_with('.') { "." } } " " (words.set(&self.caption))
                }
                script type="application/json" { (PreEscaped(&self.description)) }
            }
        }
    }
}
