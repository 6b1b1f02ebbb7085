//! `sgc check`: every finding of every file in one go.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use grammar_lang::diagnostics::Diagnostic;
use grammar_lang::diagnostics::render::{Format, render};

use super::load::Checked;
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
    /// Check only this variant
    #[arg(long, value_name = "NAME")]
    variant: Option<String>,
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
            let checked = match self.check(file) {
                Ok(checked) => checked,
                // The other files are checked all the same.
                Err(fault) => {
                    output::note(&format!("error: {}", fault.message));
                    unreadable = Some(fault.code);
                    continue;
                }
            };
            let mut shown: Vec<&Diagnostic> = Vec::new();
            for one in &checked {
                // What several variants share is told once.
                let new: Vec<Diagnostic> =
                    one.diagnostics.iter().filter(|d| !shown.contains(d)).cloned().collect();
                output::data(&render(&new, &one.sources, format, output::colour_out()))?;
                shown.extend(one.diagnostics.iter().filter(|d| new.contains(d)));
                errors += new.iter().filter(|d| d.is_error()).count();
            }
            output::note(&format!("{}: {}", file.display(), summary(&checked, &shown)));
        }
        Ok(if errors > 0 { exit::INPUT } else { unreadable.unwrap_or(exit::DONE) })
    }

    /// Checks the grammar of a file and each of its variants.
    fn check(&self, file: &Path) -> Result<Vec<Checked>, Fault> {
        if let Some(variant) = &self.variant {
            return Ok(vec![load::check(file, &self.params, Some(variant))?]);
        }
        let first = load::check(file, &self.params, None)?;
        if first.offers.len() < 2 {
            return Ok(vec![first]);
        }
        first.offers.iter().map(|name| load::check(file, &self.params, Some(name))).collect()
    }
}

/// What was found, in a few words.
fn summary(checked: &[Checked], shown: &[&Diagnostic]) -> String {
    let errors = shown.iter().filter(|d| d.is_error()).count();
    let warnings = shown.len() - errors;
    let plural = |n: usize, word: &str| format!("{n} {word}{}", if n == 1 { "" } else { "s" });
    let found = match (errors, warnings) {
        (0, 0) => "no errors".to_owned(),
        (0, warnings) => format!("no errors, {}", plural(warnings, "warning")),
        (errors, 0) => plural(errors, "error"),
        (errors, warnings) => format!("{}, {}", plural(errors, "error"), plural(warnings, "warning")),
    };
    match checked {
        [Checked { rules: Some(rules), .. }] => format!(
            "grammar {}: {} rules, {} requirements, {found}",
            rules.name,
            rules.rules.len(),
            rules.requirements.len()
        ),
        [one] if !one.is_grammar && errors == 0 => format!("a module, {found}"),
        [_] => found,
        several => format!("{} grammars and variants, {found}", several.len()),
    }
}
