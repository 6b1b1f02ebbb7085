//! `sgc report`: what runs did, as one page and tables.

use std::path::{Path, PathBuf};

use clap::Args;

use super::exit;
use super::output::{self, Fault};
use crate::results::report::{self, Asker, FOLDER};

/// Write a page of charts about one or more runs, and compare groups of runs; it opens offline in any browser
///
/// Each DIR is a group: the folder of one run, or of several runs (sgc run --runs). Runs that are in progress
/// or stopped are reported up to their present state. sgc writes the numbers of the page beside it, as csv
/// files.
#[derive(Args)]
pub(super) struct Report {
    /// Folders of runs
    #[arg(value_name = "DIR", required = true)]
    folders: Vec<PathBuf>,
    /// Where to write the page and the tables [default: report/ in DIR, or ./report for several DIRs]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Write into a folder that contains other files, and replace files with the same names
    #[arg(long)]
    force: bool,
}

impl Report {
    pub(super) fn run(self) -> Result<u8, Fault> {
        let folder = match self.folders.as_slice() {
            [only] => only.as_path(),
            _ => Path::new(""),
        };
        let out = self.out.unwrap_or_else(|| folder.join(FOLDER));
        let report = report::Report::read(&self.folders, Asker::Anybody).map_err(Fault::usage)?;
        let page = report.write(&out, self.force).map_err(Fault::usage)?;
        output::data(&format!("{}\n", page.display()))?;
        output::note("open this page in a browser");
        Ok(exit::DONE)
    }
}
