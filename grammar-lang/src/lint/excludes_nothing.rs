//! A requirement that every design fulfils, or every design that fulfils the others.

use crate::bounds::Truth;
use crate::bounds::linear::{Row, contradictory};
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Expr, ExprKind, Preference, Requirement};

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
    let wanted: Vec<Diagnostic> =
        known.ruleset.preferences.iter().filter_map(|one| always_had(known, one, &mut counts)).collect();
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
    findings.extend(wanted);
}

/// A preference that every design fulfils, or every design that fulfils the requirements.
fn always_had(known: &Known<'_>, preference: &Preference, counts: &mut Counts<'_, '_>) -> Option<Diagnostic> {
    let condition = &preference.condition;
    let always = known.reasoning(&[]).truth(condition) == Truth::Always;
    let broken = counts.rows(&not(condition));
    let kept: Vec<Row> =
        known.ruleset.requirements.iter().flat_map(|one| counts.rows(&one.condition)).collect();
    let excluded = |rows: &[Row]| contradictory(&[counts.base(), broken.as_slice(), rows].concat());
    let follows = !broken.is_empty() && !excluded(&[]) && excluded(&kept);
    (always || follows).then(|| {
        Diagnostic::new(
            Code::EXCLUDES_NOTHING,
            condition.span,
            format!("every design fulfils the preference `{}`", preference.name),
        )
        .label(if always { "holds for every design" } else { "it follows from the requirements" })
        .help("prefer what some designs lack, or take the preference out")
    })
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
        Self { requirement, kept: counts.rows(condition), broken: counts.rows(&not(condition)) }
    }
}

/// The opposite of a condition.
fn not(condition: &Expr) -> Expr {
    Expr { kind: ExprKind::Not(Box::new(condition.clone())), ..condition.clone() }
}

fn told(requirement: &Requirement) -> Diagnostic {
    Diagnostic::new(
        Code::EXCLUDES_NOTHING,
        requirement.condition.span,
        format!("the requirement `{}` excludes nothing", requirement.name),
    )
    .help("remove the condition, or change it so that it excludes something")
}
