//! Pages of documentation: what a text declares, from its `##` comments.
//!
//! A page is made from the syntax tree and slices of the text. It takes
//! declarations as they come, by the word that opens them: a kind of
//! declaration that this module has never heard of is shown like any other.

mod code;
mod lex;
mod names;
mod page;
mod prose;
mod sections;
#[cfg(test)]
mod tests;

use std::rc::Rc;

use grammar_lang::ir::Rule;
use grammar_lang::names::{LoadedModule, Program, load};
use grammar_lang::source::{Loader, Source, SourceMap};
use grammar_lang::syntax::{
    self,
    ast::{Item, ItemKind},
};
pub use names::is_name;

/// What the comment above a rule says first: one sentence without its full stop, empty if there is none.
#[must_use]
pub fn about_rule(sources: &SourceMap, rule: &Rule) -> String {
    let (module, _) = syntax::parse(sources, rule.span.file);
    let items = module.items.iter();
    let mut own =
        items.filter(|item| matches!(&item.kind, ItemKind::Rule(name, _) if name.text == rule.name));
    own.next().map_or_else(String::new, |item| prose::first_sentence(&item.doc))
}

/// A text that a page documents, with all that it imports.
struct Module {
    /// What the loader calls it: a path, or `std.blocks`.
    name: String,
    program: Program,
    sources: SourceMap,
}

impl Module {
    fn new(loader: &dyn Loader, source: &Source) -> Self {
        let mut sources = SourceMap::default();
        let entry = sources.add(source.name.clone(), source.text.clone());
        let (program, _) = load(loader, &mut sources, entry, None);
        Self { name: source.name.clone(), program, sources }
    }

    /// Its own part of the program.
    fn own(&self) -> Option<&LoadedModule> {
        self.program.modules.first()
    }

    fn items(&self) -> impl Iterator<Item = &Item> {
        self.own().into_iter().flat_map(|module| &module.tree.items).map(Rc::as_ref)
    }

    fn text(&self) -> &str {
        self.own().and_then(|module| self.sources.get(module.file)).map_or("", |source| &source.text)
    }
}

/// One self-contained page about some texts. Errors in them are not told:
/// whoever wants to know checks them.
#[must_use]
pub fn page(title: &str, loader: &dyn Loader, texts: &[Source]) -> String {
    let modules: Vec<Module> = texts.iter().map(|source| Module::new(loader, source)).collect();
    page::page(title, &modules)
}
