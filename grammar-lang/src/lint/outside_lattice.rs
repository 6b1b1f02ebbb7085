//! Regions that lie outside the lattice wherever the cell is that they are beside.

use crate::bounds::{Interval, Repeated};
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{DesignFunction, Effect, Expr, ExprKind, Function};

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let Some(lattice) = &known.ruleset.lattice else { return };
    let mut look = |region: &Expr, numbers: &dyn Fn(&Expr) -> Interval| {
        region.any(&mut |e| {
            if let ExprKind::Call(Function::Design(DesignFunction::Region), arguments) = &e.kind {
                let offsets = arguments.iter().skip(1).zip(lattice.sides).zip(["x", "y", "z"]);
                findings
                    .extend(offsets.filter_map(|((offset, side), axis)| beyond(offset, side, axis, numbers)));
            }
            false
        });
    };
    let rules = known.rules().map(|(rule, locals)| (&rule.effects, locals.narrowed.as_slice()));
    for (effects, locals) in rules.chain([(&lattice.begin, &[][..])]) {
        known.reasoning(locals).through_effects(effects, Repeated::Together, &mut |reasoning, effect| {
            if let Effect::Cells(cells) = effect {
                let locals = reasoning.locals.clone();
                look(&cells.region, &|e| known.reasoning(&locals).numbers(e));
            }
        });
    }
}

/// Says of an offset that it leads out of the lattice from everywhere, if it does.
fn beyond(offset: &Expr, side: usize, axis: &str, numbers: &dyn Fn(&Expr) -> Interval) -> Option<Diagnostic> {
    let (low, high) = match &offset.kind {
        ExprKind::Range(low, high) => (numbers(low).low, numbers(high).high),
        _ => (numbers(offset).low, numbers(offset).high),
    };
    let last = side as f64 - 1.0;
    let nearest = if low > last {
        low
    } else if high < -last {
        high
    } else {
        return None;
    };
    Some(
        Diagnostic::new(
            Code::OUT_OF_DOMAIN,
            offset.span,
            format!("wherever the cell is, these places are outside the lattice: it has {side} places along {axis}"),
        )
        .label(format!("an offset of at least {}", nearest.abs()))
        .help("make the offset smaller, or the lattice larger"),
    )
}
