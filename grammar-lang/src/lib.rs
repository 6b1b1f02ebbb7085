//! The `sgc` grammar language: from text to a typed rule set.
//!
//! Pure: no file system, clock, random numbers or terminal. Texts come from a
//! [`source::Loader`]; findings are data.

pub mod bounds;
pub mod diagnostics;
pub mod eval;
pub mod format;
pub mod ir;
pub mod lint;
pub mod names;
pub mod shape;
pub mod source;
pub mod syntax;
pub mod testing;
pub mod types;
pub mod units;

use diagnostics::Diagnostic;
use eval::Budget;
use ir::RuleSet;
use source::{FileId, Loader, SourceMap};
use syntax::Trees;

/// What a compilation gives: always all findings, and the rule set if there is no error.
#[derive(Debug)]
pub struct Compiled {
    /// The typed rule set of a grammar without errors.
    pub ruleset: Option<RuleSet>,
    /// Whether the text is a grammar, not only a module for others to import.
    pub is_grammar: bool,
    /// The grammar and the variants that the text declares.
    pub offers: Vec<String>,
    /// Everything found.
    pub diagnostics: Vec<Diagnostic>,
    /// Of a text with several grammars and variants: what this one could use, and what it does not.
    pub idle: types::Idle,
    /// What variants changed.
    pub changes: Vec<names::Change>,
    /// The warnings that the texts allow: [`Compiled::diagnostics`] are without them.
    pub allowed: names::Allowed,
    /// What more checks of it may spend.
    budget: Budget,
}

impl Compiled {
    /// Whether any finding is an error.
    #[must_use]
    pub fn has_errors(&self) -> bool {
        self.diagnostics.iter().any(Diagnostic::is_error)
    }

    /// All that is told of the text: what compiling it found, and what `more` whoever built its initial design found. Warnings that it
    /// allows are left out, and so is what an error makes of the rest of the text.
    #[must_use]
    pub fn told(&self, more: impl IntoIterator<Item = Diagnostic>) -> Vec<Diagnostic> {
        let mut all: Vec<Diagnostic> = self.diagnostics.iter().cloned().chain(more).collect();
        self.allowed.hush(&mut all);
        if all.iter().any(Diagnostic::is_error) {
            all.retain(Diagnostic::is_error);
        }
        all
    }

    /// Warnings of what a sound grammar allows without need, once everything has been [told](Self::told). Where the text declares several
    /// grammars, another one may need it.
    #[must_use]
    pub fn unneeded(&self, entry: FileId) -> Vec<Diagnostic> {
        let is_whole = self.is_grammar && self.ruleset.is_some();
        if is_whole { self.allowed.unused(entry).collect() } else { Vec::new() }
    }

    /// Whether its rule set is that of a variant of what its text declares first.
    #[must_use]
    pub fn is_varied(&self) -> bool {
        self.ruleset.as_ref().is_some_and(|ruleset| is_varied(&self.offers, ruleset))
    }

    /// What more is found where it is known how many parts the initial design has: only whoever
    /// builds it knows the images that the symmetry makes.
    #[must_use]
    pub fn found_from(&self, begun: &bounds::Begun, entry: FileId, sources: &SourceMap) -> Vec<Diagnostic> {
        let Some(ruleset) = &self.ruleset else { return Vec::new() };
        let mut found = Vec::new();
        let own = lint::Own { entry, is_varied: is_varied(&self.offers, ruleset) };
        lint::run(ruleset, Some(begun), own, &self.budget, &mut found);
        let known =
            |d: &Diagnostic| self.diagnostics.iter().any(|k| (k.code, k.span()) == (d.code, d.span()));
        found.retain(|d| !known(d));
        self.allowed.hush(&mut found);
        found.into_iter().map(|d| names::with_changes(d, &self.changes, sources)).collect()
    }
}

/// Whether a rule set is that of a variant of what its text declares first.
fn is_varied(offers: &[String], ruleset: &RuleSet) -> bool {
    offers.first().is_some_and(|first| *first != ruleset.name)
}

/// Reads and checks a grammar. `overrides` are the parameters set from outside;
/// `wanted` is one of several grammars and variants that the text declares.
pub fn compile(
    loader: &dyn Loader,
    sources: &mut SourceMap,
    entry: FileId,
    overrides: &[(String, String)],
    wanted: Option<&str>,
) -> Compiled {
    Compiler::new(loader).compile(sources, entry, overrides, wanted)
}

/// Compiles several grammars and variants of the same texts: each text is parsed once.
pub struct Compiler<'l> {
    loader: &'l dyn Loader,
    trees: Trees,
    /// What checks of all that it compiles may spend together.
    budget: Budget,
}

impl<'l> Compiler<'l> {
    /// A compiler that has read nothing yet.
    #[must_use]
    pub fn new(loader: &'l dyn Loader) -> Self {
        Self { loader, trees: Trees::default(), budget: Budget::of_file() }
    }

    /// See [`compile`].
    pub fn compile(
        &mut self,
        sources: &mut SourceMap,
        entry: FileId,
        overrides: &[(String, String)],
        wanted: Option<&str>,
    ) -> Compiled {
        let Self { loader, trees, budget } = self;
        let (program, mut diagnostics) = names::load_with(trees, *loader, sources, entry, wanted);
        let offers = program.modules.first().map_or(Vec::new(), |m| names::offers(&m.tree));
        let is_grammar = !offers.is_empty();
        let types::Checked { ruleset, found, idle } = types::check(&program, sources, overrides, budget);
        diagnostics.extend(found);
        let allowed = names::Allowed::of(&program, &mut diagnostics);
        let clean = !diagnostics.iter().any(Diagnostic::is_error);
        if let Some(ruleset) = ruleset.as_ref().filter(|_| clean) {
            let own = lint::Own { entry, is_varied: is_varied(&offers, ruleset) };
            lint::run(ruleset, None, own, budget, &mut diagnostics);
        }
        let ruleset = ruleset.filter(|_| !diagnostics.iter().any(Diagnostic::is_error));
        names::with_imports(&mut diagnostics, *loader, sources);
        diagnostics::with_habits(&mut diagnostics, sources);
        names::told_once(&mut diagnostics);
        allowed.hush(&mut diagnostics);
        // What an error makes of the rest of a text is no news.
        if diagnostics.iter().any(Diagnostic::is_error) {
            diagnostics.retain(Diagnostic::is_error);
        }
        let changes = program.changes;
        let diagnostics =
            diagnostics.into_iter().map(|d| names::with_changes(d, &changes, sources)).collect();
        let budget = budget.clone();
        Compiled { ruleset, is_grammar, offers, diagnostics, idle, changes, allowed, budget }
    }
}
