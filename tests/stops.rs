//! Runs that are stopped, cut, and what becomes of their folders.

use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use sgc::results::robustness::final_check;
use sgc::results::saved::SavedDesign;
use sgc::simulate::Stop;

use crate::runs::{
    COMPLETE, assert_code, assert_same, begin_long, command, copy, errors, grammar, names, path, sgc, short,
    signal, start, stop_once, whole,
};
use crate::support::codesign;

#[test]
fn a_run_that_is_asked_to_stop_says_how_to_go_on() {
    let folder = tempfile::tempdir().unwrap();
    let quick = grammar(folder.path(), "1");
    let whole = whole(folder.path(), &quick);
    let out = folder.path().join("run");
    let mut arguments = short(&quick, &out);
    for (n, name) in ["-TERM", "-INT", "-HUP"].into_iter().enumerate() {
        let output = stop_once(&out.join("checkpoint"), &arguments, name);
        assert_code(&output, 75);
        assert!(errors(&output).contains(&format!("sgc resume {}", path(&out))), "{}", errors(&output));
        assert!(out.join("checkpoint").exists() && !out.join("result.json").exists(), "{n}");
        arguments = vec!["resume", path(&out), "--quiet", "--checkpoint", "0.001s"];
    }
    assert_code(&sgc(&arguments), 0);
    assert_same(&out, &whole);

    // What is complete stays.
    let output = sgc(&["resume", path(&out)]);
    assert_code(&output, 0);
    assert!(errors(&output).contains("is complete"), "{}", errors(&output));
    let output = sgc(&["resume", path(&out), "--max-evals", "2000"]);
    assert_code(&output, 2);
    assert!(errors(&output).contains("is complete"), "{}", errors(&output));
    assert_same(&out, &whole);
}

/// A run that is ended where it is, after it was killed, ends no earlier than it had come: what it had found is found again.
#[test]
fn ending_a_killed_run_keeps_what_it_had_found() {
    let folder = tempfile::tempdir().unwrap();
    let grammar = grammar(folder.path(), "1");
    let out = folder.path().join("run");
    let arguments = ["run", path(&grammar), "--quiet", "--checkpoint", "1h", "--out", path(&out)];
    let mut child = start(&arguments);
    let rows = || std::fs::read_to_string(out.join("evals.csv")).unwrap_or_default();
    let begun = Instant::now();
    while rows().lines().count() < 12 {
        assert!(begun.elapsed() < Duration::from_secs(100), "{}", rows());
        std::thread::sleep(Duration::from_millis(10));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let table = rows();
    let whole = &table[..=table.rfind('\n').unwrap()];
    assert_code(&sgc(&["resume", path(&out), "--max-evals", "1", "--quiet"]), 0);
    assert!(rows().starts_with(whole), "{}\n{whole}", rows());
    assert_eq!(names(&out), COMPLETE);
}

#[test]
fn a_long_motion_is_given_up_within_a_second() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    let child = begin_long(folder.path(), &out);
    std::thread::sleep(Duration::from_millis(500));
    let asked = Instant::now();
    signal(&child, "-TERM");
    assert_code(&child.wait_with_output().unwrap(), 75);
    // Others may keep the machine busy.
    assert!(asked.elapsed() < Duration::from_secs(5), "{:?}", asked.elapsed());
    assert_code(&sgc(&["eval", path(&out)]), 0);

    // A bound on time ends a process in time, too.
    let begun = Instant::now();
    let output = sgc(&["resume", path(&out), "--time", "1.5s"]);
    assert_code(&output, 75);
    assert!(errors(&output).contains("the time is over"), "{}", errors(&output));
    assert!(begun.elapsed() < Duration::from_secs(10), "{:?}", begun.elapsed());
    // A bound on evaluations that are spent already completes it.
    assert_code(&sgc(&["resume", path(&out), "--max-evals", "1"]), 0);
    assert_eq!(names(&out), COMPLETE);
}

#[test]
fn a_run_is_cut_in_the_middle_of_an_expression_that_takes_hours() {
    let folder = tempfile::tempdir().unwrap();
    let text = codesign();
    let endless = "\nactuation endless for a : actuator {\n  vary level : Angle in 0 rad .. 1 rad mutate 1 by normal(0 rad, 1 rad)\n  \
                   drive angle = level * sin(t * 1 rad/s) * (sum over i in 1 .. 2000, j in 1 .. 2000 of i * j)\n}\n";
    let text = text.replace("with bezier_pac", "with endless") + endless;
    let file = folder.path().join("endless.sgr");
    std::fs::write(&file, text).unwrap();
    let out = folder.path().join("run");
    let begin = ["run", path(&file), "--quiet", "--max-evals", "50", "--out", path(&out)];
    for arguments in [begin.as_slice(), &["resume", path(&out)]] {
        let child = start(arguments);
        std::thread::sleep(Duration::from_millis(1500));
        signal(&child, "-INT");
        let output = child.wait_with_output().unwrap();
        assert_code(&output, 75);
        let told = errors(&output);
        assert!(told.contains("go on from the last checkpoint with: sgc resume"), "{told}");
    }
    assert_code(&sgc(&["eval", path(&out)]), 0);
    // A run that has found nothing yet is not damaged.
    std::fs::remove_file(out.join("best.design.json")).unwrap();
    let output = sgc(&["view", path(&out)]);
    assert_code(&output, 2);
    assert!(errors(&output).contains("has found no design yet"), "{}", errors(&output));
}

#[test]
fn cross_checks_that_were_given_up_are_not_taken_for_checks() {
    let folder = tempfile::tempdir().unwrap();
    let whole = whole(folder.path(), &grammar(folder.path(), "1"));
    let design = SavedDesign::read(&whole.join("best.design.json")).unwrap();
    let rules = design.grammar.compile(&design.sgc).unwrap();
    let mut bare = design.clone();
    bare.tasks[0].checks.clear();
    let flag = AtomicBool::new(true);
    assert!(final_check(&rules, &bare, Stop::new(&flag, None)).is_err());
    assert_eq!(final_check(&rules, &bare, Stop::NEVER).unwrap(), design);
}

#[test]
fn a_terminal_that_has_gone_costs_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    let quick = grammar(folder.path(), "1");
    let mut arguments = short(&quick, &out);
    arguments.retain(|argument| *argument != "--quiet");
    let mut child = command(&arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    // Nobody reads any more.
    drop((child.stdout.take(), child.stderr.take()));
    assert_eq!(child.wait().unwrap().code(), Some(0));
    assert_same(&out, &whole(folder.path(), &quick));
}

#[test]
fn a_folder_belongs_to_one_process() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    let child = begin_long(folder.path(), &out);
    let file = grammar(folder.path(), "20");
    for arguments in [vec!["resume", path(&out)], vec!["run", path(&file), "--force", "--out", path(&out)]] {
        let output = sgc(&arguments);
        assert_code(&output, 2);
        assert!(errors(&output).contains("a run is under way"), "{}", errors(&output));
    }
    signal(&child, "-TERM");
    assert_code(&child.wait_with_output().unwrap(), 75);
    let output = sgc(&["resume", path(&out), "--max-evals", "1"]);
    assert_code(&output, 0);
}

#[test]
fn a_run_goes_on_only_as_it_began() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    let long = grammar(folder.path(), "20");
    assert_code(&sgc(&["run", path(&long), "--time", "2s", "--quiet", "--out", path(&out)]), 75);
    let entry = names(&out.join("sources")).into_iter().find(|name| name.contains("quick")).unwrap();
    let source = format!("sources/{entry}");
    let library = "sources/std.blocks.sgr";
    let text = |name: &str| std::fs::read_to_string(out.join(name)).unwrap();
    let half = text("checkpoint")[..text("checkpoint").len() / 2].to_owned();
    let version = env!("CARGO_PKG_VERSION");
    let spent = text("checkpoint").replacen("\"spent\":", "\"spent\":1", 1);
    for (file, changed, says) in [
        ("checkpoint", half, "checkpoint is damaged"),
        ("checkpoint", "{}".to_owned(), "is not a checkpoint"),
        ("checkpoint", spent, "do not fit its checksum"),
        ("checkpoint", text("checkpoint").replace(version, "0.0.1"), "was written by sgc 0.0.1"),
        (
            "checkpoint",
            text("checkpoint").replacen("\"version\":1", "\"version\":2", 1),
            "is not in format 1",
        ),
        ("run.toml", text("run.toml").replace("seed = 1", "seed = 3"), "run.toml was changed"),
        (&source, text(&source).replace("= 20", "= 21"), "was changed after the run began"),
        (library, text(library) + "\n", "was changed after the run began"),
        ("evals.csv", text("evals.csv").replacen('0', "7", 1), "evals.csv was changed"),
        ("evals.csv", "move\n".to_owned(), "evals.csv was changed"),
        ("best.design.json", "{}".to_owned(), "best.design.json does not belong to this run"),
        (
            "best.design.json",
            text("best.design.json").replace("\"seed\": 1", "\"seed\": 7"),
            "does not belong to this run",
        ),
    ] {
        let damaged = folder.path().join("damaged");
        copy(&out, &damaged);
        assert_ne!(changed, text(file), "{says}");
        std::fs::write(damaged.join(file), &changed).unwrap();
        let output = sgc(&["resume", path(&damaged)]);
        assert_code(&output, 2);
        assert!(errors(&output).contains(says), "{says}: {}", errors(&output));
        assert_eq!(std::fs::read_to_string(damaged.join(file)).unwrap(), changed, "nothing was written");
        std::fs::remove_dir_all(&damaged).unwrap();
    }
    // What was moved away to be kept, with a link in its place, is not the run's any more.
    #[cfg(unix)]
    for own in ["archive", "best.design.json", "evals.csv", "processes.csv"] {
        let (damaged, kept) = (folder.path().join("damaged"), folder.path().join("kept"));
        copy(&out, &damaged);
        std::fs::create_dir(&kept).unwrap();
        let (own, moved) = (damaged.join(own), kept.join(own));
        if own.exists() {
            std::fs::rename(&own, &moved).unwrap();
        } else {
            std::fs::create_dir(&moved).unwrap();
        }
        let before = std::fs::read(&moved).ok();
        std::os::unix::fs::symlink(&moved, &own).unwrap();
        let output = sgc(&["resume", path(&damaged)]);
        assert_code(&output, 2);
        assert!(errors(&output).contains("is a link"), "{}", errors(&output));
        assert_eq!(std::fs::read(&moved).ok(), before);
        std::fs::remove_file(&own).unwrap();
        std::fs::remove_dir_all(&damaged).unwrap();
        std::fs::remove_dir_all(&kept).unwrap();
    }
    for (file, says) in
        [("checkpoint", "has no checkpoint"), ("evals.csv", "cannot read"), ("run.toml", "not a run folder")]
    {
        let damaged = folder.path().join("damaged");
        copy(&out, &damaged);
        std::fs::remove_file(damaged.join(file)).unwrap();
        let output = sgc(&["resume", path(&damaged)]);
        assert_code(&output, 2);
        assert!(errors(&output).contains(says), "{says}: {}", errors(&output));
        std::fs::remove_dir_all(&damaged).unwrap();
    }
    let output = sgc(&["resume", "nowhere"]);
    assert_code(&output, 2);
    assert!(errors(&output).contains("nowhere is not a run folder"), "{}", errors(&output));
}

#[test]
fn a_full_disk_leaves_the_last_good_files() {
    let folder = tempfile::tempdir().unwrap();
    let quick = grammar(folder.path(), "1");
    let whole = whole(folder.path(), &quick);
    let out = folder.path().join("run");
    assert_code(&stop_once(&out.join("best.design.json"), &short(&quick, &out), "-TERM"), 75);
    let kept = ["checkpoint", "best.design.json"].map(|name| std::fs::read(out.join(name)).unwrap());
    // No file may be longer than half a kilobyte, as on a disk that is full.
    let output = Command::new("sh")
        .args(["-c", "trap '' XFSZ; ulimit -f 1; exec \"$0\" resume \"$1\" --quiet --checkpoint 0.001s"])
        .args([env!("CARGO_BIN_EXE_sgc"), path(&out)])
        .output()
        .unwrap();
    assert_code(&output, 2);
    let said = errors(&output);
    assert!(said.contains("cannot write") && said.contains("go on with: sgc resume"), "{said}");
    assert_eq!(kept, ["checkpoint", "best.design.json"].map(|name| std::fs::read(out.join(name)).unwrap()));
    assert_code(&sgc(&["resume", path(&out), "--quiet"]), 0);
    assert_same(&out, &whole);
}

#[test]
fn several_runs_are_what_each_is_alone_with_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let quick = grammar(folder.path(), "1");
    let asked =
        ["run", path(&quick), "--seed", "4", "--runs", "3", "--max-evals", "150", "--checkpoint", "0.001s"];
    let several = |name: &str, jobs: &str, more: &[&str]| {
        let out = folder.path().join(name);
        let output = sgc(&[asked.as_slice(), &["--jobs", jobs, "--out", path(&out)], more].concat());
        (out, output)
    };
    let (one, told) = several("one", "1", &[]);
    assert_code(&told, 0);
    let table = String::from_utf8_lossy(&told.stdout).into_owned();
    let seeds: Vec<&str> = table.lines().skip(1).filter_map(|line| line.split_whitespace().next()).collect();
    assert_eq!(seeds, ["4", "5", "6"], "{table}");
    assert!(table.contains("of 13") && table.contains("the evaluations are spent"), "{table}");
    assert_eq!(names(&one), ["runs.toml", "seed-4", "seed-5", "seed-6", "summary.csv"]);
    let summary = |out: &Path| std::fs::read_to_string(out.join("summary.csv")).unwrap();
    assert_eq!(summary(&one).lines().count(), 4, "{}", summary(&one));

    let alone = folder.path().join("alone");
    let arguments = ["run", path(&quick), "--seed", "5", "--max-evals", "150", "--out", path(&alone)];
    assert_code(&sgc(&arguments), 0);
    assert_same(&alone, &one.join("seed-5"));

    let assert_all_same = |out: &Path| {
        for seed in ["seed-4", "seed-5", "seed-6"] {
            assert_same(&out.join(seed), &one.join(seed));
        }
        assert_eq!(summary(out), summary(&one));
    };
    let (five, told) = several("five", "5", &[]);
    assert_code(&told, 0);
    assert_all_same(&five);

    // Stopped, then killed, then one of them by itself, then all.
    let pieces = folder.path().join("pieces");
    let arguments = [asked.as_slice(), &["--jobs", "2", "--out", path(&pieces)]].concat();
    let told = stop_once(&pieces.join("seed-4/checkpoint"), &arguments, "-TERM");
    assert_code(&told, 75);
    assert!(errors(&told).contains(&format!("sgc resume {}", path(&pieces))), "{}", errors(&told));
    assert!(summary(&pieces).contains("not complete"), "{}", summary(&pieces));
    let mut child = start(&["resume", path(&pieces), "--checkpoint", "0.001s"]);
    std::thread::sleep(Duration::from_millis(300));
    child.kill().unwrap();
    child.wait().unwrap();
    assert_code(&sgc(&["resume", path(&pieces.join("seed-6")), "--quiet"]), 0);
    assert_code(&sgc(&["resume", path(&pieces), "--jobs", "2"]), 0);
    assert_all_same(&pieces);
    let output = sgc(&["resume", path(&pieces)]);
    assert_code(&output, 0);
    assert!(errors(&output).contains("are complete"), "{}", errors(&output));

    // Nothing is replaced unless by force, and nothing foreign even so.
    assert_code(&several("one", "1", &[]).1, 2);
    assert_code(&several("one", "1", &["--force"]).1, 0);
    assert_all_same(&five);
    std::fs::write(one.join("seed-4/notes.txt"), "mine").unwrap();
    let (_, told) = several("one", "1", &["--force"]);
    assert_code(&told, 2);
    assert!(errors(&told).contains("notes.txt"), "{}", errors(&told));
}

#[test]
fn what_killed_processes_leave_is_taken_away_but_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let quick = grammar(folder.path(), "1");
    let whole = whole(folder.path(), &quick);
    let out = at("run");
    let foreign = [at("run.replaced-7"), at(".sgc-run-mine"), at("run.replaced-mine"), at(".sgc-running-a")];
    for folder in &foreign {
        std::fs::create_dir(folder).unwrap();
        std::fs::write(folder.join("notes.txt"), "mine").unwrap();
    }
    // Killed when it was to replace a run: before or after it had moved it away, or later.
    let moved =
        || names(folder.path()).iter().any(|name| name.starts_with("run.replaced-") && name.len() > 16);
    for _ in 0..2 {
        copy(&whole, &out);
        let mut child = start(&[&short(&quick, &out)[..], &["--force"]].concat());
        let begun = Instant::now();
        while !moved() && begun.elapsed() < Duration::from_secs(2) {
            std::thread::sleep(Duration::from_micros(200));
        }
        child.kill().unwrap();
        child.wait().unwrap();
        copy(&whole, &at(".sgc-run-a"));
        if !out.join("result.json").exists() {
            assert_code(&sgc(&["resume", path(&out), "--quiet"]), 0);
        } else {
            assert_code(&sgc(&[&short(&quick, &out)[..], &["--force"]].concat()), 0);
        }
        assert_same(&out, &whole);
        let left: Vec<String> = names(folder.path()).into_iter().filter(|n| n.contains("run")).collect();
        assert_eq!(left, [".sgc-run-mine", ".sgc-running-a", "run", "run.replaced-7", "run.replaced-mine"]);
        std::fs::remove_dir_all(&out).unwrap();
    }
    for folder in &foreign {
        assert_eq!(std::fs::read_to_string(folder.join("notes.txt")).unwrap(), "mine");
    }

    // The older run is not lost where the newer one never came to be.
    std::fs::rename(&whole, at("run.replaced-123456")).unwrap();
    let output = sgc(&["resume", path(&out)]);
    assert_code(&output, 2);
    assert!(errors(&output).contains("run.replaced-123456 back"), "{}", errors(&output));
    // A run that was not asked to replace anything tells of it.
    let output = sgc(&short(&quick, &out));
    assert_code(&output, 0);
    assert!(errors(&output).contains("is an older run that was to be replaced"), "{}", errors(&output));
    assert_eq!(names(&at("run.replaced-123456")), COMPLETE);
}

/// Somebody who may not write what root has made; none where nobody can be anybody else.
#[cfg(unix)]
fn as_guest(arguments: &[&str], folder: &Path) -> Option<Output> {
    use std::os::unix::process::CommandExt;
    let run = |uid: Option<u32>| {
        let mut command = command(arguments);
        uid.map(|uid| command.uid(uid).gid(uid));
        command.current_dir(folder).output().ok()
    };
    let mine = Command::new("id").arg("-u").output().ok()?;
    if mine.stdout.trim_ascii() == b"0" { run(Some(65534)) } else { run(None) }
}

#[cfg(unix)]
#[test]
fn a_folder_that_cannot_be_written_is_looked_at_but_not_gone_on_with() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let quick = grammar(folder.path(), "1");
    let open = folder.path().join("open");
    std::fs::create_dir(&open).unwrap();
    let shut = folder.path().join("shut");
    let out = shut.join("run");
    assert_code(&stop_once(&out.join("best.design.json"), &short(&quick, &out), "-TERM"), 75);
    let allow = |path: &Path, mode| {
        std::fs::set_permissions(path, std::fs::Permissions::from_mode(mode)).unwrap();
    };
    allow(folder.path(), 0o755);
    allow(&open, 0o777);
    for folder in [&out.join("sources"), &out, &shut] {
        for name in names(folder) {
            let path = folder.join(name);
            allow(&path, if path.is_dir() { 0o555 } else { 0o444 });
        }
        allow(folder, 0o555);
    }
    let guest = |arguments: &[&str]| as_guest(arguments, &open);
    let before: Vec<Vec<u8>> = ["checkpoint", "evals.csv", "best.design.json", "run.toml"]
        .iter()
        .map(|name| std::fs::read(out.join(name)).unwrap())
        .collect();
    if guest(&["--version"]).is_none_or(|output| !output.status.success()) {
        eprintln!("skipped: nobody but root may run the program here");
        return;
    }
    let other = shut.join("other");
    for (arguments, says) in [
        (vec!["resume", path(&out)], "copy its folder to such a place, and resume the copy"),
        (
            vec!["run", path(&quick), "--max-evals", "5", "--out", path(&other)],
            "choose another place with --out",
        ),
        (vec!["run", path(&quick), "--max-evals", "5", "--runs", "2", "--out", path(&other)], "with --out"),
        (vec!["run", path(&quick), "--max-evals", "5", "--force", "--out", path(&out)], "cannot write"),
    ] {
        let output = guest(&arguments).unwrap();
        assert_code(&output, 2);
        assert!(
            errors(&output).contains(says) && errors(&output).contains("cannot write"),
            "{}",
            errors(&output)
        );
    }
    assert_eq!(names(&shut), ["run"]);
    for (name, before) in ["checkpoint", "evals.csv", "best.design.json", "run.toml"].iter().zip(before) {
        assert_eq!(std::fs::read(out.join(name)).unwrap(), before, "{name}");
    }
    assert_code(&guest(&["eval", path(&out)]).unwrap(), 0);
    assert_code(&guest(&["export", path(&out), "--to", "mjcf"]).unwrap(), 0);
    let output = guest(&["view", path(&out)]).unwrap();
    assert_code(&output, 0);
    assert!(errors(&output).contains("the page is in the current folder instead"), "{}", errors(&output));
    assert_eq!(names(&open), ["codesign-3.view.html"]);
    // As the message says.
    let again = open.join("again");
    copy(&out, &again);
    for name in names(&again) {
        allow(&again.join(&name), if name == "sources" { 0o755 } else { 0o644 });
    }
    assert_code(&sgc(&["resume", path(&again), "--max-evals", "1", "--quiet"]), 0);
    for folder in [&shut, &out, &out.join("sources")] {
        allow(folder, 0o755);
    }
}

/// A run whose folder was moved writes no more to the name: another run may be there by now.
#[test]
fn a_run_whose_folder_was_moved_leaves_the_next_one_alone() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    let child = begin_long(folder.path(), &out);
    std::fs::rename(&out, folder.path().join("moved")).unwrap();
    let quick = grammar(folder.path(), "1");
    assert_code(&sgc(&short(&quick, &out)), 0);
    let kept = || {
        ["best.design.json", "evals.csv", "processes.csv", "result.json"]
            .map(|name| std::fs::read(out.join(name)).unwrap())
    };
    let before = kept();
    signal(&child, "-TERM");
    let ended = child.wait_with_output().unwrap();
    assert_eq!(ended.status.code(), Some(2), "{}", errors(&ended));
    assert!(errors(&ended).contains("was moved or replaced"), "{}", errors(&ended));
    assert!(before == kept() && !out.join("checkpoint").exists(), "the other run is as it was");
}

/// A page that somebody has edited is not ours to remove; one that is as it was written is.
#[test]
fn edited_pages_are_not_removed_by_force() {
    let folder = tempfile::tempdir().unwrap();
    let quick = grammar(folder.path(), "1");
    let out = folder.path().join("run");
    let run = |more: &[&str]| {
        let asked = ["run", path(&quick), "--max-evals", "40", "--quiet", "--out", path(&out)];
        sgc(&[&asked[..], more].concat())
    };
    assert_code(&run(&[]), 0);
    assert_code(&sgc(&["view", path(&out)]), 0);
    assert_code(&run(&["--force"]), 0);
    std::fs::write(out.join("view.html"), "<p>my notes</p>").unwrap();
    let output = run(&["--force"]);
    assert_code(&output, 2);
    assert!(errors(&output).contains("\"view.html\""), "{}", errors(&output));
    assert_eq!(std::fs::read_to_string(out.join("view.html")).unwrap(), "<p>my notes</p>");
}

/// What somebody puts into the older run while the new one has found nothing yet stays, and is told.
#[test]
fn what_is_put_into_the_older_run_meanwhile_stays() {
    let folder = tempfile::tempdir().unwrap();
    let (old, out) = (grammar(folder.path(), "1"), folder.path().join("run"));
    assert_code(&sgc(&["run", path(&old), "--max-evals", "20", "--quiet", "--out", path(&out)]), 0);
    let slow = folder.path().join("slow.sgr");
    let text = "variant slow of \"./quick.sgr\" {\n  replace simulate hinge_model for 300 s\n}\n";
    std::fs::write(&slow, text).unwrap();
    let child = start(&["run", path(&slow), "--force", "--max-evals", "1", "--quiet", "--out", path(&out)]);
    let begun = Instant::now();
    let older = || {
        let beside = names(folder.path()).into_iter().find(|name| name.starts_with("run.replaced-"));
        beside.map(|name| folder.path().join(name))
    };
    while older().is_none() {
        assert!(begun.elapsed() < Duration::from_secs(60), "the older run is not put aside");
        std::thread::sleep(Duration::from_millis(1));
    }
    let notes = older().unwrap().join("notes.txt");
    // It may be too late already.
    let put = std::fs::write(&notes, "mine").is_ok();
    let ended = child.wait_with_output().unwrap();
    assert_code(&ended, 0);
    if put {
        assert_eq!(std::fs::read_to_string(&notes).unwrap(), "mine");
        assert!(errors(&ended).contains("is an older run that was to be replaced"), "{}", errors(&ended));
    }
}

/// A process that is cut off in the middle of something long, before it has found anything, gives the older run back, too.
#[test]
fn what_is_cut_off_gives_the_older_run_back() {
    let folder = tempfile::tempdir().unwrap();
    let (old, out) = (grammar(folder.path(), "2"), folder.path().join("run"));
    assert_code(&sgc(&["run", path(&old), "--max-evals", "20", "--quiet", "--out", path(&out)]), 0);
    let before = std::fs::read(out.join("run.toml")).unwrap();
    let slow = folder.path().join("slow.sgr");
    let text = "variant slow of \"./quick.sgr\" {\n  add require slow : \
                (sum over p in part, i in 0 .. 1500, j in 0 .. 1500 of i * j * p.depth) >= 0\n}\n";
    std::fs::write(&slow, text).unwrap();
    let child = start(&["run", path(&slow), "--force", "--quiet", "--out", path(&out)]);
    let begun = Instant::now();
    while std::fs::read(out.join("run.toml")).is_ok_and(|now| now == before) {
        assert!(begun.elapsed() < Duration::from_secs(60), "the run does not begin");
        std::thread::sleep(Duration::from_millis(5));
    }
    signal(&child, "-TERM");
    let ended = child.wait_with_output().unwrap();
    assert_code(&ended, 130);
    assert!(errors(&ended).contains("the older run is back"), "{}", errors(&ended));
    assert_eq!(std::fs::read(out.join("run.toml")).unwrap(), before);
    let left: Vec<String> =
        names(folder.path()).into_iter().filter(|name| name.contains("replaced")).collect();
    assert!(left.is_empty(), "{left:?}");
}
