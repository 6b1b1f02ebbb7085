//! `sgc view`: a page that shows a saved design moving.

use std::path::{Path, PathBuf};

use clap::Args;

use super::design::{self, Opened};
use super::exit;
use super::output::{self, Fault};
use super::replace::Replace;
use super::scenarios::OneWorld;
use crate::results::saved::SavedDesign;
use crate::results::{front, picture, view};

/// What its pages are sealed with.
const VIEW: &str = "view";

/// Write a page that shows a saved design moving; it opens offline in any browser
#[derive(Args)]
pub(super) struct View {
    /// The run folder, or a saved design
    #[arg(value_name = "DIR|DESIGN")]
    design: PathBuf,
    /// Where to write the page [default: view.html beside the design, or in the current folder if nothing can
    /// be written there]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    #[command(flatten)]
    replace: Replace,
    /// The task to show [default: the first]
    #[arg(long, value_name = "NAME")]
    task: Option<String>,
    #[command(flatten)]
    beside: OneWorld,
}

impl View {
    pub(super) fn run(self) -> Result<u8, Fault> {
        let path = design::file(&self.design);
        let (page, design) = self.page(&path)?;
        let out = match self.out.clone() {
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
        let others = if self.out.is_none() { front::designs(&self.design) } else { Vec::new() };
        for other in &others {
            let (page, _) = self.page(other)?;
            self.replace.write_sealed(&front::page_of(other), &page, VIEW)?;
        }
        if !others.is_empty() {
            let folder = self.design.join("front");
            output::note(&format!(
                "{} more pages, of the designs on the front, are in {}",
                others.len(),
                folder.display()
            ));
        }
        output::note("open this page in a browser");
        Ok(exit::DONE)
    }

    /// The page of a saved design.
    fn page(&self, path: &Path) -> Result<(String, SavedDesign), Fault> {
        let Opened { design, rules, sources } = design::open(path)?;
        let fault = |e| design::fault(path, &e);
        let design = design::as_simulated(path, &rules, design)?;
        let world = self.beside.asked(&rules)?;
        let scene = picture::scene(&rules, &sources, &design, self.task.as_deref(), world.as_ref());
        let scene = scene.map_err(fault)?;
        Ok((view::page(&scene), design))
    }
}

/// Writes the page beside the design; where nothing can be written, into the current folder.
fn beside(design: &Path, name: &str, page: &str, replace: Replace) -> Result<PathBuf, Fault> {
    let out = front::page_of(design);
    replace.may_write_sealed(&out, VIEW)?;
    let Err(Fault { code, message }) = replace.write_sealed(&out, page, VIEW) else { return Ok(out) };
    let here = PathBuf::from(format!("{name}.view.html"));
    replace
        .write_sealed(&here, page, VIEW)
        .map_err(|_| Fault { code, message: format!("{message}; choose another place with --out") })?;
    output::note(&format!("{message}; the page is in the current folder instead"));
    Ok(here)
}
