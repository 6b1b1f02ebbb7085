//! Helpers that several tests use.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use grammar_lang::ir::RuleSet;
use grammar_lang::source::SourceMap;
use sgc::loader::{Files, Frozen, LIBRARY};
use sgc::results::saved::SavedDesign;

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

/// The text of `codesign` with the objective of the thesis, which runs over no worlds, and its search: what most tests of the engine
/// start from.
pub(crate) fn codesign() -> String {
    let plain = nominal().replace("use std.scenarios  { workshop }\n", "");
    assert!(!plain.contains("workshop "), "{plain}");
    plain
}

/// The same, with the worlds that its variants name.
fn nominal() -> String {
    let text = read("grammars/codesign.sgr").replace("for 20 s in workshop", "for 20 s");
    text.replace("maximize min over w in workshop of travel - fall in cm", "maximize travel - fall in cm")
        .replace("recommended", "nested_annealing")
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
    "grammars/rover.sgr",
    "grammars/salamander.sgr",
    "grammars/scaled.sgr",
    "grammars/shepherd.sgr",
    "grammars/steering.sgr",
    "grammars/study1.sgr",
    "grammars/study2.sgr",
    "grammars/tendon.sgr",
    "grammars/tree.sgr",
    "grammars/turtle.sgr",
    "grammars/untethered.sgr",
    "grammars/walker.sgr",
    "grammars/worm.sgr",
];

/// The text of an edited design with a checksum that fits, as far as it is a design at all.
pub(crate) fn forged(text: &str) -> String {
    let mut design: serde_json::Value = serde_json::from_str(text).unwrap();
    design.as_object_mut().unwrap().remove("sum");
    serde_json::from_value::<SavedDesign>(design).map_or_else(|_| text.to_owned(), |design| design.text())
}

/// The texts that the grammars are made of, to be edited. `codesign` runs over no worlds, and is what its variants change.
pub(crate) fn texts() -> BTreeMap<String, String> {
    let library = LIBRARY.iter().map(|(name, text)| ((*name).to_owned(), (*text).to_owned()));
    let grammars = GRAMMARS.iter().map(|path| ((*path).to_owned(), read(path)));
    let plain = ("grammars/codesign.sgr".to_owned(), nominal());
    library.chain(grammars).chain([plain]).collect()
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
