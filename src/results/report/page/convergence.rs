//! The best value so far, drawn.

use super::chart::{Chart, Scale, hint};
use super::words::{count, counted, figures, key, value};
use super::{Link, axis, colour, names, told};
use crate::results::report::gather::convergence::{Against, Point, course, half_way, still_rising};
use crate::results::report::read::Group;

pub(super) fn section(groups: &[Group], _: Link) -> String {
    let charts: Vec<String> = [Against::Evaluations, Against::Moves]
        .into_iter()
        .filter_map(|against| chart(groups, against))
        .collect();
    if charts.is_empty() {
        return "<p>No run has a value yet.</p>\n".to_owned();
    }
    let marks = [
        ("line", "mean of the runs"),
        ("band", "from the worst to the best run"),
        ("line thin", "the run that is best in the end"),
    ];
    let marks = marks.map(|(class, text)| (class.to_owned(), text.to_owned()));
    let all: Vec<(String, String)> = names(groups).into_iter().chain(marks).collect();
    key(&all)
        + &figures(&charts)
        + &groups.iter().map(|group| told(groups, group, &said(group))).collect::<String>()
}

fn chart(groups: &[Group], against: Against) -> Option<String> {
    let courses: Vec<Vec<Point>> = groups.iter().map(|group| course(group, against)).collect();
    let points = || courses.iter().flatten();
    points().next()?;
    let x = Scale::until(points().map(|p| p.x as f64).chain([0.0]).collect::<Vec<_>>(), 5);
    let y = Scale::of(points().flat_map(|p| [p.min, p.max]).chain([0.0]), 6);
    let x_label = match against {
        Against::Evaluations => "evaluations (simulated motions)",
        Against::Moves => "moves (bodies tried)",
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
            hint(&format!(
                "{}: mean {}, {} to {} after {} {}",
                group.name,
                of(p.mean),
                of(p.min),
                of(p.max),
                p.x,
                against.text()
            ))
        });
        let area = format!("<path class=\"band {class}\" d=\"{}Z\">{hints}</path>", chart.course(&band));
        let thin = format!("<path class=\"line thin {class}\" d=\"{}\"/>", chart.course(&best));
        let mean =
            format!("<path class=\"line {class}\" d=\"{}\">{hints}</path>", chart.course(&of(|p| p.mean)));
        chart.add(&(area + &thin + &mean));
    }
    Some(chart.finish(&format!("best value so far against {}", against.text())))
}

/// What is seen, in words.
fn said(group: &Group) -> Vec<String> {
    let Some(last) = course(group, Against::Evaluations).pop() else {
        return vec!["No value yet.".to_owned()];
    };
    let of = |x: f64| value(x, &group.unit);
    let after = counted(last.x, "evaluation");
    let mut said = vec![if group.runs.len() == 1 {
        format!("{} after {after}.", of(last.mean))
    } else {
        let runs = counted(last.runs as u64, "run");
        format!(
            "A mean of {} after {after}, from {} to {} ({runs}).",
            of(last.mean),
            of(last.min),
            of(last.max)
        )
    }];
    if let Some(half) = half_way(group) {
        let half = counted(half.round() as u64, "evaluation");
        said.push(format!("On average, a run had half of its gain after {half}."));
    }
    match (still_rising(group), group.runs.len()) {
        (0, _) => {}
        (_, 1) => said.push(
            "The best was found in the last tenth of the evaluations: a longer run may find better.".to_owned(),
        ),
        (late, all) => said.push(format!(
            "{late} of {all} runs found their best in the last tenth of their evaluations: longer runs may find better."
        )),
    }
    let open = group.runs.iter().filter(|run| !run.is_complete()).count();
    if open > 0 && group.runs.len() > 1 {
        said.push(format!(
            "{} not complete: further on, the mean is that of the other runs, and may jump.",
            if open == 1 { "One run is".to_owned() } else { format!("{} runs are", count(open as u64)) }
        ));
    }
    said
}
