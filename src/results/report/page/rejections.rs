//! Failed evaluations and refused moves, as tables.

use std::collections::BTreeMap;

use super::words::{count, counted, percent, table};
use super::{Link, heading, told};
use crate::markup::escape;
use crate::results::report::gather::rejections::{Rejections, rejections};
use crate::results::report::gather::spread::share;
use crate::results::report::read::Group;

pub(super) fn section(groups: &[Group], _: Link) -> String {
    let mut out = String::new();
    for (i, group) in groups.iter().enumerate() {
        let rejected = rejections(group);
        out += &heading(groups, i);
        out += &blocked(group, &rejected);
        out += &without_value(&rejected);
        out += &told(groups, group, &said(&rejected));
    }
    out
}

/// What blocked which rule: the more often, the darker.
fn blocked(group: &Group, rejected: &Rejections) -> String {
    let reasons = rejected.reasons();
    if reasons.is_empty() {
        return "<p>No rule was ever blocked.</p>\n".to_owned();
    }
    let mut rules: BTreeMap<&String, u64> = BTreeMap::new();
    for ((rule, _), n) in &rejected.blocked {
        *rules.entry(rule).or_default() += n;
    }
    let most = rejected.blocked.values().max().copied().unwrap_or(1);
    let cell = |n: u64| {
        let depth = (libm::sqrt(n as f64 / most as f64) * 100.0).round();
        if n == 0 {
            "<span class=\"quiet\">·</span>".to_owned()
        } else {
            format!("<span class=\"heat\" style=\"--depth:{depth}%\">{}</span>", count(n))
        }
    };
    let names: Vec<String> = rules.keys().map(|rule| format!("#{}", escape(rule))).collect();
    let head: Vec<&str> =
        ["blocked by"].into_iter().chain(names.iter().map(String::as_str)).chain(["#all", "why"]).collect();
    let rows: Vec<Vec<String>> = reasons
        .iter()
        .map(|(reason, sum)| {
            let of =
                |rule: &String| rejected.blocked.get(&(rule.clone(), reason.clone())).copied().unwrap_or(0);
            let cells = rules.keys().map(|rule| cell(of(rule)));
            let why = because(group, reason);
            [escape(reason)].into_iter().chain(cells).chain([count(*sum), escape(&why)]).collect()
        })
        .collect();
    table(&head, &rows)
}

/// What the grammar says of a requirement, or what else a reason means.
fn because(group: &Group, reason: &str) -> String {
    if let Ok(rules) = &group.rules
        && let Some(requirement) = rules.0.requirements.iter().find(|r| r.name == reason)
    {
        return requirement.because.clone().unwrap_or_else(|| "a requirement of the grammar".to_owned());
    }
    match reason {
        "no match" => "the rule matches nowhere in the design",
        "symmetry" => "the images of what it does take each other's place",
        "no change" => "the body would be the same as before",
        "needed by a later step" => "a later step needs what the rule would revert",
        "port taken" => "a part is attached there already",
        "no value" => "an expression of the grammar has no value",
        _ => "",
    }
    .to_owned()
}

fn without_value(rejected: &Rejections) -> String {
    let unstable = rejected.all_unstable();
    let reasons = rejected.without_value();
    if reasons.is_empty() && unstable == 0 {
        return "<p>Every evaluation had a value, and no best lost it in a finer simulation.</p>\n"
            .to_owned();
    }
    let part = |n: u64| share(n, rejected.evaluations).map_or(String::new(), percent);
    let mut rows: Vec<Vec<String>> = reasons
        .iter()
        .map(|(reason, n)| vec![format!("no value: {}", escape(reason)), count(*n), part(*n)])
        .collect();
    if unstable > 0 {
        rows.push(vec![
            "unstable: a candidate for the best that lost its value in a finer simulation".to_owned(),
            count(unstable),
            part(unstable),
        ]);
    }
    table(&["failed evaluations", "#count", "#of all evaluations"], &rows)
}

/// What is seen, in words.
fn said(rejected: &Rejections) -> Vec<String> {
    let mut said = Vec::new();
    let reasons = rejected.reasons();
    let sum: u64 = reasons.iter().map(|(_, n)| n).sum();
    if let Some((reason, n)) = reasons.first() {
        said.push(format!(
            "Rules were blocked {}, most often by “{}” ({}).",
            counted(sum, "time"),
            escape(reason),
            percent(share(*n, sum).unwrap_or(0.0))
        ));
    }
    if rejected.nothing > 0 {
        let moves = counted(rejected.moves, "move");
        said.push(format!("In {} of {moves} no rule could be applied.", count(rejected.nothing)));
    }
    if let Some(unstable) = share(rejected.all_unstable(), rejected.evaluations).filter(|share| *share > 0.02)
    {
        said.push(format!(
            "{} of the evaluations found a candidate for the best that owes its value to errors of the simulation.",
            percent(unstable)
        ));
    }
    said
}
