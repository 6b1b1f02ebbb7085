//! The torque of an actuator, from the force at its tip.

use grammar_lang::ir::RuleSet;
use grammar_lang::units::{Dimension, shown};

use super::declared;
use super::finding::{Change, Figure, Finding, Plot, Residual};
use super::measurements::Section;
use super::problem::Problem;
use super::robust::Centre;
use super::statistics::{mean_and_deviation, slope};

/// A torque that changes by more than this share of its mean over the angles depends on the angle.
const STRONG: f64 = 0.25;

/// Fits a section of kind `tip`: force times arm.
pub(super) fn fit(section: &Section, rules: &RuleSet) -> Result<Finding, Vec<Problem>> {
    let (name, actuator) = declared::actuator(rules, section).map_err(|p| vec![p])?;
    let old = actuator.motor.effort.fixed().copied();
    let old = old.ok_or_else(|| vec![declared::varies(&name, "torque", &section.place)])?;
    let (forces, arms) = (section.numbers("force"), section.numbers("arm"));
    let problems: Vec<Problem> = forces
        .iter()
        .zip(arms)
        .enumerate()
        .filter(|(_, (force, arm))| **force <= 0.0 || **arm <= 0.0)
        .map(|(row, _)| Problem::contradiction(section.place(row), "`force` and `arm` must be above 0"))
        .collect();
    if !problems.is_empty() {
        return Err(problems);
    }
    let torques: Vec<f64> = forces.iter().zip(arms).map(|(force, arm)| force * arm).collect();
    let (_, deviation) = mean_and_deviation(&torques);
    let centre = Centre::of(&torques, &section.name);
    let mean = centre.value;
    let many = torques.len();
    if many < 2 {
        return Err(vec![Problem::unreadable(
            &section.place,
            format!(
                "`{}` has only one point: push twice or more, to show how much the result scatters",
                section.name
            ),
        )]);
    }
    let value = Figure::of(mean, centre.error(), "N*m/rad");
    let spread = Figure::of(deviation, Some(deviation / 10.0), "N*m/rad");
    let notes = vec![format!(
        "Tip force times arm: the middle value of points with a standard deviation of {spread}."
    )];
    let angles: Vec<f64> = section.numbers("angle").iter().map(|a| a.to_degrees()).collect();
    let mut warnings = centre.warnings(&section.name, "point", |i| {
        Figure::of(torques.get(i).copied().unwrap_or(0.0), None, "N*m/rad").to_string()
    });
    // What does not count has no trend.
    let counts = |values: &[f64]| -> Vec<f64> {
        values.iter().enumerate().filter(|(i, _)| !centre.far.contains(i)).map(|(_, x)| *x).collect()
    };
    warnings.extend(
        varies(&counts(&angles), &counts(&torques), mean)
            .map(|varies| format!("`{}`: {varies}", section.name)),
    );
    let has_angles = !angles.is_empty();
    let across = |i: usize| angles.get(i).copied().unwrap_or(i as f64 + 1.0);
    let point = |(i, torque): (usize, &f64)| (across(i), *torque, 0);
    let points: Vec<(f64, f64, usize)> = torques.iter().enumerate().map(point).collect();
    let ends = points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p.0), h.max(p.0)));
    let plot = Plot {
        title: format!("Torque of `{name}`"),
        x: if has_angles { "bend (deg)" } else { "measurement" }.into(),
        y: "torque (N*m/rad)".into(),
        fit: vec![(vec![(ends.0, mean), (ends.1, mean)], 0)],
        rows: Vec::new(),
        unit: "N*m/rad".into(),
        residuals: points.iter().map(|(x, y, run)| (*x, y - mean, *run)).collect(),
        points,
    };
    let residuals: Vec<f64> = torques.iter().map(|t| t - mean).collect();
    Ok(Finding {
        section: section.name.clone(),
        place: section.place.clone(),
        source: section.source.clone(),
        quantity: format!("{name}.torque"),
        old: Some(shown(old, Dimension::TORQUE)),
        change: Change::Number { path: format!("{name}.torque"), value },
        interval: centre.figures("N*m/rad"),
        factor: Some(mean / old),
        residual: Residual::of(&residuals, "N*m/rad"),
        points: many,
        notes,
        warnings,
        plots: vec![plot],
    })
}

/// Says so where the torque depends on the angle.
fn varies(angles: &[f64], torques: &[f64], mean: f64) -> Option<String> {
    let points: Vec<(f64, f64)> = angles.iter().copied().zip(torques.iter().copied()).collect();
    let (low, high) =
        angles.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), a| (l.min(*a), h.max(*a)));
    let change = slope(&points) * (high - low);
    (points.len() > 2 && change.abs() > STRONG * mean).then(|| {
        let way = if change > 0.0 { "grows" } else { "falls" };
        format!(
            "the torque {way} by {:.0} % of its mean from {low:.0} to {high:.0} deg, which one number cannot represent.",
            100.0 * change.abs() / mean
        )
    })
}
