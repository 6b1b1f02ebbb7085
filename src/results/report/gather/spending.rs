//! Where evaluations went: how much each body cost, and how good it came to be.

use std::collections::BTreeMap;

use grammar_lang::ir::Direction;

use super::{or_empty, table};
use crate::results::report::gather::spread::{mean, share};
use crate::results::report::moves::{Move, lineage};
use crate::results::report::read::{Group, Run};

/// Bodies by how good they came to be, as shares of the best: below each of these, from the last of them to the best, and
/// the best itself.
pub(crate) const STEPS: [f64; 4] = [0.1, 0.25, 0.5, 0.75];
/// How many classes that makes.
pub(crate) const CLASSES: usize = STEPS.len() + 2;

/// Where the evaluations of one run went.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Spending {
    /// Bodies that were simulated.
    pub(crate) bodies: u64,
    /// Evaluations of all of them.
    pub(crate) evaluations: u64,
    /// Those of the body that became the best.
    pub(crate) of_best: u64,
    /// Those that tuned the curves of a body further.
    pub(crate) further: u64,
    /// Those of bodies by [`STEPS`]; none where the best is not positive, or less is better: then there are no shares of it.
    pub(crate) classes: Option<[u64; CLASSES]>,
    /// Moves that were accepted, and those that tried something.
    pub(crate) accepted: (u64, u64),
    /// How many bodies lie between the initial design and the best one.
    pub(crate) generations: Option<u64>,
}

/// A body with all moves that tuned it.
#[derive(Clone, Copy, Debug, Default)]
struct Body {
    evaluations: u64,
    further: u64,
    /// Where more is better.
    fitness: Option<f64>,
}

/// The move that made the body of a move whose curves were tuned further.
fn made_at(roots: &BTreeMap<u64, u64>, made: &Move) -> u64 {
    let parent = made.parent.filter(|_| made.tuned > 0);
    parent.and_then(|parent| roots.get(&parent)).copied().unwrap_or(made.number)
}

/// Where the evaluations of a run went; none if it has made no evaluation.
pub(crate) fn spending(run: &Run, direction: Direction) -> Option<Spending> {
    let mut roots: BTreeMap<u64, u64> = BTreeMap::new();
    let mut bodies: BTreeMap<u64, Body> = BTreeMap::new();
    let (mut before, mut best): (u64, Option<&Move>) = (0, None);
    let fitness = |made: &Move| made.value.map(|value| direction.fitness(value));
    for made in &run.moves {
        let cost = made.evaluations.saturating_sub(before);
        before = made.evaluations;
        if made.did_nothing() {
            continue;
        }
        let root = made_at(&roots, made);
        roots.insert(made.number, root);
        let body = bodies.entry(root).or_default();
        body.evaluations += cost;
        body.further += if made.tuned > 0 { cost } else { 0 };
        let own = fitness(made);
        if own.is_some_and(|own| body.fitness.is_none_or(|known| own > known)) {
            body.fitness = own;
        }
        if own.is_some_and(|own| best.and_then(fitness).is_none_or(|known| own > known)) {
            best = Some(made);
        }
    }
    let evaluations: u64 = bodies.values().map(|body| body.evaluations).sum();
    if evaluations == 0 {
        return None;
    }
    let best_body = best.and_then(|best| roots.get(&best.number)).copied();
    let most = match best.and_then(fitness) {
        // A run without any value has spent everything on bodies without one.
        None => Some(f64::INFINITY).filter(|_| direction == Direction::Maximize),
        best => best.filter(|most| direction == Direction::Maximize && *most > 0.0),
    };
    let classes = most.map(|most| {
        let mut classes = [0; CLASSES];
        for (root, body) in &bodies {
            let reached = body.fitness.map_or(f64::NEG_INFINITY, |fitness| fitness / most);
            let class = match STEPS.iter().position(|step| reached < *step) {
                _ if Some(*root) == best_body => CLASSES - 1,
                Some(class) => class,
                None => CLASSES - 2,
            };
            classes[class] += body.evaluations;
        }
        classes
    });
    let tried = || run.moves.iter().filter(|made| made.number > 0 && !made.did_nothing());
    let line = best.and_then(|best| lineage(&run.moves, best));
    Some(Spending {
        bodies: bodies.values().filter(|body| body.evaluations > 0).count() as u64,
        evaluations,
        of_best: best_body.and_then(|root| bodies.get(&root)).map_or(0, |body| body.evaluations),
        further: bodies.values().map(|body| body.further).sum(),
        classes,
        accepted: (tried().filter(|made| made.accepted).count() as u64, tried().count() as u64),
        generations: line.map(|line| line.iter().filter(|made| made.rule.is_some()).count() as u64),
    })
}

/// The mean over the runs of a group of the share of evaluations in each class; none where no run has any.
pub(crate) fn shares(all: &[Spending]) -> Option<[f64; CLASSES]> {
    let known: Vec<(&[u64; CLASSES], u64)> =
        all.iter().filter_map(|one| Some((one.classes.as_ref()?, one.evaluations))).collect();
    let mut shares = [0.0; CLASSES];
    for (place, slot) in shares.iter_mut().enumerate() {
        *slot = mean(known.iter().filter_map(|(classes, of)| share(classes[place], *of)))?;
    }
    Some(shares)
}

/// `spending.csv`.
pub(crate) fn csv(groups: &[Group]) -> String {
    let columns = [
        "group",
        "seed",
        "bodies",
        "evaluations",
        "of_best",
        "further",
        "below_a_tenth",
        "accepted",
        "tried",
        "generations",
    ];
    let rows = groups.iter().flat_map(|group| {
        group.runs.iter().filter_map(|run| {
            let one = spending(run, group.direction)?;
            Some([
                group.name.clone(),
                run.asked.seed.to_string(),
                one.bodies.to_string(),
                one.evaluations.to_string(),
                one.of_best.to_string(),
                one.further.to_string(),
                or_empty(one.classes.map(|classes| classes[0])),
                one.accepted.0.to_string(),
                one.accepted.1.to_string(),
                or_empty(one.generations),
            ])
        })
    });
    table(columns, rows)
}

#[cfg(test)]
mod tests {
    use super::super::tests::two;
    use super::*;

    #[test]
    fn evaluations_belong_to_the_body_that_they_simulate() {
        let group = two();
        let one = spending(&group.runs[0], Direction::Maximize).unwrap();
        // The initial design takes 1, then 1, 1, 2 without a value, a move that does nothing, and 3 for the best.
        assert_eq!((one.bodies, one.evaluations, one.of_best, one.further), (5, 8, 3, 0));
        // 0 and nothing are below a tenth of 8, 3 is below a half, 4 below three quarters.
        assert_eq!(one.classes, Some([3, 0, 1, 1, 0, 3]));
        assert_eq!(one.accepted, (3, 4));
        // Of the moves that are taken for accepted, 1, 2 and 5 lie between.
        assert_eq!(one.generations, Some(3));
        let all: Vec<Spending> = group.runs.iter().filter_map(|run| spending(run, group.direction)).collect();
        let shares = shares(&all).unwrap();
        assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{shares:?}");
        assert_eq!(spending(&group.runs[0], Direction::Minimize).unwrap().classes, None);
    }

    #[test]
    fn what_is_tuned_further_is_the_same_body() {
        let mut group = two();
        let moves = &mut group.runs[0].moves;
        // The last move tunes the body of move 2 further.
        let last = moves.last_mut().unwrap();
        (last.rule, last.tuned, last.parent) = (None, 1, Some(2));
        let one = spending(&group.runs[0], Direction::Maximize).unwrap();
        assert_eq!((one.bodies, one.of_best, one.further), (4, 4, 3));
        assert_eq!(one.classes, Some([3, 0, 0, 1, 0, 4]));
        assert_eq!(one.generations, Some(2));
    }
}
