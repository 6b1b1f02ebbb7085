//! Reads a grammar for a command.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use grammar_lang::Compiler;
use grammar_lang::diagnostics::render::{Format, more, render};
use grammar_lang::diagnostics::{Code, Diagnostic, did_you_mean};
use grammar_lang::ir::RuleSet;
use grammar_lang::names::MOST_VARIANTS;
use grammar_lang::source::{Loader, SourceMap, Span};
use grammar_lang::types::Idle;

use super::exit;
use super::output::{self, Fault};
use crate::derive::{Candidate, Derivation};
use crate::loader::{Files, read_text};
use crate::reading;
pub(super) use crate::results::describe::no_value;
use crate::search;
use crate::trials::check_motions;

/// What messages call standard input.
pub(super) const STDIN: &str = "<stdin>";

/// What checking a file gave.
pub(super) struct Checked {
    /// The grammar or variant that was asked for, where one was.
    pub(super) wanted: Option<String>,
    /// Whether nothing is wrong with it, also nothing that is told for another one.
    pub(super) sound: bool,
    pub(super) offers: Vec<String>,
    pub(super) rules: Option<RuleSet>,
    pub(super) is_grammar: bool,
    pub(super) diagnostics: Vec<Diagnostic>,
    /// What it could use, and what it does not, where the file declares several.
    idle: Idle,
    /// Warnings of warnings that it allows without need; where the file declares several, another may need them.
    unneeded: Vec<Diagnostic>,
    pub(super) sources: SourceMap,
}

/// A text that is to be checked.
pub(super) struct Text {
    /// As it was written on the command line.
    pub(super) path: PathBuf,
    /// What messages call it.
    pub(super) name: String,
    pub(super) text: String,
}

/// Reads a file; `-` is standard input.
pub(super) fn read(path: &Path) -> Result<Text, Fault> {
    let fault = |e: std::io::Error| match e.kind() {
        std::io::ErrorKind::NotFound => Fault::usage(not_there(path)),
        _ => Fault::usage(format!("cannot read {}: {e}", path.display())),
    };
    let (name, text) = if path == Path::new("-") {
        let bytes = reading::bounded(std::io::stdin().lock()).map_err(fault)?;
        (STDIN.to_owned(), String::from_utf8_lossy(&bytes).into_owned())
    } else {
        (path.to_string_lossy().into_owned(), read_text(path).map_err(fault)?)
    };
    Ok(Text { path: path.to_owned(), name, text })
}

/// Says that there is no such file, and which one beside it may be meant.
fn not_there(path: &Path) -> String {
    let message = format!("cannot read {}: there is no such file", path.display());
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let beside = std::fs::read_dir(folder.unwrap_or(Path::new("."))).into_iter().flatten().flatten();
    let mut names: Vec<String> =
        beside.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort_unstable();
    let wanted = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let with_end = format!("{wanted}.sgr");
    let near = match names.contains(&with_end) {
        true => Some(format!("did you mean `{with_end}`?")),
        false => did_you_mean(&wanted, names.iter().map(String::as_str)),
    };
    near.map_or(message.clone(), |near| format!("{message}: {near}"))
}

/// Checks a text with what a loader gives; of several grammars and variants that it declares, the wanted one.
pub(super) fn check(
    loader: &dyn Loader,
    name: &str,
    text: &str,
    overrides: &[(String, String)],
    wanted: Option<&str>,
) -> Checked {
    let mut checked = check_with(&mut Compiler::new(loader), name, text, overrides, wanted);
    if checked.offers.len() < 2 {
        checked.diagnostics.append(&mut checked.unneeded);
    }
    checked
}

fn check_with(
    compiler: &mut Compiler<'_>,
    name: &str,
    text: &str,
    overrides: &[(String, String)],
    wanted: Option<&str>,
) -> Checked {
    let mut sources = SourceMap::default();
    let entry = sources.add(name, text);
    let compiled = compiler.compile(&mut sources, entry, overrides, wanted);
    let mut diagnostics = compiled.told(check_motions(&compiled, entry, &sources));
    // Warnings are shown once there are no errors.
    if !diagnostics.iter().any(Diagnostic::is_error)
        && let Some(error) = compiled.ruleset.as_ref().and_then(unfit)
    {
        diagnostics = vec![error];
    }
    let sound = !diagnostics.iter().any(Diagnostic::is_error);
    let unneeded = if sound { compiled.unneeded(entry) } else { Vec::new() };
    let offers = compiled.offers;
    let rules = compiled.ruleset.filter(|_| sound);
    let (is_grammar, idle, wanted) = (compiled.is_grammar, compiled.idle, wanted.map(str::to_owned));
    Checked { wanted, sound, offers, rules, is_grammar, diagnostics, idle, unneeded, sources }
}

/// That the solver cannot simulate the design that a search begins with.
fn unfit(rules: &RuleSet) -> Option<Diagnostic> {
    let first = Derivation::start(rules, rules.from.as_deref()).ok()?;
    let candidate = Candidate::new(rules, Arc::new(first));
    let unfit = search::unfit(&candidate, search::solver(rules).text())?;
    let lattice = || rules.lattice.as_ref().map(|lattice| lattice.span);
    let begun = || rules.begin.first().map(|placed| placed.span);
    let example = rules.from.as_ref().and_then(|name| rules.examples.get(name)).map(|example| example.span);
    let place = example.or_else(lattice).or_else(begun)?;
    let what =
        if example.is_some() { "the example that the search starts from" } else { "the initial design" };
    let told = Diagnostic::new(Code::MODEL_MISFIT, place, format!("{what} cannot be simulated"));
    Some(told.label(what).help(unfit.reason))
}

/// Checks the grammar of a text and each of its variants. What several of them share is
/// told by the first. `each` is shown the rule set of each that is sound; of several, none is kept.
pub(super) fn check_all(
    loader: &dyn Loader,
    name: &str,
    text: &str,
    overrides: &[(String, String)],
    each: &mut dyn FnMut(&RuleSet),
) -> Vec<Checked> {
    let mut compiler = Compiler::new(loader);
    let mut first = check_with(&mut compiler, name, text, overrides, None);
    // That there are too many is told by each.
    if first.offers.len() < 2 || first.offers.len() > MOST_VARIANTS {
        first.diagnostics.append(&mut first.unneeded);
        first.rules.iter().for_each(each);
        return vec![first];
    }
    let mut all: Vec<Checked> = Vec::new();
    let mut told = BTreeSet::new();
    let offers = first.offers.clone();
    let mut first = Some(first);
    for offer in &offers {
        // One of them has been checked to know which there are.
        let known = first.take_if(|first| first.rules.as_ref().is_some_and(|rules| rules.name == *offer));
        let mut one = match known {
            Some(known) => Checked { wanted: Some(offer.clone()), ..known },
            None => check_with(&mut compiler, name, text, overrides, Some(offer)),
        };
        let sources = &one.sources;
        let key = |d: &Diagnostic| {
            let place = sources.get(d.span().file).map(|s| s.name.clone());
            (d.code.id, d.message.clone(), d.span().start, d.span().end, place)
        };
        one.diagnostics.retain(|d| !told.contains(&key(d)));
        told.extend(one.diagnostics.iter().map(key));
        // A thousand variants of a long grammar would fill the memory.
        one.rules.take().iter().for_each(&mut *each);
        if one.diagnostics.is_empty() && !all.is_empty() {
            one.sources = SourceMap::default();
        }
        all.push(one);
    }
    let idle = used_by_none(&all);
    let unneeded = needed_by_none(&all);
    if let Some(first) = all.first_mut() {
        first.diagnostics.extend(idle);
        first.diagnostics.extend(unneeded);
    }
    all
}

/// Warnings of what none of several grammars and variants uses: each that has it leaves it idle.
fn used_by_none(all: &[Checked]) -> Vec<Diagnostic> {
    if all.iter().any(|one| one.diagnostics.iter().any(Diagnostic::is_error)) {
        // What an error hides might be the use.
        return Vec::new();
    }
    let mut used: BTreeSet<Span> = BTreeSet::new();
    for Checked { idle: Idle { there, unused }, .. } in all {
        let unused: BTreeSet<Span> = unused.iter().map(Diagnostic::span).collect();
        used.extend(there.iter().filter(|span| !unused.contains(span)));
    }
    let mut told = BTreeSet::new();
    let unused = all.iter().flat_map(|one| &one.idle.unused);
    let idle = unused.filter(|d| !used.contains(&d.span()) && told.insert((d.span(), d.message.clone())));
    idle.cloned().collect()
}

/// Warnings of warnings that none of several grammars and variants needs to allow.
fn needed_by_none(all: &[Checked]) -> Vec<Diagnostic> {
    let Some((first, others)) = all.split_first() else { return Vec::new() };
    let places = |one: &Checked| one.unneeded.iter().map(Diagnostic::span).collect::<BTreeSet<Span>>();
    let others: Vec<BTreeSet<Span>> = others.iter().map(places).collect();
    let by_none = first.unneeded.iter().filter(|d| others.iter().all(|one| one.contains(&d.span())));
    by_none.cloned().collect()
}

/// Reads a grammar that is to be run: findings go to standard error.
pub(super) fn grammar(
    path: &Path,
    overrides: &[(String, String)],
    wanted: Option<&str>,
) -> Result<(RuleSet, SourceMap), Fault> {
    grammar_or(path, overrides, wanted, ", so there is nothing to run")
}

/// The same, with what is said of a module, which is no grammar.
pub(super) fn grammar_or(
    path: &Path,
    overrides: &[(String, String)],
    wanted: Option<&str>,
    of_module: &str,
) -> Result<(RuleSet, SourceMap), Fault> {
    grammar_of(&read(path)?, overrides, wanted, of_module)
}

/// The same of a text that has been read.
pub(super) fn grammar_of(
    text: &Text,
    overrides: &[(String, String)],
    wanted: Option<&str>,
    of_module: &str,
) -> Result<(RuleSet, SourceMap), Fault> {
    let path = &text.path;
    let checked = check(&Files, &text.name, &text.text, overrides, wanted);
    if !checked.diagnostics.is_empty() {
        let text = render(&checked.diagnostics, &checked.sources, Format::Full, output::colour_err());
        output::note((text + &more(&checked.diagnostics)).trim_end());
    }
    match checked.rules {
        Some(rules) => Ok((rules, checked.sources)),
        None if checked.diagnostics.iter().any(Diagnostic::is_error) => {
            Err(Fault { code: exit::INPUT, message: String::new() })
        }
        None => Err(Fault::input(format!(
            "{} is a module for other grammars to use: it has no `grammar NAME` line{of_module}",
            path.display()
        ))),
    }
}
