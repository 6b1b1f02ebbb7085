//! Files that a command writes: what somebody else wrote or edited is not replaced.

use std::fs;
use std::path::Path;

use clap::Args;

use super::output::Fault;
use crate::reading;
use crate::results::run_files;
use crate::results::seal::{is_as_written_by, sealed};
use crate::results::whole::write_whole;
use crate::study::folder::is_of_study;

/// Whether to replace what is there.
#[derive(Args, Clone, Copy)]
pub(super) struct Replace {
    /// Replace an existing file, even if it was edited or sgc did not write it
    #[arg(long)]
    pub(super) force: bool,
}

impl Replace {
    /// Writes a text that cannot tell who wrote it: data, or a grammar. What is there is only replaced
    /// where that is asked for.
    ///
    /// # Errors
    ///
    /// [`Fault`] if something else is there, if it is one of the files that this command has read, or if the file
    /// cannot be written.
    pub(super) fn write(self, out: &Path, text: &str) -> Result<(), Fault> {
        may_replace(out)?;
        let is_the_same = || reading::to_replace(out).is_ok_and(|there| there == text.as_bytes());
        if !self.force && is_there(out) && !is_the_same() {
            return Err(refused(out, "it is not what this command would write"));
        }
        write_whole(out, text).map_err(Fault::usage)
    }

    /// Writes a page, a drawing or a model, of HTML, SVG or XML. One that is there is replaced if it is still
    /// as this command of sgc wrote it.
    ///
    /// # Errors
    ///
    /// As of [`Replace::write`].
    pub(super) fn write_sealed(self, out: &Path, text: &str, command: &str) -> Result<(), Fault> {
        self.may_write_sealed(out, command)?;
        write_whole(out, &sealed(text, command)).map_err(Fault::usage)
    }

    /// Refuses to replace a page, a drawing or a model that is not as this command of sgc wrote it.
    pub(super) fn may_write_sealed(self, out: &Path, command: &str) -> Result<(), Fault> {
        may_replace(out)?;
        if self.force || !is_there(out) || is_as_written_by(out, command) {
            return Ok(());
        }
        Err(refused(out, "this command did not write it, or somebody edited it since"))
    }
}

/// Whether there is a file that would be replaced. A link that leads nowhere is there, too; what is no file is
/// refused by whoever writes.
fn is_there(out: &Path) -> bool {
    fs::symlink_metadata(out).is_ok() && (out.is_file() || !out.exists())
}

/// Refuses to write over what is read-only, what the command has read, and what a run needs: nothing else holds it.
pub(super) fn may_replace(out: &Path) -> Result<(), Fault> {
    let place = fs::canonicalize(out).unwrap_or_else(|_| out.to_owned());
    if fs::metadata(&place).is_ok_and(|there| there.is_file() && there.permissions().readonly()) {
        return Err(Fault::usage(format!(
            "{} is read-only; choose another name, or allow writing to it",
            out.display()
        )));
    }
    if !reading::was_read(out) {
        if run_files::is_of_run(&place) {
            return Err(Fault::usage(format!(
                "{} is a file of the run in this folder, and the run needs it; choose another name with --out",
                out.display()
            )));
        }
        if is_of_study(&place) {
            return Err(Fault::usage(format!(
                "{} is a file of the study in this folder, and the study needs it; choose another name with --out",
                out.display()
            )));
        }
        return Ok(());
    }
    let also = if place == out { String::new() } else { format!("{}, ", place.display()) };
    Err(Fault::usage(format!(
        "{} is {also}which this command reads; choose another name with --out",
        out.display()
    )))
}

fn refused(out: &Path, why: &str) -> Fault {
    Fault::usage(format!(
        "{} exists already, and {why}; choose another name with --out, or replace it with --force",
        out.display()
    ))
}
