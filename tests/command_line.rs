//! The command line: wiring, exit codes, and what bad input gets.

use std::path::Path;
use std::process::{Command, Output};

use crate::support::{codesign, forged, root};

pub(crate) fn sgc(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_sgc"))
        .args(arguments)
        .current_dir(root())
        .env("NO_COLOR", "1")
        .output()
        .unwrap()
}

pub(crate) fn code(output: &Output) -> i32 {
    output.status.code().expect("an exit code")
}

pub(crate) fn errors(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

pub(crate) fn printed(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// A grammar whose search takes a moment: a short motion and few evaluations.
pub(crate) fn quick_grammar(folder: &Path) -> String {
    let text = codesign().replace("for 20 s", "for 1 s");
    let path = folder.join("quick.sgr");
    std::fs::write(&path, text).unwrap();
    path.to_string_lossy().into_owned()
}

#[test]
fn a_run_leaves_its_folder_and_eval_gives_the_same_value() {
    let folder = tempfile::tempdir().unwrap();
    let grammar = quick_grammar(folder.path());
    let run = |out: &str, jobs: &str| {
        let out = folder.path().join(out);
        let output = sgc(&[
            "run",
            &grammar,
            "--seed",
            "2",
            "--max-evals",
            "150",
            "--jobs",
            jobs,
            "--out",
            &out.to_string_lossy(),
        ]);
        assert_eq!(code(&output), 0, "{}", errors(&output));
        assert!(String::from_utf8_lossy(&output.stdout).starts_with("value "));
        out
    };
    let (one, two) = (run("one", "1"), run("two", "2"));
    for name in ["run.toml", "sources", "evals.csv", "best.design.json", "result.json"] {
        assert!(one.join(name).exists(), "{name}");
    }
    let best = |path: &Path| std::fs::read_to_string(path.join("best.design.json")).unwrap();
    // The final best went through all checks, and each of them was another simulation.
    let design: serde_json::Value = serde_json::from_str(&best(&one)).unwrap();
    let checks = design["tasks"][0]["checks"].as_array().unwrap();
    let values: std::collections::BTreeSet<_> = checks.iter().map(|c| c["value"].to_string()).collect();
    // Torques that are enough are as good as more.
    assert!(checks.len() == 13 && values.len() >= 8, "{checks:#?}");
    assert_eq!(best(&one), best(&two), "the same design with one thread and with two");
    let output = sgc(&["eval", &one.to_string_lossy()]);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    assert!(errors(&output).contains("exactly the saved value"), "{}", errors(&output));
    let output = sgc(&["eval", &one.to_string_lossy(), "--step", "1/480"]);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    let output = sgc(&["eval", &one.to_string_lossy(), "--step", "1/50"]);
    assert_eq!(code(&output), 1, "{}", errors(&output));
    assert!(
        errors(&output).contains("the step of a model with hinges must be at most 1/60 s"),
        "{}",
        errors(&output)
    );
    let output = sgc(&["eval", &one.to_string_lossy(), "--solver", "rapier"]);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    let output = sgc(&["view", &one.to_string_lossy()]);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    let page = std::fs::read_to_string(one.join("view.html")).unwrap();
    assert!(page.contains("codesign") && page.len() > 100_000);

    // A run that finds nothing gives the folder back; another's files are never touched.
    let bad =
        std::fs::read_to_string(&grammar).unwrap().replace("travel - fall in cm", "travel / (fall - fall)");
    let bad_path = folder.path().join("bad.sgr");
    std::fs::write(&bad_path, bad).unwrap();
    let before = best(&one);
    let output = sgc(&["run", &bad_path.to_string_lossy(), "--force", "--out", &one.to_string_lossy()]);
    assert_eq!(code(&output), 1, "{}", errors(&output));
    assert_eq!(best(&one), before, "the old run is still there");
    std::fs::write(one.join("notes.txt"), "mine").unwrap();
    let output = sgc(&["run", &grammar, "--force", "--max-evals", "3", "--out", &one.to_string_lossy()]);
    assert_eq!(code(&output), 2);
    assert!(errors(&output).contains("notes.txt"), "{}", errors(&output));
    std::fs::remove_file(one.join("notes.txt")).unwrap();

    // The folder is not overwritten, unless by force.
    let again = |more: &[&str]| {
        let out = one.to_string_lossy().into_owned();
        let mut arguments = vec!["run", &grammar, "--max-evals", "3", "--out", &out];
        arguments.extend(more);
        sgc(&arguments)
    };
    let output = again(&[]);
    assert_eq!(code(&output), 2);
    assert!(errors(&output).contains("exists already"), "{}", errors(&output));
    // What only looks like a part of a run is somebody's own.
    for place in ["sources/thesis.sgr", "archive/3-0.design.json"] {
        let file = one.join(place);
        std::fs::create_dir_all(file.parent().unwrap()).unwrap();
        std::fs::write(&file, "mine").unwrap();
        let output = again(&["--force"]);
        assert_eq!(code(&output), 2, "{place}");
        assert!(errors(&output).contains(place), "{}", errors(&output));
        std::fs::remove_file(&file).unwrap();
    }
    for name in ["evals.csv", "sources"] {
        let other = folder.path().join(format!("other {name}"));
        let file = if name == "sources" { other.join("sources/thesis.sgr") } else { other.join(name) };
        std::fs::create_dir_all(file.parent().unwrap()).unwrap();
        std::fs::write(&file, "mine").unwrap();
        let output =
            sgc(&["run", &grammar, "--force", "--max-evals", "3", "--out", &other.to_string_lossy()]);
        assert_eq!(code(&output), 2, "{name}");
        assert_eq!(std::fs::read_to_string(&file).unwrap(), "mine");
    }
    assert_eq!(code(&again(&["--force"])), 0);
}

#[test]
fn a_design_of_another_grammar_is_refused_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let grammar = quick_grammar(folder.path());
    let out = folder.path().join("run").to_string_lossy().into_owned();
    let output = sgc(&["run", &grammar, "--seed", "2", "--max-evals", "60", "--out", &out]);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    let output = sgc(&["eval", &out, "--grammar", "grammars/morphology.sgr"]);
    assert_eq!(code(&output), 1);
    assert!(errors(&output).contains("made by the grammar `codesign`"), "{}", errors(&output));
    // By another grammar, values have the unit of that one.
    let metres = folder.path().join("metres.sgr");
    let text = format!("variant metres of \"{grammar}\" {{ replace maximize travel - fall in m }}\n");
    std::fs::write(&metres, text).unwrap();
    let judged = sgc(&["eval", &out, "--grammar", &metres.to_string_lossy()]);
    let text = String::from_utf8_lossy(&judged.stdout);
    let lines: Vec<&str> =
        text.lines().filter(|line| line.contains("value") || line.contains("travel")).collect();
    assert!(lines.len() == 2 && lines.iter().all(|line| line.ends_with(" m")), "{text}{}", errors(&judged));
    // A design whose text was tampered with.
    let path = folder.path().join("run/best.design.json");
    let text = std::fs::read_to_string(&path).unwrap();
    for (from, to, says) in [
        ("\"version\": 2", "\"version\": 99", "version 99"),
        ("sgc design", "other design", "not a saved design"),
        ("Count in 2 .. 60 = 20", "Count in 2 .. 60 = 21", "was changed"),
        ("\"seed\": 2", "\"seed\": \"x\"", "damaged"),
        ("\"body\": \"", "\"body\": \"0", "does not lead to the body"),
        ("\"rule\": \"add_block\"", "\"rule\": \"add_black\"", "cannot be applied"),
        ("\"bender-1", "\"bender,1", "cannot be the name"),
        ("\"bender-1.twin\"", "\"bender-1\"", "two of its parts are called"),
    ] {
        assert!(text.contains(from), "{from}");
        std::fs::write(&path, forged(&text.replace(from, to))).unwrap();
        for command in [["eval", &out].as_slice(), &["view", &out], &["export", &out, "--to", "mjcf"]] {
            let output = sgc(command);
            assert_eq!(code(&output), 2, "{from} {command:?}: {}", errors(&output));
            assert!(errors(&output).contains(says), "{from} {command:?}: {}", errors(&output));
        }
    }
    std::fs::write(&path, &text[..text.len() / 2]).unwrap();
    for command in ["eval", "view"] {
        assert_eq!(code(&sgc(&[command, &out])), 2);
    }
}

#[test]
fn a_design_is_exported_and_a_motion_of_it_is_scored() {
    let folder = tempfile::tempdir().unwrap();
    let grammar = quick_grammar(folder.path());
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let out = path("run");
    let output = sgc(&["run", &grammar, "--seed", "2", "--max-evals", "60", "--out", &out]);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    let export = |more: &[&str]| {
        let output = sgc(&[&["export", out.as_str()], more].concat());
        assert_eq!(code(&output), 0, "{}", errors(&output));
        String::from_utf8(output.stdout).unwrap()
    };
    let model = export(&["--to", "mjcf", "--step", "1/1000"]);
    let document = roxmltree::Document::parse(&model).unwrap();
    assert_eq!(document.root_element().attribute("model"), Some("codesign, seed 2"));
    let option = document.descendants().find(|node| node.has_tag_name("option")).unwrap();
    assert_eq!(option.attribute("timestep"), Some("0.001"));
    let servos = document.descendants().filter(|node| node.has_tag_name("position")).count();
    let drive = export(&["--to", "drive", "--step", "1/1000"]);
    assert_eq!(drive.lines().count(), 1001);
    assert!(drive.lines().all(|line| line.split(',').count() == servos + 1));

    // The file that --out names holds the same, and standard output says where.
    let file = path("model.xml");
    assert_eq!(export(&["--to", "mjcf", "--step", "1/1000", "--out", &file]), format!("{file}\n"));
    assert!(
        std::fs::read_to_string(&file).unwrap().starts_with(&model),
        "then a line that tells who wrote it"
    );

    let file = path("motion.csv");
    export(&["--to", "motion", "--out", &file]);
    let [again, scored] = [vec!["eval", &out], vec!["eval", &out, "--motion", &file]].map(|a| sgc(&a));
    assert_eq!(code(&scored), 0, "{}", errors(&scored));
    assert_eq!(scored.stdout, again.stdout, "the own motion has the own value");

    // In a world that is as the grammar says, it moves as without one; on ice it does not.
    let other = path("other.sgr");
    let worlds = format!(
        "variant other of \"{grammar}\" {{\n  add scenarios two {{\n    case ice {{ ground_friction = 0.05 }}\n  }}\n}}\n"
    );
    std::fs::write(&other, worlds).unwrap();
    let set = format!("{other}:two");
    let within = |world: &str| export(&["--to", "motion", "--in", &set, "--world", world]);
    let motion = std::fs::read_to_string(&file).unwrap();
    assert_eq!(within("nominal"), motion);
    assert_ne!(within("ice"), motion);
    let page = path("page.html");
    assert_eq!(code(&sgc(&["view", &out, "--in", &set, "--world", "ice", "--out", &page])), 0);
    assert!(std::fs::read_to_string(&page).unwrap().contains("hidden>ice</button>"));

    std::fs::write(path("bad.csv"), "time\n0\n").unwrap();
    // As a program writes it for which z points up.
    let mut rows: Vec<Vec<&str>> = motion.lines().map(|line| line.split(',').collect()).collect();
    rows.iter_mut().skip(1).flat_map(|row| row[1..].chunks_mut(7)).for_each(|pose| pose.swap(1, 2));
    let rows: Vec<String> = rows.into_iter().map(|row| row.join(",")).collect();
    std::fs::write(path("upright.csv"), rows.join("\n")).unwrap();
    // And one that goes through the ground at its end: the columns are time, x, y and so on.
    let mut sunk: Vec<Vec<String>> =
        motion.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect();
    let last = sunk.last_mut().unwrap();
    last[2] = "-0.01".to_owned();
    let sunk: Vec<String> = sunk.into_iter().map(|row| row.join(",")).collect();
    std::fs::write(path("sunk.csv"), sunk.join("\n")).unwrap();
    let sunk = path("sunk.csv");
    let (bad, upright, nowhere) = (path("bad.csv"), path("upright.csv"), path("nowhere"));
    for (arguments, wanted, says) in [
        (vec!["export", out.as_str()], 2, "--to"),
        (vec!["export", &out, "--to", "urdf"], 2, "invalid value"),
        (vec!["export", &nowhere, "--to", "mjcf"], 2, "cannot read"),
        (vec!["export", &file, "--to", "mjcf"], 2, "not a saved design"),
        (vec!["export", &out, "--to", "mjcf", "--task", "dig"], 2, "no task `dig`"),
        (vec!["export", &out, "--to", "drive", "--out", "nowhere/drive.csv"], 2, "nowhere"),
        (vec!["eval", &out, "--motion", &nowhere], 2, "cannot read"),
        (vec!["eval", &out, "--motion", &bad], 1, "does not name the columns"),
        (vec!["eval", &out, "--motion", &upright], 1, "does not begin where the design is at rest"),
        (vec!["eval", &out, "--motion", &sunk], 1, "10.0 mm below the ground"),
        (vec!["eval", &out, "--motion", &file, "--step", "1/480"], 2, "cannot be used with"),
        (vec!["eval", &out, "--task", "dig"], 2, "--motion"),
        (vec!["view", &out, "--in", &set, "--world", "icy"], 2, "did you mean `ice`?"),
        (vec!["view", &out, "--in", &set], 2, "--world"),
        (
            vec!["export", &out, "--to", "drive", "--in", &set, "--world", "ice"],
            2,
            "works only with `--to motion` and `--to signals`",
        ),
    ] {
        let output = sgc(&arguments);
        assert_eq!(code(&output), wanted, "{arguments:?}: {}", errors(&output));
        assert!(errors(&output).contains(says), "{arguments:?}: {}", errors(&output));
    }
}

#[test]
fn bad_input_gets_its_exit_code_and_no_panic() {
    let folder = tempfile::tempdir().unwrap();
    let binary = folder.path().join("binary.sgr");
    std::fs::write(&binary, [0u8, 159, 146, 150, 255, 10, 13, 0]).unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, "x").unwrap();
    let below_file = file.join("run").to_string_lossy().into_owned();
    let binary = binary.to_string_lossy().into_owned();
    let strange = folder.path().to_string_lossy().into_owned();
    let unmade = folder.path().join("unmade").to_string_lossy().into_owned();
    std::fs::write(folder.path().join("keep.txt"), "mine").unwrap();
    for (arguments, wanted, says) in [
        (vec!["check", "nowhere.sgr"], 2, "cannot read nowhere.sgr: there is no such file"),
        (vec!["check", "grammars/codesing.sgr"], 2, "did you mean `codesign.sgr`?"),
        (vec!["check", "grammars/millipede"], 2, "did you mean `millipede.sgr`?"),
        (vec!["check", binary.as_str()], 1, "1 error"),
        (vec!["check", "grammars"], 2, "cannot read grammars"),
        (vec!["check"], 2, "required"),
        (vec!["check", "--format", "pretty", "grammars/codesign.sgr"], 2, "invalid value"),
        (vec!["chekc", "grammars/codesign.sgr"], 2, "check"),
        (vec!["run", "std-rules/blocks.sgr"], 1, "is a module"),
        (vec!["run", "tests/cases/five-errors.sgr"], 1, "E0401"),
        (vec!["run", "grammars/codesign.sgr", "-p", "max_parts"], 2, "NAME=VALUE"),
        (vec!["run", "grammars/codesign.sgr", "-p", "max_parts=99"], 1, "outside its domain"),
        (vec!["run", "grammars/codesign.sgr", "-p", "max_limbs=9"], 1, "no parameter `max_limbs`"),
        (vec!["run", "grammars/codesign.sgr", "--time", "soon"], 2, "90s, 30m or 2h"),
        (vec!["run", "grammars/codesign.sgr", "--jobs", "0"], 2, "0"),
        (vec!["run", "grammars/codesign.sgr", "--solver", "bullet"], 2, "articulated"),
        (
            vec!["run", "grammars/codesign.sgr", "--solver", "balls", "--out", unmade.as_str()],
            1,
            "`--solver balls` cannot simulate",
        ),
        (vec!["run", "grammars/codesign.sgr", "--out", below_file.as_str()], 2, "cannot write"),
        (
            vec!["run", "grammars/codesign.sgr", "--force", "--out", strange.as_str()],
            2,
            "not only a run folder",
        ),
        (vec!["eval", "nowhere.json"], 2, "cannot read nowhere.json"),
        (vec!["eval", "Cargo.toml"], 2, "not a saved design"),
        (vec!["view", "nowhere"], 2, "cannot read nowhere"),
    ] {
        let output = sgc(&arguments);
        assert_eq!(code(&output), wanted, "{arguments:?}: {}", errors(&output));
        assert!(errors(&output).contains(says), "{arguments:?}: {}", errors(&output));
        assert!(!errors(&output).contains("panicked"), "{arguments:?}");
    }
    assert_eq!(std::fs::read_to_string(folder.path().join("keep.txt")).unwrap(), "mine");
    assert!(!Path::new(&unmade).exists(), "a run that cannot begin leaves no folder");
}

#[test]
fn interrupting_a_run_keeps_the_best_so_far() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    let mut child = Command::new(env!("CARGO_BIN_EXE_sgc"))
        .args([
            "run",
            "grammars/codesign.sgr",
            "--max-evals",
            "0",
            "--quiet",
            "--out",
            &out.to_string_lossy(),
        ])
        .current_dir(root())
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    let best = out.join("best.design.json");
    for _ in 0..600 {
        if best.exists() {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    assert_eq!(child.wait().unwrap().code(), Some(75));
    let output = sgc(&["eval", &out.to_string_lossy()]);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    assert!(!out.join("result.json").exists(), "the run is not complete");
}

const COMMANDS: &[&str] = &[
    "new",
    "check",
    "explain",
    "fmt",
    "test",
    "compile",
    "derive",
    "run",
    "resume",
    "eval",
    "view",
    "doc",
    "completions",
];

#[test]
fn every_shell_can_complete_every_command() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let output = sgc(&["completions", shell]);
        assert_eq!(code(&output), 0, "{}", errors(&output));
        let script = String::from_utf8_lossy(&output.stdout).into_owned();
        for word in COMMANDS.iter().chain(&["max-evals"]) {
            assert!(script.contains(word), "{shell}: no {word}");
        }
    }
    let output = sgc(&["completions", "tcsh"]);
    assert_eq!(code(&output), 2);
    assert!(errors(&output).contains("bash"), "{}", errors(&output));
}

#[test]
fn help_names_every_command_that_works() {
    let output = sgc(&["--help"]);
    assert_eq!(code(&output), 0);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    for command in COMMANDS {
        assert!(text.contains(&format!("\n  {command} ")), "{text}");
    }
    assert!(text.contains("sgc completions bash"), "{text}");
}

#[test]
fn what_has_no_value_while_running_is_told_with_its_place_and_ends_the_run_only_at_its_start() {
    let folder = tempfile::tempdir().unwrap();
    let grammar = quick_grammar(folder.path());
    let text = std::fs::read_to_string(&grammar).unwrap();
    let (objective, guard) = ("maximize travel - fall in cm", "require whole          : connected");
    let no_value = "has no value: this divides by zero";
    for (from, to, exit, says) in [
        (objective, "maximize travel / (fall - fall)", 1, no_value.to_owned()),
        (objective, "maximize travel / (count(part) - 2) in cm", 0, format!("{no_value}, in ")),
        (guard, "require whole : 1 / (count(part) - 3) < 2", 0, format!("{no_value}; ")),
    ] {
        assert!(text.contains(from), "{from}");
        std::fs::write(&grammar, text.replace(from, to)).unwrap();
        let run = |out: &str| {
            let out = folder.path().join(out).to_string_lossy().into_owned();
            let output = sgc(&["run", &grammar, "--max-evals", "40", "--out", &out, "--force"]);
            assert_eq!(code(&output), exit, "{to}: {}", errors(&output));
            let told =
                errors(&output).lines().filter(|l| l.contains("quick.sgr:") && l.contains(&says)).count();
            assert_eq!(told, 1, "{to}: {}", errors(&output));
            std::fs::read_to_string(std::path::Path::new(&out).join("evals.csv")).unwrap_or_default()
        };
        // The same seed: also what has no value is the same twice.
        assert_eq!(run("a"), run("b"), "{to}");
    }
}

#[test]
fn a_derivation_that_stops_says_what_stops_each_rule() {
    let folder = tempfile::tempdir().unwrap();
    let grammar = quick_grammar(folder.path());
    let text = std::fs::read_to_string(&grammar).unwrap();
    let guard = "require whole          : connected";
    std::fs::write(&grammar, text.replace(guard, "require alone : count(part) <= 1")).unwrap();
    let output = sgc(&["derive", &grammar, "--steps", "5"]);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    let told = errors(&output);
    assert!(told.contains("5 of 5 moves did nothing: no rule could be applied"), "{told}");
    assert!(told.contains("`alone` would be broken: a robot is one piece (5 times)"), "{told}");
    assert!(told.contains("the rule does not match there (5 times)"), "{told}");
}

#[test]
fn a_page_is_not_written_over_a_device() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run").to_string_lossy().into_owned();
    let output = sgc(&["run", &quick_grammar(folder.path()), "--max-evals", "3", "--out", &out]);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    // A pipe stands for every special file here: a test must not risk a real device.
    let pipe = folder.path().join("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let output = sgc(&["view", &out, "--out", &pipe.to_string_lossy()]);
    assert_eq!(code(&output), 2);
    assert!(errors(&output).contains("not a regular file"), "{}", errors(&output));
}

#[cfg(unix)]
#[test]
fn a_pipe_is_not_laid_out_in_its_place() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    // Nobody writes into it: it would wait for ever.
    let output = sgc(&["fmt", &pipe.to_string_lossy()]);
    assert_eq!(code(&output), 2);
    assert!(errors(&output).contains("sgc fmt - <"), "{}", errors(&output));
}

#[test]
fn a_grammar_that_can_do_nothing_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let grammar = quick_grammar(folder.path());
    let text = std::fs::read_to_string(&grammar).unwrap().replace("  revert  s", "  revert  s\n  weight 0");
    let text = text
        .replace("with free port q\n", "with free port q\n  when count(part) > 99\n")
        .replace("where p is not core", "where p is not core and p.depth > 99");
    std::fs::write(&grammar, text).unwrap();
    let out = folder.path().join("run").to_string_lossy().into_owned();
    let output = sgc(&["run", &grammar, "--max-evals", "30", "--out", &out]);
    assert_eq!(code(&output), 1, "{}", errors(&output));
    assert!(errors(&output).contains("no rule could ever be applied"), "{}", errors(&output));
}

/// A population that begins anew again and again, although no rule can ever be applied, comes to its end.
#[test]
fn a_population_that_can_do_nothing_ends() {
    let folder = tempfile::tempdir().unwrap();
    let grammar = folder.path().join("hub.sgr");
    let text = "grammar hub
        use std.blocks     { cube }
        use std.actuators  { bender }
        use std.actuation  { bezier_pac }
        use std.models     { hinge_model }
        use std.objectives { travel }
        use std.search     { recommended }
        part hub {
          shape = disk(3 cm, 2 cm)  density = 1 g/cm^3  friction = 0.8
          port rim[i in 0 .. 11] at vector(3 cm * cos(i * 30 deg), 0 cm, 3 cm * sin(i * 30 deg)) facing vector(cos(i * 30 deg), 0, sin(i * 30 deg))
        }
        symmetry radial 12 about y
        begin { place core : hub }
        rule add_block {
          match  p : hub with free port q
          attach cube to q
        }
        rule add_actuator {
          match  p : hub with free port q
          attach bender(segments = 3) to q
        }
        param most : Count in 4 .. 20 = 10
        require few : count(part) <= most
        actuate bender with bezier_pac
        simulate hinge_model for 2 s
        maximize travel in cm
        search recommended";
    std::fs::write(&grammar, text).unwrap();
    let out = folder.path().join("run").to_string_lossy().into_owned();
    let output = sgc(&["run", &grammar.to_string_lossy(), "--max-evals", "200", "--out", &out]);
    assert!(errors(&output).contains("no rule could"), "{}", errors(&output));
    assert_ne!(code(&output), 75);
}

#[test]
fn doc_writes_a_page_where_it_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let text = |name: &str| std::fs::read_to_string(at(name)).unwrap();
    let path = |name: &str| at(name).to_string_lossy().into_owned();
    std::fs::copy(root().join("grammars/codesign.sgr"), at("mine.sgr")).unwrap();
    for arguments in [
        vec!["doc".to_owned(), path("mine.sgr")],
        vec!["doc".to_owned(), path("mine.sgr"), "--out".to_owned(), path("other.html")],
        vec!["doc".to_owned(), "std".to_owned(), "--out".to_owned(), path("pages")],
        vec!["doc".to_owned(), "std.blocks".to_owned(), "--out".to_owned(), path("pages")],
    ] {
        let output = sgc(&arguments.iter().map(String::as_str).collect::<Vec<_>>());
        assert_eq!(code(&output), 0, "{arguments:?}: {}", errors(&output));
        assert!(String::from_utf8_lossy(&output.stdout).ends_with(".html\n"));
    }
    assert_eq!(text("mine.html"), text("other.html"));
    assert!(text("mine.html").contains("add_actuator"));
    assert!(
        text("pages/std.html").contains("bezier_pac")
            && !text("pages/std.blocks.html").contains("bezier_pac")
    );

    std::fs::write(at("bad.sgr"), "grammar bad\nlet a = 3 gg\n").unwrap();
    let output = sgc(&["doc", &path("bad.sgr")]);
    assert_eq!(code(&output), 1);
    assert!(errors(&output).contains("E0303") && !at("bad.html").exists(), "{}", errors(&output));
    assert_eq!(code(&sgc(&["doc", &path("nowhere.sgr")])), 2);
    assert_eq!(code(&sgc(&["doc", "std", "--out", &path("mine.sgr")])), 2, "a file is no folder");
}

/// A saved design of a short search.
pub(crate) fn quick_run(folder: &Path) -> std::path::PathBuf {
    let out = folder.join("run");
    let output = sgc(&[
        "run",
        &quick_grammar(folder),
        "--max-evals",
        "60",
        "--quiet",
        "--out",
        &out.to_string_lossy(),
    ]);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    out
}

#[test]
fn every_command_has_a_manual_page() {
    let all = sgc(&["man"]);
    assert_eq!(code(&all), 0);
    assert!(printed(&all).starts_with(".ie") && printed(&all).contains("sgc\\-resume"), "{}", printed(&all));
    for command in ["run", "check", "drive"] {
        let page = printed(&sgc(&["man", command]));
        assert!(page.contains(&format!("sgc\\-{command}")) && page.contains(".SH OPTIONS"), "{page}");
    }
    assert_eq!(code(&sgc(&["man", "fly"])), 2);
}

/// What a schedule comes to is held within the limits of its field: a tournament of a million million bodies aborted the run.
#[test]
fn a_schedule_stays_within_its_limits() {
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(quick_grammar(folder.path())).unwrap();
    let text = text
        .replace("{ nested_annealing }", "{ recommended }")
        .replace("search   nested_annealing", "search recommended");
    let base = folder.path().join("base.sgr");
    std::fs::write(&base, text).unwrap();
    let file = folder.path().join("hostile.sgr");
    let hostile = "variant hostile of \"./base.sgr\" {\n  set recommended.bodies.tournament = if spent > 50 % then 1000000000000 else 8\n  \
                   set recommended.bodies.size = if spent > 50 % then -3 else 16\n}\n";
    std::fs::write(&file, hostile).unwrap();
    let out = folder.path().join("run").to_string_lossy().into_owned();
    let run = sgc(&["run", &file.to_string_lossy(), "--max-evals", "40", "--quiet", "--out", &out]);
    assert_eq!(code(&run), 0, "{}", errors(&run));
}

/// What a schedule comes to may be no move at all: each iteration has one.
#[test]
fn iterations_without_moves_come_to_an_end() {
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(quick_grammar(folder.path())).unwrap();
    let file = folder.path().join("dwindling.sgr");
    let text = text
        + "\nsearch dwindling {\n keep = 80 %\n bodies annealing { iterations = 1000000000000  moves = floor(3 * (1 - spent))  temperature = 9  stop = false }\n}\n";
    let text = text
        .replace("search   nested_annealing", "search dwindling")
        .replace("use std.search     { nested_annealing }\n", "");
    std::fs::write(&file, text).unwrap();
    let out = folder.path().join("run").to_string_lossy().into_owned();
    let run = sgc(&["run", &file.to_string_lossy(), "--max-evals", "20", "--quiet", "--out", &out]);
    assert_eq!(code(&run), 0, "{}", errors(&run));
}

/// A best that stands still is no robot to look at.
#[test]
fn a_run_that_finds_nothing_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let note = "this robot does no better than one that stands still";
    let still = folder.path().join("still").to_string_lossy().into_owned();
    let grammar = quick_grammar(folder.path());
    let run = sgc(&["run", &grammar, "--max-evals", "1", "--quiet", "--out", &still]);
    assert!(errors(&run).contains(note), "{}", errors(&run));
    let several = ["run", &grammar, "--max-evals", "1", "--runs", "2", "--quiet", "--out"];
    let both = folder.path().join("both").to_string_lossy().into_owned();
    let runs = sgc(&[&several[..], &[&both]].concat());
    assert!(errors(&runs).contains(note), "{}", errors(&runs));
    // One that moves is.
    let text = std::fs::read_to_string(&grammar).unwrap();
    let objective = text.lines().find(|line| line.starts_with("maximize")).unwrap();
    std::fs::write(&grammar, text.replace(objective, "maximize travel + 1 cm * count(part) in cm")).unwrap();
    let moves = folder.path().join("moves").to_string_lossy().into_owned();
    let run = sgc(&["run", &grammar, "--max-evals", "120", "--quiet", "--out", &moves]);
    let best: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(format!("{moves}/best.design.json")).unwrap()).unwrap();
    let task = &best["tasks"][0];
    let gained = task["value"].as_f64().unwrap() - task["at_rest"].as_f64().unwrap();
    assert_eq!(errors(&run).contains(note), gained < 1e-3, "{gained} {}", errors(&run));
    assert!(gained > 1e-3, "{gained}");
}

/// A search goes on from the body and the curves of a saved design, also by another grammar of the same rules.
#[test]
fn a_search_begins_with_a_saved_design() {
    let folder = tempfile::tempdir().unwrap();
    let run = quick_run(folder.path());
    let to = run.to_string_lossy();
    let best: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(run.join("best.design.json")).unwrap()).unwrap();
    let grammar = quick_grammar(folder.path());
    let next = |grammar: &str, name: &str| {
        let out = folder.path().join(name);
        let more = ["--from-design", &to, "--max-evals", "30", "--quiet", "--out", &out.to_string_lossy()];
        (sgc(&[&["run", grammar][..], &more].concat()), out)
    };
    let (output, out) = next(&grammar, "next");
    assert_eq!(code(&output), 0, "{}", errors(&output));
    let moves = std::fs::read_to_string(out.join("evals.csv")).unwrap();
    let first: f64 = moves.lines().nth(1).unwrap().split(',').nth(6).unwrap().parse().unwrap();
    assert!(first >= best["value"].as_f64().unwrap(), "{first} {moves}");
    assert!(
        std::fs::read_to_string(out.join("run.toml"))
            .unwrap()
            .contains("best.design.json (codesign of seed 1")
    );
    // Rules that do not make it are an error; an actuation that it does not fit draws its curves anew.
    let other = root().join("tests/cases/bases/worm.sgr");
    let (refused, _) = next(&other.to_string_lossy(), "other");
    assert_eq!(code(&refused), 1, "{}", errors(&refused));
    assert!(errors(&refused).contains("the rules of `worm` do not make the design"), "{}", errors(&refused));
    // So are rules whose conditions do not hold where its steps need them.
    let text = std::fs::read_to_string(&grammar).unwrap();
    let guarded = text.replace("with free port q\n", "with free port q where count(ball) >= 9\n");
    assert_ne!(guarded, text);
    let file = folder.path().join("guarded.sgr");
    std::fs::write(&file, guarded).unwrap();
    let (refused, out) = next(&file.to_string_lossy(), "guarded");
    assert_eq!(code(&refused), 1, "{}", errors(&refused));
    assert!(errors(&refused).contains("by its own steps: step 1"), "{}", errors(&refused));
    assert!(!out.exists());
    // Where the same step makes another body, that is told: here without the image of a part.
    let small = folder.path().join("small").to_string_lossy().into_owned();
    let few = ["-p", "max_parts=3", "--seed", "8", "--max-evals", "30", "--quiet", "--out", &small];
    // At its sides every part has an image, and the best has the most parts.
    let objective = text.lines().find(|line| line.starts_with("maximize")).unwrap();
    let sided = text
        .replace("with free port q\n", "with free port q where q is left or q is right\n")
        .replace(objective, "maximize count(part)");
    let file = folder.path().join("sided.sgr");
    std::fs::write(&file, &sided).unwrap();
    assert_eq!(code(&sgc(&[&["run", &file.to_string_lossy()][..], &few].concat())), 0);
    let file = folder.path().join("halves.sgr");
    std::fs::write(&file, sided.replace("symmetry mirror xy", "symmetry none")).unwrap();
    let halves = folder.path().join("halves").to_string_lossy().into_owned();
    let more = ["--from-design", &small, "--max-evals", "20", "--quiet", "--out", &halves];
    let output = sgc(&[&["run", &file.to_string_lossy()][..], &more].concat());
    assert_eq!(code(&output), 0, "{}", errors(&output));
    assert!(errors(&output).contains("make another body, of 2 parts instead of 3"), "{}", errors(&output));
    let judged = sgc(&["eval", &small, "--grammar", &file.to_string_lossy()]);
    assert!(errors(&judged).contains("make another body, of 2 parts instead of 3"), "{}", errors(&judged));
    // A parameter that was set when the design was made is told where it is not set.
    assert!(errors(&output).contains("was made with max_parts = 3, but this command uses other values"));
    let same = sgc(&["eval", &small, "--grammar", &grammar, "-p", "max_parts=3"]);
    assert_eq!(code(&same), 0, "{}", errors(&same));
    assert!(!errors(&same).contains("was made with"), "{}", errors(&same));
    // The same steps with parts that are declared otherwise.
    let heavier = folder.path().join("heavier.sgr");
    let own = "use std.blocks { ball }\npart cube { shape = box(2.5 cm, 2.5 cm, 2.5 cm) density = 1.1 g/cm^3 friction = 0.8 }";
    let heavy = text.replacen("use std.blocks     { cube, ball }", own, 1);
    assert_ne!(heavy, text);
    std::fs::write(&heavier, heavy).unwrap();
    let judged = sgc(&["eval", &small, "--grammar", &heavier.to_string_lossy(), "-p", "max_parts=3"]);
    assert!(errors(&judged).contains("declares the parts of"), "{}", errors(&judged));
    assert!(!errors(&same).contains("declares the parts of"), "{}", errors(&same));
    // What is another quantity now is not taken over.
    let amplitude = text
        .replace("use std.actuation  { bezier_pac }", "")
        .replace("bender with bezier_pac", "bender with wave");
    let wave = |ty: &str, unit: &str, turned: &str| {
        format!(
            "{amplitude}\nactuation wave for a : actuator {{\n  vary size : {ty} in 0{unit} .. 90{unit} mutate 0.5 by normal(0{unit}, 9{unit})\n  drive angle = {turned} * sin(t / 2 s * 360 deg)\n}}\n"
        )
    };
    let (angles, numbers) = (folder.path().join("angles.sgr"), folder.path().join("numbers.sgr"));
    std::fs::write(&angles, wave("Angle", " deg", "size")).unwrap();
    std::fs::write(&numbers, wave("Number", ".0", "size * 1 deg")).unwrap();
    let swung = folder.path().join("swung").to_string_lossy().into_owned();
    let output = sgc(&[
        "run",
        &angles.to_string_lossy(),
        "--seed",
        "8",
        "--max-evals",
        "30",
        "--quiet",
        "--out",
        &swung,
    ]);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    let judged = sgc(&["eval", &swung, "--grammar", &numbers.to_string_lossy()]);
    assert_eq!(code(&judged), 1);
    assert!(
        errors(&judged).contains("`size` is of type Angle in the grammar that made the design"),
        "{}",
        errors(&judged)
    );
    let less = sgc(&["eval", &small, "--grammar", &grammar]);
    assert!(errors(&less).contains("was made with max_parts = 3"), "{}", errors(&less));
    let shorter =
        text.replace("{ bezier_pac }", "{ two_sided_pac }").replace("with bezier_pac", "with two_sided_pac");
    let file = folder.path().join("two_sided.sgr");
    std::fs::write(&file, shorter).unwrap();
    let (output, _) = next(&file.to_string_lossy(), "drawn");
    assert_eq!(code(&output), 0, "{}", errors(&output));
    assert!(errors(&output).contains("draws curves anew"), "{}", errors(&output));
}
