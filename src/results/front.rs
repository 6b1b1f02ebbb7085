//! The designs that no other is better than in every objective: a saved design for each, and a table.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use grammar_lang::ir::{RuleSet, objective_name};

use super::columns::{OBSERVED, distinct};
use super::evals::{BESIDE, objectives, quoted};
use super::saved::SavedDesign;
use super::seal::is_as_written;
use super::whole::{check_no_link, entries, read, write_own};
use super::{FileError, archive, describe};
use crate::search::Best;

/// The folder of the designs within a run folder.
pub(super) const FOLDER: &str = "front";
/// The table of them.
pub(super) const TABLE: &str = "front.csv";

/// The file of a design: the move that found it, `120.design.json`.
fn file(best: &Best) -> String {
    format!("{}.design.json", best.found_at)
}

/// Whether a file can be that of a design on a front.
pub(super) fn is_design(name: &str) -> bool {
    let number = name.strip_suffix(".design.json");
    number.is_some_and(|number| !number.is_empty() && number.bytes().all(|digit| digit.is_ascii_digit()))
}

/// Where the file of a design is, or will be.
pub(super) fn place(run: &Path, best: &Best) -> PathBuf {
    run.join(FOLDER).join(file(best))
}

/// Whether a design has its file, as far as its name tells.
pub(super) fn is_there(run: &Path, best: &Best) -> bool {
    place(run, best).exists()
}

/// Writes a design.
pub(super) fn write_design(run: &Path, best: &Best, design: &SavedDesign) -> Result<(), FileError> {
    let folder = run.join(FOLDER);
    check_no_link(&folder)?;
    fs::create_dir_all(&folder).map_err(FileError::write(&folder))?;
    let file = folder.join(file(best));
    design.check_replaces(&file)?;
    write_own(&file, &design.text())
}

/// Writes the table of the designs, which have their files, and removes the files of those that left the front, with their pages. What else is
/// in their folder stays: only a design of this run is removed, by its seed and its rules.
pub(super) fn write_table(
    run: &Path,
    rules: &RuleSet,
    front: &[Best],
    (seed, hash): (u64, &str),
) -> Result<(), FileError> {
    write_own(&run.join(TABLE), &table(rules, front))?;
    let folder = run.join(FOLDER);
    check_no_link(&folder)?;
    let is_ours = |name: &str| {
        let design = SavedDesign::read_own(&folder.join(name));
        design.is_ok_and(|design| {
            (design.seed, design.grammar.rules.as_str()) == (seed, hash)
                && name == format!("{}.design.json", design.found_at)
        })
    };
    for name in entries(&folder).map_err(FileError::read(&folder))? {
        if is_design(&name) && front.iter().all(|best| file(best) != name) && is_ours(&name) {
            let left = folder.join(&name);
            let page = page_of(&left);
            fs::remove_file(&left).map_err(FileError::remove(&left))?;
            if is_as_written(&page) {
                fs::remove_file(&page).map_err(FileError::remove(&page))?;
            }
        }
    }
    Ok(())
}

/// Which designs have to be written again, as their files are not as the search left them; none inside if that is the table alone.
pub(super) fn lost(run: &Path, rules: &RuleSet, front: &[Best]) -> Option<Vec<usize>> {
    let folder = run.join(FOLDER);
    let is_there = |best: &Best| {
        let design = SavedDesign::read_own(&folder.join(file(best)));
        design.is_ok_and(|design| {
            let each = |a: &[f64], b: &[f64]| a.iter().map(|x| x.to_bits()).eq(b.iter().map(|x| x.to_bits()));
            let beside: Vec<f64> = design.beside.iter().map(|beside| beside.value).collect();
            design.found_at == best.found_at
                && design.value.to_bits() == best.value.to_bits()
                && each(&beside, &best.beside)
                && design.body == best.derivation.design.canonical_hash()
        })
    };
    let lost: Vec<usize> =
        front.iter().enumerate().filter(|(_, best)| !is_there(best)).map(|(place, _)| place).collect();
    let is_table = read(&run.join(TABLE)).is_ok_and(|text| text == table(rules, front));
    let is_whole = front.is_empty() || lost.is_empty() && is_table;
    (!is_whole).then_some(lost)
}

/// The files of the designs on the front of a run, as its table has them; none where it has no front.
#[must_use]
pub fn designs(run: &Path) -> Vec<PathBuf> {
    let Ok(table) = read(&run.join(TABLE)) else { return Vec::new() };
    let names = table.lines().skip(1).filter_map(|line| line.split(',').next());
    let files = names.filter(|name| is_design(name)).map(|name| run.join(FOLDER).join(name));
    files.filter(|file| file.is_file()).collect()
}

/// Where the page of a saved design is, unless another place is asked for: `view.html` beside it, or `NUMBER.view.html` where
/// it is one of several on a front or in an archive.
#[must_use]
pub fn page_of(design: &Path) -> PathBuf {
    let name = design.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let folder = design.parent().and_then(Path::file_name).and_then(|folder| folder.to_str());
    let is_one_of_several = folder == Some(FOLDER) && is_design(name)
        || folder == Some(archive::FOLDER) && archive::is_kind(name);
    match name.strip_suffix(".design.json").filter(|_| is_one_of_several) {
        Some(number) => design.with_file_name(format!("{number}.view.html")),
        None => design.with_file_name("view.html"),
    }
}

fn table(rules: &RuleSet, front: &[Best]) -> String {
    let fixed = ["design", "move", "parts", "actuators"];
    let named: Vec<String> =
        objectives(rules).iter().map(|name| quoted(&distinct(name, BESIDE, fixed))).collect();
    let mut text = format!("design,{},move,parts,actuators", named.join(","));
    for name in &rules.observed {
        let taken = fixed.into_iter().chain(named.iter().map(String::as_str));
        let _ = write!(text, ",{}", distinct(name, OBSERVED, taken));
    }
    text += "\n";
    for best in ordered(rules, front) {
        text += &file(best);
        for value in best.each() {
            let _ = write!(text, ",{value}");
        }
        let design = &best.derivation.design;
        let (parts, actuators) = (design.parts.len(), design.actuators(rules));
        let _ = write!(text, ",{},{parts},{actuators}", best.found_at);
        for column in 0..rules.observed.len() {
            let value = best.observed().get(column).and_then(Option::as_ref);
            let _ = write!(text, ",{}", value.map_or(String::new(), ToString::to_string));
        }
        text += "\n";
    }
    text
}

/// The designs, the best by the first objective first.
fn ordered<'b>(rules: &RuleSet, front: &'b [Best]) -> Vec<&'b Best> {
    let direction = rules.objective.direction;
    let mut all: Vec<&Best> = front.iter().collect();
    all.sort_by(|a, b| direction.fitness(b.value).total_cmp(&direction.fitness(a.value)));
    all
}

/// The front in words: a line for each design, and where they are.
#[must_use]
pub fn told(run: &Path, rules: &RuleSet, front: &[Best]) -> String {
    let designs = if front.len() == 1 { "design" } else { "designs" };
    let names: Vec<String> = rules.objectives().map(|objective| objective_name(rules, objective)).collect();
    let mut text = format!("a front of {} {designs}, by {}:\n", front.len(), names.join(" and "));
    for best in ordered(rules, front) {
        let units = rules.objectives().map(|objective| objective.unit.as_str());
        let values: Vec<String> =
            best.each().iter().zip(units).map(|(value, unit)| describe::quantity(*value, unit)).collect();
        let _ = writeln!(text, "  {}  {}", values.join("  "), Path::new(FOLDER).join(file(best)).display());
    }
    let _ = write!(text, "  the table is {}", run.join(TABLE).display());
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_files_of_a_front_are_told_by_their_names() {
        assert!(is_design("0.design.json") && is_design("120.design.json"));
        assert!(
            !is_design("mine.design.json") && !is_design("1-2.design.json") && !is_design(".design.json")
        );
    }
}
