//! The project's own grammars: free of findings, and their typed rule sets.

use sgc::testing;

use crate::support::{GRAMMARS, grammar, root};

#[test]
fn every_grammar_and_library_file_is_free_of_findings() {
    for folder in ["grammars", "std-rules"] {
        for entry in std::fs::read_dir(root().join(folder)).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                continue;
            }
            assert_eq!(testing::findings(&path), testing::CLEAN, "{}", path.display());
            let is_module = testing::rules(&path) == testing::MODULE;
            assert_eq!(is_module, folder == "std-rules", "{}", path.display());
        }
    }
}

#[test]
fn experiments_are_free_of_findings_but_for_what_is_fixed_on_purpose() {
    for entry in std::fs::read_dir(root().join("grammars/experiments")).unwrap() {
        let path = entry.unwrap().path();
        let findings = testing::findings(&path);
        let codes = findings.matches("] Error:").count() + findings.matches("] Warning:").count();
        assert_eq!(codes, findings.matches("[W0720]").count(), "{}: {findings}", path.display());
    }
}

#[test]
fn every_library_file_is_embedded() {
    for entry in std::fs::read_dir(root().join("std-rules")).unwrap() {
        let name = format!("std.{}", entry.unwrap().path().file_stem().unwrap().to_string_lossy());
        assert!(sgc::loader::LIBRARY.iter().any(|(n, _)| *n == name), "{name} is not in loader::LIBRARY");
    }
}

#[test]
fn the_typed_rule_set_of_codesign() {
    insta::assert_snapshot!(testing::rules(root().join("grammars/codesign.sgr")));
}

#[test]
fn what_every_grammar_comes_to() {
    for path in GRAMMARS {
        let name = path.trim_start_matches("grammars/").trim_end_matches(".sgr");
        insta::assert_snapshot!(format!("resolved-{name}"), testing::resolved(root().join(path)));
    }
}

#[test]
fn the_typed_rule_set_survives_being_saved() {
    for path in GRAMMARS {
        let rules = grammar(path);
        let text = serde_json::to_string(&rules).unwrap();
        let again: grammar_lang::ir::RuleSet = serde_json::from_str(&text).unwrap();
        assert_eq!(again, rules);
    }
}

#[test]
fn morphology_shares_its_rules_with_codesign() {
    let (codesign, morphology) = (grammar("grammars/codesign.sgr"), grammar("grammars/morphology.sgr"));
    for name in ["add_block", "turn_part", "undo"] {
        let of = |rules: &grammar_lang::ir::RuleSet| {
            let rule = rules.rule(name).cloned().expect("the rule");
            serde_json::to_string(&rule.effects.len()).unwrap() + &format!("{:?}", rule.locals)
        };
        assert_eq!(of(&codesign), of(&morphology));
    }
    assert_eq!(morphology.patterns.len(), 7, "six patterns and rest");
    assert!(morphology.search.curves.is_none(), "no loop over curves");
    assert_eq!(codesign.requirements.len(), morphology.requirements.len());
}

#[test]
fn what_cannot_be_tested_says_why() {
    let path = root().join("grammars/nowhere.sgr");
    assert!(
        testing::findings(&path).starts_with("cannot read nowhere.sgr: "),
        "{}",
        testing::findings(&path)
    );
    let bad = root().join("tests/cases/start-breaks.sgr");
    let said = testing::findings(&bad);
    assert!(said.contains("start-breaks.sgr:") && !said.contains("tests/cases"), "{said}");
    assert_eq!(testing::derivation(&bad, 1, 5), said, "findings in place of a derivation");
    assert_eq!(testing::rules(&bad), said);
    let imports = testing::findings(root().join("tests/cases/cycle-a.sgr"));
    assert!(imports.contains("cycle-b.sgr") && !imports.contains("/cycle-b.sgr"), "{imports}");
    assert_eq!(testing::derivation(root().join("std-rules/blocks.sgr"), 1, 5), testing::MODULE);
}

#[test]
fn the_bodies_to_measure_with_have_their_hinges() {
    use sgc::derive::Derivation;
    use sgc::design::{Body, assembly::JointKind};
    let rules = grammar("benches/bodies/bodies.sgr");
    for (example, elements, hinges) in [("two", 17, 10), ("four", 31, 20), ("eight", 58, 40)] {
        let derivation = Derivation::start(&rules, Some(example)).unwrap();
        let assembly = Body::new(&derivation.design, &rules).assembly;
        let hinge = |joint: &&sgc::design::assembly::Joint| matches!(joint.kind, JointKind::Dof(_));
        assert_eq!(
            (assembly.elements.len(), assembly.joints.iter().filter(hinge).count()),
            (elements, hinges)
        );
    }
}
