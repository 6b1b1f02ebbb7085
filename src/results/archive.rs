//! The best design of each kind, where a search keeps an archive: a saved design for each, and a table.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use grammar_lang::ir::{Descriptor, RuleSet};

use super::FileError;
use super::columns::{DESCRIPTOR, OBSERVED, distinct};
use super::saved::SavedDesign;
use super::whole::{check_no_link, read, write_own};
use crate::search::Best;

/// The folder of the designs within a run folder.
pub(super) const FOLDER: &str = "archive";
/// The table of them.
pub(super) const TABLE: &str = "archive.csv";

/// The file of a kind: its cells, `3-0.design.json`.
fn file(cell: &[usize]) -> String {
    let cells: Vec<String> = cell.iter().map(ToString::to_string).collect();
    format!("{}.design.json", cells.join("-"))
}

/// Whether a file can be that of a kind.
pub(super) fn is_kind(name: &str) -> bool {
    let is_number = |cell: &str| !cell.is_empty() && cell.bytes().all(|digit| digit.is_ascii_digit());
    name.strip_suffix(".design.json").is_some_and(|cells| cells.split('-').all(is_number))
}

/// Where a cell of a descriptor begins and ends.
fn ends(descriptor: &Descriptor, cell: usize) -> (f64, f64) {
    let end = |n: usize| {
        descriptor.from + (descriptor.to - descriptor.from) * n as f64 / descriptor.cells.max(1) as f64
    };
    (end(cell), end(cell + 1))
}

/// The files of the designs in the archive of a run, by their names; none where it has no archive.
#[must_use]
pub fn designs(run: &Path) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(run.join(FOLDER)) else { return Vec::new() };
    let is_design = |path: &PathBuf| {
        path.file_name().and_then(|name| name.to_str()).is_some_and(is_kind) && path.is_file()
    };
    let mut files: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).filter(is_design).collect();
    files.sort();
    files
}

/// Writes the design of a kind, and the table with all.
pub(super) fn write(
    run: &Path,
    rules: &RuleSet,
    archive: &[(Vec<usize>, Best)],
    cell: &[usize],
    design: &SavedDesign,
) -> Result<(), FileError> {
    let folder = run.join(FOLDER);
    check_no_link(&folder)?;
    fs::create_dir_all(&folder).map_err(FileError::write(&folder))?;
    let file = folder.join(file(cell));
    design.check_replaces(&file)?;
    write_own(&file, &design.text())?;
    write_own(&run.join(TABLE), &table(rules, archive))
}

/// Which kinds have to be written again, as their files or the table are not as the search left them.
pub(super) fn lost(run: &Path, rules: &RuleSet, archive: &[(Vec<usize>, Best)]) -> Vec<usize> {
    let folder = run.join(FOLDER);
    let is_there = |(cell, best): &(Vec<usize>, Best)| {
        let design = SavedDesign::read_own(&folder.join(file(cell)));
        design.is_ok_and(|design| {
            design.found_at == best.found_at
                && design.value.to_bits() == best.value.to_bits()
                && design.body == best.derivation.design.canonical_hash()
        })
    };
    let kinds = archive.iter().enumerate();
    let mut lost: Vec<usize> = kinds.filter(|(_, kind)| !is_there(kind)).map(|(n, _)| n).collect();
    let is_table = read(&run.join(TABLE)).is_ok_and(|text| text == table(rules, archive));
    if lost.is_empty() && !is_table && !archive.is_empty() {
        // The table is written with each design.
        lost.push(0);
    }
    lost
}

/// The columns that each table has behind those of the descriptors.
const COLUMNS: [&str; 4] = ["value", "move", "parts", "actuators"];

/// The first line of the table. No two columns have the same name.
fn head<'n>(descriptors: impl Iterator<Item = &'n str>, observed: &[String]) -> String {
    let mut columns = vec!["design".to_owned()];
    for name in descriptors {
        let ends = [name.to_owned(), format!("{name}_from"), format!("{name}_to")];
        let taken = || columns.iter().map(String::as_str).chain(COLUMNS);
        let is_taken = ends.iter().any(|end| taken().any(|other| other == end));
        let of = if is_taken { DESCRIPTOR } else { "" };
        columns.extend(ends.iter().map(|end| format!("{of}{end}")));
    }
    columns.extend(COLUMNS.map(str::to_owned));
    for name in observed {
        columns.push(distinct(name, OBSERVED, columns.iter().map(String::as_str)));
    }
    columns.join(",") + "\n"
}

fn table(rules: &RuleSet, archive: &[(Vec<usize>, Best)]) -> String {
    let descriptors: Vec<_> =
        rules.search.archive().into_iter().flat_map(|archive| &archive.descriptors).collect();
    let mut text = head(descriptors.iter().map(|(name, _)| name.as_str()), &rules.observed);
    for (cell, best) in archive {
        text += &file(cell);
        for ((_, descriptor), cell) in descriptors.iter().zip(cell) {
            let (from, to) = ends(descriptor, *cell);
            let _ = write!(text, ",{cell},{from},{to}");
        }
        let design = &best.derivation.design;
        let (parts, actuators) = (design.parts.len(), design.actuators(rules));
        let _ = write!(text, ",{},{},{parts},{actuators}", best.value, best.found_at);
        for column in 0..rules.observed.len() {
            let value = best.observed().get(column).and_then(Option::as_ref);
            let _ = write!(text, ",{}", value.map_or(String::new(), ToString::to_string));
        }
        text += "\n";
    }
    text
}

/// How many kinds a run has found, in words; none if it keeps no archive.
#[must_use]
pub fn told(run: &Path) -> Option<String> {
    let table = read(&run.join(TABLE)).ok()?;
    let found = table.lines().count().saturating_sub(1);
    let kinds = if found == 1 { "kind" } else { "kinds" };
    Some(format!("the best of {found} {kinds} of designs: see {}", run.join(TABLE).display()))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use grammar_lang::ir::{Expr, ExprKind, Ty};

    use super::*;

    #[test]
    fn no_two_columns_have_the_same_name() {
        let head = head(["size", "value", "size_from"].into_iter(), &["value".to_owned(), "size".to_owned()]);
        let columns: BTreeSet<&str> = head.trim_end().split(',').collect();
        assert_eq!(columns.len(), head.split(',').count(), "{head}");
        assert!(head.contains(",descriptor value,descriptor value_from,"), "{head}");
        assert!(head.ends_with(",value,move,parts,actuators,observed value,observed size\n"), "{head}");
    }

    #[test]
    fn a_cell_lies_between_its_ends() {
        let value = Expr { kind: ExprKind::Number(0.0), ty: Ty::NUMBER, span: Default::default() };
        let descriptor = Descriptor { value, from: 1.0, to: 21.0, cells: 10 };
        assert_eq!(ends(&descriptor, 0), (1.0, 3.0));
        assert_eq!(ends(&descriptor, 9), (19.0, 21.0));
        assert_eq!(file(&[3, 0]), "3-0.design.json");
        assert!(is_kind(&file(&[3, 0])) && is_kind("12.design.json"));
        assert!(!is_kind("mine.design.json") && !is_kind("3-.design.json") && !is_kind("3-0.json"));
    }
}
