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
pub(crate) mod written;

use std::fs;
use std::path::{Component, Path, PathBuf};

pub use error::{BadMoves, ReportError};
pub use read::Asker;

use gather::{convergence, learning, observed, rejections, rules, runs, sizes, spending, temperature};
use read::Group;
use written::Place;

use super::front;

/// What the folder of a report is called in the folder of its runs.
pub const FOLDER: &str = "report";
pub use written::PAGE;

/// A table by the name of its file.
type Table = (&'static str, fn(&[Group]) -> String);

/// The tables.
const TABLES: [Table; 11] = [
    ("runs.csv", runs::csv),
    ("convergence.csv", convergence::csv),
    ("learning.csv", learning::csv),
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
        let tables = TABLES.map(|(name, table)| (name, table(&self.groups)));
        place(out).write(|| self.page(out, Reload::Never), &tables, force)
    }

    /// Writes the page alone.
    ///
    /// # Errors
    ///
    /// As of [`Report::write`].
    pub fn write_page(&self, out: &Path, reload: Reload, force: bool) -> Result<PathBuf, ReportError> {
        place(out).write(|| self.page(out, reload), &[], force)
    }

    fn page(&self, out: &Path, reload: Reload) -> String {
        page::page(&self.groups, &|run| link(out, run), reload)
    }
}

/// Where a report is written.
fn place(folder: &Path) -> Place<'_> {
    Place { folder, command: "report", tables: TABLES.map(|(name, _)| name).to_vec(), shared: false }
}

/// Whether something in a run's folder is the report of it, and nothing else.
pub(super) fn is_own(folder: &Path, name: &str) -> bool {
    name == FOLDER && place(&folder.join(name)).foreign().is_ok_and(|foreign| foreign.is_none())
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
