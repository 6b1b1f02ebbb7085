//! Designs and values in words.

use std::collections::BTreeMap;
use std::fmt::Write;

use grammar_lang::eval::{EvalError, Reference, Value, WithValues, evaluate};
use grammar_lang::ir::{RuleSet, Spread, Ty};
use grammar_lang::source::SourceMap;
pub use grammar_lang::units::quantity;
use grammar_lang::units::{self, Dimension};
use indexmap::IndexMap;

use super::names::Names;
use crate::derive::random::Stream;
use crate::derive::{Blocked, Derivation, Recorded, Step};
use crate::design::{Design, Part, PartId, lattice, ports};

/// What people call a port: its name, with its number where several share it.
pub fn port_name(part: &Part, port: u8) -> Option<String> {
    let frames = ports(part);
    let own = frames.get(port as usize)?;
    let several = frames.iter().filter(|p| p.name == own.name).count() > 1;
    Some(if several { format!("{}[{}]", own.name, own.number) } else { own.name.clone() })
}

/// A design of a grammar, with what people call its parts.
#[derive(Clone, Copy, Debug)]
pub struct Named<'a> {
    /// The rules.
    pub rules: &'a RuleSet,
    /// The names, also those of parts that are gone.
    pub names: &'a Names,
    /// The design.
    pub design: &'a Design,
}

impl Named<'_> {
    /// What people call a part: its name, or the place of a cell.
    pub(super) fn part(self, id: PartId) -> String {
        if let Some([x, y, z]) = lattice::place_of(id) {
            let kind = self.design.parts.get(&id).map_or("place", |cell| cell.kind.as_str());
            return format!("{kind} ({x}, {y}, {z})");
        }
        self.names.get(id).unwrap_or("a part that is gone").to_owned()
    }

    /// A value as people write it.
    pub(super) fn value(self, recorded: &Recorded, ty: Option<&Ty>) -> String {
        let Self { rules, design, .. } = self;
        let several = |items: &[Recorded], ty: Option<&Ty>| {
            let items: Vec<String> = items.iter().map(|i| self.value(i, ty)).collect();
            items.join(", ")
        };
        match recorded {
            Recorded::Number(x) => match ty {
                Some(Ty::Enum(name)) => rules.value_of(name, *x).map_or_else(|| x.to_string(), str::to_owned),
                _ => units::shown(*x, ty.and_then(Ty::dimension).unwrap_or_default()),
            },
            Recorded::List(items) => match ty {
                Some(Ty::Record(name, fields)) => {
                    let fields = fields.iter().zip(items);
                    let fields: Vec<String> =
                        fields.map(|((n, ty), i)| format!("{n} = {}", self.value(i, Some(ty)))).collect();
                    format!("{name}({})", fields.join(", "))
                }
                Some(Ty::List(item)) => format!("[{}]", several(items, Some(item))),
                _ => format!("[{}]", several(items, None)),
            },
            Recorded::Set(items) => {
                let item = match ty {
                    Some(Ty::Domain(item)) => Some(&**item),
                    _ => None,
                };
                format!("{{ {} }}", several(items, item))
            }
            Recorded::Range(low, high, _) => {
                let dimension = match ty {
                    Some(Ty::Domain(item)) => item.dimension().unwrap_or_default(),
                    _ => Dimension::NUMBER,
                };
                format!("{} .. {}", units::shown(*low, dimension), units::shown(*high, dimension))
            }
            Recorded::Table(table) => format!("a table of {} rows", table.rows.len()),
            Recorded::Valve(state) => format!("{state:?}").to_lowercase(),
            Recorded::Valves(valves) => format!("a cycle of {} s", valves.period),
            Recorded::Vector(x) => {
                let dimension = match ty {
                    Some(Ty::Vector(d)) => *d,
                    _ => Dimension::NUMBER,
                };
                format!("vector({})", x.map(|x| units::shown(x, dimension)).join(", "))
            }
            Recorded::Rotation(_) => "a rotation".to_owned(),
            Recorded::Shape(_) => "a shape".to_owned(),
            Recorded::Curve(_) => "a curve".to_owned(),
            Recorded::Bool(x) => x.to_string(),
            Recorded::Text(x) | Recorded::Pattern(x) => x.clone(),
            Recorded::Kind(name, _) => name.clone(),
            Recorded::Reference(Reference::Part(id)) => self.part(*id),
            Recorded::Reference(Reference::Port(id, port)) => {
                let name = design.parts.get(id).and_then(|p| port_name(p, *port));
                name.unwrap_or_else(|| "?".to_owned())
            }
            Recorded::Reference(Reference::Joint(id)) => {
                format!("the joint of {}", self.part(*id))
            }
            Recorded::Reference(Reference::Step(id)) => format!("step {id}"),
            Recorded::Reference(Reference::Element(id)) => format!("element {id}"),
            Recorded::Reference(Reference::World(place)) => format!("world {place}"),
        }
    }

    /// What a step matched and chose in the design before it: names and values.
    #[must_use]
    pub fn choices(self, step: &Step) -> Vec<(String, String)> {
        let rule = self.rules.rule(&step.rule);
        let locals = rule.map(|r| r.locals.as_slice()).unwrap_or_default();
        let item = |name: &String| {
            let choice = rule.and_then(|r| r.choices.iter().find(|c| c.name == *name))?;
            match &choice.domain.ty {
                Ty::Domain(item) | Ty::List(item) => Some(&**item),
                _ => None,
            }
        };
        let pairs = locals.iter().zip(&step.locals);
        pairs.map(|(name, local)| (name.clone(), self.value(local, item(name)))).collect()
    }

    /// A step as one line, as an example can say it: the rule and what it matched and chose. What follows from these by `let` is left out.
    #[must_use]
    pub fn step(self, step: &Step) -> String {
        let rule = self.rules.rule(&step.rule);
        let follows = |name: &String| {
            rule.is_some_and(|r| r.choices.iter().any(|c| c.name == *name && c.spread == Spread::Fixed))
        };
        let choices = self.choices(step).into_iter().filter(|(name, _)| !follows(name));
        let values: Vec<String> = choices.map(|(name, value)| format!("{name} = {value}")).collect();
        format!("{}({})", step.rule, values.join(", "))
    }

    /// A lattice as text: its cells seen from above, a square of signs for each layer that has some, the highest first. Cells
    /// that are alike have the same letter.
    fn layers(self, out: &mut String) {
        let Self { rules, design, .. } = self;
        let Some(lattice) = &rules.lattice else { return };
        let mut kinds: Vec<&IndexMap<String, Value>> = Vec::new();
        for cell in design.parts.values() {
            if !kinds.contains(&&cell.params) {
                kinds.push(&cell.params);
            }
        }
        // Writing to a String never fails.
        let _ = writeln!(out, "{} cells", design.parts.len());
        let letter = |kind: usize| char::from_u32('a' as u32 + kind as u32).filter(char::is_ascii_lowercase);
        for (kind, params) in kinds.iter().enumerate() {
            let declared = &lattice.cell.params;
            let shown = params.iter().map(|(name, given)| {
                let ty = declared.get(name).map(|param| &param.ty);
                format!("{name} = {}", self.value(&Recorded::new(given), ty))
            });
            let shown: Vec<String> = shown.collect();
            let _ = writeln!(out, "  {} {}({})", letter(kind).unwrap_or('?'), lattice.kind, shown.join(", "));
        }
        let [nx, ny, nz] = lattice.sides;
        for y in (0..ny).rev() {
            let sign = |x: usize, z: usize| {
                let id = lattice::cell_at(lattice, [x as i64, y as i64, z as i64])?;
                let cell = design.parts.get(&id)?;
                let kind = kinds.iter().position(|params| **params == cell.params)?;
                Some(letter(kind).unwrap_or('?'))
            };
            // Forward is to the right, left is up.
            let row = |z: usize| (0..nx).map(|x| sign(x, z).unwrap_or('.')).collect::<String>();
            let rows: Vec<String> = (0..nz).map(row).collect();
            if rows.iter().any(|row| row.contains(|c| c != '.')) {
                let _ = writeln!(out, "layer {y}");
                for row in rows {
                    let _ = writeln!(out, "  {row}");
                }
            }
        }
    }
}

/// A derivation: its steps, then its parts, as stable text.
#[must_use]
pub fn derivation(rules: &RuleSet, derivation: &Derivation) -> String {
    let design = &derivation.design;
    let names = &Names::through(rules, derivation);
    let named = Named { rules, names, design };
    let mut out = String::from("steps\n");
    let mut number = 0;
    derivation.retrace(rules, |made, before, _| {
        number += 1;
        // Writing to a String never fails.
        let _ = writeln!(out, "  {number:>2}. {}", Named { design: before, ..named }.step(made));
    });
    out += &of_body(rules, design);
    if rules.lattice.is_some() {
        named.layers(&mut out);
        let _ = writeln!(out, "body {}", design.canonical_hash());
        return out;
    }
    out.push_str("parts\n");
    for (index, (id, part)) in design.parts.iter().enumerate() {
        let held = part.held_by.map_or(String::new(), |(holder, port)| {
            let port = design.parts.get(&holder).and_then(|p| port_name(p, port));
            format!(" on {}.{}", named.part(holder), port.unwrap_or_else(|| "?".to_owned()))
        });
        let turn = if part.turn == 0.0 {
            String::new()
        } else {
            format!(", turned {} deg", (part.turn.to_degrees() * 1e3).round() / 1e3)
        };
        let image = part.image_of.map_or(String::new(), |o| format!(", image of {}", named.part(o)));
        let p = part.pose.translation.vector * 1e3;
        let at = [p.x, p.y, p.z].map(|x| {
            let x = (x * 1e3).round() / 1e3;
            if x == 0.0 { 0.0 } else { x }
        });
        let own = varied(&design.known(rules), part);
        let _ = writeln!(out, "  {index:>2}. {}{own}{held}{turn}{image}, at {at:?} mm", named.part(*id));
    }
    let _ = writeln!(out, "body {}", design.canonical_hash());
    out
}

/// The parameters of a part that are not what they are by default: `(level = 2)`; empty where there are none.
fn varied(known: &WithValues<'_>, part: &Part) -> String {
    let rules = known.rules;
    let Some(kind) = rules.kind(&part.kind) else { return String::new() };
    let own = kind.params().iter().filter_map(|(name, declared)| {
        let given = part.params.get(name)?;
        let default = declared.default.as_ref().and_then(|it| evaluate(it, known, &mut Vec::new()).ok());
        if default.as_ref() == Some(given) {
            return None;
        }
        Some(format!("{name} = {}", told(rules, given, &declared.ty)?))
    });
    let own: Vec<String> = own.collect();
    if own.is_empty() { String::new() } else { format!(" ({})", own.join(", ")) }
}

/// The value of a parameter for people.
fn told(rules: &RuleSet, value: &Value, ty: &Ty) -> Option<String> {
    Some(match (value, ty) {
        (Value::Number(x), Ty::Enum(of)) => rules.value_of(of, *x)?.to_owned(),
        (Value::Number(x), ty) => units::shown(*x, ty.dimension().unwrap_or_default()),
        (Value::Bool(x), _) => x.to_string(),
        (Value::Pattern(name), _) => name.to_string(),
        _ => return None,
    })
}

/// What the parameters of the grammar that rules set are in a body, a line each; nothing where there are none.
fn of_body(rules: &RuleSet, design: &Design) -> String {
    let set = rules.params.iter().filter(|(_, param)| param.set_by_rules);
    let lines = set.filter_map(|(name, param)| {
        let value = design.values.get(name).cloned().unwrap_or_else(|| param.in_force());
        Some(format!("  {name} = {}\n", told(rules, &value, &param.ty)?))
    });
    let lines: String = lines.collect();
    if lines.is_empty() { lines } else { format!("values of the body\n{lines}") }
}

/// The derivation that a seed gives in some moves, as stable text: what `sgc derive` prints; and
/// why some of its moves did nothing, empty if none was. After each move, `made` gets the number of moves so far.
#[must_use]
pub fn derived(
    rules: &RuleSet,
    sources: &SourceMap,
    first: Derivation,
    seed: u64,
    moves: usize,
    made: &mut dyn FnMut(usize),
) -> (String, String) {
    let mut now = first;
    let mut random = Stream::named(seed, "derive");
    let mut idle = 0;
    let mut stopped: BTreeMap<(usize, Blocked), usize> = BTreeMap::new();
    for number in 1..=moves {
        let step = now.advance(rules, &mut random, 0.0);
        match step.result {
            Some(next) => now = next,
            None => {
                idle += 1;
                for blocked in step.blocked {
                    *stopped.entry(blocked).or_default() += 1;
                }
            }
        }
        made(number);
    }
    (derivation(rules, &now), why_idle(rules, sources, idle, moves, &stopped))
}

/// Why moves did nothing: what stopped each rule in them, and how often.
fn why_idle(
    rules: &RuleSet,
    sources: &SourceMap,
    idle: usize,
    moves: usize,
    stopped: &BTreeMap<(usize, Blocked), usize>,
) -> String {
    if idle == 0 {
        return String::new();
    }
    let mut out = format!("{idle} of {moves} moves did nothing: no rule could be applied\n");
    for (index, rule) in rules.rules.iter().enumerate() {
        let reasons = stopped.iter().filter(|((i, _), _)| *i == index);
        let sentence = |why: &Blocked| match why {
            Blocked::NoValue(error) => no_value(error, sources),
            other => other.sentence(rules),
        };
        let times = |n: &usize| if *n == 1 { "once".to_owned() } else { format!("{n} times") };
        let reasons: Vec<String> =
            reasons.map(|((_, why), n)| format!("{} ({})", sentence(why), times(n))).collect();
        let why = if reasons.is_empty() { "its weight is 0".to_owned() } else { reasons.join("; ") };
        let _ = writeln!(out, "  {}: {why}", rule.name);
    }
    out
}

/// Where and why an expression has no value.
#[must_use]
pub fn no_value(error: &EvalError, sources: &SourceMap) -> String {
    let (line, column) = sources.line_column(error.span);
    let name = sources.get(error.span.file).map_or("", |s| s.name.as_str());
    let text = sources.slice(error.span);
    format!("{name}:{line}:{column}: `{text}` has no value: {}", error.reason)
}

/// A term's value in a unit that people use: that of the objective, if it fits.
#[must_use]
pub fn term(rules: &RuleSet, unit: &str, name: &str, si: f64) -> String {
    let dimension = rules.terms.get(name).and_then(|t| t.ty.dimension()).unwrap_or_default();
    let objective = units::parse(unit).ok().filter(|u| u.dimension == dimension);
    match objective {
        Some(factor) => quantity(si / factor.factor, unit),
        None => quantity(si, &units::display_unit(dimension)),
    }
}
