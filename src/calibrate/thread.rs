//! How much thread an actuator takes for a bend, as a table.

use super::declared;
use super::finding::{Change, Figure, Finding, Plot, Residual, Table};
use super::lines::{at, reduce};
use super::measurements::{Section, quantity};
use super::monotone::ascending;
use super::problem::{Location, Problem};
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
/// A thread that grows by less than this from angle to angle is as long, m.
const FLAT: f64 = 0.2 * RULER;
/// A stretch of more than this share of all angles in which the thread is as long is told.
const SLACK: f64 = 0.1;
/// Angles nearer than this are one, rad.
const SAME: f64 = 1e-6;

/// The points of one angle.
struct Group {
    angle: f64,
    length: f64,
    rows: Vec<usize>,
}

/// A thread that gets shorter where the bend grows: the sign of one of the columns is turned round.
fn shrinks(section: &Section, groups: &[Group]) -> Option<String> {
    let (first, last) = (groups.first()?, groups.last()?);
    (last.length < first.length).then(|| {
        format!(
            "`{}`: the thread gets shorter as the bend grows, from {} to {}. Is the sign of one column the wrong way round?",
            section.name,
            mm(first.length),
            mm(last.length)
        )
    })
}

/// Fits a section of kind `thread`.
pub(super) fn fit(section: &Section, rules: &RuleSet) -> Result<Finding, Vec<Problem>> {
    let (actuator, declared) = declared::actuator(rules, section).map_err(|p| vec![p])?;
    let target = declared::threads(rules, section, &actuator).map_err(|p| vec![p])?;
    let (angles, lengths) = (section.numbers("angle"), section.numbers("thread"));
    let points: Vec<(f64, f64)> = angles.iter().copied().zip(lengths.iter().copied()).collect();
    let groups = groups(&points);
    if groups.len() < 2 {
        return Err(vec![Problem::unreadable(
            &section.place,
            format!("`{}` has points at only one angle: a table needs two angles or more", section.name),
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
    let mut warnings = Vec::new();
    let rows = smoothed(section, &groups, scatter.unwrap_or(0.0).max(RULER), (&mut notes, &mut warnings))?;
    let points_of_rows: Vec<(f64, f64)> = rows.iter().map(|row| (row.angle, row.length)).collect();
    // What a ruler cannot tell needs no row of its own.
    let kept = reduce(&points_of_rows, scatter.unwrap_or(0.0).max(0.5 * RULER), MOST_ROWS);
    let figures = kept.into_iter().filter_map(|i| rows.get(i)).map(|row| {
        let decimals = if row.is_flat { 2 } else { 1 };
        (Figure::with_decimals(row.angle, "deg", 2), Figure::with_decimals(row.length, "mm", decimals))
    });
    let rows = distinct(figures);
    warnings.extend(shrinks(section, &groups));
    if let Some(bend) = declared.bend {
        warnings.extend(other_unit(section, &groups, bend));
        warnings.extend(ends_early(section, &groups, bend));
    }
    let within = within(section, lengths, &groups, &rows);
    if rows.len() < 2 {
        return Err(vec![pulls_nothing(section)]);
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
        warnings,
        plots: vec![plot],
    })
}

/// How much thread a table takes from end to end, m.
fn span(table: &grammar_lang::ir::Table) -> f64 {
    let (low, high) = table.range();
    high - low
}

/// That the angles are of another size than those of the grammar.
fn other_unit(section: &Section, groups: &[Group], (least, most): (f64, f64)) -> Option<String> {
    let measured = groups.last()?.angle - groups.first()?.angle;
    let share = measured / (most - least);
    (!(0.1..=10.0).contains(&share)).then(|| {
        format!(
            "`{}`: its angles cover a range of {}, but the actuator has a range of {} in the grammar: are the units right?",
            section.name,
            shown(measured, Dimension::ANGLE),
            shown(most - least, Dimension::ANGLE)
        )
    })
}

/// That bends of the grammar were not measured.
fn ends_early(section: &Section, groups: &[Group], (least, most): (f64, f64)) -> Option<String> {
    let (first, last) = (groups.first()?.angle, groups.last()?.angle);
    (first > least + SAME || last < most - SAME).then(|| {
        format!(
            "`{}`: the measurements go from {} to {}, but the actuator bends from {} to {} in the grammar: the servo stops where the table ends. \
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
        Problem::unreadable(place, format!("`{text}` is not a length: write `tolerance = \"1.5 mm\"`"))
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
                "at {} the thread is {} here, but {} {}: they may differ by at most {}. Measure again, or write `tolerance = \"...\"`",
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
fn seen(other: &Location, here: &Location) -> String {
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

/// A row of the table before it is written.
struct Row {
    angle: f64,
    length: f64,
    /// Whether it is an end of a stretch in which the thread is as long everywhere.
    is_flat: bool,
}

/// Neighbouring angles at which the thread is as long, as far as a ruler tells.
struct Stretch<'g> {
    groups: &'g [Group],
    /// Their mean, where more is a larger bend.
    mean: f64,
}

impl Stretch<'_> {
    fn weight(&self) -> f64 {
        self.groups.iter().map(|g| g.rows.len() as f64).sum()
    }

    fn middle(&self) -> f64 {
        self.groups.iter().map(|g| g.angle * g.rows.len() as f64).sum::<f64>() / self.weight()
    }

    fn ends(&self) -> Option<(&Group, &Group)> {
        self.groups.first().zip(self.groups.last())
    }
}

/// The stretches of a thread that grows with `sign` times its length, in the order of their angles.
fn stretches(groups: &[Group], sign: f64) -> Vec<Stretch<'_>> {
    let values: Vec<f64> = groups.iter().map(|g| sign * g.length).collect();
    let count = |i: usize| groups.get(i).map_or(1.0, |g| g.rows.len() as f64);
    let mut out: Vec<(Stretch<'_>, usize)> = Vec::new();
    for pool in ascending(&values, count) {
        let own = Stretch { groups: groups.get(pool.first..pool.end).unwrap_or(&[]), mean: pool.mean };
        match out.last_mut() {
            Some((last, first)) if own.mean - last.mean < FLAT => {
                let (a, b) = (last.weight(), own.weight());
                last.mean = (last.mean * a + own.mean * b) / (a + b);
                last.groups = groups.get(*first..pool.end).unwrap_or(&[]);
            }
            _ => out.push((own, pool.first)),
        }
    }
    out.into_iter().map(|(stretch, _)| stretch).collect()
}

/// Rows that go one way: what turns back by less than the scatter is pooled, what turns back farther is refused. A table
/// has one bend for each length, so that a stretch in which the thread is as long everywhere rises by a tenth of a
/// millimetre.
fn smoothed(
    section: &Section,
    groups: &[Group],
    limit: f64,
    (notes, warnings): (&mut Vec<String>, &mut Vec<String>),
) -> Result<Vec<Row>, Vec<Problem>> {
    let points: Vec<(f64, f64)> = groups.iter().map(|g| (g.angle, g.length)).collect();
    let sign = if slope(&points) < 0.0 { -1.0 } else { 1.0 };
    let stretches = stretches(groups, sign);
    if stretches.len() < 2 {
        return Err(vec![pulls_nothing(section)]);
    }
    let middles: Vec<(f64, f64)> = stretches.iter().map(|s| (s.middle(), s.mean)).collect();
    let all = points.first().zip(points.last()).map_or(0.0, |(first, last)| last.0 - first.0);
    let mut rows = Vec::new();
    let mut problems = Vec::new();
    for (i, stretch) in stretches.iter().enumerate() {
        let middle = Row { angle: stretch.middle(), length: sign * stretch.mean, is_flat: false };
        let Some((first, last)) = stretch.ends().filter(|_| stretch.groups.len() > 1) else {
            rows.push(middle);
            continue;
        };
        let far = stretch.groups.iter().map(|g| (sign * g.length - stretch.mean).abs()).fold(0.0, f64::max);
        if far > limit {
            problems.push(turns_back(section, first, last));
            continue;
        }
        let span =
            format!("{} to {}", shown(first.angle, Dimension::ANGLE), shown(last.angle, Dimension::ANGLE));
        if stretch.groups.windows(2).any(|pair| sign * (pair[1].length - pair[0].length) < 0.0) {
            notes.push(format!(
                "From {span} the thread turned back by less than its scatter ({}); sgc smoothed it.",
                mm(far)
            ));
        }
        // One row in the middle will do where the lines to its neighbours say what was measured.
        let is_end = i == 0 || i + 1 == stretches.len();
        let is_said = |g: &Group| (at(&middles, g.angle) - sign * g.length).abs() <= limit;
        if !is_end && stretch.groups.iter().all(is_said) {
            rows.push(middle);
            continue;
        }
        let gap =
            |other: Option<&Stretch<'_>>| other.map_or(f64::INFINITY, |o| (o.mean - stretch.mean).abs());
        let gaps = gap(i.checked_sub(1).and_then(|i| stretches.get(i))).min(gap(stretches.get(i + 1)));
        let rise = (0.5 * FLAT).min(gaps / 3.0);
        for (angle, off) in [(first.angle, -rise), (last.angle, rise)] {
            rows.push(Row { angle, length: sign * (stretch.mean + off), is_flat: true });
        }
        if last.angle - first.angle > SLACK * all {
            warnings.push(format!(
                "`{}`: from {span} the length of the thread is constant: there it is slack or at a stop, and does not show how far \
                 the actuator bends. In the table, the length rises by a tenth of a millimetre.",
                section.name
            ));
        }
    }
    if problems.is_empty() { Ok(rows) } else { Err(problems) }
}

fn pulls_nothing(section: &Section) -> Problem {
    Problem::contradiction(
        &section.place,
        format!("`{}`: the thread has the same length at every angle, so it cannot pull", section.name),
    )
}

/// Says that a thread turns back by more than it scatters.
fn turns_back(section: &Section, first: &Group, last: &Group) -> Problem {
    let row = |group: &Group| section.place(group.rows.first().copied().unwrap_or(0)).clone();
    let (a, b) = (row(first), row(last));
    let ([a, b], [early, late]) = if a <= b { ([a, b], [first, last]) } else { ([b, a], [last, first]) };
    Problem::contradiction(
        &b,
        format!(
            "the thread turns back from {} to {}: {} here, {} {}. A larger bend must take more thread than a smaller one; measure these points again",
            shown(first.angle, Dimension::ANGLE),
            shown(last.angle, Dimension::ANGLE),
            shown(late.length, Dimension::LENGTH),
            shown(early.length, Dimension::LENGTH),
            seen(&a, &b),
        ),
    )
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
