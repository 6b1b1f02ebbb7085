//! `sgc eval --in`: a saved design in the worlds of a set of scenarios.

use std::path::Path;

use grammar_lang::diagnostics::did_you_mean;
use grammar_lang::ir::{RuleSet, Scenarios};

use super::output::{self, Fault};
use super::{exit, load};
use crate::results::DesignError;
use crate::results::describe;
use crate::results::elsewhere::{self, Judged, Together};
use crate::results::replay::Precision;
use crate::results::saved::SavedDesign;
use crate::scenarios;
use crate::simulate::Stop;

/// A set that is named on the command line: `NAME` of the design's grammar, or `FILE:NAME` of another.
fn set(wanted: &str, rules: &RuleSet) -> Result<(String, Scenarios), Fault> {
    let (file, name) = match wanted.rsplit_once(':') {
        Some((file, name)) => (Some(file), name),
        None => (None, wanted),
    };
    let other = match file {
        Some(file) => Some(load::grammar(Path::new(file), &[], None)?.0),
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
    let (name, set) = set(wanted, rules)?;
    if let Some((difference, why)) = rules.cannot_apply(&set, rules.tasks.values()) {
        return Err(Fault::input(format!("`{}` of `{name}` cannot be applied: {why}", difference.text())));
    }
    let fault = |error: DesignError| Fault::input(format!("{}: {error}", path.display()));
    let worlds = scenarios::worlds(&name, &set);
    let judged = elsewhere::judge(rules, design, worlds, solver, precision, Stop::NEVER).map_err(fault)?;
    let unit = &rules.objective.unit;
    let quantity = |value: f64| describe::quantity(value, unit);
    let of = |judged: &Judged| match judged.value {
        Ok(value) => quantity(value),
        Err(why) => format!("no value: {}", why.describe()),
    };
    let names = judged.iter().map(|judged| judged.scenario.name.chars().count()).max().unwrap_or(0);
    let values: Vec<String> = judged.iter().map(of).collect();
    let width = values.iter().map(|value| value.chars().count()).max().unwrap_or(0);
    for (judged, value) in judged.iter().zip(&values) {
        let line =
            format!("{:names$}  {value:>width$}  {}", judged.scenario.name, judged.scenario.described());
        output::data(&format!("{}\n", line.trim_end()))?;
    }
    if let Some(found) = elsewhere::together(rules.objective.direction, &judged) {
        output::data(&format!(
            "in {} worlds of `{name}`: {}\n",
            judged.len(),
            summed(&found, &judged, &quantity)
        ))?;
    }
    Ok(exit::DONE)
}

/// What several worlds come to, in words.
fn summed(found: &Together, judged: &[Judged], quantity: &dyn Fn(f64) -> String) -> String {
    let mut said = Vec::new();
    said.extend(found.mean.map(|mean| format!("{} on average", quantity(mean))));
    said.extend(found.tenth.map(|tenth| format!("{} or better in nine of ten", quantity(tenth))));
    if let Some(worst) = judged.get(found.worst) {
        said.push(match worst.value {
            Ok(value) => format!("{} at worst ({})", quantity(value), worst.scenario.name),
            Err(_) => format!("none in {} of them", found.without),
        });
    }
    said.join(", ")
}
