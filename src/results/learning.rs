//! The table of a learner's iterations, `learning.csv`: its learning curve.

use std::path::Path;

use grammar_lang::ir::RuleSet;

use super::evals::quoted;
use super::whole::{read, write_own};
use super::{FileError, Unfit};
use crate::search::Learned;

/// What the table is called in the folder of a run.
pub(super) const LEARNING: &str = "learning.csv";

const COLUMNS: [&str; 8] =
    ["task", "iteration", "evaluations", "motions", "reward", "exploration", "value", "best"];

/// A row of the table.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Row {
    pub(crate) task: String,
    /// From 1 on.
    pub(crate) iteration: u64,
    pub(crate) learned: Learned,
}

/// Writes the table into the folder of a run, as far as anything was learned.
pub(super) fn write(
    folder: &Path,
    rules: &RuleSet,
    learned: &[(usize, &[Learned])],
) -> Result<(), FileError> {
    if learned.iter().all(|(_, all)| all.is_empty()) {
        return Ok(());
    }
    let number = |x: Option<f64>| x.map_or(String::new(), |x| x.to_string());
    let mut text = COLUMNS.join(",") + "\n";
    for (task, all) in learned {
        let name = rules.tasks.get_index(*task).map_or("", |(name, _)| name.as_str());
        for (iteration, Learned { evaluations, motions, reward, exploration, value, best }) in
            all.iter().enumerate()
        {
            let cells = [
                quoted(name),
                (iteration + 1).to_string(),
                evaluations.to_string(),
                motions.to_string(),
                number(*reward),
                exploration.to_string(),
                number(*value),
                number(*best),
            ];
            text += &(cells.join(",") + "\n");
        }
    }
    write_own(&folder.join(LEARNING), &text)
}

/// Reads the table of a run; no rows where it has none.
///
/// # Errors
///
/// It cannot be read, or a line is no row of such a table.
pub(crate) fn rows(folder: &Path) -> Result<Vec<Row>, FileError> {
    let path = folder.join(LEARNING);
    if !path.exists() {
        return Ok(Vec::new());
    }
    let text = read(&path)?;
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let records: Vec<_> = reader.records().enumerate().collect();
    let row = |(place, record): (usize, Result<csv::StringRecord, csv::Error>)| {
        record
            .ok()
            .and_then(|record| of_record(&record))
            .ok_or_else(|| FileError::unfit(&path, Unfit::NoRow { line: place + 2, table: LEARNING }))
    };
    records.into_iter().map(row).collect()
}

fn of_record(record: &csv::StringRecord) -> Option<Row> {
    let cells: Vec<&str> = record.iter().collect();
    let [task, iteration, evaluations, motions, reward, exploration, value, best] = cells.try_into().ok()?;
    let number = |cell: &str| cell.parse::<f64>().ok().filter(|x| x.is_finite());
    let or_none = |cell: &str| if cell.is_empty() { Some(None) } else { number(cell).map(Some) };
    Some(Row {
        task: task.to_owned(),
        iteration: iteration.parse().ok()?,
        learned: Learned {
            evaluations: evaluations.parse().ok()?,
            motions: motions.parse().ok()?,
            reward: or_none(reward)?,
            exploration: number(exploration)?,
            value: or_none(value)?,
            best: or_none(best)?,
        },
    })
}
