//! `sgc derive`: makes a design without simulating it.

use std::path::PathBuf;

use clap::Args;
use grammar_lang::diagnostics::render::{Format, render};
use grammar_lang::diagnostics::{Diagnostic, did_you_mean};
use grammar_lang::ir::{ExampleClause, RuleSet};
use grammar_lang::source::SourceMap;

use super::countdown::Countdown;
use super::output::{self, Fault};
use super::{exit, load};
use crate::derive::{self, Derivation};
use crate::results::describe;

/// Apply rules at random and print the design, without simulating it
#[derive(Args)]
pub(super) struct Derive {
    /// The grammar
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Set a parameter of the grammar
    #[arg(short, long = "param", value_name = "NAME=VALUE", value_parser = super::assignment)]
    params: Vec<(String, String)>,
    /// The variant to use, if the file declares several
    #[arg(long, value_name = "NAME")]
    variant: Option<String>,
    /// Derive an example of the grammar instead; with --steps, continue from it with random moves
    #[arg(long, value_name = "NAME")]
    example: Option<String>,
    /// The seed of the random numbers
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// How many moves to make, at most 1,000,000 [default: 20, or 0 with --example]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(..=1_000_000))]
    steps: Option<u32>,
}

/// Refuses the name of an example that the grammar does not have.
pub(super) fn known_example(rules: &RuleSet, name: &str) -> Result<(), Fault> {
    if rules.examples.contains_key(name) {
        return Ok(());
    }
    let names: Vec<&str> = rules.examples.keys().map(String::as_str).collect();
    let help = match (did_you_mean(name, names.iter().copied()), names.is_empty()) {
        (Some(help), _) => help,
        (None, true) => "it has none".to_owned(),
        (None, false) => format!("it has: {}", names.join(", ")),
    };
    Err(Fault::input(format!("this grammar has no example `{name}`; {help}")))
}

/// The first design: of an example, if one is named.
pub(super) fn start(rules: &RuleSet, sources: &SourceMap, from: Option<&str>) -> Result<Derivation, Fault> {
    from.map_or(Ok(()), |name| known_example(rules, name))?;
    let told = |found: &[Diagnostic]| {
        let text = render(found, sources, Format::Full, output::colour_err());
        output::note(text.trim_end());
        Fault { code: exit::INPUT, message: String::new() }
    };
    let first = Derivation::start(rules, from).map_err(|failure| told(&[*failure]))?;
    let lost = derive::overwritten(rules, &first.design);
    if lost.is_empty() { Ok(first) } else { Err(told(&lost)) }
}

impl Derive {
    /// Prints what an example makes, though it is not what the example expects: there one sees why.
    fn show_unexpected(&self, rules: &RuleSet, sources: &SourceMap) {
        let mut bare = rules.clone();
        let Some(example) = self.example.as_ref().and_then(|name| bare.examples.get_mut(name)) else {
            return;
        };
        example.clauses.retain(|clause| matches!(clause, ExampleClause::Step { .. }));
        if let Ok(first) = Derivation::start(&bare, self.example.as_deref()) {
            let (text, _) = describe::derived(&bare, sources, first, self.seed, 0, &mut |_| {});
            // The error is what counts.
            let _ = output::data(&text);
        }
    }

    pub(super) fn run(self) -> Result<u8, Fault> {
        let (rules, sources) = load::grammar(&self.file, &self.params, self.variant.as_deref())?;
        let first = start(&rules, &sources, self.example.as_deref()).inspect_err(|_| {
            self.show_unexpected(&rules, &sources);
        })?;
        let steps = self.steps.unwrap_or(if self.example.is_some() { 0 } else { 20 }) as usize;
        let mut countdown = Countdown::begin();
        let mut made = |moves| countdown.tell("moves made", moves, steps);
        let (text, why_idle) = describe::derived(&rules, &sources, first, self.seed, steps, &mut made);
        output::data(&text)?;
        if !why_idle.is_empty() {
            output::note(why_idle.trim_end());
        }
        Ok(exit::DONE)
    }
}
