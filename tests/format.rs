//! Layout: it keeps what a grammar says, the project's own files have it, and
//! `sgc fmt` changes files only as it should.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use grammar_lang::format::format;
use grammar_lang::source::SourceMap;
use sgc::results::saved::rules_hash;

use crate::support::{GRAMMARS, codesign, compile_texts, root, texts};

fn formatted(name: &str, text: &str) -> String {
    let mut sources = SourceMap::default();
    let file = sources.add(name, text);
    format(&sources, file).unwrap_or_else(|why| panic!("{name}: {why:?}"))
}

/// The text with all its space where it was not: a break after every word, as far as
/// numbers keep their units and comments their lines.
fn stretched(text: &str) -> String {
    let mut out = String::new();
    for line in text.lines() {
        let quoted = line.contains('"') || line.contains('#');
        let words: Vec<&str> = if quoted { vec![line.trim()] } else { line.split_whitespace().collect() };
        for word in &words {
            out += word;
            // A unit stays on the line of its number.
            out.push(if word.ends_with(|c: char| c.is_ascii_digit()) { ' ' } else { '\n' });
        }
        out.push('\n');
    }
    out
}

#[test]
fn the_projects_own_files_have_the_layout() {
    for folder in ["grammars", "grammars/experiments", "std-rules"] {
        for entry in std::fs::read_dir(root().join(folder)).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                continue;
            }
            let text = std::fs::read_to_string(&path).unwrap();
            let name = path.to_string_lossy();
            assert_eq!(formatted(&name, &text), text, "run `sgc fmt {name}`");
        }
    }
}

#[test]
fn layout_keeps_the_typed_rule_set() {
    let original = texts();
    let stretched: std::collections::BTreeMap<_, _> =
        original.iter().map(|(name, text)| (name.clone(), stretched(text))).collect();
    let again = stretched.iter().map(|(name, text)| (name.clone(), formatted(name, text))).collect();
    assert_ne!(original, stretched);
    for entry in GRAMMARS {
        let before = rules_hash(&compile_texts(&stretched, entry).unwrap());
        assert_eq!(before, rules_hash(&compile_texts(&original, entry).unwrap()), "{entry}");
        assert_eq!(before, rules_hash(&compile_texts(&again, entry).unwrap()), "{entry}");
    }
}

fn fmt(arguments: &[&str], folder: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_sgc"));
    command.arg("fmt").args(arguments).current_dir(folder).env("NO_COLOR", "1").output().unwrap()
}

fn said(output: &Output) -> (Option<i32>, String, String) {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}

#[test]
fn files_change_only_as_they_should() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let text = |name: &str| std::fs::read_to_string(at(name)).unwrap();
    std::fs::write(at("ugly.sgr"), "let a=3\r\nlet bc =4 # four").unwrap();
    std::fs::write(at("broken.sgr"), "let  a = \n").unwrap();
    std::fs::write(at("fine.sgr"), "let a  = 3\nlet bc = 4   # four\n").unwrap();

    let (code, out, err) = said(&fmt(&["--check", "fine.sgr", "ugly.sgr"], folder.path()));
    assert_eq!((code, out.as_str(), err.as_str()), (Some(1), "ugly.sgr\n", ""));
    assert_eq!(text("ugly.sgr"), "let a=3\r\nlet bc =4 # four", "--check changes nothing");

    // A broken file is shown and left alone; the others are laid out.
    let (code, out, err) = said(&fmt(&["broken.sgr", "ugly.sgr", "fine.sgr"], folder.path()));
    assert_eq!((code, out.as_str()), (Some(1), ""));
    assert!(err.contains("E0103") && err.contains("broken.sgr:1:"), "{err}");
    assert!(err.contains("ugly.sgr: formatted") && !err.contains("fine.sgr"), "{err}");
    assert_eq!(text("broken.sgr"), "let  a = \n");
    assert_eq!(text("ugly.sgr"), text("fine.sgr"));
    assert_eq!(said(&fmt(&["--check", "ugly.sgr"], folder.path())), (Some(0), String::new(), String::new()));

    let (code, _, err) = said(&fmt(&["nowhere.sgr"], folder.path()));
    assert!(code == Some(2) && err.contains("cannot read nowhere.sgr"), "{err}");
    let (code, ..) = said(&fmt(&[], folder.path()));
    assert_eq!(code, Some(2));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 3, "nothing is left over");
}

#[cfg(unix)]
#[test]
fn permissions_and_links_stay() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.sgr");
    let link = folder.path().join("link.sgr");
    let mode = |path: &Path| std::fs::metadata(path).unwrap().permissions().mode() & 0o777;
    std::fs::write(&path, "let a=3").unwrap();
    std::os::unix::fs::symlink("a.sgr", &link).unwrap();
    std::fs::set_permissions(&path, PermissionsExt::from_mode(0o444)).unwrap();
    let (code, _, err) = said(&fmt(&["a.sgr"], folder.path()));
    assert!(code == Some(2) && err.contains("cannot format a.sgr: it is read-only"), "{err}");
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "let a=3");

    std::fs::set_permissions(&path, PermissionsExt::from_mode(0o640)).unwrap();
    assert_eq!(said(&fmt(&["link.sgr"], folder.path())).0, Some(0));
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "let a = 3\n");
    assert_eq!(mode(&path), 0o640);
    assert!(std::fs::symlink_metadata(&link).unwrap().is_symlink());

    // A new file in the place of one of two names would leave the other with the old text.
    std::fs::write(&path, "let a=3").unwrap();
    std::fs::hard_link(&path, folder.path().join("twin.sgr")).unwrap();
    let (code, _, err) = said(&fmt(&["a.sgr"], folder.path()));
    assert!(code == Some(2) && err.contains("other names"), "{err}");
    assert_eq!(std::fs::read_to_string(folder.path().join("twin.sgr")).unwrap(), "let a=3");
}

#[test]
fn standard_input_is_laid_out_on_standard_output() {
    let run = |arguments: &[&str], text: &str| {
        let mut child = Command::new(env!("CARGO_BIN_EXE_sgc"))
            .arg("fmt")
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        child.stdin.take().unwrap().write_all(text.as_bytes()).unwrap();
        said(&child.wait_with_output().unwrap())
    };
    let grammar = codesign();
    let crowded: String = grammar.lines().map(|line| format!("{}\n", line.trim())).collect();
    assert_eq!(run(&["-"], &crowded), (Some(0), grammar.clone(), String::new()));
    assert_eq!(run(&["--check", "-"], &crowded), (Some(1), "<stdin>\n".to_owned(), String::new()));
    assert_eq!(run(&["--check", "-"], &grammar), (Some(0), String::new(), String::new()));
    let (code, out, err) = run(&["-"], "rule r {");
    assert!(code == Some(1) && out.is_empty() && err.contains("E0104"), "{err}");
}
