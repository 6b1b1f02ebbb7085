//! Says what the parser expected where it stopped, in words.

use pest::Parser;
use pest::error::{ErrorVariant, InputLocation};

use super::forms::form;
use super::parser::{Rule, SgrParser};
use super::slip::Stop;
use super::tokens::{Stretch, TokenKind};
use crate::diagnostics::{Code, Diagnostic, did_you_mean, respell};
use crate::source::{FileId, Span};

/// What may follow a piece that is complete.
const END: &str = "the end of the declaration";

/// Turns the parser's own error into words.
pub(super) fn explain(piece: Stretch<'_>, entry: Rule, file: FileId) -> Diagnostic {
    let error = match SgrParser::parse(entry, piece.text()) {
        Err(error) => error,
        Ok(_) => {
            let span = Span::new(file, piece.start, piece.end);
            return Diagnostic::new(Code::SYNTAX, span, "this cannot be read");
        }
    };
    let (InputLocation::Pos(stop) | InputLocation::Span((stop, _))) = error.location;
    // pest stops before white space and comments; people look at the word after them.
    let found = piece.token_from(piece.start + stop);
    let positives = match &error.variant {
        ErrorVariant::ParsingError { positives, .. } => all_expected(positives),
        ErrorVariant::CustomError { .. } => Vec::new(),
    };
    let mut expected: Vec<&str> = Vec::new();
    for words in positives.into_iter().filter_map(describe) {
        if !expected.contains(&words) {
            expected.push(words);
        }
    }
    let in_expression = expected.contains(&"an operator");
    narrow(&mut expected);
    let piece_name = if entry == Rule::only_item { "the declaration" } else { "the clause" };
    let wanted = listed(&expected).replace(END, &format!("the end of {piece_name}"));
    let (place, text) = found.unwrap_or((piece.end, ""));
    let (span, message) = if text.is_empty() {
        let last = piece.start + piece.text().trim_end().len();
        (Span::new(file, last, last), format!("expected {wanted}, but {piece_name} ends here"))
    } else {
        (Span::new(file, place, place + text.len()), format!("expected {wanted}, found `{text}`"))
    };
    let words =
        || expected.iter().filter_map(|e| e.strip_prefix('`')?.strip_suffix('`')).filter(|w| w.len() > 1);
    // A word of the language is no other one misspelt.
    let misspelt = if is_reserved(text) { "" } else { text };
    let (meant, respelt) = (did_you_mean(misspelt, words()), respell(span, misspelt, words()));
    let help = habit(piece, place, text)
        .or_else(|| no_name(piece, &wanted, text))
        .or_else(|| out_of_order(piece, text))
        .or(meant);
    let like = help.is_none().then(|| looks_like(entry, piece, place, &expected)).flatten();
    if in_expression && !expected.contains(&"an operator") {
        expected.push("an operator");
    }
    let error = Diagnostic::new(Code::SYNTAX, span, message)
        .label(if text.is_empty() { "something is missing here" } else { "not expected here" })
        .help_if(help)
        .fix_if(respelt);
    let error = Stop { piece, place, found: text, expected: &expected, file }.explain(error);
    if error.help.is_some() { error } else { error.help_if(like) }
}

/// Leaves what is most likely missing of all that could go on.
fn narrow(expected: &mut Vec<&str>) {
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
}

/// Alternatives as people list them.
fn listed(expected: &[&str]) -> String {
    match expected {
        [] => "something else".to_owned(),
        [one] => (*one).to_owned(),
        [head @ .., last] => {
            let head = head.iter().take(6).copied().collect::<Vec<_>>().join(", ");
            format!("{head} or {last}")
        }
    }
}

/// Whether a word can name nothing.
fn is_reserved(word: &str) -> bool {
    SgrParser::parse(Rule::keyword, word).is_ok_and(|mut p| p.next().is_some_and(|p| p.as_str() == word))
}

/// What to write instead of a word that other clauses of a variant, or other variables, have.
fn habit(piece: Stretch<'_>, place: usize, found: &str) -> Option<String> {
    let before = piece.part(piece.start, place).text();
    let last = before.split_whitespace().next_back()?;
    let after = piece.part(place, piece.end).text();
    let is_given = after.get(found.len()..).is_some_and(|rest| rest.trim_start().starts_with('='));
    match last {
        "drop"
            if matches!(
                found,
                "rule"
                    | "require"
                    | "prefer"
                    | "term"
                    | "sense"
                    | "state"
                    | "part"
                    | "actuator"
                    | "target"
                    | "example"
            ) =>
        {
            Some(format!("write `drop NAME`, without `{found}`"))
        }
        "set"
            if matches!(found, "search" | "simulate" | "actuate" | "maximize" | "minimize" | "symmetry") =>
        {
            Some(format!("`set` gives a value: write `replace {found} ...`"))
        }
        "add" if is_given => Some(format!("a value of the base is changed by `set {found} = VALUE`")),
        _ if before.contains(": Bool")
            && before.trim_end().ends_with(|c: char| c.is_ascii_digit() || c == '%') =>
        {
            let chance = last.trim_end_matches(',');
            before
                .contains("mutate")
                .then(|| format!("a Bool is flipped, with a chance: write `flip {chance}`"))
        }
        _ => None,
    }
}

/// What to say where a word of the language stands in the place of a name.
fn no_name(piece: Stretch<'_>, wanted: &str, found: &str) -> Option<String> {
    if !wanted.contains("a name") {
        None
    } else if piece.first_word() == "drop" && found == "symmetry" {
        Some("write `replace symmetry none`".to_owned())
    } else if piece.first_word() == "drop" && matches!(found, "simulate" | "maximize" | "minimize" | "search")
    {
        Some(format!("every grammar needs one: write `replace {found} ...`"))
    } else if matches!(found, "part" | "actuator" | "cell") {
        Some(format!("give it a name first, as in `p : {found}`"))
    } else {
        is_reserved(found).then(|| format!("`{found}`{WORD_AS_NAME}"))
    }
}

/// What is said of a name that is a word of the language.
const WORD_AS_NAME: &str = " is a word of the language: choose another name";

/// The word that a help says is no name.
pub(super) fn word_as_name(help: &str) -> Option<&str> {
    help.strip_prefix('`')?.strip_suffix(WORD_AS_NAME)?.strip_suffix('`')
}

/// What to say where a part of `attach` or `place` stands behind one that comes after it.
fn out_of_order(piece: Stretch<'_>, found: &str) -> Option<String> {
    let name = match piece.first_word() {
        "attach" => " as NAME",
        "place" if found != "as" => "",
        _ => return None,
    };
    matches!(found, "to" | "turned" | "by" | "alone" | "as").then(|| {
        format!(
            "write these in this order: `to PORT turned ANGLE by PORT alone{name}`; all but the first may be left out"
        )
    })
}

/// What the whole declaration or clause looks like, where that helps: not in the middle of a value.
fn looks_like(entry: Rule, piece: Stretch<'_>, place: usize, expected: &[&str]) -> Option<String> {
    let before = piece.part(piece.start, place);
    let last = before.tokens().next_back();
    let after_word = last.is_some_and(|t| matches!(t.kind, TokenKind::Word | TokenKind::Number));
    let inside = expected.iter().any(|e| ["`)`", "`]`", "`then`", "`else`"].contains(e));
    if inside || expected == ["a value"] && !after_word {
        return None;
    }
    let first = piece.first_word();
    // What stands on a line of its own, as in an example of a variant, is nearer.
    let line = before.lines().last().map_or("", Stretch::first_word);
    // The name of a descriptor, for example.
    let names_block = before.lines().last().is_some_and(|last| last.text().trim() == line)
        && piece.part(place, piece.end).text().starts_with('{');
    if names_block && is_reserved(line) && expected.contains(&"`=`") {
        return Some(format!("`{line}`{WORD_AS_NAME}"));
    }
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
        Rule::kw_in | Rule::in_part => "`in`",
        Rule::kw_for => "`for`",
        Rule::kw_on | Rule::on_part => "`on`",
        Rule::kw_with => "`with`",
        Rule::kw_to | Rule::to_part => "`to`",
        Rule::kw_by => "`by`",
        Rule::kw_of => "`of`",
        Rule::kw_over => "`over`",
        Rule::kw_because => "`because`",
        Rule::kw_then => "`then`",
        Rule::kw_always => "`always`",
        Rule::kw_else => "`else`",
        Rule::kw_turned | Rule::turned_part => "`turned`",
        Rule::kw_from => "`from`",
        Rule::kw_next => "`next`",
        Rule::kw_facing => "`facing`",
        Rule::kw_about => "`about`",
        Rule::kw_along => "`along`",
        Rule::kw_joint => "`joint`",
        Rule::kw_passive => "`passive`",
        Rule::axis_part => "`about` or `along` and an axis",
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
