//! `sgc view`: a page that shows a saved design moving.

use std::path::{Path, PathBuf};

use clap::Args;

use super::eval::design_file;
use super::exit;
use super::output::{self, Fault};
use crate::results::saved::SavedDesign;
use crate::results::whole::write_whole;
use crate::results::{picture, view};

/// Write a page that shows a saved design moving; it opens offline in any browser
#[derive(Args)]
pub(super) struct View {
    /// The run folder, or a saved design
    #[arg(value_name = "DIR|DESIGN")]
    design: PathBuf,
    /// Where to write the page [default: view.html beside the design, or in the current folder if nothing can be written there]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// The task to show [default: the first]
    #[arg(long, value_name = "NAME")]
    task: Option<String>,
}

impl View {
    pub(super) fn run(self) -> Result<u8, Fault> {
        let path = design_file(&self.design);
        let design = SavedDesign::read(&path).map_err(Fault::usage)?;
        let fault = |e: String| Fault::input(format!("{}: {e}", path.display()));
        let frozen = design.grammar.compile_with_sources();
        let (rules, sources) = frozen.map_err(|e| Fault::usage(format!("{}: {e}", path.display())))?;
        let scene = picture::scene((&rules, &sources), &design, self.task.as_deref()).map_err(fault)?;
        let page = view::page(&scene);
        let out = match self.out {
            Some(out) => write_whole(&out, &page).map(|()| out),
            None => beside(&path, &format!("{}-{}", design.grammar.name, design.seed), &page),
        };
        let out = out.map_err(Fault::usage)?;
        output::data(&format!("{}\n", out.display()))?;
        output::note("open this page in a browser");
        Ok(exit::DONE)
    }
}

/// Writes the page beside the design; where nothing can be written, into the current folder.
fn beside(design: &Path, name: &str, page: &str) -> Result<PathBuf, String> {
    let out = design.with_file_name("view.html");
    let Err(reason) = write_whole(&out, page) else { return Ok(out) };
    let here = PathBuf::from(format!("{name}.view.html"));
    write_whole(&here, page).map_err(|_| format!("{reason}; choose another place with --out"))?;
    output::note(&format!("{reason}; the page is in the current folder instead"));
    Ok(here)
}
