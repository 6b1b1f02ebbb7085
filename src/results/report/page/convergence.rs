//! The best value so far, drawn.

use super::chart::{Chart, Scale, hint};
use super::words::{count, counted, figures, key, paragraph, value};
use super::{Link, about, axis, colour, names};
use crate::results::report::gather::convergence::{Against, Point, course, half_way, still_rising};
use crate::results::report::read::Group;

pub(super) fn section(groups: &[Group], _: Link) -> String {
    let charts: Vec<String> =
        [Against::Evaluations, Against::Moves].into_iter().filter_map(|against| chart(groups, against)).collect();
    if charts.is_empty() {
        return "<p>No run has a value yet.</p>\n".to_owned();
    }
    let marks = [("line", "mean of the runs"), ("band", "from the worst to the best run"), ("line thin", "the run that is best in the end")];
    let marks = marks.map(|(class, text)| (class.to_owned(), text.to_owned()));
    let all: Vec<(String, String)> = names(groups).into_iter().chain(marks).collect();
    key(&all) + &figures(&charts) + &paragraph(&said(groups))
}

fn chart(groups: &[Group], against: Against) -> Option<String> {
    let courses: Vec<Vec<Point>> = groups.iter().map(|group| course(group, against)).collect();
    let points = || courses.iter().flatten();
    points().next()?;
    let x = Scale::of(points().map(|p| p.x as f64).chain([0.0]), 5);
    let y = Scale::of(points().flat_map(|p| [p.min, p.max]).chain([0.0]), 5);
    let x_label = match against {
        Against::Evaluations => "evaluations (simulated motions)",
        Against::Moves => "outer moves (bodies tried)",
    };
    let mut chart = Chart::new(Chart::HALF, (x, x_label), (y, &axis("best value so far", groups.first())));
    for (i, (group, course)) in groups.iter().zip(&courses).enumerate() {
        let of = |y: fn(&Point) -> f64| course.iter().map(|p| (p.x as f64, y(p))).collect::<Vec<_>>();
        let mut band = of(|p| p.max);
        band.extend(of(|p| p.min).into_iter().rev());
        let best: Vec<(f64, f64)> = course.iter().filter_map(|p| Some((p.x as f64, p.best?))).collect();
        let class = colour(i);
        let hints = course.last().map_or(String::new(), |p| {
            let of = |x: f64| value(x, &group.unit);
            hint(&format!("{}: mean {}, {} to {} after {} {}", group.name, of(p.mean), of(p.min), of(p.max), p.x, against.text()))
        });
        let area = format!("<path class=\"band {class}\" d=\"{}Z\">{hints}</path>", chart.course(&band));
        let thin = format!("<path class=\"line thin {class}\" d=\"{}\"/>", chart.course(&best));
        let mean = format!("<path class=\"line {class}\" d=\"{}\">{hints}</path>", chart.course(&of(|p| p.mean)));
        chart.add(&(area + &thin + &mean));
    }
    Some(chart.finish(&format!("best value so far against {}", against.text())))
}

/// What is seen, in words.
fn said(groups: &[Group]) -> Vec<String> {
    let mut said = Vec::new();
    for group in groups {
        let about = about(groups, group);
        let Some(last) = course(group, Against::Evaluations).pop() else {
            said.push(format!("{about}no value yet."));
            continue;
        };
        let of = |x: f64| value(x, &group.unit);
        let half = half_way(group).map_or(String::new(), |n| {
            format!(" Half of what a run gained it had after {} on average.", counted(n.round() as u64, "evaluation"))
        });
        let runs = if group.runs.len() == 1 {
            format!("{} after {}.", of(last.mean), counted(last.x, "evaluation"))
        } else {
            format!(
                "a mean of {} after {}, from {} to {} ({}).",
                of(last.mean),
                counted(last.x, "evaluation"),
                of(last.min),
                of(last.max),
                counted(last.runs as u64, "run")
            )
        };
        said.push(format!("{about}{}{half}", capital(&about, &runs)));
        let late = still_rising(group);
        if late > 0 {
            said.push(format!(
                "{} of {} found their best in the last tenth of their evaluations: a longer run may find better.",
                late,
                counted(group.runs.len() as u64, "run")
            ));
        }
        let open = group.runs.iter().filter(|run| !run.is_complete()).count();
        if open > 0 && group.runs.len() > 1 {
            said.push(format!(
                "{} not complete yet: beyond where they are, the mean is of the others, and may jump.",
                if open == 1 { "One run is".to_owned() } else { format!("{} runs are", count(open as u64)) }
            ));
        }
    }
    said
}

/// A sentence that nothing stands before begins with a capital.
fn capital(before: &str, sentence: &str) -> String {
    let mut letters = sentence.chars();
    match letters.next() {
        Some(first) if before.is_empty() => first.to_uppercase().chain(letters).collect(),
        _ => sentence.to_owned(),
    }
}
