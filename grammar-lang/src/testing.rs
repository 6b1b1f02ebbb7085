//! For tests of grammars: what the checker says of a text, as text that stays
//! the same from machine to machine, made for snapshots.
//!
//! Nothing here panics on a grammar that is wrong: what is wrong is what the
//! text says, so that a snapshot shows it. With the crate `insta`:
//!
//! ```
//! use grammar_lang::testing;
//! # struct Nothing;
//! # impl grammar_lang::source::Loader for Nothing {
//! #     fn load(&self, _: &str, _: &str) -> Result<grammar_lang::source::Source, grammar_lang::source::NoModule> {
//! #         Err(grammar_lang::source::NoModule::NotGiven)
//! #     }
//! # }
//! # let loader = Nothing;
//! let text = testing::findings(&loader, "legs.sgr", "let knee = 90\n");
//! assert_eq!(text, testing::CLEAN); // or: insta::assert_snapshot!(text)
//! ```

use crate::diagnostics::Diagnostic;
use crate::diagnostics::render::{Format, render};
use crate::ir::{RuleSet, without_spans};
use crate::source::{Loader, SourceMap};
use crate::{Compiled, compile};

/// What [`findings`] says of a text in which nothing is found.
pub const CLEAN: &str = "no findings\n";

/// What [`rules`] says of a text without a `grammar` line.
pub const MODULE: &str = "a module for grammars to use: it has no rule set of its own\n";

fn read(loader: &dyn Loader, name: &str, text: &str) -> (Compiled, SourceMap) {
    let mut sources = SourceMap::default();
    let entry = sources.add(name, text);
    let compiled = compile(loader, &mut sources, entry, &[], None);
    (compiled, sources)
}

/// Everything that checking a text finds, as `sgc check` shows it.
///
/// `name` is what the findings call the text; `loader` knows what it imports.
#[must_use]
pub fn findings(loader: &dyn Loader, name: &str, text: &str) -> String {
    let (compiled, sources) = read(loader, name, text);
    shown(&compiled.diagnostics, &sources)
}

/// The typed rule set of a grammar, as JSON without places in the text, or
/// the findings if there are errors.
#[must_use]
pub fn rules(loader: &dyn Loader, name: &str, text: &str) -> String {
    let (compiled, sources) = read(loader, name, text);
    match &compiled.ruleset {
        Some(rules) if compiled.is_grammar => rule_set(rules),
        _ if compiled.has_errors() => shown(&compiled.diagnostics, &sources),
        _ => MODULE.to_owned(),
    }
}

/// Findings in the order of the text, drawn without colour; [`CLEAN`] if there are none.
#[must_use]
pub fn shown(findings: &[Diagnostic], sources: &SourceMap) -> String {
    if findings.is_empty() {
        return CLEAN.to_owned();
    }
    let mut findings = findings.to_vec();
    findings.sort_by_key(|d| (d.span().file, d.span().start, d.code.id));
    render(&findings, sources, Format::Full, false)
}

/// A rule set as JSON, in SI units and without places in the text: a comment
/// or a blank line more changes nothing.
#[must_use]
pub fn rule_set(rules: &RuleSet) -> String {
    let text = without_spans(rules).and_then(|value| serde_json::to_string_pretty(&value));
    text.map_or_else(|error| format!("this rule set cannot be written: {error}\n"), |text| text + "\n")
}

#[cfg(test)]
mod tests {
    use super::{CLEAN, MODULE, findings, rules};
    use crate::source::{Loader, NoModule, Source};

    /// One module, `legs`.
    struct Legs;

    impl Loader for Legs {
        fn load(&self, module: &str, _: &str) -> Result<Source, NoModule> {
            let text = "let knee = 90 deg\n".to_owned();
            if module == "./legs.sgr" {
                Ok(Source { name: "legs.sgr".to_owned(), text })
            } else {
                Err(NoModule::NotGiven)
            }
        }
    }

    #[test]
    fn a_clean_text_says_so() {
        assert_eq!(findings(&Legs, "x.sgr", "use \"./legs.sgr\" { knee }\nlet half = knee / 2\n"), CLEAN);
        assert_eq!(rules(&Legs, "x.sgr", "let half = 1 / 2\n"), MODULE);
    }

    #[test]
    fn findings_are_text_in_the_order_of_the_text() {
        let text = findings(&Legs, "x.sgr", "let a = nothing\nlet b = 3 gg\nuse \"./arms.sgr\" { elbow }\n");
        let places: Vec<_> = ["x.sgr:1:9", "x.sgr:2:11", "x.sgr:3:5"].map(|p| text.find(p)).into();
        assert!(places.iter().all(Option::is_some) && places.is_sorted(), "{text}");
        assert_eq!(rules(&Legs, "x.sgr", "grammar g\nlet b = 3 gg\n").matches("E0303").count(), 1);
    }
}
