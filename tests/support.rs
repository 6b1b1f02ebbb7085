//! Helpers that several tests use.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use grammar_lang::ir::RuleSet;
use grammar_lang::source::SourceMap;
use sgc::loader::{Files, Frozen, LIBRARY};

/// The folder of the project.
pub(crate) fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// Runs the program in a folder.
pub(crate) fn sgc(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_sgc"))
        .args(arguments)
        .current_dir(folder)
        .env("NO_COLOR", "1")
        .output()
        .unwrap()
}

/// All that a program has said.
pub(crate) fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

/// The text of a file of the project.
pub(crate) fn read(path: &str) -> String {
    std::fs::read_to_string(root().join(path)).unwrap_or_else(|e| panic!("{path}: {e}"))
}

/// Compiles a grammar of the project; it must have no finding.
pub(crate) fn grammar(path: &str) -> RuleSet {
    let mut sources = SourceMap::default();
    let entry = sources.add(root().join(path).to_string_lossy(), read(path));
    let compiled = grammar_lang::compile(&Files, &mut sources, entry, &[], None);
    assert!(compiled.diagnostics.is_empty(), "{:#?}", compiled.diagnostics);
    compiled.ruleset.expect("a grammar")
}

/// The grammars of the project.
pub(crate) const GRAMMARS: &[&str] = &[
    "grammars/codesign.sgr",
    "grammars/disk.sgr",
    "grammars/millipede.sgr",
    "grammars/morphology.sgr",
    "grammars/pneumatic.sgr",
    "grammars/scaled.sgr",
    "grammars/shepherd.sgr",
    "grammars/steering.sgr",
    "grammars/study1.sgr",
    "grammars/study2.sgr",
    "grammars/tendon.sgr",
    "grammars/untethered.sgr",
    "grammars/worm.sgr",
];

/// The texts that the grammars are made of, to be edited.
pub(crate) fn texts() -> BTreeMap<String, String> {
    let library = LIBRARY.iter().map(|(name, text)| ((*name).to_owned(), (*text).to_owned()));
    library.chain(GRAMMARS.iter().map(|path| ((*path).to_owned(), read(path)))).collect()
}

/// Compiles one of a set of texts.
pub(crate) fn compile_texts(texts: &BTreeMap<String, String>, entry: &str) -> Result<RuleSet, String> {
    let loader = Frozen { texts: texts.clone() };
    let mut sources = SourceMap::default();
    let file = sources.add(entry, texts[entry].clone());
    let compiled = grammar_lang::compile(&loader, &mut sources, file, &[], None);
    compiled.ruleset.ok_or_else(|| format!("{:?}", compiled.diagnostics))
}

/// Whether tests are to take their time: `cargo nextest run --profile long` tells them its name.
pub(crate) fn is_long() -> bool {
    std::env::var("NEXTEST_PROFILE").is_ok_and(|profile| profile == "long")
}
