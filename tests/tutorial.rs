//! The tutorial: each step compiles with all that the steps before it have put into the files.
//!
//! A block that begins with "```sgr FILE" is put into that file: a declaration takes the place of
//! the one with its name, or is new. `... without use std.search` takes one out, and what
//! `... fails E0302` shows must raise that code and is not kept.

use std::collections::BTreeMap;
use std::process::Command;

use grammar_lang::source::SourceMap;
use sgc::derive::{check_start, run_example};
use sgc::loader::Frozen;

use crate::support::{read, root};

/// Declarations of which a file has one: they have no name.
const SINGLE: &[&str] = &["grammar", "begin", "symmetry", "simulate", "maximize"];

/// A declaration of a file: what it is known by, and its text with the comments above it.
type Piece = (String, String);

/// A block of the tutorial.
struct Block {
    line: usize,
    file: String,
    without: Option<String>,
    fails: Option<String>,
    text: String,
}

fn blocks(page: &str) -> Vec<Block> {
    let mut out = Vec::new();
    let mut open: Option<Block> = None;
    for (i, line) in page.lines().enumerate() {
        match (&mut open, line.strip_prefix("```sgr ")) {
            (None, Some(head)) => {
                let (head, fails) = cut(head, " fails ");
                let (file, without) = cut(head, " without ");
                open = Some(Block { line: i + 1, file: file.into(), without, fails, text: String::new() });
            }
            (Some(_), _) if line == "```" => out.extend(open.take()),
            (Some(block), _) => block.text += &format!("{line}\n"),
            _ => {}
        }
    }
    out
}

/// A text before and after a mark.
fn cut<'t>(text: &'t str, mark: &str) -> (&'t str, Option<String>) {
    text.split_once(mark).map_or((text, None), |(before, after)| (before, Some(after.to_owned())))
}

/// Splits a text into declarations: each begins at the margin, with the comments above it.
fn pieces(text: &str) -> Vec<Piece> {
    let mut out: Vec<Piece> = Vec::new();
    let mut comments = String::new();
    for line in text.lines() {
        let line = format!("{line}\n");
        if line.starts_with('#') {
            comments += &line;
        } else if line.starts_with(|c: char| c.is_alphabetic()) {
            out.push((known_by(&line), std::mem::take(&mut comments) + &line));
        } else if let Some((_, open)) = out.last_mut() {
            *open += &line;
        }
    }
    // People leave a line before what they put in next.
    if let Some((_, last)) = out.last_mut() {
        last.push('\n');
    }
    out
}

/// `rule add_leg`, `use std.search`, `maximize`.
fn known_by(line: &str) -> String {
    let mut words = line.split_whitespace();
    let first = words.next().unwrap_or("");
    // `search quick { ... }` declares a search, `search quick` asks for one.
    let asks = first == "search" && !line.contains('{');
    if asks || SINGLE.contains(&first) {
        return first.to_owned();
    }
    format!("{first} {}", words.next().unwrap_or(""))
}

fn put(file: &mut Vec<Piece>, block: &Block) {
    file.retain(|(name, _)| Some(name) != block.without.as_ref());
    for (name, text) in pieces(&block.text) {
        match file.iter_mut().find(|(known, _)| *known == name) {
            Some((_, old)) => *old = text,
            // Imports stand above the rest, as a variant asks for.
            None if name.starts_with("use ") => file.insert(0, (name, text)),
            None => file.push((name, text)),
        }
    }
}

/// The codes that checking a file raises, and deriving its examples, in order.
fn codes(files: &BTreeMap<String, Vec<Piece>>, file: &str) -> Vec<&'static str> {
    let text = |pieces: &Vec<Piece>| pieces.iter().map(|(_, text)| text.as_str()).collect::<String>();
    let loader = Frozen { texts: files.iter().map(|(name, pieces)| (name.clone(), text(pieces))).collect() };
    let mut sources = SourceMap::default();
    let entry = sources.add(file, loader.texts[file].clone());
    let compiled = grammar_lang::compile(&loader, &mut sources, entry, &[], None);
    let mut found = compiled.diagnostics;
    for rules in compiled.ruleset.iter() {
        found.extend(check_start(rules));
        found.extend(rules.examples.iter().filter_map(|(n, e)| run_example(rules, n, e).err()).map(|e| *e));
    }
    // That nothing grows or ends yet is no mistake of a file that is being written.
    let unfinished = ["W0718", "W0719", "W0720"];
    found.iter().map(|d| d.code.id).filter(|id| !unfinished.contains(id)).collect()
}

#[test]
fn every_step_of_the_tutorial_compiles() {
    let page = read("docs/tutorial.md");
    let mut files: BTreeMap<String, Vec<Piece>> = BTreeMap::new();
    let mut kept = 0;
    for block in blocks(&page) {
        let mut trial = files.clone();
        put(trial.entry(block.file.clone()).or_default(), &block);
        let wanted: Vec<&str> = block.fails.iter().map(String::as_str).collect();
        assert_eq!(codes(&trial, &block.file), wanted, "docs/tutorial.md:{}", block.line);
        if wanted.is_empty() {
            files = trial;
            kept += 1;
        }
    }
    assert!(kept >= 10, "only {kept} blocks");
    // A later step must not break what an earlier one wrote into another file.
    for file in files.keys() {
        assert!(codes(&files, file).is_empty(), "{file} at the end");
    }
}

/// A command that the page shows, and the lines that it shows as its answer.
struct Shown {
    line: usize,
    command: String,
    answer: Vec<String>,
}

/// What the page shows: `    $ sgc ...`, and below it the answer.
fn shown(page: &str) -> Vec<Shown> {
    let mut out: Vec<Shown> = Vec::new();
    let mut is_open = false;
    for (i, line) in page.lines().enumerate() {
        let inside = line.strip_prefix("    ");
        if let Some(command) = inside.and_then(|line| line.strip_prefix("$ sgc ")) {
            out.push(Shown { line: i + 1, command: command.to_owned(), answer: Vec::new() });
            is_open = true;
        } else if let (true, Some(answer), Some(last)) = (is_open, inside, out.last_mut()) {
            last.answer.push(answer.to_owned());
        } else {
            is_open = false;
        }
    }
    out
}

/// The commands that simulate nothing are made where the page shows them, with the files as they are by then.
#[test]
fn the_program_answers_what_the_tutorial_shows() {
    let page = read("docs/tutorial.md");
    let (mut blocks, mut made) = (blocks(&page).into_iter().peekable(), 0);
    let mut files: BTreeMap<String, Vec<Piece>> = BTreeMap::new();
    for Shown { line, command, answer } in shown(&page) {
        let mut now = files.clone();
        while let Some(block) = blocks.next_if(|block| block.line < line) {
            now = files.clone();
            put(now.entry(block.file.clone()).or_default(), &block);
            if block.fails.is_none() {
                files.clone_from(&now);
            }
        }
        let text_of = |pieces: &Vec<Piece>| pieces.iter().map(|(_, text)| text.as_str()).collect::<String>();
        if command.starts_with("run walker.sgr") {
            // What a seed finds depends on the order of the rules, so the whole file is there to compare with.
            let heading = page
                .lines()
                .take(line)
                .filter_map(|line| line.strip_prefix("## "))
                .filter(|line| line.starts_with(|c: char| c.is_ascii_digit()))
                .last();
            let step = heading.and_then(|heading| heading.split_once('.')).unwrap().0;
            let file = format!("docs/walker/step-{step}.sgr");
            let whole = text_of(&now["walker.sgr"]).trim_end().to_owned() + "\n";
            if std::env::var("INSTA_UPDATE").is_ok_and(|how| how == "always") {
                std::fs::write(root().join(&file), &whole).unwrap();
            }
            assert_eq!(read(&file), whole, "{file}: INSTA_UPDATE=always writes it");
        }
        if !["check", "derive", "test"].iter().any(|known| command.starts_with(known)) {
            continue;
        }
        let folder = tempfile::tempdir().unwrap();
        for (name, pieces) in &now {
            std::fs::write(folder.path().join(name), text_of(pieces)).unwrap();
        }
        // As on a terminal, both streams in one.
        let both = format!("{} {command} 2>&1", env!("CARGO_BIN_EXE_sgc"));
        let output = Command::new("sh").args(["-c", &both]).current_dir(&folder).output().unwrap();
        let found = String::from_utf8(output.stdout).unwrap();
        let lines: Vec<&str> = found.lines().map(str::trim_end).collect();
        assert_eq!(lines, answer, "docs/tutorial.md:{line}: sgc {command}\n{found}");
        made += 1;
    }
    assert!(made >= 6, "only {made} commands");
}
