//! Studies: many runs in one folder, done by one process or several, stopped, failed and tried again.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use crate::support::{codesign, root, said, sgc};

/// A grammar with short motions, and a study of it.
fn begin(folder: &Path, study: &str) {
    let text = codesign().replace("for 20 s", "for 2 s");
    std::fs::write(folder.join("quick.sgr"), text).unwrap();
    std::fs::write(folder.join("legs.toml"), study).unwrap();
}

/// Four cells of two runs.
const EIGHT: &str = "question = \"Do parts matter?\"\ngrammar = \"quick.sgr\"\nevaluations = [20, 40]\nseeds = \"1..2\"\n\
                     [parameters]\nmax_parts = [6, 12]\n";

fn ok(output: &Output) -> String {
    assert!(output.status.success(), "{}", said(output));
    said(output)
}

/// What the runs of a study left that is the same each time, by path.
fn results(study: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for cell in std::fs::read_dir(study.join("runs")).unwrap() {
        for run in std::fs::read_dir(cell.unwrap().path()).unwrap() {
            // A process that is killed as it makes a folder leaves one that no run is in.
            if run.as_ref().unwrap().file_name().to_string_lossy().starts_with('.') {
                continue;
            }
            for name in ["best.design.json", "evals.csv", "result.json"] {
                let file = run.as_ref().unwrap().path().join(name);
                found.insert(file.strip_prefix(study).unwrap().to_owned(), std::fs::read(&file).unwrap());
            }
        }
    }
    found
}

#[test]
fn a_study_does_all_its_runs_and_says_what_matters() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    begin(place, EIGHT);
    let plan = ok(&sgc(place, &["study", "legs.toml", "--plan"]));
    assert!(plan.contains("8 runs (2 of max_parts x 2 of evaluations x 2 seeds)"), "{plan}");
    assert!(plan.contains("quick,max_parts=12,evaluations=40/seed-2"), "{plan}");
    assert!(!place.join("studies").exists(), "a plan writes nothing");

    let told = ok(&sgc(place, &["study", "legs.toml"]));
    assert!(told.contains("8 of 8: ") && told.contains("8 of 8 runs are complete"), "{told}");
    let study = place.join("studies/legs");
    let status = ok(&sgc(place, &["study", "status", "studies/legs"]));
    assert_eq!(status, "complete   8\nall        8\n");
    let page = std::fs::read_to_string(study.join("report/index.html")).unwrap();
    for part in ["Do parts matter?", "What matters", "<b>max_parts</b>", "<b>evaluations</b>", "<svg"] {
        assert!(page.contains(part), "{part}");
    }
    let table = std::fs::read_to_string(study.join("report/runs.csv")).unwrap();
    assert_eq!(table.lines().count(), 9, "{table}");
    assert!(table.starts_with("run,grammar,max_parts,evaluations,seed,standing,value,unit,"), "{table}");
    let effects = std::fs::read_to_string(study.join("report/effects.csv")).unwrap();
    assert_eq!(effects.lines().count(), 7, "{effects}");

    // The run alone is the same, and so is what other commands say of the run.
    let run = study.join("runs/quick,max_parts=6,evaluations=40/seed-2");
    let asked = std::fs::read_to_string(run.join("run.toml")).unwrap();
    let command = "sgc run quick.sgr -p max_parts=6 --max-evals 40 --seed 2";
    assert!(asked.contains(command), "{asked}");
    let alone: Vec<&str> = command.split(' ').skip(1).chain(["--out", "alone", "--quiet"]).collect();
    ok(&sgc(place, &alone));
    for name in ["best.design.json", "evals.csv"] {
        let [one, other] = [&run, &place.join("alone")].map(|run| std::fs::read(run.join(name)).unwrap());
        assert!(one == other, "{name}");
    }
    for command in ["eval", "view", "report"] {
        ok(&sgc(place, &[command, run.to_str().unwrap()]));
    }
    // Nothing is done twice, and a file that lists more adds to what is there.
    let before = results(&study);
    ok(&sgc(place, &["study", "legs.toml"]));
    assert!(results(&study) == before);
    begin(place, &EIGHT.replace("[6, 12]", "[6, 12, 9]"));
    let told = ok(&sgc(place, &["study", "legs.toml", "--plan"]));
    assert!(told.contains("new runs: 4, removed runs: 0"), "{told}");
    let status = ok(&sgc(place, &["study", "status", "studies/legs"]));
    assert_eq!(status, "complete   8\nall        8\n", "a plan writes nothing");
    // A file of the same name in another folder is another study.
    std::fs::create_dir(place.join("other")).unwrap();
    begin(&place.join("other"), "grammar = \"quick.sgr\"\nevaluations = 20\n");
    let other = sgc(place, &["study", "other/legs.toml"]);
    assert_eq!(other.status.code(), Some(2), "{}", said(&other));
    assert!(said(&other).contains("is the folder of another study"), "{}", said(&other));
}

/// What others have put or changed in the folder of a study stays.
#[test]
fn what_is_somebodys_in_a_folder_stays() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    begin(place, "grammar = \"quick.sgr\"\nevaluations = 20\n");
    let write = |path: &str, text: &str| std::fs::write(place.join(path), text).unwrap();
    let read = |path: &str| std::fs::read_to_string(place.join(path)).unwrap();
    std::fs::create_dir(place.join("out")).unwrap();
    write("out/study.toml", "mine");
    for command in [
        &["study", "legs.toml", "--out", "out"][..],
        &["study", "submit", "legs.toml", "--to", "slurm", "--out", "out"],
    ] {
        let refused = sgc(place, command);
        assert_eq!(refused.status.code(), Some(2), "{}", said(&refused));
        assert!(said(&refused).contains("out contains \"study.toml\", but no study"), "{}", said(&refused));
        assert_eq!(read("out/study.toml"), "mine");
    }
    #[cfg(unix)]
    {
        std::fs::create_dir(place.join("linked")).unwrap();
        write("precious", "mine");
        std::os::unix::fs::symlink("../precious", place.join("linked/study.toml")).unwrap();
        assert_eq!(sgc(place, &["study", "legs.toml", "--out", "linked"]).status.code(), Some(2));
        assert_eq!(read("precious"), "mine");
    }
    ok(&sgc(place, &["study", "legs.toml", "--quiet"]));
    let table = "studies/legs/report/runs.csv";
    let whole = read(table);
    write("studies/legs/report/notes.txt", "mine");
    ok(&sgc(place, &["study", "gather", "studies/legs"]));
    write(table, &format!("{whole}my row\n"));
    let refused = sgc(place, &["study", "gather", "studies/legs"]);
    assert_eq!(refused.status.code(), Some(2), "{}", said(&refused));
    assert!(said(&refused).contains("runs.csv") && read(table).ends_with("my row\n"), "{}", said(&refused));
    ok(&sgc(place, &["study", "gather", "studies/legs", "--force"]));
    assert_eq!((read(table), read("studies/legs/report/notes.txt")), (whole, "mine".to_owned()));
}

#[test]
fn what_is_in_the_place_of_a_run_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    begin(place, "grammar = \"quick.sgr\"\nevaluations = 20\nseeds = 2\n");
    ok(&sgc(place, &["study", "legs.toml", "--quiet"]));
    let runs = sgc(place, &["study", "legs.toml", "--plan"]);
    let runs = String::from_utf8(runs.stdout).unwrap();
    let taken = place.join("studies/legs/runs").join(runs.lines().next().unwrap());
    std::fs::remove_dir_all(&taken).unwrap();
    std::fs::create_dir_all(&taken).unwrap();
    std::fs::write(taken.join("notes.txt"), "mine").unwrap();
    let refused = sgc(place, &["study", "legs.toml"]);
    assert!(said(&refused).contains("contains \"notes.txt\": move this elsewhere"), "{}", said(&refused));
    assert!(!said(&refused).contains("under way"), "{}", said(&refused));
    assert_ne!(refused.status.code(), Some(75));
    assert_eq!(std::fs::read_to_string(taken.join("notes.txt")).unwrap(), "mine");
    std::fs::remove_dir_all(&taken).unwrap();
    ok(&sgc(place, &["study", "retry", "studies/legs"]));
    ok(&sgc(place, &["study", "legs.toml", "--quiet"]));
}

#[cfg(unix)]
#[test]
fn a_script_is_not_written_for_a_path_that_it_cannot_hold() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("two\nlines");
    std::fs::create_dir(&place).unwrap();
    begin(&place, "grammar = \"quick.sgr\"\nevaluations = 20\n");
    let refused = sgc(&place, &["study", "submit", "legs.toml", "--to", "slurm"]);
    assert_eq!(refused.status.code(), Some(2), "{}", said(&refused));
    assert!(said(&refused).contains("move the study elsewhere"), "{}", said(&refused));
    assert!(!place.join("studies/legs/submissions").exists());
}

#[test]
fn several_processes_and_kills_change_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    begin(place, EIGHT);
    ok(&sgc(place, &["study", "legs.toml", "--quiet", "--out", "whole"]));
    let start = || {
        let mut command = Command::new(env!("CARGO_BIN_EXE_sgc"));
        command.args(["study", "legs.toml", "--out", "pieces", "--jobs", "1", "--checkpoint", "1s"]);
        command.current_dir(place).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
    };
    let mut done = false;
    for round in 0..40 {
        let both = [start(), start()];
        if round < 4 {
            std::thread::sleep(Duration::from_millis(400 + 150 * round));
            let way = ["-KILL", "-TERM"][round as usize % 2];
            for child in &both {
                let _ = Command::new("kill").args([way, &child.id().to_string()]).status();
            }
        }
        for child in both {
            let ended = child.wait_with_output().unwrap();
            assert!(matches!(ended.status.code(), None | Some(0 | 75)), "{}", said(&ended));
        }
        // On a busy machine the first may be killed before they plan.
        if !place.join("pieces/plan.json").exists() {
            continue;
        }
        done = ok(&sgc(place, &["study", "status", "pieces"])) == "complete   8\nall        8\n";
        if done {
            break;
        }
    }
    assert!(done);
    assert!(results(&place.join("whole")) == results(&place.join("pieces")));
}

#[test]
fn what_failed_waits_until_it_is_tried_again() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    begin(place, "grammar = \"quick.sgr\"\nevaluations = 40\nseeds = [1, 2]\n");
    ok(&sgc(place, &["study", "submit", "legs.toml", "--to", "slurm"]));
    // A run that cannot be gone on with.
    let run = place.join("studies/legs/runs/quick,evaluations=40/seed-2");
    ok(&sgc(
        place,
        &["run", "quick.sgr", "--seed", "2", "--max-evals", "40", "--quiet", "--out", run.to_str().unwrap()],
    ));
    std::fs::remove_file(run.join("result.json")).unwrap();
    let best = run.join("best.design.json");
    let design = std::fs::read_to_string(&best).unwrap();
    let told = sgc(place, &["study", "legs.toml"]);
    assert_eq!(told.status.code(), Some(2), "{}", said(&told));
    assert!(said(&told).contains("seed-2 failed: "), "{}", said(&told));
    let status = said(&sgc(place, &["study", "status", "studies/legs"]));
    assert!(
        status.contains("complete   1\nfailed     1\n") && status.contains("has no checkpoint"),
        "{status}"
    );
    // It is left alone.
    let again = sgc(place, &["study", "legs.toml"]);
    assert_eq!(again.status.code(), Some(1), "{}", said(&again));
    // A design that somebody has edited is not removed.
    let edited = design.replacen("\"sum\": \"", "\"sum\": \"0", 1);
    assert_ne!(edited, design);
    std::fs::write(&best, &edited).unwrap();
    let refused = sgc(place, &["study", "retry", "studies/legs", "--anew"]);
    assert_eq!(refused.status.code(), Some(2), "{}", said(&refused));
    assert!(said(&refused).contains("best.design.json was changed since"), "{}", said(&refused));
    assert_eq!(std::fs::read_to_string(&best).unwrap(), edited);
    std::fs::write(&best, &design).unwrap();
    let told = ok(&sgc(place, &["study", "retry", "studies/legs"]));
    assert!(told.contains("one run waits again"), "{told}");
    ok(&sgc(place, &["study", "legs.toml"]));
    // A result that was damaged afterwards is left out, until it is begun anew by its name.
    std::fs::write(run.join("result.json"), "{").unwrap();
    let gathered = sgc(place, &["study", "gather", "studies/legs"]);
    assert_eq!(gathered.status.code(), Some(1), "{}", said(&gathered));
    let told = said(&gathered);
    let name = "quick,evaluations=40/seed-2";
    assert!(told.contains(&format!("{name} is left out: ")) && told.contains("1 of 2 runs"), "{told}");
    assert!(told.contains(&format!("retry studies/legs --anew --run {name}")), "{told}");
    ok(&sgc(place, &["study", "retry", "studies/legs", "--anew", "--run", name]));
    let told = ok(&sgc(place, &["study", "studies/legs"]));
    assert!(told.contains("2 of 2 runs are complete"), "{told}");
}

#[test]
fn a_submission_has_what_is_not_complete_and_its_tasks_do_it() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    begin(place, EIGHT);
    for (engine, variable) in [("slurm", "SLURM_ARRAY_TASK_ID"), ("hq", "HQ_TASK_ID")] {
        let out = format!("study of {engine}");
        let arguments = [
            "study",
            "submit",
            "legs.toml",
            "--out",
            &out,
            "--to",
            engine,
            "--runs-per-task",
            "3",
            "--minutes",
            "9",
        ];
        let shown =
            ok(&sgc(place, &[&arguments[..], &["--line", "export X=1", "--option", "--nice"]].concat()));
        assert!(shown.contains("8 runs in 3 tasks"), "{shown}");
        let script = place.join(&out).join(format!("submissions/1/{engine}.sh"));
        let text = std::fs::read_to_string(&script).unwrap();
        for part in [
            "--array=0-2",
            "\nset -eo pipefail\nexport X=1\nset +eo pipefail\n",
            " --nice\n",
            variable,
            "study of ",
        ] {
            assert!(text.contains(part), "{part}: {text}");
        }
        // A path with a space is one word, also in directives.
        let logs = text.lines().filter(|line| line.contains("put=") || line.contains("stdout="));
        assert!(logs.clone().count() > 0 && logs.clone().all(|line| line.ends_with(".log\"")), "{text}");
        // As the engine would start it; scontrol is not there.
        for task in ["0", "2", "1"] {
            let script =
                Command::new("bash").arg(&script).env(variable, task).current_dir("/").output().unwrap();
            ok(&script);
        }
        assert_eq!(ok(&sgc(place, &["study", "status", &out])), "complete   8\nall        8\n");
        let beyond = ["study", "work", &out, "--submission", "1", "--task", "3", "--runs-per-task", "3"];
        let beyond = sgc(place, &beyond);
        assert_eq!(beyond.status.code(), Some(2), "{}", said(&beyond));
        assert!(said(&beyond).contains("make the tasks 0 to 2"), "{}", said(&beyond));
        let nothing = ok(&sgc(place, &arguments));
        assert!(nothing.contains("there is nothing to submit"), "{nothing}");
    }
    let [one, other] = ["study of slurm", "study of hq"].map(|name| results(&place.join(name)));
    assert!(one == other);
}

#[test]
fn a_wrong_study_runs_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    let fails = |study: &str, code: i32, told: &str| {
        begin(place, study);
        let output = sgc(place, &["study", "legs.toml"]);
        assert_eq!(output.status.code(), Some(code), "{study}\n{}", said(&output));
        assert!(said(&output).contains(told), "{study}\n{}", said(&output));
        assert!(!place.join("studies").exists(), "{study}");
    };
    fails("grammar = \"quick.sgr\"\nparameters = { max_part = 3 }\n", 1, "did you mean `max_parts`?");
    fails(
        "grammar = \"quick.sgr\"\nparameters = { max_parts = \"3 cm\" }\n",
        1,
        "`max_parts = 3 cm` is not a Count",
    );
    fails("grammar = \"quick.sgr\"\nparameters = { max_part = 3 }\n", 1, "given by the study");
    fails("grammar = \"quack.sgr\"\n", 2, "there is no such file: did you mean `quick.sgr`?");
    fails("grammar = \"quick.sgr\"\nvariant = \"soft\"\n", 1, "soft");
    fails("grammar = \"quick.sgr\"\nfrom = \"best\"\n", 1, "no example `best`");
    fails("grammar = 3.5\n", 2, "line 1");
    let twice = "grammar = \"quick.sgr\"\nparameters = { max_parts = [6, \"6.0\"] }\n";
    fails(twice, 2, "are the same; leave one of their values out");
    fails("grammar = \"quick.sgr\"\nseedz = 3\n", 2, "unknown field `seedz`");
    let shepherd = root().join("grammars/shepherd.sgr");
    let both = format!("grammar = [\"quick.sgr\", \"{}\"]\n", shepherd.display());
    fails(&both, 2, "they cannot be compared in one study");
}

#[test]
fn a_study_goes_on_only_as_it_began() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    begin(place, "grammar = \"quick.sgr\"\nevaluations = 20\nseeds = 1\n");
    ok(&sgc(place, &["study", "legs.toml", "--quiet"]));
    let fails = |told: &str| {
        let output = sgc(place, &["study", "legs.toml"]);
        assert_eq!(output.status.code(), Some(2), "{}", said(&output));
        assert!(said(&output).contains(told), "{}", said(&output));
    };
    // It is the same from wherever the command is given.
    let elsewhere = place.join("elsewhere");
    std::fs::create_dir(&elsewhere).unwrap();
    let out = place.join("studies/legs");
    for (from, file) in [
        (place, "./legs.toml"),
        (&elsewhere, "../legs.toml"),
        (&elsewhere, place.join("legs.toml").to_str().unwrap()),
    ] {
        let told = ok(&sgc(from, &["study", file, "--out", out.to_str().unwrap()]));
        assert!(told.contains("1 of 1 runs are complete") && !told.contains("was changed"), "{told}");
    }
    let text = std::fs::read_to_string(place.join("quick.sgr")).unwrap();
    std::fs::write(place.join("quick.sgr"), text.replace("for 2 s", "for 3 s")).unwrap();
    // A cell that leaves the study, and comes back with another text.
    std::fs::write(place.join("legs.toml"), "grammar = \"quick.sgr\"\nevaluations = 30\nseeds = 1\n")
        .unwrap();
    ok(&sgc(place, &["study", "legs.toml", "--quiet"]));
    std::fs::write(place.join("legs.toml"), "grammar = \"quick.sgr\"\nevaluations = 20\nseeds = 1\n")
        .unwrap();
    fails("seed-1 is an earlier run with another text of its grammar");
    std::fs::remove_dir_all(place.join("studies")).unwrap();
    std::fs::write(place.join("quick.sgr"), &text).unwrap();
    ok(&sgc(place, &["study", "legs.toml", "--quiet"]));
    std::fs::write(place.join("quick.sgr"), text.replace("for 2 s", "for 3 s")).unwrap();
    fails("quick.sgr was changed (its earlier text is studies/legs/texts/");
    std::fs::write(place.join("quick.sgr"), text).unwrap();
    let plan = place.join("studies/legs/plan.json");
    let own = std::fs::read_to_string(&plan).unwrap();
    std::fs::write(&plan, own.replace(env!("CARGO_PKG_VERSION"), "0.0.1")).unwrap();
    fails("was begun by sgc 0.0.1");
    std::fs::write(&plan, own.replace("\"quick,evaluations=20\"", "\"../quick\"")).unwrap();
    fails("its cell \"../quick\" is not as sgc writes one");
    // What somebody changed in the plan is not mistaken for what was asked.
    let edited = own.replacen("\"max_evals\": ", "\"max_evals\": 1", 1);
    assert_ne!(edited, own);
    std::fs::write(&plan, edited).unwrap();
    fails("plan.json is damaged: it was changed since sgc wrote it");
    std::fs::write(&plan, &own).unwrap();
    let copy = out.join("study.toml");
    let copied = std::fs::read_to_string(&copy).unwrap();
    std::fs::write(&copy, "my notes").unwrap();
    fails("study.toml was changed since sgc wrote it");
    assert_eq!(std::fs::read_to_string(&copy).unwrap(), "my notes");
    std::fs::write(&copy, copied).unwrap();
    std::fs::write(&plan, &own[..own.len() / 2]).unwrap();
    fails("plan.json is damaged");
    std::fs::remove_file(&plan).unwrap();
    fails("but no study; choose another folder with --out");
}
