//! The command `check`, and what `test` says of what it leaves open.

use std::process::Command;

use crate::command_line::{code, errors, printed, quick_grammar, sgc};
use crate::support::root;

#[test]
fn check_reads_standard_input_and_goes_on_after_a_bad_file() {
    use std::io::Write;
    use std::process::Stdio;
    let mut child = Command::new(env!("CARGO_BIN_EXE_sgc"))
        .args(["check", "--format", "json", "nowhere.sgr", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all(b"let a = 3 gg\nlet b = 4 kk\n").unwrap();
    let output = child.wait_with_output().unwrap();
    // The worst code counts: what cannot be read was not checked.
    assert_eq!(code(&output), 2);
    let lines: Vec<serde_json::Value> = String::from_utf8_lossy(&output.stdout)
        .lines()
        .map(|line| serde_json::from_str(line).expect("a JSON object a line"))
        .collect();
    assert_eq!(lines.len(), 2);
    assert_eq!(lines[0]["labels"][0]["file"], "<stdin>");
}

#[test]
fn one_variant_of_several_is_tested_and_the_wrong_one_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let grammar = quick_grammar(folder.path());
    let text = std::fs::read_to_string(&grammar).unwrap();
    let more = "
        example bare { expect count(part) == 1 }
        variant right of codesign { }
        variant wrong of codesign { set nothing_there = 3 }";
    std::fs::write(&grammar, text + more).unwrap();
    let output = sgc(&["test", &grammar, "--variant", "right"]);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    assert_eq!(String::from_utf8_lossy(&output.stdout), "ok      right.bare: 0 steps, 1 part\n");
    let output = sgc(&["check", &grammar]);
    assert!(errors(&output).contains("3 grammars and variants, 1 error in wrong"), "{}", errors(&output));
}

#[test]
fn text_in_another_encoding_is_refused_with_its_place() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("latin.sgr");
    std::fs::write(&path, b"# M\xfcller\ngrammar g\n").unwrap();
    let output = sgc(&["check", &path.to_string_lossy()]);
    assert_eq!(code(&output), 1, "{}", errors(&output));
    assert!(String::from_utf8_lossy(&output.stdout).contains("UTF-8"));
}

#[test]
fn what_none_of_several_grammars_uses_is_told_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("several.sgr");
    let text = "
        grammar one
        use std.blocks     { cube, ball }
        use std.objectives { travel }
        use std.models     { hinge_model }
        use std.search     { plain_annealing }
        let nobody = 3 cm
        let second = 4
        begin { place core : cube }
        rule grow { match p : part with free port q  attach cube to q }
        require few : count(part) <= 9
        simulate hinge_model for 2 s
        maximize travel in cm
        search   plain_annealing
        variant two of one { replace require few : count(part) <= second }
        variant three of one { add rule roll { match p : part with free port q  attach ball to q } }
    ";
    std::fs::write(&path, text).unwrap();
    let output = sgc(&["check", &path.to_string_lossy(), "--format", "concise"]);
    let told = String::from_utf8_lossy(&output.stdout);
    let lines: Vec<&str> = told.lines().collect();
    assert_eq!(lines.len(), 1, "{told}");
    assert!(lines[0].contains("7:13: warning[W0701] nothing uses `nobody`"), "{told}");
}

/// What a variant no longer reads is not idle, as long as the grammar that it changes reads it.
#[test]
fn what_a_variant_leaves_unread_its_grammar_may_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("limited.sgr");
    let text = "grammar limited
use std.actuators  { bender }
use std.blocks     { cube }
use std.models     { hinge_model }
use std.objectives { travel }
use std.search     { gait_evolution }
begin { place core : cube  place limb : bender to core.front }
actuation act for a : bender {
  shared k     : Number in 0 .. 1 mutate 0.3 by normal(0, 0.3)
  let    most  = 20 deg
  let    spare = 3 deg
  let    swing = min(k * 40 deg, most)
  drive  angle = swing * sin(t / 2 s * 360 deg)
}
actuate  bender with act
simulate hinge_model for 5 s
maximize travel in cm
search   gait_evolution
variant free of limited { set act.swing = k * 40 deg }
";
    std::fs::write(&path, text).unwrap();
    let path = path.to_string_lossy();
    let told = printed(&sgc(&["check", "--format", "concise", &path]));
    let warnings: Vec<&str> = told.lines().filter(|line| line.contains("W0701")).collect();
    assert!(warnings.len() == 1 && warnings[0].contains("11:10"), "{told}");
    // Nor where the variant alone is read.
    let alone = sgc(&["derive", &path, "--variant", "free", "--steps", "1"]);
    assert!(!errors(&alone).contains("W0701"), "{}", errors(&alone));
}

#[test]
fn a_parameter_is_given_once_and_a_grammar_is_no_design() {
    let output = sgc(&["check", "grammars/codesign.sgr", "-p", "max_actuators=4", "-p", "max_actuators=5"]);
    assert_eq!(code(&output), 1);
    assert!(printed(&output).contains("`max_actuators` is given twice"), "{}", printed(&output));
    let output = sgc(&["view", "grammars/codesign.sgr"]);
    assert_eq!(code(&output), 2);
    assert!(errors(&output).contains("is a grammar"), "{}", errors(&output));
}

#[test]
fn an_example_that_the_search_starts_from_is_derived_by_check() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("start.sgr");
    let text = std::fs::read_to_string(root().join("grammars/shepherd.sgr")).unwrap();
    assert!(text.contains("expect "), "{text}");
    let base = root().join("grammars/codesign.sgr");
    let text = text.replace("./codesign.sgr", &base.to_string_lossy());
    std::fs::write(&file, &text).unwrap();
    assert_eq!(code(&sgc(&["check", &file.to_string_lossy()])), 0);
    std::fs::write(&file, text.replacen("expect ", "expect 1 == 2 and ", 1)).unwrap();
    let check = sgc(&["check", &file.to_string_lossy()]);
    assert_eq!(code(&check), 1, "{}", printed(&check));
    assert!(printed(&check).contains("E0603") && printed(&check).contains("the search starts from"));
}

/// What the rules make of an example is no finding, but `check` says that it does not hold.
#[test]
fn check_tells_how_many_examples_fail() {
    let folder = tempfile::tempdir().unwrap();
    let grammar = quick_grammar(folder.path());
    let text = std::fs::read_to_string(&grammar).unwrap();
    let told = |examples: &str| {
        std::fs::write(&grammar, text.clone() + examples).unwrap();
        let output = sgc(&["check", &grammar]);
        assert_eq!(code(&output), 0, "{}", errors(&output));
        errors(&output).trim_end().to_owned()
    };
    let (holds, fails) =
        ("\nexample one { expect count(part) == 1 }", "\nexample two { expect count(part) == 2 }");
    assert!(told(holds).ends_with(" warning"), "{}", told(holds));
    let one = told(fails);
    assert!(one.ends_with(" 2 warnings; its example fails: `sgc test` says why"), "{one}");
    let both = told(&(holds.to_owned() + fails));
    assert!(both.ends_with(" 2 warnings; 1 of 2 examples fail: `sgc test` says why"), "{both}");
}
