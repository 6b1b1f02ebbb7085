//! What each rule did, drawn.

use grammar_lang::ir::Direction;

use super::chart::{Chart, Scale, hint, line};
use super::words::{count, counted, figures, key, or_dash, percent, table, value};
use super::{Link, axis, colour, heading, told};
use crate::markup::escape;
use crate::results::report::gather::rules::{Rule, rules};
use crate::results::report::gather::spread::{Spread, share};
use crate::results::report::read::Group;

pub(super) fn section(groups: &[Group], _: Link) -> String {
    let all: Vec<Vec<Rule>> = groups.iter().map(rules).collect();
    if all.iter().flatten().all(|rule| rule.drawn() == 0) {
        return "<p>No rule was drawn.</p>\n".to_owned();
    }
    let spreads = || all.iter().flatten();
    let every = scale(spreads().filter_map(|rule| rule.change));
    let accepted = scale(spreads().filter_map(|rule| rule.accepted_change));
    let marks = [("box", "quartiles, and a line from 5 % to 95 %"), ("bar", "median"), ("point", "mean")];
    let marks = marks.map(|(class, text)| (class.to_owned(), text.to_owned()));
    let mut out = "<p>The change of the value by one application: the value of the new design minus that of the current design from which it was made.</p>\n".to_owned();
    out += &key(&marks);
    for (i, (group, rules)) in groups.iter().zip(&all).enumerate() {
        out += &heading(groups, i);
        out += &figures(&[
            effects(group, rules, i, every, ("all applications", |rule| rule.change)),
            effects(group, rules, i, accepted, ("those that were accepted", |rule| rule.accepted_change)),
        ]);
        out += &counts(rules);
        out += &told(groups, group, &said(group, rules));
    }
    out + NOTE
}

/// What of a rule is drawn, and its name.
type Of = (&'static str, fn(&Rule) -> Option<Spread>);

/// A scale for all that is drawn of some rules.
fn scale(spreads: impl Iterator<Item = Spread>) -> Scale {
    Scale::of(spreads.flat_map(|s| [s.low, s.high, s.mean]).chain([0.0]), 7)
}

fn effects(group: &Group, rules: &[Rule], index: usize, scale: Scale, (what, of): Of) -> String {
    let names: Vec<String> = rules.iter().map(|rule| rule.name.clone()).collect();
    let better = match group.direction {
        Direction::Maximize => "right is better",
        Direction::Minimize => "left is better",
    };
    let label = axis(&format!("change of the value, {better}"), Some(group));
    let mut chart = Chart::rows(what, &names, 32.0, (scale, &label));
    for (i, rule) in rules.iter().enumerate() {
        let Some(spread) = of(rule) else { continue };
        let told = format!(
            "{}, {what}: {}, mean {}, median {}, quartiles {} and {}",
            rule.name,
            counted(spread.count as u64, "application"),
            value(spread.mean, &group.unit),
            value(spread.median, &group.unit),
            value(spread.q1, &group.unit),
            value(spread.q3, &group.unit)
        );
        let mark = boxed(&chart, &spread, chart.y(i as f64 + 0.5), &colour(index), &told);
        chart.add(&mark);
    }
    chart.finish(&format!("change of the value by rule, {what}"))
}

fn boxed(chart: &Chart, spread: &Spread, y: f64, class: &str, told: &str) -> String {
    let x = |v| chart.x(v);
    let width = (x(spread.q3) - x(spread.q1)).max(1.0);
    let (left, mean) = (x(spread.q1), x(spread.mean));
    format!(
        "<g class=\"{class}\">{}{}<rect class=\"box\" x=\"{left:.1}\" y=\"{:.1}\" width=\"{width:.1}\" height=\"12\"/>{}<circle class=\"mean\" cx=\"{mean:.1}\" cy=\"{y:.1}\" r=\"3.2\"/></g>",
        hint(told),
        line((x(spread.low), y), (x(spread.high), y), "whisker"),
        y - 6.0,
        line((x(spread.median), y - 8.0), (x(spread.median), y + 8.0), "median"),
    )
}

fn counts(rules: &[Rule]) -> String {
    let sum = |of: fn(&Rule) -> u64| rules.iter().map(of).sum::<u64>();
    let (applied, way, best) = (sum(|r| r.applied), sum(|r| r.on_the_way), sum(|r| r.in_best));
    let part = |n: u64, all: u64| or_dash(share(n, all).map(percent));
    let both = |n: u64, all: u64| {
        if all == 0 { "–".to_owned() } else { format!("{} <small>{}</small>", count(n), part(n, all)) }
    };
    let rows: Vec<Vec<String>> = rules
        .iter()
        .map(|rule| {
            vec![
                escape(&rule.name),
                count(rule.drawn()),
                both(rule.blocked, rule.drawn()),
                both(rule.applied, applied),
                both(rule.accepted, rule.applied),
                both(rule.improved, rule.known()),
                both(rule.on_the_way, way),
                both(rule.in_best, best),
            ]
        })
        .collect();
    let head = [
        "rule",
        "#drawn",
        "#blocked",
        "#applied",
        "#accepted",
        "#improved",
        "#on the way to the best",
        "#steps in the best",
    ];
    table(&head, &rows)
}

const NOTE: &str = "<p class=\"small\">Shares: blocked, of the draws; applied, of all applications; accepted, of this rule's applications; improved, of those of which the change is known; the last two, of all rules together. “On the way” counts the accepted applications before a run found its best, also those that were taken back later; “steps in the best” counts the steps of the saved designs, which no longer contain a step that was reverted, nor the step that reverted it.</p>\n";

/// Rules with fewer applications say nothing of a share.
const ENOUGH: u64 = 20;

/// What is seen, in words.
fn said(group: &Group, rules: &[Rule]) -> Vec<String> {
    let mut said = Vec::new();
    let sum = |of: fn(&Rule) -> u64| rules.iter().map(of).sum::<u64>();
    if let Some(better) = share(sum(|r| r.improved), sum(Rule::known)) {
        said.push(format!("{} of the applications made the design better.", percent(better)));
    }
    let means: Vec<f64> = rules.iter().filter_map(|r| r.change).map(|s| group.fitness(s.mean)).collect();
    if !means.is_empty() && means.iter().all(|mean| *mean < 0.0) {
        said.push("On average every rule makes it worse.".to_owned());
    }
    let share_of = |rule: &Rule| share(rule.improved, rule.known()).unwrap_or(0.0);
    let most =
        rules.iter().filter(|r| r.known() >= ENOUGH).max_by(|a, b| share_of(a).total_cmp(&share_of(b)));
    if let Some(most) = most.filter(|most| most.improved > 0) {
        said.push(format!(
            "{} improves most often ({}; of the rules with {ENOUGH} applications or more).",
            escape(&most.name),
            percent(share_of(most))
        ));
    }
    let (applied, way) = (sum(|r| r.applied), sum(|r| r.on_the_way));
    for rule in rules {
        let (Some(all), Some(led)) = (share(rule.applied, applied), share(rule.on_the_way, way)) else {
            continue;
        };
        if way >= ENOUGH && all > 0.02 && (led > 1.5 * all || led < all / 1.5) {
            said.push(format!(
                "{} occurs on the way to the best {} often than among all applications ({} against {}).",
                escape(&rule.name),
                if led > all { "more" } else { "less" },
                percent(led),
                percent(all)
            ));
        }
    }
    let never: Vec<String> = rules.iter().filter(|r| r.applied == 0).map(|r| escape(&r.name)).collect();
    if !never.is_empty() {
        said.push(format!("Never applied: {}.", never.join(", ")));
    }
    let lost = group.runs.iter().filter(|run| matches!(run.design, Some(Err(_)))).count() as u64;
    if lost > 0 {
        let whose = if lost == 1 { "its" } else { "their" };
        said.push(format!(
            "{} cannot be read, and {whose} steps are not counted.",
            counted(lost, "best design")
        ));
    }
    said
}
