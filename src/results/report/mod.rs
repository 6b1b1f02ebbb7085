//! The report of runs: one page that opens offline, and the tables behind it.
//!
//! `read` reads folders of runs into plain data, `gather` counts and measures, a file for each
//! section, and `page` draws, a file for each section again. A section is a line in
//! `page::SECTIONS`, a table a line in `TABLES`; none knows another.

mod error;
mod gather;
mod moves;
pub(crate) mod page;
mod read;
#[cfg(test)]
mod tests;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Component, Path, PathBuf};

pub use error::{BadMoves, ReportError};
pub use read::Asker;

use sha2::{Digest as _, Sha256};

use gather::{convergence, observed, rejections, rules, runs, sizes, spending, temperature};
use read::Group;

use super::saved::hex;
use super::seal::{is_as_written_by, sealed};
use super::whole::{clear_unfinished_files, entries, is_unfinished, write_own};
use super::{FileError, front};
use crate::reading;

/// What the folder of a report is called in the folder of its runs.
pub const FOLDER: &str = "report";
/// The page.
pub const PAGE: &str = "index.html";

/// A table by the name of its file.
type Table = (&'static str, fn(&[Group]) -> String);

/// The tables.
const TABLES: [Table; 10] = [
    ("runs.csv", runs::csv),
    ("convergence.csv", convergence::csv),
    ("fronts.csv", gather::front::csv),
    ("temperature.csv", temperature::csv),
    ("rules.csv", rules::csv),
    ("spending.csv", spending::csv),
    ("sizes.csv", sizes::csv),
    ("observed.csv", observed::csv),
    ("classes.csv", observed::classes_csv),
    ("rejections.csv", rejections::csv),
];

/// Whether a page loads itself again after a while.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reload {
    /// It is complete.
    Never,
    /// It is written again as the runs go on.
    WhileRunning,
}

/// What is known of some runs.
#[derive(Debug)]
pub struct Report {
    groups: Vec<Group>,
}

impl Report {
    /// Reads the folders: each holds a run or several, and is a group of its own.
    ///
    /// # Errors
    ///
    /// A folder holds no runs, is damaged or is named twice, or values cannot be compared.
    pub fn read(folders: &[PathBuf], asker: Asker) -> Result<Self, ReportError> {
        Ok(Self { groups: read::groups(folders, asker)? })
    }

    /// Writes the page and the tables into a folder; what a report wrote there before is replaced.
    ///
    /// # Errors
    ///
    /// The folder holds something that no report writes (unless `force`), or cannot be written.
    pub fn write(&self, out: &Path, force: bool) -> Result<PathBuf, ReportError> {
        // The page is first: what it is written beside is known to be of a report.
        let tables = TABLES.map(|(name, table)| (name, table(&self.groups)));
        let page = self.write_page_of(out, Reload::Never, force, &tables)?;
        let files = || TABLES.iter().map(|(name, _)| out.join(name));
        if let Some(read) = files().find(|file| reading::was_read(file)) {
            return Err(ReportError::Read(read));
        }
        for (name, table) in tables {
            write_own(&out.join(name), &table)?;
        }
        // What was begun by a process that was killed.
        clear_unfinished_files(out);
        Ok(page)
    }

    /// Writes the page alone.
    ///
    /// # Errors
    ///
    /// As of [`Report::write`].
    pub fn write_page(&self, out: &Path, reload: Reload, force: bool) -> Result<PathBuf, ReportError> {
        self.write_page_of(out, reload, force, &[])
    }

    /// Writes the page, which knows these tables and those that are there: others are somebody's.
    fn write_page_of(
        &self,
        out: &Path,
        reload: Reload,
        force: bool,
        tables: &[(&str, String)],
    ) -> Result<PathBuf, ReportError> {
        if !force {
            check_place(out)?;
        }
        fs::create_dir_all(out).map_err(FileError::write(out))?;
        let page = out.join(PAGE);
        if reading::was_read(&page) {
            return Err(ReportError::Read(page));
        }
        let there = TABLES.iter().filter_map(|(name, _)| reading::to_replace(&out.join(name)).ok());
        let known: BTreeSet<String> =
            there.map(|table| short(&table)).chain(tables.iter().map(|(_, t)| short(t.as_bytes()))).collect();
        let text = page::page(&self.groups, &|run| link(out, run), reload);
        let known = known.into_iter().collect::<Vec<_>>().join(" ");
        write_own(&page, &sealed(&format!("{text}{KNOWN}{known}{KNOWN_END}"), "report"))?;
        Ok(page)
    }
}

/// The line of a page that says which tables are a report's: the beginnings of their checksums.
const KNOWN: &str = "<!-- tables ";
const KNOWN_END: &str = " -->\n";

/// The beginning of the checksum of a table.
fn short(table: &[u8]) -> String {
    hex(&Sha256::digest(table)).chars().take(16).collect()
}

/// What a page says of its tables.
fn known(page: &Path) -> Option<String> {
    let text = String::from_utf8(reading::to_replace(page).ok()?).ok()?;
    let (_, line) = text.rsplit_once(KNOWN)?;
    Some(line.split_once(KNOWN_END)?.0.to_owned())
}

/// Refuses a place where there is anything but a report.
fn check_place(out: &Path) -> Result<(), ReportError> {
    if !out.exists() {
        return Ok(());
    }
    match foreign(out) {
        Ok(None) => Ok(()),
        Ok(Some(name)) => Err(ReportError::Foreign { folder: out.to_owned(), name }),
        Err(why) => Err(ReportError::NoPlace { folder: out.to_owned(), why }),
    }
}

/// Something in a folder that no report wrote. Tables are a report's where its page knows them.
fn foreign(folder: &Path) -> std::io::Result<Option<String>> {
    let page = folder.join(PAGE);
    let has_page = is_as_written_by(&page, "report");
    if !has_page && page.exists() {
        return Ok(Some(PAGE.to_owned()));
    }
    let known = if has_page { known(&page) } else { None };
    let is_table = |name: &str| {
        // Earlier versions did not say which tables they wrote.
        let is_known = |known: &String| {
            reading::to_replace(&folder.join(name)).is_ok_and(|table| known.contains(&short(&table)))
        };
        TABLES.iter().any(|(table, _)| *table == name) && known.as_ref().is_none_or(is_known)
    };
    let is_ours = |name: &str| has_page && (name == PAGE || is_table(name)) || is_unfinished(name);
    Ok(entries(folder)?.into_iter().find(|name| !is_ours(name)))
}

/// Whether something in a run's folder is the report of it, and nothing else.
pub(super) fn is_own(folder: &Path, name: &str) -> bool {
    name == FOLDER && foreign(&folder.join(name)).is_ok_and(|foreign| foreign.is_none())
}

/// The address of the page of a run, or of a saved design, from the page of the report; none if there is no such page.
fn link(out: &Path, shown: &Path) -> Option<String> {
    let page = if shown.is_dir() { shown.join("view.html") } else { front::page_of(shown) };
    let page = fs::canonicalize(page).ok()?;
    let out = fs::canonicalize(out).ok()?;
    Some(relative(&out, &page))
}

/// The way from a folder to a file as an address.
fn relative(folder: &Path, file: &Path) -> String {
    let parts = |path: &Path| -> Vec<String> {
        let named = path.components().filter(|part| !matches!(part, Component::RootDir));
        named.map(|part| part.as_os_str().to_string_lossy().into_owned()).collect()
    };
    let (from, to) = (parts(folder), parts(file));
    let shared = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
    let up = from.iter().skip(shared).map(|_| "..".to_owned());
    let steps: Vec<String> = up.chain(to.iter().skip(shared).map(|name| encoded(name))).collect();
    steps.join("/")
}

/// A name in an address: what would mean something else there is written as numbers.
fn encoded(name: &str) -> String {
    let plain = |b: u8| b.is_ascii_alphanumeric() || b"-_.~".contains(&b);
    name.bytes().map(|b| if plain(b) { char::from(b).to_string() } else { format!("%{b:02X}") }).collect()
}
