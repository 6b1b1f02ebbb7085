//! How long the runs took.

use super::words::{count, counted, number, or_dash, paragraph, span, table};
use super::{Link, label};
use crate::markup::escape;
use crate::results::report::gather::runs::Time;
use crate::results::report::read::Group;

pub(super) fn section(groups: &[Group], _: Link) -> String {
    let runs = || groups.iter().flat_map(|group| group.runs.iter().map(move |run| (group, run)));
    let rows: Vec<Vec<String>> = runs()
        .map(|(group, run)| {
            let name = escape(&label(groups, group, run));
            match Time::of(run) {
                Some(time) => vec![
                    name,
                    span(time.seconds),
                    count(time.evaluations),
                    or_dash(time.rate().map(number)),
                    time.processes.to_string(),
                    match time.threads {
                        (a, b) if a == b => a.to_string(),
                        (a, b) => format!("{a} to {b}"),
                    },
                ],
                None => vec![
                    name,
                    "unknown".to_owned(),
                    count(run.evaluations()),
                    "–".to_owned(),
                    "–".to_owned(),
                    "–".to_owned(),
                ],
            }
        })
        .collect();
    let head = ["run", "#wall time", "#evaluations", "#evaluations a second", "#processes", "#threads"];
    table(&head, &rows) + &paragraph(&said(groups))
}

fn said(groups: &[Group]) -> Vec<String> {
    let times: Vec<Option<Time>> = groups.iter().flat_map(|group| &group.runs).map(Time::of).collect();
    let known: Vec<Time> = times.iter().copied().flatten().collect();
    let unknown = (times.len() - known.len()) as u64;
    let mut said = Vec::new();
    if !known.is_empty() {
        let seconds: f64 = known.iter().map(|time| time.seconds).sum();
        let evaluations: u64 = known.iter().map(|time| time.evaluations).sum();
        said.push(format!(
            "{} and {} in total, summed over the runs, without cross-checks; other work on the machine makes the time longer.",
            span(seconds),
            counted(evaluations, "evaluation")
        ));
    }
    if unknown > 0 {
        said.push(format!(
            "The time of {} is unknown: an older version of sgc made them, or they have no checkpoint yet.",
            counted(unknown, "run")
        ));
    }
    said
}
