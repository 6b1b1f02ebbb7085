//! `sgc check`: every finding of every file in one go.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use grammar_lang::diagnostics::Diagnostic;
use grammar_lang::diagnostics::render::{Format, render};

use super::output::{self, Fault};
use super::{exit, load};

/// Check grammars: names, types, units, domains, and the initial design
#[derive(Args)]
pub(super) struct Check {
    /// The grammars or modules; `-` reads standard input
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// How findings are written
    #[arg(long, value_enum, default_value = "full")]
    format: Style,
    /// Set a parameter of the grammars
    #[arg(short, long = "param", value_name = "NAME=VALUE", value_parser = super::assignment)]
    params: Vec<(String, String)>,
}

#[derive(Clone, Copy, ValueEnum)]
enum Style {
    /// With the text around them
    Full,
    /// One line each
    Concise,
    /// One JSON object a line
    Json,
}

impl Check {
    pub(super) fn run(self) -> Result<u8, Fault> {
        let format = match self.format {
            Style::Full => Format::Full,
            Style::Concise => Format::Concise,
            Style::Json => Format::Json,
        };
        let mut errors = 0;
        let mut unreadable = None;
        for file in &self.files {
            let checked = match load::check(file, &self.params) {
                Ok(checked) => checked,
                // The other files are checked all the same.
                Err(fault) => {
                    output::note(&format!("error: {}", fault.message));
                    unreadable = Some(fault.code);
                    continue;
                }
            };
            output::data(&render(&checked.diagnostics, &checked.sources, format, output::colour_out()))?;
            let found = checked.diagnostics.iter().filter(|d| Diagnostic::is_error(d)).count();
            errors += found;
            let summary = match (found, &checked.rules) {
                (0, Some(rules)) => format!(
                    "grammar {}: {} rules, {} requirements, no errors",
                    rules.name,
                    rules.rules.len(),
                    rules.requirements.len()
                ),
                (0, None) if !checked.is_grammar => "a module, no errors".to_owned(),
                (1, _) => "1 error".to_owned(),
                (n, _) => format!("{n} errors"),
            };
            output::note(&format!("{}: {summary}", file.display()));
        }
        Ok(if errors > 0 { exit::INPUT } else { unreadable.unwrap_or(exit::DONE) })
    }
}
