//! Texts that nobody means well with, or that a strange editor has saved: they do no harm, and what
//! is mere layout changes nothing.

use std::fmt::Write as _;
use std::io::Write as _;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use cpu_time::ThreadTime;

use grammar_lang::diagnostics::Diagnostic;
use grammar_lang::diagnostics::render::{Format, render};
use grammar_lang::eval::Budget;
use grammar_lang::ir::RuleSet;
use grammar_lang::source::{FileId, Loader, NoModule, Source, SourceMap};
use grammar_lang::{Compiled, compile, testing};
use sgc::loader::Frozen;

use crate::fuzz::mutate::{Random, gently, mutated};
use crate::fuzz::{corpus, holds};
use crate::support::{GRAMMARS, codesign, is_long, read, root};

#[allow(dead_code)]
#[path = "../benches/check/grown.rs"]
mod grown;

/// What must hold of a text whatever.
fn held(loader: &Frozen, text: &str) -> Result<(), String> {
    holds::reached(loader, text).map(drop)
}

fn compiled(text: &str) -> (Compiled, SourceMap) {
    let mut sources = SourceMap::default();
    let file = sources.add("grammars/hostile.sgr", text);
    (compile(&holds::loader(), &mut sources, file, &[], None), sources)
}

/// Codes with their places, in the order of the text.
fn places(text: &str) -> Vec<(String, (usize, usize))> {
    let (compiled, sources) = compiled(text);
    let mut found: Vec<&Diagnostic> = compiled.diagnostics.iter().collect();
    found.sort_by_key(|d| (d.span().file, d.span().start, d.code.id));
    found.into_iter().map(|d| (d.code.id.to_owned(), sources.line_column(d.span()))).collect()
}

fn rules(text: &str) -> String {
    let rules = compiled(text).0.ruleset;
    rules.as_ref().map_or(String::new(), testing::rule_set)
}

/// The grammars, and a text with errors of all kinds.
fn samples() -> Vec<String> {
    let errors = read("tests/cases/five-errors.sgr");
    GRAMMARS.iter().map(|path| read(path)).chain([errors]).collect()
}

#[test]
fn what_was_found_once_holds_now() {
    let loader = holds::loader();
    for entry in std::fs::read_dir(root().join("tests/fuzz/found")).into_iter().flatten() {
        let path = entry.unwrap().path();
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(held(&loader, &text), Ok(()), "{}", path.display());
    }
}

#[test]
fn ends_of_lines_tabs_and_a_mark_at_the_start_change_nothing() {
    for text in samples() {
        let (plain, places_of) = (rules(&text), places(&text));
        let windows = text.replace('\n', "\r\n");
        assert_eq!((rules(&windows), places(&windows)), (plain.clone(), places_of.clone()));
        let cut = text.trim_end();
        assert_eq!((rules(cut), places(cut)), (plain.clone(), places_of.clone()));
        let tabs = text.replace("  ", "\t");
        assert_eq!(rules(&tabs), plain);
        let codes = |places: Vec<(String, _)>| places.into_iter().map(|(code, _)| code).collect::<Vec<_>>();
        assert_eq!(codes(places(&tabs)), codes(places_of.clone()));
        // The mark that some editors put at the start of a file is a character of its first line.
        let marked = format!("\u{FEFF}{text}");
        assert_eq!(rules(&marked), plain);
        let moved = |(code, (line, column)): (String, (usize, usize))| {
            (code, (line, column + usize::from(line == 1)))
        };
        assert_eq!(places(&marked), places_of.into_iter().map(moved).collect::<Vec<_>>());
    }
}

#[test]
fn columns_count_characters_of_any_width() {
    let after = |start: &str| places(&format!("{start}let a = bb\n")).last().unwrap().1.1;
    for text in ["äö", "e\u{301}", "😀😀", "𝔘", "日本語"] {
        let text = format!("let c = \"{text}\" ");
        assert_eq!(after(&text), text.chars().count() + 9, "{text}");
    }
}

#[test]
fn strange_characters_are_told_where_they_stand_and_do_no_harm() {
    let strange = [
        "\u{200B}", "\u{202E}", "\u{2066}", "\u{301}", "\u{FEFF}", "\0", "\u{0C}", "\u{0B}", "😀", "\u{FFFD}",
    ];
    for text in samples() {
        for character in strange {
            for part in 0..7 {
                let mut at = text.len() * part / 7;
                while !text.is_char_boundary(at) {
                    at += 1;
                }
                let text = format!("{}{character}{}", &text[..at], &text[at..]);
                assert_eq!(held(&holds::loader(), &text), Ok(()), "{character:?} at {at}");
            }
        }
    }
}

#[test]
fn numbers_of_any_size_do_no_harm() {
    let loader = holds::loader();
    let numbers = ["1e308", "1e-320", "99999999999999999999999", "1e999", "0", "9007199254740993", "1e15"];
    let text = codesign();
    let places: Vec<usize> = text.match_indices(|c: char| c.is_ascii_digit()).map(|(i, _)| i).collect();
    for (i, place) in places.into_iter().enumerate() {
        let number = numbers[i % numbers.len()];
        let text = format!("{}{number}{}", &text[..place], &text[place + 1..]);
        assert_eq!(held(&loader, &text), Ok(()), "{number} at {place}");
    }
}

/// Fails if checking and showing a text takes long; what is found otherwise.
fn soon(what: &str, text: &str) -> Vec<Diagnostic> {
    // Of this thread alone: the machine may have other work.
    let start = ThreadTime::now();
    let (compiled, sources) = compiled(text);
    for format in [Format::Full, Format::Concise, Format::Sarif] {
        let _ = render(&compiled.diagnostics, &sources, format, false);
    }
    // Ten times what it takes on a slow machine: what is not linear takes minutes.
    assert!(start.elapsed() < Duration::from_secs(30), "{what} takes {:?}", start.elapsed());
    compiled.diagnostics
}

/// So many times a line, with its number in the place of `@`.
fn many(count: usize, line: &str) -> String {
    (0..count).fold(String::new(), |mut text, i| {
        let _ = writeln!(text, "{}", line.replace('@', &i.to_string()));
        text
    })
}

#[test]
fn large_texts_take_no_longer_than_their_length() {
    let rule = "rule r_@ {\n  match p : part with free port q\n  atach cube to q\n}";
    for (what, text, least) in [
        ("a megabyte of words", "what is this ".repeat(80_000), 1),
        ("a megabyte of signs", "(]}{[)=, \n".repeat(100_000), 1),
        ("a megabyte in one line", "let a = 1 ".repeat(100_000), 1),
        ("unknown names", many(20_000, "let a_@ = b_@"), 20_000),
        ("unknown words", many(20_000, "rul r_@ { }"), 1001),
        ("broken rules", many(5_000, rule), 1001),
        ("rules that are not closed", many(5_000, "rule r_@ {\n  match p : part"), 1001),
        ("unknown names of long lines", many(20_000, "term a_@ : Number = 1 + 2 + foo_@"), 20_000),
        ("unknown fields", format!("part a {{\n{}}}\n", many(20_000, "  mas_@ = 3 mm")), 20_000),
        ("open texts", many(20_000, "let a_@ = \"abc"), 20_000),
        ("one name declared often", many(20_000, "let a = 1"), 19_999),
        ("one long sum", format!("let a = {}1\n", "1 + ".repeat(100_000)), 1),
        ("one long list", format!("let a = [{}1]\n", "1, ".repeat(100_000)), 1),
        ("one long rule", format!("rule r {{\n{}}}\n", many(900, "  choose n_@ in 1 .. m_@")), 900),
        ("a rule beyond its limit", format!("rule r {{\n{}}}\n", many(5_000, "  choose n_@ in 1 .. m_@")), 1),
        ("brackets", "(".repeat(100_000), 1),
        ("blocks", "part a { ".repeat(50_000), 1),
        ("groups", format!("part a {{ {}", "outer { ".repeat(50_000)), 1),
        ("prefixes", format!("let a = {}1", "- not ".repeat(50_000)), 1),
        ("branches", format!("let a = {}1", "if true then 1 else ".repeat(50_000)), 1),
        ("members", format!("let a = b{}", ".c".repeat(100_000)), 1),
        ("variants", many(10_000, "variant v_@ of v_@ { drop a_@ }"), 1),
    ] {
        let found = soon(what, &text);
        assert!(found.len() >= least, "{what}: {} found", found.len());
    }
}

/// Parts, rules and whatever else, as a grammar.
fn sound(rest: &str) -> String {
    format!(
        "grammar many\n\nuse std.blocks {{ cube, ball }}\nuse std.models {{ hinge_model }}\n\
         use std.objectives {{ travel }}\nuse std.search {{ nested_annealing }}\n\n\
         begin {{\n  place core : cube\n}}\n\n{rest}\n\
         simulate hinge_model for 20 s\nmaximize travel in cm\nsearch nested_annealing\n"
    )
}

/// Kinds of parts.
fn kinds(count: usize) -> String {
    many(count, "part k_@ {\n  shape = box(4 cm, 2 cm, 2 cm)\n  mass  = 8 g\n  friction = 0.8\n}")
}

/// A long grammar without a mistake, of several kinds.
fn long_and_sound(kind: usize, count: usize) -> String {
    let attach = "rule add_@ {\n  match  p : part with free port q\n  attach k_@ to q\n}";
    match kind {
        0 => grown::grammar(count * 20, grown::Flaw::None),
        // Each rule needs what the next one makes.
        1 => {
            let rule = |i: usize| {
                let needs = if i + 1 == count { "cube".to_owned() } else { format!("k_{}", i + 1) };
                format!("rule r_{i} {{\n  match  p : {needs} with free port q\n  attach k_{i} to q\n}}\n")
            };
            sound(&(kinds(count) + &(0..count).map(rule).collect::<String>()))
        }
        // One choice among all kinds, and a rule for each of them.
        2 => {
            let all: Vec<String> = (0..count).map(|i| format!("k_{i}")).collect();
            let one = format!(
                "rule any {{\n  match  p : part with free port q\n  choose w in {{ {} }}\n  attach w to q\n}}\n",
                all.join(", ")
            );
            sound(&(kinds(count) + &one + &many(count, "rule take_@ {\n  match  p : k_@\n  remove p\n}")))
        }
        // Requirements that have to do with each other, one after the other.
        _ => {
            let require =
                |i: usize| format!("require r_{i} : count(k_{i}) + count(k_{}) <= 20\n", (i + 1) % count);
            sound(&(kinds(count) + &many(count, attach) + &(0..count).map(require).collect::<String>()))
        }
    }
}

#[test]
fn a_file_has_a_thousand_variants_at_most() {
    let text = read("grammars/codesign.sgr");
    let all = |count: usize| text.clone() + &many(count, "\nvariant v_@ of codesign {}");
    let has_limit = |count: usize| {
        let (compiled, _) = compiled(&all(count));
        let told =
            compiled.diagnostics.iter().find(|d| d.message.contains("at most 1000 grammars and variants"));
        told.is_some()
    };
    assert!(!has_limit(999) && has_limit(1000), "codesign is one of them");
}

/// How long so many checks of a sound rule set take.
fn lint_time(rules: &RuleSet, times: usize) -> Duration {
    let start = Instant::now();
    for _ in 0..times {
        let own = grammar_lang::lint::Own { entry: FileId(0), is_varied: false };
        grammar_lang::lint::run(rules, None, own, &Budget::of_file(), &mut Vec::new());
    }
    start.elapsed()
}

#[test]
fn checks_of_a_sound_grammar_take_no_longer_than_its_length() {
    const LONGER: usize = 8;
    for kind in 0..4 {
        let [few, many] = [50, 50 * LONGER].map(|count| {
            let (compiled, _) = compiled(&long_and_sound(kind, count));
            compiled.ruleset.unwrap_or_else(|| panic!("{kind}: {:?}", compiled.diagnostics.first()))
        });
        // What is linear takes as long once as eight times for an eighth of it, what is quadratic eight
        // times as long. Others may use the machine at the same time: it is enough to be right once.
        let growth = || lint_time(&many, 1).as_secs_f64() / lint_time(&few, LONGER).as_secs_f64();
        assert!((0..8).any(|_| growth() < 3.0), "text {kind}: {}", growth());
    }
}

#[test]
fn braces_that_are_missing_are_told_one_by_one() {
    let found = soon("missing braces", &many(100, "rule r_@ {\n  match p : part\n"));
    let unclosed = found.iter().filter(|d| d.code.id == "E0104").count();
    assert_eq!(unclosed, 100, "{:?}", found.first());
}

#[test]
fn more_findings_than_anyone_reads_are_counted() {
    let (compiled, sources) = compiled(&many(700, "let a_@ = b_@"));
    let text = render(&compiled.diagnostics, &sources, Format::Full, false);
    let more = compiled.diagnostics.len() - 500;
    assert!(
        text.ends_with(&format!("and {more} more: these are the first 500\n")),
        "{}",
        &text[text.len() - 90..]
    );
}

proptest::proptest! {
    #![proptest_config(proptest::test_runner::Config { cases: if is_long() { 5000 } else { 150 }, ..Default::default() })]

    /// Whatever the bytes, checking ends with findings.
    #[test]
    fn arbitrary_bytes_do_no_harm(bytes in proptest::collection::vec(proptest::num::u8::ANY, 0..400)) {
        let text = String::from_utf8_lossy(&bytes);
        proptest::prop_assert_eq!(held(&holds::loader(), &text), Ok(()));
    }

    /// Real grammars with words, signs, numbers and lines deleted, doubled, moved and put in.
    #[test]
    fn mutated_grammars_do_no_harm(seed in proptest::num::u64::ANY) {
        static CORPUS: std::sync::LazyLock<Vec<String>> = std::sync::LazyLock::new(corpus::texts);
        let mut random = Random(seed);
        let text = random.pick(&CORPUS).clone();
        let text = mutated(&text, &CORPUS, &mut random);
        proptest::prop_assert_eq!(held(&holds::loader(), &text), Ok(()), "{}", text);
    }
}

#[test]
fn small_mutations_of_sound_grammars_reach_the_engine() {
    let (loader, mut random) = (holds::loader(), Random(3));
    let sound: Vec<String> = GRAMMARS.iter().map(|path| read(path)).collect();
    let mut reached = holds::Reached::default();
    for _ in 0..if is_long() { 2000 } else { 60 } {
        let text = gently(random.pick::<String>(&sound), &mut random);
        reached += holds::reached(&loader, &text).unwrap_or_else(|why| panic!("{why}:\n{text}"));
    }
    assert!(reached.derived > 15, "{reached:?}");
}

/// What `sgc check` writes about a text on its standard input.
fn sgc_check(arguments: &[&str], text: &str) -> String {
    let mut child = Command::new(env!("CARGO_BIN_EXE_sgc"))
        .arg("check")
        .args(arguments)
        .arg("-")
        .current_dir(root().join("grammars"))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all(text.as_bytes()).unwrap();
    String::from_utf8(child.wait_with_output().unwrap().stdout).unwrap()
}

#[test]
fn mending_leads_to_no_more_errors_whatever_the_text() {
    let corpus = corpus::texts();
    let errors =
        |text: &str| sgc_check(&["--format", "json"], text).matches("\"severity\":\"error\"").count();
    let mut mended_any = 0;
    for seed in 0..if is_long() { 1000 } else { 60 } {
        let mut random = Random(seed);
        let text = mutated(random.pick::<String>(&corpus), &corpus, &mut random);
        let mended = sgc_check(&["--fix"], &text);
        mended_any += usize::from(mended != text);
        assert!(errors(&mended) <= errors(&text), "seed {seed}:\n{text}\nbecame\n{mended}");
    }
    assert!(mended_any > 2, "only {mended_any} were mended");
}

#[test]
fn rulers_and_quotes_are_no_brackets() {
    let rest = "\nrequire few : count(part) <= 9 because \"a \\\" is no end, and { [ ( no brackets -- ";
    let ruler = "-".repeat(3000);
    let text = sound(&format!("# {ruler}\n{rest}{ruler}\"\n# {}\n", "{".repeat(500)));
    let found = places(&text);
    assert!(found.iter().all(|(code, _)| !code.starts_with('E')), "{found:?}");
}

#[test]
fn functions_that_double_do_not_hang() {
    let mut text = "let f0(x : Number) = x + x\n".to_owned();
    for n in 1..=80 {
        let _ = writeln!(text, "let f{n}(x : Number) = f{0}(x) + f{0}(x)", n - 1);
    }
    let found = soon("functions that double", &sound(&format!("{text}require odd : f80(1) > 2\n")));
    let told: Vec<_> =
        found.iter().filter(|d| d.is_error()).map(|d| (d.code.id, d.message.clone())).collect();
    assert!(!told.is_empty() && told.iter().all(|(code, _)| *code == "E0106"), "{told:?}");
    assert!(told[0].1.contains("`f") && told[0].1.contains("10000"), "{told:?}");
    // Twice the same within bounds is fine, and so are many calls beside each other.
    let calls = vec!["f3(1)"; 90].join(" + ");
    let found = places(&sound(&format!(
        "{}require fine : {calls} > 2\n",
        text.lines().take(4).map(|l| format!("{l}\n")).collect::<String>()
    )));
    assert!(found.iter().all(|(code, _)| !code.starts_with('E')), "{found:?}");
}

#[test]
fn what_is_run_over_is_counted() {
    let text = sound(
        "let many = sum over i in 1 .. 10000, j in 1 .. 10000, k in 1 .. 10000 of i + j + k\nrequire odd : count(part) < many\n",
    );
    let found = soon("an aggregate over a million millions", &text);
    assert!(
        found.iter().any(|d| d.is_error() && format!("{d:?}").contains("10000000 combinations")),
        "{found:#?}"
    );
}

/// Each is within bounds, all together are not.
#[test]
fn what_many_expressions_run_over_is_counted_together() {
    let text = sound(&many(60, "require r@ : (sum over a in 1 .. 3000, b in 1 .. 3000 of a * b) > @"));
    let found = soon("sixty large aggregates", &text);
    let told: Vec<_> = found.iter().filter(|d| d.is_error()).collect();
    assert!(told.len() == 1 && format!("{told:?}").contains("this takes too long"), "{told:#?}");
    let text = sound(&many(60, "param p@ : Number = sum over a in 1 .. 2500, b in 1 .. 2500 of a / b"));
    let found = soon("sixty large parameters", &text);
    let told: Vec<_> = found.iter().filter(|d| d.is_error()).collect();
    assert!(told.len() == 1 && format!("{told:?}").contains("this takes too long"), "{told:#?}");
    // A schedule is followed step by step.
    let text = sound(
        "rule grow { match p : part with free port q attach cube to q\n\
         weight = iteration + sum over a in 1 .. 3000, b in 1 .. 3000 of a * b }",
    );
    soon("a weight that is worked out in each iteration", &text);
}

/// A word such as `part` begins no declaration within an expression.
#[test]
fn quantifiers_within_quantifiers_are_told() {
    for piece in
        ["exists a in part: ", "forall a in\npart: ", "exists a in actuator: ", "min over a in part of "]
    {
        let text = sound(&format!("require deep : {}true\n", piece.repeat(1000)));
        let told = sgc_check(&["--format", "concise"], &text);
        assert!(told.contains("E0106"), "{piece}: {told}");
    }
    // Many of them side by side are no depth.
    let many: String = (0..300).map(|n| format!("require r{n} : exists a in part: a is core\n")).collect();
    assert!(!sgc_check(&["--format", "concise"], &sound(&many)).contains("E0106"));
}

#[test]
fn variants_build_on_each_other_so_far() {
    let chain = |count: usize| {
        let mut text = sound("param p : Number = 1\nrequire fine : count(part) < 100 * p\n");
        text += "\nvariant v0 of many { set p = 2 }\n";
        for n in 1..count {
            let _ = writeln!(text, "variant v{n} of v{} {{ set p = {n} }}", n - 1);
        }
        text
    };
    let told = |count: usize| {
        let variant = format!("v{}", count - 1);
        sgc_check(&["--format", "concise", "--variant", &variant], &chain(count))
    };
    assert!(!told(100).contains("E0"), "{}", told(100));
    assert!(told(101).contains("E0106") && told(101).contains("more than 100 variants"), "{}", told(101));
}

/// What is too large is told by `check`, with the true reason.
#[test]
fn limits_are_told_with_their_reasons() {
    let head = "grammar big\nuse std.blocks { cube }\nuse std.objectives { travel }\nuse std.actuators { bender }\n\
                use std.actuation { bezier_pac }\nuse std.models { hinge_model }\nuse std.search { nested_annealing }\n\
                actuate bender with bezier_pac\nsimulate hinge_model for 20 s\nmaximize travel in cm\nsearch nested_annealing\n";
    let row = |parts: usize| {
        let mut text = format!("{head}begin {{\n  place core : cube\n");
        for i in 1..parts {
            let holder = if i == 1 { "core".to_owned() } else { format!("c{}", i - 1) };
            let _ = writeln!(text, "  place c{i} : cube to {holder}.front");
        }
        text + "}\nrule grow { match p : part with free port q attach bender to q }\n"
    };
    assert!(!sgc_check(&["--format", "concise"], &row(256)).contains("E0601"));
    let told = sgc_check(&["--format", "concise"], &row(257));
    assert!(told.contains("E0601") && told.contains("one step can make at most 256 parts"), "{told}");
    let rule = |i: usize| format!("rule r{i} {{ match p : part with free port q attach bender to q }}\n");
    let many = format!("{head}begin {{ place core : cube }}\n{}", (0..20_001).map(rule).collect::<String>());
    let told = sgc_check(&["--format", "concise"], &many);
    assert!(told.contains("E0309") && told.contains("at most 20000 rules"), "{told}");
    // Each block within another would double the work.
    let blocks = |deep: usize| {
        let open: String = (0..deep).map(|i| format!("for i{i} in 0 .. 1 {{ ")).collect();
        format!(
            "{head}begin {{ place core : cube }}\nrule r {{ match p : cube\n  {open} attach bender to p.front {} }}\n",
            "}".repeat(deep)
        )
    };
    assert!(!sgc_check(&["--format", "concise"], &blocks(8)).contains("E0309"));
    let told = sgc_check(&["--format", "concise"], &blocks(40));
    assert!(told.contains("E0309") && told.contains("at most 8 blocks"), "{told}");
    let clauses = |many: usize| {
        let all: String = (0..many).map(|i| format!("  let n{i} = {i}\n")).collect();
        format!(
            "{head}begin {{ place core : cube }}\nrule r {{ match p : cube\n{all}  attach bender to p.front }}\n"
        )
    };
    assert!(!sgc_check(&["--format", "concise"], &clauses(998)).contains("E0309"));
    let told = sgc_check(&["--format", "concise"], &clauses(20_000));
    assert!(told.contains("E0309") && told.contains("at most 1000 clauses"), "{told}");
    // A covariance has a number for each pair of values.
    let varied = |many: usize| {
        let text = row(2)
            .replace("use std.actuation { bezier_pac }\n", "")
            .replace("nested_annealing", "gait_evolution");
        let text = text.replace(
            "begin {\n  place core : cube\n",
            "begin {\n  place core : cube\n  place b : bender to core.right\n",
        );
        let vary =
            |i| format!("  vary p{i}[64] : Angle in -9 deg .. 9 deg mutate 0.5 by normal(0 deg, 1 deg)\n");
        let lists: String = (0..many).map(vary).collect();
        let own = format!("actuation own for a : actuator {{\n{lists}  drive angle = first(p0) }}\n");
        text.replace("with bezier_pac", "with own") + &own
    };
    assert!(!sgc_check(&["--format", "concise"], &varied(23)).contains("E0309"));
    let told = sgc_check(&["--format", "concise"], &varied(24));
    assert!(told.contains("E0309") && told.contains("too many values"), "{told}");
    let study = read("grammars/study1.sgr").replace("lattice 15 x 15 x 15", "lattice 46 x 46 x 46");
    let told = sgc_check(&["--format", "concise"], &study);
    assert!(told.contains("at most 65534 places") && told.contains("97336"), "{told}");
}

/// Files that import each other without end: each names one more.
struct Endless;

impl Loader for Endless {
    fn load(&self, module: &str, _: &str) -> Result<Source, NoModule> {
        let number: usize = module.trim_start_matches("./c").trim_end_matches(".sgr").parse().unwrap();
        Ok(Source { name: module.to_owned(), text: format!("use \"./c{}.sgr\"\n", number + 1) })
    }
}

#[test]
fn a_chain_of_imports_has_an_end() {
    let said = testing::findings(&Endless, "c0.sgr", "use \"./c1.sgr\"\n");
    assert!(said.contains("E0106") && said.contains("more than 100 files long"), "{said}");
}

/// A row of patterns takes as long as all that they match together, multiplied: that comes to its end, and is told.
#[test]
fn patterns_that_match_too_much_together_are_told() {
    let patterns: String = (0..9).map(|n| format!("match p{n} : part  ")).collect();
    let rule =
        format!("rule many {{ {patterns} match z : part where z.mass > 1 kg  attach cube to z.front }}\n");
    let text = codesign().replace("rule add_block", &format!("{rule}\nrule add_block"));
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("many.sgr");
    std::fs::write(&file, text).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_sgc"));
    let output = command.args(["derive", "--steps", "30"]).arg(&file).output().unwrap();
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && told.contains("more than 300000 combinations"), "{told}");
}

#[test]
fn a_match_has_so_many_cases() {
    let values: Vec<String> = (0..3000).map(|n| format!("v{n}")).collect();
    let arms: Vec<String> = values.iter().map(|value| format!("{value} -> 1")).collect();
    let text = format!(
        "enum Many {{ {} }}\nlet one(x : Many) = match x {{ {} }}\n",
        values.join(", "),
        arms.join(", ")
    );
    let found = soon("cases", &sound(&text));
    assert!(
        found.iter().any(|d| d.message.contains("has at most 2000 cases, and this one has 3000")),
        "{found:?}"
    );
}

/// The limits of an expression and of declarations that build on each other multiply: no stack overflows.
#[test]
fn deep_expressions_that_build_on_each_other_are_worked_out() {
    let link = |k: usize, before: &str| if k == 0 { before.to_owned() } else { format!("q{}", k - 1) };
    let nots = "not ".repeat(190);
    let lets: Vec<String> = (0..90).rev().map(|k| format!("let q{k} = {nots}{}", link(k, "true"))).collect();
    let checked = sgc_check(&["--format", "concise"], &lets.join("\n"));
    assert!(checked.contains("no errors") || checked.contains("error["), "{checked}");

    let folder = tempfile::tempdir().unwrap();
    let conditions = "if false then 1 else ".repeat(190);
    let terms: Vec<String> =
        (0..90).map(|k| format!("term q{k} : Number = {conditions}{}", link(k, "travel / 1 cm"))).collect();
    let text = format!(
        "grammar deep
use std.blocks {{ cube }}
use std.objectives {{ travel }}
use std.models {{ hinge_model }}
use std.search {{ plain_annealing }}
begin {{ place core : cube }}
rule add {{ match p : part with free port q attach cube to q }}
require few : count(part) <= 4
{}
simulate hinge_model for 2 s
maximize q89 * 1 cm in cm
search plain_annealing
",
        terms.join("\n")
    );
    let grammar = folder.path().join("deep.sgr");
    std::fs::write(&grammar, text).unwrap();
    let out = folder.path().join("run");
    let run = std::process::Command::new(env!("CARGO_BIN_EXE_sgc"))
        .arg("run")
        .arg(&grammar)
        .args(["--max-evals", "3", "-q", "--out"])
        .arg(&out)
        .output()
        .unwrap();
    assert_eq!(run.status.code(), Some(0), "{}", String::from_utf8_lossy(&run.stderr));
}
