//! A design as the `begin` of a grammar, so that what was found can be edited, kept and started from.

use std::fmt::Write as _;

use grammar_lang::eval::evaluate;
use grammar_lang::ir::{Effect, Expr, ExprKind, RuleSet, Ty};
use grammar_lang::units::{self, Dimension};

use super::describe::{Named, port_name};
use super::names::Names;
use crate::derive::Recorded;
use crate::design::{Design, Part, PartId, ends, pose_at};

/// The lines `begin { place ... }` that make a design. Images of a symmetry are left out: `begin` makes
/// them again, from the same originals. Parts keep their names, written as a grammar can write them: `bender_1` is what is `bender-1` elsewhere.
#[must_use]
pub fn beginning(rules: &RuleSet, called: &Names, design: &Design) -> String {
    let names = names(called, design);
    let named = Named { rules, names: called, design };
    let mut text = String::new();
    for (name, param) in &rules.params {
        let own = design.values.get(name).filter(|_| !is_always_set(rules, name));
        let value = match own {
            Some(value) => value.clone(),
            None if param.given => param.in_force(),
            None => continue,
        };
        let value = literal(named, &Recorded::new(&value), Some(&param.ty));
        let _ = writeln!(
            text,
            "# This body has other values than the grammar says: write `param {name} : {} ... = {value}`.",
            param.ty
        );
    }
    text += "begin {\n";
    for (id, name) in &names {
        if let Some(part) = design.parts.get(id) {
            let _ = writeln!(text, "  place {name} : {}", placed(named, &names, part));
        }
    }
    text + "}\n"
}

/// Whether a rule that is carried out always sets a parameter of the grammar: it does so in any design.
fn is_always_set(rules: &RuleSet, name: &str) -> bool {
    let sets = |effect: &Effect| matches!(effect, Effect::SetOfBody { name: set, .. } if set == name);
    rules.always.iter().flat_map(|rule| Effect::single(&rule.effects)).any(sets)
}

/// The original of each part, with its name, after what holds it: so its images are those that it has, and move as they do.
fn names(called: &Names, design: &Design) -> Vec<(PartId, String)> {
    let mut known: Vec<(PartId, String)> = Vec::new();
    loop {
        let before = known.len();
        for (id, part) in design.parts.iter().filter(|(_, part)| part.image_of.is_none()) {
            let is_known = |id: PartId| known.iter().any(|(other, _)| *other == id);
            let is_held = part.held_by.is_none_or(|(holder, _)| is_known(original(design, holder)));
            if is_held && !is_known(*id) {
                known.push((*id, written(called.get(*id).unwrap_or_default(), &part.kind, &known)));
            }
        }
        if known.len() == before {
            return known;
        }
    }
}

/// The part of which another is the image; a part that is no image is its own.
fn original(design: &Design, id: PartId) -> PartId {
    design.parts.get(&id).and_then(|part| part.image_of).unwrap_or(id)
}

/// A part as a text names it: `arm`, its first image `arm.twin`, another one `images(arm)[1]`.
fn path(design: &Design, names: &[(PartId, String)], id: PartId) -> Option<String> {
    let (own, name) = names.iter().find(|(known, _)| *known == original(design, id))?;
    Some(match design.orbit(*own).iter().position(|one| *one == id)? {
        0 => name.clone(),
        1 => format!("{name}.twin"),
        image => format!("images({name})[{}]", image - 1),
    })
}

/// A name as a grammar can write it: letters, digits and `_`, and no other part's.
fn written(name: &str, kind: &str, known: &[(PartId, String)]) -> String {
    let sign = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let plain: String = name.chars().map(sign).collect();
    let plain =
        if plain.starts_with(|c: char| c.is_ascii_alphabetic()) { plain } else { format!("{kind}_{plain}") };
    let numbered = (2..).map(|number| format!("{plain}_{number}"));
    let free = |name: &String| known.iter().all(|(_, other)| other != name);
    std::iter::once(plain.clone()).chain(numbered).find(free).unwrap_or(plain)
}

/// The turn by which a part stands as it does: that of an image is measured in a mirrored frame.
fn turn(holder: &Part, port: u8, part: &Part) -> f64 {
    let full = 2.0 * std::f64::consts::PI;
    let reflected = if part.turn == 0.0 { 0.0 } else { full - part.turn };
    let quarters = [0.0, 0.25, 0.5, 0.75].map(|share| share * full);
    let fits = |turn: &f64| {
        let as_placed = Part { turn: *turn, ..part.clone() };
        pose_at(holder, port, &as_placed).is_some_and(|pose| {
            let apart = pose.inverse() * part.pose;
            apart.translation.vector.norm() < 1e-6 && apart.rotation.angle() < 1e-4
        })
    };
    [part.turn, reflected].into_iter().chain(quarters).find(fits).unwrap_or(part.turn)
}

/// A value as a grammar writes it: the same bits when it is read again.
fn literal(named: Named<'_>, value: &Recorded, ty: Option<&Ty>) -> String {
    match (value, ty) {
        (Recorded::Number(_), Some(Ty::Enum(of))) => format!("{of}.{}", named.value(value, ty)),
        (Recorded::Number(x), _) => units::exact(*x, ty.and_then(Ty::dimension).unwrap_or_default()),
        (Recorded::List(items), Some(Ty::List(of))) => {
            let items: Vec<String> = items.iter().map(|item| literal(named, item, Some(of))).collect();
            format!("[{}]", items.join(", "))
        }
        (Recorded::Vector(vector), Some(Ty::Vector(of))) => {
            format!("vector({})", vector.map(|x| units::exact(x, *of)).join(", "))
        }
        (Recorded::Text(text), _) => format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\"")),
        _ => named.value(value, ty),
    }
}

fn placed(named: Named<'_>, names: &[(PartId, String)], part: &Part) -> String {
    let Named { rules, design, .. } = named;
    let mut text = part.kind.clone();
    let declared = rules.params_of(&part.kind);
    let params: Vec<String> = part
        .params
        .iter()
        .filter_map(|(name, given)| {
            let param = declared.and_then(|params| params.get(name));
            // What a parameter of the grammar may change is written.
            let fixed = |default: &&Expr| !default.any(&mut |e| matches!(e.kind, ExprKind::Param(_)));
            let default = param.and_then(|param| param.default.as_ref()).filter(fixed);
            let default = default.and_then(|default| evaluate(default, rules, &mut Vec::new()).ok());
            let differs = default.as_ref() != Some(given);
            let written = || literal(named, &Recorded::new(given), param.map(|param| &param.ty));
            differs.then(|| format!("{name} = {}", written()))
        })
        .collect();
    if !params.is_empty() {
        let _ = write!(text, "({})", params.join(", "));
    }
    let Some((holder, port)) = part.held_by else { return text };
    let name = path(design, names, holder);
    let Some(holder) = design.parts.get(&holder) else { return text };
    let port_of_it = port_name(holder, port);
    let _ = write!(text, " to {}.{}", name.as_deref().unwrap_or("?"), port_of_it.as_deref().unwrap_or("?"));
    let turn = turn(holder, port, part);
    if turn != 0.0 {
        let _ = write!(text, " turned {}", units::exact(turn, Dimension::ANGLE));
    }
    if part.holding != ends(rules, &part.kind).0
        && let Some(own) = port_name(part, part.holding)
    {
        let _ = write!(text, " by {own}");
    }
    if part.alone && !holder.alone {
        text += " alone";
    }
    text
}
