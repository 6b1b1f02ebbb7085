//! How much thread an actuator takes for a bend, as a table.

use super::declared;
use super::finding::{Change, Figure, Finding, Plot, Residual, Table};
use super::lines::{at, reduce};
use super::measurements::{Section, quantity};
use super::monotone::ascending;
use super::problem::{Place, Problem};
use super::robust::quantiles;
use super::statistics::{mean_and_deviation, slope};
use crate::derive::random::Stream;
use grammar_lang::ir::RuleSet;
use grammar_lang::units::{Dimension, shown};

/// As many rows a table has at most: more say nothing that a ruler could tell.
const MOST_ROWS: usize = 16;
/// How well a length can be read off a ruler, m.
const RULER: f64 = 0.5e-3;
/// Points of one angle may be so far apart, as a share of all the thread, if the section says nothing else.
const TOLERANCE: f64 = 0.05;
/// Angles nearer than this are one, rad.
const SAME: f64 = 1e-6;

/// The points of one angle.
struct Group {
    angle: f64,
    length: f64,
    rows: Vec<usize>,
}

/// Fits a section of kind `thread`.
pub(super) fn fit(section: &Section, rules: &RuleSet) -> Result<Finding, Vec<Problem>> {
    let (actuator, declared) = declared::actuator(rules, section).map_err(|p| vec![p])?;
    let declared_bend = declared.bend;
    let target = declared::threads(rules, section, &actuator).map_err(|p| vec![p])?;
    let (angles, lengths) = (section.numbers("angle"), section.numbers("thread"));
    let points: Vec<(f64, f64)> = angles.iter().copied().zip(lengths.iter().copied()).collect();
    let groups = groups(&points);
    if groups.len() < 2 {
        return Err(vec![Problem::unreadable(
            &section.place,
            format!("`{}` has points at one angle only: a table needs two or more", section.name),
        )]);
    }
    let (low, high) =
        lengths.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(*x), h.max(*x)));
    let tolerance = tolerance(section, high - low).map_err(|p| vec![p])?;
    let apart: Vec<Problem> =
        groups.iter().filter_map(|group| contradiction(section, lengths, group, tolerance)).collect();
    if !apart.is_empty() {
        return Err(apart);
    }
    let scatter = scatter(lengths, &groups);
    let mut notes = Vec::new();
    if let Some(scatter) = scatter {
        notes.push(format!("Repeated points scatter by {}.", mm(scatter)));
    }
    let rows = smoothed(section, &groups, scatter.unwrap_or(0.0).max(RULER), &mut notes)?;
    // What a ruler cannot tell needs no row of its own.
    let kept = reduce(&rows, scatter.unwrap_or(0.0).max(0.5 * RULER), MOST_ROWS);
    let figures = kept.into_iter().filter_map(|i| rows.get(i)).map(|(angle, length)| {
        (Figure::with_decimals(*angle, "deg", 2), Figure::with_decimals(*length, "mm", 1))
    });
    let rows = distinct(figures);
    let within = within(section, lengths, &groups, &rows);
    if rows.len() < 2 {
        return Err(vec![Problem::contradiction(
            &section.place,
            format!("`{}`: the thread is as long at every angle, so it pulls nothing", section.name),
        )]);
    }
    let drawn: Vec<(f64, f64)> = rows.iter().map(|(a, l)| (a.value, l.value)).collect();
    let in_units: Vec<(f64, f64)> = points.iter().map(|(a, l)| (a.to_degrees(), l * 1e3)).collect();
    let residuals: Vec<f64> = in_units.iter().map(|(a, l)| l - at(&drawn, *a)).collect();
    let straight = at(&drawn, 0.0);
    if straight.abs() > 2.0 && drawn.iter().any(|row| row.0 <= 0.0) && drawn.iter().any(|row| row.0 >= 0.0) {
        notes.push(format!(
            "At 0 deg the thread is {straight:.1} mm, not 0 mm: is the ruler's zero where it should be?"
        ));
    }
    let plot = Plot {
        title: format!("Thread of `{actuator}`"),
        x: "bend (deg)".into(),
        y: "thread (mm)".into(),
        points: in_units.iter().map(|(a, l)| (*a, *l, 0)).collect(),
        fit: vec![(drawn.clone(), 0)],
        rows: drawn,
        unit: "mm".into(),
        residuals: in_units.iter().zip(&residuals).map(|((a, _), r)| (*a, *r, 0)).collect(),
    };
    let si: Vec<f64> = residuals.iter().map(|r| r * 1e-3).collect();
    let path = target.map(|(name, _)| format!("{name}.thread"));
    let table = Table { name: format!("{actuator}_thread"), from: "Angle", to: "Length", rows, within };
    if target.is_none() {
        notes.push(
            "The grammar declares no target on tendon for it, so nothing uses this table yet.".to_owned(),
        );
    }
    Ok(Finding {
        section: section.name.clone(),
        place: section.place.clone(),
        source: section.source.clone(),
        quantity: path.clone().unwrap_or_else(|| table.name.clone()),
        old: target.map(|(_, threads)| declared::tabulated(&threads.thread, Dimension::LENGTH)),
        change: Change::Table { path, table },
        interval: None,
        factor: target.map(|(_, threads)| (high - low) / span(&threads.thread)),
        residual: Residual::of(&si, "mm"),
        points: points.len(),
        notes,
        warnings: ends_early(section, &groups, declared_bend).into_iter().collect(),
        plots: vec![plot],
    })
}

/// How much thread a table takes from end to end, m.
fn span(table: &grammar_lang::ir::Table) -> f64 {
    let (low, high) = table.range();
    high - low
}

/// That bends of the grammar were not measured.
fn ends_early(section: &Section, groups: &[Group], (least, most): (f64, f64)) -> Option<String> {
    let (first, last) = (groups.first()?.angle, groups.last()?.angle);
    (first > least + SAME || last < most - SAME).then(|| {
        format!(
            "`{}`: it was measured from {} to {}, and bends from {} to {} in the grammar: the servo stops where the table ends. \
             Measure further, or narrow the bend.",
            section.name,
            shown(first, Dimension::ANGLE),
            shown(last, Dimension::ANGLE),
            shown(least, Dimension::ANGLE),
            shown(most, Dimension::ANGLE)
        )
    })
}

/// Where each row lies nine times of ten, as repeated points of all angles scatter; none without any.
fn within(
    section: &Section,
    lengths: &[f64],
    groups: &[Group],
    rows: &[(Figure, Figure)],
) -> Vec<Option<(Figure, Figure)>> {
    let off: Vec<f64> = groups
        .iter()
        .filter(|group| group.rows.len() > 1)
        .flat_map(|group| {
            // So few points of one angle are nearer to their mean than to the truth.
            let n = group.rows.len() as f64;
            let wide = (n / (n - 1.0)).sqrt();
            group.rows.iter().filter_map(move |row| Some(wide * (lengths.get(*row)? - group.length)))
        })
        .collect();
    let mut random = Stream::named(0, &section.name);
    let mut of_group = |many: usize| {
        let mut means: Vec<f64> = (0..1000)
            .map(|_| {
                let drawn = (0..many).filter_map(|_| off.get(random.below(off.len())).copied());
                drawn.sum::<f64>() / many.max(1) as f64
            })
            .collect();
        quantiles(&mut means)
    };
    rows.iter()
        .map(|(angle, length)| {
            let near = |group: &&Group| (group.angle.to_degrees() - angle.value).abs() < 0.01;
            let (low, high) = of_group(groups.iter().find(near)?.rows.len()).filter(|_| !off.is_empty())?;
            let end = |off: f64| Figure::with_decimals(length.value * 1e-3 + off, "mm", 1);
            Some((end(low), end(high)))
        })
        .collect()
}

fn mm(length: f64) -> String {
    Figure::of(length, Some(length / 10.0), "mm").to_string()
}

/// How far points of one angle may be apart.
fn tolerance(section: &Section, range: f64) -> Result<f64, Problem> {
    let Some((text, place)) = section.setting("tolerance") else {
        return Ok((TOLERANCE * range).max(2.0 * RULER));
    };
    quantity(text, Dimension::LENGTH).filter(|tolerance| *tolerance > 0.0).ok_or_else(|| {
        Problem::unreadable(place, format!("`{text}` is no length: write `tolerance = \"1.5 mm\"`"))
    })
}

/// The points by their angles, ascending.
fn groups(points: &[(f64, f64)]) -> Vec<Group> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|a, b| points.get(*a).partial_cmp(&points.get(*b)).unwrap_or(std::cmp::Ordering::Equal));
    let mut groups: Vec<Group> = Vec::new();
    for row in order {
        let Some((angle, length)) = points.get(row) else { continue };
        match groups.last_mut().filter(|group| angle - group.angle < SAME) {
            Some(group) => {
                group.rows.push(row);
                group.length += (length - group.length) / group.rows.len() as f64;
            }
            None => groups.push(Group { angle: *angle, length: *length, rows: vec![row] }),
        }
    }
    groups
}

/// Says which points of one angle are too far apart. They ascend in length.
fn contradiction(section: &Section, lengths: &[f64], group: &Group, tolerance: f64) -> Option<Problem> {
    let (first, last) = (*group.rows.first()?, *group.rows.last()?);
    let (short, long) = (*lengths.get(first)?, *lengths.get(last)?);
    (long - short > tolerance).then(|| {
        let [(early, a), (late, b)] = if first < last { [(first, short), (last, long)] } else { [(last, long), (first, short)] };
        Problem::contradiction(
            section.place(late),
            format!(
                "at {} the thread is {} here, but {} {}: they may be {} apart. Measure again, or say `tolerance = \"...\"`",
                shown(group.angle, Dimension::ANGLE),
                shown(b, Dimension::LENGTH),
                shown(a, Dimension::LENGTH),
                seen(section.place(early), section.place(late)),
                mm(tolerance)
            ),
        )
    })
}

/// Where another row is.
fn seen(other: &Place, here: &Place) -> String {
    if other == here { "in the same line".to_owned() } else { format!("in {other}") }
}

/// The standard deviation within angles that were measured more than once.
fn scatter(lengths: &[f64], groups: &[Group]) -> Option<f64> {
    let mut squares = 0.0;
    let mut degrees = 0;
    for group in groups.iter().filter(|group| group.rows.len() > 1) {
        let all: Vec<f64> = group.rows.iter().filter_map(|row| lengths.get(*row).copied()).collect();
        let (_, deviation) = mean_and_deviation(&all);
        degrees += all.len() - 1;
        squares += deviation * deviation * (all.len() - 1) as f64;
    }
    (degrees > 0).then(|| (squares / degrees as f64).sqrt())
}

/// Rows that go one way: what turns back by less than the scatter is pooled, what turns back farther is refused.
fn smoothed(
    section: &Section,
    groups: &[Group],
    limit: f64,
    notes: &mut Vec<String>,
) -> Result<Vec<(f64, f64)>, Vec<Problem>> {
    let points: Vec<(f64, f64)> = groups.iter().map(|g| (g.angle, g.length)).collect();
    let sign = if slope(&points) < 0.0 { -1.0 } else { 1.0 };
    let values: Vec<f64> = groups.iter().map(|g| sign * g.length).collect();
    let count = |i: usize| groups.get(i).map_or(1.0, |g| g.rows.len() as f64);
    let mut rows = Vec::new();
    let mut problems = Vec::new();
    for pool in ascending(&values, count) {
        let members = groups.get(pool.first..pool.end).unwrap_or(&[]);
        let far = members.iter().map(|g| (sign * g.length - pool.mean).abs()).fold(0.0, f64::max);
        let weight: f64 = members.iter().map(|g| g.rows.len() as f64).sum();
        let angle = members.iter().map(|g| g.angle * g.rows.len() as f64).sum::<f64>() / weight;
        rows.push((angle, sign * pool.mean));
        let (Some(first), Some(last)) = (members.first(), members.last()) else { continue };
        if members.len() < 2 {
            continue;
        }
        let span =
            format!("{} to {}", shown(first.angle, Dimension::ANGLE), shown(last.angle, Dimension::ANGLE));
        if far > limit {
            let row = |group: &Group| section.place(group.rows.first().copied().unwrap_or(0)).clone();
            let (a, b) = (row(first), row(last));
            let ([a, b], [early, late]) =
                if a <= b { ([a, b], [first, last]) } else { ([b, a], [last, first]) };
            problems.push(Problem::contradiction(
                &b,
                format!(
                    "the thread turns back from {span}: {} here, {} {}. A bend must take more thread than a smaller one; measure these again",
                    shown(late.length, Dimension::LENGTH),
                    shown(early.length, Dimension::LENGTH),
                    seen(&a, &b),
                ),
            ));
        } else {
            notes.push(format!(
                "From {span} the thread turned back by less than it scatters ({}): smoothed.",
                mm(far)
            ));
        }
    }
    if problems.is_empty() { Ok(rows) } else { Err(problems) }
}

/// Rows that are still different as they are written.
fn distinct(rows: impl Iterator<Item = (Figure, Figure)>) -> Vec<(Figure, Figure)> {
    let mut out: Vec<(Figure, Figure)> = Vec::new();
    for row in rows {
        let same = out.last().is_some_and(|last| {
            last.0.digits(true) == row.0.digits(true) || last.1.digits(false) == row.1.digits(false)
        });
        if !same {
            out.push(row);
        }
    }
    out
}
