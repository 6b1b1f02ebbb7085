//! Novelty: the scores that the thesis prints, and those of designs.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::support::{read, root, said, sgc};

/// A variant of `morphology` with a novelty set, in a folder of its own.
fn grammar(folder: &Path, name: &str, imports: &str, edits: &str) -> PathBuf {
    let base = root().join("grammars/morphology.sgr");
    let file = folder.join(format!("{name}.sgr"));
    let text = format!("{imports}\nvariant {name} of \"{}\" {{ {edits} }}\n", base.display());
    std::fs::write(&file, text).unwrap();
    file
}

fn literature(folder: &Path, name: &str, edits: &str) -> PathBuf {
    grammar(folder, name, "use std.novelty { literature }", edits)
}

fn novelty(arguments: &[&str]) -> (i32, String) {
    let output = sgc(&root(), &[&["novelty"], arguments].concat());
    (output.status.code().unwrap(), said(&output))
}

fn json(arguments: &[&str]) -> Value {
    let output = sgc(&root(), &[&["novelty"], arguments, &["--format", "json"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn path(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn run(grammar: &Path, out: &Path, evaluations: &str) -> String {
    let run = ["run", path(grammar), "--max-evals", evaluations, "--quiet", "--out", path(out)];
    let output = sgc(&root(), &run);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    path(out).to_owned()
}

/// The scores of the designs of a document, in their order.
fn scores(document: &Value) -> Vec<f64> {
    let designs = document["designs"].as_array().unwrap();
    designs.iter().map(|design| design["score"].as_f64().unwrap()).collect()
}

#[test]
fn the_literature_has_the_scores_of_the_thesis() {
    let folder = tempfile::tempdir().unwrap();
    let grammar = literature(folder.path(), "novel", "");
    let scores = scores(&json(&[path(&grammar)]));
    let printed = [
        "17.3", "22.0", "26.0", "30.7", "43.3", "27.3", "20.7", "20.7", "17.3", "19.3", "15.3", "20.0",
        "15.3", "21.3", "15.3",
    ];
    let rounded: Vec<String> = scores.iter().map(|score| format!("{score:.1}")).collect();
    assert_eq!(rounded, printed);
    let mean = scores[..11].iter().sum::<f64>() / 11.0;
    assert_eq!(format!("{mean:.1}"), "23.6");
    let (code, table) = novelty(&[path(&grammar)]);
    assert_eq!(code, 0);
    assert!(table.contains("Onal and Rus") && table.contains("15 designs in the set"), "{table}");
    let (_, csv) = novelty(&[path(&grammar), "--format", "csv"]);
    assert_eq!(csv.lines().count(), 1 + 15 * 6, "{csv}");
    assert!(
        csv.contains("\"Tolley et al., walking\",true,22") && csv.contains(",locomotion,walking,3,8\n"),
        "{csv}"
    );
}

#[test]
fn designs_belong_to_the_set() {
    let folder = tempfile::tempdir().unwrap();
    let grammar = literature(folder.path(), "novel", "");
    let one = run(&grammar, &folder.path().join("one"), "20");
    // The same design in another layout: a copy would be refused.
    let same = folder.path().join("same.design.json");
    let text = std::fs::read_to_string(folder.path().join("one/best.design.json")).unwrap();
    std::fs::write(&same, format!("{text}\n\n")).unwrap();
    let same = same.to_string_lossy().into_owned();
    let document = json(&[&one, &same]);
    assert_eq!(document["size"], 17);
    let designs = document["designs"].as_array().unwrap();
    let [.., first, second] = designs.as_slice() else { panic!("{document}") };
    assert_eq!((&first["name"], &first["known"]), (&Value::from(one.as_str()), &Value::from(false)));
    assert_eq!((&first["features"], &first["score"]), (&second["features"], &second["score"]));
    for feature in first["features"].as_array().unwrap() {
        assert!(feature["count"].as_u64().unwrap() >= 2, "the two are alike: {feature}");
    }
    let value = |name: &str| {
        let features = first["features"].as_array().unwrap();
        features.iter().find(|f| f["feature"] == name).unwrap()["value"].as_str().unwrap().to_owned()
    };
    assert_eq!(value("bending"), "both_ways");
    // Scores are relative to the set: alone, the design has another.
    assert_ne!(json(&[&one])["designs"][15]["score"], first["score"]);

    // A weight is the user's; what does not count adds nothing.
    let heavy = literature(
        folder.path(),
        "heavy",
        "set literature.actuators.weight = 2  set literature.bending.weight = 0",
    );
    let weighed = json(&[&one, "--grammar", path(&heavy)]);
    let of = |document: &Value, feature: usize| {
        document["designs"][0]["features"][feature]["score"].as_f64().unwrap()
    };
    let plain = json(&[&one]);
    assert_eq!(of(&weighed, 0), 2.0 * of(&plain, 0));
    assert_eq!(of(&weighed, 5), 0.0);
}

#[test]
fn what_cannot_be_scored_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let says = |arguments: &[&str], code: i32, words: &str| {
        let (got, text) = novelty(arguments);
        assert!(got == code && text.contains(words), "{arguments:?}: {got} {text}");
    };
    let novel = literature(folder.path(), "novel", "");
    let none = grammar(folder.path(), "none", "", "");
    let mine = "novelty mine { feature parts = count(part) known \"a\" { parts = 3 } }";
    let other = grammar(folder.path(), "other", mine, "");
    let both = grammar(folder.path(), "both", &format!("use std.novelty {{ literature }}\n{mine}"), "");
    says(&[path(&none)], 1, "has no novelty set: import one");
    says(&[path(&both)], 2, "has several novelty sets: name one with --set (");
    says(&[path(&both), "--set", "mine"], 0, "1 design in the set");
    says(&[path(&novel), "--set", "literatur"], 2, "did you mean `literature`?");
    says(&[path(&novel), path(&other)], 2, "only one grammar can give the novelty set");
    says(&[], 2, "required");
    says(&[path(&folder.path().join("nowhere"))], 2, "cannot read");

    // One evaluation: the initial design, which has no actuators.
    let bare = run(&novel, &folder.path().join("bare"), "1");
    says(&[&bare], 1, "its feature `connections` has no value: there are no values to combine here");
    says(&[&bare, &bare], 2, "is named twice");
    // By another path, too.
    says(&[&bare, &format!("{bare}/../bare")], 2, "is named twice");
    says(&[&bare, "--variant", "novel"], 2, "name that, too");
    let plain = run(&none, &folder.path().join("plain"), "1");
    says(&[&plain], 1, "the grammar `none` has no novelty set");
    let others = run(&other, &folder.path().join("others"), "1");
    says(&[&others], 0, "2 designs in the set");
    let moved = run(&novel, &folder.path().join("moved"), "20");
    says(&[&moved, &others], 1, "which has another novelty set: judge all designs by one grammar");
    says(&[&moved, &others, "--grammar", path(&other)], 0, "3 designs in the set");
    says(
        &[&plain, "--grammar", path(&other)],
        0,
        "was made by `none`: here it is simulated with the model, the time and the target of `other`",
    );
}

#[test]
fn the_documentation_says_what_is_printed() {
    let folder = tempfile::tempdir().unwrap();
    let (_, table) = novelty(&[path(&literature(folder.path(), "novel", ""))]);
    for line in table.lines().skip(1) {
        let line = line.trim_end();
        assert!(read("docs/novelty.md").contains(line), "docs/novelty.md lacks: {line}");
    }
}
