//! The table of moves, `evals.csv`.

use std::fs;
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use grammar_lang::ir::{Objective, RuleSet, objective_name};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::columns::{OBSERVED, distinct};
use super::saved::hex;
use super::whole::{check_no_link, is_same};
use super::{FileError, Unfit};
use crate::search::Row;

use crate::reading;

const COLUMNS: &str = "move,iteration,rule,blocked,parts,actuators,value,accepted,best,temperature,evaluations,invalid,unstable,why_invalid,nominal,chain,parent,tuned";
/// The last column that every table has; those of objectives beside the first stand before it, those of what is observed behind it.
const LAST: &str = "at_most_in";

/// What each objective is of, with its unit.
pub(super) fn objectives(rules: &RuleSet) -> Vec<String> {
    let told = |objective: &Objective| {
        let name = objective_name(rules, objective);
        if objective.unit.is_empty() { name } else { format!("{name} ({})", objective.unit) }
    };
    rules.objectives().map(told).collect()
}

/// What the columns of the objectives beside the first begin with.
pub(super) const BESIDE: &str = "objective ";

/// The table, to which rows are added.
#[derive(Debug)]
pub(super) struct Evals {
    path: PathBuf,
    file: fs::File,
    /// Of all that has been written.
    sum: Sha256,
    length: u64,
    columns: More,
    /// How many evaluations had been spent at the last row that was there when it was opened, also one that was cut off.
    reached: u64,
}

/// The columns that not every table has.
#[derive(Clone, Debug, Default)]
pub(super) struct More {
    /// Of the objectives beside the first, where a front is searched for.
    pub(super) beside: Vec<String>,
    /// Of what is observed.
    pub(super) observed: Vec<String>,
}

impl More {
    /// Those of a rule set.
    pub(super) fn of(rules: &RuleSet) -> Self {
        let beside = objectives(rules).into_iter().skip(1);
        let beside = beside.map(|name| format!("{BESIDE}{name}")).collect();
        Self { beside, observed: rules.observed.clone() }
    }

    /// The first line of a table.
    fn head(&self) -> String {
        let beside = self.beside.iter().map(|name| quoted(name));
        let fixed = || COLUMNS.split(',').chain([LAST]);
        let observed = self.observed.iter().map(|name| distinct(name, OBSERVED, fixed()));
        let more: String =
            beside.chain([LAST.to_owned()]).chain(observed).map(|name| format!(",{name}")).collect();
        format!("{COLUMNS}{more}\n")
    }
}

/// How far a table was written, and what was in it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Mark {
    bytes: u64,
    sha256: String,
}

impl Mark {
    /// The beginning of a table that was counted; none if it is another now.
    fn counted<'t>(&self, table: &'t [u8]) -> Option<&'t [u8]> {
        let counted = usize::try_from(self.bytes).ok().and_then(|length| table.get(..length))?;
        (hex(&Sha256::digest(counted)) == self.sha256).then_some(counted)
    }

    /// How many lines of a table were counted.
    ///
    /// # Errors
    ///
    /// A sentence: they were changed.
    pub(super) fn rows(&self, table: &Path) -> Result<usize, FileError> {
        let bytes = reading::own(table).map_err(FileError::read(table))?;
        let counted = self.counted(&bytes).ok_or_else(|| FileError::unfit(table, Unfit::OtherRows))?;
        Ok(counted.iter().filter(|byte| **byte == b'\n').count())
    }

    /// Whether a table is all that was counted, and nothing else.
    pub(super) fn is_of(&self, table: &[u8]) -> bool {
        self.counted(table).is_some_and(|counted| counted.len() == table.len())
    }
}

impl Evals {
    /// A table without rows.
    pub(super) fn create(path: &Path, columns: More) -> Result<Self, FileError> {
        let file = fs::File::create(path).map_err(FileError::write(path))?;
        let (path, sum) = (path.to_owned(), Sha256::new());
        let head = columns.head();
        let mut evals = Self { path, file, sum, length: 0, columns, reached: 0 };
        evals.write(&head)?;
        Ok(evals)
    }

    /// The table as it was when it was marked: rows that were added later are cut off.
    pub(super) fn reopen(path: &Path, mark: &Mark, columns: More) -> Result<Self, FileError> {
        let bytes = reading::own(path).map_err(FileError::read(path))?;
        let Some(counted) = mark.counted(&bytes) else {
            return Err(FileError::unfit(path, Unfit::OtherRows));
        };
        let sum = Sha256::new_with_prefix(counted);
        let mut file = fs::OpenOptions::new().write(true).open(path).map_err(FileError::write(path))?;
        file.set_len(mark.bytes).map_err(FileError::write(path))?;
        file.seek(SeekFrom::End(0)).map_err(FileError::write(path))?;
        Ok(Self { path: path.to_owned(), file, sum, length: mark.bytes, columns, reached: spent(&bytes) })
    }

    /// How many evaluations had been spent at the last row that was there when the table was opened, also one that was cut off.
    pub(super) fn reached(&self) -> u64 {
        self.reached
    }

    /// Where the table is from now on: its folder was moved.
    pub(super) fn moved(&mut self, path: PathBuf) {
        self.path = path;
    }

    /// Adds a row.
    pub(super) fn row(&mut self, row: &Row) -> Result<(), FileError> {
        let number = |x: Option<f64>| x.map_or(String::new(), |x| format!("{x}"));
        let blocked: Vec<String> = row.blocked.iter().map(|(rule, why)| format!("{rule}: {why}")).collect();
        let mut line = format!(
            "{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}",
            row.number,
            row.iteration,
            row.rule.as_deref().unwrap_or(""),
            quoted(&blocked.join("; ")),
            row.size.0,
            row.size.1,
            number(row.value),
            row.accepted,
            number(row.best),
            row.temperature,
            row.evaluations,
            row.tally.invalid(),
            row.tally.unstable,
            quoted(&row.tally.reasons_in_worlds()),
            number(row.nominal),
            row.chain,
            row.parent.map_or(String::new(), |parent| parent.to_string()),
            row.tuned,
        );
        for column in 0..self.columns.beside.len() {
            line += &format!(",{}", number(row.beside.get(column).copied()));
        }
        line += &format!(",{}", row.at_most_in.map_or(String::new(), |worlds| worlds.to_string()));
        for column in 0..self.columns.observed.len() {
            let value = row.observed.get(column).and_then(Option::as_ref);
            line += &format!(",{}", value.map_or(String::new(), ToString::to_string));
        }
        line += "\n";
        self.write(&line)
    }

    fn write(&mut self, text: &str) -> Result<(), FileError> {
        // Somebody may have cut it: what is written beyond its end would leave a hole.
        let length = self.file.metadata().map_err(FileError::read(&self.path))?.len();
        if length != self.length {
            return Err(FileError::unfit(&self.path, Unfit::TakenAway));
        }
        self.file.write_all(text.as_bytes()).map_err(FileError::write(&self.path))?;
        self.sum.update(text);
        self.length += text.len() as u64;
        Ok(())
    }

    /// How far it is written; all of that is on the disk when this returns.
    pub(super) fn mark(&self) -> Result<Mark, FileError> {
        self.file.sync_data().map_err(FileError::write(&self.path))?;
        check_no_link(&self.path)?;
        let length = self.file.metadata().map_err(FileError::read(&self.path))?.len();
        if !is_same(&self.path, &self.file) || length != self.length {
            return Err(FileError::unfit(&self.path, Unfit::TakenAway));
        }
        Ok(Mark { bytes: self.length, sha256: hex(&self.sum.clone().finalize()) })
    }
}

/// What the last whole row of a table says of the evaluations that were spent; none if there is no such row.
fn spent(table: &[u8]) -> u64 {
    let whole = table.iter().rposition(|byte| *byte == b'\n').map_or(&[][..], |end| &table[..end]);
    let begin = whole.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
    let Some(column) = COLUMNS.split(',').position(|name| name == "evaluations") else { return 0 };
    let mut reader = csv::ReaderBuilder::new().has_headers(false).flexible(true).from_reader(&whole[begin..]);
    let row = reader.records().next().and_then(Result::ok);
    row.and_then(|row| row.get(column)?.parse().ok()).unwrap_or(0)
}

/// A text as a field of a csv file.
pub(super) fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_tells_how_far_its_run_was() {
        let head = More::default().head();
        assert_eq!(spent(head.as_bytes()), 0, "no row yet");
        let table = format!(
            "{head}1,1,grow,\"a: b, c\",2,1,3.5,true,3.5,1,24,0,0,,,0,0,0,\n2,1,grow,,2,1,3.5,true,3.5,1,48,0,0,,,0,0,0,\n"
        );
        assert_eq!(spent(table.as_bytes()), 48);
        // A process that was killed may leave half a row.
        assert_eq!(spent(format!("{table}3,1,grow,,2,1,3.5,true,3.5,1,7").as_bytes()), 48);
        assert_eq!(spent(b""), 0);
    }

    #[test]
    fn rows_after_a_mark_are_cut_off_and_changed_rows_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("evals.csv");
        let mut evals = Evals::create(&path, More::default()).unwrap();
        evals.write("one\n").unwrap();
        let mark = evals.mark().unwrap();
        evals.write("two\nhal").unwrap();
        drop(evals);

        let mut evals = Evals::reopen(&path, &mark, More::default()).unwrap();
        assert_eq!(evals.mark().unwrap(), mark);
        evals.write("three\n").unwrap();
        let now = evals.mark().unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), format!("{COLUMNS},{LAST}\none\nthree\n"));
        assert_eq!(Evals::reopen(&path, &now, More::default()).unwrap().mark().unwrap(), now);

        fs::write(&path, format!("{COLUMNS},{LAST}\nodd\nthree\n")).unwrap();
        assert!(
            Evals::reopen(&path, &mark, More::default()).unwrap_err().to_string().contains("was changed")
        );
        fs::write(&path, "move").unwrap();
        assert!(
            Evals::reopen(&path, &mark, More::default()).unwrap_err().to_string().contains("was changed")
        );
        assert_eq!(fs::read_to_string(&path).unwrap(), "move", "what is refused stays as it is");
    }

    #[cfg(unix)]
    #[test]
    fn a_table_that_was_taken_away_is_found() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("evals.csv");
        let evals = Evals::create(&path, More::default()).unwrap();
        fs::rename(&path, folder.path().join("aside")).unwrap();
        fs::write(&path, COLUMNS).unwrap();
        assert!(evals.mark().unwrap_err().to_string().contains("removed, replaced"));
    }

    #[test]
    fn a_table_that_was_emptied_is_found() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("evals.csv");
        let evals = Evals::create(&path, More::default()).unwrap();
        fs::write(&path, "").unwrap();
        assert!(evals.mark().unwrap_err().to_string().contains("changed"));
    }
}
