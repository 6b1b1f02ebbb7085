//! Searches for a front of several objectives: the designs that no other is better than in every one.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::support::{codesign, forged, root};

fn sgc(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_sgc"));
    command.args(arguments).current_dir(root()).env("NO_COLOR", "1").output().unwrap()
}

fn said(output: &Output) -> String {
    format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
}

fn path(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// `codesign` with a short motion in one world, and with objectives beside its own.
fn grammar(folder: &Path, beside: &str) -> PathBuf {
    let text = codesign()
        .replace("for 20 s", "for 2 s")
        .replace("travel, fall }", "travel, fall, energy }")
        .replace("{ nested_annealing }", "{ trade_offs }")
        .replace("search   nested_annealing", &format!("{beside}\nsearch trade_offs"));
    assert!(text.contains("energy }") && text.contains(beside), "{text}");
    let file = folder.join("several.sgr");
    std::fs::write(&file, text).unwrap();
    file
}

fn run(grammar: &Path, out: &Path, jobs: &str) -> String {
    let arguments = ["run", path(grammar), "--seed", "3", "--max-evals", "400", "--jobs", jobs, "--out"];
    let output = sgc(&[&arguments[..], &[path(out)]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    said(&output)
}

/// A table by rows of fields.
fn table(file: &Path) -> Vec<Vec<String>> {
    let mut reader = csv::ReaderBuilder::new().has_headers(false).from_path(file).unwrap();
    let rows = reader.records().map(|row| row.unwrap().iter().map(str::to_owned).collect());
    rows.collect()
}

#[test]
fn a_front_holds_what_no_other_body_is_better_than() {
    let folder = tempfile::tempdir().unwrap();
    let grammar = grammar(folder.path(), "minimize energy in J");
    let (out, other) = (folder.path().join("one"), folder.path().join("other"));
    let told = run(&grammar, &out, "1");
    assert!(told.contains("by travel - fall and energy"), "{told}");
    let (_, checked) = told.split_once("each objective, checked:\n").expect("what was checked");
    let half = checked.lines().next().unwrap();
    assert!(half.contains("with half the step, finer contacts: ") && half.contains(" cm, energy "), "{told}");
    run(&grammar, &other, "3");
    let front = table(&out.join("front.csv"));
    assert_eq!(front[0][..4], ["design", "travel - fall (cm)", "energy (J)", "move"]);
    assert_eq!(front, table(&other.join("front.csv")), "threads change nothing");
    let number = |text: &str| text.parse::<f64>().unwrap();
    let moves = table(&out.join("evals.csv"));
    let energy = moves[0].iter().position(|name| name == "objective energy (J)").unwrap();
    let tried: Vec<(f64, f64)> = moves[1..]
        .iter()
        .filter(|row| !row[6].is_empty())
        .map(|row| (number(&row[6]), number(&row[energy])))
        .collect();
    assert!(front.len() > 4 && tried.len() > 20, "{front:?}");
    for row in &front[1..] {
        let own = (number(&row[1]), number(&row[2]));
        let beats = |(travel, energy): &&(f64, f64)| {
            *travel >= own.0 && *energy <= own.1 && (*travel > own.0 || *energy < own.1)
        };
        assert_eq!(tried.iter().find(beats), None, "{row:?}");
        // What is saved comes out again.
        let design = out.join("front").join(&row[0]);
        let again = sgc(&["eval", path(&design)]);
        assert_eq!(again.status.code(), Some(0), "{}", said(&again));
        let energy = format!("and energy {:.4}", own.1);
        let small = own.1 < 5e-4;
        assert!(said(&again).contains("exactly the saved value"), "{}", said(&again));
        assert!(small || said(&again).contains(&energy), "{energy}: {}", said(&again));
    }
    let mut files: Vec<String> = std::fs::read_dir(out.join("front"))
        .unwrap()
        .map(|file| file.unwrap().file_name().into_string().unwrap())
        .collect();
    let mut named: Vec<String> = front[1..].iter().map(|row| row[0].clone()).collect();
    files.sort();
    named.sort();
    assert_eq!(files, named, "what left the front has no file");

    // Each of them has a page, and the report shows and links them.
    let view = sgc(&["view", path(&out)]);
    assert_eq!(view.status.code(), Some(0), "{}", said(&view));
    let report = sgc(&["report", path(&out)]);
    assert_eq!(report.status.code(), Some(0), "{}", said(&report));
    let page = std::fs::read_to_string(out.join("report/index.html")).unwrap();
    let first = named[0].replace(".design.json", ".view.html");
    assert!(page.contains("<h2>The front</h2>") && page.contains(&format!("../front/{first}")), "{page}");
    assert!(page.contains("<code>minimize energy in J</code>"), "{page}");
    let numbers = std::fs::read_to_string(out.join("report/fronts.csv")).unwrap();
    assert!(numbers.contains("energy,") && numbers.contains(",travel - fall,"), "{numbers}");
    // A run with its pages may be replaced as any other.
    let again = sgc(&["run", path(&grammar), "--max-evals", "60", "--force", "--out", path(&out)]);
    assert_eq!(again.status.code(), Some(0), "{}", said(&again));
}

/// What somebody put among the designs of a front stays there, whatever it is called.
#[test]
fn a_front_removes_only_its_own_designs() {
    let folder = tempfile::tempdir().unwrap();
    let grammar = grammar(folder.path(), "minimize energy in J");
    let out = folder.path().join("run");
    let run =
        ["run", path(&grammar), "--max-evals", "100000", "--jobs", "1", "--time", "2s", "--out", path(&out)];
    let stopped = sgc(&run);
    assert_eq!(stopped.status.code(), Some(75), "{}", said(&stopped));
    let own = std::fs::read_dir(out.join("front")).unwrap().next().unwrap().unwrap().path();
    let (notes, kept) = (out.join("front/999991.design.json"), out.join("front/999992.design.json"));
    std::fs::write(&notes, "my notes").unwrap();
    std::fs::copy(&own, &kept).unwrap();
    let text = std::fs::read_to_string(&own).unwrap();
    std::fs::write(&own, text.replacen("\"format\"", "\"mine\": 1, \"format\"", 1)).unwrap();
    let refused = sgc(&["resume", path(&out)]);
    assert_eq!(refused.status.code(), Some(2), "an edited design of the front is kept: {}", said(&refused));
    assert!(said(&refused).contains("move it away"), "{}", said(&refused));
    std::fs::write(&own, text).unwrap();
    let spent = std::fs::read_to_string(out.join("evals.csv")).unwrap();
    let spent: u64 = spent.lines().last().unwrap().split(',').nth(10).unwrap().parse().unwrap();
    let resumed = sgc(&["resume", path(&out), "--max-evals", &(spent + 300).to_string()]);
    assert_eq!(resumed.status.code(), Some(0), "{}", said(&resumed));
    assert_eq!(std::fs::read_to_string(&notes).unwrap(), "my notes");
    assert!(kept.exists());
    let view = sgc(&["view", path(&out)]);
    assert_eq!(view.status.code(), Some(0), "what is not of the front has no page: {}", said(&view));
    assert!(!out.join("front/999992.view.html").exists());
}

#[test]
fn what_another_objective_comes_to_cannot_be_forged() {
    let folder = tempfile::tempdir().unwrap();
    let grammar = grammar(folder.path(), "minimize energy in J");
    let out = folder.path().join("run");
    run(&grammar, &out, "2");
    let text = std::fs::read_to_string(out.join("best.design.json")).unwrap();
    let mut design: serde_json::Value = serde_json::from_str(&text).unwrap();
    design["beside"][0]["value"] = 1e-9.into();
    let design = forged(&design.to_string());
    let file = folder.path().join("forged.design.json");
    std::fs::write(&file, design).unwrap();
    let eval = sgc(&["eval", path(&file)]);
    assert_eq!(eval.status.code(), Some(1), "{}", said(&eval));
    assert!(said(&eval).contains("its value in another objective"), "{}", said(&eval));
}

/// A count of the design can be an objective: prices are told step by step.
/// What somebody put where a design of the front will be is not overwritten; without it, the run goes on.
#[test]
fn a_front_does_not_overwrite_what_is_in_the_place_of_a_design() {
    let folder = tempfile::tempdir().unwrap();
    let grammar = grammar(folder.path(), "minimize energy in J");
    let (whole, out) = (folder.path().join("whole"), folder.path().join("run"));
    let run = |out: &Path, more: &[&str]| {
        let fixed = ["run", path(&grammar), "--max-evals", "1500", "--jobs", "1", "--out", path(out)];
        sgc(&[&fixed[..], more].concat())
    };
    assert_eq!(run(&whole, &[]).status.code(), Some(0));
    let stopped = run(&out, &["--time", "1s"]);
    assert_eq!(stopped.status.code(), Some(75), "{}", said(&stopped));
    let later = std::fs::read_dir(whole.join("front")).unwrap().map(|entry| entry.unwrap().file_name());
    let later = later.map(|name| out.join("front").join(name)).find(|file| !file.exists());
    let notes = later.expect("the front has not changed any more");
    std::fs::write(&notes, "my notes").unwrap();
    let refused = sgc(&["resume", path(&out)]);
    assert_eq!(refused.status.code(), Some(2), "{}", said(&refused));
    assert!(said(&refused).contains("move it away"), "{}", said(&refused));
    assert_eq!(std::fs::read_to_string(&notes).unwrap(), "my notes");
    std::fs::remove_file(&notes).unwrap();
    let resumed = sgc(&["resume", path(&out)]);
    assert_eq!(resumed.status.code(), Some(0), "{}", said(&resumed));
    let table = |out: &Path| std::fs::read_to_string(out.join("front.csv")).unwrap();
    assert_eq!(table(&out), table(&whole));
}

#[test]
fn a_front_over_three_objectives_tells_what_actuators_cost() {
    let folder = tempfile::tempdir().unwrap();
    let grammar = grammar(folder.path(), "minimize energy in J\nminimize count(actuator)");
    let out = folder.path().join("run");
    run(&grammar, &out, "2");
    let front = table(&out.join("front.csv"));
    assert_eq!(front[0][3], "count(actuator)");
    let report = sgc(&["report", path(&out)]);
    assert_eq!(report.status.code(), Some(0), "{}", said(&report));
    let page = std::fs::read_to_string(out.join("report/index.html")).unwrap();
    assert!(page.contains("of count(actuator) costs"), "{page}");
}

/// Where designs are equal by the first objective, the best of a run is none that the front is ahead of.
#[test]
fn the_best_of_a_front_is_on_it() {
    let folder = tempfile::tempdir().unwrap();
    let file = grammar(folder.path(), "maximize travel - fall in cm");
    let text = std::fs::read_to_string(&file).unwrap();
    let text = text.replacen("maximize travel - fall in cm", "minimize count(actuator)", 1);
    std::fs::write(&file, text.replace(", energy }", " }")).unwrap();
    let out = folder.path().join("run");
    run(&file, &out, "2");
    let text = std::fs::read_to_string(out.join("best.design.json")).unwrap();
    let best: serde_json::Value = serde_json::from_str(&text).unwrap();
    let (value, beside) = (best["value"].as_f64().unwrap(), best["beside"][0]["value"].as_f64().unwrap());
    let front = table(&out.join("front.csv"));
    let number = |text: &str| text.parse::<f64>().unwrap();
    let equals: Vec<f64> =
        front[1..].iter().filter(|row| number(&row[1]) == value).map(|row| number(&row[2])).collect();
    assert!(!equals.is_empty() && equals.iter().all(|x| *x <= beside), "{value} {beside} {front:?}");
    // The report names the same design, not the first one with this value.
    assert_eq!(sgc(&["report", path(&out)]).status.code(), Some(0));
    let runs = table(&out.join("report/runs.csv"));
    let column = runs[0].iter().position(|name| name == "found_at_move").unwrap();
    assert_eq!(runs[1][column], best["found_at"].to_string());
}

/// Values of tasks can be traded: each task has its curves, whatever the front is over.
#[test]
fn a_front_over_the_values_of_two_tasks() {
    let folder = tempfile::tempdir().unwrap();
    let text = codesign()
        .replace("for 20 s", "for 2 s")
        .replace("travel, fall }", "travel, fall, turning }")
        .replace("{ nested_annealing }", "{ trade_offs }")
        .replace("maximize travel - fall in cm", "maximize ahead.value in cm\nmaximize around.value in deg")
        .replace("search   nested_annealing", "search trade_offs");
    let tasks = "task ahead { maximize travel - fall in cm }\ntask around { maximize turning in deg }\n";
    let file = folder.path().join("tasks.sgr");
    std::fs::write(&file, text + tasks).unwrap();
    let out = folder.path().join("run");
    run(&file, &out, "2");
    let front = table(&out.join("front.csv"));
    assert_eq!(front[0][1..3], ["ahead.value (cm)", "around.value (deg)"]);
    for row in &front[1..] {
        let again = sgc(&["eval", path(&out.join("front").join(&row[0]))]);
        assert!(said(&again).contains("exactly the saved value"), "{}", said(&again));
    }
}
