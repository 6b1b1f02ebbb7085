//! `sgc calibrate`: from a bench's files to a variant that runs.

use std::path::Path;

use crate::support::{root, said, sgc};

/// A folder with the example's measurements, and the project's grammars beside it.
fn bench() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (from, to) in [("docs/calibration-example", "bench"), ("grammars", "grammars")] {
        std::fs::create_dir(folder.path().join(to)).unwrap();
        for entry in std::fs::read_dir(root().join(from)).unwrap() {
            let path = entry.unwrap().path();
            if path.is_file() {
                std::fs::copy(&path, folder.path().join(to).join(path.file_name().unwrap())).unwrap();
            }
        }
    }
    folder
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

#[test]
fn what_a_bench_measured_is_checked_and_runs() {
    let folder = bench();
    for (measurements, grammar, holds) in [
        (
            "fingers",
            "pneumatic",
            ["set bender.bending_speed  = bender_inflating", "add prototype ours_3 on pneumatic"],
        ),
        ("tendons", "tendon", ["set threads.thread = bender_thread", "set ball.friction"]),
    ] {
        let measurements = format!("bench/{measurements}.toml");
        let base = format!("grammars/{grammar}.sgr");
        let output = sgc(folder.path(), &["calibrate", &measurements, "--for", &base]);
        assert_eq!(output.status.code(), Some(0), "{}", said(&output));
        let written = format!("bench/{grammar}_bench.sgr");
        let text = std::fs::read_to_string(folder.path().join(&written)).unwrap();
        for holds in holds {
            assert!(text.contains(holds), "{holds} is not in\n{text}");
        }
        assert!(
            text.contains(&format!("variant {grammar}_bench of \"../grammars/{grammar}.sgr\"")),
            "{text}"
        );
        assert!(folder.path().join(format!("bench/{grammar}_bench.html")).exists());

        let output = sgc(folder.path(), &["check", "--format", "concise", &written]);
        assert_eq!(
            (output.status.code(), output.stdout.as_slice()),
            (Some(0), &b""[..]),
            "{}",
            said(&output)
        );
        let output = sgc(folder.path(), &["fmt", "--check", &written]);
        assert_eq!(output.status.code(), Some(0), "{}", said(&output));
        // What a run uses is what was measured: the torque of the rule set is that of the table on the terminal.
        let output = sgc(folder.path(), &["compile", &written, "--emit", "resolved"]);
        let torque = text.lines().find_map(|l| l.trim().strip_prefix("set bender.torque")).unwrap();
        let torque = torque.trim_start_matches([' ', '=']).split(' ').next().unwrap();
        assert!(said(&output).contains(torque), "{torque} is not in\n{}", said(&output));
        let output = sgc(folder.path(), &["run", &written, "--max-evals", "12", "--quiet"]);
        assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    }
}

#[test]
fn nothing_is_overwritten_unless_by_force_and_nothing_is_half_written() {
    let folder = bench();
    let bench = folder.path().join("bench");
    let before = names(&bench);
    let calibrate = |more: &[&str]| sgc(&bench, &[&["calibrate", "tendons.toml"], more].concat());
    let base = "../grammars/tendon.sgr";
    std::fs::write(bench.join("empty.toml"), "").unwrap();
    std::fs::write(bench.join("against.toml"), "[a]\nkind = \"mass\"\nfor = \"cub\"\n\"mass [g]\" = 1\n")
        .unwrap();
    for (arguments, code, says) in [
        (vec!["calibrate", "nowhere.toml", "--for", base], 2, "cannot read nowhere.toml"),
        (vec!["calibrate", "tendons.toml"], 2, "--for"),
        (vec!["calibrate", "tendons.toml", "--for", "nowhere.sgr"], 2, "cannot read nowhere.sgr"),
        (vec!["calibrate", "tendons.toml", "--for", "tendons.toml"], 2, "is not a grammar file"),
        (
            vec!["calibrate", "empty.toml", "--for", base],
            2,
            "empty.toml:1: this file contains no measurement",
        ),
        (
            vec!["calibrate", "against.toml", "--for", base],
            1,
            "against.toml:3: the grammar declares no part or actuator `cub`: did you mean `cube`?",
        ),
        (vec!["calibrate", "tendons.toml", "--for", base, "--out", "mine.txt"], 2, "--out NAME.sgr"),
        (vec!["calibrate", "tendons.toml", "--for", base, "--out", base], 2, "the grammar itself"),
        (
            vec!["calibrate", "tendons.toml", "--for", base, "--variant", "two words"],
            2,
            "cannot name a variant",
        ),
        (vec!["calibrate", "tendons.toml", "--for", base, "--out", "my-bench.sgr"], 2, "--variant NAME"),
        (vec!["calibrate", "tendons.toml", "--for", base, "--out", "nowhere/mine.sgr"], 2, "nowhere"),
    ] {
        let output = sgc(&bench, &arguments);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {}", said(&output));
        assert!(said(&output).contains(says), "{arguments:?}: {}", said(&output));
    }
    std::fs::remove_file(bench.join("empty.toml")).unwrap();
    std::fs::remove_file(bench.join("against.toml")).unwrap();
    assert_eq!(names(&bench), before, "nothing was written");

    std::fs::write(bench.join("tendon_bench.html"), "mine").unwrap();
    let output = calibrate(&["--for", base]);
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    assert!(said(&output).contains("--force"), "{}", said(&output));
    assert!(!bench.join("tendon_bench.sgr").exists());
    assert_eq!(std::fs::read_to_string(bench.join("tendon_bench.html")).unwrap(), "mine");
    #[cfg(unix)]
    {
        // Not even by force what it reads, whatever it is called.
        std::os::unix::fs::symlink("tendons.toml", bench.join("link.sgr")).unwrap();
        let measured = std::fs::read(bench.join("tendons.toml")).unwrap();
        let output = calibrate(&["--for", base, "--force", "--out", "link.sgr"]);
        assert_eq!(output.status.code(), Some(2), "{}", said(&output));
        assert!(said(&output).contains("which this command reads"), "{}", said(&output));
        assert_eq!(std::fs::read(bench.join("tendons.toml")).unwrap(), measured);
    }
    let output = calibrate(&["--for", base, "--force", "--variant", "mine"]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    assert!(std::fs::read_to_string(bench.join("tendon_bench.sgr")).unwrap().contains("variant mine of"));
}
