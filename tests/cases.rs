//! Bad input: every file of `cases/` says in its first line which codes it must
//! raise and where; the full text of the findings is a snapshot. That every code is raised by
//! something is the catalogue's test.
//!
//! Most files are called `DECLARATION-CLASS.sgr`: a class of mistakes in a kind of declaration or
//! clause. `docs/mistakes.md` shows them as a table, so that holes are seen. `cases/bases/` holds
//! what such files start from; nothing is wrong with it.

use grammar_lang::diagnostics::render::{Format, render};
use grammar_lang::diagnostics::{Diagnostic, apply};
use grammar_lang::source::SourceMap;
use sgc::derive::run_example;
use sgc::loader::Files;
use sgc::trials::check_motions;

use crate::support::{read, root};

/// The columns of the table of mistakes: how files call them, and how people do.
const CLASSES: &[(&str, &str)] = &[
    ("unknown", "unknown name"),
    ("duplicate", "twice"),
    ("type", "wrong type or unit"),
    ("domain", "outside its domain"),
    ("stage", "wrong stage"),
    ("unused", "unused"),
    ("never", "never possible"),
    ("missing", "something is missing"),
    ("syntax", "cannot be read"),
];

/// The rows: what a file's name begins with, and what that is in a grammar.
const DECLARATIONS: &[(&str, &str)] = &[
    ("grammar", "grammar"),
    ("allow", "allow"),
    ("use", "use"),
    ("param", "param"),
    ("part", "part"),
    ("port", "port"),
    ("actuator", "actuator"),
    ("joint", "joint"),
    ("construction", "material, chamber, thread"),
    ("field", "a field that reads another"),
    ("begins", "begins"),
    ("limb", "param of a part"),
    ("cell", "cell"),
    ("lattice", "lattice"),
    ("begin", "begin"),
    ("symmetry", "symmetry"),
    ("rule", "rule"),
    ("match", "match"),
    ("choose", "choose"),
    ("guard", "when, unless"),
    ("attach", "attach"),
    ("for", "for"),
    ("if", "if"),
    ("then", "then"),
    ("always", "always"),
    ("body", "set a parameter of the grammar"),
    ("set", "set"),
    ("remove", "remove"),
    ("replace", "replace"),
    ("revert", "revert"),
    ("fill", "fill"),
    ("paint", "paint"),
    ("clear", "clear"),
    ("weight", "weight"),
    ("fallback", "fallback"),
    ("require", "require"),
    ("prefer", "prefer"),
    ("pattern", "pattern"),
    ("actuation", "actuation"),
    ("rhythm", "shared by all actuations"),
    ("vary", "shared, vary"),
    ("per", "per"),
    ("state", "state"),
    ("memory", "state outside of actuations"),
    ("drive", "drive"),
    ("actuate", "actuate"),
    ("sense", "sense"),
    ("policy", "policy"),
    ("reward", "reward of a policy"),
    ("learner", "soft_actor_critic, double_dqn"),
    ("action", "action"),
    ("term", "term"),
    ("maximize", "maximize"),
    ("task", "task"),
    ("model", "model"),
    ("simulate", "simulate"),
    ("scenarios", "scenarios"),
    ("worlds", "over w in scenarios"),
    ("search", "search"),
    ("front", "several objectives"),
    ("table", "table"),
    ("target", "target"),
    ("prototype", "prototype"),
    ("observe", "observe"),
    ("novelty", "novelty"),
    ("let", "let"),
    ("function", "let f(x)"),
    ("enum", "enum"),
    ("record", "record"),
    ("example", "example"),
    ("variant", "variant"),
    ("variant-set", "set in a variant"),
    ("variant-narrow", "narrow"),
    ("variant-drop", "drop"),
    ("variant-replace", "replace in a variant"),
    ("variant-add", "add"),
    ("cases", "match x { ... }"),
    ("over", "forall, sum over"),
];

/// Checks a text as `sgc check` does, and its examples as `sgc test` does.
fn check(name: &str, text: &str) -> (Vec<Diagnostic>, SourceMap) {
    let mut sources = SourceMap::default();
    let entry = sources.add(name, text);
    let compiled = grammar_lang::compile(&Files, &mut sources, entry, &[], None);
    let mut found = compiled.told(check_motions(&compiled, entry, &sources));
    if compiled.offers.len() < 2 && !found.iter().any(Diagnostic::is_error) {
        found.extend(compiled.unneeded(entry));
    }
    for (name, example) in compiled.ruleset.iter().flat_map(|r| &r.examples) {
        found.extend(compiled.ruleset.iter().filter_map(|r| run_example(r, name, example).err()).map(|e| *e));
    }
    // What `sgc test` reports as an error, `sgc check` warns of.
    let fails = found.iter().any(|told| told.code.id == "E0603");
    found.retain(|told| !fails || told.code.id != "W0747");
    found.sort_by_key(|d| (d.span().file, d.span().start, d.code.id));
    (found, sources)
}

fn cases() -> Vec<std::path::PathBuf> {
    let mut cases: Vec<_> = std::fs::read_dir(root().join("tests/cases"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "sgr"))
        .collect();
    cases.sort();
    cases
}

#[test]
fn each_case_raises_what_it_says_where_it_says() {
    for path in cases() {
        let text = std::fs::read_to_string(&path).unwrap();
        let expected = text.lines().next().and_then(|l| l.strip_prefix("# expect: ")).expect("a first line");
        let (found, sources) = check(&path.to_string_lossy(), &text);
        let here = path.to_string_lossy();
        let got: Vec<String> = found
            .iter()
            .map(|d| {
                let (line, column) = sources.line_column(d.span());
                let name = &sources.get(d.span().file).unwrap().name;
                let place = if *name == here {
                    String::new()
                } else {
                    format!("{} ", name.rsplit('/').next().unwrap())
                };
                format!("{} {place}{line}:{column}", d.code.id)
            })
            .collect();
        let got = if got.is_empty() { "nothing".to_owned() } else { got.join(", ") };
        assert_eq!(got, expected, "{}", path.display());
    }
}

#[test]
fn nothing_is_wrong_with_what_cases_start_from() {
    assert_eq!(sgc::testing::findings(root().join("tests/cases/bases/worm.sgr")), sgc::testing::CLEAN);
}

/// The codes that a case says it raises, each once.
fn codes_of(path: &std::path::Path) -> String {
    let text = std::fs::read_to_string(path).unwrap();
    let first = text.lines().next().unwrap_or("").to_owned();
    let mut codes: Vec<&str> =
        first.split([' ', ',']).filter(|word| grammar_lang::diagnostics::find(word).is_some()).collect();
    codes.sort_unstable();
    codes.dedup();
    codes.join(" ")
}

/// The table of mistakes as `docs/mistakes.md` shows it.
fn table() -> String {
    let heads: Vec<&str> = CLASSES.iter().map(|(_, head)| *head).collect();
    let mut table = format!("| | {} |\n|---|{}\n", heads.join(" | "), "---|".repeat(heads.len()));
    for (declaration, written) in DECLARATIONS {
        let cells = CLASSES.iter().map(|(class, _)| {
            let file = format!("tests/cases/{declaration}-{class}.sgr");
            let path = root().join(&file);
            if path.exists() { format!("[{}](../{file})", codes_of(&path)) } else { String::new() }
        });
        table += &format!("| `{written}` | {} |\n", cells.collect::<Vec<_>>().join(" | "));
    }
    table
}

#[test]
fn the_table_of_mistakes_is_that_of_the_files() {
    let table = table();
    assert!(read("docs/mistakes.md").contains(&table), "docs/mistakes.md must hold\n{table}");
}

#[test]
fn findings_read_well() {
    for path in cases() {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        insta::with_settings!({ prepend_module_to_snapshot => false, omit_expression => true }, {
            let mut text = sgc::testing::findings(&path);
            // An example is wrong only when it is derived.
            if text == sgc::testing::CLEAN && name.starts_with("example-") {
                text = sgc::testing::example(&path, "one");
            }
            insta::assert_snapshot!(format!("case-{name}"), text);
        });
    }
}

#[test]
fn five_planted_errors_are_reported_in_one_run() {
    let (found, _) =
        check("five", &std::fs::read_to_string(root().join("tests/cases/five-errors.sgr")).unwrap());
    assert!(found.len() >= 5, "{found:?}");
    let codes: std::collections::BTreeSet<_> = found.iter().map(|d| d.code.id).collect();
    assert_eq!(codes.len(), 5, "five different kinds: {codes:?}");
}

#[test]
fn machine_formats_hold_code_place_and_help() {
    let (found, sources) = check("x.sgr", "let a = 3 gg\n");
    assert_eq!(
        render(&found, &sources, Format::Concise, false),
        "x.sgr:1:11: error[E0303] unknown unit `gg`; help: did you mean `g`?\n"
    );
    let json: serde_json::Value =
        serde_json::from_str(&render(&found, &sources, Format::Json, false)).unwrap();
    assert_eq!(json["code"], "E0303");
    assert_eq!(json["labels"][0]["line"], 1);
    assert_eq!(json["labels"][0]["start"], 10);
    assert_eq!(json["help"], "did you mean `g`?");
}

#[test]
fn a_parameter_that_does_not_exist_or_fit_is_refused() {
    for (name, value, code) in [
        ("max_part", "3", "E0207"),
        ("max_parts", "three", "E0304"),
        ("max_parts", "3 mm", "E0304"),
        ("max_parts", "99", "E0309"),
        ("max_parts", "2.5", "E0304"),
        ("max_parts", "5e", "E0304"),
        ("max_parts", "1e3", "E0309"),
    ] {
        let mut sources = SourceMap::default();
        let path = root().join("grammars/codesign.sgr");
        let entry = sources.add(path.to_string_lossy(), std::fs::read_to_string(&path).unwrap());
        let compiled =
            grammar_lang::compile(&Files, &mut sources, entry, &[(name.into(), value.into())], None);
        let codes: Vec<_> = compiled.diagnostics.iter().map(|d| d.code.id).collect();
        assert_eq!(codes, [code], "-p {name}={value}");
        assert!(compiled.ruleset.is_none());
    }
}

proptest::proptest! {
    /// Whatever the text, checking ends with findings, not with a panic.
    #[test]
    fn arbitrary_text_never_panics(text in "\\PC{0,200}") {
        check("any", &text);
    }

    /// A real grammar with a piece cut out, doubled or replaced never panics, its findings can be
    /// drawn, and each fix that is offered can be applied.
    #[test]
    fn mutated_grammars_never_panic(from in 0usize..2600, length in 0usize..60, insert in "[ -~\n]{0,12}") {
        let text = std::fs::read_to_string(root().join("grammars/codesign.sgr")).unwrap();
        let from = from.min(text.len());
        let to = (from + length).min(text.len());
        let mutated = format!("{}{insert}{}", &text[..from], &text[to..]);
        let (found, sources) = check("mutated", &mutated);
        let text = render(&found, &sources, Format::Full, false);
        proptest::prop_assert_eq!(text.is_empty(), found.is_empty());
        for fix in found.iter().filter_map(|d| d.fix.as_ref()) {
            let file = sources.get(fix.edits[0].span.file).unwrap();
            proptest::prop_assert!(apply(&file.text, &fix.edits).is_some(), "{:?}", fix);
        }
    }
}
