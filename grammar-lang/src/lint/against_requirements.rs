//! Rules and preferences that ask for what a requirement forbids.

use std::collections::{BTreeMap, BTreeSet};

use crate::bounds::Truth;
use crate::bounds::linear::{Row, contradictory};
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{BodyMethod, Expr, ExprKind, Operator, Preference, Rule, Ty};

use super::counts::Counts;
use super::known::Known;
use super::places::conditions;

/// A condition is compared with so many requirements at most that are about the same counts: the time grows with the text.
const MOST: usize = 20;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let ruleset = known.ruleset;
    let mut counts = Counts::new(known);
    let required: Vec<Vec<Row>> =
        ruleset.requirements.iter().map(|requirement| counts.rows(&requirement.condition)).collect();
    let all = ruleset.rules.iter().flat_map(|rule| conditions(rule).map(move |condition| (rule, condition)));
    let asked: Vec<(&Rule, &Expr, Vec<Row>)> =
        all.map(|(rule, condition)| (rule, condition, counts.rows(condition))).collect();
    let preferred: Vec<(&Preference, Vec<Row>)> = ruleset
        .preferences
        .iter()
        .map(|preference| (preference, counts.rows(&preference.condition)))
        .collect();
    let about = About::new(&required);
    let always: Vec<Vec<Row>> = counts.base().iter().map(|row| vec![row.clone()]).collect();
    let always_about = About::new(&always);
    let forbidden = |asked: &[Row]| {
        let against = about.those(asked).into_iter().take(MOST).find(|place| {
            let both = || asked.iter().chain(required.get(*place).into_iter().flatten()).cloned();
            let mut rows: Vec<Row> = both().collect();
            for place in always_about.those(&rows) {
                rows.extend(always.get(place).into_iter().flatten().cloned());
            }
            contradictory(&rows)
        });
        against.and_then(|place| ruleset.requirements.get(place))
    };
    for (preference, asked) in preferred {
        let Some(against) = forbidden(&asked) else { continue };
        findings.push(
            Diagnostic::new(
                Code::AGAINST_REQUIREMENT,
                preference.condition.span,
                format!(
                    "no design can fulfil this preference: the requirement `{}` forbids it",
                    against.name
                ),
            )
            .label("no allowed design fulfils this")
            .also(against.condition.span, "required here")
            .help("relax one of the two, or remove the preference"),
        );
    }
    for fallback in &ruleset.fallbacks {
        let asked = counts.rows(&fallback.condition);
        let never = known.reasoning(&[]).truth(&fallback.condition) == Truth::Never;
        let against = forbidden(&asked);
        if never || against.is_some() {
            let found = Diagnostic::new(
                Code::AGAINST_REQUIREMENT,
                fallback.condition.span,
                format!("the fallback `{}` is never drawn", fallback.rule),
            );
            let found = found.label("never holds for this lattice");
            let found = match against {
                Some(against) => found.also(against.condition.span, "because of this requirement"),
                None => found,
            };
            findings.push(found.help("lower the number, or remove the fallback"));
        }
    }
    let archive = match ruleset.search.bodies.as_ref().map(|bodies| &bodies.method) {
        Some(BodyMethod::Archive(archive)) => Some(archive),
        _ => None,
    };
    for kind in archive.iter().flat_map(|archive| archive.descriptors.values()) {
        let Some(against) = forbidden(&counts.rows(&at_least(&kind.value, kind.from))) else { continue };
        findings.push(
            Diagnostic::new(
                Code::AGAINST_REQUIREMENT,
                kind.value.span,
                "every allowed design belongs to the first cell of this archive",
            )
            .label(format!("the first cell begins at {}", kind.from))
            .also(against.condition.span, "required here")
            .help("lower `from`, or relax the requirement"),
        );
    }
    for (rule, condition, asked) in asked {
        let Some(against) = forbidden(&asked) else { continue };
        findings.push(
            Diagnostic::new(
                Code::AGAINST_REQUIREMENT,
                condition.span,
                format!(
                    "the rule `{}` never applies: designs like this break the requirement `{}`",
                    rule.name, against.name
                ),
            )
            .label("no allowed design fulfils this")
            .also(against.condition.span, "required here")
            .help("relax one of the two, or remove the rule"),
        );
    }
}

/// A condition that asks for so much of a quantity.
fn at_least(value: &Expr, least: f64) -> Expr {
    let number = Expr { kind: ExprKind::Number(least), ..value.clone() };
    let sides = (Box::new(value.clone()), Box::new(number));
    Expr { kind: ExprKind::Binary(sides.0, Operator::GreaterEqual, sides.1), ty: Ty::Bool, ..value.clone() }
}

/// Which of several sets of inequalities are about a variable.
struct About(BTreeMap<usize, Vec<usize>>);

impl About {
    fn new(sets: &[Vec<Row>]) -> Self {
        let mut about: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (place, rows) in sets.iter().enumerate() {
            let variables: BTreeSet<usize> = rows.iter().flat_map(Row::variables).collect();
            variables.into_iter().for_each(|variable| about.entry(variable).or_default().push(place));
        }
        Self(about)
    }

    /// The sets that have a variable in common with some inequalities, in their order.
    fn those(&self, rows: &[Row]) -> BTreeSet<usize> {
        let variables = rows.iter().flat_map(Row::variables);
        variables.filter_map(|variable| self.0.get(&variable)).flatten().copied().collect()
    }
}
