//! For tests of grammars in files: what checking and deriving them gives, as
//! text that stays the same from machine to machine, made for snapshots.
//!
//! What goes wrong is in the text, too: a snapshot shows it, a panic would hide
//! the rest. `docs/testing.md` says how to set up a project that uses this.
//!
//! ```no_run
//! use sgc::testing;
//!
//! // With the crate `insta`: insta::assert_snapshot!(testing::findings("grammars/legs.sgr"));
//! assert_eq!(testing::findings("grammars/legs.sgr"), testing::CLEAN);
//! println!("{}", testing::derivation("grammars/legs.sgr", 7, 30));
//! ```

use crate::results::FileError;
use std::path::Path;

use grammar_lang::diagnostics::Diagnostic;
use grammar_lang::format::{Unformatted, format};
use grammar_lang::ir::RuleSet;
use grammar_lang::source::SourceMap;
pub use grammar_lang::testing::{CLEAN, MODULE};
use grammar_lang::testing::{rule_set, shown};

use crate::derive::{Derivation, run_example};
use crate::loader::{Folder, read_text};
use crate::results::describe;
use crate::trials::check_motions;

/// A file that has been read and checked.
struct Checked {
    rules: Option<RuleSet>,
    is_grammar: bool,
    findings: Vec<Diagnostic>,
    sources: SourceMap,
}

impl Checked {
    /// Reads a file. Everything is named from its folder, so that no text
    /// depends on where the project lies.
    fn read(path: &Path) -> Result<Self, FileError> {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let text = read_text(path).map_err(FileError::read(Path::new(&name)))?;
        let loader = Folder { path: path.parent().unwrap_or(Path::new("")).to_owned() };
        let mut sources = SourceMap::default();
        let entry = sources.add(name, text);
        let compiled = grammar_lang::compile(&loader, &mut sources, entry, &[], None);
        let mut findings = compiled.told(check_motions(&compiled, entry, &sources));
        let sound = !findings.iter().any(Diagnostic::is_error);
        if sound && compiled.offers.len() < 2 {
            findings.extend(compiled.unneeded(entry));
        }
        let rules = compiled.ruleset.filter(|_| sound && compiled.is_grammar);
        Ok(Self { rules, is_grammar: compiled.is_grammar, findings, sources })
    }

    fn shown(&self) -> String {
        shown(&self.findings, &self.sources)
    }

    /// What can be said of its rule set; if it has none, why.
    fn with_rules(&self, say: impl Fn(&RuleSet) -> String) -> String {
        match &self.rules {
            Some(rules) => say(rules),
            None if self.is_grammar || !self.findings.is_empty() => self.shown(),
            None => MODULE.to_owned(),
        }
    }
}

/// What is to be said of a file, or why it cannot be read.
fn of(path: &Path, say: impl Fn(&Checked) -> String) -> String {
    Checked::read(path).map_or_else(|error| format!("{error}\n"), |checked| say(&checked))
}

/// What a grammar comes to, much as a grammar is written: variants, imports and parameters
/// resolved, numbers in units that people use. Findings if there are errors.
pub fn resolved(path: impl AsRef<Path>) -> String {
    of(path.as_ref(), |checked| checked.with_rules(grammar_lang::ir::resolved))
}

/// A grammar as `sgc fmt` would lay it out; findings if it cannot be read.
pub fn formatted(path: impl AsRef<Path>) -> String {
    of(path.as_ref(), |checked| match checked.sources.iter().next() {
        Some((entry, _)) => match format(&checked.sources, entry) {
            Ok(text) => text,
            Err(Unformatted::Errors(errors)) => shown(&errors, &checked.sources),
            Err(Unformatted::Altered) => "it could not be laid out without changing it\n".to_owned(),
        },
        None => String::new(),
    })
}

/// What an example of a grammar derives; or why it fails.
pub fn example(path: impl AsRef<Path>, name: &str) -> String {
    of(path.as_ref(), |checked| {
        checked.with_rules(|rules| match rules.examples.get(name) {
            Some(example) => match run_example(rules, name, example) {
                Ok(derivation) => describe::derivation(rules, &derivation),
                Err(failure) => shown(&[*failure], &checked.sources),
            },
            None => format!("there is no example `{name}`\n"),
        })
    })
}

/// Everything that `sgc check` finds in a grammar or module; [`CLEAN`] if that is nothing.
pub fn findings(path: impl AsRef<Path>) -> String {
    of(path.as_ref(), Checked::shown)
}

/// The typed rule set of a grammar as JSON: every number that the engine will
/// see, in SI units. Findings if there are errors.
pub fn rules(path: impl AsRef<Path>) -> String {
    of(path.as_ref(), |checked| checked.with_rules(rule_set))
}

/// The design that a seed gives in some moves, as `sgc derive` prints it: the
/// steps with what each matched and chose, then the parts. Findings if there are errors.
pub fn derivation(path: impl AsRef<Path>, seed: u64, steps: usize) -> String {
    of(path.as_ref(), |checked| {
        checked.with_rules(|rules| {
            describe::derived(rules, &checked.sources, Derivation::begin(rules), seed, steps, &mut |_| {}).0
        })
    })
}
