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

/// Whether a bare number is certainly meant in degrees: an angle of ten and more is, if it is whole. A length, a mass or a
/// time without its unit could be anything.
fn is_in_degrees(want: Dimension, value: f64) -> bool {
    want == Dimension::ANGLE && value.abs() >= 10.0 && value.fract() == 0.0
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

/// Two units that are written as one word: `N*m` for `Nm`.
pub(super) fn product_meant(word: &str) -> Option<String> {
    let is_unit = |text: &str| text != "N" && units::unit_names().any(|name| name == text);
    (1..word.len()).filter(|at| word.is_char_boundary(*at)).find_map(|at| {
        let (one, other) = word.split_at(at);
        // Of others it is rather one unit that is misspelt.
        let is_factor = matches!(one, "N" | "mN" | "Pa" | "kPa" | "W" | "J");
        (is_factor && is_unit(other)).then(|| format!("{one}*{other}"))
    })
}

impl Expressions<'_> {
    /// Writes the unit behind a bare number, where it is certain and the literal `beside` it, if there is one, has it, too.
    pub(super) fn missing_unit(
        &self,
        number: &Expr,
        value: f64,
        want: Dimension,
        beside: Option<&Expr>,
    ) -> Option<Fix> {
        let text = self.environment.sources.slice(number.span);
        let is_alone = self.unit_beside(want, beside).is_none_or(|unit| unit == "deg");
        let plain = text.ends_with(|c: char| c.is_ascii_digit()) && !text.starts_with('(');
        let is_certain = plain && is_alone && is_in_degrees(want, value) && !self.is_half(number.span);
        is_certain.then(|| Fix::insert_after(number.span, " deg", format!("write `{text} deg`")))
    }

    /// Whether a number may be a part of one that is written with a comma: `22,5 deg`.
    fn is_half(&self, number: Span) -> bool {
        let Some(source) = self.environment.sources.get(number.file) else { return true };
        let place = number.range();
        let after = source.text.get(place.end..).unwrap_or("").strip_prefix(',').unwrap_or("");
        let before = source.text.get(..place.start).unwrap_or("").strip_suffix(',').unwrap_or("");
        after.starts_with(|c: char| c.is_ascii_digit()) || before.ends_with(|c: char| c.is_ascii_digit())
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

    /// Turns a range the right way round, where both ends are written in one unit: one that lacks its own may be meant
    /// otherwise.
    pub(super) fn swapped(&self, low: Span, high: Span) -> Option<Fix> {
        let (a, b) = (self.environment.sources.slice(low), self.environment.sources.slice(high));
        let alike = match (written(a), written(b)) {
            (Some((_, one)), Some((_, other))) => one == other,
            (one, other) => one.is_none() && other.is_none() && !a.is_empty() && !b.is_empty(),
        };
        alike.then(|| Fix::replace(low, b, format!("write `{b} .. {a}`")).and(high, a))
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
