//! `sgc view`: a page that shows a saved design moving.

use std::path::{Path, PathBuf};

use clap::Args;

use super::design::{self, Opened};
use super::exit;
use super::output::{self, Fault};
use super::replace::Replace;
use crate::results::{picture, view};

/// What its pages are sealed with.
const VIEW: &str = "view";

/// Write a page that shows a saved design moving; it opens offline in any browser
#[derive(Args)]
pub(super) struct View {
    /// The run folder, or a saved design
    #[arg(value_name = "DIR|DESIGN")]
    design: PathBuf,
    /// Where to write the page [default: view.html beside the design, or in the current folder if nothing can be written there]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    #[command(flatten)]
    replace: Replace,
    /// The task to show [default: the first]
    #[arg(long, value_name = "NAME")]
    task: Option<String>,
}

impl View {
    pub(super) fn run(self) -> Result<u8, Fault> {
        let path = design::file(&self.design);
        let Opened { design, rules, sources } = design::open(&path)?;
        let fault = |e| design::fault(&path, &e);
        let scene = picture::scene(&rules, &sources, &design, self.task.as_deref()).map_err(fault)?;
        let page = view::page(&scene);
        let out = match self.out {
            Some(out) => {
                self.replace.write_sealed(&out, &page, VIEW)?;
                out
            }
            None => {
                let name = format!("{}-{}", design.grammar.name, design.seed);
                beside(&path, &name, &page, self.replace)?
            }
        };
        output::data(&format!("{}\n", out.display()))?;
        output::note("open this page in a browser");
        Ok(exit::DONE)
    }
}

/// Writes the page beside the design; where nothing can be written, into the current folder.
fn beside(design: &Path, name: &str, page: &str, replace: Replace) -> Result<PathBuf, Fault> {
    let out = design.with_file_name("view.html");
    replace.may_write_sealed(&out, VIEW)?;
    let Err(Fault { code, message }) = replace.write_sealed(&out, page, VIEW) else { return Ok(out) };
    let here = PathBuf::from(format!("{name}.view.html"));
    replace
        .write_sealed(&here, page, VIEW)
        .map_err(|_| Fault { code, message: format!("{message}; choose another place with --out") })?;
    output::note(&format!("{message}; the page is in the current folder instead"));
    Ok(here)
}
