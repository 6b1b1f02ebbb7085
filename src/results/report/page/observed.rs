//! What was observed against the value, drawn.

use std::collections::BTreeMap;

use super::chart::{Chart, Scale, hint};
use super::words::{count, counted, figures, key, number, or_dash, percent, table, value};
use super::{Link, axis, colour, heading, told};
use crate::markup::escape;
use crate::results::report::gather::observed::{Kind, Occurrence, Seen, bins, classes, points, seen};
use crate::results::report::gather::spread::Spread;
use crate::results::report::read::Group;

/// Bodies as near as these parts of the scales share a mark.
const CELLS: (f64, f64) = (80.0, 60.0);
/// Bins with fewer bodies say nothing of a mean.
const ENOUGH: usize = 10;

pub(super) fn section(groups: &[Group], _: Link) -> String {
    let all: Vec<Vec<Seen>> = groups.iter().map(seen).collect();
    if all.iter().all(Vec::is_empty) {
        return String::new();
    }
    let numbers = |seen: &Seen| matches!(seen.kind, Kind::Number { .. });
    let mut out = String::new();
    if all.iter().flatten().any(numbers) {
        let marks = [
            ("point soft", "bodies that were accepted: the larger the mark, the more of them"),
            ("line ink", "mean value by tenths of the range"),
        ];
        out += &key(&marks.map(|(class, text)| (class.to_owned(), text.to_owned())));
    }
    for (i, group) in groups.iter().enumerate() {
        let own = all.get(i).map_or(&[][..], Vec::as_slice);
        if own.is_empty() {
            continue;
        }
        out += &heading(groups, i);
        let mut pictures = Vec::new();
        let mut sentences = Vec::new();
        for Seen { name, kind } in own {
            let Kind::Number { unit, factor } = kind else { continue };
            let points = points(group, name, *factor);
            if points.is_empty() {
                sentences.push(format!("<code>{}</code> has no value for any accepted body.", escape(name)));
                continue;
            }
            sentences.extend(said(group, (name, unit), &points));
            pictures.push(chart(group, (name, unit), &points, &colour(i)));
        }
        if !pictures.is_empty() {
            out += &figures(&pictures);
        }
        out += &told(groups, group, &sentences);
        for Seen { name, kind } in own {
            if let Kind::Class(order) = kind {
                out += &class_table(group, name, order);
            }
        }
    }
    out
}

fn chart(group: &Group, (name, unit): (&str, &str), points: &[(f64, f64)], class: &str) -> String {
    let x = Scale::of(points.iter().map(|(x, _)| *x), 8);
    let y = Scale::of(points.iter().map(|(_, y)| *y).chain([0.0]), 6);
    let label = if unit.is_empty() { name.to_owned() } else { format!("{name} ({unit})") };
    let mut chart = Chart::new(Chart::HALF, (x, &label), (y, &axis("value of the body", Some(group))));
    let mut cells: BTreeMap<(i64, i64), (u64, f64, f64)> = BTreeMap::new();
    let cell = |scale: &Scale, value: f64, cells: f64| {
        ((value - scale.low) / (scale.high - scale.low) * cells).floor() as i64
    };
    for (at, worth) in points {
        let (n, across, up) = cells.entry((cell(&x, *at, CELLS.0), cell(&y, *worth, CELLS.1))).or_default();
        (*n, *across, *up) = (*n + 1, *across + at, *up + worth);
    }
    for (n, across, up) in cells.values() {
        let (across, up) = (across / *n as f64, up / *n as f64);
        let told = format!(
            "{name} near {}: {} near {}",
            value(across, unit),
            counted(*n, "body").replace("bodys", "bodies"),
            value(up, &group.unit)
        );
        let (cx, cy) = (chart.x(across), chart.y(up));
        let r = 1.6 + 1.5 * libm::log10(*n as f64);
        chart.add(&format!(
            "<circle class=\"cell {class}\" cx=\"{cx:.1}\" cy=\"{cy:.1}\" r=\"{r:.1}\">{}</circle>",
            hint(&told)
        ));
    }
    let bins = bins(points);
    let middle = |low: f64, high: f64| (low + high) / 2.0;
    let means: Vec<(f64, f64)> = bins.iter().map(|b| (middle(b.low, b.high), b.spread.mean)).collect();
    let course = chart.course(&means);
    chart.add(&format!("<path class=\"line ink\" d=\"{course}\"/>"));
    for (bin, (at, mean)) in bins.iter().zip(means) {
        let told = format!(
            "{name} from {} to {}: mean {}, median {}, {}",
            value(bin.low, unit),
            value(bin.high, unit),
            value(mean, &group.unit),
            value(bin.spread.median, &group.unit),
            counted(bin.spread.count as u64, "body").replace("bodys", "bodies")
        );
        let (cx, cy) = (chart.x(at), chart.y(mean));
        chart.add(&format!(
            "<circle class=\"dot ink\" cx=\"{cx:.1}\" cy=\"{cy:.1}\" r=\"2.6\">{}</circle>",
            hint(&told)
        ));
    }
    chart.finish(&format!("value against {name}"))
}

/// What is seen of a number, in words.
fn said(group: &Group, (name, unit): (&str, &str), points: &[(f64, f64)]) -> Option<String> {
    let name = escape(name);
    let bins = bins(points);
    if let [only] = bins.as_slice() {
        return Some(format!("<code>{name}</code> is {} for all bodies.", value(only.low, unit)));
    }
    let often = bins.into_iter().filter(|bin| bin.spread.count >= ENOUGH);
    let best = often.max_by(|a, b| group.fitness(a.spread.mean).total_cmp(&group.fitness(b.spread.mean)))?;
    Some(format!(
        "Grouped by <code>{name}</code>, the best mean is {}, for bodies from {} to {} (among the ranges with {ENOUGH} bodies or more).",
        value(best.spread.mean, &group.unit),
        value(best.low, unit),
        value(best.high, unit)
    ))
}

/// Occurrence and values by class, as table 4.2 of the thesis has them.
fn class_table(group: &Group, name: &str, order: &[String]) -> String {
    let all = classes(group, name, order);
    let head = ["", "#occurrence", "#mean", "#min", "#max", "#sd"];
    let row = |class: &str, Occurrence { count: n, share, spread }: &Occurrence| {
        let of = |number_of: fn(&Spread) -> f64| or_dash(spread.as_ref().map(|s| number(number_of(s))));
        vec![
            escape(class),
            format!("{} ({})", count(*n), or_dash(share.map(percent))),
            of(|s| s.mean),
            of(|s| s.min),
            of(|s| s.max),
            or_dash(spread.and_then(|s| s.sd).map(number)),
        ]
    };
    let titled = |what: &str, rows: Vec<Vec<String>>| {
        let title = format!("<code>{}</code>, {what}: {}", escape(name), axis("value", Some(group)));
        format!("<p class=\"small\">{title}</p>\n{}", table(&head, &rows))
    };
    titled("the best of each run", all.iter().map(|class| row(&class.name, &class.best)).collect())
        + &titled(
            "all bodies that were accepted",
            all.iter().map(|class| row(&class.name, &class.accepted)).collect(),
        )
}
