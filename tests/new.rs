//! `sgc new`: every template is a grammar that works.

use crate::support::{said, sgc};

const TEMPLATES: &[&str] = &["walker", "worm"];

#[test]
fn every_template_is_free_of_findings_and_runs() {
    let folder = tempfile::tempdir().unwrap();
    let root = crate::support::root();
    let files = std::fs::read_dir(root.join("src/cli/templates")).unwrap().count();
    assert_eq!(files, TEMPLATES.len(), "a template is not tested");
    for template in TEMPLATES {
        let name = format!("my_{template}");
        let file = format!("{name}.sgr");
        let output = sgc(folder.path(), &["new", &name, "--from", template]);
        assert_eq!(output.status.code(), Some(0), "{}", said(&output));
        assert!(said(&output).contains(&format!("sgc check {file}")), "{}", said(&output));
        let text = std::fs::read_to_string(folder.path().join(&file)).unwrap();
        assert!(text.contains(&format!("\ngrammar {name}\n")) && !text.contains("NAME"), "{text}");

        let output = sgc(folder.path(), &["check", "--format", "concise", &file]);
        assert_eq!(output.status.code(), Some(0), "{}", said(&output));
        assert!(output.stdout.is_empty(), "{}", said(&output));
        let derive = |seed| said(&sgc(folder.path(), &["derive", &file, "--steps", "30", "--seed", seed]));
        let designs = ["1", "2", "3"].map(derive).concat();
        assert_eq!(designs.matches("\nparts\n").count(), 3, "{designs}");
        assert!(designs.contains(". bender-1 (segments = ") && designs.contains(" cube-1 on "), "{designs}");
        let output = sgc(folder.path(), &["run", &file, "--max-evals", "10", "--quiet"]);
        assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    }
}

#[test]
fn nothing_is_overwritten_unless_by_force() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("walker.sgr");
    std::fs::write(&path, "mine").unwrap();
    let output = sgc(folder.path(), &["new", "walker"]);
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    assert!(said(&output).contains("exists already"), "{}", said(&output));
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "mine");
    let output = sgc(folder.path(), &["new", "walker", "--force"]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    assert!(std::fs::read_to_string(&path).unwrap().contains("grammar walker"));
}

#[test]
fn a_name_that_cannot_be_is_refused_with_one_that_can() {
    let folder = tempfile::tempdir().unwrap();
    for (name, suggested) in [
        ("my-robot", Some("my_robot")),
        ("robots/walker.sgr", Some("walker")),
        ("3legs", Some("my_3legs")),
        ("rule", Some("my_rule")),
        ("a b\nuse std.blocks", Some("a_b_use_std_blocks")),
        ("worm # crawls", Some("worm___crawls")),
        ("../..", None),
        ("", None),
    ] {
        let output = sgc(folder.path(), &["new", name]);
        assert_eq!(output.status.code(), Some(2), "{name}: {}", said(&output));
        match suggested {
            Some(s) => {
                assert!(said(&output).contains(&format!("`sgc new {s}`")), "{name}: {}", said(&output))
            }
            None => assert!(!said(&output).contains("try"), "{name}: {}", said(&output)),
        }
    }
    let output = sgc(folder.path(), &["new", "worm", "--from", "snake"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(said(&output).contains("walker"), "{}", said(&output));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "nothing was written");
}

/// Who made a file read-only wants to keep it.
#[test]
fn a_read_only_file_stays_also_by_force() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("walker.sgr");
    std::fs::write(&path, "mine").unwrap();
    let mut permissions = std::fs::metadata(&path).unwrap().permissions();
    permissions.set_readonly(true);
    std::fs::set_permissions(&path, permissions).unwrap();
    let output = sgc(folder.path(), &["new", "walker", "--force"]);
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    assert!(said(&output).contains("is read-only"), "{}", said(&output));
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "mine");
}
