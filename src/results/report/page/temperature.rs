//! The temperature and what was accepted, drawn.

use super::chart::{Chart, Scale, hint};
use super::words::{counted, figures, key, percent};
use super::{Link, axis, colour, names, told};
use crate::results::report::gather::spread::share;
use crate::results::report::gather::temperature::{Window, windows};
use crate::results::report::read::Group;

pub(super) fn section(groups: &[Group], _: Link) -> String {
    let all: Vec<Vec<Window>> = groups.iter().map(windows).collect();
    if all.iter().all(Vec::is_empty) {
        return "<p>No move was made.</p>\n".to_owned();
    }
    let names = names(groups);
    let key = if names.is_empty() { String::new() } else { key(&names) };
    // Where nothing anneals, there is no temperature to show.
    let pictures = if all.iter().any(|windows| is_heated(windows)) {
        figures(&[temperature(groups, &all), acceptance(&all)]) + NOTE
    } else {
        figures(&[acceptance(&all)]) + COLD_NOTE
    };
    let told = groups.iter().zip(&all).map(|(group, windows)| told(groups, group, &said(windows)));
    key + &pictures + &told.collect::<String>()
}

/// Whether a temperature decides on what is accepted.
fn is_heated(windows: &[Window]) -> bool {
    windows.iter().any(|window| window.temperature > 0.0)
}

/// The middle of a window.
fn middle(window: &Window) -> f64 {
    (window.moves.0 + window.moves.1) as f64 / 2.0
}

fn moves(all: &[Vec<Window>]) -> Scale {
    Scale::until(all.iter().flatten().map(|w| w.moves.1 as f64).chain([0.0]).collect::<Vec<_>>(), 5)
}

fn temperature(groups: &[Group], all: &[Vec<Window>]) -> String {
    let y = Scale::of(all.iter().flatten().map(|w| w.temperature).chain([0.0]), 5);
    let mut chart =
        Chart::new(Chart::HALF, (moves(all), "moves of bodies"), (y, &axis("temperature", groups.first())));
    for (i, windows) in all.iter().enumerate() {
        let points: Vec<(f64, f64)> = windows.iter().map(|w| (middle(w), w.temperature)).collect();
        let course = chart.course(&points);
        chart.add(&format!("<path class=\"line {}\" d=\"{course}\"/>", colour(i)));
    }
    chart.finish("temperature against moves of bodies")
}

fn acceptance(all: &[Vec<Window>]) -> String {
    let y = Scale::of([0.0, 100.0], 5);
    let mut chart = Chart::new(Chart::HALF, (moves(all), "moves of bodies"), (y, "accepted designs (%)"));
    for (i, windows) in all.iter().enumerate() {
        let class = colour(i);
        let points: Vec<(f64, f64, &Window)> =
            windows.iter().filter_map(|w| Some((middle(w), w.acceptance? * 100.0, w))).collect();
        let plain: Vec<(f64, f64)> = points.iter().map(|(x, y, _)| (*x, *y)).collect();
        let course = chart.course(&plain);
        chart.add(&format!("<path class=\"line {class}\" d=\"{course}\"/>"));
        for (x, y, window) in points {
            let told = format!(
                "moves {} to {}: {} of {} designs accepted, {} moves did nothing",
                window.moves.0, window.moves.1, window.accepted, window.tried, window.nothing
            );
            let (x, y) = (chart.x(x), chart.y(y));
            chart.add(&format!(
                "<circle class=\"dot {class}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"2.5\">{}</circle>",
                hint(&told)
            ));
        }
    }
    chart.finish("share of accepted designs against moves of bodies")
}

const NOTE: &str = "<p class=\"small\">A point is a window of moves in a row, a mean over the runs. A temperature of T accepts a loss of T with probability 1/e (37 %).</p>\n";
const COLD_NOTE: &str = "<p class=\"small\">A point is a window of moves in a row, a mean over the runs. This search has no temperature.</p>\n";
/// Windows with fewer designs say nothing of a rate.
const ENOUGH: u64 = 20;

/// What is seen, in words.
fn said(windows: &[Window]) -> Vec<String> {
    let (tried, accepted, nothing) =
        windows.iter().fold((0, 0, 0), |sum, w| (sum.0 + w.tried, sum.1 + w.accepted, sum.2 + w.nothing));
    let Some(rate) = share(accepted, tried) else { return vec!["No design was tried.".to_owned()] };
    let mut said =
        vec![format!("{} of {} became the current design.", percent(rate), counted(tried, "design"))];
    let late = windows.iter().rev().filter(|w| w.tried >= ENOUGH).find_map(|w| w.acceptance);
    if let Some(late) = late.filter(|late| *late > 0.5) {
        let why = if is_heated(windows) {
            "losses are small compared with the temperature, and the search wanders more than it selects"
        } else {
            "the search takes most of what it tries"
        };
        said.push(format!("At the end {} are still accepted: {why}.", percent(late)));
    }
    if let Some(late) = late.filter(|late| *late < 0.01) {
        said.push(format!("At the end {} are accepted: the search is frozen.", percent(late)));
    }
    if let Some(idle) = share(nothing, tried + nothing).filter(|idle| *idle > 0.01) {
        said.push(format!(
            "In {} of the moves that were to change a body no rule could be applied.",
            percent(idle)
        ));
    }
    said
}
