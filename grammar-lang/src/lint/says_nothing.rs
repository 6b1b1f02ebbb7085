//! Clauses that do nothing: empty examples and reasons, a part that is replaced by its like, curves of one point, what is observed or
//! compared though it is the same for every design.

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{
    Attribute, Effect, Expr, ExprKind, Function, Group, Matched, Objective, Operator, Owner, PartAttribute,
    Rule, State, Word,
};
use crate::source::Span;
use crate::units::{Dimension, shown};

use super::known::Known;
use super::places::places;

/// No sensor of an angle scatters by so much, rad: 30 degrees.
const MOST_NOISE: f64 = 0.53;

/// No sensor of a robot is so late, s.
const LATE: f64 = 1.0;

/// An objective in such a unit of length, m, or a larger one, leaves values near zero.
const LARGE: f64 = 100.0;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    let mut told = |place: Span, message: &str, label: &str, help: &str| {
        findings.push(Diagnostic::new(Code::POINTLESS, place, message).label(label).help(help));
    };
    let rules = known.ruleset;
    for (name, example) in &rules.examples {
        if example.clauses.is_empty() {
            told(
                example.span,
                &format!("the example `{name}` does and expects nothing"),
                "empty",
                "write `step a = RULE(...)` and `expect CONDITION`, or take it out",
            );
        }
    }
    let required = rules.requirements.iter().map(|r| (&r.because, r.condition.span));
    for (because, place) in required.chain(rules.preferences.iter().map(|p| (&p.because, p.condition.span))) {
        if because.as_ref().is_some_and(|text| text.trim().is_empty()) {
            told(place, "this reason is empty", "no text after `because`", "say why, or leave `because` out");
        }
    }
    for rule in &rules.rules {
        if let Some((place, kind)) = replaced_by_its_like(rule) {
            told(
                place,
                &format!("the rule `{}` replaces a `{kind}` with a `{kind}`", rule.name),
                "the same kind",
                "replace it with another kind, or set its parameters: `set p.PARAMETER = ...`",
            );
        }
    }
    for rule in &rules.rules {
        if let Some(place) = removed_again(rule) {
            told(
                place,
                &format!("the rule `{}` removes what it has attached", rule.name),
                "the design stays as it was",
                "take both lines out, or remove another part",
            );
        }
        for over in repeated_once(&rule.effects) {
            told(
                over,
                "this block is repeated only once",
                "a range of one number",
                "a range includes its last number: `0 .. 5` repeats six times. Or write the lines without `for`",
            );
        }
    }
    for actuation in rules.actuations.values() {
        for variable in &actuation.variables {
            if let Owner::Group(group) = &variable.owner
                && is_image(group)
            {
                told(
                    group.span,
                    "grouping by `image` puts all actuators into one group",
                    "images follow their originals, whose number is 0",
                    "remove `per`: each original then has a value of its own. For a different value on each side, write a list and read `values[a.image]`",
                );
            }
        }
        for variable in actuation.variables.iter().filter(|variable| variable.size == Some(1)) {
            told(
                variable.span,
                &format!("`{}` is a list of one value", variable.name),
                "a curve through one point is the same everywhere",
                "write more, as in `points[4]`, or leave the brackets out",
            );
        }
    }
    let never_changes = |state: &State, is_own: &dyn Fn(&Expr) -> bool| {
        let (next, name) = (&state.next, &state.name);
        let label = if is_own(next) {
            "its next value is its present one"
        } else {
            match (&state.from.kind, truth(next, is_own, &state.from)) {
                (ExprKind::Bool(true), Some(true)) => "it begins as true, and stays so",
                (ExprKind::Bool(false), Some(false)) => "it begins as false, and stays so",
                _ => return None,
            }
        };
        let told = Diagnostic::new(Code::POINTLESS, next.span, format!("the state `{name}` never changes"))
            .label(label)
            .help("let `next` depend on the time, on a sensor or on its own value: `next min(n + 1, 9)`; for a constant, use `let`");
        Some(told)
    };
    let mut constant = Vec::new();
    for state in rules.states.values().map(|state| &state.state) {
        let is_own = |e: &Expr| matches!(&e.kind, ExprKind::Sensor(name, _) if *name == state.name);
        constant.extend(never_changes(state, &is_own));
    }
    for actuation in rules.actuations.values() {
        for (place, state) in actuation.states.iter().enumerate() {
            let is_own =
                |e: &Expr| matches!(e.kind, ExprKind::Local(slot) if slot == actuation.first_state() + place);
            constant.extend(never_changes(state, &is_own));
        }
    }
    for (name, sensor) in &rules.sensors {
        let moves = |e: &Expr| matches!(e.kind, ExprKind::At(..) | ExprKind::Word(Word::Now));
        if !sensor.value.any(&mut |e| moves(e)) {
            told(
                sensor.value.span,
                &format!("the sensor `{name}` reads nothing that moves"),
                "the same in the whole motion",
                "read something `at now`, as in `core.rotation at now`",
            );
        }
        if sensor.ty.dimension() == Some(Dimension::ANGLE) && sensor.noise > MOST_NOISE {
            told(
                sensor.span,
                &format!("the readings of `{name}` scatter by {}", shown(sensor.noise, Dimension::ANGLE)),
                "no sensor of an angle is so bad",
                "write how far readings scatter, such as `noise 1 deg`",
            );
        }
        let shortest = rules.tasks.values().map(|task| task.model.duration).fold(f64::INFINITY, f64::min);
        if sensor.delay > LATE.min(shortest / 2.0) {
            told(
                sensor.span,
                &format!("`{name}` reads a value that is {} old", shown(sensor.delay, Dimension::TIME)),
                "much later than any sensor",
                "check the unit. The delay of a sensor is usually some milliseconds: `delay 20 ms`",
            );
        }
    }
    for scoped in places(known) {
        for expr in scoped.exprs {
            expr.any(&mut |e| {
                if let ExprKind::Call(Function::Bezier, points) = &e.kind
                    && let [Expr { kind: ExprKind::List(points), .. }] = points.as_slice()
                    && points.len() == 1
                {
                    told(
                        e.span,
                        "a Bezier curve of one point is the same everywhere",
                        "one control point",
                        "give it at least two points",
                    );
                }
                false
            });
        }
    }
    for name in &rules.observed {
        let Some(term) = rules.terms.get(name) else { continue };
        if known.numbers(&term.value).single().is_some() {
            told(
                term.span,
                &format!("`{name}` is observed, but has the same value for every design"),
                "a constant",
                "let it read the motion or the design, or do not observe it",
            );
        }
    }
    for novelty in rules.novelties.values() {
        for (name, feature) in &novelty.features {
            if known.numbers(&feature.value).single().is_some() {
                told(
                    feature.value.span,
                    &format!("the feature `{name}` has the same value for every design"),
                    "a constant",
                    "let it read the design or its motion: a constant cannot distinguish designs",
                );
            }
        }
    }
    for objective in rules.tasks.values().flat_map(|task| task.objectives()) {
        if is_in_large_unit(objective) {
            told(
                objective.value.span,
                &format!("in {}, the values of this objective are near zero", objective.unit),
                "robots of this size travel a few metres at most",
                "write `in cm`: temperatures of searches are on the scale of the objective, and results are printed in its unit",
            );
        }
    }
    findings.extend(constant);
}

/// Where a rule removes what it has attached itself.
fn removed_again(rule: &Rule) -> Option<Span> {
    let mut slot = rule.locals.len();
    let mut own = Vec::new();
    for effect in &rule.effects {
        match effect {
            Effect::Attach { .. } | Effect::Replace { .. } => {
                own.extend(matches!(effect, Effect::Attach { .. }).then_some(slot));
                slot += 1;
            }
            Effect::Remove(part) => {
                if let ExprKind::Local(slot) = part.kind
                    && own.contains(&slot)
                {
                    return Some(part.span);
                }
            }
            Effect::Repeat { lists, .. } => slot += lists.len(),
            Effect::Let(_) => slot += 1,
            _ => {}
        }
    }
    None
}

/// The ranges of one number that effects are repeated for.
fn repeated_once(effects: &[Effect]) -> Vec<Span> {
    let mut found = Vec::new();
    for effect in effects {
        let Effect::Repeat { over, effects, .. } = effect else { continue };
        for binder in over {
            if let ExprKind::Range(low, high) = &binder.over.kind
                && let (ExprKind::Number(low), ExprKind::Number(high)) = (&low.kind, &high.kind)
                && low == high
            {
                found.push(binder.over.span);
            }
        }
        found.extend(repeated_once(effects));
    }
    found
}

/// A rule that matches a part of one kind and puts the same kind in its place, with no other parameters.
fn replaced_by_its_like(rule: &Rule) -> Option<(Span, &str)> {
    // The slots that are filled by a part of one kind.
    let mut kinds: Vec<Option<&str>> = Vec::new();
    for matched in &rule.matches {
        match &matched.what {
            Matched::Part { kind, port, .. } => {
                kinds.push(if let Group::Kind(kind) = kind { Some(kind) } else { None });
                kinds.extend(port.then_some(None));
            }
            Matched::Port { .. } | Matched::Joint | Matched::Step => kinds.push(None),
        }
    }
    Effect::single(&rule.effects).find_map(|effect| {
        let Effect::Replace { part, with, .. } = effect else { return None };
        let (ExprKind::Local(slot), ExprKind::Kind(with_kind, params)) = (&part.kind, &with.kind) else {
            return None;
        };
        let own = (*kinds.get(*slot)?)?;
        (params.is_empty() && own == with_kind).then_some((with.span, own))
    })
}

/// Whether an objective is a length in a unit that is far too large for a robot.
fn is_in_large_unit(objective: &Objective) -> bool {
    let ExprKind::Convert(value, unit) = &objective.value.kind else { return false };
    value.ty.dimension() == Some(Dimension::LENGTH) && *unit >= LARGE
}

/// Whether what groups actuators is nothing but which image one is.
fn is_image(group: &Expr) -> bool {
    match &group.kind {
        ExprKind::Attribute(_, Attribute::Part(PartAttribute::Image)) => true,
        ExprKind::List(items) => !items.is_empty() && items.iter().all(is_image),
        _ => false,
    }
}

/// What a condition is whatever else it reads, while a state is as it begins.
fn truth(condition: &Expr, is_own: &dyn Fn(&Expr) -> bool, from: &Expr) -> Option<bool> {
    if is_own(condition) {
        return truth(from, &|_| false, from);
    }
    let of = |e: &Expr| truth(e, is_own, from);
    match &condition.kind {
        ExprKind::Bool(known) => Some(*known),
        ExprKind::Not(x) => Some(!of(x)?),
        ExprKind::Binary(a, operator @ (Operator::And | Operator::Or), b) => {
            let decided = *operator == Operator::Or;
            match (of(a), of(b)) {
                (Some(x), _) | (_, Some(x)) if x == decided => Some(decided),
                (Some(x), Some(_)) => Some(x),
                _ => None,
            }
        }
        _ => None,
    }
}
