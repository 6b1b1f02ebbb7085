//! Writes XML, indented.

use super::number;
use crate::markup::escape;

/// A document while it is being written.
#[derive(Debug, Default)]
pub(super) struct Xml {
    out: String,
    open: Vec<&'static str>,
}

impl Xml {
    /// A comment in lines of its own; it must not contain two hyphens in a row.
    pub(super) fn comment(&mut self, text: &str) {
        self.indent();
        self.out.push_str(&format!("<!-- {} -->\n", text.replace("--", "- -")));
    }

    /// An element with what comes before the matching [`Self::close`] inside.
    pub(super) fn open(&mut self, name: &'static str, attributes: &[(&str, String)]) {
        self.begin(name, attributes);
        self.out.push_str(">\n");
        self.open.push(name);
    }

    /// Ends the element opened last.
    pub(super) fn close(&mut self) {
        if let Some(name) = self.open.pop() {
            self.indent();
            self.out.push_str(&format!("</{name}>\n"));
        }
    }

    /// An element with nothing inside.
    pub(super) fn leaf(&mut self, name: &str, attributes: &[(&str, String)]) {
        self.begin(name, attributes);
        self.out.push_str("/>\n");
    }

    /// The text, with all elements closed.
    pub(super) fn finish(mut self) -> String {
        while !self.open.is_empty() {
            self.close();
        }
        self.out
    }

    fn begin(&mut self, name: &str, attributes: &[(&str, String)]) {
        self.indent();
        self.out.push_str(&format!("<{name}"));
        for (name, value) in attributes {
            self.out.push_str(&format!(" {name}=\"{}\"", escaped(value)));
        }
    }

    fn indent(&mut self) {
        self.out.extend(std::iter::repeat_n("  ", self.open.len()));
    }
}

/// Several numbers of one quantity as the value of an attribute. What is
/// nothing beside the others is rounding, and becomes zero.
pub(super) fn numbers(values: &[f64]) -> String {
    let most = values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    let clean = |value: &f64| if value.abs() < 1e-12 * most { 0.0 } else { *value };
    values.iter().map(|value| number(clean(value))).collect::<Vec<_>>().join(" ")
}

/// A text as the value of an attribute; characters that XML cannot hold are left out.
fn escaped(text: &str) -> String {
    let held = text.chars().filter_map(|c| match c {
        '\t' | '\n' | '\r' => Some(' '),
        c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => None,
        c => Some(c),
    });
    escape(&held.collect::<String>())
}
