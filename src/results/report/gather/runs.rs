//! The runs, one by one and together.

use super::spread::Spread;
use super::{or_empty, table};
use crate::results::elsewhere::Tested;
use crate::results::report::read::{Group, Run};

/// How long a run took, as far as it was written down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Time {
    pub(crate) seconds: f64,
    /// Evaluations in that time: some may have been lost with a process that was killed.
    pub(crate) evaluations: u64,
    pub(crate) processes: usize,
    /// The fewest and the most threads of a process.
    pub(crate) threads: (usize, usize),
}

impl Time {
    /// None where nobody kept count.
    pub(crate) fn of(run: &Run) -> Option<Self> {
        let processes = run.processes.as_ref()?;
        let threads = || processes.iter().map(|process| process.threads);
        Some(Self {
            seconds: processes.iter().map(|process| process.seconds).sum(),
            evaluations: processes.iter().map(|process| process.end - process.begin).sum(),
            processes: processes.len(),
            threads: (threads().min()?, threads().max()?),
        })
    }

    /// Evaluations per second.
    pub(crate) fn rate(&self) -> Option<f64> {
        (self.seconds > 0.0).then(|| self.evaluations as f64 / self.seconds)
    }
}

/// How two groups compare over all pairs of a run of each, as shares of the pairs.
pub(crate) struct Pairs {
    /// In which the first has the better value.
    pub(crate) better: f64,
    /// In which both have the same value.
    pub(crate) even: f64,
}

/// Compares two groups; none where one has no runs.
pub(crate) fn pairs(one: &Group, other: &Group) -> Option<Pairs> {
    // A run that has found nothing is worse than any that has.
    let worth = |group: &Group| -> Vec<f64> {
        let fitness = |value: f64| one.fitness(value);
        group.outcomes().into_iter().map(|value| value.map_or(f64::NEG_INFINITY, fitness)).collect()
    };
    let (ours, theirs) = (worth(one), worth(other));
    let all: Vec<_> = ours.iter().flat_map(|a| theirs.iter().map(|b| a.total_cmp(b))).collect();
    let share = |of| all.iter().filter(|order| **order == of).count() as f64 / all.len() as f64;
    (!all.is_empty())
        .then(|| Pairs { better: share(std::cmp::Ordering::Greater), even: share(std::cmp::Ordering::Equal) })
}

/// The best values of a group's runs.
pub(crate) fn spread(group: &Group) -> Option<Spread> {
    Spread::of(group.values())
}

/// `runs.csv`.
pub(crate) fn csv(groups: &[Group]) -> String {
    let columns = [
        "group",
        "seed",
        "value",
        "unit",
        "evaluations",
        "moves",
        "found_at_move",
        "found_at_evaluation",
        "parts",
        "actuators",
        "end",
        "checks_kept",
        "checks",
        "nine_of_ten",
        "mean_of_worlds",
        "over_worlds",
        "seconds",
        "evaluations_per_second",
        "folder",
    ];
    let rows = groups.iter().flat_map(|group| group.runs.iter().map(move |run| (group, run)));
    table(
        columns,
        rows.map(|(group, run)| {
            let (found, checks, time) = (run.found(), run.checks(), Time::of(run));
            let tested = run.tested();
            [
                group.name.clone(),
                run.asked.seed.to_string(),
                or_empty(run.value()),
                group.unit.clone(),
                run.evaluations().to_string(),
                or_empty(run.moves.last().map(|m| m.number)),
                or_empty(found.map(|m| m.number)),
                or_empty(found.map(|m| m.evaluations)),
                or_empty(found.map(|m| m.parts)),
                or_empty(found.map(|m| m.actuators)),
                run.standing.text().to_owned(),
                or_empty(checks.map(|(kept, _)| kept)),
                or_empty(checks.map(|(_, all)| all)),
                or_empty(tested.as_ref().and_then(|tested| tested.each()?.tenth)),
                or_empty(tested.as_ref().and_then(|tested| tested.each()?.mean)),
                or_empty(tested.as_ref().and_then(Tested::whole)),
                or_empty(time.map(|time| format!("{:.1}", time.seconds))),
                or_empty(time.and_then(|time| time.rate()).map(|rate| format!("{rate:.1}"))),
                run.path.display().to_string(),
            ]
        }),
    )
}

#[cfg(test)]
mod tests {
    use grammar_lang::ir::Direction;

    use super::super::tests::{group, run, two};
    use super::*;
    use crate::results::processes::Process;

    #[test]
    fn time_is_summed_over_the_processes() {
        let mut timed = run(1, "0,0,,,1,0,0,true,0,0,1,0,0,\n");
        assert_eq!(Time::of(&timed), None);
        let process = |begin, end, seconds, threads| Process { begin, end, seconds, threads };
        timed.processes = Some(vec![process(0, 100, 2.0, 2), process(90, 190, 3.0, 1)]);
        let time = Time::of(&timed).unwrap();
        assert_eq!(time, Time { seconds: 5.0, evaluations: 200, processes: 2, threads: (1, 2) });
        assert_eq!(time.rate(), Some(40.0));
    }

    #[test]
    fn groups_are_compared_pair_by_pair() {
        // 8 and 2 against 4: better once, worse once.
        let four = group(vec![run(1, "0,0,,,1,0,4,true,4,0,1,0,0,\n")]);
        let shares = |one: &Group, other: &Group| pairs(one, other).map(|pairs| (pairs.better, pairs.even));
        assert_eq!(shares(&two(), &four), Some((0.5, 0.0)));
        // 8 and 2 against 2: better once, even once.
        let same = group(vec![run(1, "0,0,,,1,0,2,true,2,0,1,0,0,\n")]);
        assert_eq!(shares(&two(), &same), Some((0.5, 0.5)));
        let mut least = same;
        least.direction = Direction::Minimize;
        let mut other = two();
        other.direction = Direction::Minimize;
        assert_eq!(shares(&other, &least), Some((0.0, 0.5)));
        assert_eq!(shares(&two(), &group(Vec::new())), None);
    }

    #[test]
    fn the_best_run_is_found_whatever_is_best() {
        let mut runs = two();
        let best = |group: &Group| group.best().map(|(i, _)| i);
        assert_eq!(best(&runs), Some(0));
        runs.direction = Direction::Minimize;
        assert_eq!(best(&runs), Some(1));
        assert_eq!(best(&group(vec![run(1, ""), run(2, "0,0,,,1,0,,true,,0,1,1,0,1 too fast\n")])), None);
    }
}
