//! Size against value: all bodies that were tried.

use std::collections::BTreeMap;

use super::spread::Spread;
use super::{or_empty, table};
use crate::results::report::moves::Move;
use crate::results::report::read::Group;

/// What the size is counted in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Size {
    Parts,
    Actuators,
}

impl Size {
    pub(crate) fn text(self) -> &'static str {
        match self {
            Self::Parts => "parts",
            Self::Actuators => "actuators",
        }
    }

    fn of(self, made: &Move) -> u64 {
        match self {
            Self::Parts => made.parts,
            Self::Actuators => made.actuators,
        }
    }
}

/// The bodies of one size.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Sized {
    pub(crate) size: u64,
    /// All that were tried, also those without a value.
    pub(crate) bodies: usize,
    /// Values of those that have one.
    pub(crate) values: Vec<f64>,
    pub(crate) spread: Option<Spread>,
}

/// All bodies that the runs of a group tried, by size. One that was tried again is counted again.
pub(crate) fn sizes(group: &Group, by: Size) -> Vec<Sized> {
    let mut all: BTreeMap<u64, (usize, Vec<f64>)> = BTreeMap::new();
    let tried = |m: &&Move| m.rule.is_some() || m.number == 0;
    for made in group.runs.iter().flat_map(|run| run.moves.iter().filter(tried)) {
        let (bodies, values) = all.entry(by.of(made)).or_default();
        *bodies += 1;
        values.extend(made.value);
    }
    let sized = all.into_iter().map(|(size, (bodies, values))| {
        let spread = Spread::of(values.iter().copied());
        Sized { size, bodies, values, spread }
    });
    sized.collect()
}

/// `sizes.csv`.
pub(crate) fn csv(groups: &[Group]) -> String {
    let columns =
        ["group", "by", "size", "bodies", "valued", "mean", "sd", "min", "q1", "median", "q3", "max"];
    let rows = groups.iter().flat_map(|group| {
        [Size::Parts, Size::Actuators].into_iter().flat_map(move |by| {
            sizes(group, by).into_iter().map(move |sized| {
                let of = |number: fn(&Spread) -> f64| or_empty(sized.spread.as_ref().map(number));
                [
                    group.name.clone(),
                    by.text().to_owned(),
                    sized.size.to_string(),
                    sized.bodies.to_string(),
                    sized.values.len().to_string(),
                    of(|s| s.mean),
                    or_empty(sized.spread.and_then(|s| s.sd)),
                    of(|s| s.min),
                    of(|s| s.q1),
                    of(|s| s.median),
                    of(|s| s.q3),
                    of(|s| s.max),
                ]
            })
        })
    });
    table(columns, rows)
}

#[cfg(test)]
mod tests {
    use super::super::tests::{group, run, two};
    use super::*;

    #[test]
    fn bodies_by_size() {
        let by_parts = sizes(&two(), Size::Parts);
        let counts: Vec<_> = by_parts.iter().map(|s| (s.size, s.bodies, s.values.len())).collect();
        // The move that did nothing made no body.
        assert_eq!(counts, [(1, 2, 2), (2, 4, 3), (3, 1, 1), (4, 1, 1)]);
        // 4, 2 and 1 with two parts.
        assert_eq!(by_parts[1].spread.map(|s| s.median), Some(2.0));
        let by_actuators: Vec<_> =
            sizes(&two(), Size::Actuators).iter().map(|s| (s.size, s.bodies)).collect();
        assert_eq!(by_actuators, [(0, 2), (1, 5), (2, 1)]);
        assert_eq!(sizes(&group(vec![run(1, "")]), Size::Parts), []);
    }
}
