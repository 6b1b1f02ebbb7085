//! Reports syntax errors one declaration, and one clause, at a time.

use std::rc::Rc;

use pest::Parser;
use pest::iterators::Pair;

use super::ast::{Item, ItemKind};
use super::braces::{brace, doubled_brace, is_all_within, matching_close, opening, span, two_braces};
use super::declarations::{Clauses, ITEM_WORDS, kind};
use super::explain::explain;
use super::lower::Lowering;
use super::parser::{Found, Rule, SgrParser};
use super::tokens::{Scan, Stretch, Token, TokenKind, deeper};
use crate::diagnostics::{Code, Diagnostic, Fix, did_you_mean, nearest, respell};
use crate::source::{FileId, Span};

const RULE_CLAUSES: &[&str] = &[
    "match", "choose", "let", "when", "unless", "attach", "set", "remove", "replace", "revert", "fill",
    "paint", "clear", "for", "if", "then", "always", "weight", "allow",
];
/// The clauses that a line `for i in RANGE` may follow.
const REPEATABLE: &[&str] = &["attach", "set", "fill", "paint", "clear"];
const TASK_CLAUSES: &[&str] = &["actuate", "simulate", "maximize", "minimize", "allow"];
const EXAMPLE_CLAUSES: &[&str] = &["step", "refuse", "expect", "allow"];
const EDITS: &[&str] = &["set", "narrow", "drop", "replace", "add", "allow"];
const NOVELTY_CLAUSES: &[&str] = &["feature", "known", "allow"];
const ACTUATION_CLAUSES: &[&str] = &["shared", "vary", "state", "action", "let", "drive", "allow"];

/// Reports a run of junk, declaration by declaration.
pub(super) fn junk(scan: &Scan<'_>, junk: Stretch<'_>, file: FileId, found: &mut Found) {
    // Outside braces, a line that starts with a word of its own starts something new.
    let mut starts = vec![junk.start];
    let mut depth = 0;
    for line in junk.lines() {
        let word = line.first_word();
        let clause = [RULE_CLAUSES, ACTUATION_CLAUSES, EXAMPLE_CLAUSES, NOVELTY_CLAUSES, EDITS]
            .iter()
            .any(|c| c.contains(&word))
            && !ITEM_WORDS.contains(&word);
        let begins_line = line.before_on_line().is_empty();
        if line.start > junk.start && begins_line && depth == 0 && !word.is_empty() && !clause {
            starts.push(line.start);
        }
        depth = line.tokens().fold(depth, |depth, token| (depth + brace(token)).max(0));
    }
    let ends = starts.iter().skip(1).copied().chain([junk.end]).collect::<Vec<_>>();
    for (start, end) in starts.into_iter().zip(ends) {
        if found.gives_up(Span::new(file, start, end)) {
            return;
        }
        chunk(scan, junk.part(start, end), file, found);
    }
}

/// Reports one broken declaration and saves what can be saved of it.
fn chunk(scan: &Scan<'_>, piece: Stretch<'_>, file: FileId, found: &mut Found) {
    let first = piece.first_word();
    if !ITEM_WORDS.contains(&first) {
        no_declaration(piece, first, file, found);
        return;
    }
    let header = piece.part(piece.start + first.len(), piece.end);
    let name = header.first().filter(|token| token.kind == TokenKind::Word);
    found.module.broken.push(name.map_or("", |name| name.text).to_owned());
    found.module.unread.push(first.to_owned());
    if first == "use" {
        found.module.broken.extend(header.words().map(str::to_owned));
    }
    match by_clause(scan, piece, file, found) {
        Some(item) => found.module.items.push(Rc::new(item)),
        None => found.errors.push(explain(piece, Rule::only_item, file)),
    }
}

/// Reports a piece that begins with no word that opens a declaration.
fn no_declaration(piece: Stretch<'_>, first: &str, file: FileId, found: &mut Found) {
    let words = || ITEM_WORDS.iter().copied();
    let shown = if first.is_empty() {
        piece.text().chars().next().map_or(String::new(), String::from)
    } else {
        first.to_owned()
    };
    let span = Span::new(file, piece.start, piece.start + shown.len());
    let mut error = if first.is_empty() || !piece.before_on_line().trim().is_empty() {
        Diagnostic::new(Code::SYNTAX, span, format!("unexpected `{shown}`"))
            .label("no declaration starts here")
            .help("a declaration ends before this; the next one starts on a new line with a word such as `rule`")
    } else {
        Diagnostic::new(Code::UNKNOWN_KEYWORD, span, format!("`{first}` does not start a declaration"))
            .label("unknown word")
            .help(
                did_you_mean(first, words()).unwrap_or_else(|| {
                    format!("a declaration starts with one of: {}", ITEM_WORDS.join(", "))
                }),
            )
            .fix_if(respell(span, first, words()))
    };
    // A brace that closes more than this opens ends a declaration that began before.
    if piece.tokens().map(brace).sum::<i32>() < 0 {
        found.module.headless = true;
        if error.fix.is_none() {
            error.help = Some(
                "a `}` closes a block here, but its first line is missing, such as `rule NAME {`".to_owned(),
            );
        }
    }
    found.errors.push(error);
    // What it was meant to declare is known all the same.
    let broken = &mut found.module.broken;
    match nearest(first, words()).or_else(|| elsewhere(first)) {
        Some("use") => broken.extend(piece.words().map(str::to_owned)),
        Some(_) => broken.extend(piece.tokens().nth(1).map(|token| token.text.to_owned())),
        None => {}
    }
}

/// The word that declares what a word of another language does.
fn elsewhere(word: &str) -> Option<&'static str> {
    Some(match word {
        "import" | "include" | "from" => "use",
        "def" | "fn" | "func" | "function" | "const" | "var" => "let",
        "module" | "class" => "part",
        _ => return None,
    })
}

/// The clauses of a block: the words that begin them, none where any name may, and the grammar's
/// entry for one of them.
fn clauses_of(word: &str) -> Option<(&'static [&'static str], Rule)> {
    Some(match kind(word)?.clauses {
        Clauses::Rule => (RULE_CLAUSES, Rule::only_rule),
        Clauses::Actuation => (ACTUATION_CLAUSES, Rule::only_actuation),
        Clauses::Begin => (&["place", "allow"], Rule::only_begin),
        Clauses::Task => (TASK_CLAUSES, Rule::only_task),
        Clauses::Example => (EXAMPLE_CLAUSES, Rule::only_example),
        Clauses::Edits => (EDITS, Rule::only_edit),
        Clauses::Novelty => (NOVELTY_CLAUSES, Rule::only_novelty),
        Clauses::Fields => (&[], Rule::only_field),
        Clauses::None => return None,
    })
}

/// Reads an item with a block clause by clause; `None` if the header is what is wrong.
fn by_clause(scan: &Scan<'_>, piece: Stretch<'_>, file: FileId, found: &mut Found) -> Option<Item> {
    let open = opening(piece)?;
    let first = piece.first_word();
    let (words, entry) = clauses_of(first)?;
    let block = piece.part(open.start, piece.end);
    if let Some(second) = doubled_brace(block) {
        let (error, clean) = two_braces(scan, piece, second, file);
        found.errors.push(error);
        let clean = Scan::new(&clean);
        let piece = clean.stretch(piece.start, piece.end);
        return whole(piece, file, &mut found.errors).or_else(|| by_clause(&clean, piece, file, found));
    }
    // The header must stand on its own: it does if it does with an empty block.
    let header = format!("{}{{}}", piece.part(piece.start, open.start).text());
    let pair = SgrParser::parse(Rule::only_item, &header).ok()?.next()?;
    let mut lowering = Lowering::new(&header, file, piece.start);
    let mut item = lowering.item(pair.into_inner().next()?)?;
    found.errors.extend(lowering.finish());
    item.damaged = true;
    let before = found.errors.len();
    let close = matching_close(block);
    if close.is_none() {
        found.errors.push(unclosed(piece, open, file));
    }
    let inside = block.part(open.end(), close.map_or(piece.end, |close| close.start));
    let all = clauses(inside, words);
    // A brace that a clause leaves open, as that of a set, is the one that is missing, and told there.
    let is_open =
        |clause: &Stretch<'_>| clause.end != inside.end && clause.tokens().map(brace).sum::<i32>() > 0;
    if close.is_none()
        && all.iter().any(|clause| is_open(clause) && SgrParser::parse(entry, clause.text()).is_err())
    {
        found.errors.truncate(before);
    }
    for clause in all {
        match SgrParser::parse(entry, clause.text()) {
            Ok(mut pairs) => {
                let Some(inner) =
                    pairs.next().and_then(|p| p.into_inner().find(|p| p.as_rule() != Rule::COMMENT))
                else {
                    continue;
                };
                let mut lowering = Lowering::new(clause.text(), file, clause.start);
                fill(&mut item, &mut lowering, inner);
                found.errors.extend(lowering.finish());
            }
            // It only lacks the brace that has been reported.
            Err(_) if close.is_none() && clause.end == inside.end => {}
            Err(_) if found.gives_up(Span::new(file, clause.start, clause.end)) => break,
            Err(_) => {
                // What it declares is known by its name even where the rest cannot be read.
                found.module.broken.extend(declared_in(clause, words).into_iter().map(str::to_owned));
                found.errors.push(clause_error(clause, entry, words, first, file));
            }
        }
    }
    if let Some(close) = close {
        let is_all = found.errors.len() == before;
        found.errors.extend(after_close(piece.part(close.end(), piece.end), first, is_all, file));
    }
    if found.errors.len() == before {
        // Each piece reads well, yet the whole does not: let the parser say why.
        found.errors.push(explain(piece, Rule::only_item, file));
    }
    Some(item)
}

/// Says that a block is not closed.
fn unclosed(piece: Stretch<'_>, open: &Token<'_>, file: FileId) -> Diagnostic {
    // Comments below the last line belong to what follows.
    let end = Span::new(file, piece.line_end(), piece.line_end());
    let help = "add a `}` on a line of its own";
    let is_certain = is_all_within(piece.part(open.start, piece.end));
    let message = format!("`{}` is not closed: a `}}` is missing", piece.first_word());
    Diagnostic::new(Code::UNCLOSED, end, message)
        .label("expected `}` here")
        .also(span(open, file), "this `{` is open")
        .help(help)
        .fix_if(is_certain.then(|| Fix::replace(end, "\n}", help)))
}

/// Says what stands after the end of a block; `is_all` if nothing else is wrong with it.
fn after_close(rest: Stretch<'_>, block: &str, is_all: bool, file: FileId) -> Option<Diagnostic> {
    let extra = rest.first()?;
    // Where something else is wrong, a `{` may be missing before it.
    let is_brace_too_many = is_all && extra.text == "}" && rest.tokens().nth(1).is_none();
    let error = Diagnostic::new(Code::SYNTAX, span(extra, file), "unexpected text after the closing `}`")
        .label(format!("`{block}` ended before this"))
        .help("is there a `}` too many?");
    Some(
        error.fix_if(is_brace_too_many.then(|| Fix::replace(span(extra, file), "", "remove a `}` too many"))),
    )
}

/// The name that a clause declares for others: `port site ...`, `add rule grow ...`.
fn declared_in<'t>(clause: Stretch<'t>, words: &[&str]) -> Vec<&'t str> {
    // A bracket that is left open takes the lines that follow with it.
    clause.lines().filter_map(|line| declared_by(line, words)).collect()
}

/// The same of a line.
fn declared_by<'t>(line: Stretch<'t>, words: &[&str]) -> Option<&'t str> {
    let mut all = line.tokens();
    let declared = match (all.next()?.text, words) {
        (first, []) if nearest(first, ["port", "param"]).is_some() => all.next(),
        ("add" | "replace", EDITS) => all.nth(1),
        (first, EDITS) if ITEM_WORDS.contains(&first) => all.next(),
        _ => None,
    };
    declared.map(|token| token.text)
}

/// Reads an item that is sound after all.
fn whole(piece: Stretch<'_>, file: FileId, errors: &mut Vec<Diagnostic>) -> Option<Item> {
    let pair = SgrParser::parse(Rule::only_item, piece.text()).ok()?.next()?;
    let mut lowering = Lowering::new(piece.text(), file, piece.start);
    let item = lowering.item(pair.into_inner().next()?);
    errors.extend(lowering.finish());
    item
}

/// Adds a clause that could be read to its declaration.
fn fill<'a>(item: &mut Item, lowering: &mut Lowering<'a>, clause: Pair<'a, Rule>) {
    match &mut item.kind {
        ItemKind::Rule(_, clauses) => clauses.extend(lowering.rule_clause(clause)),
        ItemKind::Actuation { clauses, .. } => clauses.extend(lowering.actuation_clause(clause)),
        ItemKind::Begin(places, fills) => match clause.as_rule() {
            Rule::place_clause => places.extend(lowering.place(clause)),
            Rule::allow_item => {}
            _ => fills.extend(lowering.cells(clause)),
        },
        ItemKind::Task(_, items) => items.extend(lowering.item(clause)),
        ItemKind::Example(_, clauses) => clauses.extend(lowering.example_clause(clause)),
        ItemKind::Novelty(_, clauses) => clauses.extend(lowering.novelty_clause(clause)),
        ItemKind::Variant(variant) => variant.edits.extend(lowering.edit(clause)),
        other => {
            if let Some(block) = other.block_mut() {
                block.fields.extend(lowering.field(clause));
            }
        }
    }
}

/// Says what is wrong with a clause, first of all with its first word.
fn clause_error(clause: Stretch<'_>, entry: Rule, words: &[&str], block: &str, file: FileId) -> Diagnostic {
    let first = clause.first_word();
    if !words.is_empty() && !words.contains(&first) && !first.is_empty() {
        return no_clause(first, clause.start, words, block, file);
    }
    if let Some(error) = error_in_block(clause, entry, words, file) {
        return error;
    }
    let error = explain(clause, entry, file);
    // A clause that could end stopped at a line of its own: that line is what cannot be read.
    let stop = clause.part(error.span().start as usize, clause.end);
    let word = stop.first_word();
    if stop.start <= clause.start || !error.message.contains("the end of the clause") {
        return error;
    }
    let is_on_own_line = stop.before_on_line().trim().is_empty();
    if is_on_own_line && !words.is_empty() && !word.is_empty() && !words.contains(&word) {
        return no_clause(word, stop.start, words, block, file);
    }
    // Several clauses stand on this line, and it is a later one that cannot be read.
    let is_field =
        || matches!(word, "param" | "port" | "allow") || stop.tokens().nth(1).is_some_and(|t| t.text == "=");
    // A condition without a block is a slip of another kind.
    let is_clause = || words.contains(&word) && (word != "if" || opening(stop).is_some());
    let begins = if words.is_empty() { is_field() } else { is_clause() };
    if begins && SgrParser::parse(entry, stop.text()).is_err() {
        return clause_error(stop, entry, words, block, file);
    }
    error
}

/// Says what is wrong with the first clause that cannot be read of a block that is repeated.
fn error_in_block(clause: Stretch<'_>, entry: Rule, words: &[&str], file: FileId) -> Option<Diagnostic> {
    if !matches!(clause.first_word(), "for" | "if") || !words.contains(&"for") {
        return None;
    }
    let open = opening(clause)?;
    let close = matching_close(clause.part(open.start, clause.end))?;
    // What is repeated must be readable itself.
    let header = format!("{}{{}}", clause.part(clause.start, open.start).text());
    SgrParser::parse(entry, &header).ok()?;
    let all = clauses(clause.part(open.end(), close.start), words);
    let wrong = all.into_iter().find(|inner| SgrParser::parse(entry, inner.text()).is_err())?;
    Some(clause_error(wrong, entry, words, "rule", file))
}

/// Says that a word opens no clause of a block.
fn no_clause(word: &str, start: usize, words: &[&str], block: &str, file: FileId) -> Diagnostic {
    let span = Span::new(file, start, start + word.len());
    Diagnostic::new(Code::UNKNOWN_KEYWORD, span, format!("`{word}` does not start a clause of `{block}`"))
        .label("unknown word")
        .help(
            did_you_mean(word, words.iter().copied())
                .or_else(|| {
                    ITEM_WORDS
                        .contains(&word)
                        .then(|| format!("`{word}` is a declaration: write it outside `{block} {{ ... }}`"))
                })
                .unwrap_or_else(|| format!("a clause of `{block}` starts with one of: {}", words.join(", "))),
        )
        .fix_if(respell(span, word, words.iter().copied()))
}

/// Splits the inside of a block at the lines that start a clause: with one of
/// `words`, or, without words, with `name =`, `name {`, `name method {`, `param` or `port`.
fn clauses<'a>(inside: Stretch<'a>, words: &[&str]) -> Vec<Stretch<'a>> {
    let mut starts: Vec<usize> = Vec::new();
    let mut depth = 0;
    // The end of a block that is repeated: its clauses belong to it.
    let mut block_end = inside.start;
    for line in inside.lines().filter(|line| line.first().is_some()) {
        if line.start < block_end {
            continue;
        }
        let word = line.first_word();
        // An expression may go on with `if` on a line of its own.
        let is_condition = || {
            let opens = line.tokens().any(|token| token.text == "{");
            word == "if" && opens && !line.tokens().any(|token| token.text == "then")
        };
        if words.contains(&word) && (word == "for" || is_condition()) {
            let open = line.tokens().find(|token| token.text == "{");
            let close = open.and_then(|open| matching_close(inside.part(open.start, inside.end)));
            let before = starts.last().map_or("", |start| inside.part(*start, line.start).first_word());
            if open.is_some() || !REPEATABLE.contains(&before) {
                starts.push(line.start);
            }
            block_end = close.map_or(block_end, Token::end);
            continue;
        }
        let opens = if words.is_empty() {
            depth == 0 && opens_field(line, !starts.is_empty())
        } else {
            // Continuation lines start with an operator or a word such as `because`.
            let goes_on = word == "then" && line.tokens().nth(1).is_some();
            let begins = words.contains(&word) && word != "if"
                || depth == 0 && nearest(word, words.iter().copied()).is_some();
            begins && !goes_on
        };
        if opens || starts.is_empty() {
            starts.push(line.start);
        }
        let change = |depth: i32, token| (depth + deeper(token, &["{", "(", "["], &["}", ")", "]"])).max(0);
        depth = line.tokens().fold(depth, change);
    }
    let ends = starts.iter().skip(1).copied().chain([inside.end]).collect::<Vec<_>>();
    starts.into_iter().zip(ends).map(|(start, end)| inside.part(start, end)).collect()
}

/// Whether a line begins a field; one after others may be a name alone, with its value left out.
fn opens_field(line: Stretch<'_>, is_after_others: bool) -> bool {
    let word = line.first_word();
    let mut rest = line.tokens().skip(usize::from(!word.is_empty()));
    let (next, after) = (rest.next(), rest.next());
    let is = |token: Option<&Token<'_>>, signs: &[&str]| token.is_some_and(|t| signs.contains(&t.text));
    // A `=` was left out.
    let is_value = next.is_some_and(|t| t.kind == TokenKind::Number);
    let names_a_method = next.is_some_and(|t| t.kind == TokenKind::Word) && is(after, &["{"]);
    matches!(word, "param" | "port" | "allow")
        || is(next, &["=", "==", "{", ":"])
        || is_value
        || names_a_method
        || is_after_others && !word.is_empty() && next.is_none()
}
