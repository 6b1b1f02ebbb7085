//! How fast an actuator bends and goes back, from films of its bend.

use std::collections::BTreeMap;

use grammar_lang::ir::{RuleSet, Speed};
use grammar_lang::units::{Dimension, shown};

use super::declared;
use super::finding::{Change, Figure, Finding, Plot, Residual, Table};
use super::kind::Kind;
use super::measurements::Section;
use super::monotone::course;
use super::problem::Problem;
use super::trajectory::{self, Fit, Motion, Run};

/// A run with fewer points is no curve.
const FEWEST: usize = 5;
/// More points than this take minutes, and say no more.
const MOST: usize = 2000;
/// A curve that turns back by more than this share of its way is none of one motion.
const STRAY: f64 = 0.15;

/// Pictures of a film that lie further apart, s, are times in another unit, or of two films.
const FURTHEST: f64 = 100.0;

/// Runs of which one is this many times as fast as another are told.
const DIFFERENT: f64 = 1.15;

/// A bend that changes by less, rad, is noise.
const LEAST_WAY: f64 = std::f64::consts::PI / 180.0;

/// A film that goes so many times as far as the actuator bends in the grammar is of another angle, or of another actuator.
const BEYOND: f64 = 1.25;
/// A film of which no run comes nearer to rest than this share of its greatest bend leaves the slow beginning out.
const BENT: f64 = 0.2;
/// So much of the greatest bend on the other side is more than a zero that is a little off.
const OTHER_SIDE: f64 = 0.15;

/// A point at an end is alone if its run has so many steps, the step to it is this share of the whole way, and so many times as fast as
/// any other.
const LONE_STEPS: usize = 5;
const LONE_WAY: f64 = 0.1;
const LONE_SPEED: f64 = 2.0;

/// A run of a section: its name, its points in time, and the line of the first.
struct Curve {
    name: String,
    points: Vec<(f64, f64)>,
    row: usize,
}

/// Fits a section of kind `inflate` or `deflate`.
pub(super) fn fit(section: &Section, rules: &RuleSet) -> Result<Finding, Vec<Problem>> {
    let (name, actuator) = declared::actuator(rules, section).map_err(|p| vec![p])?;
    let many = section.numbers("time").len();
    if many > MOST {
        let every = many.div_ceil(MOST);
        let told = format!(
            "`{}` has {many} points, and a fit takes at most {MOST}: read one picture of the film in {every}",
            section.name
        );
        return Err(vec![Problem::unreadable(&section.place, told)]);
    }
    let curves = curves(section);
    let sign = sign(section, &curves)?;
    // From the beginning of each run: a clock that counts from 1970 has no digits left for milliseconds.
    let turned = |points: &[(f64, f64)]| {
        let begin = points.first().map_or(0.0, |(t, _)| *t);
        points.iter().map(|(t, a)| (t - begin, sign * a)).collect()
    };
    let runs: Vec<Run> = curves.iter().map(|curve| Run { points: turned(&curve.points) }).collect();
    let mut problems = Vec::new();
    for (curve, run) in curves.iter().zip(&runs) {
        if let Some(problem) = stray(section, curve, run) {
            problems.push(problem);
        }
    }
    if !problems.is_empty() {
        return Err(problems);
    }
    if let Some(problem) = unseen(section, &curves, &runs) {
        return Err(vec![problem]);
    }
    let found = trajectory::fit(&runs, &section.name).ok_or_else(|| {
        vec![Problem::contradiction(&section.place, format!("`{}` does not move", section.name))]
    })?;
    let (field, what, old) = match section.kind {
        Kind::Deflate => ("relaxing_speed", "deflating", &actuator.motor.relaxing_speed),
        _ => ("bending_speed", "inflating", &actuator.motor.speed),
    };
    let path = format!("{name}.{field}");
    let Some(old) = old.fixed() else {
        return Err(vec![declared::varies(&name, field, &section.place)]);
    };
    let mut measured: Vec<(Figure, Figure, (Figure, Figure))> = found
        .rows
        .iter()
        .zip(&found.within)
        .map(|((bend, speed), (low, high))| {
            let bend = Figure::with_decimals(sign * bend, "deg", usize::from(bend.to_degrees() < 20.0));
            let error = 0.5 * (high - low);
            let end = |speed: f64| Figure::of(speed, Some(error / 10.0), "deg/s");
            (bend, Figure::of(*speed, Some(error), "deg/s"), (end(*low), end(*high)))
        })
        .collect();
    if sign < 0.0 {
        measured.reverse();
    }
    measured.dedup_by(|b, a| a.0.digits(true) == b.0.digits(true));
    let known = |within: &(Figure, Figure)| (!found.is_thin).then(|| within.clone());
    let within: Vec<_> = measured.iter().map(|(.., within)| known(within)).collect();
    let rows: Vec<(Figure, Figure)> = measured.into_iter().map(|(bend, speed, _)| (bend, speed)).collect();
    let mut interval = None;
    let mut notes = Vec::new();
    if curves.len() > 1 {
        notes.push(format!("{} runs, fitted together.", curves.len()));
    }
    let change = match rows.as_slice() {
        [(_, only)] => {
            notes.push("The speed is the same at every bend, within the scatter.".to_owned());
            interval = within.first().cloned().flatten();
            Change::Number { path: path.clone(), value: only.clone() }
        }
        _ => {
            let table =
                Table { name: format!("{name}_{what}"), from: "Angle", to: "AngularVelocity", rows, within };
            Change::Table { path: Some(path.clone()), table }
        }
    };
    let residuals = residuals(&found, &runs);
    let si: Vec<f64> = residuals.iter().map(|(_, r, _)| *r).collect();
    Ok(Finding {
        section: section.name.clone(),
        place: section.place.clone(),
        source: section.source.clone(),
        quantity: path,
        old: Some(so_far(old)),
        change,
        interval,
        factor: Some(found.rows.iter().map(|(_, speed)| *speed).fold(0.0, f64::max) / old.most()),
        residual: Residual::of(&si, "deg"),
        points: si.len(),
        notes,
        warnings: warnings(section, &curves, &found, actuator.bend),
        plots: plots(&name, section.kind, sign, &found, &runs, &residuals),
    })
}

/// What is to be looked at: points that are far off, and bends that were not filmed.
fn warnings(section: &Section, curves: &[Curve], found: &Fit, bend: Option<(f64, f64)>) -> Vec<String> {
    let mut out = Vec::new();
    let all: usize = curves.iter().map(|curve| curve.points.len()).sum();
    if let Some((run, place)) = found.far.first() {
        let at = curves.get(*run).and_then(|curve| Some((curve, curve.points.get(*place)?)));
        let first = at.map_or(String::new(), |(curve, (time, bend))| {
            format!(": the first in {}, at {time:.2} s and {:.0} deg", called(curve), bend.to_degrees())
        });
        out.push(format!(
            "`{}`: {} of {all} points are far from the fit and hardly count{first}. Look at the page.",
            section.name,
            found.far.len()
        ));
    }
    for curve in curves {
        let Some((time, bend)) = lone_end(&curve.points) else { continue };
        out.push(format!(
            "`{}`: the point of {} at {time:.2} s and {:.0} deg, at an end of the film, is far from the next point, and no other step is as \
             large. The speed depends on where a run begins and ends: look at that picture, or leave the point out.",
            section.name,
            called(curve),
            bend.to_degrees()
        ));
    }
    if found.is_thin {
        out.push(format!(
            "`{}`: {all} points of {} are too few to show how accurate the speed is, or whether one of them is wrong. Read \
             more pictures of the film while it moves: ten or more of each run.",
            section.name,
            if curves.len() == 1 { "one run".to_owned() } else { format!("{} runs", curves.len()) }
        ));
    }
    let (least, fastest) =
        found.alone.iter().fold((f64::INFINITY, 0.0_f64), |(a, b), x| (a.min(*x), b.max(*x)));
    if fastest > DIFFERENT * least {
        let shares: Vec<String> = found.alone.iter().map(|share| format!("{share:.2}")).collect();
        out.push(format!(
            "`{}`: its runs differ: fitted one by one, they are {} times as fast as in the fit of all runs. The interval shows how well their \
             middle value is known; if the runs should be the same, check how they were filmed.",
            section.name,
            shares.join(", ")
        ));
    }
    let most = found.motions.iter().map(Motion::most).fold(0.0, f64::max);
    let needs = bend.map_or(0.0, |(low, high)| low.abs().max(high.abs()));
    // A tenth of the way, the fit itself says.
    if most < 0.9 * needs {
        out.push(format!(
            "`{}`: the film ends at a bend of {:.0} deg, but the actuator bends by {:.0} deg in the grammar; beyond the film, \
             sgc uses the last speed.",
            section.name,
            most.to_degrees(),
            needs.to_degrees()
        ));
    }
    if needs > 0.0 && most > BEYOND * needs {
        out.push(format!(
            "`{}`: the film goes up to a bend of {:.0} deg, but the actuator bends by at most {:.0} deg in the grammar: check the unit, \
             and whether the grammar's `bend` is that of the whole actuator.",
            section.name,
            most.to_degrees(),
            needs.to_degrees()
        ));
    }
    let other = found.motions.iter().map(Motion::on_the_other_side).fold(0.0, f64::max);
    if other > OTHER_SIDE * most {
        out.push(format!(
            "`{}`: a run crosses the straight position: {:.0} deg of its way are on the other side, where the actuator relaxes while the bend grows. \
             Film each side by itself, as `deflate` and `inflate`.",
            section.name,
            other.to_degrees()
        ));
    }
    let least = found.motions.iter().map(Motion::least).fold(f64::INFINITY, f64::min);
    if least > BENT * most {
        out.push(format!(
            "`{}`: the film shows no bend below {:.0} deg; there, sgc uses the first speed of the table. Film the whole way from rest or to rest, \
             or subtract the bend at rest from the angles.",
            section.name,
            least.to_degrees()
        ));
    }
    out
}

/// The first or the last point of a run, if it is alone there: the way to its neighbour is a part of the whole way that counts, and
/// is gone faster than twice as fast as any other.
fn lone_end(points: &[(f64, f64)]) -> Option<(f64, f64)> {
    let steps: Vec<(f64, f64)> = points
        .windows(2)
        .filter_map(|pair| match pair {
            [(t, a), (u, b)] if u > t => Some(((b - a).abs(), (b - a).abs() / (u - t))),
            _ => None,
        })
        .collect();
    let (least, most) = points
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (_, bend)| (low.min(*bend), high.max(*bend)));
    let is_alone = |end: usize| {
        let (way, speed) = steps.get(end).copied().unwrap_or_default();
        let others = steps.iter().enumerate().filter(|(place, _)| *place != end);
        let fastest = others.map(|(_, (_, speed))| *speed).fold(0.0, f64::max);
        steps.len() >= LONE_STEPS && way > LONE_WAY * (most - least) && speed > LONE_SPEED * fastest
    };
    if is_alone(0) {
        points.first().copied()
    } else if is_alone(steps.len().saturating_sub(1)) {
        points.last().copied()
    } else {
        None
    }
}

/// What the grammar says of a speed.
fn so_far(speed: &Speed) -> String {
    let dimension = Dimension::ANGULAR_VELOCITY;
    match speed {
        Speed::Constant(speed) => shown(*speed, dimension),
        Speed::ByBend(table) => declared::tabulated(table, dimension),
    }
}

/// The runs, by name; their points ascend in time.
fn curves(section: &Section) -> Vec<Curve> {
    let mut curves: BTreeMap<&str, Curve> = BTreeMap::new();
    let named = section.words("run");
    for (row, point) in section.numbers("time").iter().zip(section.numbers("angle")).enumerate() {
        let name = named.get(row).map_or("", String::as_str);
        let curve =
            curves.entry(name).or_insert_with(|| Curve { name: name.to_owned(), points: Vec::new(), row });
        curve.points.push((*point.0, *point.1));
    }
    let mut all: Vec<Curve> = curves.into_values().collect();
    for curve in &mut all {
        curve.points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    }
    all
}

/// What a curve is called in a message.
fn called(curve: &Curve) -> String {
    if curve.name.is_empty() { "the curve".to_owned() } else { format!("run `{}`", curve.name) }
}

/// 1 where the bend grows in numbers, -1 where it falls: all runs must do the same, and what the kind says.
fn sign(section: &Section, curves: &[Curve]) -> Result<f64, Vec<Problem>> {
    let mut problems = Vec::new();
    let mut signs: Vec<f64> = Vec::new();
    for curve in curves {
        let place = section.place(curve.row);
        let (points, many) = (&curve.points, curve.points.len());
        let between = points.windows(2).filter_map(|two| Some(two.last()?.0 - two.first()?.0));
        let longest = between.fold(0.0, f64::max);
        if longest > FURTHEST {
            let gap = Figure::of(longest, None, "s");
            problems.push(Problem::unreadable(
                place,
                format!(
                    "{} of `{}` has {gap} between two of its points, but the limit is {FURTHEST} s: give its times in s or ms, and each \
                     film a `run` of its own",
                    called(curve),
                    section.name
                ),
            ));
            continue;
        }
        let distinct = points.windows(2).filter(|w| matches!(w, [a, b] if b.0 > a.0)).count() + 1;
        if many < FEWEST || distinct < FEWEST {
            let has = match (many, distinct) {
                (1, _) => "only 1 point".to_owned(),
                (many, _) if many < FEWEST => format!("only {many} points"),
                (many, 1) => format!("{many} points, all at the same time"),
                (many, distinct) => format!("{many} points, but at only {distinct} different times"),
            };
            problems.push(Problem::unreadable(
                place,
                format!(
                    "{} of `{}` has {has}: a curve needs {FEWEST} or more, at different times",
                    called(curve),
                    section.name
                ),
            ));
            continue;
        }
        let third = (many / 3).max(1);
        let mean = |part: &[(f64, f64)]| part.iter().map(|p| p.1).sum::<f64>() / part.len().max(1) as f64;
        let first = mean(points.get(..third).unwrap_or(points));
        let last = mean(points.get(many - third..).unwrap_or(points));
        let (low, high) = points
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), (_, bend)| (a.min(*bend), b.max(*bend)));
        let is_still = (last.abs() - first.abs()).abs() < LEAST_WAY;
        if is_still && first.abs().min(last.abs()) > LEAST_WAY && first * last < 0.0 {
            problems.push(Problem::contradiction(
                place,
                format!(
                    "{} of `{}` goes as far to one side as to the other: film each side by itself, as `deflate` and `inflate`",
                    called(curve),
                    section.name
                ),
            ));
            continue;
        }
        if high - low < LEAST_WAY || is_still {
            problems.push(Problem::unreadable(
                place,
                format!(
                    "the bend of {} of `{}` changes by less than {:.0} deg, so there is no speed to find",
                    called(curve),
                    section.name,
                    LEAST_WAY.to_degrees()
                ),
            ));
            continue;
        }
        let grows = last.abs() > first.abs();
        let expected = section.kind != Kind::Deflate;
        if grows != expected {
            let (does, other) =
                if grows { ("grows", Kind::Inflate.text()) } else { ("goes back", Kind::Deflate.text()) };
            problems.push(Problem::contradiction(
                place,
                format!(
                    "the bend of {} {does}, so `{}` should be of kind `{other}`{}",
                    called(curve),
                    section.name,
                    // Rows of several runs, one after another, may do anything as one curve.
                    if curve.name.is_empty() {
                        "; or its rows are of several runs: then give them a column `run`"
                    } else {
                        ""
                    }
                ),
            ));
        }
        signs.push(if last > first { 1.0 } else { -1.0 });
    }
    if !problems.is_empty() {
        return Err(problems);
    }
    match signs.first() {
        Some(first) if signs.iter().all(|sign| sign == first) => Ok(*first),
        _ => Err(vec![Problem::contradiction(
            &section.place,
            format!(
                "some runs of `{}` bend to one side and some to the other: measure one side",
                section.name
            ),
        )]),
    }
}

/// Says that a curve is not of one motion.
fn stray(section: &Section, curve: &Curve, run: &Run) -> Option<Problem> {
    let bends: Vec<f64> = run.points.iter().map(|(_, bend)| *bend).collect();
    let course = course(&bends);
    let way = course.last()? - course.first()?;
    let mean = bends.iter().zip(&course).map(|(a, b)| (a - b) * (a - b)).sum::<f64>() / bends.len() as f64;
    (mean.sqrt() > STRAY * way).then(|| {
        Problem::contradiction(
            section.place(curve.row),
            format!(
                "{} of `{}` goes back and forth: give each motion a `run` of its own, from rest to rest",
                called(curve),
                section.name
            ),
        )
    })
}

/// Says that no run has enough pictures of the motion itself: the speed is then any that is not too low.
fn unseen(section: &Section, curves: &[Curve], runs: &[Run]) -> Option<Problem> {
    if trajectory::telling(runs) > 0 {
        return None;
    }
    let (curve, run) = curves.iter().zip(runs).next()?;
    let seen = match run.moving() {
        0 => "no picture".to_owned(),
        1 => "one picture".to_owned(),
        many => format!("{many} pictures"),
    };
    Some(Problem::contradiction(
        section.place(curve.row),
        format!(
            "{} of `{}` has {seen} of the motion itself, but a speed needs two or more, and an interval needs ten: film with more \
             pictures a second, or read off more of them while it moves",
            called(curve),
            section.name
        ),
    ))
}

/// Time from the run's own beginning (s), residual (rad), run.
fn residuals(found: &Fit, runs: &[Run]) -> Vec<(f64, f64, usize)> {
    let mut out = Vec::new();
    for (i, (run, motion)) in runs.iter().zip(&found.motions).enumerate() {
        let first = run.points.first().map_or(0.0, |p| p.0);
        out.extend(run.points.iter().map(|(time, bend)| (time - first, bend - found.bend(motion, *time), i)));
    }
    out
}

fn plots(
    name: &str,
    kind: Kind,
    sign: f64,
    found: &Fit,
    runs: &[Run],
    residuals: &[(f64, f64, usize)],
) -> Vec<Plot> {
    let (title, speed) = if kind == Kind::Deflate {
        (format!("`{name}` goes back"), format!("Relaxing speed of `{name}`"))
    } else {
        (format!("`{name}` bends"), format!("Bending speed of `{name}`"))
    };
    let mut motion =
        Plot { title, x: "time (s)".into(), y: "bend (deg)".into(), unit: "deg".into(), ..Plot::default() };
    for (i, (run, own)) in runs.iter().zip(&found.motions).enumerate() {
        let (Some(first), Some(last)) = (run.points.first(), run.points.last()) else { continue };
        motion.points.extend(run.points.iter().map(|(t, b)| (t - first.0, (sign * b).to_degrees(), i)));
        let line = (0..=160).map(|k| {
            let time = first.0 + (last.0 - first.0) * f64::from(k) / 160.0;
            (time - first.0, (sign * found.bend(own, time)).to_degrees())
        });
        motion.fit.push((line.collect(), i));
    }
    motion.residuals = residuals.iter().map(|(t, r, i)| (*t, (sign * r).to_degrees(), *i)).collect();
    let mut rows: Vec<(f64, f64)> =
        found.rows.iter().map(|(b, v)| ((sign * b).to_degrees(), v.to_degrees())).collect();
    if let [(_, only)] = rows.as_slice() {
        let ends = found.motions.iter().zip(runs).flat_map(|(own, run)| {
            run.points.iter().map(move |(time, _)| (sign * found.bend(own, *time)).to_degrees())
        });
        let (low, high) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), b| (l.min(b), h.max(b)));
        rows = vec![(low, *only), (high, *only)];
    }
    if sign < 0.0 {
        rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    let table = Plot {
        title: speed,
        x: "bend (deg)".into(),
        y: "speed (deg/s)".into(),
        fit: vec![(rows.clone(), 0)],
        rows,
        ..Plot::default()
    };
    vec![motion, table]
}
