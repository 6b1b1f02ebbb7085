//! Short motions of a few bodies, and what is odd in all of them.
//!
//! The bodies are the design that a search starts from and the ends of random walks, each with some random curves. They show what no text shows: that a
//! wheel does not reach the ground, that a spring is too soft for the weight on it, that an objective does not depend on what the robot does.

mod aims;
mod cells;
mod contact;
mod ending;
mod failures;
mod following;
mod immobile;
mod loads;
mod mirrored;
mod passive;
mod policies;
mod prices;
mod reversals;
mod scales;
mod variables;
mod waiting;

use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;

use grammar_lang::Compiled;
use grammar_lang::diagnostics::{Code, Diagnostic};
use grammar_lang::ir::{Expr, RuleSet, Task};
use grammar_lang::source::{FileId, SourceMap, Span};

use crate::derive::random::Stream;
use crate::derive::{Candidate, Derivation, failing_examples, walk};
use crate::design::PartId;
use crate::drive::{ControlLaw, Drive};
use crate::score::{Recording, check_designs, quantities};
use crate::search::{settings, solver};
use crate::simulate::{Case, Invalid, Motion, Settings, Stop, World};

/// How long a motion is at most, s.
const TIME: f64 = 2.0;
/// How many bodies move, and how many motions they make together: each by as many draws of its curves.
const BODIES: usize = 4;
const MOTIONS: usize = 8;
/// How much all motions of a grammar may take: elements times steps.
const EFFORT: f64 = 300_000.0;
/// How many operations the drives and the scores of a grammar may take together. What is not known then is not told.
const OPERATIONS: u64 = 50_000_000;

/// A body with its drive, and what came of its motions.
struct Trial<'r> {
    drive: Drive<'r>,
    motions: Vec<Moved<'r>>,
}

/// A motion with the values of its curves.
struct Moved<'r> {
    parameters: Vec<f64>,
    law: ControlLaw<'r>,
    motion: Result<Motion, Invalid>,
}

/// The text that is checked.
#[derive(Clone, Copy)]
struct Text {
    entry: FileId,
    /// Whether the grammar is a variant of what the text declares first, which may leave something of the text without effect.
    is_varied: bool,
}

/// The motions of one task.
struct Trials<'r> {
    /// The rules with tasks of their whole time.
    whole: &'r RuleSet,
    text: Text,
    /// How many operations may still be taken.
    operations: Arc<AtomicU64>,
    trials: Vec<Trial<'r>>,
}

/// All that is found in a grammar once its initial design and its examples are built, driven and scored, and once some of its bodies
/// have moved for a short time.
#[must_use]
pub fn check_motions(compiled: &Compiled, entry: FileId, sources: &SourceMap) -> Vec<Diagnostic> {
    let mut found = check_designs(compiled, entry, sources);
    if let Some(rules) = compiled.ruleset.as_ref().filter(|_| !found.iter().any(Diagnostic::is_error)) {
        // What cannot grow is told already, with the reason.
        if compiled.diagnostics.iter().chain(&found).all(|known| known.code != Code::NO_ROOM) {
            found.extend(failing_examples(rules, entry));
            let walks = walk(rules);
            found.extend(walks.found);
            // What else is odd may make motions odd, too: it is told alone.
            if compiled.told(found.iter().cloned()).is_empty() {
                let text = Text { entry, is_varied: compiled.is_varied() };
                found.extend(check_short(rules, text, walks.ends));
            }
        }
    }
    found
}

/// What is odd in all motions of a task.
fn check_short(rules: &RuleSet, text: Text, ends: Vec<Derivation>) -> Vec<Diagnostic> {
    if rules.lattice.is_some() {
        return Vec::new();
    }
    let mut short = rules.clone();
    for task in short.tasks.values_mut() {
        task.model.duration = task.model.duration.min(TIME);
    }
    let Ok(first) = Derivation::start(rules, rules.from.as_deref()) else { return Vec::new() };
    let mut bodies = vec![first];
    if rules.search.bodies.is_some() {
        bodies.extend(ends);
    }
    let mut found: Vec<Diagnostic> = Vec::new();
    let mut left = (EFFORT, Arc::new(AtomicU64::new(OPERATIONS)));
    for task in short.tasks.keys() {
        let Some(trials) = Trials::of((rules, &short), text, task, &bodies, &mut left) else { continue };
        for told in trials.odd() {
            if found.iter().all(|known| known.span() != told.span()) {
                found.push(told);
            }
        }
    }
    found
}

impl<'r> Trials<'r> {
    /// The motions of a task; none if they take more than is left.
    fn of(
        (whole, rules): (&'r RuleSet, &'r RuleSet),
        text: Text,
        task: &str,
        bodies: &[Derivation],
        (effort, operations): &mut (f64, Arc<AtomicU64>),
    ) -> Option<Self> {
        let task = rules.tasks.get(task)?;
        let mut settings = settings(&task.model);
        settings.pace_limit = None;
        let draws = (MOTIONS / bodies.len().clamp(1, BODIES)) as u64;
        let mut trials = Vec::new();
        let mut known = BTreeSet::new();
        for derivation in bodies {
            if !known.insert(derivation.design.canonical_hash()) {
                continue;
            }
            let candidate = Candidate::new(rules, Arc::new(derivation.clone()));
            let steps = settings.duration / settings.step * draws as f64;
            let takes = candidate.body.assembly.elements.len() as f64 * steps;
            if candidate.body.actuators.is_empty() || takes > *effort || trials.len() == BODIES {
                continue;
            }
            *effort -= takes;
            trials.push(Trial::of(&candidate, task, operations, &settings, draws)?);
        }
        (!trials.is_empty()).then_some(Self { whole, text, operations: Arc::clone(operations), trials })
    }

    fn odd(&self) -> Vec<Diagnostic> {
        if let Some(told) = failures::check(self) {
            return vec![told];
        }
        if waiting::check(self) {
            return Vec::new();
        }
        let mut found: Vec<Diagnostic> = reversals::check(self).into_iter().collect();
        found.extend(following::check(self));
        found.extend(ending::check(self));
        found.extend(contact::check(self));
        found.extend(passive::check(self));
        found.extend(cells::check(self));
        found.extend(loads::check(self));
        found.extend(mirrored::check(self));
        found.extend(mirrored::against_each_other(self));
        found.extend(mirrored::steers_alike(self));
        found.extend(variables::check(self));
        if found.is_empty() {
            found.extend(aims::check(self));
        }
        if found.is_empty() {
            found.extend(scales::check(self));
            found.extend(prices::check(self));
            found.extend(immobile::check(self));
            found.extend(policies::check(self));
        }
        found
    }

    /// Each motion that succeeded, with its body.
    fn motions(&self) -> impl Iterator<Item = (&Trial<'r>, &Moved<'r>, &Motion)> {
        self.trials.iter().flat_map(|trial| {
            trial.motions.iter().filter_map(move |moved| Some((trial, moved, moved.motion.as_ref().ok()?)))
        })
    }

    /// The scores of all motions, as far as they have a value.
    fn recordings(&self) -> impl Iterator<Item = Recording<'_>> {
        self.motions()
            .map(|(trial, moved, motion)| Recording::nominal(&trial.drive, &moved.parameters, motion))
    }

    /// What an expression of the motion comes to in all motions, as far as it has a value.
    fn values(&self, wanted: &Expr) -> Vec<f64> {
        self.recordings().filter_map(|recording| quantities(recording, &[wanted]).ok()?.pop()).collect()
    }

    /// What drives a body over the whole time of its task, not only in its first seconds.
    fn whole_drive(&self, trial: &Trial<'_>) -> Option<Drive<'_>> {
        let candidate = Candidate::new(self.whole, Arc::clone(&trial.drive.candidate().derivation));
        let drive = Drive::new(&candidate, self.whole.tasks.get(&trial.drive.task().name)?).ok()?;
        Some(drive.tried_with(&self.operations))
    }
}

impl<'r> Trial<'r> {
    fn of(
        candidate: &Candidate<'r>,
        task: &'r Task,
        operations: &Arc<AtomicU64>,
        settings: &Settings,
        draws: u64,
    ) -> Option<Self> {
        let drive = Drive::new(candidate, task).ok()?.tried_with(operations);
        let mut simulation =
            solver(candidate.rules).model().prepare(&candidate.body.assembly, settings).ok()?;
        // Without anything to draw, all motions of a body are the same.
        let draws = if drive.is_fixed() { 1 } else { draws };
        let drawn = (0..draws).map(|draw| drive.draw(&mut Stream::named(draw, "trials")));
        let laws: Vec<(Vec<f64>, ControlLaw<'r>)> = drawn
            .map(|drawn| Some((drawn.clone(), drive.control_law(&drawn).ok()?)))
            .collect::<Option<_>>()?;
        let cases: Vec<Case<'_>> = laws.iter().map(|(_, law)| law.case(&World::NOMINAL)).collect();
        let motions = simulation.run_cases(Stop::NEVER, &cases)?;
        drop(cases);
        let moved = laws.into_iter().zip(motions).map(|((parameters, law), motion)| Moved {
            parameters,
            law,
            motion,
        });
        Some(Self { motions: moved.collect(), drive })
    }

    /// The kind of the part that an element belongs to, with its place in the text.
    fn kind_of(&self, element: usize) -> Option<(&str, Span)> {
        self.kind(*self.drive.candidate().body.parts_of_elements.get(element)?)
    }

    /// The kind of a part, with its place in the text.
    fn kind(&self, id: PartId) -> Option<(&str, Span)> {
        let candidate = self.drive.candidate();
        let kind = candidate.design().parts.get(&id)?.kind.as_str();
        let rules = candidate.rules;
        let block = rules.parts.get(kind).map(|block| block.span);
        Some((kind, block.or_else(|| rules.actuators.get(kind).map(|actuator| actuator.span))?))
    }
}

/// A warning about what all short motions have in common.
fn odd(span: Span, message: String) -> Diagnostic {
    Diagnostic::new(Code::SHORT_MOTIONS, span, message)
}
