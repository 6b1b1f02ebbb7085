//! Mends of quantities that are certain enough for a program to make.

use super::Expressions;
use crate::diagnostics::{Fix, sure};
use crate::ir::{Expr, ExprKind, Operator};
use crate::source::Span;
use crate::syntax::ast::Name;
use crate::units::{self, Dimension};

/// A quantity as it is written: `240 s` is `240` and `s`.
fn written(text: &str) -> Option<(&str, &str)> {
    let end =
        text.find(|c: char| !(c.is_ascii_digit() || matches!(c, '.' | '-' | ' '))).unwrap_or(text.len());
    let (number, unit) = text.split_at_checked(end)?;
    number.contains(|c: char| c.is_ascii_digit()).then_some((number.trim(), unit))
}

/// The unit that a number of this dimension certainly has if none is written: an angle of ten and more is one in
/// degrees. Lengths, masses and times have no such unit.
fn usual(want: Dimension, value: f64) -> Option<&'static str> {
    let size = value.abs();
    match want {
        Dimension::ANGLE if size >= 10.0 && size.fract() == 0.0 => Some("deg"),
        _ => None,
    }
}

/// The unit that a word certainly stands for: one written out, or one misspelt beyond doubt.
///
/// Capitals decide between thousandths and millions, `kgm` may be a product and `degC` is another
/// unit altogether, so of the slips only swapped and doubled letters are mended.
pub(super) fn unit_meant(word: &str) -> Option<&'static str> {
    if let Some(unit) = units::written_out(word) {
        return Some(unit);
    }
    let unit = sure(word, units::unit_names())?;
    let letters = |text: &str| text.chars().collect::<std::collections::BTreeSet<char>>();
    (letters(word) == letters(unit)).then_some(unit)
}

impl Expressions<'_> {
    /// Writes the unit behind a bare number: the one of the literal `beside` it, or the usual one.
    pub(super) fn missing_unit(
        &self,
        number: &Expr,
        value: f64,
        want: Dimension,
        beside: Option<&Expr>,
    ) -> Option<Fix> {
        let text = self.environment.sources.slice(number.span);
        let unit = self.unit_beside(want, beside).or_else(|| usual(want, value))?;
        let plain = text.ends_with(|c: char| c.is_ascii_digit()) && !text.starts_with('(');
        plain.then(|| Fix::insert_after(number.span, format!(" {unit}"), format!("write `{text} {unit}`")))
    }

    /// The unit of this dimension that a literal carries.
    pub(super) fn unit_beside(&self, want: Dimension, beside: Option<&Expr>) -> Option<&str> {
        let (_, unit) = written(self.environment.sources.slice(beside?.span))?;
        units::parse(unit).is_ok_and(|u| u.dimension == want).then_some(unit)
    }

    /// Mends `1 / 240 s` and a torque without its angle.
    pub(super) fn mended_quantity(&self, expr: &Expr, want: Dimension) -> Option<Fix> {
        let text = match &expr.kind {
            ExprKind::Binary(a, Operator::Divide, b) => {
                let (above, none) = written(self.environment.sources.slice(a.span))?;
                let (below, unit) = written(self.environment.sources.slice(b.span))?;
                let fits = none.is_empty() && units::parse(unit).is_ok_and(|u| u.dimension == want);
                fits.then(|| format!("{above} {unit} / {below}"))?
            }
            ExprKind::Number(_) => {
                let (number, unit) = written(self.environment.sources.slice(expr.span))?;
                let have = units::parse(unit).ok()?.dimension;
                let unit = match have.over(want)? {
                    d if d == Dimension::ANGLE => match unit.strip_suffix("/rad") {
                        Some(torque) => format!("{torque}/rad^2"),
                        None => format!("{unit}/rad"),
                    },
                    d if Some(d) == Dimension::ANGLE.power(2) => format!("{unit}/rad^2"),
                    _ => return None,
                };
                let fits = units::parse(&unit).is_ok_and(|u| u.dimension == want);
                fits.then(|| format!("{number} {unit}"))?
            }
            _ => return None,
        };
        let message = format!("write `{text}`");
        Some(Fix::replace(expr.span, text, message))
    }

    /// Turns a range the right way round.
    pub(super) fn swapped(&self, low: Span, high: Span) -> Option<Fix> {
        let (a, b) = (self.environment.sources.slice(low), self.environment.sources.slice(high));
        let there = !a.is_empty() && !b.is_empty();
        there.then(|| Fix::replace(low, b, format!("write `{b} .. {a}`")).and(high, a))
    }

    /// Replaces the one word of a unit that is none.
    pub(super) fn mended_unit(&self, unit: &Name, word: &str) -> Option<Fix> {
        let meant = unit_meant(word)?;
        let mut start = unit.span.start as usize;
        for piece in self.environment.sources.slice(unit.span).split_inclusive(['*', '/', '^']) {
            if piece.trim_end_matches(['*', '/', '^']) == word {
                let span = Span::new(unit.span.file, start, start + word.len());
                return Some(Fix::replace(span, meant, format!("write `{meant}` instead of `{word}`")));
            }
            start += piece.len();
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_is_guessed_only_beyond_doubt() {
        assert_eq!(unit_meant("sec"), Some("s"));
        assert_eq!(unit_meant("degg"), Some("deg"));
        assert_eq!(unit_meant("kPaa"), Some("kPa"));
        for other in ["MN", "mPa", "mAh", "gg", "kgm", "Nmm", "degC", "barg", "brick"] {
            assert_eq!(unit_meant(other), None, "{other}");
        }
    }

    #[test]
    fn a_quantity_is_taken_apart_as_it_is_written() {
        assert_eq!(written("240 s"), Some(("240", "s")));
        assert_eq!(written("-1.5 N*m"), Some(("-1.5", "N*m")));
        assert_eq!(written("3"), Some(("3", "")));
        assert_eq!(written("x"), None);
    }
}
