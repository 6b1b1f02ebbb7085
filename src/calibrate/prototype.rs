//! Robots that were built: what they did beside what a simulation said.

use grammar_lang::diagnostics::did_you_mean;
use grammar_lang::ir::{Backend, RuleSet};

use super::finding::{Change, Figure, Finding, Plot};
use super::measurements::Section;
use super::problem::{Problem, listed};
use super::reality::{Built, predict};
use crate::document::is_name;

/// The kinds of robots that can be built.
const BUILDS: &[&str] = Backend::NAMES;

/// Reads a section of kind `prototype`: a finding for each robot.
pub(super) fn fit(section: &Section, rules: &RuleSet) -> Result<Vec<Finding>, Vec<Problem>> {
    let (names, builds) = (section.words("name"), section.words("build"));
    let (simulated, measured) = (section.numbers("simulated"), section.numbers("measured"));
    let lengths = section.numbers("length");
    let problems = problems(section, rules);
    if !problems.is_empty() {
        return Err(problems);
    }
    let mut findings = Vec::new();
    let rows = names.iter().zip(builds).zip(simulated.iter().zip(measured)).enumerate();
    for (row, ((name, build), (simulated, measured))) in rows {
        let length = lengths.get(row).map(|length| Figure::as_written(*length, "mm"));
        findings.push(Finding {
            section: section.name.clone(),
            place: section.place(row).clone(),
            source: section.source.clone(),
            quantity: format!("prototype {name}"),
            old: None,
            change: Change::Prototype {
                name: name.clone(),
                build: build.clone(),
                simulated: Figure::as_written(*simulated, "m/h"),
                measured: Figure::as_written(*measured, "m/h"),
                length,
            },
            interval: None,
            factor: None,
            residual: None,
            points: 1,
            notes: Vec::new(),
            warnings: Vec::new(),
            plots: Vec::new(),
        });
    }
    if let Some(first) = findings.first_mut() {
        first.plots.push(plot(section));
    }
    for build in BUILDS.iter().copied() {
        let rows = names.iter().zip(builds).zip(simulated.iter().zip(measured)).enumerate();
        let built: Vec<Built> = rows
            .filter(|(_, ((_, own), _))| *own == build)
            .map(|(row, ((name, _), (s, m)))| Built {
                name: name.clone(),
                simulated: *s,
                measured: *m,
                length: lengths.get(row).copied(),
            })
            .collect();
        let last = findings
            .iter_mut()
            .rfind(|f| matches!(&f.change, Change::Prototype { build: b, .. } if b == build));
        if let (Some(last), Some(told)) = (last, predict(&built, 1.0)) {
            let within = told.ratio.interval.map_or_else(
                || "; one prototype does not show how much prototypes differ".to_owned(),
                |(low, high)| {
                    format!("; with a probability of 90 %, the next one will reach {low:.2} .. {high:.2}")
                },
            );
            last.notes.push(format!(
                "Of the kind {build}, {} reached {:.2} of the simulated speed on average{within}.",
                match told.prototypes.len() {
                    1 => "the only robot".to_owned(),
                    several => format!("{several} robots"),
                },
                told.ratio.speed
            ));
            if told.constant.is_some() {
                last.notes.push(
                    "One speed for all robots fits them better than a share of the simulated speed: `sgc eval` prints both."
                        .to_owned(),
                );
            }
            if !told.repeated.is_empty() {
                last.notes.push(format!(
                    "Not counted, because another robot has the same numbers: {}.",
                    told.repeated.join(", ")
                ));
            }
        }
    }
    Ok(findings)
}

fn factor(unit: &str) -> f64 {
    grammar_lang::units::parse(unit).map_or(1.0, |u| u.factor)
}

fn problems(section: &Section, rules: &RuleSet) -> Vec<Problem> {
    let mut problems = Vec::new();
    let names = section.words("name");
    for (row, name) in names.iter().enumerate() {
        if !is_name(name) {
            problems.push(Problem::unreadable(
                section.place(row),
                format!("`{name}` cannot name a prototype: a name is a word of letters, digits and `_` that does not begin with a digit"),
            ));
        } else if rules.prototypes.contains_key(name) {
            problems.push(Problem::contradiction(
                section.place(row),
                format!("the grammar already has a prototype `{name}`: give this one another name"),
            ));
        } else if let Some(first) = names.iter().position(|n| n == name).filter(|first| *first < row) {
            problems.push(Problem::contradiction(
                section.place(row),
                format!("there are two prototypes `{name}`; the first is in {}", section.place(first)),
            ));
        }
    }
    for (row, build) in section.words("build").iter().enumerate() {
        if !BUILDS.contains(&build.as_str()) {
            let help = did_you_mean(build, BUILDS.iter().copied())
                .unwrap_or_else(|| format!("the kinds are {}", listed(BUILDS)));
            problems.push(Problem::unreadable(
                section.place(row),
                format!("there is no kind of robot `{build}`: {help}"),
            ));
        }
    }
    for column in ["simulated", "measured", "length"] {
        for (row, value) in section.numbers(column).iter().enumerate() {
            if *value <= 0.0 {
                let name = names.get(row).map_or("", String::as_str);
                problems.push(Problem::contradiction(
                    section.place(row),
                    format!("`{column}` of `{name}` must be above 0"),
                ));
            }
        }
    }
    problems
}

/// Measured over simulated speeds, with a line through 0 for what each kind comes to.
fn plot(section: &Section) -> Plot {
    let hour = factor("m/h");
    let (simulated, measured) = (section.numbers("simulated"), section.numbers("measured"));
    let builds = section.words("build");
    let rows: Vec<(f64, f64, usize)> = builds
        .iter()
        .zip(simulated.iter().zip(measured))
        .filter_map(|(build, (s, m))| Some((s / hour, m / hour, BUILDS.iter().position(|b| b == build)?)))
        .collect();
    let most = rows.iter().map(|row| row.0).fold(0.0, f64::max);
    let lines = (0..BUILDS.len()).filter_map(|build| {
        let pairs = rows.iter().filter(|r| r.2 == build).enumerate();
        // Here each point is drawn, and none has a length.
        let robots: Vec<Built> = pairs
            .map(|(i, r)| Built {
                name: i.to_string(),
                simulated: r.0,
                measured: r.1,
                length: Some(i as f64),
            })
            .collect();
        Some((vec![(0.0, 0.0), (most, predict(&robots, most)?.ratio.speed)], build))
    });
    Plot {
        title: "Prototypes: pneumatic in the first colour, tendon in the second".into(),
        x: "simulated (m/h)".into(),
        y: "measured (m/h)".into(),
        fit: lines.collect(),
        points: rows,
        ..Plot::default()
    }
}
