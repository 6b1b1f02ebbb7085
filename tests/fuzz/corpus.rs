//! All texts in the language that the project has.

use std::path::{Path, PathBuf};

/// The texts, in an order that does not depend on the machine.
pub fn texts() -> Vec<String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folders = [
        "std-rules",
        "grammars",
        "grammars/experiments",
        "tests/cases",
        "tests/fuzz/found",
        "docs",
        "grammar-lang/src/diagnostics/catalogue",
    ];
    let mut paths: Vec<PathBuf> = Vec::new();
    for folder in folders {
        // There may be nothing that was found.
        let entries = std::fs::read_dir(root.join(folder)).into_iter().flatten();
        let mut here: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
        here.sort();
        paths.extend(here);
    }
    let mut texts = Vec::new();
    for path in paths {
        let Ok(text) = std::fs::read_to_string(&path) else { continue };
        match path.extension().and_then(|e| e.to_str()) {
            Some("sgr") => texts.push(text),
            Some("md") => texts.extend(blocks(&text)),
            _ => {}
        }
    }
    texts
}

/// The blocks of a page that are in the language.
fn blocks(page: &str) -> Vec<String> {
    let blocks = page.split("```sgr").skip(1).filter_map(|b| b.split_once('\n'));
    blocks.filter_map(|(_, b)| b.split("```").next()).map(str::to_owned).collect()
}
