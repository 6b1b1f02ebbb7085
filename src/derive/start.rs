//! Whether the initial design fulfils the requirements.

use grammar_lang::Compiled;
use grammar_lang::bounds::Begun;
use grammar_lang::diagnostics::{Code, Diagnostic};
use grammar_lang::eval::{EvalError, PartId, Value, evaluate};
use grammar_lang::ir::{Method, Param, Placed, RuleSet, Symmetry};

use grammar_lang::names::{Change, with_changes};
use grammar_lang::source::{FileId, SourceMap};
use grammar_lang::units::{Dimension, shown};

use super::apply::{Blocked, attachment};
use super::broken::compared;
use super::{Derivation, DesignScope, run_example};
use crate::design::CORE;
use crate::design::{Design, MOST_BALLS, Refusal, balls};

/// The initial design, and what of it cannot be placed.
pub(super) fn begin(rules: &RuleSet) -> (Derivation, Option<EvalError>) {
    let mut derivation = Derivation { design: Design::default(), steps: Vec::new(), next: 1 };
    if let Some(error) = fill(rules, &mut derivation) {
        return (derivation, Some(error));
    }
    for placed in &rules.begin {
        if let Err(error) = place(rules, &mut derivation, placed) {
            return (derivation, Some(error));
        }
    }
    let unkept = derivation.carry_out_always(rules).err().map(|blocked| match blocked {
        Blocked::NoValue(error) => error,
        blocked => {
            let span = rules.always.first().map_or_else(Default::default, |rule| rule.span);
            EvalError { span, reason: blocked.sentence(rules) }
        }
    });
    (derivation, unkept)
}

/// Fills what a lattice begins with; gives what of it cannot be filled.
fn fill(rules: &RuleSet, derivation: &mut Derivation) -> Option<EvalError> {
    let lattice = rules.lattice.as_ref()?;
    let before = derivation.clone();
    match before.carry_out(derivation, rules, &lattice.begin, &[], 0) {
        Ok(_) if !derivation.design.parts.is_empty() => None,
        Ok(_) => {
            let reason = Blocked::Refused(Refusal::Empty).sentence(rules);
            Some(EvalError { span: lattice.span, reason })
        }
        Err(Blocked::NoValue(error)) => Some(error),
        Err(blocked) => Some(EvalError { span: lattice.span, reason: blocked.sentence(rules) }),
    }
}

fn place(rules: &RuleSet, derivation: &mut Derivation, placed: &Placed) -> Result<(), EvalError> {
    let refused =
        |refusal| EvalError { span: placed.span, reason: Blocked::Refused(refusal).sentence(rules) };
    let before = derivation.clone();
    let scope = DesignScope::new(rules, &before);
    let id = match &placed.on {
        None => {
            let Value::Kind(kind) = evaluate(&placed.what, &scope, &mut Vec::new())? else { return Ok(()) };
            derivation.design = Design::core(rules, &kind.name, &kind.params).map_err(refused)?;
            CORE
        }
        Some(on) => {
            let attachment = attachment(&placed.what, on, &scope, &mut Vec::new())?;
            derivation.design.attach(rules, &attachment, 0).map_err(refused)?
        }
    };
    derivation.design.placed.insert(placed.name.clone(), id);
    Ok(())
}

/// What helps where a part that overlaps another begins with its joint elsewhere than it is attached.
fn bent(start: &Derivation, rules: &RuleSet, broken: usize) -> Option<String> {
    let (a, b) = start.overlap(rules, broken)?;
    [a, b].into_iter().find_map(|id| start.design.parts.get(&id)?.begins_bent())
}

/// What `begin` calls a part, or the part whose image it is.
fn called(start: &Derivation, id: PartId) -> String {
    let design = &start.design;
    let name = |id: PartId| design.placed.iter().find(|(_, placed)| **placed == id).map(|(name, _)| name);
    let original = design.parts.get(&id).and_then(|part| part.image_of);
    match (name(id), original.and_then(name)) {
        (Some(name), _) => name.clone(),
        (None, Some(name)) => format!("{name}.twin"),
        (None, None) => design.parts.get(&id).map_or_else(String::new, |part| part.kind.clone()),
    }
}

/// What is found in a grammar once its initial design is built: a requirement that it breaks, or
/// what follows from the images that the symmetry makes of it.
#[must_use]
pub fn check_begun(compiled: &Compiled, entry: FileId, sources: &SourceMap) -> Vec<Diagnostic> {
    let Some(rules) = &compiled.ruleset else { return Vec::new() };
    let begun = begin(rules).0;
    // Before anything makes so many balls.
    if let Some(told) = too_fine(rules, &begun.design) {
        return vec![told];
    }
    if let Some(broken) = check_start(rules) {
        return vec![with_changes(broken, &compiled.changes, sources)];
    }
    let mut found = super::refused::check(rules, &begun);
    let overwritten = |design: &Design| {
        let mut lost = overwritten(rules, design);
        lost.extend(overwritten_in_variants(rules, design, &compiled.changes));
        lost
    };
    let lost = overwritten(&begun.design);
    let told = !lost.is_empty();
    found.extend(lost);
    if rules.lattice.is_none() && begun.design.parts.len() > rules.begin.len() {
        let mut counts = Begun::new();
        for part in begun.design.parts.values() {
            *counts.entry(part.kind.clone()).or_default() += 1;
        }
        found.extend(compiled.found_from(&counts, entry, sources));
    }
    // A search could not even begin.
    let from = rules.from.as_ref().and_then(|name| Some((name, rules.examples.get(name)?)));
    match from.map(|(name, example)| (name, run_example(rules, name, example))) {
        Some((name, Err(fails))) => found.push(fails.help(format!("the search starts from `{name}`"))),
        Some((_, Ok(start))) => {
            if let Some(told) = too_fine(rules, &start.design) {
                return vec![told];
            }
            found.extend(super::divisors::check(rules, &start));
            if !told {
                found.extend(overwritten(&start.design));
            }
        }
        None => found.extend(super::divisors::check(rules, &begun)),
    }
    found
}

/// That a filling makes more balls of a design than can be worked with.
fn too_fine(rules: &RuleSet, design: &Design) -> Option<Diagnostic> {
    let Method::Balls(Some(filling)) = rules.method() else { return None };
    let balls = balls(design, &filling);
    let place = rules.begin.first().map(|placed| placed.span)?;
    (!balls.is_finite() || balls > MOST_BALLS).then(|| {
        let enough = filling.spacing * libm::cbrt(balls / MOST_BALLS);
        let told =
            Diagnostic::new(Code::MODEL_MISFIT, place, "the filling of this design has too many balls")
                .label(format!("about {balls:.0} balls; at most {MOST_BALLS} can be simulated"));
        told.help(if enough.is_finite() {
            format!("give the filling a `spacing` of at least {}", shown(enough, Dimension::LENGTH))
        } else {
            "give the filling a larger `spacing`".to_owned()
        })
    })
}

/// Values from outside that say nothing: in the design that a search begins with, a rule has set the parameter to another one.
#[must_use]
pub fn overwritten(rules: &RuleSet, design: &Design) -> Vec<Diagnostic> {
    let given = design.values.keys().filter_map(|name| Some((name, rules.params.get(name)?)));
    let error = |(name, param): (&String, &Param)| {
        Diagnostic::new(
            Code::NO_EFFECT,
            param.span,
            format!("the value of `{name}` that `-p` gives is not that of the first design"),
        )
        .label("there, a rule has set another value")
        .help("vary what this rule reads, begin with another design, or leave `-p` out")
    };
    given.filter(|(_, param)| param.given).map(error).collect()
}

/// The same of values that variants set.
fn overwritten_in_variants(rules: &RuleSet, design: &Design, changes: &[Change]) -> Vec<Diagnostic> {
    let is_lost = |name: &str| {
        design.values.contains_key(name) && rules.params.get(name).is_some_and(|param| !param.given)
    };
    let error = |change: &Change| {
        let (name, (place, variant)) = (change.sets().filter(|name| is_lost(name))?, change.source());
        let message = format!(
            "the value of `{name}` that the variant `{variant}` sets is not that of the first design"
        );
        Some(
            Diagnostic::new(Code::NO_EFFECT, place, message)
                .label("there, a rule has set another value")
                .help("change what this rule reads, or the rule, or leave this line out"),
        )
    };
    // Of several variants, one upon the other, the last one counts.
    let last =
        |(place, change): (usize, &Change)| changes[place + 1..].iter().all(|c| c.sets() != change.sets());
    changes.iter().enumerate().filter(|one| last(*one)).filter_map(|(_, change)| error(change)).collect()
}

/// Reports the requirement that the initial design breaks, if it does.
#[must_use]
pub fn check_start(rules: &RuleSet) -> Option<Diagnostic> {
    let (start, unplaced) = begin(rules);
    let is_lost = |reason: &str| reason.starts_with("the symmetry would be lost");
    if let Some(error) = unplaced {
        return Some(
            Diagnostic::new(Code::START_BREAKS, error.span, "the initial design cannot be built")
                .help(match error.reason.as_str() {
                    reason if reason.contains("has no port") => {
                        "the symmetry must map each port to a port: declare one at that place, or choose another symmetry (the mirror plane `xy` separates left from right)"
                    }
                    reason if reason.contains("is taken") => {
                        "a part is attached there already, perhaps an image under the symmetry: name another port"
                    }
                    reason if is_lost(reason) && matches!(rules.symmetry, Symmetry::Mirror(_)) => {
                        "the core and its ports must be the same in that mirror, and what is attached must \
                         have an image there: mirror another plane (`xy` is forward and up, between left and right)"
                    }
                    reason if is_lost(reason) => {
                        "the core must be its own image: a box is one under `radial 2` and, if square, \
                         `radial 4`, a disk under any symmetry, if its ports fit; an actuator on the axis must be round, and twist, spin or slide along it"
                    }
                    "one step can make at most 256 parts, including images" => {
                        "`begin` counts as one step: place fewer parts, and let rules add the rest"
                    }
                    reason if reason.contains("turned out of the plane") => {
                        "turn it by 0 deg or 180 deg, or mirror another plane (`xy` is forward and up); to bend across the plane, \
                         give it another axis: `bender(direction = 90 deg)`, or `joint = bend about y`"
                    }
                    _ => "every design starts from `begin`",
                })
                .label(error.reason),
        );
    }
    match start.broken(rules) {
        Ok(None) => None,
        Ok(Some(i)) => {
            let requirement = rules.requirements.get(i)?;
            let reason =
                requirement.because.as_ref().map_or(String::new(), |b| format!(" (because \"{b}\")"));
            let mut error = Diagnostic::new(
                Code::START_BREAKS,
                requirement.condition.span,
                format!("the initial design breaks `{}`{reason}", requirement.name),
            )
            .label(match (compared(rules, &start, &requirement.condition), start.overlap(rules, i)) {
                (Some((is, must)), _) => {
                    format!("does not hold at the start: it is {is}, and must be {must}")
                }
                (None, Some((a, b))) => {
                    format!(
                        "does not hold at the start: `{}` and `{}` overlap",
                        called(&start, a),
                        called(&start, b)
                    )
                }
                (None, None) => "does not hold at the start".to_owned(),
            })
            .help(bent(&start, rules, i).unwrap_or_else(|| {
                "every design starts from `begin`: relax the requirement, or begin with another design"
                    .to_owned()
            }));
            if let Some(placed) = rules.begin.first() {
                error = error.also(placed.span, "the initial design");
            }
            Some(error)
        }
        Err(error) => Some(
            Diagnostic::new(Code::NO_VALUE, error.span, "this has no value for the initial design")
                .label(error.reason)
                .help(
                    "a search begins with this design: write the condition so that it has a value there, too",
                ),
        ),
    }
}
