//! The map is true: paths exist, and layers know only those before them.

use crate::support::{read, root};

/// The layers of the engine, first to last. Each may use itself and those before it.
const ENGINE: &[&str] = &[
    "deep",
    "reading",
    "markup",
    "loader",
    "document",
    "design",
    "simulate",
    "derive",
    "audit",
    "learn",
    "drive",
    "scenarios",
    "score",
    "search",
    "trials",
    "hardware",
    "results",
    "calibrate",
    "solid",
    "fit",
    "study",
    "testing",
    "cli",
];
/// The layers of the language.
const LANGUAGE: &[&str] = &[
    "source",
    "units",
    "shape",
    "diagnostics",
    "syntax",
    "format",
    "names",
    "ir",
    "eval",
    "types",
    "bounds",
    "lint",
    "testing",
];

fn rust_files(folder: &std::path::Path, into: &mut Vec<std::path::PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            rust_files(&path, into);
        } else if path.extension().is_some_and(|e| e == "rs") {
            into.push(path);
        }
    }
}

/// Checks every `crate::LAYER` in a crate against the order of its layers.
fn check(source: &str, layers: &[&str]) {
    let mut files = Vec::new();
    rust_files(&root().join(source), &mut files);
    let mut seen = 0;
    for file in files {
        let relative = file.strip_prefix(root().join(source)).unwrap().to_string_lossy().into_owned();
        let own = relative.split(['/', '.']).next().unwrap().to_owned();
        if ["main", "lib"].contains(&own.as_str()) {
            continue;
        }
        let rank =
            layers.iter().position(|l| *l == own).unwrap_or_else(|| panic!("{relative} belongs to no layer"));
        let text = std::fs::read_to_string(&file).unwrap();
        for (i, _) in text.match_indices("crate::") {
            let used: String =
                text[i + 7..].chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
            if let Some(other) = layers.iter().position(|l| *l == used) {
                assert!(other <= rank, "{source}/{relative}: `{own}` must not know `{used}`");
                seen += 1;
            }
        }
    }
    assert!(seen > 20, "the test sees no uses");
}

#[test]
fn layers_know_only_those_before_them() {
    check("src", ENGINE);
    check("grammar-lang/src", LANGUAGE);
}

/// The files and folders beside a file that it names, those that only its tests name left out.
fn siblings_named(file: &std::path::Path, siblings: &[String]) -> Vec<usize> {
    let text = std::fs::read_to_string(file).unwrap();
    let code = text.split("#[cfg(test)]").next().unwrap().lines();
    let text: String = code.filter(|line| !line.trim_start().starts_with("//")).collect();
    // `use super::{one, two::Three}` names both.
    let of_list = |list: &str| -> Vec<String> {
        let end = list.find("};").unwrap_or(list.len());
        let inner = list.get(1..end).unwrap_or_default();
        inner.split(',').map(|part| part.split("::").next().unwrap_or_default().trim().to_owned()).collect()
    };
    let named = text.match_indices("super::").filter(|(i, _)| !text[..*i].ends_with("super::")).flat_map(
        |(i, path)| {
            let rest = &text[i + path.len()..];
            let word: String = rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
            if rest.starts_with('{') { of_list(rest) } else { vec![word] }
        },
    );
    named.filter_map(|name| siblings.iter().position(|sibling| *sibling == name)).collect()
}

/// The files on a circle, if from this one there is a way back to one on the way.
fn circle(edges: &[Vec<usize>], way: &mut Vec<usize>, done: &mut [bool]) -> Option<Vec<usize>> {
    let at = *way.last().unwrap();
    for &next in &edges[at] {
        if let Some(begin) = way.iter().position(|one| *one == next) {
            return Some(way[begin..].to_vec());
        }
        if !done[next] {
            way.push(next);
            let found = circle(edges, way, done);
            way.pop();
            if found.is_some() {
                return found;
            }
        }
    }
    done[at] = true;
    None
}

/// A file can be read before those that use it: no circle of files beside each other.
#[test]
fn files_beside_each_other_form_no_circle() {
    let mut seen = 0;
    let mut open = vec![root().join("src"), root().join("grammar-lang/src")];
    while let Some(folder) = open.pop() {
        let mut files: Vec<_> =
            std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
        files.sort();
        open.extend(files.iter().filter(|path| path.is_dir() && !path.ends_with("tests")).cloned());
        let is_file = |path: &std::path::PathBuf| {
            let name = path.file_name().unwrap().to_string_lossy();
            name.ends_with(".rs") && !["mod.rs", "lib.rs", "main.rs", "tests.rs"].contains(&&*name)
        };
        files.retain(is_file);
        let names: Vec<String> =
            files.iter().map(|path| path.file_stem().unwrap().to_string_lossy().into_owned()).collect();
        let edges: Vec<Vec<usize>> = files.iter().map(|file| siblings_named(file, &names)).collect();
        seen += edges.iter().map(Vec::len).sum::<usize>();
        let mut done = vec![false; files.len()];
        for first in 0..files.len() {
            let found = circle(&edges, &mut vec![first], &mut done);
            let found = found.map(|all| all.into_iter().map(|i| &names[i]).collect::<Vec<_>>());
            assert!(found.is_none(), "in {} these name each other: {found:?}", folder.display());
        }
    }
    assert!(seen > 200, "the test sees no uses");
}

/// The checker of the language goes through phases, which are folders or files of `types`.
#[test]
fn phases_of_the_checker_know_only_those_before_them() {
    const PHASES: [&str; 4] = ["environment", "expressions", "declarations", "assembly"];
    let types = root().join("grammar-lang/src/types");
    let mut files = Vec::new();
    rust_files(&types, &mut files);
    let mut seen = 0;
    for file in files {
        let name = file.strip_prefix(&types).unwrap().to_string_lossy().into_owned();
        let own = PHASES.iter().position(|phase| name.starts_with(phase));
        let Some(own) = own else { continue };
        let text = std::fs::read_to_string(&file).unwrap();
        for later in &PHASES[own + 1..] {
            for path in [format!("types::{later}"), format!("super::{later}")] {
                assert!(!text.contains(&path), "{name} names {path}");
            }
        }
        seen += 1;
    }
    assert!(seen > 25, "the test sees no files");
}

/// What simulates, and what speaks with the board, could be crates of their own: they know what an assembly is, or a
/// schedule, and nothing of grammars.
#[test]
fn solvers_and_the_link_to_the_board_know_no_grammar() {
    let mut files = Vec::new();
    rust_files(&root().join("src/simulate"), &mut files);
    let solvers = files.len();
    let link = ["link", "frame", "message", "session", "error"].map(|name| format!("src/hardware/{name}.rs"));
    files.extend(link.iter().map(|path| root().join(path)).filter(|path| path.exists()));
    assert!(solvers > 30 && files.len() > solvers + 3, "the test sees no files");
    for file in files {
        let name = file.strip_prefix(root()).unwrap().to_string_lossy().into_owned();
        let text = std::fs::read_to_string(&file).unwrap();
        assert!(!text.contains("grammar_lang"), "{name} names the language");
        let own = ["crate::simulate", "crate::hardware", "crate::design::assembly", "crate::markup"];
        for (i, _) in text.match_indices("crate::") {
            let path = &text[i..];
            let is_macro = path.starts_with("crate::tests!");
            assert!(
                is_macro || own.iter().any(|own| path.starts_with(own)),
                "{name} names {}",
                path.lines().next().unwrap()
            );
        }
    }
}

/// The checker warns of what the solver refuses: the same turn in a step.
#[test]
fn the_checker_and_the_solver_have_one_limit_of_turns() {
    assert!((grammar_lang::lint::MOST_TURN - sgc::simulate::MOST_TURN).abs() < 1e-12);
}

#[test]
fn only_their_walls_name_pest_ariadne_and_rapier() {
    let mut files = Vec::new();
    for source in ["src", "grammar-lang/src"] {
        rust_files(&root().join(source), &mut files);
    }
    for (library, wall) in
        [("pest::", "syntax/"), ("ariadne::", "render/"), ("rapier3d::", "simulate/rapier/")]
    {
        for file in &files {
            let name = file.to_string_lossy();
            let text = std::fs::read_to_string(file).unwrap();
            let names = text.lines().any(|l| l.trim_start().starts_with(&format!("use {library}")));
            assert!(!names || name.contains(wall), "{name} names {library}");
        }
    }
}

#[test]
fn every_path_of_the_map_exists() {
    for map in ["ARCHITECTURE.md", "CONTRIBUTING.md"] {
        let text = read(map);
        let mut checked = 0;
        for path in text.split('`').skip(1).step_by(2) {
            let looks_like_path = path.contains('/') && !path.contains([' ', '<', '*'])
                || path.ends_with(".md")
                || path.ends_with(".toml");
            if looks_like_path && !path.contains("://") && !path.contains("NAME") {
                assert!(root().join(path).exists(), "{map} names {path}");
                checked += 1;
            }
        }
        assert!(checked > 20, "only {checked} paths in {map}");
    }
}
