//! Saved designs: those that were changed, and those of other versions of sgc.

use crate::command_line::{code, errors, printed, quick_run, sgc};
use crate::support::forged;

#[test]
fn a_saved_design_is_what_it_says() {
    let folder = tempfile::tempdir().unwrap();
    let run = quick_run(folder.path());
    let text = std::fs::read_to_string(run.join("best.design.json")).unwrap();
    let design: serde_json::Value = serde_json::from_str(&text).unwrap();
    let edited = folder.path().join("edited.design.json");
    let path = edited.to_string_lossy().into_owned();
    let told = |design: &serde_json::Value, command: &[&str], edit: &dyn Fn(&mut serde_json::Value)| {
        let mut design = design.clone();
        edit(&mut design);
        std::fs::write(&edited, design.to_string()).unwrap();
        let output = sgc(command);
        (code(&output), errors(&output))
    };
    let said = |command: &[&str], edit: &dyn Fn(&mut serde_json::Value)| told(&design, command, edit);
    assert_eq!(said(&["eval", &path], &|_| {}).0, 0);
    // Whatever was changed, also what nothing else would tell.
    let check = |design: &mut serde_json::Value| design["tasks"][0]["checks"][0]["value"] = 99.5.into();
    let commands: [&[&str]; 4] = [
        &["eval", &path],
        &["view", &path],
        &["export", &path, "--to", "begin"],
        &["eval", &path, "--grammar", "grammars/codesign.sgr"],
    ];
    for command in commands {
        let (code, said) = said(command, &check);
        assert!(code == 2 && said.contains("does not fit its checksum"), "{command:?}: {code}, {said}");
    }
    // Without a checksum it is none.
    let bare = |design: &mut serde_json::Value| drop(design.as_object_mut().unwrap().remove("sum"));
    for command in commands {
        let (code, said) = said(command, &bare);
        assert!(code == 2 && said.contains("does not fit its checksum"), "{command:?}: {code}, {said}");
    }
    // Whoever makes a checksum of their own is found by what is simulated.
    let said = |command: &[&str], edit: &dyn Fn(&mut serde_json::Value)| {
        let mut design = design.clone();
        edit(&mut design);
        std::fs::write(&edited, forged(&design.to_string())).unwrap();
        let output = sgc(command);
        (code(&output), errors(&output))
    };
    let term = |design: &mut serde_json::Value| design["tasks"][0]["terms"][0][1] = 0.25.into();
    let value = |design: &mut serde_json::Value| design["tasks"][0]["value"] = 99.5.into();
    let observed = |design: &mut serde_json::Value| design["observed"]["slid"] = 0.125.into();
    let unit = |design: &mut serde_json::Value| design["unit"] = "m".into();
    let cheap = |design: &mut serde_json::Value| design["penalties"] = serde_json::json!([["cheap", 2.0]]);
    for (edit, what) in [
        (&term as &dyn Fn(&mut serde_json::Value), "the saved term `travel`"),
        (&value, "the saved value of the task"),
        (&observed, "the observed value `slid`"),
        (&unit, "the saved unit"),
        (&cheap, "preferences that are not fulfilled"),
    ] {
        for command in [&["eval", &path][..], &["view", &path], &["export", &path, "--to", "mjcf"]] {
            let (code, said) = said(command, edit);
            assert!(code == 1 && said.contains(what), "{command:?}: {code}, {said}");
            assert!(!said.contains("exactly"), "{said}");
        }
    }
    // One reader takes the first of two, another the last.
    std::fs::write(&edited, text.replacen("\"value\":", "\"value\": 99.5, \"value\":", 1)).unwrap();
    let output = sgc(&["eval", &path]);
    assert_eq!(code(&output), 2);
    assert!(errors(&output).contains("it gives \"value\" twice"), "{}", errors(&output));
    // A choice that no rule makes.
    let chosen = |design: &mut serde_json::Value, is_it: &dyn Fn(f64) -> bool, value: f64| {
        let steps = design["derivation"].as_array_mut().unwrap();
        let mut locals = steps.iter_mut().flat_map(|step| step["locals"].as_array_mut().unwrap());
        let is_it =
            |local: &&mut serde_json::Value| local.get("number").is_some_and(|x| is_it(x.as_f64().unwrap()));
        locals.find(is_it).expect("a number that was chosen")["number"] = value.into();
    };
    let turned = |design: &mut serde_json::Value| chosen(design, &|_| true, 1e300);
    // Segments are counted.
    let half = |design: &mut serde_json::Value| {
        chosen(design, &|x| (3.0..=6.0).contains(&x) && x.fract() == 0.0, 3.5)
    };
    for command in [&["eval", &path][..], &["view", &path], &["export", &path, "--to", "begin"]] {
        for forged in [&turned as &dyn Fn(&mut serde_json::Value), &half] {
            let (code, said) = said(command, forged);
            assert!(code != 0 && said.contains("never chooses"), "{command:?}: {code}, {said}");
        }
    }
    // Another body than the one that was saved, also where nothing is simulated.
    let body = |design: &mut serde_json::Value| design["body"] = "0".repeat(64).into();
    for command in [&["eval", &path][..], &["view", &path], &["export", &path, "--to", "begin"]] {
        let (code, said) = said(command, &body);
        assert!(code != 0 && said.contains("does not lead to the body"), "{command:?}: {code}, {said}");
    }
}

/// A design that another version of sgc saved opens: its texts, body and curves are in it. What this one says otherwise
/// is told.
#[test]
fn a_design_of_another_version_opens() {
    let folder = tempfile::tempdir().unwrap();
    let run = quick_run(folder.path());
    let text = std::fs::read_to_string(run.join("best.design.json")).unwrap();
    let path = folder.path().join("older.design.json");
    let named = path.to_string_lossy().into_owned();
    let written = |edit: &dyn Fn(&mut serde_json::Value)| {
        let mut design: serde_json::Value = serde_json::from_str(&text).unwrap();
        edit(&mut design);
        std::fs::write(&path, forged(&design.to_string())).unwrap();
    };
    // Read as another rule set, it is the same design with the same value.
    let reread = |design: &mut serde_json::Value| {
        design["sgc"] = "0.0.1".into();
        design["grammar"]["rules"] = "of fields that rule sets had then".into();
    };
    written(&reread);
    for command in [&["view", &named, "--force"][..], &["export", &named, "--to", "mjcf"], &["eval", &named]]
    {
        let output = sgc(command);
        assert!(code(&output) == 0 && !errors(&output).contains("0.0.1"), "{command:?}: {}", errors(&output));
    }
    // By this version the same would be a changed grammar.
    written(&|design| design["grammar"]["rules"] = "of another text".into());
    let output = sgc(&["view", &named, "--force"]);
    assert!(code(&output) == 2 && errors(&output).contains("its grammar was changed"), "{}", errors(&output));
    // Simulated otherwise, it is told, and shown as it is now.
    written(&|design| {
        reread(design);
        design["value"] = 1234.5.into();
        design["tasks"][0]["value"] = 1234.5.into();
    });
    for command in [&["view", &named, "--force"][..], &["export", &named, "--to", "mjcf"]] {
        let output = sgc(command);
        let said = errors(&output);
        assert!(code(&output) == 0 && said.contains("saved by sgc 0.0.1"), "{command:?}: {said}");
        assert!(said.contains("it has another value"), "{command:?}: {said}");
    }
    let out = folder.path().join("older.html");
    assert_eq!(code(&sgc(&["view", &named, "--out", &out.to_string_lossy()])), 0);
    let page = std::fs::read_to_string(out).unwrap();
    assert!(!page.contains("1234.5"));
    let output = sgc(&["eval", &named]);
    assert!(code(&output) == 1 && printed(&output).starts_with("value "), "{}", errors(&output));
    // Its body, too.
    written(&|design| {
        reread(design);
        design["body"] = "of parts that were counted otherwise".into();
    });
    let output = sgc(&["view", &named, "--force"]);
    assert!(
        code(&output) == 2 && errors(&output).contains("its steps lead to another body"),
        "{}",
        errors(&output)
    );
}
