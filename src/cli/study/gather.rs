//! `sgc study gather`: what the runs of a study came to, as one page and tables.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::cli::exit;
use crate::cli::output::{self, Fault};
use crate::results::run_files::has_result;
use crate::study;
use crate::study::folder::Study;
use crate::study::outcome::outcomes;
use crate::study::standing::Standing;
use crate::study::tables::Gathered;

/// Write the page and the tables of a study, even while it is running
#[derive(Args)]
pub(super) struct Gather {
    /// The folder of the study
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Where to write the page and the tables [default: report/ in DIR]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Write into a folder that contains other files, and replace files with the same names
    #[arg(long)]
    force: bool,
}

impl Gather {
    pub(super) fn run(self) -> Result<u8, Fault> {
        let study = Study::open(&self.folder).map_err(Fault::usage)?;
        gather(&study, self.out.as_deref(), self.force)
    }
}

/// Writes them, and says where; the exit code, which tells whether a result was left out.
pub(super) fn gather(study: &Study, out: Option<&Path>, force: bool) -> Result<u8, Fault> {
    let outcomes = outcomes(study);
    // What a process noted as failed, `status` tells.
    let mut code = exit::DONE;
    for one in outcomes.iter().filter(|one| has_result(&study.folder(one.run))) {
        if let Some(problem) = &one.problem {
            output::note(&format!("{} is left out: {problem}", study.name(one.run)));
            code = exit::INPUT;
        }
    }
    let gathered = Gathered::new(study, &outcomes);
    let page = study::write(&gathered, out, force).map_err(Fault::usage)?;
    output::data(&format!("{}\n", page.display()))?;
    let complete = outcomes.iter().filter(|one| one.standing == Standing::Complete).count();
    output::note(&format!("{complete} of {} runs are complete; open this page in a browser", outcomes.len()));
    Ok(code)
}
