//! What was observed against value: all bodies that were accepted, and the best of each run.

use std::collections::BTreeMap;

use grammar_lang::ir::{RuleSet, Ty};
use grammar_lang::units;

use super::spread::{Spread, share};
use super::{or_empty, table};
use crate::results::report::moves::Move;
use crate::results::report::read::Group;

/// How many bins a range of numbers is cut into.
const BINS: usize = 10;

/// What an observed term says.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Kind {
    /// A number, shown in a unit that is so many SI units.
    Number { unit: String, factor: f64 },
    /// One of some words, in this order.
    Class(Vec<String>),
}

/// An observed term.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Seen {
    pub(crate) name: String,
    pub(crate) kind: Kind,
}

/// Bodies whose numbers are near each other.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Bin {
    pub(crate) low: f64,
    pub(crate) high: f64,
    pub(crate) spread: Spread,
}

/// The bodies of a class.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Class {
    pub(crate) name: String,
    /// The best of each run, or all bodies that were accepted: how many, their share, and their values.
    pub(crate) best: Occurrence,
    pub(crate) accepted: Occurrence,
}

/// How often a class occurs.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Occurrence {
    pub(crate) count: u64,
    pub(crate) share: Option<f64>,
    pub(crate) spread: Option<Spread>,
}

fn word<'m>(made: &'m Move, name: &str) -> Option<&'m str> {
    made.observed.iter().find(|(n, _)| n == name).map(|(_, text)| text.as_str())
}

fn moves(group: &Group) -> impl Iterator<Item = &Move> {
    group.runs.iter().flat_map(|run| &run.moves)
}

/// The bodies of a group that were accepted, with their values.
fn accepted(group: &Group) -> impl Iterator<Item = (&Move, f64)> {
    moves(group).filter(|made| made.accepted).filter_map(|made| Some((made, made.value?)))
}

/// What was observed in a group, in the order of its columns.
pub(crate) fn seen(group: &Group) -> Vec<Seen> {
    let mut names: Vec<&str> = Vec::new();
    for (name, _) in moves(group).flat_map(|made| &made.observed) {
        if !names.contains(&name.as_str()) {
            names.push(name);
        }
    }
    // A term without a value leaves its column empty: the grammar knows the order.
    if let Ok(rules) = &group.rules {
        names.sort_by_key(|name| rules.0.observed.iter().position(|n| n == name));
    }
    names.into_iter().map(|name| Seen { name: name.to_owned(), kind: kind(group, name) }).collect()
}

fn kind(group: &Group, name: &str) -> Kind {
    let rules = group.rules.as_ref().ok().map(|rules| &rules.0);
    match rules.and_then(|rules| Some((rules, &rules.terms.get(name)?.ty))) {
        Some((rules, Ty::Enum(of))) => Kind::Class(rules.enumerations.get(of).cloned().unwrap_or_default()),
        Some((_, Ty::Bool)) => Kind::Class(vec!["true".to_owned(), "false".to_owned()]),
        Some((rules, ty)) => number(rules, ty),
        None => {
            let words = || moves(group).filter_map(|made| word(made, name));
            if words().all(|text| text.parse::<f64>().is_ok()) {
                return Kind::Number { unit: String::new(), factor: 1.0 };
            }
            let mut all: Vec<String> = words().map(str::to_owned).collect();
            all.sort();
            all.dedup();
            Kind::Class(all)
        }
    }
}

/// In the unit of the objective where that fits, else in one that people use.
fn number(rules: &RuleSet, ty: &Ty) -> Kind {
    let dimension = ty.dimension().unwrap_or_default();
    let own = units::parse(&rules.objective.unit).ok().filter(|unit| unit.dimension == dimension);
    if let (Some(own), false) = (own, dimension.is_number()) {
        return Kind::Number { unit: rules.objective.unit.clone(), factor: own.factor };
    }
    let unit = units::display_unit(dimension);
    let factor = units::parse(&unit).map_or(1.0, |unit| unit.factor);
    Kind::Number { unit, factor }
}

/// A number and the value, for each body that was accepted.
pub(crate) fn points(group: &Group, name: &str, factor: f64) -> Vec<(f64, f64)> {
    let number = |made| word(made, name)?.parse::<f64>().ok().filter(|x| x.is_finite());
    accepted(group).filter_map(|(made, value)| Some((number(made)? / factor, value))).collect()
}

/// The points in even bins; those without a point are left out.
pub(crate) fn bins(points: &[(f64, f64)]) -> Vec<Bin> {
    let (low, high) =
        points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), (x, _)| (l.min(*x), h.max(*x)));
    let width = (high - low) / BINS as f64;
    let mut all: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
    for (x, value) in points {
        let bin = if width > 0.0 { (((x - low) / width) as usize).min(BINS - 1) } else { 0 };
        all.entry(bin).or_default().push(*value);
    }
    let bin = |(bin, values): (usize, Vec<f64>)| {
        let (low, high) = (low + width * bin as f64, low + width * (bin + 1) as f64);
        Some(Bin { low, high, spread: Spread::of(values)? })
    };
    all.into_iter().filter_map(bin).collect()
}

/// How often each class occurs among the best of each run and the bodies that were accepted.
pub(crate) fn classes(group: &Group, name: &str, order: &[String]) -> Vec<Class> {
    let best = || group.runs.iter().filter_map(|run| Some((word(run.found()?, name)?, run.value()?)));
    let accepted = || accepted(group).filter_map(|(made, value)| Some((word(made, name)?, value)));
    let (bests, all) = (best().count() as u64, accepted().count() as u64);
    let occurrence = |values: Vec<f64>, of: u64| {
        let count = values.len() as u64;
        Occurrence { count, share: share(count, of), spread: Spread::of(values) }
    };
    order
        .iter()
        .map(|class| Class {
            name: class.clone(),
            best: occurrence(best().filter(|(word, _)| word == class).map(|(_, v)| v).collect(), bests),
            accepted: occurrence(accepted().filter(|(word, _)| word == class).map(|(_, v)| v).collect(), all),
        })
        .collect()
}

/// `observed.csv`.
pub(crate) fn csv(groups: &[Group]) -> String {
    let columns =
        ["group", "term", "unit", "from", "to", "bodies", "mean", "sd", "min", "q1", "median", "q3", "max"];
    let mut rows = Vec::new();
    for group in groups {
        for Seen { name, kind } in seen(group) {
            let Kind::Number { unit, factor } = kind else { continue };
            for Bin { low, high, spread } in bins(&points(group, &name, factor)) {
                rows.push([
                    group.name.clone(),
                    name.clone(),
                    unit.clone(),
                    low.to_string(),
                    high.to_string(),
                    spread.count.to_string(),
                    spread.mean.to_string(),
                    or_empty(spread.sd),
                    spread.min.to_string(),
                    spread.q1.to_string(),
                    spread.median.to_string(),
                    spread.q3.to_string(),
                    spread.max.to_string(),
                ]);
            }
        }
    }
    table(columns, rows.into_iter())
}

/// `classes.csv`.
pub(crate) fn classes_csv(groups: &[Group]) -> String {
    let columns = ["group", "term", "class", "of", "count", "share", "mean", "sd", "min", "max"];
    let mut rows = Vec::new();
    for group in groups {
        for Seen { name, kind } in seen(group) {
            let Kind::Class(order) = kind else { continue };
            for class in classes(group, &name, &order) {
                for (of, Occurrence { count, share, spread }) in
                    [("best of each run", class.best), ("accepted", class.accepted)]
                {
                    rows.push([
                        group.name.clone(),
                        name.clone(),
                        class.name.clone(),
                        of.to_owned(),
                        count.to_string(),
                        or_empty(share),
                        or_empty(spread.map(|s| s.mean)),
                        or_empty(spread.and_then(|s| s.sd)),
                        or_empty(spread.map(|s| s.min)),
                        or_empty(spread.map(|s| s.max)),
                    ]);
                }
            }
        }
    }
    table(columns, rows.into_iter())
}

#[cfg(test)]
mod tests {
    use super::super::tests::two;
    use super::*;

    /// The group of two runs, whose bodies were observed: their height, and whether they hop.
    fn observed() -> Group {
        let mut group = two();
        for made in group.runs.iter_mut().flat_map(|run| &mut run.moves).filter(|m| m.value.is_some()) {
            let gait = if made.parts > 2 { "hopper" } else { "still" };
            made.observed = vec![
                ("height".to_owned(), format!("{}", made.parts as f64 / 10.0)),
                ("gait".to_owned(), gait.to_owned()),
            ];
        }
        group
    }

    #[test]
    fn numbers_are_binned_and_classes_counted() {
        let group = observed();
        let names: Vec<_> = seen(&group).into_iter().map(|seen| seen.name).collect();
        assert_eq!(names, ["height", "gait"]);
        let points = points(&group, "height", 0.1);
        // The move that was not accepted and the one without a value are no points.
        let rounded: Vec<_> = points.iter().map(|(x, y)| ((x * 1e9).round() / 1e9, *y)).collect();
        assert_eq!(rounded, [(1.0, 0.0), (2.0, 4.0), (3.0, 3.0), (4.0, 8.0), (1.0, 0.0), (2.0, 2.0)]);
        let bins = bins(&points);
        let counts: Vec<_> = bins.iter().map(|bin| (bin.spread.count, bin.spread.mean)).collect();
        assert_eq!(counts, [(2, 0.0), (2, 3.0), (1, 3.0), (1, 8.0)]);
        let order = ["still".to_owned(), "hopper".to_owned(), "roller".to_owned()];
        let classes = classes(&group, "gait", &order);
        let counts: Vec<_> = classes.iter().map(|class| (class.best.count, class.accepted.count)).collect();
        assert_eq!(counts, [(1, 4), (1, 2), (0, 0)]);
        assert_eq!(classes[1].best.spread.map(|s| s.mean), Some(8.0));
        assert_eq!(classes[2].accepted.share, Some(0.0));
    }

    #[test]
    fn one_number_is_one_bin() {
        assert_eq!(bins(&[(2.0, 1.0), (2.0, 3.0)]).len(), 1);
        assert_eq!(bins(&[]), []);
    }

    #[test]
    fn the_tables_of_what_was_observed() {
        let groups = [observed()];
        assert!(classes_csv(&groups).contains("tiny,gait,hopper,best of each run,1,0.5,8,,8,8\n"));
        assert_eq!(csv(&groups).lines().count(), 5);
    }
}
