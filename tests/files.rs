//! What commands do to files: what others wrote or edited is kept, what is written is whole, and only files are read.

use std::process::{Command, Stdio};

use crate::command_line::{code, errors, printed, quick_grammar, quick_run, sgc};
use crate::support::root;

/// A signal at any moment leaves nothing behind, and files are there whole or not at all.
#[cfg(unix)]
#[test]
fn a_command_that_is_interrupted_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let run = quick_run(folder.path());
    let page = run.join("view.html");
    assert_eq!(code(&sgc(&["view", &run.to_string_lossy()])), 0);
    let whole = std::fs::read(&page).unwrap();
    for number in 0..12 {
        let mut child = Command::new(env!("CARGO_BIN_EXE_sgc"))
            .args(["view".as_ref(), run.as_os_str()])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(std::time::Duration::from_millis(15 * number));
        let kind = ["-INT", "-TERM"][number as usize % 2];
        let _ = Command::new("kill").args([kind, &child.id().to_string()]).status();
        let ended = child.wait().unwrap().code();
        // Before the handler is set, the system ends it.
        assert!([Some(0), Some(130), None].contains(&ended), "{ended:?}");
        assert_eq!(std::fs::read(&page).unwrap(), whole);
        let names = std::fs::read_dir(&run).unwrap().map(|entry| entry.unwrap().file_name());
        let left: Vec<_> = names.filter(|name| name.to_string_lossy().starts_with('.')).collect();
        assert!(left.is_empty(), "{left:?}");
    }
}

/// Where a file may not become longer, that is an error of writing.
#[cfg(unix)]
#[test]
fn a_file_that_may_not_grow_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let run = quick_run(folder.path());
    let out = folder.path().join("model.xml");
    let command = "ulimit -f 1; exec \"$0\" export \"$1\" --to motion --out \"$2\"";
    let output = Command::new("sh")
        .args(["-c", command, env!("CARGO_BIN_EXE_sgc")])
        .args([run.as_os_str(), out.as_os_str()])
        .output()
        .unwrap();
    assert_eq!(code(&output), 2, "{}", errors(&output));
    assert!(errors(&output).contains("too large"), "{}", errors(&output));
    let left = std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name());
    assert!(left.filter(|name| name.to_string_lossy().starts_with('.')).count() == 0 && !out.exists());
}

#[test]
fn what_others_wrote_is_not_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let run = quick_run(folder.path());
    let (run, mine) = (run.to_string_lossy().into_owned(), folder.path().join("mine.html"));
    let to = mine.to_string_lossy().into_owned();
    for command in [
        &["view", &run][..],
        &["export", &run, "--to", "mjcf"],
        &["export", &run, "--to", "drive"],
        &["export", &run, "--to", "begin"],
        &["export", &run, "--to", "motion"],
        &["doc", "grammars/codesign.sgr"],
    ] {
        let with = |more: &[&str]| sgc(&[command, &["--out", &to], more].concat());
        std::fs::write(&mine, "grammar mine\n").unwrap();
        let refused = with(&[]);
        assert_eq!(code(&refused), 2, "{command:?}");
        assert!(errors(&refused).contains("--force"), "{}", errors(&refused));
        assert_eq!(std::fs::read_to_string(&mine).unwrap(), "grammar mine\n", "{command:?}");
        let forced = with(&["--force"]);
        assert_eq!(code(&forced), 0, "{command:?}: {}", errors(&forced));
        // What the command wrote itself it replaces, but not what was edited since.
        assert_eq!(code(&with(&[])), 0, "{command:?}: {}", errors(&with(&[])));
        let edited = std::fs::read_to_string(&mine).unwrap().replacen('1', "2", 1);
        std::fs::write(&mine, &edited).unwrap();
        assert_eq!(code(&with(&[])), 2, "{command:?}");
        assert_eq!(std::fs::read_to_string(&mine).unwrap(), edited, "{command:?}");
    }
}

#[test]
fn a_command_does_not_write_over_what_it_reads() {
    let folder = tempfile::tempdir().unwrap();
    let run = quick_run(folder.path());
    let design = run.join("best.design.json");
    let before = std::fs::read(&design).unwrap();
    let (from, to) = (design.to_string_lossy().into_owned(), folder.path().join("link"));
    #[cfg(unix)]
    std::os::unix::fs::symlink(&design, &to).unwrap();
    #[cfg(not(unix))]
    let to = design.clone();
    for command in
        [&["view", &from][..], &["export", &from, "--to", "motion"], &["export", &from, "--to", "mjcf"]]
    {
        let output = sgc(&[command, &["--force", "--out", &to.to_string_lossy()]].concat());
        assert_eq!(code(&output), 2, "{command:?}");
        assert!(errors(&output).contains("which this command reads"), "{}", errors(&output));
        assert_eq!(std::fs::read(&design).unwrap(), before, "{command:?}");
    }
    // Nor over what a run cannot do without, nor over what another command wrote.
    let (other, page) = (run.join("run.toml").to_string_lossy().into_owned(), run.join("view.html"));
    let output = sgc(&["export", &from, "--to", "mjcf", "--force", "--out", &other]);
    assert_eq!(code(&output), 2);
    assert!(errors(&output).contains("is a file of the run"), "{}", errors(&output));
    assert_eq!(code(&sgc(&["view", &from])), 0);
    let output = sgc(&["export", &from, "--to", "mjcf", "--out", &page.to_string_lossy()]);
    assert_eq!(code(&output), 2);
    assert!(errors(&output).contains("did not write it"), "{}", errors(&output));
    assert_eq!(code(&sgc(&["view", &from])), 0, "its own page is replaced");
    // Nor over what that imports, by any name.
    let (base, own) = (folder.path().join("base.sgr"), folder.path().join("own.sgr"));
    let text = std::fs::read_to_string(root().join("tests/cases/bases/worm.sgr")).unwrap();
    std::fs::write(&base, &text).unwrap();
    std::fs::write(&own, "variant own of \"./base.sgr\" {\n  set longest = 4\n}\n").unwrap();
    let output = sgc(&[
        "doc",
        &own.to_string_lossy(),
        "--force",
        "--out",
        &base.with_extension("html").to_string_lossy(),
    ]);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    #[cfg(unix)]
    {
        let page = folder.path().join("page.html");
        std::os::unix::fs::symlink(&base, &page).unwrap();
        let output = sgc(&["doc", &own.to_string_lossy(), "--force", "--out", &page.to_string_lossy()]);
        assert_eq!(code(&output), 2, "{}", errors(&output));
        assert_eq!(std::fs::read_to_string(&base).unwrap(), text);
    }
}

#[cfg(unix)]
#[test]
fn devices_are_not_read_and_pipes_are() {
    let folder = tempfile::tempdir().unwrap();
    for command in ["check", "view", "eval"] {
        let output = sgc(&[command, "/dev/zero"]);
        assert_eq!(code(&output), 2, "{command}");
        assert!(errors(&output).contains("device"), "{}", errors(&output));
    }
    let importing = folder.path().join("importing.sgr");
    std::os::unix::fs::symlink("/dev/zero", folder.path().join("zero.sgr")).unwrap();
    std::fs::write(&importing, "use \"./zero.sgr\" { cube }\ngrammar importing\n").unwrap();
    let output = sgc(&["check", &importing.to_string_lossy()]);
    assert_eq!(code(&output), 1);
    assert!(printed(&output).contains("device"), "{}", printed(&output));
    let piped = |path: &str, text: &[u8]| {
        let mut check = Command::new(env!("CARGO_BIN_EXE_sgc"))
            .args(["check", path])
            .current_dir(root())
            .stdin(std::process::Stdio::piped())
            .stdout(std::process::Stdio::piped())
            .stderr(std::process::Stdio::piped())
            .spawn()
            .unwrap();
        let mut to = check.stdin.take().unwrap();
        // It may stop reading.
        let _ = std::io::Write::write_all(&mut to, text);
        drop(to);
        check.wait_with_output().unwrap()
    };
    let text = std::fs::read(root().join("tests/cases/bases/worm.sgr")).unwrap();
    for path in ["-", "/dev/stdin"] {
        let output = piped(path, &text);
        assert_eq!(code(&output), 0, "{path}: {}", errors(&output));
        let output = piped(path, &vec![b' '; 65 << 20]);
        assert_eq!(code(&output), 2, "{path}");
        assert!(errors(&output).contains("larger than 64 MB"), "{path}: {}", errors(&output));
    }
}

/// A report replaces its page and its tables as long as nobody has edited them.
#[test]
fn an_edited_table_of_a_report_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let run = quick_run(folder.path());
    let to = run.to_string_lossy().into_owned();
    for _ in 0..2 {
        let report = sgc(&["report", &to]);
        assert_eq!(code(&report), 0, "{}", errors(&report));
    }
    let table = run.join("report/runs.csv");
    std::fs::write(&table, "notes of mine\n").unwrap();
    for command in [&["report", &to][..], &["run", &quick_grammar(folder.path()), "--force", "--out", &to]] {
        let refused = sgc(command);
        assert_eq!(code(&refused), 2, "{command:?}: {}", errors(&refused));
        assert_eq!(std::fs::read_to_string(&table).unwrap(), "notes of mine\n", "{command:?}");
    }
    let forced = sgc(&["report", &to, "--force"]);
    assert_eq!(code(&forced), 0, "{}", errors(&forced));
    assert_eq!(code(&sgc(&["report", &to])), 0);
}

/// A run does not replace one of which somebody has changed a file.
#[test]
fn an_edited_file_of_a_run_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let run = quick_run(folder.path());
    let to = run.to_string_lossy().into_owned();
    let grammar = quick_grammar(folder.path());
    let begin_anew = || sgc(&["run", &grammar, "--force", "--max-evals", "20", "--out", &to]);
    let sources = std::fs::read_dir(run.join("sources")).unwrap();
    let source = sources.map(|file| file.unwrap().path()).next().unwrap();
    let mut files: Vec<_> =
        ["evals.csv", "best.design.json", "result.json", "run.toml"].map(|name| run.join(name)).into();
    files.push(source);
    for file in files {
        let whole = std::fs::read_to_string(&file).unwrap();
        // The first line may be the recorded command, in which the folder's name may hold any digit.
        let (first, rest) = whole.split_once('\n').unwrap();
        let edited = format!("{first}\n{}", rest.replacen('1', "2", 1));
        assert_ne!(whole, edited);
        std::fs::write(&file, &edited).unwrap();
        let refused = begin_anew();
        assert_eq!(code(&refused), 2, "{}: {}", file.display(), errors(&refused));
        let message = errors(&refused);
        assert!(message.contains("was changed since the run wrote it"), "{message}");
        assert!(message.contains(&*file.file_name().unwrap().to_string_lossy()), "{message}");
        assert_eq!(std::fs::read_to_string(&file).unwrap(), edited);
        std::fs::write(&file, &whole).unwrap();
    }
    // What is gone cannot be lost.
    std::fs::remove_file(run.join("evals.csv")).unwrap();
    let replaced = begin_anew();
    assert_eq!(code(&replaced), 0, "{}", errors(&replaced));
}

/// A design of another run that lies in the folder is nobody's to remove, and is not told as this run's.
#[test]
fn a_design_of_another_run_is_kept_and_told() {
    let folder = tempfile::tempdir().unwrap();
    let run = quick_run(folder.path());
    let grammar = quick_grammar(folder.path());
    let other = folder.path().join("other");
    let to = other.to_string_lossy().into_owned();
    let made = sgc(&["run", &grammar, "--seed", "7", "--max-evals", "20", "--out", &to]);
    assert_eq!(code(&made), 0, "{}", errors(&made));
    let best = run.join("best.design.json");
    std::fs::rename(other.join("best.design.json"), &best).unwrap();
    let foreign = std::fs::read(&best).unwrap();
    let at = run.to_string_lossy().into_owned();
    let refused = sgc(&["run", &grammar, "--force", "--max-evals", "20", "--out", &at]);
    assert_eq!(code(&refused), 2, "{}", errors(&refused));
    assert!(errors(&refused).contains("is a design of another run"), "{}", errors(&refused));
    for command in [&["eval"][..], &["view"], &["export", "--to", "begin"]] {
        let refused = sgc(&[command, &[&*at]].concat());
        assert_eq!(code(&refused), 2, "{command:?}: {}", errors(&refused));
        assert!(errors(&refused).contains("it belongs to another run"), "{command:?}: {}", errors(&refused));
    }
    assert_eq!(std::fs::read(&best).unwrap(), foreign);
}

/// What several runs replace is kept until one of them has a design.
#[test]
fn several_runs_keep_what_they_replace_until_they_have_a_design() {
    let folder = tempfile::tempdir().unwrap();
    let run = quick_run(folder.path());
    let best = std::fs::read(run.join("best.design.json")).unwrap();
    let grammar = quick_grammar(folder.path());
    let at = run.to_string_lossy().into_owned();
    let stopped = sgc(&[
        "run",
        &grammar,
        "--force",
        "--runs",
        "2",
        "--max-evals",
        "20",
        "--time",
        "0.000001s",
        "--out",
        &at,
    ]);
    assert_eq!(code(&stopped), 75, "{}", errors(&stopped));
    let mut beside = std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().path());
    let older = beside.find(|path| path.to_string_lossy().contains(".replaced-")).unwrap();
    assert_eq!(std::fs::read(older.join("best.design.json")).unwrap(), best);
    assert!(errors(&stopped).contains("the earlier contents are kept in"), "{}", errors(&stopped));
    let whole = sgc(&["resume", &at]);
    assert_eq!(code(&whole), 0, "{}", errors(&whole));
    assert!(run.join("seed-2/best.design.json").exists() && !older.exists());
}

/// A run does not replace the folder that holds its grammar.
#[test]
fn a_run_keeps_the_grammar_that_it_is_made_of() {
    let folder = tempfile::tempdir().unwrap();
    let run = quick_run(folder.path());
    let source = std::fs::read_dir(run.join("sources"))
        .unwrap()
        .map(|file| file.unwrap().path())
        .find(|file| file.to_string_lossy().contains("quick"))
        .expect("the grammar");
    let arguments = ["run", &source.to_string_lossy(), "--force", "--out", &run.to_string_lossy()];
    let refused = sgc(&arguments);
    assert_eq!(code(&refused), 2, "{}", errors(&refused));
    assert!(errors(&refused).contains("which this run was made of"), "{}", errors(&refused));
    assert!(source.exists());
    // Nor that of the design that it begins with.
    let to = run.to_string_lossy();
    let grammar = quick_grammar(folder.path());
    let refused = sgc(&["run", &grammar, "--from-design", &to, "--force", "--out", &to]);
    assert_eq!(code(&refused), 2, "{}", errors(&refused));
    assert!(errors(&refused).contains("which this run was made of"), "{}", errors(&refused));
}

#[cfg(unix)]
#[test]
fn a_pipe_in_a_run_folder_is_not_waited_for() {
    let folder = tempfile::tempdir().unwrap();
    let run = quick_run(folder.path());
    let best = run.join("best.design.json");
    std::fs::remove_file(&best).unwrap();
    assert!(Command::new("mkfifo").arg(&best).status().unwrap().success());
    let view = sgc(&["view", &run.to_string_lossy()]);
    assert_eq!(code(&view), 2, "{}", errors(&view));
    assert!(errors(&view).contains("pipe"), "{}", errors(&view));
}

#[cfg(unix)]
#[test]
fn names_need_not_be_unicode() {
    use std::os::unix::ffi::OsStrExt;
    let folder = tempfile::tempdir().unwrap();
    let odd = folder.path().join(std::ffi::OsStr::from_bytes(b"odd\xff.sgr"));
    std::fs::copy(quick_grammar(folder.path()), &odd).unwrap();
    let out = folder.path().join(std::ffi::OsStr::from_bytes(b"out\xff"));
    let run = Command::new(env!("CARGO_BIN_EXE_sgc"))
        .arg("run")
        .arg(&odd)
        .args(["--max-evals", "20", "--out"])
        .arg(&out)
        .current_dir(root())
        .output()
        .unwrap();
    assert_eq!(code(&run), 0, "{}", errors(&run));
    assert!(out.join("result.json").exists());
}

/// A file that imports itself through links to its own folder has ever new names; a file behind a link is read, and kept by its name.
#[cfg(unix)]
#[test]
fn imports_through_links_end() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    for link in ["one", "two"] {
        std::os::unix::fs::symlink(".", at(link)).unwrap();
    }
    let ring = at("ring.sgr");
    std::fs::write(&ring, "use \"./one/ring.sgr\" { x }\nuse \"./two/ring.sgr\" { x }\n").unwrap();
    let output = sgc(&["check", &ring.to_string_lossy()]);
    assert_eq!(code(&output), 1, "{}", errors(&output));
    assert!(printed(&output).contains("circular import: "), "{}", printed(&output));
    std::fs::create_dir(at("shared")).unwrap();
    std::os::unix::fs::symlink("shared", at("lib")).unwrap();
    std::fs::write(at("shared/numbers.sgr"), "let swing_of_all = 20 deg\n").unwrap();
    let quick = std::fs::read_to_string(quick_grammar(folder.path())).unwrap();
    let grammar = at("linked.sgr");
    std::fs::write(
        &grammar,
        quick + "\nuse \"./lib/numbers.sgr\" { swing_of_all }\npattern tried = swing_of_all\n",
    )
    .unwrap();
    let run = at("run").to_string_lossy().into_owned();
    let output = sgc(&["run", &grammar.to_string_lossy(), "--max-evals", "20", "--quiet", "--out", &run]);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    assert_eq!(code(&sgc(&["eval", &run])), 0);
}
