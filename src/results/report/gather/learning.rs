//! The learning curves of policies.

use super::{or_empty, table};
use crate::results::report::read::{Group, Run};
use crate::search::Learned;

/// What a learner came to in one task of a run.
pub(crate) struct Curve<'g> {
    pub(crate) run: &'g Run,
    pub(crate) task: &'g str,
    /// Its iterations, in their order; at least one.
    pub(crate) iterations: Vec<&'g Learned>,
}

impl Curve<'_> {
    /// The first iteration after which the best value of the task did not change any more.
    pub(crate) fn found(&self) -> Option<&Learned> {
        let best = self.iterations.last()?.best?;
        self.iterations.iter().find(|iteration| iteration.best == Some(best)).copied()
    }
}

/// The curves of a group, by run and task.
pub(crate) fn curves(group: &Group) -> Vec<Curve<'_>> {
    let mut all: Vec<Curve<'_>> = Vec::new();
    for run in &group.runs {
        for row in &run.learning {
            match all.last_mut() {
                Some(curve) if curve.task == row.task && std::ptr::eq(curve.run, run) => {
                    curve.iterations.push(&row.learned);
                }
                _ => all.push(Curve { run, task: &row.task, iterations: vec![&row.learned] }),
            }
        }
    }
    all
}

/// `learning.csv`.
pub(crate) fn csv(groups: &[Group]) -> String {
    let columns = [
        "group",
        "seed",
        "task",
        "iteration",
        "evaluations",
        "motions",
        "reward",
        "exploration",
        "value",
        "best",
    ];
    let rows = groups.iter().flat_map(|group| {
        group.runs.iter().flat_map(move |run| {
            run.learning.iter().map(move |row| {
                let learned = &row.learned;
                [
                    group.name.clone(),
                    run.asked.seed.to_string(),
                    row.task.clone(),
                    row.iteration.to_string(),
                    learned.evaluations.to_string(),
                    learned.motions.to_string(),
                    or_empty(learned.reward),
                    learned.exploration.to_string(),
                    or_empty(learned.value),
                    or_empty(learned.best),
                ]
            })
        })
    });
    table(columns, rows)
}

#[cfg(test)]
mod tests {
    use super::super::tests::{group, run};
    use super::*;
    use crate::results::learning::Row;

    #[test]
    fn a_curve_is_of_one_run_and_one_task() {
        let row = |task: &str, iteration, best| Row {
            task: task.to_owned(),
            iteration,
            learned: Learned {
                evaluations: 5 * iteration,
                motions: 4 * iteration,
                reward: Some(0.5),
                exploration: 0.0,
                value: None,
                best,
            },
        };
        let mut learns = run(1, "0,0,,,1,0,0,true,0,0,1,0,0,\n");
        learns.learning =
            vec![row("go", 1, None), row("go", 2, Some(3.0)), row("go", 3, Some(3.0)), row("turn", 1, None)];
        let group = group(vec![learns, run(2, "0,0,,,1,0,0,true,0,0,1,0,0,\n")]);
        let curves = curves(&group);
        let seen: Vec<_> = curves.iter().map(|curve| (curve.task, curve.iterations.len())).collect();
        assert_eq!(seen, [("go", 3), ("turn", 1)]);
        assert_eq!(curves[0].found().map(|found| found.motions), Some(8));
        assert_eq!(curves[1].found(), None);
        let text = csv(std::slice::from_ref(&group));
        assert_eq!(text.lines().nth(2), Some("tiny,1,go,2,10,8,0.5,0,,3"), "{text}");
    }
}
