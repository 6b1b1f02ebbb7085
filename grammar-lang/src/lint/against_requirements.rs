//! Rules that ask for what a requirement forbids.

use crate::bounds::linear::{Row, contradictory};
use crate::diagnostics::{Code, Diagnostic};

use super::counts::Counts;
use super::known::Known;
use super::places::conditions;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let requirements = &known.ruleset.requirements;
    for rule in &known.ruleset.rules {
        for condition in conditions(rule) {
            let mut counts = Counts::new(known);
            let asked = counts.rows(condition);
            if asked.is_empty() {
                continue;
            }
            let against = requirements.iter().find(|requirement| {
                let required = counts.rows(&requirement.condition);
                let both: Vec<Row> =
                    asked.iter().cloned().chain(required).chain(counts.base().iter().cloned()).collect();
                contradictory(&both)
            });
            let Some(against) = against else { continue };
            findings.push(
                Diagnostic::new(
                    Code::AGAINST_REQUIREMENT,
                    condition.span,
                    format!(
                        "the rule `{}` never applies: designs like this break the requirement `{}`",
                        rule.name, against.name
                    ),
                )
                .label("asks for what no design may be")
                .also(against.condition.span, "required here")
                .help("relax one of the two, or remove the rule"),
            );
        }
    }
}
