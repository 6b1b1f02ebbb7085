//! Source text as HTML: lightly coloured, names linked to where they are explained.

use super::Module;
use super::lex::{Kind, Piece, pieces};
use super::names::{Meaning, Names};
use crate::markup::escape;

/// A declaration of a module. Its own name, which stands above it, is no link.
pub(super) fn html(names: &Names<'_>, module: &Module, own: Option<&str>, text: &str) -> String {
    let pieces = pieces(text);
    let one_line = !text.contains('\n');
    let mut out = String::new();
    for (place, piece) in pieces.iter().enumerate() {
        let before = pieces.get(..place).unwrap_or_default();
        let after = pieces.get(place + 1..).unwrap_or_default();
        out += &match piece.kind {
            // What was aligned with its neighbours stands alone here.
            Kind::Space if one_line => " ".to_owned(),
            Kind::Space | Kind::Sign => escape(piece.text),
            Kind::Comment => span("comment", piece.text),
            Kind::Text => span("text", piece.text),
            Kind::Number => span("number", piece.text),
            // Fields, arguments and members are not what the module declares.
            Kind::Word if own == Some(piece.text) || is_field(before, after) => escape(piece.text),
            Kind::Word => word(names, module, piece.text),
        };
    }
    out
}

/// A name of a module, linked if it is explained on the page.
pub(super) fn word(names: &Names<'_>, module: &Module, word: &str) -> String {
    let text = escape(word);
    match names.meaning(module, word) {
        Meaning::Here(anchor) => format!("<a href=\"#{}\">{text}</a>", escape(&anchor)),
        Meaning::Elsewhere(about) => {
            format!("<span class=\"known\" title=\"{}\">{text}</span>", escape(&about))
        }
        Meaning::Reserved => format!("<b>{text}</b>"),
        Meaning::Other => text,
    }
}

/// A declaration that ends in `because "REASON"` as what comes before that, and the reason.
pub(super) fn reason(text: &str) -> Option<(&str, String)> {
    let all = pieces(text);
    let place = all.iter().rposition(|p| p.kind == Kind::Word && p.text == "because")?;
    let (before, after) = all.split_at_checked(place)?;
    let mut after = after.iter().skip(1).filter(|p| !matches!(p.kind, Kind::Space | Kind::Comment));
    let quoted = after.next().filter(|p| p.kind == Kind::Text)?.text;
    if after.next().is_some() {
        return None;
    }
    let length: usize = before.iter().map(|p| p.text.len()).sum();
    let inner = quoted.strip_prefix('"')?;
    Some((text.get(..length)?.trim_end(), unescaped(inner.strip_suffix('"').unwrap_or(inner))))
}

/// A backslash takes the next character as it is.
fn unescaped(text: &str) -> String {
    let mut out = String::new();
    let mut chars = text.chars();
    while let Some(c) = chars.next() {
        out.extend(if c == '\\' { chars.next() } else { Some(c) });
    }
    out
}

fn span(class: &str, text: &str) -> String {
    format!("<span class=\"{class}\">{}</span>", escape(text))
}

/// Whether a word is the name of a field or argument (`name = `), or follows a point.
fn is_field(before: &[Piece<'_>], after: &[Piece<'_>]) -> bool {
    let member = before.last().is_some_and(|p| p.text == ".")
        && before.len().checked_sub(2).and_then(|i| before.get(i)).is_some_and(|p| p.text != ".");
    let mut next = after.iter().filter(|p| p.kind != Kind::Space);
    let given = next.next().is_some_and(|p| p.text == "=") && next.next().is_none_or(|p| p.text != "=");
    let opens = before.iter().rev().find(|p| p.kind != Kind::Space).is_none_or(|p| p.kind != Kind::Word);
    member || given && opens
}
