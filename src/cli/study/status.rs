//! `sgc study status`: how far the runs of a study are.

use std::path::PathBuf;

use clap::Args;

use crate::cli::exit;
use crate::cli::output::{self, Fault};
use crate::study::folder::Study;
use crate::study::standing::{Standing, reason, standing};

/// Show the progress of the runs of a study
#[derive(Args)]
pub(super) struct Status {
    /// The folder of the study
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Print a line for each run
    #[arg(long)]
    runs: bool,
}

impl Status {
    pub(super) fn run(self) -> Result<u8, Fault> {
        let study = Study::open(&self.folder).map_err(Fault::usage)?;
        let all: Vec<_> = study.runs().map(|run| (run, standing(&study, run))).collect();
        let mut text = String::new();
        if self.runs {
            text += "run,standing\n";
            for (run, standing) in &all {
                text += &format!("\"{}\",{}\n", study.name(*run), standing.text());
            }
            output::data(&text)?;
            return Ok(exit::DONE);
        }
        for standing in Standing::ALL {
            let many = all.iter().filter(|(_, own)| *own == standing).count();
            if many > 0 {
                text += &format!("{:<10} {many}\n", standing.text());
            }
        }
        text += &format!("{:<10} {}\n", "all", all.len());
        output::data(&text)?;
        for (run, _) in all.iter().filter(|(_, own)| *own == Standing::Failed) {
            let why = reason(&study, *run).unwrap_or_default();
            output::note(&format!("{} failed: {why}", study.name(*run)));
        }
        Ok(exit::DONE)
    }
}
