//! Audits: counts that are known by hand, bodies that can and cannot be made, and that
//! what is said of an expression before there is a design holds for designs.

use grammar_lang::bounds::{Facts, Reasoning};
use grammar_lang::eval::{Value, evaluate};
use grammar_lang::ir::{Expr, RuleSet};
use grammar_lang::source::SourceMap;
use sgc::audit::{self, Answer, Audit, Counted, Observer, Settings};
use sgc::derive::random::Stream;
use sgc::derive::{Derivation, DesignScope};
use sgc::loader::Files;

use crate::support::{codesign, grammar, root};

struct Quiet;

impl Observer for Quiet {
    fn progress(&mut self, _: &str, _: usize, _: usize) {}
}

/// A grammar of cubes with these declarations.
fn cubes(declarations: &str) -> RuleSet {
    let text = format!(
        "grammar cubes
use std.blocks     {{ cube, ball }}
use std.objectives {{ travel }}
use std.models     {{ hinge_model }}
use std.search     {{ plain_annealing }}
begin {{ place core : cube }}
simulate hinge_model for 20 s
maximize travel in cm
search   plain_annealing
{declarations}"
    );
    let mut sources = SourceMap::default();
    let entry = sources.add("cubes", text);
    let compiled = grammar_lang::compile(&Files, &mut sources, entry, &[], None);
    compiled.ruleset.unwrap_or_else(|| panic!("{:#?}", compiled.diagnostics))
}

const GROW: &str = "rule grow { match p : part with free port q attach cube to q }\n";

fn settings(seed: u64) -> Settings {
    Settings { seed, walks: 12, steps: 4, temperature: 0.0, budget: 3000 }
}

fn run(rules: &RuleSet, settings: &Settings) -> Audit {
    audit::audit(rules, &Derivation::begin(rules), settings, &mut Quiet).unwrap()
}

fn counts(audit: &Audit) -> Vec<(usize, Counted)> {
    audit.depths.iter().map(|d| (d.designs, d.counted)).collect()
}

fn ask(rules: &RuleSet, wanted: &Derivation) -> Answer {
    audit::can_make(rules, &Derivation::begin(rules), wanted, &settings(1), &mut Quiet).unwrap()
}

#[test]
fn designs_at_the_first_depths_are_those_counted_by_hand() {
    // A cube on one of six faces; then two on faces of the core (15), or one on one of
    // the five faces that are left of the first (30).
    let rules = cubes(GROW);
    assert_eq!(
        counts(&run(&rules, &settings(1)))[..3],
        [(1, Counted::All), (6, Counted::All), (45, Counted::All)]
    );
    // Four faces on the mirror plane, and one pair beside it.
    let mirrored = cubes(&format!("symmetry mirror xy\n{GROW}"));
    assert_eq!(counts(&run(&mirrored, &settings(1)))[1], (5, Counted::All));
    // What one choice of a rule cannot say, as zero here, the others can.
    let divided = cubes(
        "rule grow { match p : part with free port q choose b in 0 .. 3 when 6 / b >= 3 attach cube to q }
         require few : count(part) < 4 + sqrt(4 - count(part))",
    );
    let audit = run(&divided, &Settings { steps: 5, ..settings(1) });
    assert_eq!(counts(&audit)[..3], [1, 6, 45].map(|n| (n, Counted::All)));
    // A requirement that has no value stops a move, too: of five cubes.
    assert!(audit.requirements[0].stopped > 0, "{:?}", audit.requirements);
    // A row in one direction ends.
    let row = cubes(
        "rule grow { match p : part with free port q where q is front attach cube to q }
         require short : count(part) <= 3",
    );
    let depths = counts(&run(&row, &settings(1)));
    assert_eq!(depths, [1, 1, 1, 0].map(|n| (n, Counted::All)), "no depth after an empty one");
}

#[test]
fn depths_that_were_not_enumerated_say_so() {
    let free = cubes(
        "rule grow { match p : part with free port q choose turn in 0 deg .. 90 deg
                     attach ball to q turned turn }
         rule lay { match p : part with free port q choose turn in 10 deg .. 20 deg
                    attach cube to q turned turn }",
    );
    assert_eq!(counts(&run(&free, &settings(1)))[1].1, Counted::AtLeast, "a continuous choice");
    let few = Settings { budget: 10, ..settings(1) };
    let audit = run(&cubes(GROW), &few);
    assert_eq!(counts(&audit)[1], (6, Counted::All));
    assert!(counts(&audit)[2..].iter().all(|(_, how)| *how == Counted::Walks), "the budget is spent");
}

#[test]
fn a_rule_that_a_requirement_always_stops_is_told() {
    let rules = cubes(&format!(
        "{GROW}rule roll {{ match p : part with free port q attach ball to q }}
         require square : count(ball) == 0
         require few    : count(part) <= 50
         prefer  small  : count(part) <= 3 weight 1"
    ));
    let audit = run(&rules, &settings(3));
    let roll = &audit.rules[1];
    assert!(roll.drawn > 0 && roll.applied == 0, "{roll:?}");
    let text = audit::report(&audit);
    assert!(text.contains("never applied: every application breaks `square`"), "{text}");
    let few = text.lines().find(|l| l.starts_with("  few")).unwrap();
    assert!(few.ends_with("never stopped anything"), "{few}");
    let (_, yes, of) = audit.preferences[0];
    assert_eq!((yes, of), (24, 48), "after the first two of four moves of twelve walks");
}

/// What differs by its numbers alone is one cause.
#[test]
fn causes_that_differ_by_numbers_are_one() {
    let rules = cubes(
        "part bar {
           param long : Length in 1 cm .. 2 cm = 1 cm
           shape    = box(long, 1 cm, 1 cm)
           density  = 1 g/cm^3
           friction = 0.8
         }
         rule grow { match p : part with free port q  choose l in 1 cm .. 2 cm  attach bar(long = l * (1 + count(bar))) to q }
         require few : count(part) <= 50",
    );
    let audit = run(&rules, &settings(3));
    let stopped: Vec<_> =
        audit.rules[0].stopped.iter().map(|stopped| (stopped.by.as_str(), stopped.times)).collect();
    assert_eq!(stopped.iter().filter(|(by, _)| *by == "parameter long").count(), 1, "{stopped:?}");
    assert!(stopped.iter().any(|(by, times)| *by == "parameter long" && *times > 5), "{stopped:?}");
}

#[test]
fn audits_are_repeatable() {
    let rules = grammar("grammars/codesign.sgr");
    let audits = [1, 1, 2].map(|seed| run(&rules, &settings(seed)));
    assert_eq!(audits[0], audits[1]);
    assert_ne!(audits[0], audits[2]);
}

#[test]
fn a_report_of_codesign() {
    let rules = grammar("grammars/codesign.sgr");
    let settings = Settings { seed: 1, walks: 40, steps: 8, temperature: 0.0, budget: 2000 };
    insta::assert_snapshot!(audit::report(&run(&rules, &settings)));
}

/// A derivation of some random moves.
fn derived(rules: &RuleSet, seed: u64, moves: usize) -> Derivation {
    let mut random = Stream::named(seed, "wanted");
    let mut derivation = Derivation::begin(rules);
    for _ in 0..moves {
        if let Some(next) = derivation.advance(rules, &mut random, 0.0).result {
            derivation = next;
        }
    }
    derivation
}

#[test]
fn a_body_is_made_by_its_own_steps_or_in_another_way() {
    let rules = cubes(GROW);
    let wanted = derived(&rules, 1, 6);
    let Answer::Yes(made) = ask(&rules, &wanted) else { panic!("its own grammar makes it") };
    assert!(made.own_steps);
    let other =
        cubes("rule put { match p : part with free port q choose what in { ball, cube } attach what to q }");
    let Answer::Yes(made) = ask(&other, &wanted) else { panic!("a rule of another name makes it") };
    assert!(!made.own_steps);
    assert_eq!(made.derivation.design.canonical_hash(), wanted.design.canonical_hash());
    assert_eq!(Derivation::replay(&other, &made.derivation.steps).unwrap().design, made.derivation.design);
}

#[test]
fn a_body_that_cannot_be_made_is_refused_with_the_reason() {
    let wanted = derived(&cubes(GROW), 1, 6);
    let strict = cubes(&format!("{GROW}require few : count(part) <= 4 because \"the box is small\""));
    let Answer::No(reasons) = ask(&strict, &wanted) else { panic!("it has seven parts") };
    assert_eq!(reasons, ["`few` would be broken: the box is small"]);
    let row = cubes("rule grow { match p : part with free port q where q is front attach cube to q }");
    let Answer::No(reasons) = ask(&row, &wanted) else { panic!("it is no row") };
    assert!(reasons[0].starts_with("step 1 of its own derivation cannot be applied"), "{reasons:?}");
    let balls = cubes("rule grow { match p : part with free port q attach ball to q }");
    assert!(matches!(ask(&balls, &wanted), Answer::No(_)));
}

#[test]
fn a_search_that_gives_up_says_so() {
    let wanted = derived(&cubes(GROW), 1, 6);
    // It could go round about: turning moves whatever hangs on a part.
    let turning = cubes(
        "rule grow { match p : part with free port q where q is front attach cube to q }
         rule turn { match p : part where p is not core choose angle in { 90 deg, 180 deg } set p.turn = p.turn + angle }",
    );
    let Answer::Open(reasons) = ask(&turning, &wanted) else { panic!("not decided") };
    assert!(reasons.last().unwrap().starts_with("only derivations through designs"), "{reasons:?}");
}

/// Checks every number and truth within an expression against what is said of it.
fn holds_for(expr: &Expr, facts: &Facts<'_>, scope: &DesignScope<'_>, checked: &mut usize) {
    let mut reasoning = Reasoning::new(facts, Vec::new());
    let known = reasoning.value(expr);
    match evaluate(expr, scope, &mut Vec::new()) {
        Ok(Value::Number(x)) => {
            let known = known.numbers();
            assert!(known.low <= x && x <= known.high, "{x} in {known:?}");
            *checked += 1;
        }
        Ok(Value::Bool(x)) => {
            let truth = known.truth();
            assert_ne!(truth, grammar_lang::bounds::Truth::known(!x), "{expr:?}");
            *checked += 1;
        }
        _ => {}
    }
    expr.each(&mut |inner| holds_for(inner, facts, scope, checked));
}

#[test]
fn what_is_said_before_there_is_a_design_holds_for_designs() {
    let mut checked = 0;
    for path in ["grammars/codesign.sgr", "grammars/morphology.sgr"] {
        let rules = grammar(path);
        let facts = Facts::new(&rules);
        for seed in 0..10 {
            let derivation = derived(&rules, seed, 20);
            let scope = DesignScope::new(&rules, &derivation).at_temperature(seed as f64);
            let requirements = rules.requirements.iter().map(|r| &r.condition);
            let weights = rules.rules.iter().map(|r| &r.weight);
            let moves = rules.search.curves.iter().map(|curves| &curves.schedule.moves);
            requirements.chain(weights).chain(moves).for_each(|e| holds_for(e, &facts, &scope, &mut checked));
        }
    }
    assert!(checked > 200, "only {checked} values");
}

#[test]
fn the_command_tells_by_its_exit_code_whether_all_can_be_made() {
    let sgc = |arguments: &[&str]| {
        std::process::Command::new(env!("CARGO_BIN_EXE_sgc"))
            .arg("audit")
            .args(arguments)
            .args(["--walks", "4", "--steps", "2", "--budget", "3000"])
            .current_dir(root())
            .output()
            .unwrap()
    };
    let plain = sgc(&["grammars/codesign.sgr", "--format", "json"]);
    assert_eq!(plain.status.code(), Some(0));
    let report: serde_json::Value = serde_json::from_slice(&plain.stdout).unwrap();
    assert_eq!(report["depths"][1]["designs"], 42);
    assert_eq!(report["rules"][0]["name"], "add_block");
    let unknown = sgc(&["grammars/codesign.sgr", "--example", "none"]);
    assert_eq!(unknown.status.code(), Some(1));
    assert_eq!(sgc(&["grammars/codesign.sgr", "--design", "nowhere"]).status.code(), Some(2));

    let folder = tempfile::tempdir().unwrap();
    let short = codesign().replace("for 20 s", "for 1 s");
    let quick = folder.path().join("quick.sgr");
    std::fs::write(&quick, short).unwrap();
    let out = folder.path().join("run");
    let ran = std::process::Command::new(env!("CARGO_BIN_EXE_sgc"))
        .args([
            "run",
            &quick.to_string_lossy(),
            "--max-evals",
            "100",
            "--quiet",
            "--out",
            &out.to_string_lossy(),
        ])
        .output()
        .unwrap();
    assert!(ran.status.success());
    let made = sgc(&["grammars/codesign.sgr", "--design", &out.to_string_lossy()]);
    assert_eq!(made.status.code(), Some(0), "{}", String::from_utf8_lossy(&made.stderr));
    assert!(String::from_utf8_lossy(&made.stdout).contains("can be made, by its own steps"));
    let refused = sgc(&["grammars/codesign.sgr", "-p", "max_parts=2", "--design", &out.to_string_lossy()]);
    assert_eq!(refused.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&refused.stdout).contains("`few_parts` would be broken"));
}

/// A rule of which an expression never has a value is told, and the rest of the report is there.
#[test]
fn an_expression_without_a_value_does_not_end_an_audit() {
    let text = crate::support::read("grammars/morphology.sgr").replace(
        "rule add_actuator {",
        "rule never {\n  match p : part with free port q\n  when  sqrt(count(cube) - 1 - count(part)) > 0\n  \
         attach cube to q\n}\n\nrule add_actuator {",
    );
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("failing.sgr");
    let text = text.replace("\"./", &format!("\"{}/", crate::support::root().join("grammars").display()));
    std::fs::write(&path, text).unwrap();
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_sgc"))
        .args(["audit", &path.to_string_lossy(), "--walks", "5", "--steps", "5", "--budget", "500"])
        .output()
        .unwrap();
    let (out, errors) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert_eq!(output.status.code(), Some(0), "{out}{errors}");
    assert!(out.contains("never applied: no value, every time"), "{out}");
    assert!(
        errors.contains("a negative number has no square root; ") && errors.contains("refused because of it"),
        "{errors}"
    );
    assert!(out.contains("different designs after each number of moves"), "{out}");
}

/// Sixty million values of ten choices are not listed before the budget is asked.
#[test]
fn a_budget_holds_between_the_choices_of_a_rule() {
    let choices: String = (0..10).map(|i| format!("choose c{i} in 0 .. 5\n")).collect();
    let sum: Vec<String> = (0..10).map(|i| format!("c{i}")).collect();
    let sum = sum.join(" + ");
    let turned = format!(
        "{GROW}rule turn {{ match p : part with free port q\n{choices} attach ball to q turned ({sum}) * 1 deg }}"
    );
    let never = format!(
        "{GROW}rule turn {{ match p : part with free port q\n{}when {sum} > 49\nattach ball to q }}",
        choices.trim_end()
    );
    for declarations in [turned, never] {
        let rules = cubes(&declarations);
        let audit = run(&rules, &Settings { budget: 200, ..settings(1) });
        assert_ne!(audit.depths[1].counted, Counted::All, "{:?}", audit.depths);
    }
}

/// Bodies that look alike may go on differently, as their ports have changed places.
#[test]
fn a_part_that_was_turned_onto_itself_is_gone_on_from() {
    let text = "grammar alike
use std.objectives { travel }
use std.models     { hinge_model }
use std.search     { recommended }
use std.blocks     { cube }
part nub { shape = sphere(3 mm)  mass = 2 g  friction = 0.5 }
begin { place core : cube }
rule add {
  match  p : cube with free port q where q is front and p is core
  choose turn in { 0 deg, 90 deg, 180 deg, 270 deg }
  attach cube to q turned turn
}
rule stick {
  match  p : cube with free port q where q is left and p is not core
  attach nub to q
}
require few : count(part) <= 3
simulate hinge_model for 4 s
maximize travel in cm
search recommended
";
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("turned.sgr");
    std::fs::write(&file, text).unwrap();
    let output =
        crate::support::sgc(folder.path(), &["audit", "turned.sgr", "--walks", "20", "--steps", "2"]);
    let said = crate::support::said(&output);
    let words = |line: &str| line.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
    assert!(said.lines().any(|line| words(line) == ["2", "4", "all", "there", "are"]), "{said}");
}
