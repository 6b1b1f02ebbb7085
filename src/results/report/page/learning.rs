//! Learning curves, drawn.

use super::chart::{Chart, Scale, hint};
use super::words::{counted, figures, key, value};
use super::{Link, axis, colour, label, names, told};
use crate::results::report::gather::learning::{Curve, curves};
use crate::results::report::read::Group;
use crate::search::Learned;

/// What a chart shows of an iteration.
type Of = fn(&Learned) -> Option<f64>;

pub(super) fn section(groups: &[Group], _: Link) -> String {
    let all: Vec<Vec<Curve<'_>>> = groups.iter().map(curves).collect();
    if all.iter().all(Vec::is_empty) {
        return String::new();
    }
    let best = [("line thin".to_owned(), "the best policy so far".to_owned())];
    let marks: Vec<(String, String)> = names(groups).into_iter().chain(best).collect();
    let reward = chart(groups, &all, "reward of a motion that explores", &[("line", |one| one.reward)]);
    let policy = axis("value of the policy", groups.first());
    let worth = chart(groups, &all, &policy, &[("line", |one| one.value), ("line thin", |one| one.best)]);
    let told = groups.iter().zip(&all).map(|(group, curves)| told(groups, group, &said(group, curves)));
    key(&marks) + &figures(&[reward, worth]) + NOTE + &told.collect::<String>()
}

const NOTE: &str = "<p class=\"small\">A line is a run and a task. The reward is the sum over a motion, a mean over the motions of an iteration. The policy is judged without random actions, in the nominal world; the best so far counts in all worlds, if the objective runs over worlds.</p>\n";

fn chart(groups: &[Group], all: &[Vec<Curve<'_>>], label_of_y: &str, shown: &[(&str, Of)]) -> String {
    let iterations = || all.iter().flatten().flat_map(|curve| &curve.iterations);
    let motions: Vec<f64> = iterations().map(|one| one.motions as f64).chain([0.0]).collect();
    let y =
        Scale::of(shown.iter().flat_map(|(_, of)| iterations().filter_map(|one| of(one))).chain([0.0]), 6);
    let mut chart =
        Chart::new(Chart::HALF, (Scale::until(motions, 5), "motions that explored"), (y, label_of_y));
    for (i, (group, curves)) in groups.iter().zip(all).enumerate() {
        for curve in curves {
            let task = if curve.task.is_empty() { String::new() } else { format!(", {}", curve.task) };
            let hints = hint(&(label(groups, group, curve.run) + &task));
            for (class, of) in shown {
                let points: Vec<(f64, f64)> =
                    curve.iterations.iter().filter_map(|one| Some((one.motions as f64, of(one)?))).collect();
                let course = chart.course(&points);
                chart.add(&format!("<path class=\"{class} {}\" d=\"{course}\">{hints}</path>", colour(i)));
            }
        }
    }
    chart.finish(&format!("{label_of_y} against motions that explored"))
}

/// What is seen, in words.
fn said(group: &Group, curves: &[Curve<'_>]) -> Vec<String> {
    let several = curves.iter().any(|curve| curves.first().is_some_and(|first| first.task != curve.task));
    curves
        .iter()
        .filter_map(|curve| {
            let last = curve.iterations.last()?;
            let task = if several { format!(", {}", curve.task) } else { String::new() };
            let name = format!("Seed {}{task}", curve.run.asked.seed);
            let Some(found) = curve.found() else { return Some(format!("{name}: no policy has a value yet.")) };
            // Tasks may have other units than the objective.
            let unit = if several { "" } else { group.unit.as_str() };
            let of = |x: Option<f64>| x.map_or("no value".to_owned(), |x| value(x, unit));
            Some(format!(
                "{name}: the best policy of the iterations, {}, was found after {} that explored; the last policy, after {}, comes to {}.",
                of(found.best),
                counted(found.motions, "motion"),
                last.motions,
                of(last.value)
            ))
        })
        .collect()
}
