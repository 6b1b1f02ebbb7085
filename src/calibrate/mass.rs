//! What parts weigh.

use grammar_lang::ir::RuleSet;
use grammar_lang::units::{Dimension, shown};
use indexmap::IndexMap;

use super::declared::{self, Declared};
use super::finding::{Change, Figure, Finding, Plot, Residual};
use super::measurements::Section;
use super::problem::Problem;
use super::robust::Centre;

/// Fits a section of kind `mass`: a finding for each part.
pub(super) fn fit(section: &Section, rules: &RuleSet) -> Result<Vec<Finding>, Vec<Problem>> {
    let parts = declared::parts(rules, section).map_err(|p| vec![p])?;
    let mut weighed: IndexMap<&str, Vec<f64>> = IndexMap::new();
    let mut problems = Vec::new();
    for (row, (name, mass)) in parts.iter().zip(section.numbers("mass")).enumerate() {
        match one(section, rules, row, name, *mass) {
            Ok(mass) => weighed.entry(name).or_default().push(mass),
            Err(problem) if problems.contains(&problem) => {}
            Err(problem) => problems.push(problem),
        }
    }
    if !problems.is_empty() {
        return Err(problems);
    }
    weighed.into_iter().map(|(name, masses)| finding(section, rules, name, &masses)).collect()
}

/// No scale on a bench shows less, kg.
const LEAST: f64 = 1e-9;

/// The mass that a row gives to a part, or to one segment of an actuator.
fn one(section: &Section, rules: &RuleSet, row: usize, name: &str, mass: f64) -> Result<f64, Problem> {
    // What the whole section is for is said in another line.
    let said = section.setting("for").filter(|_| section.words("part").is_empty());
    let declared = declared::part(rules, name, said.map_or_else(|| section.place(row), |(_, place)| place))?;
    if mass < LEAST {
        return Err(Problem::contradiction(
            section.place(row),
            format!("the mass of `{name}` is zero here, or below a microgram"),
        ));
    }
    let segments = section.numbers("segments").get(row).copied();
    match declared {
        // A table of both has a number for each.
        Declared::Part(_) => match segments.filter(|segments| *segments > 1.0) {
            Some(segments) => Err(Problem::contradiction(
                section.place(row),
                format!(
                    "`{name}` is not an actuator, so it cannot have {segments} segments: weigh one part by itself, and write 1"
                ),
            )),
            None => Ok(mass),
        },
        Declared::Actuator(_) => match segments {
            Some(segments) if segments >= 1.0 && segments.fract() == 0.0 => Ok(mass / segments),
            Some(segments) => Err(Problem::contradiction(
                section.place(row),
                format!(
                    "`{name}` cannot have {segments} segments: write a whole number of segments, 1 or more"
                ),
            )),
            None => Err(Problem::unreadable(
                section.place(row),
                format!(
                    "`{name}` is an actuator, and its `mass` is that of one segment: add a column `segments` with the number of segments"
                ),
            )),
        },
    }
}

fn finding(section: &Section, rules: &RuleSet, name: &str, masses: &[f64]) -> Result<Finding, Vec<Problem>> {
    let declared = declared::part(rules, name, &section.place).map_err(|p| vec![p])?;
    let old = declared.mass().ok_or_else(|| vec![declared::varies(name, "mass", &section.place)])?;
    let many = masses.len();
    let centre = Centre::of(masses, &format!("{} {name}", section.name));
    let mean = centre.value;
    let value = Figure::of(mean, centre.error(), "g");
    let mut notes = Vec::new();
    if matches!(declared, Declared::Actuator(_)) {
        notes.push("The mass of one segment: the weighed mass divided by the number of segments.".to_owned());
    }
    let points = masses.iter().enumerate().map(|(i, m)| (i as f64 + 1.0, m * 1e3, 0));
    let plot = Plot {
        title: format!("Mass of `{name}`"),
        x: "weighing".into(),
        y: "mass (g)".into(),
        fit: vec![(vec![(1.0, mean * 1e3), (many as f64, mean * 1e3)], 0)],
        rows: Vec::new(),
        unit: "g".into(),
        residuals: masses.iter().enumerate().map(|(i, m)| (i as f64 + 1.0, (m - mean) * 1e3, 0)).collect(),
        points: points.collect(),
    };
    let residuals: Vec<f64> = masses.iter().map(|m| m - mean).collect();
    Ok(Finding {
        section: section.name.clone(),
        place: section.place.clone(),
        source: section.source.clone(),
        quantity: format!("{name}.mass"),
        old: Some(shown(old, Dimension::MASS)),
        change: Change::Number { path: format!("{name}.mass"), value },
        interval: centre.figures("g"),
        factor: Some(mean / old),
        residual: Residual::of(&residuals, "g").filter(|_| many > 1),
        points: many,
        notes,
        warnings: centre.warnings(&section.name, &format!("{name}, weighing"), |i| {
            shown(masses.get(i).copied().unwrap_or(0.0), Dimension::MASS)
        }),
        plots: if many > 1 { vec![plot] } else { Vec::new() },
    })
}
