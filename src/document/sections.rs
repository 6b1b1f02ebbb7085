//! Declarations in groups: what a reader looks for, in the order of the text.

use grammar_lang::names::declared;
use grammar_lang::syntax::ast::{Item, ItemKind};
use grammar_lang::syntax::declarations::{SETTINGS, kind};
use grammar_lang::syntax::{TokenKind, tokens};

use super::Module;
use super::lex::{Kind, pieces};

/// The words after which a name may be left out.
const MAYBE_NAMED: &[&str] = &["require", "prefer", "search"];

/// A declaration with what the page says of it.
pub(super) struct Entry<'a> {
    /// The word that opens it.
    pub(super) word: &'a str,
    /// Its name, if it has one.
    pub(super) name: Option<&'a str>,
    /// Its comment.
    pub(super) doc: &'a str,
    /// Its text.
    pub(super) source: &'a str,
}

/// Declarations of a kind.
pub(super) struct Group<'a> {
    pub(super) title: String,
    pub(super) entries: Vec<Entry<'a>>,
}

/// An import: a module, and the names if not all are taken.
pub(super) type Import<'a> = (&'a str, Option<Vec<&'a str>>);

/// What a module declares, by kind; `grammar` and `use` lines have their own places.
pub(super) fn groups(module: &Module) -> Vec<Group<'_>> {
    let mut groups: Vec<Group<'_>> = Vec::new();
    for item in module.items() {
        if matches!(item.kind, ItemKind::Grammar(_) | ItemKind::Use { .. }) {
            continue;
        }
        let entry = entry(module, item);
        let title = title(&entry);
        match groups.iter_mut().find(|group| group.title == title) {
            Some(group) => group.entries.push(entry),
            None => groups.push(Group { title, entries: vec![entry] }),
        }
    }
    // Settings are what the rest leads to.
    groups.sort_by_key(|group| group.title == SETTINGS);
    groups
}

fn entry<'a>(module: &'a Module, item: &'a Item) -> Entry<'a> {
    let source = source(module.text(), item.span.range());
    let word = source.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap_or("");
    let name = declared(item).map(|name| name.text.as_str()).or_else(|| second_word(word, source));
    Entry { word, name, doc: &item.doc, source }
}

/// The name of a declaration that others cannot import, or of a kind that is not known here.
fn second_word<'a>(word: &str, source: &'a str) -> Option<&'a str> {
    if kind(word).is_some_and(|kind| kind.several == SETTINGS) || MAYBE_NAMED.contains(&word) {
        return None;
    }
    let mut pieces = pieces(source).into_iter().filter(|piece| piece.kind != Kind::Space).skip(1);
    pieces.next().filter(|piece| piece.kind == Kind::Word).map(|piece| piece.text)
}

fn title(entry: &Entry<'_>) -> String {
    // `search NAME` without a block chooses one; with a block it declares one.
    if entry.word == "search" && entry.name.is_none() {
        return SETTINGS.to_owned();
    }
    kind(entry.word).map_or_else(|| entry.word.to_owned(), |kind| kind.several.to_owned())
}

/// The text of an item: with a comment that follows on its last line, without
/// those on lines below, which belong to what comes next.
fn source(text: &str, range: std::ops::Range<usize>) -> &str {
    let rest = text.get(range.start..).unwrap_or("");
    let (mut end, mut is_same_line) = (0, false);
    for token in tokens(rest) {
        match token.kind {
            TokenKind::Space => is_same_line &= !token.text.contains('\n'),
            TokenKind::Comment if is_same_line => end = token.end(),
            TokenKind::Comment => {}
            _ if token.start >= range.len() => break,
            _ => (end, is_same_line) = (token.end(), true),
        }
    }
    rest.get(..end).unwrap_or("").trim_end()
}

/// The comment at the head of a text, unless it belongs to the declaration right below it.
fn head(text: &str) -> String {
    let mut tokens = tokens(text).skip_while(|t| t.kind == TokenKind::Space);
    let mut doc = Vec::new();
    let mut next = tokens.next();
    while let Some(line) = next.filter(|t| t.kind == TokenKind::Comment && t.text.starts_with("##")) {
        doc.push(line.text.trim_start_matches('#').trim());
        let ends = tokens.next().is_none_or(|space| space.text.matches('\n').count() > 1);
        next = if ends { None } else { tokens.next() };
    }
    if next.is_none() { doc.join("\n") } else { String::new() }
}

/// What a text says about itself: the comment of its `grammar` line, or the one at its head.
pub(super) fn about(module: &Module) -> String {
    let grammar = module.items().find(|item| matches!(item.kind, ItemKind::Grammar(_)));
    let own = grammar.map(|item| item.doc.clone()).filter(|doc| !doc.is_empty());
    own.unwrap_or_else(|| head(module.text()))
}

/// The name of a grammar; none for a module.
pub(super) fn grammar(module: &Module) -> Option<&str> {
    module.items().find_map(|item| match &item.kind {
        ItemKind::Grammar(name) => Some(name.text.as_str()),
        _ => None,
    })
}

/// What a module imports.
pub(super) fn imports(module: &Module) -> Vec<Import<'_>> {
    let mut imports = Vec::new();
    for item in module.items() {
        if let ItemKind::Use { module: from, names } = &item.kind {
            let names = names.as_ref().map(|names| names.iter().map(|name| name.text.as_str()).collect());
            imports.push((from.text.as_str(), names));
        }
    }
    imports
}
