//! Says what is wrong with text that is no item, piece by piece.

use pest::Parser;
use pest::error::{ErrorVariant, InputLocation};
use pest::iterators::Pair;

use super::ast::{Item, ItemKind, Module};
use super::braces::{
    bare, doubled_brace, find_bare, is_all_within, last_line_end, matching_close, two_braces,
};
use super::declarations::{Clauses, ITEM_WORDS, kind};
use super::forms::form;
use super::lower::Lowering;
use super::parse::{Rule, SgrParser};
use super::slip::Stop;
use crate::diagnostics::{Code, Diagnostic, Fix, did_you_mean, nearest, respell};
use crate::source::{FileId, Span};

const RULE_CLAUSES: &[&str] = &[
    "match", "choose", "let", "when", "unless", "attach", "set", "remove", "replace", "revert", "fill",
    "paint", "clear", "weight",
];
const TASK_CLAUSES: &[&str] = &["actuate", "simulate", "maximize", "minimize"];
const EXAMPLE_CLAUSES: &[&str] = &["step", "refuse", "expect"];
const EDITS: &[&str] = &["set", "narrow", "drop", "replace", "add"];
const NOVELTY_CLAUSES: &[&str] = &["feature", "known"];
const ACTUATION_CLAUSES: &[&str] = &["shared", "vary", "let", "drive"];
/// What may follow a piece that is complete.
const END: &str = "the end of the declaration";

/// Reports a run of junk, declaration by declaration.
pub(super) fn junk(
    text: &str,
    start: usize,
    end: usize,
    file: FileId,
    module: &mut Module,
    errors: &mut Vec<Diagnostic>,
) {
    let piece = text.get(start..end).unwrap_or("");
    // Outside braces, a line that starts with a word of its own starts something new.
    let mut starts = vec![0];
    let mut depth = 0usize;
    let mut at = 0;
    for line in piece.split_inclusive('\n') {
        let word = word_at(line);
        let clause = [RULE_CLAUSES, ACTUATION_CLAUSES, EXAMPLE_CLAUSES, NOVELTY_CLAUSES, EDITS]
            .iter()
            .any(|c| c.contains(&word))
            && !ITEM_WORDS.contains(&word);
        if at > 0 && depth == 0 && !word.is_empty() && !clause {
            starts.push(at);
        }
        for (_, c) in bare(line) {
            match c {
                '{' => depth += 1,
                '}' => depth = depth.saturating_sub(1),
                _ => {}
            }
        }
        at += line.len();
    }
    let ends = starts.iter().skip(1).copied().chain([piece.len()]).collect::<Vec<_>>();
    for (from, to) in starts.into_iter().zip(ends) {
        chunk(text, start + from, start + to, file, module, errors);
    }
}

/// Reports one broken declaration and saves what can be saved of it.
fn chunk(
    text: &str,
    start: usize,
    end: usize,
    file: FileId,
    module: &mut Module,
    errors: &mut Vec<Diagnostic>,
) {
    let piece = text.get(start..end).unwrap_or("");
    let first = word_at(piece);
    let at = |from: usize, to: usize| Span::new(file, from, to);
    if !ITEM_WORDS.contains(&first) {
        let line_start = text.get(..start).unwrap_or("").rsplit('\n').next().unwrap_or("");
        let shown = if first.is_empty() {
            piece.chars().next().map_or(String::new(), String::from)
        } else {
            first.into()
        };
        let span = at(start, start + shown.len());
        if first.is_empty() || !line_start.trim().is_empty() {
            errors.push(
                Diagnostic::new(Code::SYNTAX, span, format!("unexpected `{shown}`"))
                    .label("no declaration starts here")
                    .help("a declaration ends before this; the next one starts on a new line with a word such as `rule`"),
            );
        } else {
            errors.push(
                Diagnostic::new(
                    Code::UNKNOWN_KEYWORD,
                    span,
                    format!("`{first}` does not start a declaration"),
                )
                .label("unknown word")
                .help(did_you_mean(first, ITEM_WORDS.iter().copied()).unwrap_or_else(|| {
                    format!("a declaration starts with one of: {}", ITEM_WORDS.join(", "))
                }))
                .fix_if(respell(span, first, ITEM_WORDS.iter().copied())),
            );
        }
        // A brace that closes more than this opens ends a declaration that began before.
        if is_body(piece) {
            module.headless = true;
            if let Some(error) = errors.last_mut().filter(|e| e.fix.is_none()) {
                let help = "a `}` ends this: its first line is missing, such as `rule NAME {`";
                error.help = Some(help.to_owned());
            }
        }
        // What it was meant to declare is known all the same.
        match nearest(first, ITEM_WORDS.iter().copied()) {
            Some("use") => module.broken.extend(words_of(piece).map(str::to_owned)),
            Some(_) => module.broken.extend(piece.split_whitespace().nth(1).map(str::to_owned)),
            None => {}
        }
        return;
    }
    let header = piece.get(first.len()..).unwrap_or("").trim_start();
    module.broken.push(word_at(header).to_owned());
    if first == "use" {
        module.broken.extend(words_of(header).map(str::to_owned));
    }
    if let Some(item) = by_clause(text, start, end, file, first, errors, &mut module.broken) {
        module.items.push(item);
        return;
    }
    errors.push(explain(text, start, end, Rule::only_item, file));
}

/// The words of a piece: what a broken import may have named.
fn words_of(piece: &str) -> impl Iterator<Item = &str> {
    piece.split(|c: char| !(c.is_alphanumeric() || c == '_')).filter(|word| !word.is_empty())
}

/// Whether a piece ends with a brace that it does not open.
fn is_body(piece: &str) -> bool {
    bare(piece).map(|(_, c)| i32::from(c == '{') - i32::from(c == '}')).sum::<i32>() < 0
}

/// Reads an item with a block clause by clause; `None` if the header is what is wrong. `lost` gets
/// the names of what could not be read.
fn by_clause(
    text: &str,
    start: usize,
    end: usize,
    file: FileId,
    first: &str,
    errors: &mut Vec<Diagnostic>,
    lost: &mut Vec<String>,
) -> Option<Item> {
    let piece = text.get(start..end)?;
    let open = find_bare(piece, '{')?;
    let (words, entry): (&[&str], Rule) = match kind(first)?.clauses {
        Clauses::Rule => (RULE_CLAUSES, Rule::only_rule),
        Clauses::Actuation => (ACTUATION_CLAUSES, Rule::only_actuation),
        Clauses::Begin => (&["place"], Rule::only_begin),
        Clauses::Task => (TASK_CLAUSES, Rule::only_task),
        Clauses::Example => (EXAMPLE_CLAUSES, Rule::only_example),
        Clauses::Edits => (EDITS, Rule::only_edit),
        Clauses::Novelty => (NOVELTY_CLAUSES, Rule::only_novelty),
        Clauses::Fields => (&[], Rule::only_field),
        Clauses::None => return None,
    };
    if let Some(second) = doubled_brace(piece, open) {
        let (error, clean) = two_braces(text, start, end, second, file);
        errors.push(error);
        return whole(&clean, start, end, file, errors)
            .or_else(|| by_clause(&clean, start, end, file, first, errors, lost));
    }
    // The header must stand on its own: it does if it does with an empty block.
    let header = format!("{}{{}}", piece.get(..open)?);
    let pair = SgrParser::parse(Rule::only_item, &header).ok()?.next()?;
    let mut lowering = Lowering::new(&header, file, start);
    let mut item = lowering.item(pair.into_inner().next()?)?;
    errors.extend(lowering.finish());
    item.damaged = true;
    let found = errors.len();

    let close = matching_close(piece, open);
    let body_end = close.unwrap_or(piece.len());
    if close.is_none() {
        let last = last_line_end(piece);
        let end = Span::new(file, start + last, start + last);
        errors.push(
            Diagnostic::new(Code::UNCLOSED, end, format!("`{first}` is not closed: a `}}` is missing"))
                .label("expected `}` here")
                .also(Span::new(file, start + open, start + open + 1), "this `{` is open")
                .help("add a `}` on a line of its own")
                .fix_if(
                    is_all_within(piece, open)
                        .then(|| Fix::replace(end, "\n}", "add a `}` on a line of its own")),
                ),
        );
    }
    for (from, to) in clauses(piece, open + 1, body_end, words) {
        let clause = piece.get(from..to).unwrap_or("");
        match SgrParser::parse(entry, clause) {
            Ok(mut pairs) => {
                let Some(inner) =
                    pairs.next().and_then(|p| p.into_inner().find(|p| p.as_rule() != Rule::COMMENT))
                else {
                    continue;
                };
                let mut lowering = Lowering::new(clause, file, start + from);
                fill(&mut item, &mut lowering, inner);
                errors.extend(lowering.finish());
            }
            // It only lacks the brace that has been reported.
            Err(_) if close.is_none() && to == body_end => {}
            Err(_) => {
                // What it declares is known by its name even where the rest cannot be read.
                lost.extend(declared_in(clause, words).map(str::to_owned));
                errors.push(clause_error(text, start + from, start + to, entry, words, first, file));
            }
        }
    }
    if let Some(close) = close {
        let rest = piece.get(close + 1..).unwrap_or("");
        let lead = rest.len() - rest.trim_start().len();
        let extra = rest.trim();
        if !extra.is_empty() && !extra.starts_with('#') {
            let from = start + close + 1 + lead;
            let length = extra.chars().next().map_or(1, char::len_utf8).max(word_at(extra).len());
            errors.push(
                Diagnostic::new(
                    Code::SYNTAX,
                    Span::new(file, from, from + length),
                    "unexpected text after the closing `}`",
                )
                .label(format!("`{first}` ended before this"))
                .help("is there a `}` too many?")
                .fix_if(
                    // Where something else is wrong, a `{` may be missing before it.
                    (extra == "}" && errors.len() == found)
                        .then(|| Fix::replace(Span::new(file, from, from + 1), "", "remove a `}` too many")),
                ),
            );
        }
    }
    if errors.len() == found {
        // Each piece reads well, yet the whole does not: let the parser say why.
        errors.push(explain(text, start, end, Rule::only_item, file));
    }
    Some(item)
}

/// The name that a clause declares for others: `port site ...`, `add rule grow ...`.
fn declared_in<'t>(clause: &'t str, words: &[&str]) -> Option<&'t str> {
    let mut all = clause.split_whitespace();
    match (all.next()?, words) {
        (first, []) if nearest(first, ["port", "param"]).is_some() => all.next(),
        ("add" | "replace", EDITS) => all.nth(1),
        (first, EDITS) if ITEM_WORDS.contains(&first) => all.next(),
        _ => None,
    }
    .map(word_at)
}

/// Reads an item that is sound after all.
fn whole(text: &str, start: usize, end: usize, file: FileId, errors: &mut Vec<Diagnostic>) -> Option<Item> {
    let piece = text.get(start..end)?;
    let pair = SgrParser::parse(Rule::only_item, piece).ok()?.next()?;
    let mut lowering = Lowering::new(piece, file, start);
    let item = lowering.item(pair.into_inner().next()?);
    errors.extend(lowering.finish());
    item
}

/// Adds a clause that could be read to its declaration.
fn fill<'a>(item: &mut Item, lowering: &mut Lowering<'a>, clause: Pair<'a, Rule>) {
    match &mut item.kind {
        ItemKind::Rule(_, clauses) => clauses.extend(lowering.rule_clause(clause)),
        ItemKind::Actuation { clauses, .. } => clauses.extend(lowering.actuation_clause(clause)),
        ItemKind::Begin(places, fills) => {
            if clause.as_rule() == Rule::place_clause {
                places.extend(lowering.place(clause));
            } else {
                fills.extend(lowering.cells(clause));
            }
        }
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
fn clause_error(
    text: &str,
    start: usize,
    end: usize,
    entry: Rule,
    words: &[&str],
    block: &str,
    file: FileId,
) -> Diagnostic {
    let piece = text.get(start..end).unwrap_or("");
    let first = word_at(piece);
    if !words.is_empty() && !words.contains(&first) && !first.is_empty() {
        return no_clause(first, start, words, block, file);
    }
    let error = explain(text, start, end, entry, file);
    // A clause that could end stopped at a line of its own: that line is what cannot be read.
    let stop = error.span().start as usize;
    let line = text.get(..stop).unwrap_or("").rsplit('\n').next().unwrap_or("");
    let word = word_at(text.get(stop..end).unwrap_or(""));
    let ended = error.message.contains("the end of the clause") && line.trim().is_empty();
    if ended && stop > start && !words.is_empty() && !word.is_empty() && !words.contains(&word) {
        return no_clause(word, stop, words, block, file);
    }
    error
}

/// Says that a word opens no clause of a block.
fn no_clause(word: &str, start: usize, words: &[&str], block: &str, file: FileId) -> Diagnostic {
    let span = Span::new(file, start, start + word.len());
    Diagnostic::new(Code::UNKNOWN_KEYWORD, span, format!("`{word}` does not start a clause of `{block}`"))
        .label("unknown word")
        .help(
            did_you_mean(word, words.iter().copied())
                .unwrap_or_else(|| format!("a clause of `{block}` starts with one of: {}", words.join(", "))),
        )
        .fix_if(respell(span, word, words.iter().copied()))
}

/// Turns the parser's own error into words.
fn explain(text: &str, start: usize, end: usize, entry: Rule, file: FileId) -> Diagnostic {
    let piece = text.get(start..end).unwrap_or("");
    let error = match SgrParser::parse(entry, piece) {
        Err(error) => error,
        Ok(_) => return Diagnostic::new(Code::SYNTAX, Span::new(file, start, end), "this cannot be read"),
    };
    let (InputLocation::Pos(mut place) | InputLocation::Span((mut place, _))) = error.location;
    // pest stops before white space and comments; people look at the word after them.
    loop {
        let rest = piece.get(place..).unwrap_or("");
        let skipped = rest.len() - rest.trim_start().len();
        place += skipped;
        match piece.get(place..).filter(|r| r.starts_with('#')) {
            Some(rest) => place += rest.find('\n').unwrap_or(rest.len()),
            None => break,
        }
    }
    let rest = piece.get(place..).unwrap_or("");
    let found = token_at(rest);
    let mut expected: Vec<&str> = Vec::new();
    if let ErrorVariant::ParsingError { positives, .. } = &error.variant {
        for words in all_expected(positives).into_iter().filter_map(describe) {
            if !expected.contains(&words) {
                expected.push(words);
            }
        }
    }
    // Operators can follow almost everything: they hide what is really missing.
    let in_expression = expected.contains(&"an operator");
    if expected.len() > 1 {
        expected.retain(|e| *e != "an operator");
    }
    // So do the other ways to go on after a value, where something else must follow.
    let on = ["an operator", "`[`", "`(`", "`in`", "`..`"];
    if in_expression && expected.iter().any(|e| !on.contains(e)) {
        expected.retain(|e| !on.contains(e));
    }
    // Where a declaration may end, what else could go on is beside the point.
    if expected.contains(&END) {
        expected.retain(|e| !["`[`", "`(`", "`in`", "`..`", "a value"].contains(e));
    }
    // Where a bracket is open, it is more likely to be closed than to be followed by another.
    if expected.iter().any(|e| ["`)`", "`]`"].contains(e)) {
        expected.retain(|e| !["`[`", "`(`", "`in`", "`..`"].contains(e));
    }
    let wanted = match expected.as_slice() {
        [] => "something else".to_owned(),
        [one] => (*one).to_owned(),
        [head @ .., last] => {
            let head = head.iter().take(6).copied().collect::<Vec<_>>().join(", ");
            format!("{head} or {last}")
        }
    };
    let piece_name = if entry == Rule::only_item { "the declaration" } else { "the clause" };
    let wanted = wanted.replace(END, &format!("the end of {piece_name}"));
    let (span, message) = if found.is_empty() {
        let last = start + piece.trim_end().len();
        (Span::new(file, last, last), format!("expected {wanted}, but {piece_name} ends here"))
    } else {
        (
            Span::new(file, start + place, start + place + found.len()),
            format!("expected {wanted}, found `{found}`"),
        )
    };
    let reserved = SgrParser::parse(Rule::keyword, found)
        .is_ok_and(|mut p| p.next().is_some_and(|p| p.as_str() == found));
    let help = if wanted.contains("a name") && matches!(found, "part" | "actuator" | "cell") {
        Some(format!("give it a name first, as in `p : {found}`"))
    } else if wanted.contains("a name") && reserved {
        Some(format!("`{found}` is a word of the language: choose another name"))
    } else {
        None
    };
    let like = help.is_none().then(|| looks_like(entry, piece, place, &expected)).flatten();
    if in_expression && !expected.contains(&"an operator") {
        expected.push("an operator");
    }
    let error = Diagnostic::new(Code::SYNTAX, span, message)
        .label(if found.is_empty() { "something is missing here" } else { "not expected here" })
        .help_if(help);
    let error = Stop { piece, start, place, found, expected: &expected, file }.explain(error);
    if error.help.is_some() { error } else { error.help_if(like) }
}

/// What the whole declaration or clause looks like, where that helps: not in the middle of a value.
fn looks_like(entry: Rule, piece: &str, place: usize, expected: &[&str]) -> Option<String> {
    let before = piece.get(..place).unwrap_or("").trim_end();
    let after_word = before.ends_with(|c: char| c.is_alphanumeric() || c == '_');
    let inside = expected.iter().any(|e| ["`)`", "`]`", "`then`", "`else`"].contains(e));
    if inside || expected == ["a value"] && !after_word {
        return None;
    }
    let first = word_at(piece);
    // What stands on a line of its own, as in an example of a variant, is nearer.
    let line = before.rsplit('\n').next().map_or("", |line| word_at(line.trim_start()));
    if let Some(form) = form(entry, line).or_else(|| form(entry, first)) {
        return Some(format!("write for example `{form}`"));
    }
    let field = entry == Rule::only_field && expected.contains(&"`=`");
    field.then(|| format!("write `{first} = VALUE`"))
}

/// What the parser expected, with the brackets that it looked ahead for: where an operator can
/// follow, they can, too.
fn all_expected(positives: &[Rule]) -> Vec<Rule> {
    let mut all = positives.to_vec();
    if positives.contains(&Rule::product_op) {
        all.extend([Rule::bracket_open, Rule::paren_open]);
        all.sort();
        all.dedup();
    }
    all
}

/// The words that people use for what the grammar expects.
fn describe(rule: Rule) -> Option<&'static str> {
    Some(match rule {
        Rule::name | Rule::word | Rule::ident => "a name",
        Rule::kind_name | Rule::kind_word => "a kind of part",
        Rule::type_name => "a type",
        Rule::expr
        | Rule::range
        | Rule::primary
        | Rule::sum
        | Rule::postfix
        | Rule::number
        | Rule::quantity
        | Rule::set
        | Rule::list
        | Rule::condition
        | Rule::cases
        | Rule::kw_match
        | Rule::minus
        | Rule::aggregate
        | Rule::aggregate_word
        | Rule::quantifier
        | Rule::boolean
        | Rule::kw_not
        | Rule::kw_if
        | Rule::kw_forall
        | Rule::kw_exists => "a value",
        Rule::compare_op
        | Rule::sum_op
        | Rule::product_op
        | Rule::member
        | Rule::call
        | Rule::index
        | Rule::dots
        | Rule::kw_and
        | Rule::kw_or
        | Rule::kw_at
        | Rule::dot
        | Rule::kw_is
        | Rule::kw_adds
        | Rule::unit_text => "an operator",
        Rule::text | Rule::quote => "a text in quotes",
        Rule::brace_open => "`{`",
        Rule::brace_close => "`}`",
        Rule::bracket_open => "`[`",
        Rule::bracket_close => "`]`",
        Rule::paren_open => "`(`",
        Rule::paren_close => "`)`",
        Rule::comma => "`,`",
        Rule::colon => "`:`",
        Rule::equals => "`=`",
        Rule::kw_in => "`in`",
        Rule::kw_for => "`for`",
        Rule::kw_on => "`on`",
        Rule::kw_with => "`with`",
        Rule::kw_to | Rule::to_part => "`to`",
        Rule::kw_by => "`by`",
        Rule::kw_of => "`of`",
        Rule::kw_over => "`over`",
        Rule::kw_because => "`because`",
        Rule::kw_then => "`then`",
        Rule::kw_else => "`else`",
        Rule::kw_turned | Rule::turned_part => "`turned`",
        Rule::kw_from => "`from`",
        Rule::kw_facing => "`facing`",
        Rule::kw_about => "`about`",
        Rule::kw_x => "`x`",
        Rule::kw_when => "`when`",
        Rule::side => "a number",
        Rule::kw_weight => "`weight`",
        Rule::arrow => "`->`",
        Rule::path => "what is changed, such as `bender.bend`",
        Rule::link => "a name",
        Rule::item => "a declaration",
        Rule::edit => "`set`, `narrow`, `drop`, `replace` or `add`",
        Rule::task_clause => "`actuate`, `simulate`, `maximize` or `minimize`",
        Rule::example_clause => "`step`, `refuse` or `expect`",
        Rule::kw_where | Rule::where_part => "`where`",
        Rule::kw_port => "`port`",
        Rule::kw_free => "`free`",
        Rule::free_port => "`with free port`",
        Rule::module_path => "a module such as `std.blocks`",
        Rule::mutate_part => "`mutate`",
        Rule::flip_part => "`flip`",
        Rule::field_clause | Rule::field | Rule::group => "`name = value`",
        Rule::rule_clause => "a clause such as `match`",
        Rule::actuation_clause => "a clause such as `vary`",
        Rule::EOI => END,
        _ => return None,
    })
}

fn word_at(text: &str) -> &str {
    let end = text.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(text.len());
    text.get(..end).unwrap_or("")
}

fn token_at(text: &str) -> &str {
    let word = word_at(text);
    if !word.is_empty() {
        return word;
    }
    ["<=", ">=", "==", "!=", ".."]
        .into_iter()
        .find(|t| text.starts_with(t))
        .and_then(|t| text.get(..t.len()))
        .or_else(|| text.chars().next().and_then(|c| text.get(..c.len_utf8())))
        .unwrap_or("")
}

/// Splits the inside of a block at the lines that start a clause: with one of
/// `words`, or, without words, with `name =`, `name {`, `name method {`, `param` or `port`.
fn clauses(text: &str, from: usize, to: usize, words: &[&str]) -> Vec<(usize, usize)> {
    let mut starts = Vec::new();
    let mut line = from;
    let mut depth = 0usize;
    while line < to {
        let rest = text.get(line..to).unwrap_or("");
        let length = rest.find('\n').map_or(rest.len(), |n| n + 1);
        let content = rest.get(..length).unwrap_or("");
        let lead = content.len() - content.trim_start().len();
        let trimmed = content.trim();
        let word = word_at(trimmed);
        let after = trimmed.get(word.len()..).unwrap_or("").trim_start();
        let method = word_at(after);
        let names_a_method = !method.is_empty() && after[method.len()..].trim_start().starts_with('{');
        let opens = if words.is_empty() {
            depth == 0
                && (matches!(word, "param" | "port")
                    || after.starts_with('=')
                    || after.starts_with('{')
                    || names_a_method
                    || after.starts_with(':')
                    // A `=` was left out.
                    || after.starts_with(|c: char| c.is_ascii_digit())
                    || !starts.is_empty() && !word.is_empty() && after.is_empty())
        } else {
            // Continuation lines start with an operator or a word such as `because`.
            words.contains(&word) || (depth == 0 && nearest(word, words.iter().copied()).is_some())
        };
        if !trimmed.is_empty() && !trimmed.starts_with('#') && (opens || starts.is_empty()) {
            starts.push(line + lead);
        }
        for (_, c) in bare(content) {
            match c {
                '{' | '(' | '[' => depth += 1,
                '}' | ')' | ']' => depth = depth.saturating_sub(1),
                _ => {}
            }
        }
        line += length;
    }
    let ends = starts.iter().skip(1).copied().chain([to]).collect::<Vec<_>>();
    starts.into_iter().zip(ends).collect()
}
