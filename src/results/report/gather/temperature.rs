//! The temperature, and the share of designs that became the current one, over the moves of bodies.

use super::spread::{mean, share};
use super::{or_empty, table};
use crate::results::report::moves::Move;
use crate::results::report::read::Group;

/// At most about so many windows.
const WINDOWS: u64 = 40;

/// Some moves in a row.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Window {
    /// The first and last move.
    pub(crate) moves: (u64, u64),
    /// Runs with moves in it.
    pub(crate) runs: usize,
    /// Mean over the runs.
    pub(crate) temperature: f64,
    /// Designs that were tried, in all runs.
    pub(crate) tried: u64,
    /// Of these: became the current design.
    pub(crate) accepted: u64,
    /// Moves for which no rule could be applied.
    pub(crate) nothing: u64,
    /// The share that was accepted: mean over the runs that tried any.
    pub(crate) acceptance: Option<f64>,
}

/// How many moves are in a window, where the longest run has so many: 1, 2 or 5 with zeros after it.
fn width(longest: u64) -> u64 {
    let steps = (0..18).flat_map(|zeros| [1, 2, 5].map(|step| step * 10_u64.pow(zeros)));
    steps.into_iter().find(|step| step * WINDOWS >= longest).unwrap_or(longest)
}

/// The windows of a group. The initial design is no move.
pub(crate) fn windows(group: &Group) -> Vec<Window> {
    let longest = group.runs.iter().filter_map(|run| run.moves.last()).map(|m| m.number).max().unwrap_or(0);
    let width = width(longest);
    let first = (1..=longest).step_by(usize::try_from(width).unwrap_or(usize::MAX).max(1));
    first.filter_map(|first| window(group, (first, (first + width - 1).min(longest)))).collect()
}

fn window(group: &Group, (first, last): (u64, u64)) -> Option<Window> {
    let inside = |moves: &[Move]| -> Vec<Move> {
        let from = moves.partition_point(|m| m.number < first);
        let until = moves.partition_point(|m| m.number <= last);
        moves.get(from..until).map(<[Move]>::to_vec).unwrap_or_default()
    };
    let runs: Vec<Vec<Move>> =
        group.runs.iter().map(|run| inside(&run.moves)).filter(|moves| !moves.is_empty()).collect();
    let tried = |moves: &[Move]| moves.iter().filter(|m| m.rule.is_some()).count() as u64;
    let accepted = |moves: &[Move]| moves.iter().filter(|m| m.rule.is_some() && m.accepted).count() as u64;
    let shares = runs.iter().filter_map(|moves| share(accepted(moves), tried(moves)));
    let all_tried: u64 = runs.iter().map(|moves| tried(moves)).sum();
    Some(Window {
        moves: (first, last),
        runs: runs.len(),
        temperature: mean(runs.iter().filter_map(|moves| mean(moves.iter().map(|m| m.temperature))))?,
        tried: all_tried,
        accepted: runs.iter().map(|moves| accepted(moves)).sum(),
        nothing: runs.iter().flatten().filter(|made| made.did_nothing()).count() as u64,
        acceptance: mean(shares),
    })
}

/// `temperature.csv`.
pub(crate) fn csv(groups: &[Group]) -> String {
    let columns = [
        "group",
        "first_move",
        "last_move",
        "runs",
        "temperature",
        "tried",
        "accepted",
        "nothing",
        "acceptance",
    ];
    let rows = groups.iter().flat_map(|group| {
        windows(group).into_iter().map(move |window| {
            [
                group.name.clone(),
                window.moves.0.to_string(),
                window.moves.1.to_string(),
                window.runs.to_string(),
                window.temperature.to_string(),
                window.tried.to_string(),
                window.accepted.to_string(),
                window.nothing.to_string(),
                or_empty(window.acceptance),
            ]
        })
    });
    table(columns, rows)
}

#[cfg(test)]
mod tests {
    use super::super::tests::{group, run, two};
    use super::*;

    #[test]
    fn windows_are_round_and_few() {
        let widths: Vec<u64> = [0, 1, 40, 41, 80, 81, 300, 8000].map(width).to_vec();
        assert_eq!(widths, [1, 1, 1, 2, 2, 5, 10, 200]);
    }

    #[test]
    fn what_was_accepted_is_a_share_of_what_was_tried() {
        let all = window(&two(), (1, 5)).unwrap();
        // Run 1 tried four and accepted three, and could do nothing once; run 2 tried two and accepted one.
        assert_eq!((all.runs, all.tried, all.accepted, all.nothing), (2, 6, 4, 1));
        assert_eq!(all.acceptance, Some((0.75 + 0.5) / 2.0));
        // Run 1: 9, 9, 6, 6, 6; run 2: 9, 9.
        assert!((all.temperature - (7.2 + 9.0) / 2.0).abs() < 1e-12);
        let windows = windows(&two());
        assert_eq!(windows.len(), 5);
        assert_eq!((windows[3].tried, windows[3].nothing, windows[3].acceptance), (0, 1, None));
        assert_eq!(super::windows(&group(vec![run(1, "0,0,,,1,0,0,true,0,0,1,0,0,\n")])), []);
    }
}
