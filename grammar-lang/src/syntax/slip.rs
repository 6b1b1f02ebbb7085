//! Common slips at the place where the parser stopped, with what was meant.

use pest::Parser;

use super::braces::span;
use super::parser::{Rule, SgrParser};
use super::tokens::{Stretch, TokenKind};
use crate::diagnostics::{Diagnostic, Fix};
use crate::source::{FileId, Span};

/// Signs that come along from word processors and other languages, and what they stand for here.
const LOOK_ALIKE: &[(&str, &str)] = &[
    ("−", "-"),
    ("–", "-"),
    ("—", "-"),
    ("×", "*"),
    ("·", "*"),
    ("÷", "/"),
    ("=<", "<="),
    ("=>", ">="),
    ("≤", "<="),
    ("≥", ">="),
    ("≠", "!="),
    ("…", ".."),
    ("&&", "and"),
    ("||", "or"),
];

/// How things are counted that fulfil a condition.
const COUNT: &str = "write `over` after `count`: `(count over p in part where p.depth > 1)`";

/// Where the parser stopped.
pub(super) struct Stop<'a> {
    /// The declaration or clause.
    pub(super) piece: Stretch<'a>,
    /// Where the parser stopped in the file.
    pub(super) place: usize,
    /// The word or sign that stands there.
    pub(super) found: &'a str,
    /// What could stand there instead, as people call it.
    pub(super) expected: &'a [&'a str],
    pub(super) file: FileId,
}

impl Stop<'_> {
    fn span(&self, length: usize) -> Span {
        Span::new(self.file, self.place, self.place + length)
    }

    /// The piece up to where the parser stopped.
    fn read(&self) -> Stretch<'_> {
        self.piece.part(self.piece.start, self.place)
    }

    /// Whether a bracket before this is not closed.
    fn opens_bracket(&self) -> bool {
        let before = self.before();
        before.matches('(').count() > before.matches(')').count()
    }

    fn before(&self) -> &str {
        self.read().text()
    }

    /// The piece from a number of bytes behind where the parser stopped.
    fn unread(&self, skipped: usize) -> Stretch<'_> {
        self.piece.part(self.place + skipped, self.piece.end)
    }

    fn rest(&self) -> &str {
        self.unread(0).text()
    }

    /// The word that the clause begins with; several may stand in a piece.
    fn clause(&self) -> &str {
        self.read().lines().last().map_or("", Stretch::first_word)
    }

    /// The last token before the stop.
    fn last(&self) -> &str {
        self.read().tokens().next_back().map_or("", |token| token.text)
    }

    fn expects(&self, what: &str) -> bool {
        self.expected.contains(&what)
    }

    /// The finding with what was meant, where that can be told.
    pub(super) fn explain(&self, error: Diagnostic) -> Diagnostic {
        if let Some(span) = self.attached_at() {
            let help = "write `to` instead of `at`";
            return Diagnostic::new(error.code, span, "expected `to`, found `at`")
                .label("not expected here")
                .help(help)
                .fix(Fix::replace(span, "to", help));
        }
        if let Some(span) = self.compared_to_set() {
            let help = "write `=`: `==` compares two values";
            return Diagnostic::new(error.code, span, "expected `=` after `set`, found `==`")
                .label("not expected here")
                .help(help)
                .fix(Fix::replace(span, "=", help));
        }
        let slip = self
            .look_alike()
            .or_else(|| self.quotes())
            .or_else(|| self.comment())
            .or_else(|| self.range())
            .or_else(|| self.equals())
            .or_else(|| self.comma())
            .or_else(|| self.needless())
            .or_else(|| self.time())
            .or_else(|| self.chained())
            .or_else(|| self.where_to())
            .or_else(|| self.named_early())
            .or_else(|| self.either_kind())
            .or_else(|| self.open_bracket())
            .or_else(|| self.little_word())
            .or_else(|| self.between());
        match slip {
            Some((help, fix)) => error.help(help).fix_if(fix),
            None => error,
        }
    }

    fn look_alike(&self) -> Option<(String, Option<Fix>)> {
        let (sign, meant) = LOOK_ALIKE.iter().find(|(sign, _)| self.rest().starts_with(sign))?;
        let message = format!("write `{meant}` instead of `{sign}`");
        // A word stands apart from its neighbours, a sign need not.
        let word = meant.starts_with(char::is_alphabetic);
        let after = self.rest().get(sign.len()..).unwrap_or("");
        let before = if word && !self.before().ends_with([' ', '\t']) { " " } else { "" };
        let after = if word && after.starts_with(char::is_alphanumeric) { " " } else { "" };
        let fix = Fix::replace(self.span(sign.len()), format!("{before}{meant}{after}"), message.clone());
        // Elsewhere this sign is an arrow.
        let arrow = *sign == "=>";
        let message = if arrow {
            format!("{message} to compare; a case of `match` and a row of a table have `->`")
        } else {
            message
        };
        Some((message, (!arrow && !self.is_ambiguous(sign)).then_some(fix)))
    }

    /// Whether a sign that looks like another may stand for something else here: between two values people write a dash for a
    /// range, too, and between two digits a dot for the decimal point.
    fn is_ambiguous(&self, sign: &str) -> bool {
        let before = self.before();
        let after = self.rest().get(sign.len()..).unwrap_or("");
        match sign {
            "–" | "—" => before.trim_end().ends_with(|c: char| c.is_alphanumeric() || ")]%°".contains(c)),
            "·" => {
                before.ends_with(|c: char| c.is_ascii_digit())
                    && after.starts_with(|c: char| c.is_ascii_digit())
            }
            _ => false,
        }
    }

    /// Curly quotes around a text.
    fn quotes(&self) -> Option<(String, Option<Fix>)> {
        let curly = ['“', '”', '„', '‟', '«', '»'];
        let line = self.rest().lines().next()?;
        let open = line.chars().next().filter(|c| curly.contains(c))?;
        let help = "write straight quotes: `\"`".to_owned();
        let inner = line.get(open.len_utf8()..)?;
        let fix = inner.find(curly).and_then(|close| {
            let close_start = self.place + open.len_utf8() + close;
            let length = inner.get(close..)?.chars().next()?.len_utf8();
            let close = Span::new(self.file, close_start, close_start + length);
            Some(Fix::replace(self.span(open.len_utf8()), "\"", help.clone()).and(close, "\""))
        });
        Some((help, fix))
    }

    /// `//`, of which the parser has taken the first for a division.
    fn comment(&self) -> Option<(String, Option<Fix>)> {
        if self.found != "/" || !self.before().ends_with('/') {
            return None;
        }
        let both = Span { start: self.span(0).start.saturating_sub(1), ..self.span(1) };
        let fix = Fix::replace(both, "#", "write `#` instead of `//`");
        // `// 8` may be a division, too, with a sign too many.
        let rest = self.unread(1).rest_of_line();
        let divides = SgrParser::parse(Rule::only_expr, rest.trim_end_matches([')', '}', ']'])).is_ok();
        if divides {
            return Some(("a comment begins with `#`, and one `/` divides".to_owned(), None));
        }
        Some(("a comment begins with `#`".to_owned(), Some(fix)))
    }

    /// `=` where two values are compared, `==` or `:` where a name gets one.
    fn equals(&self) -> Option<(String, Option<Fix>)> {
        let replace = |length, by: &str| {
            let found = self.found;
            Some(Fix::replace(self.span(length), by, format!("write `{by}` instead of `{found}`")))
        };
        let words = "write `==` to compare two values; `=` gives a value to a name";
        let condition = ["require", "when", "unless"].iter().any(|w| self.piece.first_word() == *w);
        let alone = !self.rest().get(1..).unwrap_or("").starts_with(['=', '<', '>', '~']);
        match self.found {
            "==" if self.expects("`=`") => Some((words.to_owned(), replace(2, "="))),
            // The parser has taken the first of two for the sign that it was looking for.
            "=" if self.before().ends_with('=') => Some((words.to_owned(), {
                let first = Span { start: self.span(0).start.saturating_sub(1), ..self.span(1) };
                Some(Fix::replace(first, "=", "write `=` instead of `==`"))
            })),
            // A condition may begin with a name, too: what is meant is not certain.
            "=" if self.expects("`:`")
                && ["require", "prefer"].iter().any(|w| self.piece.first_word() == *w) =>
            {
                let help = "write `:` between the name and the condition, and `==` to compare";
                Some((help.to_owned(), None))
            }
            "=" if self.expects("an operator") => {
                Some((words.to_owned(), replace(1, "==").filter(|_| condition && alone)))
            }
            ":" if self.expects("`=`") => {
                Some(("write `=` here: `:` gives the type of a name".to_owned(), replace(1, "=")))
            }
            _ => None,
        }
    }

    /// `3 ..= 5` and `3 ..< 5`, of which the parser has taken the dots.
    fn range(&self) -> Option<(String, Option<Fix>)> {
        let sign = Some(self.found).filter(|_| self.before().trim_end().ends_with(".."))?;
        let help = match sign {
            "=" => "a range includes both of its ends: write `3 .. 5`",
            "<" => "both ends of a range belong to it: write `3 .. 4` for 3 and 4",
            _ => return None,
        };
        let fix = (sign == "=").then(|| Fix::replace(self.span(1), " ", "remove `=`"));
        Some((help.to_owned(), fix))
    }

    /// Whether a colour without quotes precedes the stop: the parser has taken it for a comment.
    fn is_colour(&self) -> bool {
        let after = self.before().rsplit_once('=').map_or("", |(_, after)| after.trim_start());
        let hex = after.strip_prefix('#').map_or("", |hex| hex);
        hex.chars().take_while(char::is_ascii_hexdigit).count() >= 3
    }

    /// A value after another in a list.
    fn between(&self) -> Option<(String, Option<Fix>)> {
        let is = |rule| SgrParser::parse(rule, self.found).is_ok();
        let is_value = is(Rule::only_expr) && !is(Rule::keyword);
        // In round brackets what follows may lie behind them, if it is no number.
        let in_round = self.expects("`)`") && self.found.starts_with(|c: char| c.is_ascii_digit());
        let is_list =
            self.expects("`,`") && (in_round || ["`]`", "`}`"].iter().any(|close| self.expects(close)));
        let last = self.read().tokens().next_back().filter(|_| is_value && is_list)?;
        let is_operand = matches!(last.kind, TokenKind::Word | TokenKind::Number);
        let help = format!("put a comma before `{}`", self.found);
        is_operand.then(|| (help, Some(Fix::insert_after(span(last, self.file), ",", "insert a comma"))))
    }

    /// A comma where it means something in other languages.
    fn comma(&self) -> Option<(String, Option<Fix>)> {
        let after = self.rest().strip_prefix(',')?;
        let unit = after.trim_start_matches(|c: char| c.is_ascii_digit());
        let digits = self.before().ends_with(|c: char| c.is_ascii_digit()) && unit.len() < after.len();
        // Without a unit, these may be two whole numbers.
        if digits && unit.trim_start_matches([' ', '\t']).starts_with(|c: char| c.is_alphabetic() || c == '%')
        {
            let message = "a decimal number is written with a point".to_owned();
            // Three digits may be thousands.
            if after.len() - unit.len() == 3 {
                return Some((format!("{message}, thousands without a sign"), None));
            }
            return Some((message.clone(), Some(Fix::replace(self.span(1), ".", message))));
        }
        let rest = Some(self.unread(1).rest_of_line()).filter(|rest| !rest.is_empty())?;
        let help = match self.clause() {
            "choose" => {
                let first = self.before().rsplit_once(" in ").map_or("", |(_, values)| values).trim();
                // Another clause may follow on the same line, further apart.
                let rest = rest.split("  ").next().unwrap_or(rest);
                let rest = if first.starts_with('(') { rest.trim_end_matches(')') } else { rest };
                let first = first.trim_start_matches('(');
                format!("put single values in braces: `{{ {first}, {rest} }}`")
            }
            "match" => format!("one `match` binds one name: write `match {rest}` on the next line"),
            _ if self.expects("`}`") => {
                let (name, first) = self.read().lines().last()?.text().split_once('=')?;
                let (name, first) = (name.trim(), first.trim());
                if name.contains(char::is_whitespace) || first.is_empty() {
                    return None;
                }
                format!("several values are a list: `{name} = [{first}, {rest}]`")
            }
            _ => return None,
        };
        Some((help, None))
    }

    /// `1 < x < 3`
    fn chained(&self) -> Option<(String, Option<Fix>)> {
        let signs = ["<", ">", "<=", ">=", "==", "!="];
        let compared = || self.read().tokens().any(|token| signs.contains(&token.text));
        (signs.contains(&self.found) && compared()).then(|| {
            let help = "comparisons cannot be chained: join two of them with `and`, as in `1 < x and x < 3`";
            (help.to_owned(), None)
        })
    }

    /// `attach cube at q`, of which the parser has taken `at q` for a time.
    fn attached_at(&self) -> Option<Span> {
        let attaches = matches!(self.piece.first_word(), "attach" | "place");
        let at = self.read().tokens().find(|token| token.text == "at");
        at.filter(|_| attaches && self.expects("`to`")).map(|at| span(at, self.file))
    }

    /// `set p.turn == 90 deg`, of which the parser has taken all for what is to be set.
    fn compared_to_set(&self) -> Option<Span> {
        let sets = self.clause() == "set" && self.expects("`=`");
        let sign = self.read().tokens().find(|token| token.text == "==");
        sign.filter(|_| sets).map(|sign| span(sign, self.file))
    }

    /// `attach cube turned 90 deg to q`
    fn where_to(&self) -> Option<(String, Option<Fix>)> {
        let attaches = matches!(self.clause(), "attach" | "place") && self.expects("`to`");
        let early = attaches && matches!(self.found, "turned" | "by" | "as");
        let (early, others) = early.then(|| (self.found, self.unread(0).rest_of_line()))?;
        let (own, to) = others.split_once(" to ")?;
        let what = self.read().lines().last()?.text().trim();
        // The name of the part comes last.
        let (to, name) =
            to.split_once(" as ").map_or((to, String::new()), |(to, name)| (to, format!(" as {name}")));
        Some((
            format!("give the port before `{early}`: `{what} to {} {}{name}`", to.trim(), own.trim()),
            None,
        ))
    }

    /// `match p : wheel or ski`
    fn either_kind(&self) -> Option<(String, Option<Fix>)> {
        let read = Some(self.read().lines().last()?.text())
            .filter(|_| self.clause() == "match" && self.found == "or")?;
        let (bound, one) = read.split_once(':')?;
        let (name, one) = (bound.split_whitespace().next_back()?, one.trim());
        let other = self.unread("or".len()).rest_of_line().split_whitespace().next()?;
        let help = format!(
            "a `match` names one kind or group: `match {name} : part where {name} is {one} or {name} is {other}`"
        );
        Some((help, None))
    }

    /// `attach cube to q as s by front`
    fn named_early(&self) -> Option<(String, Option<Fix>)> {
        let attaches = matches!(self.clause(), "attach" | "place" | "replace");
        let late = attaches && matches!(self.found, "turned" | "by" | "between" | "from");
        let others = late.then(|| self.unread(0).rest_of_line())?;
        let (what, name) = self.read().lines().last()?.text().trim().rsplit_once(" as ")?;
        Some((format!("the name comes last: `{what} {} as {}`", others.trim(), name.trim()), None))
    }

    /// A bracket that is open where the clause ends.
    fn open_bracket(&self) -> Option<(String, Option<Fix>)> {
        let pairs = [("{", "}"), ("(", ")"), ("[", "]")];
        let count = |sign: &str| self.read().tokens().filter(|token| token.text == sign).count();
        let (_, close) = pairs.into_iter().find(|(open, close)| {
            self.found.is_empty() && self.expects(&format!("`{close}`")) && count(open) > count(close)
        })?;
        let gap = if close == "}" { " " } else { "" };
        let line = self.read().lines().last()?.text().trim().to_owned();
        Some((format!("end it with `{close}`: `{line}{gap}{close}`"), None))
    }

    /// A little word of plain English where the language has another, or a sign.
    fn little_word(&self) -> Option<(String, Option<Fix>)> {
        let last = self.last();
        let counts = self
            .before()
            .rfind('(')
            .is_some_and(|open| self.before().get(..open).is_some_and(|before| before.ends_with("count")));
        let gathers = ["sum", "mean", "count", "min", "max", "forall", "exists"].contains(&last);
        let help = match self.found {
            "of" if self.expects("`in`") => {
                "write `in` before the group and `of` before the value: `max over e in elements of e.size`"
            }
            ")" | "," if self.expects("`:`") && self.piece.first_word() == "let" => {
                "give the parameter a type: `let half(x : Length) = x / 2`"
            }
            "{" if self.expects("`where`") => {
                "a condition follows `where`: `match s : step where s adds part`"
            }
            "=" if self.piece.first_word() == "choose" => {
                "a choice is drawn from a domain: `choose n in 3 .. 6`; one value is given by `let n = 3`"
            }
            "where" | "in" if counts => COUNT,
            "part" | "actuator" if counts && last == "in" => COUNT,
            "of" if gathers => "write for example `sum over p in part of p.mass`",
            "to" | "turned" | "as" | "by" if self.expects("`)`") && self.opens_bracket() => {
                "a bracket is not closed: write `)` before this"
            }
            "to" if self.expects("an operator") && self.before().contains('=') => {
                "a range is written with two dots: `0 deg .. 90 deg`"
            }
            _ if self.expects("`{`") && self.clause() == "case" => {
                "put its values in braces: `case ice { ground_friction = 0.2 }`"
            }
            _ if self.expects("`with`") && self.piece.first_word() == "actuate" => {
                "name the actuation that drives this kind: `actuate bender with two_sided_pac`"
            }
            _ if self.expects("a value") && last == "=" && self.is_colour() => {
                "put the colour in quotes: `\"#a0522d\"`; a `#` without quotes begins a comment"
            }
            _ if self.expects("`else`")
                && self.expected.iter().all(|e| ["`else`", "an operator"].contains(e)) =>
            {
                "give the value for the other case: `if a > b then 1 else 0`"
            }
            _ if self.expects("`then`") && !matches!(last, "elif" | "elseif") => {
                "a condition is followed by `then`: `if a > b then 1 else 0`"
            }
            _ if ["sum", "mean", "min", "max"].contains(&last)
                && self.unread(self.found.len()).rest_of_line().starts_with("in ") =>
            {
                "write `over`: `sum over p in part of p.mass`"
            }
            _ if matches!(last, "elif" | "elseif") => "write `else if`",
            _ if last == "passive" && self.piece.first_word() == "joint" => {
                "put `passive` at the end: `joint = bend about y passive`"
            }
            _ if self.expects("`of`")
                && self.before().contains(" over ")
                && self.found.starts_with(char::is_alphabetic) =>
            {
                "write `of` before the value: `min over w in workshop of travel`"
            }
            _ if self.expects("`->`") => "write each case as `VALUE -> RESULT`",
            _ if self.expects("`:`") && self.expects("`where`") && self.before().contains("in ") => {
                "put a `:` before the condition: `forall p in part: p.mass < 9 g`"
            }
            _ if self.expects("a text in quotes") && last == "because" => {
                "write the reason in quotes: `because \"the box is small\"`"
            }
            _ => return None,
        };
        Some((help.to_owned(), None))
    }

    /// A sign at the end of a line that needs none.
    fn needless(&self) -> Option<(String, Option<Fix>)> {
        let sign = Some(self.found).filter(|f| [";", ","].contains(f))?;
        let after = self.unread(1);
        let last = after.rest_of_line().is_empty() || after.first().is_some_and(|t| t.text == "}");
        last.then(|| {
            let fix = Fix::replace(self.span(1), "", format!("remove `{sign}`"));
            (format!("remove the `{sign}`"), Some(fix))
        })
    }

    /// A calculated time after `at`.
    fn time(&self) -> Option<(String, Option<Fix>)> {
        (self.found == "-" && self.last() == "at").then(|| {
            let help = "times count from the start of the motion, which is 0 s; put a calculated time in brackets: `at (end - 1 s)`";
            (help.to_owned(), None)
        })
    }
}
