//! The designs of runs that no other is better than in every objective; what one objective costs in another.

use std::path::PathBuf;

use grammar_lang::ir::{Direction, Objective, objective_name};

use super::{or_empty, table};
use crate::results::report::moves::Move;
use crate::results::report::read::{Group, Run};
use crate::results::saved::SavedDesign;
use crate::search::hypervolume;

/// An objective, for people.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Wanted {
    pub(crate) name: String,
    pub(crate) unit: String,
    pub(crate) direction: Direction,
}

/// A body that has a value in every objective.
#[derive(Clone, Debug)]
pub(crate) struct Valued<'r> {
    pub(crate) made: &'r Move,
    /// Its values, in the order of the objectives.
    pub(crate) each: Vec<f64>,
}

/// What a run has found, by several objectives.
#[derive(Clone, Debug)]
pub(crate) struct Front<'r> {
    pub(crate) run: &'r Run,
    /// Every body that has values.
    pub(crate) tried: Vec<Valued<'r>>,
    /// Those that no other is better than, the best by the first objective first.
    pub(crate) best: Vec<Valued<'r>>,
}

/// The objectives of a group; none where it has only one.
pub(crate) fn wanted(group: &Group) -> Option<Vec<Wanted>> {
    let (rules, _) = &**group.rules.as_ref().ok()?;
    if rules.beside().is_empty() {
        return None;
    }
    let one = |objective: &Objective| Wanted {
        name: objective_name(rules, objective),
        unit: objective.unit.clone(),
        direction: objective.direction,
    };
    Some(rules.objectives().map(one).collect())
}

/// What a run has found.
pub(crate) fn front<'r>(run: &'r Run, wanted: &[Wanted]) -> Front<'r> {
    let valued = |made: &'r Move| {
        let each: Vec<f64> = made.value.into_iter().chain(made.beside.iter().copied()).collect();
        (each.len() == wanted.len()).then_some(Valued { made, each })
    };
    let tried: Vec<Valued<'r>> = run.moves.iter().filter_map(valued).collect();
    let points: Vec<Vec<f64>> = tried.iter().map(|one| point(one, wanted)).collect();
    let covers = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| a >= b);
    // Of two that are the same the first stays.
    let is_best = |place: &usize| {
        let own = &points[*place];
        !points.iter().enumerate().any(|(other, point)| {
            other != *place && covers(point, own) && (!covers(own, point) || other < *place)
        })
    };
    let mut best: Vec<usize> = (0..points.len()).filter(is_best).collect();
    best.sort_by(|a, b| points[*b][0].total_cmp(&points[*a][0]));
    let best = best.into_iter().map(|place| tried[place].clone()).collect();
    Front { run, tried, best }
}

/// The values of a body on scales where more is better.
fn point(one: &Valued<'_>, wanted: &[Wanted]) -> Vec<f64> {
    wanted.iter().zip(&one.each).map(|(wanted, value)| wanted.direction.fitness(*value)).collect()
}

impl Valued<'_> {
    /// The file of the saved design, if it is on the front that the run has kept, and says the same.
    pub(crate) fn file(&self, run: &Run) -> Option<PathBuf> {
        let file = run.path.join("front").join(format!("{}.design.json", self.made.number));
        let design = SavedDesign::read_own(&file).ok()?;
        let own: Vec<f64> = [design.value].into_iter().chain(design.beside.iter().map(|b| b.value)).collect();
        (design.found_at as u64 == self.made.number && own == self.each).then_some(file)
    }
}

/// What groups want, and the fronts of their runs; none of a group that has one objective.
pub(crate) type Found<'r> = Vec<Option<(Vec<Wanted>, Vec<Front<'r>>)>>;

/// The fronts of all groups.
pub(crate) fn fronts(groups: &[Group]) -> Found<'_> {
    groups
        .iter()
        .map(|group| {
            let wanted = wanted(group)?;
            let fronts = group.runs.iter().map(|run| front(run, &wanted)).collect();
            Some((wanted, fronts))
        })
        .collect()
}

/// The shares that the fronts cover, by groups: those of the same objectives on one scale.
pub(crate) fn shares(all: &Found<'_>) -> Vec<Vec<f64>> {
    let of = |found: &Option<(Vec<Wanted>, Vec<Front<'_>>)>| {
        let Some((wanted, fronts)) = found else { return Vec::new() };
        let others = alike(all, wanted);
        let shares = covered(&others, wanted);
        let is_own = |front: &&Front<'_>| fronts.iter().any(|own| own.run.path == front.run.path);
        others.iter().zip(shares).filter(|(front, _)| is_own(front)).map(|(_, share)| share).collect()
    };
    all.iter().map(of).collect()
}

/// The fronts of all groups that want the same.
pub(crate) fn alike<'a, 'r>(all: &'a Found<'r>, wanted: &[Wanted]) -> Vec<&'a Front<'r>> {
    all.iter().flatten().filter(|(other, _)| other == wanted).flat_map(|(_, fronts)| fronts).collect()
}

/// How much of the space between the worst and the best values on all the fronts each of them covers (the hypervolume),
/// as a share.
pub(crate) fn covered(fronts: &[&Front<'_>], wanted: &[Wanted]) -> Vec<f64> {
    let space = Space::of(fronts, wanted);
    let volume = |front: &&Front<'_>| {
        let points: Vec<Vec<f64>> = front.best.iter().map(|one| space.share(&point(one, wanted))).collect();
        hypervolume(&points, &vec![0.0; wanted.len()])
    };
    fronts.iter().map(volume).collect()
}

/// How much of the box of some fronts a run has covered after so many evaluations, each time that this grew.
pub(crate) fn course(front: &Front<'_>, fronts: &[&Front<'_>], wanted: &[Wanted]) -> Vec<(u64, f64)> {
    let space = Space::of(fronts, wanted);
    let mut inside: Vec<Vec<f64>> = Vec::new();
    let mut course = vec![(0, 0.0)];
    for one in &front.tried {
        let share = space.share(&point(one, wanted));
        let covers = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| a >= b);
        if share.iter().any(|x| *x <= 0.0) || inside.iter().any(|other| covers(other, &share)) {
            continue;
        }
        inside.retain(|other| !covers(&share, other));
        inside.push(share);
        course.push((one.made.evaluations, hypervolume(&inside, &vec![0.0; wanted.len()])));
    }
    course
}

/// The box between the worst and the best values on some fronts.
struct Space {
    worst: Vec<f64>,
    best: Vec<f64>,
}

impl Space {
    fn of(fronts: &[&Front<'_>], wanted: &[Wanted]) -> Self {
        let all: Vec<Vec<f64>> =
            fronts.iter().flat_map(|front| &front.best).map(|one| point(one, wanted)).collect();
        let ends = |which: fn(f64, f64) -> f64, from: f64| -> Vec<f64> {
            (0..wanted.len()).map(|place| all.iter().map(|point| point[place]).fold(from, which)).collect()
        };
        Self { worst: ends(f64::min, f64::INFINITY), best: ends(f64::max, f64::NEG_INFINITY) }
    }

    /// Where a point is between the worst and the best, in each objective.
    fn share(&self, point: &[f64]) -> Vec<f64> {
        let ends = self.worst.iter().zip(&self.best);
        let between = |(x, (worst, best)): (&f64, (&f64, &f64))| {
            if best > worst { (x - worst) / (best - worst) } else { 1.0 }
        };
        point.iter().zip(ends).map(between).collect()
    }
}

impl<'r> Front<'r> {
    /// The design where the front bends, if it does: of those between the ends the one whose sum of values is the greatest, each as a
    /// share of the front's range; none where no sum is above those of the ends.
    pub(crate) fn knee(&self, wanted: &[Wanted]) -> Option<&Valued<'r>> {
        let all: Vec<&Valued<'r>> = self.best.iter().collect();
        let places: Vec<usize> = (0..wanted.len()).collect();
        bend(&all, wanted, &places)
    }

    /// For each value of an objective beside the first the best that the first can be: those that nothing beats in these two. The best by the
    /// first objective first.
    pub(crate) fn trade(&self, beside: usize, wanted: &[Wanted]) -> Vec<&Valued<'r>> {
        let Some(other) = wanted.get(beside).map(|wanted| wanted.direction) else { return Vec::new() };
        let first = wanted[0].direction;
        let mut order: Vec<&Valued<'r>> = self.best.iter().collect();
        let by = |direction: Direction, place: usize, a: &Valued<'_>, b: &Valued<'_>| {
            direction.fitness(b.each[place]).total_cmp(&direction.fitness(a.each[place]))
        };
        order.sort_by(|a, b| by(first, 0, a, b).then(by(other, beside, a, b)));
        let mut kept: Vec<&Valued<'r>> = Vec::new();
        for one in order {
            // Whoever comes later must be better in the other.
            let value = other.fitness(one.each[beside]);
            if kept.last().is_none_or(|last| value > other.fitness(last.each[beside])) {
                kept.push(one);
            }
        }
        kept
    }
}

/// Where a front bends in some of its objectives: see [`Front::knee`].
pub(crate) fn bend<'a, 'r>(
    all: &[&'a Valued<'r>],
    wanted: &[Wanted],
    places: &[usize],
) -> Option<&'a Valued<'r>> {
    let fitness = |one: &Valued<'_>, place: usize| wanted[place].direction.fitness(one.each[place]);
    let ranges: Vec<(f64, f64)> = places
        .iter()
        .map(|place| {
            let own = || all.iter().map(|one| fitness(one, *place));
            (own().fold(f64::INFINITY, f64::min), own().fold(f64::NEG_INFINITY, f64::max))
        })
        .collect();
    let sum = |one: &Valued<'_>| -> f64 {
        let shares = places.iter().zip(&ranges).filter(|(_, (low, high))| high > low);
        shares.map(|(place, (low, high))| (fitness(one, *place) - low) / (high - low)).sum()
    };
    let is_end =
        |one: &Valued<'_>| places.iter().zip(&ranges).any(|(place, (_, high))| fitness(one, *place) == *high);
    let of_ends = all.iter().filter(|one| is_end(one)).map(|one| sum(one)).fold(f64::NEG_INFINITY, f64::max);
    let inner = all.iter().filter(|one| !is_end(one));
    inner.max_by(|a, b| sum(a).total_cmp(&sum(b))).copied().filter(|one| sum(one) > of_ends)
}

/// `fronts.csv`: the designs on the fronts, all objectives in their units.
pub(crate) fn csv(groups: &[Group]) -> String {
    let columns =
        ["group", "seed", "move", "parts", "actuators", "objective", "value", "unit", "covered", "design"];
    let mut rows = Vec::new();
    let all = fronts(groups);
    for ((group, found), shares) in groups.iter().zip(&all).zip(shares(&all)) {
        let Some((wanted, fronts)) = found else { continue };
        for (front, share) in fronts.iter().zip(shares) {
            for one in &front.best {
                for (wanted, value) in wanted.iter().zip(&one.each) {
                    rows.push([
                        group.name.clone(),
                        front.run.asked.seed.to_string(),
                        one.made.number.to_string(),
                        one.made.parts.to_string(),
                        one.made.actuators.to_string(),
                        wanted.name.clone(),
                        value.to_string(),
                        wanted.unit.clone(),
                        share.to_string(),
                        or_empty(one.file(front.run).map(|file| file.display().to_string())),
                    ]);
                }
            }
        }
    }
    table(columns, rows.into_iter())
}

#[cfg(test)]
mod tests {
    use super::super::tests::run;
    use super::*;

    fn wanted() -> Vec<Wanted> {
        let one = |name: &str, unit: &str, direction| Wanted {
            name: name.to_owned(),
            unit: unit.to_owned(),
            direction,
        };
        vec![one("travel", "cm", Direction::Maximize), one("energy", "J", Direction::Minimize)]
    }

    /// A run of bodies with these values and energies.
    fn found(values: &[(f64, f64)]) -> Run {
        let rows: String = values
            .iter()
            .enumerate()
            .map(|(n, (value, _))| format!("{n},0,add,,2,1,{value},true,{value},0,{},0,0,\n", n + 1))
            .collect();
        let mut run = run(1, &rows);
        for (made, (_, energy)) in run.moves.iter_mut().zip(values) {
            made.beside = vec![*energy];
        }
        run
    }

    #[test]
    fn what_is_beaten_in_both_is_not_on_the_front() {
        let run = found(&[(0.0, 0.0), (10.0, 5.0), (9.0, 6.0), (8.0, 1.0), (8.0, 1.0), (10.0, 7.0)]);
        let front = front(&run, &wanted());
        let moves: Vec<u64> = front.best.iter().map(|one| one.made.number).collect();
        assert_eq!(moves, [1, 3, 0]);
        assert_eq!(front.knee(&wanted()).map(|one| one.made.number), Some(3));
        assert_eq!(front.trade(1, &wanted()).len(), 3);
        // Of a range of 10 by 5: 10 x 0 and 8 x 4 and 0 x 5, in boxes from the corner (0, 5).
        let share = covered(&[&front], &wanted())[0];
        assert!((share - 0.8 * 0.8).abs() < 1e-12, "{share}");
    }

    #[test]
    fn a_front_of_the_best_of_both_covers_all() {
        let (one, other) = (found(&[(10.0, 1.0)]), found(&[(5.0, 1.0), (10.0, 2.0)]));
        let fronts = [front(&one, &wanted()), front(&other, &wanted())];
        let shares = covered(&fronts.iter().collect::<Vec<_>>(), &wanted());
        assert_eq!(shares[0], 1.0);
        assert_eq!(shares[1], 0.0, "each of its designs is the worst in one of the two");
        assert_eq!(fronts[0].knee(&wanted()).map(|one| one.made.number), None);
    }

    #[test]
    fn a_hollow_front_has_no_knee_and_of_equals_the_one_that_is_better_in_the_other_begins_a_trade() {
        let run = found(&[(10.0, 10.0), (4.0, 6.0), (0.0, 0.0)]);
        assert!(front(&run, &wanted()).knee(&wanted()).is_none());
        let mut three = wanted();
        three.push(Wanted { name: "height".to_owned(), ..three[0].clone() });
        let mut run = found(&[(10.0, 9.0), (10.0, 5.0), (3.0, 1.0)]);
        for (made, height) in run.moves.iter_mut().zip([2.0, 1.0, 0.0]) {
            made.beside.push(height);
        }
        let front = front(&run, &three);
        let trade: Vec<u64> = front.trade(1, &three).iter().map(|one| one.made.number).collect();
        assert_eq!((front.best.len(), trade), (3, vec![1, 2]));
    }

    #[test]
    fn bodies_without_a_value_in_every_objective_are_left_out() {
        let mut run = found(&[(1.0, 1.0), (2.0, 2.0)]);
        run.moves[1].beside.clear();
        assert_eq!(front(&run, &wanted()).tried.len(), 1);
    }
}
