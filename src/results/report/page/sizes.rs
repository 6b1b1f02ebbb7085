//! Size and value, drawn.

use std::collections::BTreeMap;

use grammar_lang::ir::Direction;

use super::chart::{Chart, Scale, hint};
use super::words::{counted, figures, key, percent, value};
use super::{Link, axis, colour, heading, told};
use crate::results::report::gather::sizes::{Size, Sized, sizes};
use crate::results::report::gather::spread::share;
use crate::results::report::read::Group;

/// Bodies of one size whose values are as near as this part of the scale share a mark.
const CELLS: f64 = 70.0;

pub(super) fn section(groups: &[Group], _: Link) -> String {
    let parts: Vec<Vec<Sized>> = groups.iter().map(|group| sizes(group, Size::Parts)).collect();
    let actuators: Vec<Vec<Sized>> = groups.iter().map(|group| sizes(group, Size::Actuators)).collect();
    let values = || parts.iter().flatten().flat_map(|sized| sized.values.iter().copied());
    if values().next().is_none() {
        return "<p>No body has a value yet.</p>\n".to_owned();
    }
    let y = Scale::of(values().chain([0.0]), 6);
    let marks = [
        ("point soft", "bodies that were tried: the larger the mark, the more of them"),
        ("line ink", "mean of a size"),
    ];
    let mut out = key(&marks.map(|(class, text)| (class.to_owned(), text.to_owned())));
    for (i, group) in groups.iter().enumerate() {
        out += &heading(groups, i);
        let chart = |all: &[Vec<Sized>], by: Size| {
            let widest = all.iter().flatten().map(|sized| sized.size as f64);
            let x = Scale::counts(widest.chain([0.0]), 10);
            chart(group, all.get(i).map_or(&[][..], Vec::as_slice), by, (x, y), &colour(i))
        };
        out += &figures(&[chart(&parts, Size::Parts), chart(&actuators, Size::Actuators)]);
        out += &told(groups, group, &said(group, parts.get(i).map_or(&[][..], Vec::as_slice)));
    }
    out
}

fn chart(group: &Group, all: &[Sized], by: Size, (x, y): (Scale, Scale), class: &str) -> String {
    let label = format!("{} of a body", by.text());
    let mut chart = Chart::new(Chart::HALF, (x, &label), (y, &axis("value of the body", Some(group))));
    for sized in all {
        let mut cells: BTreeMap<i64, (u64, f64)> = BTreeMap::new();
        for value in &sized.values {
            let cell = ((value - y.low) / (y.high - y.low) * CELLS).floor() as i64;
            let (n, sum) = cells.entry(cell).or_default();
            (*n, *sum) = (*n + 1, *sum + value);
        }
        for (n, sum) in cells.values() {
            let mean = sum / *n as f64;
            let told = format!(
                "{} {}: {} near {}",
                sized.size,
                by.text(),
                counted(*n, "body").replace("bodys", "bodies"),
                value(mean, &group.unit)
            );
            let (cx, cy) = (chart.x(sized.size as f64), chart.y(mean));
            let r = 1.6 + 1.5 * libm::log10(*n as f64);
            chart.add(&format!(
                "<circle class=\"cell {class}\" cx=\"{cx:.1}\" cy=\"{cy:.1}\" r=\"{r:.1}\">{}</circle>",
                hint(&told)
            ));
        }
    }
    let means: Vec<(f64, f64)> =
        all.iter().filter_map(|sized| Some((sized.size as f64, sized.spread?.mean))).collect();
    let course = chart.course(&means);
    chart.add(&format!("<path class=\"line ink\" d=\"{course}\"/>"));
    for sized in all {
        let Some(spread) = &sized.spread else { continue };
        let told = format!(
            "{} {}: mean {}, median {}, {} with a value of {}",
            sized.size,
            by.text(),
            value(spread.mean, &group.unit),
            value(spread.median, &group.unit),
            spread.count,
            sized.bodies
        );
        let (cx, cy) = (chart.x(sized.size as f64), chart.y(spread.mean));
        chart.add(&format!(
            "<circle class=\"dot ink\" cx=\"{cx:.1}\" cy=\"{cy:.1}\" r=\"2.6\">{}</circle>",
            hint(&told)
        ));
    }
    chart.finish(&format!("value against {}", by.text()))
}

/// Sizes with fewer values say nothing of a mean.
const ENOUGH: usize = 10;

/// What is seen, in words.
fn said(group: &Group, all: &[Sized]) -> Vec<String> {
    let mut said = Vec::new();
    let fitness = |s: &&Sized| s.spread.map_or(f64::NEG_INFINITY, |spread| group.fitness(spread.mean));
    let often = |s: &&Sized| s.values.len() >= ENOUGH;
    if let Some(best) = all.iter().filter(often).max_by(|a, b| fitness(a).total_cmp(&fitness(b)))
        && let Some(spread) = best.spread
    {
        said.push(format!(
            "Bodies of {} have the best mean, {} (of the sizes that were tried ten times or more).",
            counted(best.size, "part"),
            value(spread.mean, &group.unit)
        ));
    }
    let bodies: u64 = all.iter().map(|s| s.bodies as u64).sum();
    let valued: u64 = all.iter().map(|s| s.values.len() as u64).sum();
    if let Some(without) = share(bodies - valued, bodies).filter(|share| *share > 0.0) {
        said.push(format!("{} of the bodies have no value and no mark.", percent(without)));
    }
    let best = group.best().and_then(|(_, run)| run.value());
    if let Some(best) = best.filter(|best| *best > 0.0 && group.direction == Direction::Maximize) {
        let weak = all.iter().flat_map(|s| &s.values).filter(|v| **v < best / 100.0).count() as u64;
        if let Some(weak) = share(weak, valued).filter(|weak| *weak > 0.2) {
            said.push(format!(
                "{} of the bodies with a value have less than a hundredth of the best value.",
                percent(weak)
            ));
        }
    }
    if let Some((most, last)) = all.iter().max_by_key(|s| s.bodies).zip(all.last())
        && all.len() > 3
        && most.size + 1 >= last.size
    {
        said.push(format!(
            "The largest bodies are tried most often ({} of all have {}): the limit on the size holds the search back.",
            percent(share(most.bodies as u64, bodies).unwrap_or(0.0)),
            counted(most.size, "part")
        ));
    }
    said
}
