//! Fields that read parameters, and have no value that a part can have for some of them.

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::Kind;

use super::instances::{made, told};
use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let rules = known.ruleset;
    let parts = rules.parts.iter().map(|(name, part)| (name, Kind::Block(part)));
    let actuators = rules.actuators.iter().map(|(name, actuator)| (name, Kind::Actuator(actuator)));
    let cells = rules.lattice.iter().map(|lattice| (&lattice.kind, Kind::Cell(lattice)));
    for (name, kind) in parts.chain(actuators).chain(cells) {
        let Some((given, unmade)) = made(known, kind).find_map(|(given, made)| Some((given, made.err()?)))
        else {
            continue;
        };
        // What varies may leave another field without a valid value.
        let mut places = kind.varying();
        let own = places.find(|(field, _)| *field == unmade.field).or_else(|| kind.varying().next());
        let Some((_, expr)) = own else { continue };
        let place = expr.span;
        let with = told(known, kind, &given);
        findings.push(
            Diagnostic::new(
                Code::OUT_OF_DOMAIN,
                place,
                format!("a `{name}` with {with} has no valid `{}`", unmade.field),
            )
            .label(unmade.reason)
            .help("narrow the domain of the parameter, or make the field valid in the whole domain"),
        );
    }
}
