//! Refused moves and failed evaluations, and why.

use std::collections::BTreeMap;

use super::table;
use crate::results::report::read::Group;

/// Refused moves and failed evaluations in the runs of a group.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Rejections {
    /// Draws that were blocked, by rule and what blocked them.
    pub(crate) blocked: BTreeMap<(String, String), u64>,
    /// Moves for which no rule could be applied.
    pub(crate) nothing: u64,
    /// Moves in all.
    pub(crate) moves: u64,
    /// Evaluations without a value, by the rule of the move (empty for the initial design) and reason.
    pub(crate) missing: BTreeMap<(String, String), u64>,
    /// Would-be bests that lost their value in a finer simulation, by the rule of the move.
    pub(crate) unstable: BTreeMap<String, u64>,
    /// Evaluations in all.
    pub(crate) evaluations: u64,
}

/// Refused moves and failed evaluations of a group.
pub(crate) fn rejections(group: &Group) -> Rejections {
    let mut all = Rejections::default();
    for run in &group.runs {
        all.evaluations += run.evaluations();
        for made in &run.moves {
            let rule = made.rule.clone().unwrap_or_default();
            let is_move = made.number > 0;
            all.moves += u64::from(is_move);
            all.nothing += u64::from(made.did_nothing());
            for pair in &made.blocked {
                *all.blocked.entry(pair.clone()).or_default() += 1;
            }
            for (reason, n) in &made.missing {
                *all.missing.entry((rule.clone(), reason.clone())).or_default() += n;
            }
            if made.unstable > 0 {
                *all.unstable.entry(rule).or_default() += made.unstable;
            }
        }
    }
    all
}

impl Rejections {
    /// What blocked rules, most often first, and how often.
    pub(crate) fn reasons(&self) -> Vec<(String, u64)> {
        by_second(&self.blocked)
    }

    /// Why evaluations had no value, most often first, and how often.
    pub(crate) fn without_value(&self) -> Vec<(String, u64)> {
        by_second(&self.missing)
    }

    /// All that lost their value in a finer simulation.
    pub(crate) fn all_unstable(&self) -> u64 {
        self.unstable.values().sum()
    }
}

fn by_second(counts: &BTreeMap<(String, String), u64>) -> Vec<(String, u64)> {
    let mut sums: BTreeMap<&String, u64> = BTreeMap::new();
    for ((_, reason), n) in counts {
        *sums.entry(reason).or_default() += n;
    }
    let mut sums: Vec<_> = sums.into_iter().map(|(reason, n)| (reason.clone(), n)).collect();
    sums.sort_by(|a, b| b.1.cmp(&a.1).then_with(|| a.0.cmp(&b.0)));
    sums
}

/// `rejections.csv`.
pub(crate) fn csv(groups: &[Group]) -> String {
    let rows = groups.iter().flat_map(|group| {
        let all = rejections(group);
        let pairs = |what: &'static str, counts: BTreeMap<(String, String), u64>| {
            counts.into_iter().map(move |((rule, reason), n)| (what, rule, reason, n))
        };
        let unstable = all.unstable.into_iter().map(|(rule, n)| ("unstable", rule, String::new(), n));
        let rows: Vec<_> =
            pairs("blocked", all.blocked).chain(pairs("no value", all.missing)).chain(unstable).collect();
        let name = group.name.clone();
        rows.into_iter()
            .map(move |(what, rule, reason, n)| [name.clone(), what.to_owned(), rule, reason, n.to_string()])
    });
    table(["group", "what", "rule", "reason", "count"], rows)
}

#[cfg(test)]
mod tests {
    use super::super::tests::{group, run, two};
    use super::*;

    #[test]
    fn what_came_to_nothing() {
        let all = rejections(&two());
        assert_eq!((all.moves, all.nothing, all.evaluations, all.all_unstable()), (7, 1, 14, 1));
        let reason = |text: &str, n| (text.to_owned(), n);
        assert_eq!(all.reasons(), [reason("solid", 3), reason("few", 2), reason("no match", 1)]);
        assert_eq!(all.without_value(), [reason("too fast", 1)]);
        assert_eq!(all.blocked[&("turn".to_owned(), "solid".to_owned())], 3);
        assert_eq!(all.unstable["undo"], 1);
        assert_eq!(rejections(&group(vec![run(1, "")])), Rejections::default());
    }
}
