//! Types that must fit: what is expected of an expression, and what two have in common.

use super::Expressions;
use super::context::{Context, as_group, unknown};
use crate::diagnostics::{Code, Diagnostic, did_you_mean};
use crate::ir::{Expr, ExprKind, Operator, Ty, Word};
use crate::syntax::ast;
use crate::syntax::ast::Name;
use crate::syntax::declarations::BlockKind;
use crate::units::{self, Dimension, UnitError};

/// Whole numbers from here on are no counts: their last digits may be lost.
pub(super) const LEAST_NOT_COUNTED: f64 = 1e15;

impl Expressions<'_> {
    /// Checks an expression that must have a type; says `what` it is for.
    pub(in crate::types) fn expect(
        &mut self,
        tree: &ast::Expr,
        cx: &mut Context,
        wanted: &Ty,
        what: &str,
    ) -> Expr {
        let expr = self.infer(tree, cx);
        self.fit(expr, wanted, what)
    }

    /// Makes an expression fit a type, or reports why it does not.
    pub(in crate::types) fn fit(&mut self, mut expr: Expr, wanted: &Ty, what: &str) -> Expr {
        if expr.ty.fits(wanted) {
            return expr;
        }
        if *wanted == Ty::Group
            && let Some(group) = as_group(&expr)
        {
            return group;
        }
        if let (Ty::Domain(inner), ExprKind::Range(low, high)) = (wanted, &expr.kind) {
            let (known, have) = (self.errors.len(), low.ty.clone());
            let low = self.fit((**low).clone(), inner, what);
            // Both ends in a unit of the same wrong kind are one mistake.
            let told = self.errors.len() > known && high.ty == have && bare_number(high).is_none();
            let high = if told { unknown(high.span) } else { self.fit((**high).clone(), inner, what) };
            let ok = low.ty != Ty::Unknown && high.ty != Ty::Unknown;
            expr.kind = ExprKind::Range(Box::new(low), Box::new(high));
            expr.ty = if ok { wanted.clone() } else { Ty::Unknown };
            return expr;
        }
        if let (Some(dimension), true) = (wanted.dimension(), is_zero(&expr)) {
            expr.ty = Ty::Quantity(dimension);
            return expr;
        }
        let fix =
            wanted.dimension().filter(|_| *wanted != Ty::Count).and_then(|want| match bare_number(&expr) {
                Some(x) => self.missing_unit(&expr, x, want, None),
                None => self.mended_quantity(&expr, want),
            });
        self.report(mismatch(&expr, wanted, what).fix_if(fix));
        expr.ty = Ty::Unknown;
        expr
    }

    /// Makes two operands have one type; `None` if they cannot (reported).
    pub(super) fn unify(&mut self, mut a: Expr, mut b: Expr, what: &str) -> Option<(Expr, Expr, Ty)> {
        if let (true, Ty::Quantity(d)) = (is_zero(&a), &b.ty) {
            a.ty = Ty::Quantity(*d);
        } else if let (true, Ty::Quantity(d)) = (is_zero(&b), &a.ty) {
            b.ty = Ty::Quantity(*d);
        }
        if let Some(ty) = a.ty.common(&b.ty) {
            return Some((a, b, ty));
        }
        let numbers = (a.ty.dimension(), b.ty.dimension());
        let bare = match numbers {
            (Some(_), Some(want)) if bare_number(&a).is_some() => Some((&a, &b, want)),
            (Some(want), Some(_)) if bare_number(&b).is_some() => Some((&b, &a, want)),
            _ => None,
        };
        let error = match bare {
            Some((number, other, want)) if !want.is_number() => {
                let x = bare_number(number).unwrap_or_default();
                Diagnostic::new(
                    Code::MISSING_UNIT,
                    number.span,
                    format!("this number needs a unit: {} {what} is {}", other_of(what), article(&other.ty)),
                )
                .label("without a unit")
                .also(other.span, article(&other.ty))
                .help({
                    let unit = self.unit_beside(want, Some(other));
                    let unit = unit.map_or_else(|| units::suggest(want), str::to_owned);
                    // What is calculated may well be meant as a number.
                    let is_plain = matches!(other.kind, ExprKind::Number(_) | ExprKind::Negate(_));
                    let one = if want == Dimension::ANGLE { "rad" } else { unit.as_str() };
                    match is_plain || !matches!(what, "`+`" | "`-`") {
                        true => format!("write `{x} {unit}`"),
                        false => format!(
                            "write `{x} {unit}`; if numbers are meant, divide the other side by `1 {one}`"
                        ),
                    }
                })
                .fix_if(self.missing_unit(number, x, want, Some(other)))
            }
            _ => {
                let code = if numbers.0.is_some() && numbers.1.is_some() {
                    Code::WRONG_DIMENSION
                } else {
                    Code::WRONG_TYPE
                };
                Diagnostic::new(
                    code,
                    b.span,
                    format!("{what} cannot combine {} and {}", article(&a.ty), article(&b.ty)),
                )
                .label(article(&b.ty))
                .also(a.span, article(&a.ty))
                .help(unlike(&a.ty, &b.ty))
            }
        };
        self.report(error);
        None
    }

    /// Reads a unit.
    pub(super) fn unit(&mut self, unit: &Name) -> Option<units::Unit> {
        match units::parse(&unit.text) {
            Ok(unit) => Some(unit),
            Err(UnitError::Unknown(word)) => {
                let product = super::mend::product_meant(&word);
                let product = product.map(|m| format!("write `{}`", unit.text.replacen(&word, &m, 1)));
                let meant = super::mend::unit_meant(&word).map(|m| format!("did you mean `{m}`?"));
                let meant = product.or(meant);
                let kind = self.environment.program.lookup(unit.span, &unit.text).map(|(_, item)| &item.kind);
                let part =
                    matches!(kind, Some(ast::ItemKind::Block(BlockKind::Part | BlockKind::Actuator, _)));
                let help = meant.or_else(|| did_you_mean(&word, units::unit_names())).unwrap_or_else(|| {
                    if part {
                        format!("one `attach` makes one part: write `{word}` alone, and repeat the line as often as needed")
                    } else if unit.text.contains('*') || unit.text.contains('/') {
                        "to calculate with a name, put spaces around `*` and `/`".to_owned()
                    } else {
                        format!("units are: {}", units::unit_names().collect::<Vec<_>>().join(", "))
                    }
                });
                self.report(
                    Diagnostic::new(Code::UNKNOWN_UNIT, unit.span, format!("unknown unit `{word}`"))
                        .label("no unit of this name")
                        .help(help)
                        .fix_if(self.mended_unit(unit, &word)),
                );
                None
            }
            Err(UnitError::TooHigh) => {
                self.report(
                    Diagnostic::new(
                        Code::UNKNOWN_UNIT,
                        unit.span,
                        "the exponents of this unit are too large",
                    )
                    .label("no quantity has such a unit"),
                );
                None
            }
        }
    }
}

/// Whether this is the literal 0, which fits every dimension.
pub(super) fn is_zero(expr: &Expr) -> bool {
    matches!(expr.kind, ExprKind::Number(x) if x == 0.0) && expr.ty == Ty::Count
}

/// A number that was written without a unit.
fn bare_number(expr: &Expr) -> Option<f64> {
    match &expr.kind {
        ExprKind::Number(x) if expr.ty.dimension().is_some_and(Dimension::is_number) => Some(*x),
        ExprKind::Negate(inner) => bare_number(inner).map(|x| -x),
        _ => None,
    }
}

/// Says that a quantity cannot be counted in a unit of another kind.
pub(super) fn other_unit(value: &Expr, dimension: Dimension, unit: &Name) -> Diagnostic {
    let have = article(&value.ty);
    Diagnostic::new(
        Code::WRONG_DIMENSION,
        unit.span,
        format!("{have} cannot be expressed in `{}`", unit.text),
    )
    .label("a unit of another kind")
    .also(value.span, format!("this is {have}"))
    .help(format!("write a unit that fits, such as `in {}`", units::suggest(dimension)))
}

/// A type with its article.
pub(in crate::types) fn article(ty: &Ty) -> String {
    let name = ty.to_string();
    let an = name.starts_with(['A', 'E', 'a', 'e']);
    format!("{} {name}", if an { "an" } else { "a" })
}

/// How to write what is wanted, where something of another kind stands.
fn meant(expr: &Expr, wanted: &Ty) -> Option<String> {
    match (&expr.ty, wanted) {
        (Ty::Track(_), _) => Some("ask for it at a time: `e.position at end`".to_owned()),
        (Ty::Domain(_), _) => Some("a single value is needed here, not a range or set".to_owned()),
        (Ty::List(item), wanted) if item.fits(wanted) => Some(
            "name one item of the list: `LIST[0]`, `first(LIST)` or `last(LIST)`; in a rule, `for x in LIST` runs over all of them".to_owned(),
        ),
        (_, Ty::Distribution(d)) => {
            let unit = if d.is_number() { String::new() } else { format!(" {}", units::suggest(*d)) };
            Some(format!("write for example `normal(0{unit}, 1{unit})` or `uniform(-1{unit}, 1{unit})`"))
        }
        (Ty::Part | Ty::Actuator, Ty::Port) => {
            Some("name one of its ports, as in `core.top` or `a.tip`".to_owned())
        }
        (_, Ty::Kind) => Some("name a kind of part, such as `cube`".to_owned()),
        (Ty::Count, Ty::Bool) if bare_number(expr).is_some_and(|x| x == 0.0 || x == 1.0) => {
            Some(format!("write `{}`", bare_number(expr) == Some(1.0)))
        }
        (Ty::Port, Ty::Part) => Some("`.part` is the part that a port belongs to".to_owned()),
        (Ty::Kind, Ty::Part) => {
            Some("`is` asks of what kind a part is: compare kinds by `==`, as in `what == cube`".to_owned())
        }
        (_, Ty::Part) => Some("name a part, such as one that the rule matches".to_owned()),
        (_, Ty::Step) => Some("match a step: `match s : step where s adds part`".to_owned()),
        (_, Ty::Group) => Some("name `part`, `block`, `actuator` or a kind, as in `s adds part`".to_owned()),
        (_, Ty::Enum(name)) => Some(format!("write one of its values, as in `{name}.VALUE`")),
        (_, Ty::Vector(d)) => {
            let unit = units::display_unit(*d);
            let unit = if *d == Dimension::LENGTH { " cm".to_owned() } else { format!(" {unit}") };
            let unit = if d.is_number() { "" } else { &unit };
            Some(format!("write for example `vector(1{unit}, 0{unit}, 0{unit})`"))
        }
        (Ty::Count | Ty::Quantity(_), Ty::Bool) => {
            Some("compare it with something, as in `count(part) > 3`".to_owned())
        }
        (Ty::Quantity(d), Ty::Domain(inner)) if expr.ty == **inner && !d.is_number() => {
            let range = match &expr.kind {
                ExprKind::Number(x) => {
                    Some(format!("{} .. {}", units::shown(x.min(0.0), *d), units::shown(x.max(0.0), *d)))
                }
                _ => None,
            };
            Some(format!("write a range, as in `{}`", range.as_deref().unwrap_or("LEAST .. GREATEST")))
        }
        (Ty::Bool, Ty::Count | Ty::Quantity(_)) => {
            Some("use `if CONDITION then a else b` to turn a Bool into a number".to_owned())
        }
        (_, Ty::Count) => Some("write a whole number, such as 3".to_owned()),
        (_, Ty::Domain(_)) => Some("write a range `a .. b` or a set `{ a, b }`".to_owned()),
        _ => None,
    }
}

/// Says why an expression does not fit, and how it would.
fn mismatch(expr: &Expr, wanted: &Ty, what: &str) -> Diagnostic {
    let (Some(have), Some(want)) = (expr.ty.dimension(), wanted.dimension()) else {
        let help = meant(expr, wanted);
        return Diagnostic::new(
            Code::WRONG_TYPE,
            expr.span,
            format!("{what} must be {}, but this is {}", article(wanted), article(&expr.ty)),
        )
        .label(format!("this is {}", article(&expr.ty)))
        .help_if(help);
    };
    if *wanted == Ty::Count {
        let mut large = None;
        have.is_number().then(|| {
            expr.any(&mut |part| {
                let is_large = matches!(part.kind, ExprKind::Number(x) if x.abs() >= LEAST_NOT_COUNTED && x.fract() == 0.0);
                large = large.or(is_large.then_some(part.span));
                is_large
            })
        });
        if let Some(place) = large {
            return Diagnostic::new(Code::WRONG_TYPE, place, "this number is too large for a Count")
                .label(format!("a Count is below {LEAST_NOT_COUNTED:e}"))
                .help("write a smaller whole number, or use the type `Number`");
        }
        return Diagnostic::new(Code::WRONG_TYPE, expr.span, format!("{what} must be a whole number"))
            .label(if have.is_number() {
                "not a whole number".to_owned()
            } else {
                format!("this is {}", article(&expr.ty))
            })
            .help(if have.is_number() {
                "write a number such as 3, or use `floor` or `round`"
            } else {
                "write a whole number without a unit, such as 3"
            });
    }
    if let Some(x) = bare_number(expr) {
        return Diagnostic::new(
            Code::MISSING_UNIT,
            expr.span,
            format!("{what} must be {}, but this number has no unit", article(wanted)),
        )
        .label("without a unit")
        .help(format!("write `{x} {}`", units::suggest(want)));
    }
    let upside_down = match &expr.kind {
        ExprKind::Binary(a, Operator::Divide, b) if Dimension::NUMBER.over(want) == Some(have) => {
            bare_number(a).is_some() && matches!(b.kind, ExprKind::Number(_))
        }
        _ => false,
    };
    let per_angle =
        have.over(want).is_some_and(|d| d == Dimension::ANGLE || Some(d) == Dimension::ANGLE.power(2));
    let literal = matches!(&expr.kind, ExprKind::Number(_))
        || matches!(&expr.kind, ExprKind::Negate(x) if matches!(x.kind, ExprKind::Number(_)));
    let help = if upside_down {
        "a unit belongs to the number before it: write the unit before dividing, as in `1 s / 240`".to_owned()
    } else if want.is_number() && literal {
        "write it without a unit".to_owned()
    } else if matches!(&expr.kind, ExprKind::Word(Word::Cycle)) && want == Dimension::ANGLE {
        "`cycle` runs from 0 to 1: write `cycle * 360 deg`".to_owned()
    } else if have.is_number() && !literal {
        let unit = units::suggest(want);
        let turn = if unit == "deg" { "; a full turn is `360 deg`, not `2 * pi`" } else { "" };
        if unit == "deg" && expr.any(&mut |e| matches!(e.kind, ExprKind::Word(Word::Pi))) {
            "angles have units: write `360 deg` instead of `2 * pi`, or multiply by `1 rad`".to_owned()
        } else {
            format!(
                "give one of its numbers a unit of {want}, such as {unit}, or multiply it by `1 {unit}`{turn}"
            )
        }
    } else if weighs(have, want) {
        "a data sheet uses the weight of 1 kg as a unit of force: 1 kg*cm is `0.0981 N*m/rad`, and the force of 1 kg is `9.81 N`".to_owned()
    } else if !want.is_number() && !per_angle && !literal {
        if what == "this term" {
            format!("declare it as `: {have}`, or change what it is calculated from")
        } else {
            format!("the calculation gives {}: is a factor or a unit missing?", article(&expr.ty))
        }
    } else if want.is_number() {
        format!("divide it by a quantity of the same kind, or write `in {}` after it", units::suggest(have))
    } else if per_angle {
        format!("angles count as a dimension here: write it in {}", units::suggest(want))
    } else {
        format!("write it in a unit of {want}, such as {}", units::suggest(want))
    };
    Diagnostic::new(
        Code::WRONG_DIMENSION,
        expr.span,
        format!("{what} must be {}, but this is {}", article(wanted), article(&expr.ty)),
    )
    .label(format!("this is {}", article(&expr.ty)))
    .help(help)
}

/// What helps where two operands are of different kinds.
fn unlike(a: &Ty, b: &Ty) -> &'static str {
    let number = |ty: &Ty| ty.dimension().is_some();
    match (a, b) {
        (a, b) if number(a) && number(b) => "both must be of the same kind: is one of the units wrong?",
        (Ty::Enum(_), _) | (_, Ty::Enum(_)) => {
            "a value of an enumeration can be compared only with another one"
        }
        (Ty::Bool, _) | (_, Ty::Bool) => "use `if CONDITION then a else b` to turn a Bool into a number",
        _ => "both must be of the same kind",
    }
}

/// What another value that something joins is called: of a list, a `match` or an operator.
fn other_of(what: &str) -> &'static str {
    match what {
        "`match`" => "another case of",
        operator if operator.starts_with('`') => "the other side of",
        _ => "another value of",
    }
}

/// Whether a quantity lacks no more than an acceleration, and an angle, to be what is wanted: a mass that stands for its weight.
fn weighs(have: Dimension, want: Dimension) -> bool {
    let lacks = want.over(have);
    let acceleration = Dimension::LENGTH.over(Dimension::TIME).and_then(|speed| speed.over(Dimension::TIME));
    lacks.is_some() && (lacks == acceleration || lacks == acceleration.and_then(|a| a.over(Dimension::ANGLE)))
}
