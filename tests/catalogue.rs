//! The catalogue: what each page says goes wrong does, and what it says is right is.
//!
//! An example is checked as `sgc check` checks a file, with the standard library. Four conventions
//! make it complete: a line `# file: legs.sgr` begins a further file beside the first one
//! (`main.sgr`), `# sgc check -p NAME=VALUE` sets a parameter, and `␀` stands for a zero byte,
//! which no text file can show.

use std::collections::BTreeMap;

use grammar_lang::diagnostics::{CODES, Code, Diagnostic, apply};
use grammar_lang::source::SourceMap;
use sgc::derive::run_example;
use sgc::loader::Frozen;
use sgc::trials::check_motions;

/// The files of an example by name.
fn files(block: &str) -> BTreeMap<String, String> {
    let mut files: BTreeMap<String, String> = BTreeMap::new();
    let mut name = "main.sgr";
    for line in block.lines() {
        match line.strip_prefix("# file: ") {
            Some(next) => name = next,
            None => {
                let text = files.entry(name.to_owned()).or_default();
                text.push_str(&line.replace('␀', "\0"));
                text.push('\n');
            }
        }
    }
    files
}

/// The parameters that the command line of an example sets.
fn parameters(block: &str) -> Vec<(String, String)> {
    let command = block.lines().find(|line| line.starts_with("# sgc check "));
    let mut words = command.into_iter().flat_map(str::split_whitespace);
    let mut found = Vec::new();
    while let Some(word) = words.next() {
        if word == "-p" {
            let (name, value) = words.next().and_then(|w| w.split_once('=')).expect("NAME=VALUE");
            found.push((name.to_owned(), value.to_owned()));
        }
    }
    found
}

/// All that a set of files raises, and their texts.
fn check(files: &BTreeMap<String, String>, overrides: &[(String, String)]) -> (Vec<Diagnostic>, SourceMap) {
    let (mut found, sources, offers) = check_one(files, overrides, None);
    // A file with several grammars and variants is checked for each of them.
    for offer in offers.iter().filter(|_| offers.len() > 1) {
        for finding in check_one(files, overrides, Some(offer)).0 {
            if !found.contains(&finding) {
                found.push(finding);
            }
        }
    }
    (found, sources)
}

fn check_one(
    files: &BTreeMap<String, String>,
    overrides: &[(String, String)],
    wanted: Option<&str>,
) -> (Vec<Diagnostic>, SourceMap, Vec<String>) {
    let mut sources = SourceMap::default();
    let entry = sources.add("main.sgr", files["main.sgr"].as_str());
    let loader = Frozen { texts: files.clone() };
    let compiled = grammar_lang::compile(&loader, &mut sources, entry, overrides, wanted);
    let mut found = compiled.told(check_motions(&compiled, entry, &sources));
    if compiled.offers.len() < 2 && !found.iter().any(Diagnostic::is_error) {
        found.extend(compiled.unneeded(entry));
    }
    // Examples are derived, too, as `sgc test` does.
    for (name, example) in compiled.ruleset.iter().flat_map(|r| &r.examples) {
        found.extend(compiled.ruleset.iter().filter_map(|r| run_example(r, name, example).err()).map(|e| *e));
    }
    // What `sgc test` reports as an error, `sgc check` warns of.
    let fails = found.iter().any(|told| told.code.id == "E0603");
    found.retain(|told| !fails || told.code.id != "W0747");
    (found, sources, compiled.offers)
}

fn example(code: &Code, name: &str) -> &'static str {
    code.example(name).unwrap_or_else(|| panic!("the page of {} has no block `{name}`", code.id))
}

#[test]
fn every_failing_example_raises_its_code_and_nothing_else() {
    for code in CODES {
        let block = example(code, "fails");
        let (found, _) = check(&files(block), &parameters(block));
        let mut raised: Vec<&str> = found.iter().map(|d| d.code.id).collect();
        // Each variant of a circle of variants has the same to say.
        raised.dedup();
        let wanted = if code.id == "W0747" { "E0603" } else { code.id };
        assert_eq!(raised, [wanted], "{found:#?}");
    }
}

#[test]
fn every_mended_example_raises_nothing() {
    for code in CODES {
        let block = example(code, "mended");
        let (found, _) = check(&files(block), &parameters(block));
        assert!(found.is_empty(), "{}: {found:#?}", code.id);
    }
}

#[test]
fn a_fix_of_a_failing_example_mends_it() {
    let mut mended = 0;
    for code in CODES {
        let block = example(code, "fails");
        let mut files = files(block);
        let (found, sources) = check(&files, &parameters(block));
        let Some(fix) = found.first().and_then(|d| d.fix.clone()) else { continue };
        let file = fix.edits.first().expect("an edit").span.file;
        let source = sources.get(file).expect("a file");
        let text = apply(&source.text, &fix.edits).expect("edits that fit");
        files.insert(source.name.clone(), text);
        let (left, _) = check(&files, &parameters(block));
        assert!(left.is_empty(), "{} {}: {left:#?}", code.id, fix.message);
        mended += 1;
    }
    assert!(mended >= 8, "only {mended} pages show a finding that can be mended at once");
}
