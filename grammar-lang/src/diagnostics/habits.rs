//! Habits of other languages: what people write who know Python, C, Matlab, YAML or OpenSCAD, and what `sgc` writes instead.

use std::ops::Range;

use super::{Code, Diagnostic};
use crate::source::SourceMap;

/// How a habit is told from other text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Told {
    /// A name that is not known.
    Name,
    /// A function that is not known.
    Function,
    /// A unit that is not known.
    Unit,
    /// A type that is not known.
    Type,
    /// A field that is not known.
    Field,
    /// A word that begins a declaration or a clause, and does not begin one here.
    Opening,
    /// A word that cannot stand where it stands.
    Word,
    /// Where a finding stands on this sign, or within it.
    Sign,
    /// Where this stands in the line of a finding.
    Line,
}

const NAME: Told = Told::Name;
const FUNCTION: Told = Told::Function;
const UNIT: Told = Told::Unit;
const TYPE: Told = Told::Type;
const FIELD: Told = Told::Field;
const OPENING: Told = Told::Opening;
const WORD: Told = Told::Word;
const SIGN: Told = Told::Sign;
const LINE: Told = Told::Line;

/// What is written elsewhere, how it is told, and what helps.
const HABITS: &[(&str, Told, &str)] = &[
    // Operators
    (
        "**",
        SIGN,
        "there is no power operator: write `x * x`, or `exp(n * ln(x))` where n varies; in a unit, `m^2`",
    ),
    (
        "+=",
        LINE,
        "a value cannot be changed later: write `name = value`; in a rule, `set p.turn = p.turn + 90 deg`",
    ),
    (
        "-=",
        LINE,
        "a value cannot be changed later: write `name = value`; in a rule, `set p.turn = p.turn - 90 deg`",
    ),
    ("!=", SIGN, "compare with `!=` or `is not`"),
    ("<>", SIGN, "write `!=` for quantities, `is not` for parts"),
    ("&&", SIGN, "write `and` instead of `&&`"),
    ("||", SIGN, "write `or` instead of `||`"),
    ("?", SIGN, "write `if CONDITION then A else B`"),
    ("!", SIGN, "write `not` instead of `!`"),
    ("|", SIGN, "write `abs(x)` instead of `|x|`"),
    ("%", SIGN, "there is no remainder operator: the remainder of n divided by 8 is `n - 8 * floor(n / 8)`"),
    (
        "mod",
        WORD,
        "there is no remainder operator: the remainder of n divided by 8 is `n - 8 * floor(n / 8)`",
    ),
    (
        "^",
        SIGN,
        "there is no power operator: write `x * x`, or `exp(n * ln(x))` where n varies; in a unit, `m^2`",
    ),
    ("√", SIGN, "write `sqrt(x)`"),
    ("AND", WORD, "write `and`: keywords are in lower case"),
    ("OR", WORD, "write `or`: keywords are in lower case"),
    ("NOT", WORD, "write `not`: keywords are in lower case"),
    // Comments
    ("/*", SIGN, "a comment begins with `#` and ends at the end of the line"),
    ("//", SIGN, "a comment begins with `#`"),
    (" --", LINE, "a comment begins with `#`"),
    // Values
    ("True", NAME, "write `true`"),
    ("False", NAME, "write `false`"),
    ("TRUE", NAME, "write `true`"),
    ("FALSE", NAME, "write `false`"),
    ("None", NAME, "there is no empty value: leave the line out"),
    ("null", NAME, "there is no empty value: write a condition, as in `p is core`"),
    ("nil", NAME, "there is no empty value: write a condition, as in `p is core`"),
    ("this", NAME, "use the name that `match` gives to the matched part, as in `match p : part`"),
    ("self", NAME, "use the name that `match` gives to the matched part, as in `match p : part`"),
    ("deflate", NAME, "the states of valves are `inflate`, `vent` and `closed`"),
    ("exhaust", NAME, "the states of valves are `inflate`, `vent` and `closed`"),
    ("never", NAME, "write `false`: with `stop = false`, a loop makes all of its `iterations`"),
    ("always", NAME, "write `true`"),
    ("inf", NAME, "no number is infinite: write one that is large enough"),
    // Functions
    ("range", FUNCTION, "write `3 .. 6`: both ends are included"),
    (
        "len",
        FUNCTION,
        "write `count(part)` for parts; a list has the length that it was declared with, as in `points[4]`",
    ),
    ("sum", FUNCTION, "write `sum over p in part of p.mass`"),
    ("mean", FUNCTION, "write `mean over e in elements of e.size`"),
    ("any", FUNCTION, "write `exists p in part: CONDITION`"),
    ("all", FUNCTION, "write `forall p in part: CONDITION`"),
    ("pow", FUNCTION, "there is no power function: write `x * x`, or `exp(n * ln(x))`"),
    ("atan", FUNCTION, "write `atan2(y, x)`, or `atan2(x, 1)` for the angle of one tangent"),
    ("log", FUNCTION, "write `ln(x)` for the natural logarithm"),
    ("gaussian", FUNCTION, "write `normal(mean, deviation)`"),
    ("gauss", FUNCTION, "write `normal(mean, deviation)`"),
    ("randn", FUNCTION, "write `normal(mean, deviation)`"),
    (
        "cube",
        FUNCTION,
        "a shape is written `box(x, y, z)`; the part `cube` has no parameters, and comes from `use std.blocks { cube }`",
    ),
    ("worst", NAME, "the worst of several worlds is `min over w in workshop of ...`"),
    ("worst", WORD, "the worst of several worlds is `min over w in workshop of ...`"),
    ("percentile", WORD, "write `quantile 10 % over w in workshop of ...`"),
    ("rand", FUNCTION, "only `choose` and `mutate` draw random values: `choose n in 3 .. 6`"),
    ("random", FUNCTION, "only `choose` and `mutate` draw random values: `choose n in 3 .. 6`"),
    // Declarations and clauses
    ("def", OPENING, "write `let name(x : Length) = ...` for a function, `rule name { ... }` for a rule"),
    ("fn", OPENING, "write `let name(x : Length) = ...`"),
    ("func", OPENING, "write `let name(x : Length) = ...`"),
    ("function", OPENING, "write `let name(x : Length) = ...`"),
    ("const", OPENING, "write `let name = ...`, or `param` for a value that users may set"),
    (
        "var",
        OPENING,
        "write `let name = ...`, or `param` for a value that users may set; declare values that the search varies in an `actuation`",
    ),
    ("import", OPENING, "write `use std.blocks { cube }`, or `use \"./mine.sgr\" { brick }`"),
    ("include", OPENING, "write `use std.blocks { cube }`, or `use \"./mine.sgr\" { brick }`"),
    ("from", OPENING, "write `use std.blocks { cube }`, or `use \"./mine.sgr\" { brick }`"),
    ("module", OPENING, "declare a kind of part with `part`; a file of declarations needs no keyword"),
    (
        "class",
        OPENING,
        "write `part name { ... }` for a kind of part, or `record Name { ... }` for a group of fields",
    ),
    ("struct", OPENING, "write `record Name { field : Type, ... }`"),
    ("print", OPENING, "to record a term beside the value of each design, write `observe TERM`"),
    ("echo", OPENING, "to record a term beside the value of each design, write `observe TERM`"),
    ("return", OPENING, "a function is one expression: `let twice(x : Length) = 2 * x`"),
    (
        "for",
        OPENING,
        "`for` repeats lines of a rule: write it inside `rule NAME { ... }`. To add up over many parts, write `sum over p in part of ...`",
    ),
    (
        "while",
        OPENING,
        "there are no loops: the search applies rules again and again, as long as `when` allows it",
    ),
    (
        "repeat",
        OPENING,
        "there are no loops: the search applies rules again and again, as long as `when` allows it",
    ),
    (
        "if",
        OPENING,
        "write a condition of the whole rule as `when n > 3`; put effects that depend on a condition into a block: `if n > 3 { attach cube to q }`",
    ),
    ("else", WORD, "a block has no `else`: write a second block, `if not (CONDITION) { ... }`"),
    ("if", WORD, "write `if CONDITION then A else B`"),
    ("not is", LINE, "write `is not`"),
    ("elif", WORD, "write `else if`"),
    ("elseif", WORD, "write `else if`"),
    ("new", WORD, "a kind is named without `new`: `attach cube to q`"),
    (
        "set",
        OPENING,
        "edit the declaration itself, or, to keep it unchanged, write a variant: `variant mine of \"./x.sgr\" { set ... }`",
    ),
    // Fields
    ("axis", FIELD, "write the axis in the field `joint`: `joint = bend about y`, `joint = slide along x`"),
    (
        "limits",
        FIELD,
        "the limits of a joint are its `bend` or its `range`, as in `range = -30 deg .. 30 deg`",
    ),
    ("size", FIELD, "write sizes in the shape: `shape = box(3 cm, 3 cm, 3 cm)`"),
    (
        "radius",
        FIELD,
        "write sizes in the shape, as in `segment = cylinder(6 mm, 12 mm)` or `shape = ball(1 cm)`",
    ),
    (
        "diameter",
        FIELD,
        "write sizes in the shape, as a radius: `segment = cylinder(6 mm, 12 mm)`, `shape = ball(1 cm)`",
    ),
    ("weight", FIELD, "write `mass = 12 g`"),
    // Types
    ("float", TYPE, "write the kind of quantity, such as `Length`, or `Number` for a number without a unit"),
    ("double", TYPE, "write the kind of quantity, such as `Length`, or `Number` for a number without a unit"),
    ("real", TYPE, "write the kind of quantity, such as `Length`, or `Number` for a number without a unit"),
    ("int", TYPE, "write `Count` for a whole number"),
    ("integer", TYPE, "write `Count` for a whole number"),
    ("Int", TYPE, "write `Count` for a whole number"),
    ("Integer", TYPE, "write `Count` for a whole number"),
    ("Float", TYPE, "write the kind of quantity, such as `Length`, or `Number` for a number without a unit"),
    ("Real", TYPE, "write the kind of quantity, such as `Length`, or `Number` for a number without a unit"),
    ("bool", TYPE, "write `Bool`"),
    ("boolean", TYPE, "write `Bool`"),
    ("str", TYPE, "write `Text`"),
    ("string", TYPE, "write `Text`"),
    // Units
    ("Nmm", UNIT, "write a torque in `N*mm/rad`"),
    ("Nm", UNIT, "write a torque in `N*m/rad`"),
    ("Ncm", UNIT, "write a torque in `N*m/rad`: 1 N cm is `0.01 N*m/rad`"),
    ("mNm", UNIT, "write a torque in `N*m/rad`: 1 mN m is `0.001 N*m/rad`"),
    ("kgcm", UNIT, "write a torque in `N*m/rad`: 1 kg cm is `0.0981 N*m/rad`"),
    ("rpm", UNIT, "1 rpm is `6 deg/s`"),
    ("psi", UNIT, "1 psi is `6.895 kPa`"),
    ("mbar", UNIT, "1 mbar is `0.1 kPa`"),
    ("atm", UNIT, "1 atm is `101.3 kPa`"),
    ("inch", UNIT, "1 inch is `25.4 mm`"),
    ("inches", UNIT, "1 inch is `25.4 mm`"),
    ("ft", UNIT, "1 foot is `304.8 mm`"),
    ("lb", UNIT, "1 lb is `453.6 g`"),
    ("oz", UNIT, "1 oz is `28.35 g`"),
    ("dm", UNIT, "1 dm is `10 cm`"),
    ("kHz", UNIT, "1 kHz is `1000 Hz`"),
    ("mW", UNIT, "1 mW is `0.001 W`"),
    ("kN", UNIT, "1 kN is `1000 N`"),
    ("GPa", UNIT, "1 GPa is `1000 MPa`"),
    ("l", UNIT, "1 l is `1000 cm^3`"),
    ("L", UNIT, "1 l is `1000 cm^3`"),
    ("turn", UNIT, "a full turn is `360 deg`"),
    ("rev", UNIT, "a full turn is `360 deg`"),
    ("rps", UNIT, "1 turn a second is `360 deg/s`"),
];

/// What findings can be about a habit: names, words, units and text that cannot be read.
fn may_be(code: &Code) -> bool {
    let codes = [
        Code::SYNTAX,
        Code::UNKNOWN_KEYWORD,
        Code::UNKNOWN_NAME,
        Code::UNKNOWN_FIELD,
        Code::UNKNOWN_TYPE,
        Code::UNKNOWN_UNIT,
    ];
    codes.contains(&code)
}

/// Says in findings what is written instead of a habit of another language.
pub(crate) fn with_habits(findings: &mut [Diagnostic], sources: &SourceMap) {
    for finding in findings.iter_mut().filter(|finding| may_be(finding.code)) {
        let span = finding.span();
        let Some(source) = sources.get(span.file) else { continue };
        let (text, start, end) = around(&source.text, span.range());
        if let Some(help) = number(text, start).filter(|_| finding.code != Code::UNKNOWN_UNIT) {
            finding.help = Some(help);
            continue;
        }
        if let Some(help) = form(text, start).filter(|_| finding.code == Code::SYNTAX) {
            finding.help = Some(help);
            finding.fix = None;
            continue;
        }
        if let Some(help) = unit_apart(text, start, end).filter(|_| finding.code == Code::SYNTAX) {
            finding.help = Some(help.to_owned());
            continue;
        }
        if let Some(help) =
            without_set(&finding.message, text, start).filter(|_| finding.code == Code::UNKNOWN_KEYWORD)
        {
            finding.help = Some(help);
            finding.fix = None;
            continue;
        }
        // What is said of a sign already, knows more of what stands around it.
        let is_open = finding.fix.is_none()
            && finding.help.as_ref().is_none_or(|help| {
                ["write for example", "a declaration ends before this"]
                    .iter()
                    .any(|open| help.starts_with(open))
            });
        let habit = HABITS.iter().find(|(habit, told, _)| match told {
            Told::Name => finding.code == Code::UNKNOWN_NAME && text.get(start..end) == Some(habit),
            Told::Function => {
                finding.message.starts_with("unknown function") && text.get(start..end) == Some(habit)
            }
            Told::Unit => finding.code == Code::UNKNOWN_UNIT && text.get(start..end) == Some(habit),
            Told::Type => finding.code == Code::UNKNOWN_TYPE && text.get(start..end) == Some(habit),
            Told::Field => {
                let is_body = ["a part has no", "an actuator has no"]
                    .iter()
                    .any(|owner| finding.message.starts_with(owner));
                let is_field = text.get(..start).is_some_and(|before| !before.ends_with('.'));
                is_body && is_field && finding.fix.is_none() && text.get(start..end) == Some(habit)
            }
            Told::Opening => finding.code == Code::UNKNOWN_KEYWORD && text.get(start..end) == Some(habit),
            Told::Word => {
                [Code::SYNTAX, Code::UNKNOWN_KEYWORD].contains(&finding.code)
                    && text.get(start..end) == Some(habit)
            }
            Told::Sign => is_open && finding.code == Code::SYNTAX && is_at(text, start, habit),
            Told::Line => {
                let unread = [Code::SYNTAX, Code::UNKNOWN_KEYWORD].contains(&finding.code);
                unread && finding.fix.is_none() && line(text, start).contains(habit)
            }
        });
        if let Some((_, _, help)) = habit {
            finding.help = Some((*help).to_owned());
            finding.fix = None;
        }
    }
}

/// How far around a finding a habit is looked for, in bytes.
const AROUND: usize = 2000;

/// The text around a finding, and where the finding begins and ends in it, so that the costs of a finding do not grow
/// with the text.
fn around(text: &str, finding: Range<usize>) -> (&str, usize, usize) {
    let cut = |place: usize| {
        let place = place.min(text.len());
        (place..=text.len()).find(|place| text.is_char_boundary(*place)).unwrap_or(text.len())
    };
    let from = cut(finding.start.saturating_sub(AROUND));
    let to = cut(finding.end.min(finding.start + AROUND) + AROUND);
    (text.get(from..to).unwrap_or(""), finding.start - from, finding.end - from)
}

/// Declarations that give a name to something.
const NAMED: &[&str] = &[
    "grammar",
    "variant",
    "param",
    "let",
    "part",
    "actuator",
    "cell",
    "rule",
    "require",
    "prefer",
    "pattern",
    "actuation",
    "term",
    "task",
    "model",
    "search",
    "scenarios",
    "target",
    "table",
    "example",
    "observe",
    "shared",
    "vary",
    "sense",
    "state",
    "policy",
    "action",
];

/// What helps where the parts of a line are there, but in another form or order: `rule add-leg`, `0:90:270 deg`,
/// `param n : Count = 4 in 1 .. 20`, `shared side : Bool in { false, true }`, `use codesign { cube }`.
fn form(text: &str, place: usize) -> Option<String> {
    let (before, after) = (text.get(..place)?, text.get(place..)?);
    let line = line(text, place).trim();
    let mut words = line.split_whitespace();
    let (first, second) = (words.next()?, words.next().unwrap_or(""));
    let is_letter = |c: Option<char>| c.is_some_and(char::is_alphabetic);
    if after.starts_with('-') && is_letter(before.chars().next_back()) && is_letter(after.chars().nth(1)) {
        let is_name = NAMED.contains(&first) && second.contains('-');
        return is_name
            .then(|| format!("a name cannot contain a hyphen: write `{}`", second.replace('-', "_")));
    }
    let is_digit = |c: Option<char>| c.is_some_and(|c| c.is_ascii_digit());
    if after.starts_with(':') && is_digit(before.chars().next_back()) && is_digit(after.chars().nth(1)) {
        let number = |c: char| c.is_ascii_digit() || c == '.' || c == '-';
        let low = before.rsplit(|c| !number(c)).next()?;
        let rest = after.get(1..)?;
        let high = rest.split(|c| !number(c)).next()?;
        if !rest.get(high.len()..).is_some_and(|more| more.starts_with(':')) {
            return Some(format!("write a range with two dots: `{low} .. {high}`"));
        }
        return Some(
            "write single values as a set, `{ 0 deg, 90 deg, 180 deg }`, and a range as `0 deg .. 180 deg`"
                .to_owned(),
        );
    }
    if after.starts_with("for ") && matches!(first, "remove" | "replace") {
        return Some(format!(
            "`{first}` cannot have `for`: write one line for each part, or let the search apply the rule several times"
        ));
    }
    if after.starts_with("for ") && first == "place" {
        return Some("`place` cannot have `for`: write one line for each part".to_owned());
    }
    let open = |sign: char| before.rsplit('\n').next().is_some_and(|line| line.contains(sign));
    if after.starts_with("for ") && (open('(') || open('[')) {
        return Some("to add up over many parts, write `sum over p in part of p.mass`".to_owned());
    }
    if first == "param"
        && let Some((head, rest)) = line.split_once(" = ")
        && let Some((value, domain)) = rest.split_once(" in ")
    {
        return Some(format!("the domain comes before the value: write `{head} in {domain} = {value}`"));
    }
    if matches!(first, "shared" | "vary") && line.contains(": Bool in ") {
        return Some(format!("a Bool has no domain: write `{first} {second} : Bool flip 0.1`"));
    }
    if first == "actuate" && after.starts_with("for ") {
        let time = after.lines().next()?.trim();
        return Some(format!(
            "give the duration where the motion is simulated: `simulate hinge_model {time}`"
        ));
    }
    let argument = before.rsplit(['(', ',']).next().unwrap_or("").trim();
    if after.starts_with(':') && open('(') && !argument.is_empty() && argument.chars().all(is_of_name) {
        return Some(format!("a parameter is given with `=`: write `{argument} =`"));
    }
    if after.starts_with("if ") {
        let condition = after.strip_prefix("if ")?.lines().next()?.trim();
        match first {
            "match" => return Some(format!("the condition of a match follows `where`: `where {condition}`")),
            "fallback" => {
                return Some(format!("write `when` before the condition of a fallback: `when {condition}`"));
            }
            _ => {}
        }
    }
    let places =
        before.rsplit("port ").next().is_some_and(|port| port.contains(" at (") && !port.contains('\n'));
    if line.contains("port ") && places && after.starts_with(',') {
        return Some("a place is a vector: write `at vector(0 cm, 1 cm, 0 cm)`".to_owned());
    }
    let is_simulate = first == "simulate" || line.starts_with("replace simulate");
    if is_simulate && after.starts_with("and ") && line.contains(" on ") {
        return Some("separate several targets with commas: `on air, threads`".to_owned());
    }
    if first == "attach" && after.starts_with(':') {
        let rest = line.split_once(':')?.1.trim();
        return Some(format!("write `attach {rest} as {second}`"));
    }
    if first == "match"
        && !line.contains(':')
        && let Some(name) = words.next().filter(|name| name.chars().all(char::is_alphanumeric))
    {
        return Some(format!("write `match {name} : {second}`, and put other conditions after it"));
    }
    if matches!(first, "maximize" | "minimize")
        && line.matches(" in ").count() > 1
        && after.starts_with(['-', '+'])
    {
        return Some("write the unit once, at the end: `maximize travel - fall in cm`".to_owned());
    }
    if first == "use" && line.strip_prefix("use ")?.starts_with(second) && before.trim_end().ends_with("use")
    {
        let name: String = second.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
        let is_word = !name.is_empty() && name != "std";
        return is_word.then(|| format!("write `use std.{name} {{ ... }}` for a module of the library, `use \"./{name}.sgr\" {{ ... }}` for a file"));
    }
    None
}

fn is_of_name(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// What helps where a unit stands apart from its number: `box(2, 2, 2) cm`, `1 in`.
fn unit_apart(text: &str, start: usize, end: usize) -> Option<&'static str> {
    let (word, before) = (text.get(start..end)?, text.get(..start)?.trim_end());
    if before.ends_with(')')
        && word != "in"
        && word.chars().all(char::is_alphabetic)
        && crate::units::parse(word).is_ok()
    {
        return Some("a unit follows its number: `box(2 cm, 2 cm, 2 cm)`");
    }
    let inch = before.strip_suffix("in").map(str::trim_end)?;
    let is_number = inch.ends_with(|c: char| c.is_ascii_digit());
    (is_number && matches!(word, "," | ")")).then_some("1 inch is `25.4 mm`")
}

/// What helps where a value is changed without `set`.
fn without_set(message: &str, text: &str, start: usize) -> Option<String> {
    let is_block = ["clause of `rule`", "clause of `variant`"].iter().any(|block| message.contains(block));
    let line = line(text, start).trim();
    let (path, value) = line.split_once('=')?;
    let is_path = path.trim_end().chars().all(|c| c.is_alphanumeric() || "._".contains(c));
    (is_block && is_path && !value.starts_with('=')).then(|| format!("to change a value, write `set {line}`"))
}

/// Whether a sign stands at a place, or around it.
fn is_at(text: &str, place: usize, sign: &str) -> bool {
    (0..sign.len()).any(|back| {
        place.checked_sub(back).and_then(|from| text.get(from..)).is_some_and(|t| t.starts_with(sign))
    })
}

/// The line around a place, up to its comment.
fn line(text: &str, place: usize) -> &str {
    let from = text.get(..place).and_then(|before| before.rfind('\n')).map_or(0, |i| i + 1);
    let rest = text.get(from..).unwrap_or("");
    rest.split(['\n', '#', '"']).next().unwrap_or("")
}

/// What helps where a number is written as elsewhere: `.4`, `1.`, `+4`, `10_000`, `0,8`, `kg/m3`, `cm³`.
fn number(text: &str, place: usize) -> Option<String> {
    let before = text.get(..place)?;
    let after = text.get(place..)?;
    let last = before.chars().next_back();
    let mut rest = after.chars();
    let (sign, next) = (rest.next(), rest.next());
    let is_digit = |c: Option<char>| c.is_some_and(|c| c.is_ascii_digit());
    let digits = |text: &str| text.chars().take_while(char::is_ascii_digit).collect::<String>();
    let word_before =
        before.rsplit(|c: char| !(c.is_alphanumeric() || "^/*".contains(c))).next().unwrap_or("");
    let is_unit = |word: &str| crate::units::parse(word).is_ok();
    match sign {
        Some('.') if is_digit(next) && !is_digit(last) => {
            Some(format!("write `0.{}`: a number begins with a digit", digits(after.get(1..)?)))
        }
        Some('+') if is_digit(next) => {
            Some(format!("write `{}`: a number has no `+`", digits(after.get(1..)?)))
        }
        Some('_') if is_digit(last) && is_digit(next) => {
            Some("write the digits without `_`, as in `10000`".to_owned())
        }
        Some(',') if is_digit(last) && is_digit(next) => {
            let whole: String = before.chars().rev().take_while(char::is_ascii_digit).collect();
            let whole: String = whole.chars().rev().collect();
            Some(format!("write `{whole}.{}`: the decimal sign is a point", digits(after.get(1..)?)))
        }
        Some('²' | '³') if is_unit(word_before) => {
            let power = if sign == Some('²') { 2 } else { 3 };
            Some(format!("write `{word_before}^{power}`"))
        }
        Some(power @ '1'..='9') if is_unit(word_before) && !word_before.is_empty() => {
            Some(format!("write `{word_before}^{power}`"))
        }
        Some('^') => spaced_unit(before, after),
        _ if before.trim_end().ends_with('.') && !before.trim_end().ends_with("..") => {
            let whole = before.trim_end().trim_end_matches('.');
            // A name may end with a digit: `leg2.tip`.
            let is_in_word = |c: char| c.is_alphanumeric() || c == '_';
            let word = whole.trim_end_matches(is_in_word).len();
            is_digit(whole.get(word..).and_then(|word| word.chars().next())).then(|| {
                "write the number without the point at its end, or with a digit after the point: `1.0`"
                    .to_owned()
            })
        }
        _ => None,
    }
}

/// What helps where a unit has spaces: `1 g / cm^3`.
fn spaced_unit(before: &str, after: &str) -> Option<String> {
    let split = |text: &str| {
        let text = text.trim_end();
        let start = text.trim_end_matches(char::is_alphabetic).len();
        Some((text.get(..start)?.to_owned(), text.get(start..)?.to_owned()))
    };
    let is_unit = |word: &str| !word.is_empty() && crate::units::parse(word).is_ok();
    let (rest, last) = split(before)?;
    let sign = rest.trim_end().chars().next_back().filter(|sign| "*/".contains(*sign))?;
    let (_, first) = split(rest.trim_end().strip_suffix(sign)?)?;
    let power: String = after.get(1..)?.trim_start().chars().take_while(char::is_ascii_digit).collect();
    (is_unit(&first) && is_unit(&last))
        .then(|| format!("write the unit without spaces: `{first}{sign}{last}^{power}`"))
}

#[cfg(test)]
mod tests {
    use super::{HABITS, is_at, line, number};

    #[test]
    fn habits_are_there_once() {
        let mut all: Vec<String> =
            HABITS.iter().map(|(habit, told, _)| format!("{habit} {told:?}")).collect();
        all.sort_unstable();
        let count = all.len();
        all.dedup();
        assert_eq!(all.len(), count);
    }

    #[test]
    fn a_sign_is_known_from_within() {
        assert!(is_at("a ** b", 3, "**") && is_at("a ** b", 2, "**") && !is_at("a * b", 2, "**"));
        assert_eq!(line("a\nb += 1 # c += 2\nd", 3), "b += 1 ");
    }

    #[test]
    fn numbers_of_other_notations_are_known() {
        let told = |text: &str, place: usize| number(text, place).unwrap_or_default();
        assert_eq!(told("x = .4", 4), "write `0.4`: a number begins with a digit");
        assert_eq!(told("x = +4", 4), "write `4`: a number has no `+`");
        assert!(told("x = 10_000", 6).contains("10000"));
        assert_eq!(told("x = 0,8", 5), "write `0.8`: the decimal sign is a point");
        assert_eq!(told("x = 1 kg/m3", 10), "write `kg/m^3`");
        assert_eq!(told("x = 1 g/cm³", 10), "write `g/cm^3`");
        assert!(told("x = 1.", 6).contains("1.0"));
        assert_eq!(told("x = 1 g / cm^3", 12), "write the unit without spaces: `g/cm^3`");
        assert_eq!(number("x = a / b^3", 9), None);
        assert_eq!(number("x = 4 + 3", 6), None);
    }
}
