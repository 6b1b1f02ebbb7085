//! The best designs of all, so many of them. A move takes one of them, the best of a few that are drawn, and changes it
//! by a rule, or tunes its curves further from where they stand. Several moves may go on side by side: each takes
//! one of the designs that were kept before the first of them.

use std::sync::Arc;

use grammar_lang::ir::{Direction, RuleSet, Schedule, Selection, Task};

use super::super::Failure;
use super::super::aim::Aim;
use super::super::schedule::{Course, Plan, Stand};
use super::super::state::{Best, Designs, Incumbent, Member, Members, Tuned};
use super::Bodies;
use crate::derive::random::Stream;
use crate::derive::{Candidate, Derivation};
use crate::drive::Drive;

/// What designs share of which one is kept: the body. Where no curves are tuned also all that a drive can read of how it came to
/// be, which part is the original for one: tuned curves make up for that.
fn identity(rules: &RuleSet, derivation: &Derivation) -> String {
    let varies = |task: &Task| {
        let mut actuations = task.actuated.values().filter_map(|name| rules.actuations.get(name));
        actuations.any(|actuation| !actuation.variables.is_empty() || !actuation.actions.is_empty())
    };
    match rules.search.curves.is_some() && rules.tasks.values().any(varies) {
        true => derivation.design.canonical_hash(),
        false => derivation.design.driven_hash(),
    }
}

/// How a move chooses the design that it begins with.
pub(super) struct Tournament<'a> {
    /// So many are drawn.
    pub(super) size: usize,
    /// The share of moves that tune curves further.
    pub(super) further: f64,
    /// What the move is after, where a front is searched for.
    pub(super) aim: Option<&'a Aim>,
}

/// What a move begins with.
pub(super) struct Parent {
    pub(super) place: Incumbent<Arc<Derivation>>,
    /// Where the search for its curves stands, if the move is to tune them further.
    pub(super) further: Option<Tuned>,
}

impl Members<Arc<Derivation>> {
    /// None yet.
    pub(super) fn none(direction: Direction) -> Self {
        Self { kept: Vec::new(), course: Course::new(direction, None) }
    }
}

impl Bodies<'_> {
    /// Notes the end of an iteration, and begins anew with the initial design if the search says so. The best of the run
    /// is kept, of course.
    pub(super) fn complete_members(&mut self, schedule: &Schedule) -> Result<(), Failure> {
        let (rules, direction) = (self.rules, self.rules.objective.direction);
        let Some(population) = rules.search.population() else { return Ok(()) };
        let first = Arc::clone(&self.state.first.derivation);
        let around = self.around();
        let Some(Designs::Population(members)) = &mut self.state.designs else { return Ok(()) };
        let fitness = |member: &Arc<Member<_>>| direction.fitness(member.best.value);
        let best = members.kept.iter().max_by(|a, b| fitness(a).total_cmp(&fitness(b)));
        members.course.complete(best.map(|member| member.best.value));
        let (course, stand) = (&members.course, Stand::Bodies);
        let plan = Plan { rules, derivation: &first, schedule, course, stand, around };
        if plan.restarts(population.restart.as_ref())? {
            *members = Members::none(direction);
            self.state.earlier.clear();
        }
        Ok(())
    }

    /// Notes what is kept before the move that comes now.
    pub(super) fn note_members(&mut self) {
        let Some(selection) = self.rules.search.selection() else { return };
        let members = self.state.members().to_vec();
        self.state.earlier.push_back(members);
        while self.state.earlier.len() > selection.side_by_side() {
            self.state.earlier.pop_front();
        }
    }

    /// What was kept before the first of the moves that go on side by side with the present one.
    pub(super) fn parents(&self) -> &[Arc<Member<Arc<Derivation>>>] {
        self.state.earlier.front().map_or(&[], Vec::as_slice)
    }

    /// One of the designs that were kept: the best of as many as the tournament has, each drawn with the same chance. With an aim, the best
    /// by that.
    pub(super) fn winner(&self, tournament: &Tournament<'_>, random: &mut Stream) -> Option<Parent> {
        let members = self.parents();
        if members.is_empty() {
            return None;
        }
        let drawn: Vec<usize> = (0..tournament.size).map(|_| random.below(members.len())).collect();
        let wants_further = random.unit() < tournament.further;
        let value = |best: &Best| tournament.aim.map_or(best.value, |aim| aim.value(&best.each()));
        let fitness = |place: usize| self.fitness(Some(value(&members[place].best)));
        // Of equals the first drawn.
        let winner = drawn.into_iter().reduce(|a, b| if fitness(b) > fitness(a) { b } else { a })?;
        let Member { best, tuned } = &**members.get(winner)?;
        let Best { derivation, tasks, value, found_at, .. } = best.clone();
        let further = (wants_further && self.is_tunable(&derivation)).then(|| tuned.clone());
        Some(Parent {
            place: Incumbent { number: found_at, derivation, value: Some(value), tunes: tasks },
            further,
        })
    }

    /// Whether a body has curves that can be tuned.
    fn is_tunable(&self, derivation: &Arc<Derivation>) -> bool {
        let candidate = Candidate::new(self.rules, Arc::clone(derivation));
        let is_free = |task| Drive::new(&candidate, task).is_ok_and(|drive| !drive.is_fixed());
        self.rules.search.curves.is_some() && self.rules.tasks.values().any(is_free)
    }

    /// Whether a move could begin with this body.
    pub(super) fn is_member(&self, derivation: &Derivation) -> bool {
        let members = self.parents();
        !members.is_empty() && {
            let own = identity(self.rules, derivation);
            members.iter().any(|member| identity(self.rules, &member.best.derivation) == own)
        }
    }

    /// How a move chooses among the bodies of a population or a front, as things stand.
    pub(super) fn tournament<'a>(&self, aim: Option<&'a Aim>) -> Result<Option<Tournament<'a>>, Failure> {
        let Some((selection, plan)) = self.selection(self.state.spent) else { return Ok(None) };
        let (size, further) = plan.choice(selection)?;
        Ok(Some(Tournament { size, further, aim }))
    }

    /// How many bodies a population or a front keeps when so many evaluations are spent.
    pub(super) fn size(&self, spent: u64) -> Result<usize, Failure> {
        let Some((selection, plan)) = self.selection(spent) else { return Ok(usize::MAX) };
        Ok(plan.size(selection, self.rules.search.front().is_some())?)
    }

    fn selection(&self, spent: u64) -> Option<(&Selection, Plan<'_>)> {
        let schedule = &self.rules.search.bodies.as_ref()?.schedule;
        Some((self.rules.search.selection()?, self.plan_at(schedule, spent)))
    }

    /// The value that a design must exceed to come into the population, where more is better.
    pub(super) fn least_kept(&self, size: usize) -> f64 {
        let members = self.state.members();
        if members.len() < size {
            return f64::NEG_INFINITY;
        }
        members.iter().map(|member| self.fitness(Some(member.best.value))).fold(f64::INFINITY, f64::min)
    }

    /// Keeps a design if it is among the best; whether it is, or is better than it was. `is_further` says that it is one
    /// of those that are kept, with its curves tuned further.
    pub(super) fn keep_member(
        &mut self,
        place: Incumbent<Arc<Derivation>>,
        tuned: Tuned,
        is_further: bool,
    ) -> Result<bool, Failure> {
        let (rules, direction) = (self.rules, self.rules.objective.direction);
        let (Some(_), Some(value)) = (rules.search.population(), place.value) else { return Ok(false) };
        self.shrink()?;
        let size = self.size(self.state.spent)?;
        let least = self.least_kept(size);
        let Some(Designs::Population(Members { kept: members, .. })) = &mut self.state.designs else {
            return Ok(false);
        };
        let Incumbent { number, derivation, tunes, .. } = place;
        let own = identity(rules, &derivation);
        let best = Best { derivation, tasks: tunes, value, beside: Vec::new(), found_at: number };
        let fitness = |member: &Member<_>| direction.fitness(member.best.value);
        if let Some(same) = members.iter_mut().find(|member| identity(rules, &member.best.derivation) == own)
        {
            let is_better = direction.fitness(value) > fitness(same);
            let same = Arc::make_mut(same);
            if is_better {
                same.best = best;
            }
            // What was learnt of its curves is of use, even if nothing better was found.
            if is_better || is_further {
                same.tuned = tuned;
            }
            return Ok(is_better);
        }
        if members.len() < size {
            members.push(Arc::new(Member { best, tuned }));
            return Ok(true);
        }
        let is_better = direction.fitness(value) > least;
        // Of equals the last that came in leaves.
        if is_better && let Some(worst) = members.iter().rposition(|member| fitness(member) <= least) {
            members[worst] = Arc::new(Member { best, tuned });
        }
        Ok(is_better)
    }

    /// The worst leave where fewer are kept than before.
    fn shrink(&mut self) -> Result<(), Failure> {
        let (size, direction) = (self.size(self.state.spent)?, self.rules.objective.direction);
        let Some(Designs::Population(Members { kept, .. })) = &mut self.state.designs else { return Ok(()) };
        while kept.len() > size {
            let fitness = |member: &Member<_>| direction.fitness(member.best.value);
            // Of equals the last that came in leaves.
            let worst = kept.iter().enumerate().rev().min_by(|a, b| fitness(a.1).total_cmp(&fitness(b.1)));
            let Some((worst, _)) = worst else { break };
            kept.remove(worst);
        }
        Ok(())
    }
}
