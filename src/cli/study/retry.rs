//! `sgc study retry`: failed runs are tried again.

use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;

use crate::cli::exit;
use crate::cli::output::{self, Fault};
use crate::results::run_files::CHECKPOINT;
use crate::results::{FileError, place};
use crate::study::folder::{Run, Study};
use crate::study::standing::{Standing, standing};

/// Try the failed runs of a study again, after you have removed the cause
#[derive(Args)]
pub(super) struct Retry {
    /// The folder of the study
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Start them again from the beginning, and remove their results so far [default: go on from their checkpoints, where they have one]
    #[arg(long)]
    anew: bool,
    /// Begin this run anew, whatever its state, such as a complete one whose files are damaged; may be given several times
    #[arg(long, value_name = "NAME", requires = "anew")]
    run: Vec<String>,
}

impl Retry {
    pub(super) fn run(self) -> Result<u8, Fault> {
        let study = Study::open(&self.folder).map_err(Fault::usage)?;
        let failed: Vec<_> = match self.run.is_empty() {
            true => study.runs().filter(|run| standing(&study, *run) == Standing::Failed).collect(),
            false => self.run.iter().map(|name| named(&study, name)).collect::<Result<_, _>>()?,
        };
        for run in &failed {
            let folder = study.folder(*run);
            // What has no checkpoint can only begin anew.
            if folder.exists() && (self.anew || !folder.join(CHECKPOINT).exists()) {
                place::check_run(&folder).map_err(|why| {
                    Fault::usage(format!(
                        "cannot remove this run: {why}. Move the folder away, and give this command again"
                    ))
                })?;
                // A run that is named is removed with what was changed in it.
                let changed = if self.run.is_empty() { place::changed(&folder) } else { None };
                if let Some(file) = changed {
                    return Err(Fault::usage(format!(
                        "{} was changed since the run wrote it, or is damaged, and would be removed: move it elsewhere, or remove it with \
                         `sgc study retry {} --anew --run {}`",
                        file.display(),
                        output::typed(&self.folder),
                        output::typed(Path::new(&study.name(*run)))
                    )));
                }
                fs::remove_dir_all(&folder).map_err(FileError::remove(&folder)).map_err(Fault::usage)?;
            }
            let note = study.note_of(*run);
            if note.exists() {
                fs::remove_file(&note).map_err(FileError::remove(&note)).map_err(Fault::usage)?;
            }
        }
        output::note(&match failed.len() {
            0 => "no run has failed".to_owned(),
            1 => "one run waits again: `sgc study FILE`, or `sgc study submit`, does it".to_owned(),
            many => format!("{many} runs wait again: `sgc study FILE`, or `sgc study submit`, does them"),
        });
        Ok(exit::DONE)
    }
}

fn named(study: &Study, name: &str) -> Result<Run, Fault> {
    study.named(name).filter(|run| standing(study, *run) != Standing::UnderWay).ok_or_else(|| {
        Fault::usage(format!(
            "the study has no run \"{name}\", or a process holds it; `sgc study status DIR --runs` lists all"
        ))
    })
}
