//! Runs the grammar over a whole text and gathers items and errors.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::rc::Rc;

use pest::Parser;
use pest::iterators::Pair;

use super::ast::Module;
use super::declarations::ITEM_WORDS;
use super::lower::Lowering;
use super::parser::{Found, Rule, SgrParser};
use super::tokens::{Scan, Token, TokenKind, deeper, tokens};
use super::{explain, recover, strange};
use crate::diagnostics::{Code, Diagnostic};
use crate::source::{FileId, Span};

/// How many brackets may be open at once: recursion in the parser and in all
/// that walks the tree is bounded by it.
const DEEPEST: i32 = 48;

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
    "sense",
    "policy",
    "require",
    "prefer",
    "example",
    "task",
];

/// The longest text that is read, in bytes: spans are 32 bits wide.
const LONGEST: usize = 64 << 20;

/// The most tokens of a text that is read: each takes about 300 bytes of memory before the grammar is checked.
const MOST_TOKENS: usize = 4_000_000;

pub(super) fn module(text: &str, file: FileId) -> (Module, Vec<Diagnostic>) {
    let scan = match scanned(text, file) {
        Ok(scan) => scan,
        Err(refusal) => return (Module::default(), vec![*refusal]),
    };
    let clean = strange::cleaned(&scan, file);
    let (module, mut errors) = match &clean.text {
        Cow::Borrowed(_) => items(&scan, file),
        Cow::Owned(text) => items(&Scan::new(text), file),
    };
    errors.retain(|e| !clean.is_echo(e));
    errors.extend(clean.errors);
    (module, once_for_each_word(errors))
}

/// Reads a clean text declaration by declaration.
fn items(scan: &Scan<'_>, file: FileId) -> (Module, Vec<Diagnostic>) {
    let text = scan.text;
    let mut lowering = Lowering::new(text, file, 0);
    let mut found = Found::default();
    // `file` matches every text; should it not, the whole text is junk.
    let Ok(pairs) = SgrParser::parse(Rule::file, text) else {
        recover::junk(scan, scan.stretch(0, text.len()), file, &mut found);
        return (found.module, found.errors);
    };
    let mut pairs = pairs.flat_map(Pair::into_inner).peekable();
    while let Some(pair) = pairs.next() {
        let span = pair.as_span();
        match pair.as_rule() {
            // What goes on in the same line belongs to the declaration, and is where it went wrong.
            Rule::item if pairs.peek().is_some_and(|next| goes_on(text, &pair, next)) => {
                let end = pairs.next().map_or(span.end(), |junk| junk.as_span().end());
                recover::junk(scan, scan.stretch(span.start(), end), file, &mut found);
            }
            Rule::item => found.module.items.extend(lowering.item(pair).map(Rc::new)),
            Rule::junk => recover::junk(scan, scan.stretch(span.start(), span.end()), file, &mut found),
            _ => {}
        }
    }
    found.module.allows = lowering.allows();
    found.errors.extend(lowering.finish());
    (found.module, found.errors)
}

/// Whether a declaration is followed by something unreadable in its last line.
fn goes_on(text: &str, item: &Pair<'_, Rule>, next: &Pair<'_, Rule>) -> bool {
    let end = item.as_span().start() + item.as_str().trim_end().len();
    let between = text.get(end..next.as_span().start()).unwrap_or("\n");
    next.as_rule() == Rule::junk && !between.contains('\n')
}

/// The tokens of a text that is worth parsing.
fn scanned(text: &str, file: FileId) -> Result<Scan<'_>, Box<Diagnostic>> {
    let refuse =
        |code, start, end, message: &str| Diagnostic::new(code, Span::new(file, start, end), message);
    if text.len() > LONGEST {
        return Err(Box::new(
            refuse(Code::NOT_TEXT, 0, 0, "this file is larger than 64 MB")
                .help("a grammar is a few kilobytes of text; is this the right file?"),
        ));
    }
    if let Some(place) = text.find('\0').or_else(|| text.find('\u{FFFD}')) {
        let length = text.get(place..).and_then(|t| t.chars().next()).map_or(1, char::len_utf8);
        return Err(Box::new(
            refuse(Code::NOT_TEXT, place, place + length, "this file is not text")
                .label("the first byte that is not text")
                .help("a grammar is a plain text file in UTF-8: save it again with that encoding"),
        ));
    }
    if text.len() > MOST_TOKENS
        && let Some(over) = tokens(text).nth(MOST_TOKENS)
    {
        return Err(Box::new(
            refuse(
                Code::NOT_TEXT,
                over.start,
                over.end(),
                "this file has more than 4 million words and symbols",
            )
            .help("a grammar has a few thousand; is this the right file?"),
        ));
    }
    let scan = Scan::new(text);
    if let Some((deep, label)) = too_deep(scan.tokens()) {
        return Err(Box::new(
            refuse(Code::TOO_DEEP, deep.start, deep.end(), "this is nested too deeply")
                .label(label)
                .help("give parts of it a name with `let`"),
        ));
    }
    if scan.tokens().iter().all(Token::is_silent) {
        return Err(Box::new(
            refuse(Code::EMPTY, 0, 0, "this file declares nothing")
                .help("a grammar begins with `grammar NAME`"),
        ));
    }
    Ok(scan)
}

/// The token at which more would recurse than the parser can bear, and what of.
fn too_deep<'t, 'a>(tokens: &'t [Token<'a>]) -> Option<(&'t Token<'a>, String)> {
    // Words that recurse without a bracket: many in one expression are as deep as brackets.
    let words = ["if", "not", "forall", "exists", "over"];
    let most_words = 4 * DEEPEST;
    let is_word = |token: &Token<'_>, word| token.kind == TokenKind::Word && token.text == word;
    // From here on blocks may hold declarations.
    let variants = tokens.iter().position(|t| is_word(t, "variant")).unwrap_or(tokens.len());
    let (mut depth, mut minuses, mut recursing) = (0i32, 0, 0);
    let mut before: Option<&Token<'_>> = None;
    for (place, token) in tokens.iter().enumerate() {
        if token.is_silent() {
            continue;
        }
        if place < variants && begins_outside(tokens, place) {
            depth = 0;
        }
        depth = (depth + deeper(token, &["(", "[", "{"], &[")", "]", "}"])).max(0);
        // Chains of `-` recurse as brackets do.
        minuses = if token.text == "-" { minuses + 1 } else { 0 };
        if token.kind == TokenKind::Word {
            let begins = ITEM_WORDS.contains(&token.text) || CLAUSE_WORDS.contains(&token.text);
            if begins && before.is_none_or(ends_expression) {
                recursing = 0;
            }
            if words.contains(&token.text) {
                recursing += 1;
            }
        }
        before = Some(token);
        if depth > DEEPEST || minuses > DEEPEST {
            return Some((token, format!("level {}", DEEPEST + 1)));
        }
        if recursing > most_words {
            let words = words.map(|word| format!("`{word}`")).join(", ");
            return Some((token, format!("one expression with more than {most_words} of {words}")));
        }
    }
    None
}

/// Reserved words that begin a clause of a block where no expression goes on.
const CLAUSE_WORDS: [&str; 15] = [
    "if", "for", "let", "set", "attach", "remove", "replace", "revert", "choose", "when", "unless", "weight",
    "shared", "vary", "drive",
];

/// Whether an expression may end with a token: after others a word such as `part` is an operand, and begins no
/// declaration.
fn ends_expression(token: &Token<'_>) -> bool {
    const GOES_ON: [&str; 16] = [
        "in",
        "is",
        "not",
        "over",
        "of",
        "adds",
        "and",
        "or",
        "if",
        "then",
        "else",
        "where",
        "at",
        "forall",
        "exists",
        "otherwise",
    ];
    match token.kind {
        TokenKind::Word => !GOES_ON.contains(&token.text),
        _ => !["(", "[", ",", ":", "=", "<", ">", "+", "-", "*", "/", ".", "->"].contains(&token.text),
    }
}

/// Whether all that is open ends before a token for certain, although braces are missing: it begins
/// a declaration with a name that nothing but a variant can hold, at the start of a line. So the parser
/// does not go deeper there, either.
fn begins_outside(tokens: &[Token<'_>], place: usize) -> bool {
    let at = |place: usize| tokens.get(place);
    let begins_line = place == 0 || at(place - 1).is_some_and(|before| before.text.ends_with('\n'));
    let is_named = at(place + 1).is_some_and(|space| space.is_silent() && !space.text.contains('\n'))
        && at(place + 2).is_some_and(|name| name.kind == TokenKind::Word);
    begins_line && is_named && at(place).is_some_and(|word| BLOCKS.contains(&word.text))
}

/// Without what follows from a name that is a word of the language: where it is declared, another name is asked for, and
/// where it is read nothing new is wrong.
fn once_for_each_word(errors: Vec<Diagnostic>) -> Vec<Diagnostic> {
    let asked = |error: &Diagnostic| error.help.as_deref().and_then(explain::word_as_name).map(str::to_owned);
    let words: BTreeSet<String> = errors.iter().filter_map(asked).collect();
    let follows = |error: &Diagnostic| {
        let found = error.message.rsplit_once("found `").and_then(|(_, found)| found.strip_suffix('`'));
        asked(error).is_none() && found.is_some_and(|found| words.contains(found))
    };
    errors.into_iter().filter(|error| !follows(error)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn errors(text: &str) -> Vec<Diagnostic> {
        module(text, FileId(0)).1
    }

    #[test]
    fn after_a_thousand_errors_the_rest_is_not_looked_at() {
        for (head, line, tail) in [("grammar g\n", "x\n", ""), ("rule r {\n", "match x y\n", "}\n")] {
            let text = |lines: usize| format!("{head}{}{tail}", line.repeat(lines));
            assert_eq!(errors(&text(900)).len(), 900);
            let found = errors(&text(3000));
            assert_eq!(found.len(), 1001, "{line}");
            let last = found.last().unwrap();
            assert!(last.message.contains("the rest was not checked"), "{}", last.message);
            assert_eq!(last.span().range().start, head.len() + 1000 * line.len());
        }
    }

    #[test]
    fn many_clauses_are_not_deep() {
        for clause in ["if p.w > 1 { set p.w = 2 }", "set p.w = 1 + (count over x in part where not x.is_in)"]
        {
            let text = format!("rule r {{\nmatch p : b\n{}}}\n", format!("{clause}\n").repeat(900));
            assert!(errors(&text).is_empty(), "{clause}");
        }
        for word in ["if a then 1 else", "not"] {
            let found = errors(&format!("let a = {} 1\n", format!("{word} ").repeat(193)));
            assert_eq!(found.first().unwrap().code.id, "E0106", "{word}");
        }
    }

    #[test]
    fn a_text_of_millions_of_tokens_is_not_read() {
        let found = errors(&"x\n".repeat(MOST_TOKENS / 2 + 1));
        assert_eq!(found.len(), 1);
        assert_eq!(found.first().unwrap().code.id, "E0101");
    }
}
