//! Patterns of sines that jump where one cycle ends and the next one begins: mostly half a turn for a whole one.

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Expr, ExprKind, Function, Ty};
use crate::units::{Dimension, shown};

use super::known::Known;

/// A jump counts if it is more than this share of the whole swing.
const JUMP: f64 = 0.1;
/// The swing is looked at in so many places.
const PLACES: usize = 64;
/// As close to the end of the cycle as counts, as a share of it.
const END: f64 = 1.0 - 1e-9;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    for (name, value) in known.ruleset.patterns.iter().filter(|(_, value)| is_sine(value)) {
        let at = |place: f64| {
            let expr = |kind, ty| Expr { kind, ty, span: value.span };
            let pattern = expr(ExprKind::Pattern(name.clone()), Ty::Pattern);
            let place = expr(ExprKind::Number(place), Ty::Quantity(Dimension::NUMBER));
            let applied = expr(ExprKind::Apply(Box::new(pattern), Box::new(place)), value.ty.clone());
            known.value(&applied).ok()?.as_number()
        };
        let places = (0..PLACES).map(|place| at(place as f64 / PLACES as f64));
        let (Some(all), Some(end)) = (places.collect::<Option<Vec<f64>>>(), at(END)) else { continue };
        let (low, high) = all.iter().fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(*x), b.max(*x)));
        let jump = (all[0] - end).abs();
        if jump > JUMP * (high - low).max(1e-9) {
            let jump = shown(jump, value.ty.dimension().unwrap_or_default());
            findings.push(
                Diagnostic::new(
                    Code::UNUSUAL,
                    value.span,
                    format!("the pattern `{name}` jumps by {jump} where its cycle ends"),
                )
                .label("it ends elsewhere than it begins")
                .help("a whole swing is `sin(cycle * 360 deg)`; `cycle` goes from 0 to 1"),
            );
        }
    }
}

/// Whether a pattern is made of sines, and has no steps of its own.
fn is_sine(value: &Expr) -> bool {
    let has_sine = value.any(&mut |e| matches!(e.kind, ExprKind::Call(Function::Sin | Function::Cos, _)));
    let has_steps = value.any(&mut |e| {
        matches!(
            e.kind,
            ExprKind::If(..)
                | ExprKind::Apply(..)
                | ExprKind::Call(Function::Fraction | Function::Floor | Function::Ceil | Function::Round, _)
        )
    });
    has_sine && !has_steps
}
