//! What a check has found so far: each finding once, in the order of finding.

use std::collections::BTreeMap;
use std::ops::Deref;

use crate::diagnostics::{Code, Diagnostic};
use crate::source::Span;

/// Findings without repetition.
#[derive(Default)]
pub(super) struct Found {
    all: Vec<Diagnostic>,
    /// Which of them stand at a place: only those can be the same as another one there.
    at: BTreeMap<Span, Vec<usize>>,
}

impl Found {
    /// Adds a finding if it is not there yet.
    pub(super) fn add(&mut self, diagnostic: Diagnostic) {
        let here = self.at.entry(diagnostic.span()).or_default();
        if here.iter().any(|i| self.all.get(*i) == Some(&diagnostic)) {
            return;
        }
        here.push(self.all.len());
        self.all.push(diagnostic);
    }

    /// Changes a finding that stands at a place and begins like this; false if there is none.
    pub(super) fn amend(
        &mut self,
        place: Span,
        code: &Code,
        begins: &str,
        change: impl FnOnce(&mut Diagnostic),
    ) -> bool {
        let here = self.at.get(&place).into_iter().flatten();
        let known = here
            .copied()
            .find(|i| self.all.get(*i).is_some_and(|d| d.code == code && d.message.starts_with(begins)));
        let Some(found) = known.and_then(|i| self.all.get_mut(i)) else { return false };
        change(found);
        true
    }

    /// Takes out what was found after the first `known`, to be looked at again.
    pub(super) fn split_off(&mut self, known: usize) -> Vec<Diagnostic> {
        let later = self.all.split_off(known.min(self.all.len()));
        for diagnostic in &later {
            if let Some(here) = self.at.get_mut(&diagnostic.span()) {
                here.retain(|i| *i < known);
            }
        }
        later
    }

    /// Gives names that were found to be unknown after the first `known` findings another help, where there is one for a name.
    pub(super) fn help_unknown(&mut self, known: usize, help: impl Fn(&str) -> Option<String>) {
        for mut error in self.split_off(known) {
            let name = error.message.strip_prefix("unknown name `").and_then(|rest| rest.strip_suffix('`'));
            if let Some(help) = name.filter(|_| error.code == Code::UNKNOWN_NAME).and_then(&help) {
                error.help = Some(help);
                error.fix = None;
            }
            self.add(error);
        }
    }

    /// All of them.
    pub(super) fn into_vec(self) -> Vec<Diagnostic> {
        self.all
    }
}

impl Deref for Found {
    type Target = [Diagnostic];

    fn deref(&self) -> &[Diagnostic] {
        &self.all
    }
}
