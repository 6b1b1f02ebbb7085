//! `sgc check`: every finding of every file in one go.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use grammar_lang::diagnostics::Diagnostic;
use grammar_lang::diagnostics::render::{Format, more, render, sarif};
use grammar_lang::ir::RuleSet;

use super::load::{self, Checked, Text};
use super::output::{self, Fault};
use super::{exit, mend};
use crate::derive::run_example;
use crate::loader::Edited;

/// Check grammars: names, types, units, domains, and the initial design
#[derive(Args)]
pub(super) struct Check {
    /// The grammars or modules; `-` reads standard input
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// How findings are written
    #[arg(long, value_enum, default_value = "full")]
    format: Style,
    /// Apply the fixes that are certain, in these files and in the files that they import by path; for `-`,
    /// print the fixed text
    #[arg(long)]
    fix: bool,
    /// Print what --fix would change, and change nothing; findings go to standard error
    #[arg(long, conflicts_with = "fix")]
    diff: bool,
    /// Exit with 1 if there are warnings, as if they were errors
    #[arg(long)]
    deny_warnings: bool,
    /// Set a parameter of the grammars
    #[arg(short, long = "param", value_name = "NAME=VALUE", value_parser = super::assignment)]
    params: Vec<(String, String)>,
    /// Check only this variant
    #[arg(long, value_name = "NAME")]
    variant: Option<String>,
}

#[derive(Clone, Copy, ValueEnum)]
enum Style {
    /// With the lines of the file around them
    Full,
    /// One line each
    Concise,
    /// One JSON object per line
    Json,
    /// One SARIF 2.1.0 document, for editors and code-hosting sites
    Sarif,
}

impl From<Style> for Format {
    fn from(style: Style) -> Self {
        match style {
            Style::Full => Self::Full,
            Style::Concise => Self::Concise,
            Style::Json => Self::Json,
            Style::Sarif => Self::Sarif,
        }
    }
}

impl Check {
    pub(super) fn run(self) -> Result<u8, Fault> {
        let mut unreadable = None;
        let mut texts = Vec::new();
        for file in &self.files {
            match load::read(file) {
                Ok(text) => texts.push(text),
                // The other files are checked all the same.
                Err(fault) => {
                    output::note(&format!("error: {}", fault.message));
                    unreadable = Some(fault.code);
                }
            }
        }
        let loader = match (self.fix, self.diff) {
            (true, _) => mend::mend(&texts, &self.params, mend::Outcome::Written)?,
            (_, true) => mend::mend(&texts, &self.params, mend::Outcome::Shown)?,
            _ => Edited::default(),
        };
        let mut checked = Vec::new();
        for Text { path, name, text } in &texts {
            let text = loader.get(name).unwrap_or(text);
            let mut examples = Examples::default();
            let found = match &self.variant {
                Some(variant) => {
                    let one = load::check(&loader, name, text, &self.params, Some(variant));
                    one.rules.iter().for_each(|rules| examples.run(rules));
                    vec![one]
                }
                None => load::check_all(&loader, name, text, &self.params, &mut |rules| examples.run(rules)),
            };
            for one in &found {
                self.tell(one)?;
            }
            output::note(&format!("{}: {}{}", path.display(), summary(&found), examples.told()));
            checked.extend(found);
        }
        self.tell_all(&checked)?;
        let is_wrong = |c: &Checked| errors(c) > 0 || self.deny_warnings && !c.diagnostics.is_empty();
        let sound = !checked.iter().any(is_wrong);
        // The worst code counts.
        Ok(unreadable.unwrap_or(if sound { exit::DONE } else { exit::INPUT }))
    }

    /// Writes the findings of one file, where each file is written on its own.
    fn tell(&self, found: &Checked) -> Result<(), Fault> {
        match self.format.into() {
            Format::Sarif => Ok(()),
            format => self.write(|colour| render(&found.diagnostics, &found.sources, format, colour)),
        }
    }

    /// Writes what is written once for all files.
    fn tell_all(&self, checked: &[Checked]) -> Result<(), Fault> {
        let findings: Vec<_> = checked.iter().map(|c| (c.diagnostics.as_slice(), &c.sources)).collect();
        match self.format.into() {
            Format::Full => self.write(|_| more(checked.iter().flat_map(|c| &c.diagnostics))),
            Format::Sarif => self.write(|_| sarif::render(&findings)),
            _ => Ok(()),
        }
    }

    /// Writes to standard output, unless that is where a mended text or a difference goes.
    fn write(&self, text: impl Fn(bool) -> String) -> Result<(), Fault> {
        if self.diff || self.fix && self.files.iter().any(|f| f.as_os_str() == "-") {
            let text = text(output::colour_err());
            if !text.is_empty() {
                output::note(text.trim_end());
            }
            return Ok(());
        }
        output::data(&text(output::colour_out()))
    }
}

fn errors(checked: &Checked) -> usize {
    checked.diagnostics.iter().filter(|d| Diagnostic::is_error(d)).count()
}

/// How many examples there are, and how many do not hold: what the rules make of them is no business of the checks, but nobody would
/// want to miss it.
#[derive(Default)]
struct Examples {
    all: usize,
    failed: usize,
}

impl Examples {
    fn run(&mut self, rules: &RuleSet) {
        for (name, example) in &rules.examples {
            self.all += 1;
            self.failed += usize::from(run_example(rules, name, example).is_err());
        }
    }

    fn told(&self) -> String {
        match (self.failed, self.all) {
            (0, _) => String::new(),
            (_, 1) => "; its example fails: `sgc test` says why".to_owned(),
            (failed, all) => format!("; {failed} of {all} examples fail: `sgc test` says why"),
        }
    }
}

/// What the check of a file comes down to.
fn summary(checked: &[Checked]) -> String {
    let all: usize = checked.iter().map(errors).sum();
    let warnings = checked.iter().map(|c| c.diagnostics.len()).sum::<usize>() - all;
    // Whose errors they are, where that is not plain.
    let wrong: Vec<&str> = checked.iter().filter(|c| !c.sound).filter_map(|c| c.wanted.as_deref()).collect();
    let whose = match wrong.len() {
        0 => String::new(),
        _ if checked.len() < 2 => String::new(),
        several if several > 1 => {
            let of = |one: &Checked| Some(format!("{} in {}", errors(one), one.wanted.as_deref()?));
            let each: Vec<String> = checked.iter().filter(|one| errors(one) > 0).filter_map(of).collect();
            format!(" ({})", each.join(", "))
        }
        _ => format!(" in {}", wrong.join(", ")),
    };
    let plural = |n: usize, word: &str| format!("{n} {word}{}", if n == 1 { "" } else { "s" });
    let found = match (all, warnings) {
        (0, 0) => "no errors".to_owned(),
        (0, warnings) => format!("no errors, {}", plural(warnings, "warning")),
        (errors, 0) => plural(errors, "error") + &whose,
        (errors, warnings) => format!("{}{whose}, {}", plural(errors, "error"), plural(warnings, "warning")),
    };
    match checked {
        [Checked { rules: Some(rules), .. }] => format!(
            "grammar {}: {}, {}, {found}",
            rules.name,
            plural(rules.rules.len() + rules.always.len(), "rule"),
            plural(rules.requirements.len(), "requirement")
        ),
        [one] if !one.is_grammar && all == 0 => format!("a module, {found}"),
        [_] => found,
        several => format!("{} grammars and variants, {found}", several.len()),
    }
}
