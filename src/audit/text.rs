//! An audit as text for people, in columns.

use std::fmt::Write;

use super::depths::{Counted, Depth};
use super::sizes::Sizes;
use super::walks::{Requirements, Rules};
use super::{Answer, Audit};

/// How wide the longest bar of a histogram is.
const BAR: usize = 40;
/// How many bars a histogram has at most.
const BARS: usize = 12;

/// The report of an audit.
#[must_use]
pub fn report(audit: &Audit) -> String {
    let mut out = format!(
        "audit of {}: {} walks of {} moves, seed {}, temperature {}\n",
        audit.grammar, audit.walks, audit.steps, audit.seed, audit.temperature
    );
    rules(&mut out, &audit.rules);
    requirements(&mut out, &audit.requirements);
    preferences(&mut out, &audit.preferences);
    out.push_str("\nsizes at the ends of the walks\n");
    sizes(&mut out, "parts", &audit.parts);
    sizes(&mut out, "actuators", &audit.actuators);
    depths(&mut out, &audit.depths);
    out
}

fn widest<'a>(names: impl Iterator<Item = &'a str>, title: &str) -> usize {
    names.map(|n| n.chars().count() + 2).chain([title.len()]).max().unwrap_or(0)
}

// Writing to a String never fails.
fn line(out: &mut String, text: &str) {
    let _ = writeln!(out, "{}", text.trim_end());
}

fn rules(out: &mut String, rules: &[Rules]) {
    let width = widest(rules.iter().map(|r| r.name.as_str()), "rules");
    let title = "rules";
    line(out, &format!("\n{title:width$}  {:>8}  {:>8}  stopped by", "drawn", "applied"));
    for rule in rules {
        let name = format!("  {}", rule.name);
        line(out, &format!("{name:width$}  {:>8}  {:>8}  {}", rule.drawn, rule.applied, stopped(rule)));
    }
}

/// What stopped a rule; in a sentence if it was never applied.
fn stopped(rule: &Rules) -> String {
    let all: Vec<String> = rule.stopped.iter().map(|s| format!("{} {}", s.by, s.times)).collect();
    let list = all.join(", ");
    match rule.stopped.first() {
        _ if rule.drawn == 0 => "never drawn".to_owned(),
        Some(only) if rule.applied == 0 && rule.stopped.len() == 1 => match &only.requirement {
            Some(name) => format!("never applied: every application breaks `{name}`"),
            None => format!("never applied: {}, every time", only.by),
        },
        Some(_) if rule.applied == 0 => {
            let most = rule.stopped.iter().find_map(|s| s.requirement.as_ref());
            let most = most.map_or(String::new(), |name| format!("stopped most by `{name}`; "));
            format!("never applied: {most}{list}")
        }
        _ => list,
    }
}

fn requirements(out: &mut String, requirements: &[Requirements]) {
    if requirements.is_empty() {
        return;
    }
    let width = widest(requirements.iter().map(|r| r.name.as_str()), "requirements");
    let title = "requirements";
    line(out, &format!("\n{title:width$}  {:>8}", "stopped"));
    for r in requirements {
        let name = format!("  {}", r.name);
        let note = if r.stopped == 0 { "  never stopped anything" } else { "" };
        line(out, &format!("{name:width$}  {:>8}{note}", r.stopped));
    }
}

fn preferences(out: &mut String, preferences: &[(String, usize, usize)]) {
    if preferences.is_empty() {
        return;
    }
    let width = widest(preferences.iter().map(|(n, ..)| n.as_str()), "preferences");
    let title = "preferences";
    line(out, &format!("\n{title:width$}  fulfilled"));
    for (name, yes, of) in preferences {
        let name = format!("  {name}");
        let share = 100.0 * *yes as f64 / (*of).max(1) as f64;
        line(out, &format!("{name:width$}  {share:>7.1} %  {yes} of {of} designs"));
    }
}

fn sizes(out: &mut String, what: &str, sizes: &Sizes) {
    line(out, &format!("  {what}: min {}, mean {:.1}, max {}", sizes.min, sizes.mean, sizes.max));
    let bins = sizes.bins(BARS);
    let most = bins.iter().map(|(.., n)| *n).max().unwrap_or(0).max(1);
    for (low, high, n) in bins {
        let range = if low == high { format!("{low}") } else { format!("{low} .. {high}") };
        // Whatever is there is seen.
        let bar = "#".repeat((n * BAR).div_ceil(most));
        line(out, &format!("    {range:>10}  {n:>6}  {bar}"));
    }
}

fn depths(out: &mut String, depths: &[Depth]) {
    line(out, "\nnumber of different designs after each number of moves");
    line(out, &format!("  {:>5}  {:>9}", "moves", "designs"));
    for depth in depths {
        let how = match depth.counted {
            Counted::All => "all there are",
            Counted::AtLeast if depth.designs == 0 => "none found within the allowed tries",
            Counted::AtLeast => "at least",
            Counted::Walks => "seen in the walks",
        };
        line(out, &format!("  {:>5}  {:>9}  {how}", depth.moves, depth.designs));
    }
}

/// Whether a body can be made; `steps` are those of the derivation that was found, in words.
#[must_use]
pub fn answer(name: &str, answer: &Answer, steps: &[String]) -> String {
    let mut out = String::new();
    let reasons = match answer {
        Answer::Yes(made) => {
            let how = if made.own_steps { "by its own steps" } else { "in another way" };
            line(&mut out, &format!("\n{name}: can be made, {how}"));
            for (i, step) in steps.iter().enumerate() {
                line(&mut out, &format!("  {:>2}. {step}", i + 1));
            }
            return out;
        }
        Answer::No(reasons) => {
            line(&mut out, &format!("\n{name}: cannot be made"));
            reasons
        }
        Answer::Open(reasons) => {
            line(&mut out, &format!("\n{name}: undecided, no derivation was found"));
            reasons
        }
    };
    reasons.iter().for_each(|reason| line(&mut out, &format!("  {reason}")));
    out
}
