//! Parameters of parts that rules set and nothing reads: a `per` was forgotten, or an actuation.

use indexmap::IndexMap;

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Effect, Expr, ExprKind, Kind, Owner, Settable};
use crate::source::Span;

use super::known::Known;
use super::places::places;

/// What every actuator's own shape reads.
const SEGMENTS: &str = "segments";

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let mut unread = set_by_rules(known);
    if unread.is_empty() {
        return;
    }
    let mut reads = |expr: &Expr| {
        expr.any(&mut |e| {
            if let ExprKind::Attribute(_, attribute) = &e.kind {
                unread.shift_remove(attribute.text());
            }
            false
        });
    };
    places(known).into_iter().flat_map(|place| place.exprs).for_each(&mut reads);
    for feature in known.ruleset.novelties.values().flat_map(|set| set.features.values()) {
        reads(&feature.value);
    }
    for variable in known.ruleset.actuations.values().flat_map(|a| &a.variables) {
        if let Owner::Group(number) = &variable.owner {
            reads(number);
        }
    }
    for (name, (kind, span)) in unread {
        let message = format!("rules set `{name}` of `{kind}`, but nothing reads it");
        let per = if known.ruleset.is_actuator(kind) {
            format!("in `per a.{name}` of an actuation")
        } else {
            "in a `where`".to_owned()
        };
        findings.push(Diagnostic::new(Code::UNUSED, span, message).label("this has no effect").help(format!(
            "read it where it should matter, as in a field of `{kind}`, {per} or in a `require`; or do not set it"
        )));
    }
}

/// The parameters that rules set, with the kind that has them and where the first rule does.
fn set_by_rules<'r>(known: &Known<'r>) -> IndexMap<&'r str, (&'r str, Span)> {
    let ruleset = known.ruleset;
    let mut set = IndexMap::new();
    let mut note = |name: &'r str, value: &Expr| {
        let parts = ruleset.parts.iter().map(|(kind, part)| (kind, Kind::Block(part)));
        let actuators = ruleset.actuators.iter().map(|(kind, actuator)| (kind, Kind::Actuator(actuator)));
        let owners: Vec<_> =
            parts.chain(actuators).filter(|(_, kind)| kind.params().contains_key(name)).collect();
        if let Some((kind, _)) = owners.first()
            && name != SEGMENTS
            && !owners.iter().any(|(_, of)| of.reads(name))
        {
            set.entry(name).or_insert((kind.as_str(), value.span));
        }
    };
    for effect in ruleset.rules.iter().chain(&ruleset.always).flat_map(|rule| Effect::single(&rule.effects)) {
        match effect {
            Effect::Attach {
                what: Expr { kind: ExprKind::Kind(_, params) | ExprKind::With(_, params), .. },
                ..
            }
            | Effect::Replace {
                with: Expr { kind: ExprKind::Kind(_, params) | ExprKind::With(_, params), .. },
                ..
            } => {
                params.iter().for_each(|(name, value)| note(name, value));
            }
            Effect::Set { attribute: Settable::Param(name), value, .. } => note(name, value),
            _ => {}
        }
    }
    set
}
