//! What was run, and what came of each run.

use std::collections::BTreeSet;

use grammar_lang::ir::{Objective, RuleSet, Schedule, SearchMethod};
use grammar_lang::source::SourceMap;

use super::words::{count, counted, number, or_dash, paragraph, percent, table, value};
use super::{Link, heading, told};
use crate::markup::escape;
use crate::results::elsewhere::Tested;
use crate::results::report::gather::runs::{Pairs, pairs, spread};
use crate::results::report::read::{Group, Run};

/// The place of the column that says how a design does in other worlds.
const TESTED: usize = 2;

pub(super) fn section(groups: &[Group], link: Link) -> String {
    let asked: String = groups
        .iter()
        .enumerate()
        .map(|(i, group)| format!("<div>{}{}</div>\n", heading(groups, i), facts(group)))
        .collect();
    let several = groups.len() > 1;
    let seen: String = groups.iter().map(|group| told(groups, group, &said(group))).collect();
    let words = seen + &paragraph(&compared(groups));
    let mut head = vec![
        "#seed",
        "#best value",
        "#evaluations",
        "#moves",
        "#found at evaluation",
        "#parts",
        "#actuators",
        "#checks kept",
        "why it ended",
    ];
    // Who was tested in no worlds has nothing to show there.
    let is_tested = groups.iter().flat_map(|group| &group.runs).any(|run| run.tested().is_some());
    if is_tested {
        head.insert(TESTED, "#nine of ten other worlds");
    }
    if several {
        head.insert(0, "group");
    }
    let rows: Vec<Vec<String>> = groups
        .iter()
        .flat_map(|group| group.runs.iter().map(move |run| (group, run)))
        .map(|(group, run)| {
            let mut cells = cells(group, run, link);
            if is_tested {
                let shown = run.tested().and_then(|tested| match tested {
                    Tested::Each(each) => Some(value(each.tenth?, &group.unit)),
                    Tested::Whole(whole) => Some(format!("{} over all", value(whole?, &group.unit))),
                });
                cells.insert(TESTED, or_dash(shown));
            }
            if several {
                cells.insert(0, escape(&group.name));
            }
            cells
        })
        .collect();
    format!("<div class=\"asked\">{asked}</div>\n{}{}{}", table(&head, &rows), together(groups), words)
}

/// What a group was asked.
fn facts(group: &Group) -> String {
    let Some(first) = group.runs.first() else { return String::new() };
    let asked = &first.asked;
    let code = |text: &str| format!("<code>{}</code>", escape(text));
    let mut facts = vec![("grammar", format!("{}, from {}", escape(&asked.grammar), code(&asked.entry)))];
    match &group.rules {
        Ok(rules) => facts.extend(of_rules(&rules.0, &rules.1)),
        Err(why) => facts.push(("rules", format!("not shown: {}", escape(&why.to_string())))),
    }
    facts.push(("runs", format!("{}, {}", group.runs.len(), seeds(group))));
    facts.push(("bound", bound(group, asked.time.as_deref())));
    facts.push(("solver", escape(&asked.solver)));
    if let Some(from) = &asked.from {
        facts.push(("started from", format!("the example {}", escape(from))));
    }
    if let Some(design) = &asked.design {
        facts.push(("started from", format!("the saved design {}", code(design))));
    }
    if !asked.parameters.is_empty() {
        let all: Vec<String> =
            asked.parameters.iter().map(|(name, text)| code(&format!("{name}={text}"))).collect();
        facts.push(("parameters", all.join(" ")));
    }
    let mut versions: Vec<&str> = group.runs.iter().map(|run| run.asked.sgc.as_str()).collect();
    versions.dedup();
    facts.push(("sgc", escape(&versions.join(", "))));
    facts.push(("folder", code(&group.path.display().to_string())));
    let facts: String =
        facts.into_iter().map(|(name, text)| format!("<div><dt>{name}</dt><dd>{text}</dd></div>")).collect();
    format!("<dl>{facts}</dl>\n")
}

/// What bounded the runs of a group. One that went on may have been given another bound than it began with.
fn bound(group: &Group, time: Option<&str>) -> String {
    let bounds: Vec<Option<u64>> = group.runs.iter().map(Run::max_evals).collect();
    let evaluations =
        match (bounds.first().copied().flatten(), bounds.iter().all(|b| Some(b) == bounds.first())) {
            (Some(n), true) => Some(format!("{} each", counted(n, "evaluation"))),
            (None, true) => None,
            (_, false) => {
                let told = bounds.iter().map(|b| b.map_or("none".to_owned(), |n| n.to_string()));
                Some(format!(
                    "not the same for all runs: {} evaluations",
                    told.collect::<Vec<_>>().join(", ")
                ))
            }
        };
    match (evaluations, time) {
        (Some(evaluations), Some(time)) => format!("{evaluations}, or {}", escape(time)),
        (Some(evaluations), None) => evaluations,
        (None, Some(time)) => escape(time),
        (None, None) => "that of the search's schedule".to_owned(),
    }
}

/// The seeds of a group: a row of them as its ends.
fn seeds(group: &Group) -> String {
    let seeds: Vec<u64> = group.runs.iter().map(|run| run.asked.seed).collect();
    match seeds.as_slice() {
        [only] => format!("seed {only}"),
        [first, .., last] if seeds.windows(2).all(|pair| pair[1] == pair[0] + 1) => {
            format!("seeds {first} to {last}")
        }
        _ => format!("seeds {}", seeds.iter().map(u64::to_string).collect::<Vec<_>>().join(", ")),
    }
}

/// What the grammar asks of the search.
fn of_rules(rules: &RuleSet, sources: &SourceMap) -> Vec<(&'static str, String)> {
    let goal = |objective: &Objective| {
        let text = sources.slice(objective.value.span);
        // The unit stands in the text, unless a variant has set it.
        let unit = match objective.unit.as_str() {
            unit if unit.is_empty() || text.ends_with(unit) => String::new(),
            unit => format!(" in {unit}"),
        };
        format!("<code>{}</code>", escape(&format!("{} {text}{unit}", objective.direction)))
    };
    let goals: Vec<String> = rules.objectives().map(goal).collect();
    let mut facts = vec![(if goals.len() > 1 { "objectives" } else { "objective" }, goals.join(", "))];
    let tasks: Vec<&str> =
        rules.tasks.keys().map(String::as_str).filter(|name| *name != RuleSet::ONLY_TASK).collect();
    if !tasks.is_empty() {
        facts.push(("tasks", escape(&tasks.join(", "))));
    }
    let looped = |(schedule, method): (&Schedule, SearchMethod<'_>)| {
        let text =
            |expr: &grammar_lang::ir::Expr| format!("<code>{}</code>", escape(sources.slice(expr.span)));
        let chains = match method.chains() {
            0 | 1 => String::new(),
            n => format!(" in {n} chains"),
        };
        let how = match method.temperature() {
            Some(temperature) => format!("temperature {}", text(temperature)),
            None => method.about().to_owned(),
        };
        format!(
            "{} iterations of {} moves{chains}, {how}, stop {}",
            text(&schedule.iterations),
            text(&schedule.moves),
            text(&schedule.stop)
        )
    };
    facts.push(("search", escape(&rules.search.name)));
    match &rules.search.bodies {
        Some(bodies) => facts.push(("bodies", looped((&bodies.schedule, bodies.method())))),
        None => facts.push(("bodies", "not searched: the initial design alone".to_owned())),
    }
    match &rules.search.curves {
        Some(curves) => facts.push(("gaits", looped((&curves.schedule, curves.method())))),
        None => facts.push(("gaits", "not searched: one evaluation a body".to_owned())),
    }
    facts
}

fn cells(group: &Group, run: &Run, link: Link) -> Vec<String> {
    let found = run.found();
    let seed = run.asked.seed.to_string();
    let seed = match link(&run.path) {
        Some(address) => format!("<a href=\"{}\">{seed}</a>", escape(&address)),
        None => seed,
    };
    let kept = run.checks().map(|(kept, all)| {
        let class = if kept == all { "good" } else { "odd" };
        format!("<span class=\"{class}\">{kept} of {all}</span>")
    });
    vec![
        seed,
        or_dash(run.value().map(|best| value(best, &group.unit))),
        count(run.evaluations()),
        or_dash(run.moves.last().map(|m| count(m.number))),
        or_dash(found.map(|m| count(m.evaluations))),
        or_dash(found.map(|m| m.parts.to_string())),
        or_dash(found.map(|m| m.actuators.to_string())),
        or_dash(kept),
        escape(run.standing.text()),
    ]
}

/// The groups as wholes.
fn together(groups: &[Group]) -> String {
    if groups.iter().all(|group| group.runs.len() < 2) && groups.len() < 2 {
        return String::new();
    }
    let head = ["best values of", "#runs", "#best", "#mean", "#median", "#sd", "#lowest", "#highest"];
    let rows: Vec<Vec<String>> = groups
        .iter()
        .filter_map(|group| {
            let spread = spread(group)?;
            let best = group.direction.better(spread.min, spread.max);
            let of = |x: f64| value(x, &group.unit);
            let sd = or_dash(spread.sd.map(of));
            let name = escape(&group.name);
            Some(vec![
                name,
                spread.count.to_string(),
                of(best),
                of(spread.mean),
                of(spread.median),
                sd,
                of(spread.min),
                of(spread.max),
            ])
        })
        .collect();
    if rows.is_empty() { String::new() } else { table(&head, &rows) }
}

/// What is seen of a group, in words.
fn said(group: &Group) -> Vec<String> {
    let mut said = Vec::new();
    let without =
        group.runs.iter().filter(|run| !run.moves.is_empty() && run.value().is_none()).count() as u64;
    if without > 0 {
        said.push(format!("{} found no valid design so far.", counted(without, "run")));
    }
    if let Some(spread) = spread(group).filter(|spread| spread.count > 2)
        && let Some(sd) = spread.sd
        && sd > 0.5 * spread.mean.abs()
    {
        said.push(format!(
            "The standard deviation is {} of the mean: results differ much from seed to seed, and a few runs are not enough to compare.",
            percent(sd / spread.mean.abs().max(f64::MIN_POSITIVE))
        ));
    }
    let checked: Vec<(usize, usize)> =
        group.runs.iter().filter_map(Run::checks).filter(|(_, all)| *all > 0).collect();
    let held = checked.iter().filter(|(kept, all)| kept == all).count();
    if !checked.is_empty() {
        let silent: Vec<Vec<String>> =
            group.runs.iter().map(Run::silent_checks).filter(|names| !names.is_empty()).collect();
        if silent.is_empty() {
            said.push(format!(
                "{held} of {} best designs kept their value in all cross-checks (finer simulation, ice, other solvers, and one quantity changed by a tenth).",
                checked.len()
            ));
        } else {
            let names: BTreeSet<&String> = silent.iter().flatten().collect();
            let names: Vec<&str> = names.into_iter().map(String::as_str).collect();
            said.push(format!(
                "{held} of {} best designs kept their value in all cross-checks that apply to them. For {} of them, these cross-checks do not apply: {}.",
                checked.len(),
                silent.len(),
                names.join(", ")
            ));
        }
    }
    said
}

/// The objective of a group as its grammar writes it.
fn objective(group: &Group) -> Option<String> {
    let (rules, sources) = &**group.rules.as_ref().ok()?;
    let written = |objective: &Objective| {
        sources.slice(objective.value.span).split_whitespace().collect::<Vec<_>>().join(" ")
    };
    Some(rules.first_task()?.objectives().map(written).collect::<Vec<_>>().join(", "))
}

/// What is seen of groups side by side, in words.
fn compared(groups: &[Group]) -> Vec<String> {
    let mut said = Vec::new();
    let wanted: Vec<String> = groups.iter().filter_map(objective).collect();
    if let Some((first, others)) = wanted.split_first()
        && others.iter().any(|other| other != first)
    {
        let each = groups
            .iter()
            .zip(&wanted)
            .map(|(group, text)| format!("{}: <code>{}</code>", escape(&group.name), escape(text)));
        said.push(format!(
            "The objectives differ ({}), so the values are not comparable.",
            each.collect::<Vec<_>>().join("; ")
        ));
    }
    for (i, one) in groups.iter().enumerate() {
        for other in groups.iter().skip(i + 1) {
            // Of a single pair the table says it all.
            if one.runs.len() * other.runs.len() < 2 {
                continue;
            }
            let Some(Pairs { better, even }) = pairs(one, other) else { continue };
            said.push(format!(
                "Of all pairs of runs, one of each group, {} is better than {} in {}{}{}.",
                escape(&one.name),
                escape(&other.name),
                percent(better),
                if even > 0.0 { format!(", and equal in {}", percent(even)) } else { String::new() },
                // As if a coin decided even pairs.
                if (0.4..=0.6).contains(&(better + 0.5 * even)) { ": hardly a difference" } else { "" }
            ));
        }
    }
    if let [one, other] = groups
        && groups.iter().all(|group| group.outcomes().iter().all(Option::is_some))
        && let (Some(a), Some(b)) = (spread(one), spread(other))
        && a.mean > 0.0
        && b.mean > 0.0
    {
        let factor = if a.mean > b.mean { a.mean / b.mean } else { b.mean / a.mean };
        let (more, less) = if a.mean > b.mean { (one, other) } else { (other, one) };
        said.push(format!(
            "The mean of {} is {} times that of {}.",
            escape(&more.name),
            number(factor),
            escape(&less.name)
        ));
    }
    said
}
