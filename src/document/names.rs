//! Which words are names, and where on the page they are explained.

use std::cell::RefCell;
use std::collections::BTreeMap;

use grammar_lang::source::SourceMap;
use grammar_lang::syntax;
use grammar_lang::syntax::ast::ItemKind;

use super::{Module, prose};

/// Whether a thing can have a name. The parser says, so that this holds for every reserved word.
#[must_use]
pub fn is_name(word: &str) -> bool {
    let mut sources = SourceMap::default();
    let file = sources.add("name", format!("grammar {word}\n"));
    let (tree, errors) = syntax::parse(&sources, file);
    let named =
        |item: &std::rc::Rc<syntax::ast::Item>| matches!(&item.kind, ItemKind::Grammar(n) if n.text == word);
    errors.is_empty() && tree.items.len() == 1 && tree.items.iter().all(named)
}

/// What a word of a text means.
pub(super) enum Meaning {
    /// Explained on the page, at an anchor.
    Here(String),
    /// Imported from a module that is not on the page; what to say about it.
    Elsewhere(String),
    /// A word of the language.
    Reserved,
    /// Nothing that the page knows.
    Other,
}

/// The words of a page.
pub(super) struct Names<'a> {
    modules: &'a [Module],
    /// What has been asked already: the parser need not answer twice.
    reserved: RefCell<BTreeMap<String, bool>>,
}

impl<'a> Names<'a> {
    pub(super) fn new(modules: &'a [Module]) -> Self {
        Self { modules, reserved: RefCell::default() }
    }

    /// Where on the page a module's declaration stands. Modules may declare the same name.
    pub(super) fn anchor(&self, module: &str, name: &str) -> String {
        if self.modules.len() == 1 { name.to_owned() } else { format!("{module}.{name}") }
    }

    /// What a word means in a module.
    pub(super) fn meaning(&self, module: &Module, word: &str) -> Meaning {
        let known = module.own().and_then(|own| own.scope.get(word)).copied();
        let Some(declaration) = known else {
            return if self.is_reserved(word) { Meaning::Reserved } else { Meaning::Other };
        };
        let home = module.program.modules.get(declaration.module).map_or("", |m| m.name.as_str());
        if self.modules.iter().any(|m| m.name == home) {
            return Meaning::Here(self.anchor(home, word));
        }
        let about =
            module.program.item(declaration).map_or_else(String::new, |i| prose::first_sentence(&i.doc));
        Meaning::Elsewhere(if about.is_empty() {
            format!("from {home}")
        } else {
            format!("{about} (from {home})")
        })
    }

    fn is_reserved(&self, word: &str) -> bool {
        if let Some(known) = self.reserved.borrow().get(word) {
            return *known;
        }
        let reserved = !is_name(word);
        self.reserved.borrow_mut().insert(word.to_owned(), reserved);
        reserved
    }
}
