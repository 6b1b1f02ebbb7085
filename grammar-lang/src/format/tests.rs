//! Layouts of small texts, and what holds for every text.

use super::*;

fn try_format(text: &str) -> Result<String, Unformatted> {
    let mut sources = SourceMap::default();
    let file = sources.add("test", text);
    format(&sources, file)
}

/// Lays out a text that has no error; doing it again must change nothing.
fn formatted(text: &str) -> String {
    let once = try_format(text).unwrap_or_else(|why| panic!("{why:?}\n{text}"));
    let twice = try_format(&once).unwrap_or_else(|why| panic!("{why:?}\n{once}"));
    assert_eq!(once, twice, "the layout of\n{text}");
    once
}

static TEXTS: std::sync::LazyLock<Vec<String>> = std::sync::LazyLock::new(texts);

/// Every text of the project: the library, the grammars, the cases that have the right form, and the
/// blocks of the documentation.
fn texts() -> Vec<String> {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut paths: Vec<_> = ["std-rules", "grammars", "tests/cases", "docs"]
        .iter()
        .flat_map(|folder| std::fs::read_dir(root.join(folder)).unwrap())
        .map(|entry| entry.unwrap().path())
        .collect();
    paths.sort();
    let mut texts = vec![EVERYTHING.to_owned(), LONG.to_owned()];
    for path in paths {
        let Ok(text) = std::fs::read_to_string(&path) else { continue };
        match path.extension().and_then(|e| e.to_str()) {
            Some("sgr") => texts.push(text),
            Some("md") => {
                let blocks = text.split("```sgr\n").skip(1);
                texts.extend(blocks.filter_map(|b| b.split("```").next()).map(str::to_owned));
            }
            _ => {}
        }
    }
    texts.retain(|text| !matches!(try_format(text), Err(Unformatted::Errors(_))));
    assert!(texts.len() > 30, "only {} texts", texts.len());
    texts
}

/// Every kind of clause and expression.
const EVERYTHING: &str = r##"
grammar everything
use "./other.sgr" { one, two, }
use std.blocks
param a : Length in 1 mm .. 2 mm = 1.5 mm
symmetry mirror xy
part p { shape = box(1 cm, 2 cm, 3 cm) density = 1 g/cm^3 colour = "#fff # not a comment" }
actuator q { param x : Pattern = rest segment = cylinder(1 cm, 2 cm) }
begin { place core : p }
rule nothing_else { match nothing when true weight 2 * temperature }
rule all {
  match s : part with free port f where not s is core and s.turn != -3 deg
  choose n in { 1, 2 } + [3] unless exists b in part, c in neighbours(b) where b is not c: c is block
  attach q(x = rest) to f turned 90 deg set s.turn = -s.turn for i in 0 .. 2, j in 0 .. i { attach q to s.front[i] as m set m.turn = 1 deg } revert s
}
actuation w for a : actuator {
  shared p : Time in 1 s .. 2 s mutate 0.5 by normal(0 s, 1 s) bound clamp
  vary l[4] : Bool flip 0.1 let s = l[0] drive angle = if l[1] then -1 else (s - 1) * 3 %
}
actuate q with w simulate m for 20 s
model m { deep { deeper { x = 3 } } step = 1 s / 240
}
term t : Length = max over e in elements where e is p of height(e.position at end) otherwise 0 cm
minimize t in cm
search s search s { keep = 80 % }
let f = bezier([0, 0, 1,])(0.5)
"##;

/// Lines that do not fit.
const LONG: &str = r#"
require long : count(part) <= max_parts and count(actuator) <= max_actuators because "both of them cost time to simulate"
require longer : forall a in actuator, n in neighbours(a): n is block and n is not core and n.turn > 30 deg or n.turn < -30 deg
use "./other.sgr" { one_name, another_name, a_third_name, a_fourth_name, a_fifth_name, a_sixth_name, a_seventh_name }
let x = first_summand * some_factor + second_summand * another_factor - third_summand / some_divisor + fourth
let y = if some_condition and another_condition then the_value_of_the_first_branch else if yet_another_condition then the_second else the_third_of_them
let z = bezier([0.123456, 0.234567, 0.345678, 0.456789, 0.567891, 0.678912, 0.789123, 0.891234, 0.912345])(cycle + 0.5)
let w = the_name_of_some_function_that_is_called(the_first_of_its_arguments, the_second_of_its_argume)
let deep = outer(inner_one(aaaaaaaaaaaaaaaaaaaaaa, bbbbbbbbbbbbbbbbbbbbbbbbbb), inner_two(cccccccccccccccccccccccc, ddddddddddddddddddddd, eeeeeeeeeeeeeeeeeeeeeeee, ffffffffffffffffffffffff), g)
rule r {
  match p : part with free port q where count(neighbours(p)) > 3 and p is not core and p.turn > some_angle
  attach some_actuator(segments = n, rhythm = what) to some_port_with_a_long_name turned some_angle + another
}
"#;

#[test]
fn every_text_of_the_project_can_be_laid_out() {
    TEXTS.iter().for_each(|text| drop(formatted(text)));
}

#[test]
fn every_kind_of_clause() {
    let out = formatted(EVERYTHING);
    insta::assert_snapshot!(out);
}

#[test]
fn comments_stay_where_they_are() {
    let out = formatted(
        r#"# first

## Documents the rule.
rule r { # after the brace


  # before a clause
  match p : part   # after a clause
  # in the middle

  # of a block
  choose n in { # in a set
    1, # one
    # before two
    2
    # last of the set
  } 
  when a # left
    # before the operator
    and b # right
  attach f({ 1, # inside an inner set
    2 }, n) to q ## not documentation

  # before the end
} # after the end
rule empty { # nothing
  # at all
}
rule # after the keyword
  odd
  # before the brace
  { match nothing }


# last"#,
    );
    insta::assert_snapshot!(out);
}

#[test]
fn long_lines_are_broken_at_their_outermost_places() {
    let out = formatted(LONG);
    insta::assert_snapshot!(out);
}

#[test]
fn consecutive_lines_are_tables() {
    let out = formatted(
        r#"
use std.blocks {cube}
use std.objectives {travel,fall}
use "./a.sgr" {
  b,
  c, d,
}
use std.models { hinge_model }
param n : Count = 3
param length : Length in 1 mm .. 2 mm = 1.5 mm
# A comment does not end a table.
param on : Bool

param after_a_blank_line : Count = 3
let a = 1   # one
let bcd = 2 # two

let e = 3 # three
maximize n in cm
search s
model m {
  step = 1 s / 240
  list = [1,
  ]
  control_every = 3
  inner { a = 1 }
  b = 2
}
"#,
    );
    insta::assert_snapshot!(out);
}

#[test]
fn line_ends_marks_and_tabs_become_plain() {
    let text =
        "\u{FEFF}grammar g\r\n\r\n\r\n\r\nrule r {\r\n\r\n\tmatch nothing # why \t\r\n\r\n}\r\n\r\n\r\n";
    assert_eq!(formatted(text), "grammar g\n\nrule r {\n  match   nothing   # why\n}\n");
    assert_eq!(formatted("let a=3"), "let a = 3\n");
}

#[test]
fn a_text_with_errors_is_refused_with_them() {
    for text in ["rule r {", "let a = ", "# only a comment", "grammar g \0", "let a = 1e999"] {
        assert!(matches!(try_format(text), Err(Unformatted::Errors(found)) if !found.is_empty()), "{text}");
    }
}

#[test]
fn the_table_names_pairs_of_the_grammar() {
    let grammar = include_str!("../syntax/grammar.pest");
    let defined: Vec<&str> = grammar.lines().filter_map(|l| l.split(" =").next()).map(str::trim).collect();
    let tables = table::TABLES.iter().flat_map(|t| t.rows.iter().chain(t.columns.iter().copied().flatten()));
    let lines = table::FIRST_WORDS.iter().map(|(name, _)| name);
    let signs = table::PREFIXES.iter().chain(table::SUFFIXES).map(|(name, _)| name);
    // Levels of expressions have a file of their own.
    let levels = include_str!("../syntax/levels.rs");
    for name in tables.chain(lines).chain(signs).chain(table::BREAK_BEFORE) {
        assert!(defined.contains(name) || levels.contains(&format!("\"{name}\"")), "{name}");
    }
}

#[test]
fn spaces_and_the_ends_of_lines_make_no_difference() {
    for (text, indent) in TEXTS.iter().zip(["", " ", "\t", "      "].iter().cycle()) {
        let other: String = text.lines().map(|line| format!("{indent}{}  \r\n", line.trim())).collect();
        assert_eq!(formatted(&other), formatted(text));
    }
}

/// What may stand between two tokens.
const BETWEEN: &[&str] = &[
    " ",
    " ",
    " ",
    "\n",
    "\t",
    "\r\n",
    "   ",
    "\n\n\n",
    "\n  \n",
    " # a note \n",
    "\n# a note\n",
    "\n\n## a longer note\n\n# and another\n",
    "\u{FEFF}",
];

/// The same tokens and comments with other space and further comments between them.
fn shaken(text: &str, choices: &[usize]) -> String {
    let tree = syntax::tree(text).unwrap();
    let mut comments = tree.comments.iter().peekable();
    let mut choices = choices.iter().cycle();
    let mut out = String::new();
    for (i, token) in tree.leaves.iter().enumerate() {
        while let Some(comment) = comments.next_if(|c| c.start < token.start) {
            out += &format!("{}\n", comment.text);
        }
        // A unit stands on the line of its number, and no other word does.
        let is = |token, rule| tree.beginning_with(token).next().is_some_and(|pair| pair == rule);
        let separator = BETWEEN[*choices.next().unwrap() % BETWEEN.len()];
        let after_number = i > 0 && is(i - 1, "number") && token.text.starts_with(char::is_alphabetic);
        out += match (is(i, "unit_text"), after_number) {
            (true, _) => " ",
            (_, true) if !separator.contains('\n') => "\n",
            _ => separator,
        };
        out += token.text;
    }
    out
}

proptest::proptest! {
    #![proptest_config(proptest::prelude::ProptestConfig::with_cases(400))]

    /// Whatever stands between the tokens: nothing is lost (`format` itself compares),
    /// and a layout is its own layout.
    #[test]
    fn any_space_and_comments_between_tokens(
        which in 0usize..1000,
        choices in proptest::collection::vec(0usize..1000, 1..80),
    ) {
        formatted(&shaken(&TEXTS[which % TEXTS.len()], &choices));
    }
}
