//! What each rule did: how often, with what effect on the value, and what came of it.

use super::spread::{Spread, share};
use super::{or_empty, table};
use crate::results::report::moves::Move;
use crate::results::report::read::{Found, Group};

/// What a rule did in the runs of a group.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rule {
    pub(crate) name: String,
    /// Draws without a result.
    pub(crate) blocked: u64,
    pub(crate) applied: u64,
    /// Applications whose design became the current one.
    pub(crate) accepted: u64,
    /// The change of the value, new less current, of the applications for which both have one.
    pub(crate) change: Option<Spread>,
    /// The same of those that were accepted.
    pub(crate) accepted_change: Option<Spread>,
    /// How many of these changes are for the better.
    pub(crate) improved: u64,
    /// Applications on the way to each run's best design, those that were taken back included; of runs of which the
    /// way is known.
    pub(crate) on_the_way: u64,
    /// Steps in the saved best designs: what was taken back is not among them.
    pub(crate) in_best: u64,
}

impl Rule {
    /// How often it was drawn.
    pub(crate) fn drawn(&self) -> u64 {
        self.blocked + self.applied
    }

    /// How often its effect on the value is known.
    pub(crate) fn known(&self) -> u64 {
        self.change.map_or(0, |change| change.count as u64)
    }
}

/// The rules of a group: in the order of the grammar if it can be read, else by name.
pub(crate) fn rules(group: &Group) -> Vec<Rule> {
    names(group).into_iter().map(|name| rule(group, name)).collect()
}

fn names(group: &Group) -> Vec<String> {
    let mut names: Vec<String> = match &group.rules {
        Ok(rules) => rules.0.rules.iter().map(|rule| rule.name.clone()).collect(),
        Err(_) => Vec::new(),
    };
    let declared = names.len();
    for made in group.runs.iter().flat_map(|run| &run.moves) {
        for name in made.rule.iter().chain(made.blocked.iter().map(|(name, _)| name)) {
            if !names.contains(name) {
                names.push(name.clone());
            }
        }
    }
    names[declared..].sort();
    names
}

fn rule(group: &Group, name: String) -> Rule {
    let moves = || group.runs.iter().flat_map(|run| &run.moves);
    let applied: Vec<&Move> = moves().filter(|m| m.rule.as_ref() == Some(&name)).collect();
    let change = |m: &&Move| Some(m.value? - m.from?);
    let better = |m: &&&Move| {
        let pair = m.value.zip(m.from);
        pair.is_some_and(|(new, old)| group.fitness(new) > group.fitness(old))
    };
    let drawn_in_vain = |m: &Move| m.blocked.iter().filter(|(blocked, _)| *blocked == name).count() as u64;
    let steps =
        |found: &Found| found.design.derivation.iter().filter(|step| step.rule == name).count() as u64;
    let is_its_own = |m: &&Move| m.rule.as_ref() == Some(&name);
    let on_the_way = group.runs.iter().filter_map(|run| run.history());
    let on_the_way = on_the_way.map(|moves| moves.into_iter().filter(is_its_own).count() as u64);
    Rule {
        blocked: moves().map(drawn_in_vain).sum(),
        applied: applied.len() as u64,
        accepted: applied.iter().filter(|m| m.accepted).count() as u64,
        change: Spread::of(applied.iter().filter_map(change)),
        accepted_change: Spread::of(applied.iter().filter(|m| m.accepted).filter_map(change)),
        improved: applied.iter().filter(better).count() as u64,
        on_the_way: on_the_way.sum(),
        in_best: group.runs.iter().filter_map(|run| run.design.as_ref()?.as_ref().ok()).map(steps).sum(),
        name,
    }
}

/// `rules.csv`.
pub(crate) fn csv(groups: &[Group]) -> String {
    let columns = [
        "group",
        "rule",
        "drawn",
        "blocked",
        "applied",
        "accepted",
        "known",
        "improved",
        "share_improved",
        "mean",
        "sd",
        "q1",
        "median",
        "q3",
        "accepted_mean",
        "accepted_q1",
        "accepted_median",
        "accepted_q3",
        "share_of_applied",
        "on_the_way",
        "share_on_the_way",
        "in_best",
        "share_in_best",
    ];
    let rows = groups.iter().flat_map(|group| {
        let rules = rules(group);
        let sum = |of: fn(&Rule) -> u64| rules.iter().map(of).sum::<u64>();
        let (applied, way, best) = (sum(|r| r.applied), sum(|r| r.on_the_way), sum(|r| r.in_best));
        let row = |rule: &Rule| {
            let (all, kept) = (rule.change, rule.accepted_change);
            [
                group.name.clone(),
                rule.name.clone(),
                rule.drawn().to_string(),
                rule.blocked.to_string(),
                rule.applied.to_string(),
                rule.accepted.to_string(),
                rule.known().to_string(),
                rule.improved.to_string(),
                or_empty(share(rule.improved, rule.known())),
                or_empty(all.map(|s| s.mean)),
                or_empty(all.and_then(|s| s.sd)),
                or_empty(all.map(|s| s.q1)),
                or_empty(all.map(|s| s.median)),
                or_empty(all.map(|s| s.q3)),
                or_empty(kept.map(|s| s.mean)),
                or_empty(kept.map(|s| s.q1)),
                or_empty(kept.map(|s| s.median)),
                or_empty(kept.map(|s| s.q3)),
                or_empty(share(rule.applied, applied)),
                rule.on_the_way.to_string(),
                or_empty(share(rule.on_the_way, way)),
                rule.in_best.to_string(),
                or_empty(share(rule.in_best, best)),
            ]
        };
        rules.iter().map(row).collect::<Vec<_>>()
    });
    table(columns, rows)
}

#[cfg(test)]
mod tests {
    use grammar_lang::ir::Direction;

    use super::super::tests::{group, run, two};
    use super::*;

    fn of<'a>(rules: &'a [Rule], name: &str) -> &'a Rule {
        rules.iter().find(|rule| rule.name == name).unwrap()
    }

    #[test]
    fn what_each_rule_did() {
        let rules = rules(&two());
        assert_eq!(rules.iter().map(|r| r.name.as_str()).collect::<Vec<_>>(), ["add", "turn", "undo"]);
        let add = of(&rules, "add");
        // From 0 to 4, from 4 to 3, from 3 to 8; and from 0 to 2.
        let change = add.change.unwrap();
        assert_eq!((change.count, change.mean, change.median), (4, 2.5, 3.0));
        assert_eq!((change.min, change.max), (-1.0, 5.0));
        assert_eq!((add.drawn(), add.blocked, add.applied, add.accepted), (6, 2, 4, 4));
        assert_eq!((add.known(), add.improved, add.on_the_way, add.in_best), (4, 3, 4, 0));
        let turn = of(&rules, "turn");
        assert_eq!((turn.drawn(), turn.blocked, turn.applied, turn.accepted), (4, 3, 1, 0));
        assert_eq!(turn.change.map(|s| s.mean), Some(-1.0));
        assert_eq!((turn.accepted_change, turn.on_the_way), (None, 0));
        let undo = of(&rules, "undo");
        assert_eq!((undo.applied, undo.blocked, undo.known(), undo.improved), (1, 1, 0, 0));
    }

    #[test]
    fn where_less_is_better_less_is_an_improvement() {
        let mut group = two();
        group.direction = Direction::Minimize;
        assert_eq!(of(&rules(&group), "add").improved, 1);
        assert_eq!(of(&rules(&group), "turn").improved, 1);
    }

    #[test]
    fn only_what_the_best_was_made_of_led_to_it() {
        let rows =
            "0,0,,,1,0,0,true,0,0,1,0,0,\n1,0,add,,2,0,1,true,1,9,2,0,0,\n2,0,add,,2,0,5,true,5,9,3,0,0,\n";
        let made_of = |parent: Option<u64>| {
            let mut alone = run(1, rows);
            alone.moves[2].parent = parent;
            of(&rules(&group(vec![alone])), "add").on_the_way
        };
        assert_eq!([Some(1), Some(0), None].map(made_of), [2, 1, 0]);
    }

    #[test]
    fn a_run_without_any_rule_has_no_rules() {
        assert!(rules(&group(vec![run(1, "0,0,,,1,0,0,true,0,0,1,0,0,\n"), run(2, "")])).is_empty());
    }
}
