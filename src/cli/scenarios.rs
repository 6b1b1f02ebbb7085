//! `--in`: a saved design in the worlds of a set of scenarios, or in one of them.

use std::path::Path;

use clap::Args;
use grammar_lang::diagnostics::did_you_mean;
use grammar_lang::ir::{RuleSet, Scenarios};

use super::output::{self, Fault};
use super::{exit, load};
use crate::results::DesignError;
use crate::results::elsewhere::{self, Judged};
use crate::results::replay::{How, Precision};
use crate::results::saved::SavedDesign;
use crate::results::{describe, summary};
use crate::scenarios::{self, Scenario};
use crate::simulate::Stop;

/// One world of a set.
#[derive(Args)]
pub(super) struct OneWorld {
    /// The set of scenarios that `--world` belongs to: NAME in the design's grammar, or FILE:NAME in another file
    #[arg(long = "in", value_name = "SCENARIOS", requires = "world")]
    scenarios: Option<String>,
    /// The world to simulate, by the name that `sgc eval DESIGN --in SCENARIOS` prints, such as `drawn 3`
    #[arg(long, value_name = "WORLD", requires = "scenarios")]
    world: Option<String>,
}

impl OneWorld {
    /// The world, if one is named.
    pub(super) fn asked(&self, rules: &RuleSet) -> Result<Option<Scenario>, Fault> {
        let (Some(wanted), Some(world)) = (&self.scenarios, &self.world) else { return Ok(None) };
        let (name, worlds) = worlds(wanted, rules)?;
        let names: Vec<String> = worlds.iter().map(|scenario| scenario.name.clone()).collect();
        let found = worlds.into_iter().find(|scenario| scenario.name == *world);
        found.map(Some).ok_or_else(|| {
            let help = did_you_mean(world, names.iter().map(String::as_str))
                .unwrap_or_else(|| format!("it has: {}", names.join(", ")));
            Fault::usage(format!("`{name}` has no world `{world}`\nhelp: {help}"))
        })
    }
}

/// The worlds of a set that is named on the command line, and its name.
fn worlds(wanted: &str, rules: &RuleSet) -> Result<(String, Vec<Scenario>), Fault> {
    let (name, set) = set(wanted, rules)?;
    if let Some((difference, why)) = rules.cannot_apply(&set, rules.tasks.values()) {
        return Err(Fault::input(format!("`{}` of `{name}` cannot be applied: {why}", difference.text())));
    }
    let worlds = scenarios::worlds(&name, &set);
    Ok((name, worlds))
}

/// A set that is named on the command line: `NAME` of the design's grammar, or `FILE:NAME` of another.
fn set(wanted: &str, rules: &RuleSet) -> Result<(String, Scenarios), Fault> {
    let (file, name) = match wanted.rsplit_once(':') {
        Some((file, name)) => (Some(file), name),
        None => (None, wanted),
    };
    if let Some(library) = file.filter(|file| file.starts_with("std.")) {
        return Err(Fault::usage(format!(
            "`--in` cannot name a set of the library directly: it needs a grammar that imports the set\nhelp: write `use {library} {{ {name} }}` in a file, and `--in FILE:{name}`; \
             a set that the design's own grammar imports needs no file: `--in {name}`"
        )));
    }
    let other = match file {
        Some(file) => {
            let help =
                format!("\nhelp: name a grammar that imports `{name}` from it: `--in GRAMMAR.sgr:{name}`");
            Some(load::grammar_or(Path::new(file), &[], None, &help)?.0)
        }
        None => None,
    };
    let there = &other.as_ref().unwrap_or(rules).scenarios;
    if let Some(set) = there.get(name) {
        return Ok((name.to_owned(), set.clone()));
    }
    let whose = file.map_or("the grammar of this design".to_owned(), str::to_owned);
    let help = did_you_mean(name, there.keys().map(String::as_str));
    let help = help.unwrap_or_else(|| match there.is_empty() {
        true => "it declares none; name another grammar that does: `--in FILE:NAME`".to_owned(),
        false => format!("it has: {}", there.keys().map(String::as_str).collect::<Vec<_>>().join(", ")),
    });
    Err(Fault::usage(format!("{whose} has no scenarios `{name}`\nhelp: {help}")))
}

/// Simulates a design in every world of a set, and prints what it comes to.
pub(super) fn eval(
    wanted: &str,
    rules: &RuleSet,
    design: &SavedDesign,
    path: &Path,
    solver: &str,
    precision: Precision,
) -> Result<u8, Fault> {
    let (name, worlds) = worlds(wanted, rules)?;
    let fault = |error: DesignError| Fault::input(format!("{}: {error}", path.display()));
    let how = How { solver, precision, stop: Stop::NEVER };
    let (judged, whole) = elsewhere::judge(rules, design, worlds, how).map_err(fault)?;
    let unit = &rules.objective.unit;
    let quantity = |value: f64| describe::quantity(value, unit);
    let of = |judged: &Judged| match judged.value {
        Ok(value) => quantity(value),
        Err(why) => format!("no value: {}", why.describe()),
    };
    if rules.tasks.len() > 1 {
        let tasks: Vec<&str> = rules.tasks.keys().map(String::as_str).collect();
        output::data(&format!(
            "the value of the grammar's objective over its tasks ({}):\n",
            tasks.join(", ")
        ))?;
    }
    let names = judged.iter().map(|judged| judged.scenario.name.chars().count()).max().unwrap_or(0);
    let values: Vec<String> = judged.iter().map(of).collect();
    let width = values.iter().map(|value| value.chars().count()).max().unwrap_or(0);
    for (judged, value) in judged.iter().zip(&values) {
        let line =
            format!("{:names$}  {value:>width$}  {}", judged.scenario.name, judged.scenario.described());
        output::data(&format!("{}\n", line.trim_end()))?;
    }
    let values: Vec<Option<f64>> = judged.iter().map(|judged| judged.value.ok()).collect();
    let worst = |place: usize| judged[place].scenario.name.clone();
    if let Some(said) = summary::together(rules.objective.direction, &values, unit, worst) {
        let whole = match rules.tasks.values().all(|task| task.objective.is_told_by_each_world()) {
            true => String::new(),
            false => summary::whole(whole, unit),
        };
        output::data(&format!("in {} worlds of `{name}`: {whole}{said}\n", judged.len()))?;
    }
    Ok(exit::DONE)
}
