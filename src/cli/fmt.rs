//! `sgc fmt`: the one layout of every file.

use std::path::{Path, PathBuf};

use clap::Args;
use grammar_lang::diagnostics::render::{Format, render};
use grammar_lang::format::{Unformatted, format};
use grammar_lang::source::SourceMap;

use super::load::Text;
use super::output::{self, Fault};
use super::{exit, load, mend};

/// Format grammars: change line breaks, columns and spaces, never words
#[derive(Args)]
pub(super) struct Fmt {
    /// The grammars or modules; `-` reads standard input and writes standard output
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Change nothing: name the files that would change, and exit with 1 if there are any
    #[arg(long)]
    check: bool,
}

/// What became of a file.
enum Done {
    /// It was laid out already, or is now.
    Well,
    /// It has errors, or would change.
    Not,
}

impl Fmt {
    pub(super) fn run(self) -> Result<u8, Fault> {
        let mut code = exit::DONE;
        for file in &self.files {
            // The other files are laid out all the same; the worst exit code counts.
            code = code.max(match self.file(file) {
                Ok(Done::Well) => exit::DONE,
                Ok(Done::Not) => exit::INPUT,
                Err(fault) => {
                    output::note(&format!("error: {}", fault.message));
                    fault.code
                }
            });
        }
        Ok(code)
    }

    fn file(&self, path: &Path) -> Result<Done, Fault> {
        // Asked before it is read: what comes out of a pipe comes once.
        if !self.check && path != Path::new("-") && path.exists() && !path.is_file() && !path.is_dir() {
            let name = path.display();
            return Err(Fault::usage(format!(
                "cannot format {name}: it is not a file that can be written; `sgc fmt - < {name}` writes to standard output"
            )));
        }
        let Text { name, text, .. } = load::read(path)?;
        let mut sources = SourceMap::default();
        let file = sources.add(name.clone(), text.clone());
        let formatted = match format(&sources, file) {
            Ok(formatted) => formatted,
            Err(Unformatted::Errors(found)) => {
                let text = render(&found, &sources, Format::Full, output::colour_err());
                output::note(text.trim_end());
                output::note(&format!("{name}: not formatted, because it has errors"));
                return Ok(Done::Not);
            }
            Err(Unformatted::Altered) => {
                return Err(Fault::input(format!(
                    "{name} is left unchanged: formatting would change its meaning; this is a bug in sgc"
                )));
            }
        };
        let same = formatted == text;
        if self.check {
            if !same {
                output::data(&format!("{name}\n"))?;
            }
            return Ok(if same { Done::Well } else { Done::Not });
        }
        if path == Path::new("-") {
            output::data(&formatted)?;
        } else if !same {
            mend::replace(path, &text, &formatted)
                .map_err(|why| Fault::usage(format!("cannot format {name}: {why}")))?;
            output::note(&format!("{name}: formatted"));
        }
        Ok(Done::Well)
    }
}
