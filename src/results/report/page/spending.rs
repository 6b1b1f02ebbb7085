//! Where evaluations went, drawn and in words.

use super::words::{count, counted, key, number, or_dash, percent, table};
use super::{Link, label, told};
use crate::markup::escape;
use crate::results::report::gather::spending::{CLASSES, Spending, shares, spending};
use crate::results::report::gather::spread::{mean, share};
use crate::results::report::read::Group;

/// What the classes are called, from the worst to the best.
const NAMES: [&str; CLASSES] = [
    "bodies below a tenth of the best value, or without one",
    "a tenth to a quarter",
    "a quarter to a half",
    "a half to three quarters",
    "three quarters and more",
    "the best body itself",
];

pub(super) fn section(groups: &[Group], _: Link) -> String {
    let all: Vec<Vec<Spending>> = groups
        .iter()
        .map(|group| group.runs.iter().filter_map(|run| spending(run, group.direction)).collect())
        .collect();
    if all.iter().all(Vec::is_empty) {
        return "<p>Nothing was simulated.</p>\n".to_owned();
    }
    let mut out = String::new();
    let drawn: String = groups.iter().zip(&all).filter_map(|(group, all)| bar(groups, group, all)).collect();
    if !drawn.is_empty() {
        let marks = NAMES.iter().enumerate().map(|(i, name)| (format!("chip c{i}"), (*name).to_owned()));
        out += &key(&marks.collect::<Vec<_>>());
        out += &drawn;
    }
    out += &rows(groups);
    for (group, all) in groups.iter().zip(&all) {
        out += &told(groups, group, &said(all));
    }
    out
}

/// The shares of a group, as one bar.
fn bar(groups: &[Group], group: &Group, all: &[Spending]) -> Option<String> {
    let shares = shares(all)?;
    let parts: String = shares
        .iter()
        .zip(NAMES)
        .enumerate()
        .filter(|(_, (share, _))| **share > 0.0)
        .map(|(class, (share, name))| {
            format!(
                "<span class=\"c{class}\" style=\"flex-grow:{share:.4}\" title=\"{}: {}\"></span>",
                escape(name),
                percent(*share)
            )
        })
        .collect();
    let name = if groups.len() < 2 { String::new() } else { format!("<b>{}</b>", escape(&group.name)) };
    Some(format!("<div class=\"spent\">{name}<div class=\"bar\">{parts}</div></div>\n"))
}

fn rows(groups: &[Group]) -> String {
    let mut rows = Vec::new();
    for group in groups {
        for run in &group.runs {
            let Some(one) = spending(run, group.direction) else { continue };
            let part = |n: u64| or_dash(share(n, one.evaluations).map(percent));
            rows.push(vec![
                escape(&label(groups, group, run)),
                count(one.bodies),
                number(one.evaluations as f64 / one.bodies.max(1) as f64),
                or_dash(one.classes.and_then(|classes| share(classes[0], one.evaluations)).map(percent)),
                part(one.of_best),
                part(one.further),
                or_dash(share(one.accepted.0, one.accepted.1).map(percent)),
                or_dash(one.generations.map(count)),
            ]);
        }
    }
    let head = [
        "run",
        "#bodies simulated",
        "#evaluations of each",
        "#below a tenth of the best",
        "#of the best body",
        "#tuning further",
        "#moves accepted",
        "#generations to the best",
    ];
    table(&head, &rows)
}

/// Beyond this share of accepted moves a search hardly selects.
const HARDLY_SELECTS: f64 = 0.6;
/// And beyond this share on bodies that are no good it is slow to leave them.
const SLOW: f64 = 0.5;

/// What is seen, in words.
fn said(all: &[Spending]) -> Vec<String> {
    let mut said = Vec::new();
    let bodies: u64 = all.iter().map(|one| one.bodies).sum();
    let evaluations: u64 = all.iter().map(|one| one.evaluations).sum();
    if bodies > 0 {
        said.push(format!(
            "{} took {:.1} evaluations on average.",
            counted(bodies, "body").replace("bodys", "bodies"),
            evaluations as f64 / bodies as f64
        ));
    }
    if let Some(worst) = shares(all).map(|shares| shares[0]) {
        let advice = if worst > SLOW {
            " A search that spends less on each body before it goes on would try more of them."
        } else {
            ""
        };
        said.push(format!(
            "{} of the evaluations went into bodies that ended below a tenth of the best.{advice}",
            percent(worst)
        ));
    }
    let rates = all.iter().filter_map(|one| share(one.accepted.0, one.accepted.1));
    if let Some(rate) = mean(rates).filter(|rate| *rate > HARDLY_SELECTS) {
        said.push(format!(
            "{} of the moves were accepted: the search hardly selects among bodies.",
            percent(rate)
        ));
    }
    said
}
