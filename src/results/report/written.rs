//! Where a page and the tables beside it are written, and what may be replaced there: only what sgc has written, and nobody changed.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use sha2::{Digest as _, Sha256};

use super::error::ReportError;
use crate::reading;
use crate::results::FileError;
use crate::results::run_files::is_of_run;
use crate::results::saved::hex;
use crate::results::seal::{is_as_written_by, sealed};
use crate::results::whole::{clear_unfinished_files, entries, is_unfinished, write_own};

/// The page.
pub const PAGE: &str = "index.html";
/// The line of a page that says which tables belong to it: the beginnings of their checksums.
const KNOWN: &str = "<!-- tables ";
const KNOWN_END: &str = " -->\n";

/// A folder for a page and its tables.
pub(crate) struct Place<'a> {
    pub(crate) folder: &'a Path,
    /// The command that writes them.
    pub(crate) command: &'static str,
    /// The names of all tables that it writes.
    pub(crate) tables: Vec<&'static str>,
    /// Whether other processes may write here at the same time, and people keep files of their own beside.
    pub(crate) shared: bool,
}

impl Place<'_> {
    /// Writes the page, which is made once the folder is there, and some tables; what the command wrote there before is replaced.
    ///
    /// # Errors
    ///
    /// The folder holds something that the command does not write (unless `force`), or cannot be written.
    pub(crate) fn write(
        &self,
        page: impl FnOnce() -> String,
        tables: &[(&str, String)],
        force: bool,
    ) -> Result<PathBuf, ReportError> {
        let out = self.folder;
        if self.shared {
            fs::create_dir_all(out).map_err(FileError::write(out))?;
        }
        // One after the other: what one has written, the page of the next one knows. Some file systems know no locks.
        let turn = if self.shared { fs::File::open(out).ok() } else { None };
        if let Some(folder) = &turn {
            let _ = folder.lock();
        }
        if let Some(file) = self.needed_by_a_run(tables) {
            return Err(ReportError::OfRun(file));
        }
        if !force {
            self.check()?;
        }
        fs::create_dir_all(out).map_err(FileError::write(out))?;
        let file = out.join(PAGE);
        if reading::was_read(&file) {
            return Err(ReportError::Read(file));
        }
        // The page is first: what it is written beside is known to be of it. It knows these tables and those that are there:
        // others are somebody's.
        let there = self.tables.iter().filter_map(|name| reading::to_replace(&out.join(name)).ok());
        let known: BTreeSet<String> =
            there.map(|table| short(&table)).chain(tables.iter().map(|(_, t)| short(t.as_bytes()))).collect();
        let known = known.into_iter().collect::<Vec<_>>().join(" ");
        write_own(&file, &sealed(&format!("{}{KNOWN}{known}{KNOWN_END}", page()), self.command))?;
        if let Some(read) = tables.iter().map(|(name, _)| out.join(name)).find(|file| reading::was_read(file))
        {
            return Err(ReportError::Read(read));
        }
        for (name, table) in tables {
            write_own(&out.join(name), table)?;
        }
        if !tables.is_empty() && !self.shared {
            // What was begun by a process that was killed.
            clear_unfinished_files(out);
        }
        Ok(file)
    }

    /// A file that a run needs, and that would be replaced.
    fn needed_by_a_run(&self, tables: &[(&str, String)]) -> Option<PathBuf> {
        let folder = fs::canonicalize(self.folder).ok()?;
        let files = std::iter::once(PAGE).chain(tables.iter().map(|(name, _)| *name));
        files.map(|name| folder.join(name)).find(|file| is_of_run(file))
    }

    /// Refuses a place where there is anything else.
    fn check(&self) -> Result<(), ReportError> {
        let folder = self.folder.to_owned();
        if !folder.exists() {
            return Ok(());
        }
        match self.foreign() {
            Ok(None) => Ok(()),
            Ok(Some(name)) => Err(ReportError::Foreign { folder, name }),
            Err(why) => Err(ReportError::NoPlace { folder, why }),
        }
    }

    /// Something in the folder that the command did not write. Tables are its own where its page knows them.
    pub(super) fn foreign(&self) -> std::io::Result<Option<String>> {
        let page = self.folder.join(PAGE);
        let has_page = is_as_written_by(&page, self.command);
        if !has_page && page.exists() {
            return Ok(Some(PAGE.to_owned()));
        }
        let known = if has_page { known(&page) } else { None };
        let is_table = |name: &str| {
            // Earlier versions did not say which tables they wrote.
            let is_known = |known: &String| {
                reading::to_replace(&self.folder.join(name)).is_ok_and(|table| known.contains(&short(&table)))
            };
            self.tables.contains(&name) && known.as_ref().is_none_or(is_known)
        };
        let is_beside = |name: &str| self.shared && name != PAGE && !self.tables.contains(&name);
        let is_ours = |name: &str| {
            has_page && (name == PAGE || is_table(name)) || is_unfinished(name) || is_beside(name)
        };
        Ok(entries(self.folder)?.into_iter().find(|name| !is_ours(name)))
    }
}

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
