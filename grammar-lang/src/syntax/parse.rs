//! Runs the grammar over a whole text and gathers items and errors.

use pest::Parser;
use pest::iterators::Pair;
use pest_derive::Parser;

use super::ast::Module;
use super::braces::bare;
use super::lower::Lowering;
use super::{recover, strange};
use crate::diagnostics::{Code, Diagnostic};
use crate::source::{FileId, Span};

/// The parser that pest derives.
#[derive(Parser)]
#[grammar = "syntax/grammar.pest"]
pub(super) struct SgrParser;

/// How many brackets may be open at once: recursion in the parser and in all
/// that walks the tree is bounded by it.
const DEEPEST: usize = 48;

/// Declarations with a name that stand outside all blocks, but for those of a variant.
const BLOCKS: &[&str] = &[
    "rule",
    "actuation",
    "model",
    "search",
    "enum",
    "record",
    "pattern",
    "term",
    "require",
    "prefer",
    "example",
    "task",
];

/// The longest text that is read, in bytes: spans are 32 bits wide.
const LONGEST: usize = 64 << 20;

pub(super) fn module(text: &str, file: FileId) -> (Module, Vec<Diagnostic>) {
    if let Some(refusal) = refuse(text, file) {
        return (Module::default(), vec![refusal]);
    }
    let clean = strange::cleaned(text, file);
    let (module, mut errors) = items(&clean.text, file);
    errors.retain(|e| !clean.is_echo(e));
    errors.extend(clean.errors);
    (module, errors)
}

/// Reads a clean text declaration by declaration.
fn items(text: &str, file: FileId) -> (Module, Vec<Diagnostic>) {
    let mut lowering = Lowering::new(text, file, 0);
    let mut module = Module::default();
    let pairs = match SgrParser::parse(Rule::file, text) {
        Ok(pairs) => pairs,
        // `file` matches every text; should it not, the whole text is junk.
        Err(_) => {
            let mut errors = lowering.finish();
            recover::junk(text, 0, text.len(), file, &mut module, &mut errors);
            return (module, errors);
        }
    };
    let mut errors = Vec::new();
    let mut pairs = pairs.flat_map(Pair::into_inner).peekable();
    while let Some(pair) = pairs.next() {
        match pair.as_rule() {
            // What goes on in the same line belongs to the declaration, and is where it went wrong.
            Rule::item if pairs.peek().is_some_and(|next| goes_on(text, &pair, next)) => {
                let end = pairs.next().map_or(0, |junk| junk.as_span().end());
                recover::junk(text, pair.as_span().start(), end, file, &mut module, &mut errors);
            }
            Rule::item => {
                if let Some(item) = lowering.item(pair) {
                    module.items.push(item);
                }
            }
            Rule::junk => {
                let span = pair.as_span();
                recover::junk(text, span.start(), span.end(), file, &mut module, &mut errors);
            }
            _ => {}
        }
    }
    errors.extend(lowering.finish());
    (module, errors)
}

/// Whether a declaration is followed by something unreadable in its last line.
fn goes_on(text: &str, item: &Pair<'_, Rule>, next: &Pair<'_, Rule>) -> bool {
    let end = item.as_span().start() + item.as_str().trim_end().len();
    let between = text.get(end..next.as_span().start()).unwrap_or("\n");
    next.as_rule() == Rule::junk && !between.contains('\n')
}

/// Knows where a block ends for certain, although its `}` is missing.
struct Blocks<'a> {
    text: &'a str,
    /// From here on blocks may hold declarations.
    variants: usize,
}

impl<'a> Blocks<'a> {
    fn new(text: &'a str) -> Self {
        Self { text, variants: text.find("variant").unwrap_or(text.len()) }
    }

    /// Whether everything that is open ends before the line at a place: the line begins a declaration
    /// that nothing but a variant can hold. So the parser does not go deeper there, either.
    fn end_before(&self, place: usize) -> bool {
        let rest = self.text.get(place..).unwrap_or("");
        let word = rest.split([' ', '\t']).next().unwrap_or("");
        place < self.variants && BLOCKS.contains(&word) && rest.get(word.len() + 1..).is_some_and(is_name)
    }
}

/// Whether a text begins with a letter, as names do.
fn is_name(text: &str) -> bool {
    text.trim_start_matches([' ', '\t']).starts_with(|c: char| c.is_alphabetic() || c == '_')
}

/// Texts that are not worth parsing.
fn refuse(text: &str, file: FileId) -> Option<Diagnostic> {
    let at = |start, end| Span::new(file, start, end);
    if text.len() > LONGEST {
        return Some(
            Diagnostic::new(Code::NOT_TEXT, at(0, 0), "this file is larger than 64 MB")
                .help("a grammar is a few kilobytes of text; is this the right file?"),
        );
    }
    if let Some(place) = text.find('\0').or_else(|| text.find('\u{FFFD}')) {
        return Some(
            Diagnostic::new(
                Code::NOT_TEXT,
                at(place, place + text.get(place..).and_then(|t| t.chars().next()).map_or(1, char::len_utf8)),
                "this file is not text",
            )
            .label("the first byte that no text has")
            .help("a grammar is a plain text file in UTF-8: save it again with that encoding"),
        );
    }
    let mut depth = 0usize;
    let blocks = Blocks::new(text);
    let mut prefixes = 0usize;
    for (place, c) in bare(text) {
        match c {
            '\n' if blocks.end_before(place + 1) => depth = 0,
            '(' | '[' | '{' => depth += 1,
            ')' | ']' | '}' => depth = depth.saturating_sub(1),
            _ => {}
        }
        // Chains of `-` recurse as brackets do.
        prefixes = match c {
            '-' => prefixes + 1,
            c if c.is_whitespace() => prefixes,
            _ => 0,
        };
        if depth > DEEPEST || prefixes > DEEPEST {
            return Some(
                Diagnostic::new(Code::TOO_DEEP, at(place, place + c.len_utf8()), "this is nested too deeply")
                    .label(format!("level {}", DEEPEST + 1))
                    .help("give parts of it a name with `let`"),
            );
        }
    }
    let words = ["if", "not", "forall", "exists", "over"];
    let mut run = 0usize;
    for word in text.split_whitespace() {
        // Words that recurse without a bracket: many in one expression are as deep as brackets.
        if words.contains(&word) {
            run += 1;
        } else if super::declarations::ITEM_WORDS.contains(&word) {
            run = 0;
        }
        if run > 4 * DEEPEST {
            return Some(
                Diagnostic::new(Code::TOO_DEEP, at(0, 0), "an expression in this file is nested too deeply")
                    .help("give parts of it a name with `let`"),
            );
        }
    }
    let bare = text
        .lines()
        .map(|l| {
            l.split('#').next().unwrap_or("").trim_matches(|c: char| c.is_whitespace() || c == '\u{FEFF}')
        })
        .all(str::is_empty);
    bare.then(|| {
        Diagnostic::new(Code::EMPTY, at(0, 0), "this file declares nothing")
            .help("a grammar begins with `grammar NAME`")
    })
}
