//! Runs of the program that tests begin, stop and compare.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::support::{codesign, read, root};

/// What a complete run leaves.
pub(crate) const COMPLETE: [&str; 6] =
    ["best.design.json", "evals.csv", "processes.csv", "result.json", "run.toml", "sources"];

/// What of it is the same each time.
pub(crate) const SAME: [&str; 3] = ["best.design.json", "evals.csv", "result.json"];

/// What there is beside that where a search keeps an archive of kinds, or a front.
pub(crate) const KEPT: [&str; 5] = ["archive", "archive.csv", "front", "front.csv", "learning.csv"];

pub(crate) fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_sgc"));
    command.args(arguments).current_dir(root()).env("NO_COLOR", "1");
    command
}

pub(crate) fn sgc(arguments: &[&str]) -> Output {
    command(arguments).output().unwrap()
}

pub(crate) fn start(arguments: &[&str]) -> Child {
    command(arguments).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
}

pub(crate) fn errors(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

pub(crate) fn assert_code(output: &Output, code: i32) {
    assert_eq!(output.status.code(), Some(code), "{}", errors(output));
}

pub(crate) fn signal(child: &Child, name: &str) {
    assert!(Command::new("kill").args([name, &child.id().to_string()]).status().unwrap().success());
}

pub(crate) fn path(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// A grammar whose motions are as short as said.
pub(crate) fn grammar(folder: &Path, seconds: &str) -> PathBuf {
    let text = codesign();
    let file = folder.join("quick.sgr");
    let observed = "\nuse std.gaits { airborne, gait }\nobserve airborne, gait\n";
    let text = text.replace("for 20 s", &format!("for {seconds} s")) + observed;
    std::fs::write(&file, text).unwrap();
    file
}

/// The arguments of a short run into a folder; checkpoints are saved as often as can be.
pub(crate) fn short<'a>(grammar: &'a Path, out: &'a Path) -> Vec<&'a str> {
    let out = path(out);
    let mut arguments = vec!["run", path(grammar), "--seed", "3", "--max-evals", "900", "--quiet"];
    arguments.extend(["--checkpoint", "0.001s", "--out", out]);
    arguments
}

/// The run without any interruption.
pub(crate) fn whole(folder: &Path, grammar: &Path) -> PathBuf {
    let out = folder.join("whole");
    assert_code(&sgc(&short(grammar, &out)), 0);
    out
}

/// Starts a run that would take long, and waits until it has a first best.
pub(crate) fn begin_long(folder: &Path, out: &Path) -> Child {
    let child = start(&["run", path(&grammar(folder, "20")), "--max-evals", "0", "--out", path(out)]);
    let begun = Instant::now();
    while !out.join("best.design.json").exists() {
        assert!(begun.elapsed() < Duration::from_secs(60), "nothing was found in a minute");
        std::thread::sleep(Duration::from_millis(20));
    }
    child
}

/// Starts a command and sends it a signal as soon as it has written a file.
pub(crate) fn stop_once(file: &Path, arguments: &[&str], name: &str) -> Output {
    let written = || std::fs::metadata(file).and_then(|file| file.modified()).ok();
    let before = written();
    let child = start(arguments);
    let begun = Instant::now();
    while written() == before {
        assert!(begun.elapsed() < Duration::from_secs(60), "nothing was written in a minute");
        std::thread::sleep(Duration::from_millis(1));
    }
    signal(&child, name);
    child.wait_with_output().unwrap()
}

pub(crate) fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

/// Two complete runs of one search that found the same.
pub(crate) fn assert_same(one: &Path, other: &Path) {
    for run in [one, other] {
        let names: Vec<String> =
            names(run).into_iter().filter(|name| !KEPT.contains(&name.as_str())).collect();
        assert_eq!(names, COMPLETE);
    }
    for name in SAME.iter().chain(&KEPT) {
        assert_same_file(&one.join(name), &other.join(name));
    }
}

/// The same bytes, in a folder the same files of them, or neither is there.
pub(crate) fn assert_same_file(one: &Path, other: &Path) {
    assert_eq!(one.exists(), other.exists(), "{}", one.display());
    if one.is_dir() {
        assert_eq!(names(one), names(other), "{}", one.display());
        names(one).iter().for_each(|name| assert_same_file(&one.join(name), &other.join(name)));
    } else if one.exists() {
        let [a, b] = [one, other].map(|file| std::fs::read_to_string(file).unwrap());
        assert_eq!(a, b, "{}", one.display());
    }
}

pub(crate) fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for name in names(from) {
        let (from, to) = (from.join(&name), to.join(&name));
        if from.is_dir() {
            copy(&from, &to);
        } else {
            std::fs::copy(from, to).unwrap();
        }
    }
}

/// What the project's own `codesign` searches for: kinds of bodies, and gaits that hold in many worlds.
pub(crate) fn grammar_in_worlds(folder: &Path, search: &str) -> PathBuf {
    let text = read("grammars/codesign.sgr").replace("for 20 s in workshop", "for 1 s in workshop");
    let text = text.replace("recommended", search);
    assert!(text.contains("for 1 s in workshop") && text.contains(search), "{text}");
    let file = folder.join("worlds.sgr");
    std::fs::write(&file, text).unwrap();
    file
}
