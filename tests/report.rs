//! Reports of real runs, and of folders that are not as they should be.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::support::{codesign, forged, root};

fn sgc(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_sgc"))
        .args(arguments)
        .current_dir(root())
        .env("NO_COLOR", "1")
        .output()
        .unwrap()
}

fn errors(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn assert_code(output: &Output, code: i32) {
    assert_eq!(output.status.code(), Some(code), "{}", errors(output));
}

fn path(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn read(path: PathBuf) -> String {
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Two short runs of one grammar, followed by a page.
fn two_runs(folder: &Path, seed: &str, out: &str) -> PathBuf {
    let text = codesign();
    let grammar = folder.join("quick.sgr");
    std::fs::write(&grammar, text.replace("for 20 s", "for 1 s")).unwrap();
    let out = folder.join(out);
    let run = ["run", path(&grammar), "--seed", seed, "--runs", "2", "--max-evals", "80", "--live"];
    let output = sgc(&[&run[..], &["--out", path(&out)]].concat());
    assert_code(&output, 0);
    assert!(errors(&output).contains("report/index.html"), "{}", errors(&output));
    out
}

#[test]
fn a_report_of_two_runs_says_what_their_tables_say() {
    let folder = tempfile::tempdir().unwrap();
    let runs = two_runs(folder.path(), "4", "runs");
    let followed = read(runs.join("report/index.html"));
    assert!(!followed.contains("http-equiv=\"refresh\""), "the last page follows nothing any more");

    let output = sgc(&["report", path(&runs)]);
    assert_code(&output, 0);
    assert_eq!(String::from_utf8_lossy(&output.stdout).trim(), path(&runs.join("report/index.html")));
    let page = read(runs.join("report/index.html"));
    assert_eq!(page, followed, "the runs wrote the same at their end");
    assert_eq!(page.matches("<figure class=\"card\">").count(), 2);
    assert!(!page.contains("class=\"lost\"") && page.contains("class=\"solid\""), "both designs are drawn");
    assert!(!page.contains("<script"), "nothing runs in it");
    assert!(page.contains("evaluations a second") && !page.contains("unknown"), "the time is known");

    // What the report says is in the runs' own files.
    let table = read(runs.join("report/runs.csv"));
    let summary = read(runs.join("summary.csv"));
    for (ours, theirs) in table.lines().zip(summary.lines()).skip(1) {
        let (ours, theirs): (Vec<&str>, Vec<&str>) = (ours.split(',').collect(), theirs.split(',').collect());
        assert_eq!((ours[1], ours[2], ours[4]), (theirs[0], theirs[1], theirs[3]), "{table}{summary}");
    }
    let applied: usize = ["seed-4", "seed-5"]
        .iter()
        .map(|seed| {
            read(runs.join(seed).join("evals.csv"))
                .lines()
                .skip(2)
                .filter(|l| l.split(',').nth(2) != Some(""))
                .count()
        })
        .sum();
    let rules = read(runs.join("report/rules.csv"));
    let counted: usize =
        rules.lines().skip(1).map(|l| l.split(',').nth(4).unwrap().parse::<usize>().unwrap()).sum();
    assert_eq!(counted, applied, "{rules}");

    // A page of a run is linked; one run has a report, too, and a folder with a report can be replaced.
    assert_code(&sgc(&["view", path(&runs.join("seed-4"))]), 0);
    assert_code(&sgc(&["report", path(&runs)]), 0);
    assert!(read(runs.join("report/index.html")).contains("href=\"../seed-4/view.html\""));
    assert_code(&sgc(&["report", path(&runs.join("seed-5"))]), 0);
    assert!(runs.join("seed-5/report/index.html").exists());
    two_runs_again_by_force(folder.path(), &runs);
}

fn two_runs_again_by_force(folder: &Path, runs: &Path) {
    let grammar = folder.join("quick.sgr");
    let run = ["run", path(&grammar), "--seed", "4", "--runs", "2", "--max-evals", "3", "--out", path(runs)];
    assert_code(&sgc(&[&run[..], &["--force"]].concat()), 0);
    assert!(!runs.join("report").exists());
    std::fs::create_dir(runs.join("report")).unwrap();
    std::fs::write(runs.join("report/notes.txt"), "mine").unwrap();
    assert_code(&sgc(&[&run[..], &["--force"]].concat()), 2);
    let output = sgc(&["report", path(runs)]);
    assert_code(&output, 2);
    assert!(errors(&output).contains("\"notes.txt\", which no report wrote"), "{}", errors(&output));
}

#[test]
fn a_report_replaces_only_what_a_report_wrote() {
    let folder = tempfile::tempdir().unwrap();
    let runs = two_runs(folder.path(), "4", "one");
    let out = folder.path().join("site");
    let report = |more: &[&str]| sgc(&[&["report", path(&runs), "--out", path(&out)][..], more].concat());
    for name in ["index.html", "runs.csv"] {
        std::fs::create_dir_all(&out).unwrap();
        std::fs::write(out.join(name), "mine").unwrap();
        let output = report(&[]);
        assert_code(&output, 2);
        assert!(errors(&output).contains(name) && errors(&output).contains("--force"), "{}", errors(&output));
        assert_eq!(read(out.join(name)), "mine");
        assert_code(&report(&["--force"]), 0);
        // What a report wrote is replaced, as long as nobody has edited the page.
        assert_code(&report(&[]), 0);
        std::fs::write(out.join("index.html"), read(out.join("index.html")).replace("<h1>", "<h1>My "))
            .unwrap();
        let output = report(&[]);
        assert_code(&output, 2);
        assert!(errors(&output).contains("\"index.html\""), "{}", errors(&output));
        std::fs::remove_dir_all(&out).unwrap();
    }
}

#[test]
fn groups_are_compared_and_damage_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let (one, other) = (two_runs(folder.path(), "4", "one"), two_runs(folder.path(), "6", "other"));
    let out = folder.path().join("compared");
    let report = |folders: &[&Path]| {
        let folders: Vec<&str> = folders.iter().map(|folder| path(folder)).collect();
        sgc(&[&["report", "--out", path(&out)][..], &folders].concat())
    };
    assert_code(&report(&[&one, &other]), 0);
    let page = read(out.join("index.html"));
    assert!(page.contains("Of all pairs of runs, one of each group, one is better than other"), "{page}");
    assert_eq!(read(out.join("runs.csv")).lines().count(), 5);

    let says = |folders: &[&Path], says: &str| {
        let output = report(folders);
        assert_code(&output, 2);
        assert!(errors(&output).contains(says), "{says}: {}", errors(&output));
    };
    says(&[&one, &one], "is named twice");
    let within = one.join(
        std::fs::read_dir(&one)
            .unwrap()
            .map(|e| e.unwrap().file_name())
            .find(|n| n.to_string_lossy().starts_with("seed-"))
            .unwrap(),
    );
    says(&[&one, &within], "is named twice");
    says(&[&folder.path().join("nowhere")], "there is no folder");
    says(&[folder.path()], "holds no run");

    // A changed design is told in its place, and all else is shown.
    let design = one.join("seed-4/best.design.json");
    let text = read(design.clone());
    std::fs::write(&design, text.replacen("\"body\": \"", "\"body\": \"0", 1)).unwrap();
    assert_code(&report(&[&one]), 0);
    let page = read(out.join("index.html"));
    assert!(page.contains("was changed after it was saved") && page.matches("class=\"solid\"").count() == 1);
    for (other, told) in [
        (read(other.join("seed-7/best.design.json")), "it belongs to another run"),
        (
            forged(&text.replacen("\"value\": ", "\"value\": 9", 1)),
            "its value differs from that in result.json",
        ),
    ] {
        std::fs::write(&design, other).unwrap();
        assert_code(&report(&[&one]), 0);
        assert!(read(out.join("index.html")).contains(told), "{told}");
    }
    std::fs::write(&design, text.get(..200).unwrap()).unwrap();
    assert_code(&report(&[&one]), 0);
    assert!(read(out.join("index.html")).contains("is not a saved design"));

    // Runs of one folder are of one grammar.
    let asked = one.join("seed-5/run.toml");
    let text = read(asked.clone());
    let rules = text.split("rules = \"").nth(1).expect("a hash of the rules").get(..4).unwrap().to_owned();
    std::fs::write(&asked, text.replacen(&format!("rules = \"{rules}"), "rules = \"0000", 1)).unwrap();
    says(&[&one], "run.toml was changed after the run had ended");
    // Results of earlier versions do not say what they are of.
    let result = one.join("seed-5/result.json");
    let complete = read(result.clone());
    let mut earlier: serde_json::Value = serde_json::from_str(&complete).unwrap();
    for field in ["asked", "sum"] {
        earlier.as_object_mut().unwrap().remove(field).unwrap();
    }
    std::fs::write(&result, earlier.to_string()).unwrap();
    says(&[&one], "are not runs of one grammar");
    std::fs::write(&asked, text).unwrap();
    std::fs::write(&result, complete).unwrap();

    // Nor are runs that were copied over each other, and what a report reads it does not write over.
    let (kept, own) = (folder.path().join("kept"), one.join("seed-5"));
    std::fs::rename(&own, &kept).unwrap();
    std::fs::rename(one.join("seed-4"), &own).unwrap();
    std::fs::rename(&kept, one.join("seed-4")).unwrap();
    says(&[&one], "holds a run of seed 5");
    std::fs::rename(one.join("seed-4"), &kept).unwrap();
    std::fs::rename(&own, one.join("seed-4")).unwrap();
    std::fs::rename(&kept, &own).unwrap();
    #[cfg(unix)]
    {
        let (table, before) = (own.join("evals.csv"), read(own.join("evals.csv")));
        std::fs::remove_file(out.join("runs.csv")).unwrap();
        std::os::unix::fs::symlink(&table, out.join("runs.csv")).unwrap();
        says(&[&one], "which no report wrote there");
        let forced = sgc(&["report", path(&one), "--force", "--out", path(&out)]);
        assert_code(&forced, 2);
        assert!(errors(&forced).contains("is a file that this report is made of"), "{}", errors(&forced));
        assert_eq!(read(table), before);
        std::fs::remove_file(out.join("runs.csv")).unwrap();
    }

    // What a run needs stays, also where it is the run of another report.
    for place in [own.clone(), own.join("sources")] {
        let kept = read(own.join("evals.csv"));
        let forced = sgc(&["report", path(&one.join("seed-4")), "--force", "--out", path(&place)]);
        assert_code(&forced, 2);
        assert!(errors(&forced).contains("is a file of a run, and the run needs it"), "{}", errors(&forced));
        assert_eq!(read(own.join("evals.csv")), kept);
        assert!(!place.join("index.html").exists());
    }

    // The table and the result must agree.
    let result = one.join("seed-5/result.json");
    let text = read(result.clone());
    let mut changed: serde_json::Value = serde_json::from_str(&text).unwrap();
    changed["value"] = serde_json::json!(1000.0);
    std::fs::write(&result, changed.to_string()).unwrap();
    says(&[&one], "result.json is damaged: its contents do not fit its checksum");
    // Earlier versions wrote none.
    changed.as_object_mut().unwrap().remove("sum");
    std::fs::write(&result, changed.to_string()).unwrap();
    says(&[&one], "evals.csv and result.json name different bests");
    std::fs::write(&result, text).unwrap();

    let mut changed: serde_json::Value = serde_json::from_str(&read(result.clone())).unwrap();
    changed["seed"] = serde_json::json!(50);
    changed.as_object_mut().unwrap().remove("sum");
    let text = read(result.clone());
    std::fs::write(&result, changed.to_string()).unwrap();
    says(&[&one], "belongs to grammar codesign and seed 50, but run.toml beside it names others");
    std::fs::write(&result, text).unwrap();

    // What a complete run was asked decides what its result means.
    let run = one.join("seed-5/run.toml");
    let text = read(run.clone());
    std::fs::write(&run, text.replace("\"articulated\"", "\"impulses\"")).unwrap();
    says(&[&one], "run.toml was changed after the run had ended");
    std::fs::write(&run, text).unwrap();

    // What a complete run has counted is not changed afterwards, though each row by itself could be one.
    let evals = one.join("seed-5/evals.csv");
    let text = read(evals.clone());
    std::fs::write(&evals, text.replacen(",true,", ",false,", 1)).unwrap();
    says(&[&one], "evals.csv was changed after the run ended");

    // A killed run may have half a row, a complete one not.
    std::fs::write(&evals, text.get(..text.len() - 5).unwrap()).unwrap();
    says(&[&one], "seed-5/evals.csv is damaged: its last row is not complete");
    std::fs::remove_file(one.join("seed-5/result.json")).unwrap();
    assert_code(&report(&[&one]), 0);
    assert!(read(out.join("index.html")).contains("stopped before its end"));
    std::fs::write(&evals, text.replacen("0,0,,", "0,0,,,", 1)).unwrap();
    says(&[&one], "line 2 has 22 fields, where its first line names 21 columns");
    std::fs::remove_file(&evals).unwrap();
    says(&[&one], "cannot read");
    std::fs::remove_file(one.join("seed-5/run.toml")).unwrap();
    says(&[&one], "it has no run.toml");
    std::fs::write(one.join("runs.toml"), "seeds = [").unwrap();
    says(&[&one], "runs.toml is damaged");
}
