//! `sgc doc`: a page about a grammar, a module or the standard library.

use std::path::{Path, PathBuf};

use clap::Args;
use grammar_lang::diagnostics::Diagnostic;
use grammar_lang::diagnostics::render::{Format, render};
use grammar_lang::source::Source;

use super::output::{self, Fault};
use super::replace::Replace;
use super::{exit, load};
use crate::document;
use crate::loader::{Files, LIBRARY};

/// Write a page of documentation from the `##` comments of a grammar or module
#[derive(Args)]
pub(super) struct Doc {
    /// The grammar or module; `std` is the whole standard library, `std.blocks` a part of it
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Where to write the page, or the folder to write it into [default: beside the file]
    #[arg(long, value_name = "DIR|PAGE.html")]
    out: Option<PathBuf>,
    #[command(flatten)]
    replace: Replace,
}

/// The texts of the standard library that a name means.
fn library(name: &str) -> Vec<Source> {
    let meant = LIBRARY.iter().filter(|(module, _)| name == "std" || *module == name);
    meant.map(|(module, text)| Source { name: (*module).to_owned(), text: (*text).to_owned() }).collect()
}

/// A file that has no errors: what is broken cannot be told in full.
fn sound(file: &Path) -> Result<Source, Fault> {
    let text = load::read(file)?;
    let checked = load::check(&Files, &text.name, &text.text, &[], None);
    if checked.diagnostics.iter().any(Diagnostic::is_error) {
        let text = render(&checked.diagnostics, &checked.sources, Format::Full, output::colour_err());
        output::note(text.trim_end());
        return Err(Fault { code: exit::INPUT, message: String::new() });
    }
    let entry = checked.sources.iter().next().map(|(_, source)| source.clone());
    entry.ok_or_else(|| Fault::usage(format!("cannot read {}", file.display())))
}

impl Doc {
    /// Where the page goes.
    fn out(&self, name: &str) -> Result<PathBuf, Fault> {
        let page = format!("{name}.html");
        match &self.out {
            None => Ok(self.file.with_file_name(page)),
            Some(out) if out.extension().is_some_and(|e| e == "html") && !out.is_dir() => Ok(out.clone()),
            Some(folder) => {
                std::fs::create_dir_all(folder)
                    .map_err(|e| Fault::usage(format!("cannot make {}: {e}", folder.display())))?;
                Ok(folder.join(page))
            }
        }
    }

    pub(super) fn run(self) -> Result<u8, Fault> {
        let asked = self.file.to_string_lossy().into_owned();
        let texts = library(&asked);
        let (title, name, texts) = match texts.as_slice() {
            [] if self.file == Path::new("-") => {
                ("standard input".to_owned(), "stdin".to_owned(), vec![sound(&self.file)?])
            }
            [] => {
                let part =
                    |part: Option<&std::ffi::OsStr>| part.unwrap_or_default().to_string_lossy().into_owned();
                (part(self.file.file_name()), part(self.file.file_stem()), vec![sound(&self.file)?])
            }
            [_] => (asked.clone(), asked, texts),
            _ => ("The standard library".to_owned(), asked, texts),
        };
        let out = self.out(&name)?;
        self.replace.write_sealed(&out, &document::page(&title, &Files, &texts), "doc")?;
        output::data(&format!("{}\n", out.display()))?;
        output::note("open this page in a browser");
        Ok(exit::DONE)
    }
}
