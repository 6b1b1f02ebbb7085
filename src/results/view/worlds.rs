//! How a design does in many worlds, as a strip of marks: one for each world, where its value is.

use super::Worlds;
use crate::markup::escape;
use crate::results::describe::quantity;

/// The size of the picture, in its own units.
const WIDTH: f64 = 300.0;
const HEIGHT: f64 = 64.0;
/// How far the marks stay from the left and the right.
const MARGIN: f64 = 8.0;
/// Where the marks stand, and how large they are.
const GROUND: f64 = 46.0;
const MARK: f64 = 2.6;
/// So many columns of marks.
const COLUMNS: usize = 40;

/// The section of the page.
pub(super) fn section(worlds: &Worlds) -> String {
    format!(
        "<section class=\"worlds\"><h2>In other worlds</h2>{}<p>{}</p></section>",
        strip(worlds),
        escape(&worlds.text)
    )
}

/// The marks over an axis from the least to the greatest value, with a line where the nominal world is. Worlds without a
/// value stand at the left, as crosses.
fn strip(worlds: &Worlds) -> String {
    let known = || worlds.values.iter().flatten().copied().filter(|value| value.is_finite());
    let (low, high) = known()
        .chain([worlds.nominal])
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
    let span = if high > low { high - low } else { 1.0 };
    let share = |value: f64| (value - low) / span;
    let at = |share: f64| MARGIN + share * (WIDTH - 2.0 * MARGIN);
    let mut stacks = [0_usize; COLUMNS + 1];
    let mut marks = String::new();
    for value in &worlds.values {
        let (column, class) = match value {
            Some(value) => ((share(*value) * COLUMNS as f64).round() as usize, "world"),
            None => (0, "world none"),
        };
        let x = at(column as f64 / COLUMNS as f64);
        let y = GROUND - MARK - 2.0 * MARK * stacks[column] as f64;
        stacks[column] += 1;
        // As many as there are should stand above each other, not beyond the picture.
        let y = y.max(MARK);
        marks += &format!("<circle class=\"{class}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{:.1}\"/>", MARK - 0.3);
    }
    let nominal = at(share(worlds.nominal));
    format!(
        "<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{label}\">\
         <path class=\"axis\" d=\"M{MARGIN} {GROUND}H{end}\"/>\
         <path class=\"nominal\" d=\"M{nominal:.1} 2V{GROUND}\"/>{marks}\
         <text x=\"{MARGIN}\" y=\"60\">{low}</text>\
         <text x=\"{end}\" y=\"60\" text-anchor=\"end\">{high}</text></svg>",
        label = escape(&worlds.text),
        end = WIDTH - MARGIN,
        low = escape(&quantity(low, &worlds.unit)),
        high = escape(&quantity(high, &worlds.unit)),
    )
}
