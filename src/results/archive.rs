//! The best design of each kind, where a search keeps an archive: a saved design for each, and a table.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use grammar_lang::ir::{Descriptor, RuleSet};

use super::FileError;
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
    write_own(&folder.join(file(cell)), &design.text())?;
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
                && design.body == best.derivation.design.canonical_hash(rules)
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

fn table(rules: &RuleSet, archive: &[(Vec<usize>, Best)]) -> String {
    let mut text = String::from("design");
    let descriptors: Vec<_> =
        rules.search.archive().into_iter().flat_map(|archive| &archive.descriptors).collect();
    for (name, _) in &descriptors {
        let _ = write!(text, ",{name},{name}_from,{name}_to");
    }
    text += ",value,move,parts,actuators";
    rules.observed.iter().for_each(|name| text += &format!(",{name}"));
    text += "\n";
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
    use grammar_lang::ir::{Expr, ExprKind, Ty};

    use super::*;

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
