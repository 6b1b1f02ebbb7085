//! Files that a command writes: what somebody else wrote is not replaced.

use std::fs;
use std::io::Read;
use std::path::Path;

use clap::Args;

use super::output::Fault;
use crate::results::whole::write_whole;

/// So much of a file says who wrote it, in bytes.
const HEAD: u64 = 4096;

/// Whether to replace what is there.
#[derive(Args, Clone, Copy)]
pub(super) struct Replace {
    /// Replace the file that is there, whoever wrote it
    #[arg(long)]
    force: bool,
}

impl Replace {
    /// Writes a file. One that is there is replaced only if `mark`, which stands near the beginning of all that the command
    /// writes, stands near its beginning, too; without a mark it is never replaced.
    ///
    /// # Errors
    ///
    /// [`Fault`] if something else is there, or the file cannot be written.
    pub(super) fn write(self, out: &Path, text: &str, mark: Option<&str>) -> Result<(), Fault> {
        self.may_write(out, mark)?;
        write_whole(out, text).map_err(Fault::usage)
    }

    /// Refuses to replace what the command did not write.
    pub(super) fn may_write(self, out: &Path, mark: Option<&str>) -> Result<(), Fault> {
        // A link that leads nowhere is there, too; what is no file is refused by whoever writes.
        let is_there = fs::symlink_metadata(out).is_ok() && (out.is_file() || !out.exists());
        if self.force || !is_there || mark.is_some_and(|mark| has_mark(out, mark)) {
            return Ok(());
        }
        Err(Fault::usage(format!(
            "{} exists already, and this command did not write it; choose another name with --out, or replace it with --force",
            out.display()
        )))
    }
}

/// Whether something stands near the beginning of a file.
fn has_mark(path: &Path, mark: &str) -> bool {
    let mut head = Vec::new();
    let file = fs::File::open(path);
    let read = file.and_then(|file| file.take(HEAD).read_to_end(&mut head));
    read.is_ok() && String::from_utf8_lossy(&head).contains(mark)
}
