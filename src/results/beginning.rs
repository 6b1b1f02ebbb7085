//! A design as the `begin` of a grammar, so that what was found can be edited, kept and started from.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use grammar_lang::ir::RuleSet;
use grammar_lang::units::{self, Dimension};

use super::describe::{port_name, value};
use crate::derive::Recorded;
use crate::design::{Design, Part, PartId, ends};

/// The lines `begin { place ... }` that make a design. Images of a symmetry are left out: `begin` makes
/// them again. What a grammar's own `begin` has placed keeps its name.
#[must_use]
pub fn beginning(rules: &RuleSet, design: &Design) -> String {
    let names = names(design);
    let mut text = String::from("begin {\n");
    for (id, name) in &names {
        if let Some(part) = design.parts.get(id) {
            let _ = writeln!(text, "  place {name} : {}", placed(rules, design, &names, part));
        }
    }
    text + "}\n"
}

/// The originals with their names, each after what holds it.
fn names(design: &Design) -> Vec<(PartId, String)> {
    let mut numbers: BTreeMap<&str, usize> = BTreeMap::new();
    let mut known: Vec<(PartId, String)> = Vec::new();
    let originals: Vec<(&PartId, &Part)> = design.parts.iter().filter(|(_, p)| p.image == 0).collect();
    // A part that was turned or replaced may stand before what holds it.
    while known.len() < originals.len() {
        let before = known.len();
        for (id, part) in &originals {
            let holder = part.held_by.map(|(holder, _)| holder);
            let stands = |wanted: PartId| known.iter().any(|(known, _)| *known == wanted);
            if stands(**id) || holder.is_some_and(|holder| !stands(holder)) {
                continue;
            }
            let given = design.placed.iter().find(|(_, placed)| *placed == *id).map(|(name, _)| name.clone());
            let name = given.unwrap_or_else(|| {
                let number = numbers.entry(part.kind.as_str()).or_default();
                *number += 1;
                format!("{}{number}", part.kind)
            });
            known.push((**id, name));
        }
        if known.len() == before {
            break;
        }
    }
    known
}

fn placed(rules: &RuleSet, design: &Design, names: &[(PartId, String)], part: &Part) -> String {
    let mut text = part.kind.clone();
    let declared = rules.actuators.get(&part.kind).map(|actuator| &actuator.params);
    let params: Vec<String> = part
        .params
        .iter()
        .map(|(name, given)| {
            let ty = declared.and_then(|params| params.get(name)).map(|param| &param.ty);
            format!("{name} = {}", value(rules, design, &Recorded::new(given), ty))
        })
        .collect();
    if !params.is_empty() {
        let _ = write!(text, "({})", params.join(", "));
    }
    let Some((holder, port)) = part.held_by else { return text };
    let name = names.iter().find(|(id, _)| *id == holder).map_or("?", |(_, name)| name);
    let on = design.parts.get(&holder).and_then(|holder| port_name(rules, holder, port));
    let _ = write!(text, " to {name}.{}", on.as_deref().unwrap_or("?"));
    if part.turn != 0.0 {
        let _ = write!(text, " turned {}", units::shown(part.turn, Dimension::ANGLE));
    }
    if part.holding != ends(rules, &part.kind).0
        && let Some(own) = port_name(rules, part, part.holding)
    {
        let _ = write!(text, " by {own}");
    }
    text
}
