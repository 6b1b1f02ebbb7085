//! The map is true: paths exist, and layers know only those before them.

use crate::support::{read, root};

/// The layers of the engine, first to last. Each may use itself and those before it.
const ENGINE: &[&str] = &[
    "reading",
    "markup",
    "world",
    "document",
    "design",
    "simulate",
    "derive",
    "audit",
    "drive",
    "score",
    "search",
    "hardware",
    "results",
    "calibrate",
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
