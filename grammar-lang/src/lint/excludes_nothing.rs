//! A requirement that every design fulfils, or every design that fulfils the others.

use crate::bounds::Truth;
use crate::bounds::linear::{Row, contradictory};
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Expr, ExprKind, Requirement};

use super::clash::listed;
use super::counts::Counts;
use super::known::Known;

/// Of more requirements than this, none is compared with the others.
const MOST: usize = 100;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    for requirement in &known.ruleset.requirements {
        if known.reasoning(&[]).truth(&requirement.condition) == Truth::Always {
            findings.push(told(requirement).label("holds for every design"));
        }
    }
    // Whoever sets a parameter may let one of two limits count.
    let fixed = known.ruleset.requirements.iter().filter(|requirement| {
        !requirement.condition.any(&mut |e| matches!(e.kind, ExprKind::Param(_)))
            && findings.iter().all(|known| known.span() != requirement.condition.span)
    });
    if known.ruleset.requirements.len() > MOST {
        return;
    }
    let mut counts = Counts::new(known);
    let mut left: Vec<Limits<'_>> = fixed.map(|requirement| Limits::of(requirement, &mut counts)).collect();
    // The last of two that follow from each other is told.
    for place in (0..left.len()).rev() {
        let Some(own) = left.get(place).filter(|own| !own.broken.is_empty()) else { continue };
        let others = left.iter().enumerate().filter(|(other, _)| *other != place).map(|(_, other)| other);
        let excluded = |rows: &[Row]| contradictory(&[counts.base(), &own.broken, rows].concat());
        if excluded(&[]) {
            continue;
        }
        let together: Vec<Row> = others.clone().flat_map(|other| other.kept.clone()).collect();
        if !excluded(&together) {
            continue;
        }
        match others.clone().find(|other| excluded(&other.kept)) {
            // Those that say the same are told as such.
            Some(one) if one.kept == own.kept => {}
            Some(one) => {
                let from = listed(&[one.requirement]);
                findings.push(told(own.requirement).label(format!("it follows from {from}")));
            }
            None => findings.push(told(own.requirement).label("it follows from the others")),
        }
        left.remove(place);
    }
}

/// A requirement, and what holds of the numbers of parts where it does, and where it does not.
struct Limits<'r> {
    requirement: &'r Requirement,
    kept: Vec<Row>,
    broken: Vec<Row>,
}

impl<'r> Limits<'r> {
    fn of(requirement: &'r Requirement, counts: &mut Counts<'_, '_>) -> Self {
        let condition = &requirement.condition;
        let not = Expr {
            kind: ExprKind::Not(Box::new(condition.clone())),
            ty: condition.ty.clone(),
            span: condition.span,
        };
        Self { requirement, kept: counts.rows(condition), broken: counts.rows(&not) }
    }
}

fn told(requirement: &Requirement) -> Diagnostic {
    Diagnostic::new(
        Code::EXCLUDES_NOTHING,
        requirement.condition.span,
        format!("the requirement `{}` excludes nothing", requirement.name),
    )
    .help("remove the condition, or change it so that it excludes something")
}
