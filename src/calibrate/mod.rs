//! From the measurements of a workshop's bench to a variant of a grammar that holds them.
//!
//! [`read`] reads them, [`fit`] says what each comes to and whether it fits the grammar, [`variant::text`]
//! writes the variant, and [`page::page`] draws points, fits and residuals.

mod declared;
mod finding;
mod friction;
mod kind;
mod lines;
mod mass;
mod measurements;
mod monotone;
pub mod page;
mod problem;
mod prototype;
pub mod reality;
mod robust;
mod speed;
mod statistics;
#[cfg(test)]
mod tests;
mod thread;
mod torque;
mod trajectory;
pub mod variant;
mod worlds;

use std::collections::BTreeMap;

use grammar_lang::ir::RuleSet;

pub use finding::{Change, Figure, Finding, Plot, Residual, Table};
pub use kind::Kind;
pub use measurements::{Load, Reading, Section, read};
pub use problem::{Location, Problem};

/// What measurements come to, in their order, for a grammar whose declarations they are for.
///
/// # Errors
///
/// All that is wrong, by file and line: what could not be read, and measurements that contradict themselves, each
/// other or the grammar.
pub fn fit(reading: &Reading, rules: &RuleSet) -> Result<Vec<Finding>, Vec<Problem>> {
    let mut findings: Vec<Finding> = Vec::new();
    let mut problems = reading.problems.clone();
    for section in &reading.sections {
        let found = match section.kind {
            Kind::Thread => thread::fit(section, rules).map(|one| vec![one]),
            Kind::Inflate | Kind::Deflate => speed::fit(section, rules).map(|one| vec![one]),
            Kind::Tip => torque::fit(section, rules).map(|one| vec![one]),
            Kind::Mass => mass::fit(section, rules),
            Kind::Friction => friction::fit(section, rules),
            Kind::Prototype => prototype::fit(section, rules),
        };
        match found {
            Ok(found) => findings.extend(found),
            Err(found) => problems.extend(found),
        }
    }
    for finding in &mut findings {
        if let Some(factor) = finding.factor.filter(|factor| !(0.1..=10.0).contains(factor)) {
            let times = if factor > 1.0 { factor } else { 1.0 / factor };
            let times = Figure::of(times, Some(times / 10.0), "");
            let way = if factor > 1.0 { "times" } else { "times less than" };
            finding.warnings.push(format!(
                "`{}` is {times} {way} the value in the grammar ({}): are the units right?",
                finding.quantity,
                finding.old.as_deref().unwrap_or("nothing")
            ));
        }
    }
    for finding in &mut findings {
        if let (Change::Number { value, .. }, Some((low, high))) = (&finding.change, &finding.interval)
            && high.value - low.value > value.value
        {
            finding.warnings.push(format!(
                "the 90 % interval of `{}` is {} to {high}, which is too wide to be useful: take more measurements, or find out what differed between them.",
                finding.quantity,
                low.digits(false)
            ));
        }
    }
    for finding in findings.iter().filter(|finding| !finding.change.is_finite()) {
        problems.push(Problem::contradiction(
            &finding.place,
            format!("`{}` would not be finite: are the units right?", finding.quantity),
        ));
    }
    let mut seen: BTreeMap<&str, &Finding> = BTreeMap::new();
    for finding in &findings {
        if let Some(first) = seen.insert(&finding.quantity, finding) {
            problems.push(Problem::contradiction(
                &finding.place,
                format!(
                    "`{}` is measured twice: in `{}` ({}), too; put all its points into one section",
                    finding.quantity, first.section, first.place
                ),
            ));
        }
    }
    problems.sort_by(|a, b| a.place.cmp(&b.place));
    if problems.is_empty() { Ok(findings) } else { Err(problems) }
}

/// Gives tables other names where theirs are taken: a variant cannot declare what its base does.
pub fn rename(findings: &mut [Finding], is_taken: &dyn Fn(&str) -> bool) {
    for finding in findings {
        if let Change::Table { table, .. } = &mut finding.change {
            while is_taken(&table.name) {
                table.name.push_str("_measured");
            }
        }
    }
}

/// What was measured, as a table for people: the old and the new value, the residual, how many points.
#[must_use]
pub fn summary(findings: &[Finding]) -> String {
    let mut rows = vec![
        ["quantity", "in the grammar", "measured", "90 % interval", "residual rms", "largest", "points"]
            .map(str::to_owned)
            .to_vec(),
    ];
    for finding in findings {
        let dash = || "-".to_owned();
        let residual = finding.residual.as_ref();
        rows.push(vec![
            finding.quantity.clone(),
            finding.old.clone().unwrap_or_else(dash),
            finding.change.shown(),
            finding
                .interval
                .as_ref()
                .map_or_else(dash, |(low, high)| format!("{} .. {high}", low.digits(false))),
            residual.map_or_else(dash, |r| r.rms.to_string()),
            residual.map_or_else(dash, |r| r.largest.to_string()),
            finding.points.to_string(),
        ]);
    }
    let width =
        |i: usize| rows.iter().filter_map(|row| row.get(i)).map(|c| c.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..7).map(width).collect();
    let line = |row: &Vec<String>| {
        let cells: Vec<String> =
            row.iter().zip(&widths).map(|(cell, width)| format!("{cell:width$}")).collect();
        format!("{}\n", cells.join("  ").trim_end())
    };
    rows.iter().map(line).collect()
}
