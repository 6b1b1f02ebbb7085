//! The documentation: every block of the language in it is free of findings.

use crate::support::{read, root};

/// The `sgr` blocks of a page with the line that each begins at.
fn blocks(text: &str) -> Vec<(usize, String)> {
    let mut out = Vec::new();
    let mut open: Option<(usize, String)> = None;
    for (i, line) in text.lines().enumerate() {
        match (&mut open, line) {
            (None, "```sgr") => open = Some((i + 2, String::new())),
            (Some(_), "```") => out.extend(open.take()),
            (Some((_, block)), line) => *block += &format!("{line}\n"),
            _ => {}
        }
    }
    out
}

/// The usual values as `docs/usual.md` shows them.
fn usual_values() -> String {
    let mut table = "| of | field | usual | between |\n|---|---|---|---|\n".to_owned();
    for usual in grammar_lang::types::USUAL {
        let unit = if usual.unit.is_empty() { String::new() } else { format!(" {}", usual.unit) };
        let number = |x: f64| {
            if (1e-3..1e5).contains(&x.abs()) || x == 0.0 {
                format!("{}", (x * 1e4).round() / 1e4)
            } else {
                format!("{x:e}")
            }
        };
        let (of, field, ends) = (usual.of, usual.field, usual.ends);
        table += &format!(
            "| {of} | `{field}` | {} .. {}{unit} | {ends} |\n",
            number(usual.least),
            number(usual.most)
        );
    }
    table
}

#[test]
fn the_table_of_usual_values_is_that_of_the_checker() {
    let table = usual_values();
    assert!(read("docs/usual.md").contains(&table), "docs/usual.md must hold\n{table}");
}

/// Each reserved word of the page is one, and every reserved word is on the page.
#[test]
fn the_reserved_words_are_those_of_the_parser() {
    let page = read("docs/language.md");
    let (_, section) = page.split_once("## Reserved words").unwrap();
    let list = section.split("\n\n").nth(2).unwrap();
    let listed: Vec<&str> = list.split('`').filter(|word| !word.trim().is_empty()).collect();
    assert!(listed.len() > 60, "{listed:?}");
    let is_name = |word: &str| {
        let mut sources = grammar_lang::source::SourceMap::default();
        let entry = sources.add("own.sgr", format!("let {word} = 1\n"));
        let compiled = grammar_lang::compile(&sgc::loader::Files, &mut sources, entry, &[], None);
        compiled.diagnostics.iter().all(|found| found.code.id != "E0103")
    };
    for word in &listed {
        assert!(!is_name(word), "`{word}` is not reserved");
    }
    // Every word that the parser reads by itself, and that no declaration can be called by.
    let parser = read("grammar-lang/src/syntax/grammar.pest");
    let words =
        parser.lines().filter_map(|line| line.split_once("= @{ \"")?.1.split_once("\" ~ !XID_CONTINUE }"));
    let mut seen = 0;
    for (word, _) in words {
        seen += 1;
        assert!(is_name(word) || listed.contains(&word), "`{word}` is reserved, and not on the page");
    }
    assert!(seen > 40, "{seen} words");
}

/// The names that no declaration can have, because they are built in, are all on the page, and no others.
#[test]
fn the_built_in_names_are_those_of_the_language() {
    use grammar_lang::ir::{Function, Word};
    let page = read("docs/language.md");
    let (_, section) = page.split_once("word or function either (E0212):").unwrap();
    let list = section.trim_start().split("\n\n").next().unwrap();
    let listed: Vec<&str> = list.split('`').filter(|word| !word.trim().is_empty()).collect();
    let is_built_in = |word: &str| {
        let mut sources = grammar_lang::source::SourceMap::default();
        let entry = sources.add("own.sgr", format!("let {word} = 1\n"));
        let compiled = grammar_lang::compile(&sgc::loader::Files, &mut sources, entry, &[], None);
        // What is reserved stands in the other list.
        compiled.diagnostics.iter().any(|found| ["E0212", "E0103"].contains(&found.code.id))
    };
    for word in &listed {
        assert!(is_built_in(word), "`{word}` is not built in");
    }
    for word in Word::ALL.iter().map(|w| w.text()).chain(Function::ALL.iter().map(|f| f.text())) {
        assert!(listed.contains(&word), "`{word}` is built in, and not on the page");
    }
}

#[test]
fn every_block_of_the_documentation_is_free_of_findings() {
    let mut pages: Vec<String> = std::fs::read_dir(root().join("docs"))
        .unwrap()
        .map(|e| format!("docs/{}", e.unwrap().file_name().to_string_lossy()))
        .collect();
    pages.push("README.md".into());
    let mut seen = 0;
    for page in pages.iter().filter(|p| p.ends_with(".md")) {
        for (line, block) in blocks(&read(page)) {
            // A part of a grammar stands among the usual imports and parameters.
            let whole = block.contains("grammar ");
            let imports = "use std.actuators { bender }\nparam max_actuators : Count = 8\n";
            let needed = block.contains("bender(") || block.contains("max_actuators");
            let text = if whole || !needed { block } else { format!("{imports}{block}") };
            let mut sources = grammar_lang::source::SourceMap::default();
            let entry = sources.add(root().join("grammars/block.sgr").to_string_lossy(), text);
            let compiled = grammar_lang::compile(&sgc::loader::Files, &mut sources, entry, &[], None);
            assert!(compiled.diagnostics.is_empty(), "{page}:{line}: {:?}", compiled.diagnostics);
            seen += 1;
        }
    }
    assert!(seen >= 7, "only {seen} blocks");
}

#[test]
fn every_word_function_and_unit_is_in_the_reference() {
    use grammar_lang::ir::{Function, Word};
    let reference = read("docs/language.md");
    let words = Word::ALL.iter().map(|w| w.text()).chain(Function::ALL.iter().map(|f| f.text()));
    for word in words.chain(grammar_lang::units::unit_names()).chain(grammar_lang::units::Dimension::names())
    {
        let found = reference
            .split(|c: char| !(c.is_alphanumeric() || c == '_' || c == '%'))
            .any(|token| token == word);
        assert!(found, "docs/language.md does not mention `{word}`");
    }
}

/// The site colours every word that opens a declaration.
#[test]
fn the_site_knows_the_words_of_the_language() {
    let script = read("docs/site/sgr.js");
    let words: Vec<&str> = script.split(|c: char| !c.is_alphanumeric()).collect();
    for kind in grammar_lang::syntax::declarations::KINDS {
        assert!(words.contains(&kind.word), "docs/site/sgr.js lacks `{}`", kind.word);
    }
}
