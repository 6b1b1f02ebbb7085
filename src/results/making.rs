//! How a design was made, a rule application at a time: what can be seen of each step, and in words.

use std::collections::{BTreeMap, BTreeSet};

use grammar_lang::ir::RuleSet;
use grammar_lang::source::SourceMap;

use super::describe::Named;
use super::names::Names;
use super::view::{Look, Made, Making, Piece};
use crate::derive::{Derivation, Step};
use crate::design::assembly::Shape;
use crate::design::{Body, Design, Part, PartId};
use crate::document::about_rule;

/// The beginning and the steps of a derivation, with all elements that ever were.
///
/// Steps that were taken back are none of its steps, and do not show.
#[must_use]
pub fn making(rules: &RuleSet, sources: &SourceMap, derivation: &Derivation, names: &Names) -> Making {
    let begin = Derivation::begin(rules).design;
    let named = Named { rules, names, design: &begin };
    let mut making = Making { steps: vec![begun(named)], pieces: Vec::new() };
    let mut there = BTreeMap::new();
    follow(&Design::default(), named, &mut making, &mut there);
    derivation.retrace(rules, |step, before, after| {
        let (old, new) = (Named { design: before, ..named }, Named { design: after, ..named });
        making.steps.push(made(sources, step, old, new));
        follow(before, new, &mut making, &mut there);
    });
    making
}

/// How an element of a part looks.
pub(super) fn look(part: &Part, shape: Shape) -> Look {
    Look { shape, colour: part.made.colour().to_owned(), label: part.kind.clone() }
}

/// Takes over what the last step did to the elements. `there` says which pieces the elements of
/// the design are: by their part and their place in it.
fn follow(
    before: &Design,
    named: Named<'_>,
    making: &mut Making,
    there: &mut BTreeMap<(PartId, usize), usize>,
) {
    let Named { rules, design: after, .. } = named;
    let step = making.steps.len() - 1;
    let body = Body::new(after, rules);
    let mut gone = std::mem::take(there);
    let mut places: BTreeMap<PartId, usize> = BTreeMap::new();
    for (element, id) in body.assembly.elements.iter().zip(&body.parts_of_elements) {
        let Some(part) = after.parts.get(id) else { continue };
        let place = places.entry(*id).or_default();
        let key = (*id, *place);
        *place += 1;
        let look = look(part, element.shape);
        let name = named.part(*id);
        let known = gone.get(&key).copied();
        let piece = known.and_then(|index| making.pieces.get_mut(index)).filter(|piece| piece.look == look);
        let index = match (piece, known) {
            (Some(piece), Some(index)) => {
                let touched = before.parts.get(id).is_none_or(|old| is_other(old, part));
                if touched || piece.poses.last().is_none_or(|(_, pose)| *pose != element.pose) {
                    piece.poses.push((step, element.pose));
                }
                if piece.names.last().is_none_or(|(_, old)| *old != name) {
                    piece.names.push((step, name));
                }
                gone.remove(&key);
                index
            }
            _ => {
                let (poses, names) = (vec![(step, element.pose)], vec![(step, name)]);
                making.pieces.push(Piece { look, from: step, until: None, poses, names });
                making.pieces.len() - 1
            }
        };
        there.insert(key, index);
    }
    for index in gone.into_values() {
        if let Some(piece) = making.pieces.get_mut(index) {
            piece.until = Some(step);
        }
    }
}

/// Whether a part itself was changed, not only where it is.
fn is_other(before: &Part, after: &Part) -> bool {
    before.turn != after.turn || before.params != after.params || before.holding != after.holding
}

/// The beginning in words.
fn begun(named: Named<'_>) -> Made {
    let parts: Vec<String> = named.design.parts.keys().map(|id| named.part(*id)).collect();
    Made {
        rule: "begin".to_owned(),
        about: "The design that every derivation starts from".to_owned(),
        choices: Vec::new(),
        done: format!("places {}", listed(&parts, "part")),
    }
}

/// A step in words.
fn made(sources: &SourceMap, step: &Step, before: Named<'_>, after: Named<'_>) -> Made {
    let rule = before.rules.rule(&step.rule);
    Made {
        rule: step.rule.clone(),
        about: rule.map_or_else(String::new, |rule| about_rule(sources, rule)),
        choices: before.choices(step),
        done: done(before, after),
    }
}

/// What a step did to the parts, in words.
fn done(old: Named<'_>, new: Named<'_>) -> String {
    let (before, after) = (old.design, new.design);
    let old = |id: PartId| old.part(id);
    let new = |id: PartId| new.part(id);
    let mut said = Vec::new();
    let mut say = |verb: &str, names: Vec<String>| {
        if !names.is_empty() {
            said.push(format!("{verb} {}", listed(&names, "part")));
        }
    };
    // What is put in the place of another has its place in the order of the parts, too.
    let instead = |id: &PartId| {
        let (index, _, _) = before.parts.get_full(id)?;
        let (other, _) = after.parts.get_index(index)?;
        let is_swap = !after.parts.contains_key(id) && !before.parts.contains_key(other);
        is_swap.then_some(*other)
    };
    let swaps: Vec<(PartId, PartId)> =
        before.parts.keys().filter_map(|id| Some((*id, instead(id)?))).collect();
    let added = after.parts.keys().filter(|id| !before.parts.contains_key(*id));
    let added = added.filter(|id| !swaps.iter().any(|(_, other)| other == *id));
    say("adds", added.map(|id| new(*id)).collect());
    let swapped = swaps.iter().map(|(id, other)| format!("{} in the place of {}", new(*other), old(*id)));
    say("puts", swapped.collect());
    let gone = before.parts.keys().filter(|id| !after.parts.contains_key(*id));
    let gone = gone.filter(|id| !swaps.iter().any(|(swapped, _)| swapped == *id));
    say("takes away", gone.map(|id| old(*id)).collect());
    let names: BTreeSet<&String> = before.values.keys().chain(after.values.keys()).collect();
    let others = names.into_iter().filter(|name| before.values.get(*name) != after.values.get(*name));
    say("sets", others.map(|name| format!("`{name}`")).collect());
    let both = || before.parts.iter().filter_map(|(id, old)| Some((*id, old, after.parts.get(id)?)));
    let turned = both().filter(|(_, old, part)| old.turn != part.turn);
    say("turns", turned.map(|(id, ..)| new(id)).collect());
    let mut set: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for (id, old, part) in both().filter(|(_, old, part)| old.params != part.params) {
        let other = part.params.iter().filter(|(name, value)| old.params.get(*name) != Some(*value));
        let names: Vec<&str> = other.map(|(name, _)| name.as_str()).collect();
        set.entry(names.join(" and ")).or_default().push(new(id));
    }
    for (attributes, parts) in set {
        say(&format!("sets {attributes} of"), parts);
    }
    let carried = both().filter(|(_, old, part)| old.pose != part.pose && !is_other(old, part));
    say("carries along", carried.map(|(id, ..)| new(id)).collect());
    if said.is_empty() { "changes nothing that can be seen".to_owned() } else { said.join("; ") }
}

/// Names as a list; many are counted.
fn listed(names: &[String], what: &str) -> String {
    match names {
        [] => format!("no {what}"),
        [one] => one.clone(),
        [first @ .., last] if names.len() <= 4 => format!("{} and {last}", first.join(", ")),
        [first, .., last] => format!("{} {what}s, from {first} to {last}", names.len()),
    }
}
