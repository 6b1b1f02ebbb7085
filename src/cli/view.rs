//! `sgc view`: a page that shows a saved design moving.

use std::path::PathBuf;

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
    /// Where to write the page [default: view.html beside the design]
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
        let out = self.out.unwrap_or_else(|| path.with_file_name("view.html"));
        write_whole(&out, &view::page(&scene)).map_err(Fault::usage)?;
        output::data(&format!("{}\n", out.display()))?;
        output::note("open this page in a browser");
        Ok(exit::DONE)
    }
}
