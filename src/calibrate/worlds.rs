//! How far measurements may be off, as a set of worlds to search and test in.

use grammar_lang::ir::Difference;
use indexmap::IndexMap;

use super::finding::{Change, Figure, Finding, Table};

/// How many worlds are drawn between the ends.
const DRAWN: usize = 15;
/// What is known to so little is no difference between worlds.
const LITTLE: f64 = 0.005;

/// Where the true values lie nine times of ten, as factors of the measured ones. Of several measurements that a world
/// differs in by one factor, the widest counts.
fn ranges(findings: &[Finding]) -> IndexMap<Difference, (f64, f64)> {
    let mut ranges: IndexMap<Difference, (f64, f64)> = IndexMap::new();
    for finding in findings {
        let Some((difference, power)) = difference(&finding.quantity) else { continue };
        let Some((low, high)) = factors(finding) else { continue };
        let (low, high) = (libm::pow(low, power), libm::pow(high, power));
        let range = ranges.entry(difference).or_insert((1.0, 1.0));
        *range = (range.0.min(low), range.1.max(high));
    }
    ranges.retain(|difference, (low, high)| {
        let (least, most) = difference.limits();
        (*low, *high) = (low.max(least), high.min(most));
        *high - *low > LITTLE
    });
    // In the order in which they are listed everywhere.
    ranges.sort_keys();
    ranges
}

/// What a world differs in by a measured field, and by which power of it: a contact has the root of the product of two
/// coefficients of friction.
fn difference(quantity: &str) -> Option<(Difference, f64)> {
    Some(match quantity.rsplit('.').next()? {
        "friction" | "ground_friction" => (Difference::Friction, 0.5),
        "mass" | "density" => (Difference::Mass, 1.0),
        "torque" => (Difference::Torque, 1.0),
        "bending_speed" | "relaxing_speed" | "servo_speed" => (Difference::Speed, 1.0),
        _ => return None,
    })
}

/// The ends of an interval over the value, all as they are written: a world's factor is one of the written value.
fn factors(finding: &Finding) -> Option<(f64, f64)> {
    let over = |value: &Figure, (low, high): &(Figure, Figure)| {
        let [value, low, high] = [value, low, high].map(Figure::written);
        (value > 0.0 && low >= 0.0).then(|| (low / value, high / value))
    };
    match &finding.change {
        Change::Number { value, .. } => over(value, finding.interval.as_ref()?),
        Change::Table { table: Table { rows, within, .. }, .. } => {
            let all =
                rows.iter().zip(within).filter_map(|((_, value), within)| over(value, within.as_ref()?));
            all.reduce(|(low, high), (a, b)| (low.min(a), high.max(b)))
        }
        Change::Prototype { .. } => None,
    }
}

/// The block of a variant that declares these worlds by a name; nothing where the measurements do not say how far they may
/// be off.
pub(super) fn block(name: &str, findings: &[Finding]) -> Option<String> {
    let ranges = ranges(findings);
    if ranges.is_empty() {
        return None;
    }
    // Outwards, to whole percents.
    let percent = |factor: f64, round: fn(f64) -> f64| round(100.0 * factor);
    let lines: Vec<String> = ranges
        .iter()
        .map(|(difference, (low, high))| {
            // Rounding errors are no percent.
            let (low, high) = (percent(low + 1e-9, libm::floor), percent(high - 1e-9, libm::ceil));
            format!("    {} = {low} % .. {high} %\n", difference.text())
        })
        .collect();
    Some(format!("  add scenarios {name} {{\n{}    drawn = {DRAWN}\n  }}\n", lines.concat()))
}
