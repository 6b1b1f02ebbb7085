//! What must hold of every text whatever.

use std::collections::BTreeMap;

use grammar_lang::diagnostics::render::{Format, render};
use grammar_lang::diagnostics::{Diagnostic, apply};
use grammar_lang::format::{Unformatted, format};
use grammar_lang::ir::RuleSet;
use grammar_lang::source::SourceMap;
use grammar_lang::{Compiled, compile};
use sgc::derive::random::Stream;
use sgc::derive::{Derivation, check_start, run_example};
use sgc::loader::Frozen;

/// What the text is called.
const NAME: &str = "grammars/fuzz.sgr";

/// The texts that a text may import.
pub fn loader() -> Frozen {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/grammars");
    let mut texts = BTreeMap::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            continue;
        }
        let name = format!("grammars/{}", path.file_name().unwrap().to_string_lossy());
        texts.insert(name, std::fs::read_to_string(&path).unwrap());
    }
    Frozen { texts }
}

fn compiled(loader: &Frozen, text: &str, wanted: Option<&str>) -> (Compiled, SourceMap) {
    let mut sources = SourceMap::default();
    let file = sources.add(NAME, text);
    (compile(loader, &mut sources, file, &[], wanted), sources)
}

/// How many texts got how far.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reached {
    /// Grammars that compiled without errors.
    pub sound: u64,
    /// Those of which a rule was applied.
    pub derived: u64,
}

impl std::ops::AddAssign for Reached {
    fn add_assign(&mut self, other: Self) {
        self.sound += other.sound;
        self.derived += other.derived;
    }
}

/// Checks a text in every way. How far it gets, or what does not hold, in a sentence; panics are for the
/// caller to catch.
pub fn reached(loader: &Frozen, text: &str) -> Result<Reached, String> {
    let (first, sources) = compiled(loader, text, None);
    let (second, _) = compiled(loader, text, None);
    if first.diagnostics != second.diagnostics || json(&first.ruleset) != json(&second.ruleset) {
        return Err("checking twice gives two results".to_owned());
    }
    findings(&first.diagnostics, &sources)?;
    layout(loader, text, &first)?;
    fixes(loader, text, &first)?;
    let mut sets = vec![first];
    for offer in sets[0].offers.clone().iter().skip(1).take(2) {
        let (other, sources) = compiled(loader, text, Some(offer));
        findings(&other.diagnostics, &sources)?;
        sets.push(other);
    }
    let mut reached = Reached::default();
    for set in sets {
        if let Some(rules) = set.ruleset.filter(|_| set.is_grammar) {
            reached.sound = 1;
            reached.derived |= u64::from(derive(&rules)?);
        }
    }
    Ok(reached)
}

fn json(rules: &Option<RuleSet>) -> String {
    rules.as_ref().map_or(String::new(), |r| serde_json::to_string(r).unwrap())
}

fn json_without_spans(rules: &Option<RuleSet>) -> String {
    rules.as_ref().map_or(String::new(), grammar_lang::testing::rule_set)
}

/// Findings stand in the text, can be shown in every way, and their fixes can be applied.
fn findings(found: &[Diagnostic], sources: &SourceMap) -> Result<(), String> {
    for label in found.iter().flat_map(|d| &d.labels) {
        let text = sources.get(label.span.file).map_or("", |s| s.text.as_str());
        if text.get(label.span.range()).is_none() {
            return Err(format!("a finding is outside the text: {:?} of {}", label.span, text.len()));
        }
    }
    for fix in found.iter().filter_map(|d| d.fix.as_ref()) {
        let text = sources.get(fix.edits[0].span.file).map_or("", |s| s.text.as_str());
        if apply(text, &fix.edits).is_none() {
            return Err(format!("a fix cannot be applied: {fix:?}"));
        }
    }
    for format in [Format::Full, Format::Concise, Format::Json, Format::Sarif] {
        let some = &found[..found.len().min(20)];
        if render(some, sources, format, false).is_empty() != (found.is_empty() && format != Format::Sarif) {
            return Err("findings are shown as nothing".to_owned());
        }
    }
    Ok(())
}

/// The layout of a text keeps what it says, and a laid out text is not changed any more.
fn layout(loader: &Frozen, text: &str, before: &Compiled) -> Result<(), String> {
    let lay_out = |text: &str| {
        let mut sources = SourceMap::default();
        let file = sources.add(NAME, text);
        format(&sources, file)
    };
    let once = match lay_out(text) {
        Ok(once) => once,
        Err(Unformatted::Errors(_)) => return Ok(()),
        Err(Unformatted::Altered) => return Err("its layout would alter it".to_owned()),
    };
    if lay_out(&once).as_ref() != Ok(&once) {
        return Err("its layout is laid out differently".to_owned());
    }
    let (after, _) = compiled(loader, &once, None);
    let codes = |c: &Compiled| {
        let mut codes: Vec<&str> = c.diagnostics.iter().map(|d| d.code.id).collect();
        codes.sort_unstable();
        codes
    };
    if codes(before) != codes(&after) {
        return Err(format!("its layout has other findings: {:?}, {:?}", codes(before), codes(&after)));
    }
    if json_without_spans(&before.ruleset) != json_without_spans(&after.ruleset) {
        return Err("its layout says something else".to_owned());
    }
    Ok(())
}

/// A text that was mended can be checked. That fixes lead to no more errors is what `sgc check --fix`
/// sees to: one alone may bring to light what an error has hidden.
fn fixes(loader: &Frozen, text: &str, before: &Compiled) -> Result<(), String> {
    for fix in before.diagnostics.iter().filter_map(|d| d.fix.as_ref()).take(3) {
        if fix.edits.iter().any(|e| e.span.file.0 != 0) {
            continue;
        }
        let mended = apply(text, &fix.edits).unwrap_or_default();
        let (after, sources) = compiled(loader, &mended, None);
        findings(&after.diagnostics, &sources)?;
    }
    Ok(())
}

/// A rule set is the same after it was written and read, and rules can be applied without harm.
/// Whether one was.
fn derive(rules: &RuleSet) -> Result<bool, String> {
    let text = serde_json::to_string(rules).unwrap();
    let read: RuleSet =
        serde_json::from_str(&text).map_err(|e| format!("its rule set cannot be read: {e}"))?;
    if serde_json::to_string(&read).unwrap() != text {
        return Err("its rule set is another one after writing and reading".to_owned());
    }
    let _ = grammar_lang::ir::resolved(rules);
    if check_start(rules).is_some() {
        return Ok(false);
    }
    for (name, example) in rules.examples.iter().take(3) {
        let _ = run_example(rules, name, example);
    }
    let mut random = Stream::named(1, "fuzz");
    let mut derivation = Derivation::begin(rules);
    for _ in 0..3 {
        derivation = derivation.advance(rules, &mut random, 1.0).result.unwrap_or(derivation);
    }
    match Derivation::replay(rules, &derivation.steps) {
        Ok(again) if (&again.design, &again.steps) == (&derivation.design, &derivation.steps) => {
            Ok(!derivation.steps.is_empty())
        }
        Ok(_) => Err("its derivation is another one when repeated".to_owned()),
        Err(bad) => Err(format!("its derivation cannot be repeated: {bad}")),
    }
}
