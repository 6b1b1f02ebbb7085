//! Reads a grammar for a command.

use std::io::Read;
use std::path::Path;

use grammar_lang::diagnostics::Diagnostic;
use grammar_lang::diagnostics::render::{Format, render};
use grammar_lang::ir::RuleSet;
use grammar_lang::source::SourceMap;

use super::exit;
use super::output::{self, Fault};
use crate::derive::check_start;
pub(super) use crate::results::describe::no_value;
use crate::world::{Files, read_text};

/// What checking a file gave.
pub(super) struct Checked {
    pub(super) offers: Vec<String>,
    pub(super) rules: Option<RuleSet>,
    pub(super) is_grammar: bool,
    pub(super) diagnostics: Vec<Diagnostic>,
    pub(super) sources: SourceMap,
}

/// The name and the text of a file; `-` is standard input.
pub(super) fn text(path: &Path) -> Result<(String, String), Fault> {
    let fault = |e: String| Fault::usage(format!("cannot read {}: {e}", path.display()));
    if path == Path::new("-") {
        let mut bytes = Vec::new();
        std::io::stdin().lock().read_to_end(&mut bytes).map_err(|e| fault(e.to_string()))?;
        return Ok(("<stdin>".to_owned(), String::from_utf8_lossy(&bytes).into_owned()));
    }
    Ok((path.to_string_lossy().into_owned(), read_text(path).map_err(fault)?))
}

/// Reads and checks a file; `-` is standard input. Of several grammars and variants that
/// it declares, `wanted` is checked.
pub(super) fn check(
    path: &Path,
    overrides: &[(String, String)],
    wanted: Option<&str>,
) -> Result<Checked, Fault> {
    let (name, text) = text(path)?;
    let mut sources = SourceMap::default();
    let entry = sources.add(name, text);
    let compiled = grammar_lang::compile(&Files, &mut sources, entry, overrides, wanted);
    let mut diagnostics = compiled.diagnostics;
    diagnostics.extend(compiled.ruleset.as_ref().and_then(check_start));
    let offers = compiled.offers;
    let sound = !diagnostics.iter().any(Diagnostic::is_error);
    let rules = compiled.ruleset.filter(|_| sound);
    Ok(Checked { offers, rules, is_grammar: compiled.is_grammar, diagnostics, sources })
}

/// Reads a grammar that is to be run: findings go to standard error.
pub(super) fn grammar(
    path: &Path,
    overrides: &[(String, String)],
    wanted: Option<&str>,
) -> Result<(RuleSet, SourceMap), Fault> {
    let checked = check(path, overrides, wanted)?;
    if !checked.diagnostics.is_empty() {
        let text = render(&checked.diagnostics, &checked.sources, Format::Full, output::colour_err());
        output::note(text.trim_end());
    }
    match checked.rules {
        Some(rules) => Ok((rules, checked.sources)),
        None if checked.diagnostics.iter().any(Diagnostic::is_error) => {
            Err(Fault { code: exit::INPUT, message: String::new() })
        }
        None => Err(Fault::input(format!(
            "{} is a module for other grammars to use: it has no `grammar NAME` line, so there is nothing to run",
            path.display()
        ))),
    }
}
