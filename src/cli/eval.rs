//! `sgc eval`: simulates a saved design again.

use std::path::{Path, PathBuf};

use clap::Args;

use grammar_lang::ir::{RuleSet, objective_name};
use grammar_lang::source::SourceMap;

use super::design::{self, Opened};
use super::output::{self, Fault};
use super::precision::Precision;
use super::{exit, load, scenarios};
use crate::calibrate::reality::{self, Built, Estimate, Prediction};
use crate::results::replay::Replayed;
use crate::results::saved::SavedDesign;
use crate::results::{describe, genuine, replay, summary};
use crate::score;
use crate::simulate::SolverName;

/// Simulate a saved design again and print its terms and value
#[derive(Args)]
pub(super) struct Eval {
    /// The saved design, or the run folder that holds it
    #[arg(value_name = "DESIGN")]
    design: PathBuf,
    /// Use another simulation method [default: the method of the run]
    #[arg(long, value_parser = clap::builder::PossibleValuesParser::new(SolverName::ALL.map(SolverName::text)))]
    solver: Option<String>,
    #[command(flatten)]
    precision: Precision,
    /// Evaluate the design with this grammar, not with the one that made it
    #[arg(long, value_name = "FILE")]
    grammar: Option<PathBuf>,
    /// Score this motion from another program, and simulate nothing; the file has the format that `sgc export
    /// --to motion` writes
    #[arg(long, value_name = "FILE", conflicts_with_all = ["solver", "step", "sweeps"])]
    motion: Option<PathBuf>,
    /// The task that the motion is scored by [default: the first]
    #[arg(long, value_name = "NAME", requires = "motion")]
    task: Option<String>,
    /// Simulate the design in every world of this set of scenarios: NAME in its grammar, or FILE:NAME in another file
    #[arg(long = "in", value_name = "SCENARIOS", conflicts_with_all = ["motion", "task"])]
    scenarios: Option<String>,
    /// The variant of the grammar that --grammar names
    #[arg(long, value_name = "NAME", requires = "grammar")]
    variant: Option<String>,
    /// Set a parameter of that grammar
    #[arg(short, long = "param", value_name = "NAME=VALUE", requires = "grammar", value_parser = super::assignment)]
    params: Vec<(String, String)>,
}

/// What the prototypes of its kind of build make of a design's speed, for each task that is simulated on a target.
fn predictions(rules: &RuleSet, sources: &SourceMap, replayed: &Replayed) -> Vec<String> {
    let mut lines = Vec::new();
    for (name, simulated) in replayed.tasks.iter().filter_map(|task| task.speed.as_ref()) {
        let Some(target) = rules.targets.get(name) else { continue };
        let simulated = *simulated;
        let kind = target.backend.name();
        let said = target.speed.as_ref().map_or("", |speed| sources.slice(speed.span));
        lines.push(format!("speed on `{name}` {} simulated (`{said}`)\n", hourly(simulated)));
        let built: Vec<Built> = rules
            .prototypes
            .iter()
            .filter(|(_, prototype)| prototype.backend == kind)
            .map(|(name, p)| Built {
                name: name.clone(),
                simulated: p.simulated,
                measured: p.measured,
                length: p.length,
            })
            .collect();
        let Some(prediction) = reality::predict(&built, simulated) else { continue };
        let names = listed(&prediction.prototypes);
        lines.push(format!(
            "  expected when built: {} (from the measured and simulated speeds of {names} on {kind})\n",
            expected(&prediction.ratio)
        ));
        lines.extend(held(&prediction.ratio, &prediction));
        if let Some(constant) = &prediction.constant {
            lines.push(format!("  one speed for all of them fits better: {}\n", expected(constant)));
            lines.extend(held(constant, &prediction));
        }
        if let Some((low, high)) = prediction.beyond {
            lines.push(format!(
                "  {} lies outside the range of the prototypes ({} to {} simulated): do not rely on this\n",
                hourly(simulated),
                digits(low),
                hourly(high)
            ));
        }
        if !prediction.repeated.is_empty() {
            let names = listed(&prediction.repeated);
            lines.push(format!("  not counted, because another prototype has the same numbers: {names}\n"));
        }
    }
    lines
}

fn hourly(speed: f64) -> String {
    format!("{} m/h", digits(speed))
}

/// A speed in m/h, to two digits or a tenth.
fn digits(speed: f64) -> String {
    let hourly = speed * 3600.0;
    if hourly.abs() < 1.0 {
        let decimals =
            if hourly == 0.0 { 2.0 } else { (1.0 - libm::floor(libm::log10(hourly.abs()))).min(9.0) };
        format!("{hourly:.0$}", decimals as usize)
    } else {
        format!("{hourly:.1}")
    }
}

/// An estimate in words: `2.9 m/h, nine times of ten 1.0 to 8.4 m/h`.
fn expected(estimate: &Estimate) -> String {
    let within = estimate
        .interval
        .map_or(String::new(), |(low, high)| format!(", 90 % interval {} to {}", digits(low), hourly(high)));
    format!("{}{within}", hourly(estimate.speed))
}

/// How well the prototypes predict each other, in words.
fn held(estimate: &Estimate, of: &Prediction) -> Option<String> {
    let (held, all) = (estimate.held?, of.prototypes.len());
    Some(format!(
        "    when each is left out in turn, {held} of {all} lie in the interval that the others give\n"
    ))
}

fn listed(names: &[String]) -> String {
    match names {
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
        [] => String::new(),
    }
}

impl Eval {
    pub(super) fn run(self) -> Result<u8, Fault> {
        let path = design::file(&self.design);
        let opened = design::open_by(&path, self.grammar.as_deref(), &self.params, self.variant.as_deref())?;
        let Opened { mut design, rules, sources } = opened;
        let other = (rules.name != design.grammar.name).then(|| {
            format!("; it was made by the grammar `{}`, not by `{}`", design.grammar.name, rules.name)
        });
        if let Some(motion) = &self.motion {
            return self.score(&rules, &design, motion);
        }
        let solver = self.solver.as_deref().unwrap_or(&design.solver);
        let precision = self.precision.asked();
        if let Some(wanted) = &self.scenarios {
            return scenarios::eval(wanted, &rules, &design, &path, solver, precision);
        }
        let replayed = replay::replay(&rules, &design, solver, precision)
            .map_err(|e| Fault::input(format!("{}: {e}{}", path.display(), other.unwrap_or_default())))?;
        let Some(value) = replayed.value else {
            return Err(Fault::input(format!("the motion is not valid: {}", replayed.why_invalid())));
        };
        // Of the design as it was read.
        let checked = genuine::check_values(&rules, &design, &replayed);
        output::data(&format!("value {}\n", describe::quantity(value, &rules.objective.unit)))?;
        for (objective, value) in rules.beside().iter().zip(&replayed.beside) {
            let value = describe::quantity(*value, &objective.unit);
            output::data(&format!("  and {} {value}\n", objective_name(&rules, objective)))?;
        }
        let penalties = score::penalties(&rules, &replayed.candidate.derivation)
            .map_err(|e| Fault::input(format!("{}: {}", path.display(), e.reason)))?;
        for (name, weight) in &penalties {
            output::data(&summary::not_fulfilled(&rules, name, *weight))?;
        }
        design.penalties = penalties;
        for (name, value) in &replayed.observed {
            output::data(&summary::observed(&rules, name, value.as_ref()))?;
        }
        for task in &replayed.tasks {
            let Some(score) = &task.score else { continue };
            // In the unit of the grammar that judges.
            let unit = rules.tasks.get(&task.name).map_or("", |task| &task.objective.unit);
            if task.name != RuleSet::ONLY_TASK {
                let value = describe::quantity(score.value, unit);
                output::data(&format!("task {} {value}\n", task.name))?;
            }
            if let Some(nominal) = task.nominal {
                let nominal = design.less_penalties(rules.objective.direction, nominal);
                let value = describe::quantity(nominal, unit);
                output::data(&format!("  in the nominal world {value}\n"))?;
            }
            for (name, value) in &score.terms {
                let text = describe::term(&rules, unit, name, *value);
                output::data(&format!("  {name} {text}\n"))?;
            }
        }
        for line in predictions(&rules, &sources, &replayed) {
            output::data(&line)?;
        }
        let same = self.solver.is_none() && precision == replay::Precision::Model && self.grammar.is_none();
        if same && checked.is_ok() {
            output::note("exactly the saved value");
        } else {
            output::note(&format!("the saved value is {}", describe::quantity(design.value, &design.unit)));
        }
        if same {
            checked.map_err(|e| Fault::input(format!("{}: {e}", path.display())))?;
        }
        Ok(exit::DONE)
    }

    /// Scores a motion that another program made.
    fn score(&self, rules: &RuleSet, design: &SavedDesign, motion: &Path) -> Result<u8, Fault> {
        let text = load::read(motion)?.text;
        let task = self.task.as_deref();
        let (score, observed) =
            replay::score_of(rules, design, task, &text).map_err(|e| design::fault(motion, &e))?;
        let judged = design.task(task).ok().and_then(|saved| rules.tasks.get(&saved.name));
        let unit = judged.map_or("", |task| task.objective.unit.as_str());
        output::data(&format!("value {}\n", describe::quantity(score.value, unit)))?;
        if let Some(model) = judged.map(|task| &task.model) {
            let (rows, recorded) = (text.lines().count().saturating_sub(1), model.duration / model.record);
            if (rows as f64) < recorded / 2.0 {
                output::note(&format!(
                    "the motion has {rows} rows, but the model records {recorded:.0}: terms that add up along the path of an element, such as \
                     `e.path`, `e.slid` and `e.touching`, and what is observed of these, are too small"
                ));
            }
        }
        if design.task(task).is_ok_and(|saved| saved.nominal.is_some()) {
            output::note(
                "this is one motion, scored as that of the nominal world; the saved value of the design is over all of its worlds",
            );
        }
        for (name, value) in rules.observed.iter().zip(&observed) {
            output::data(&summary::observed(rules, name, value.as_ref()))?;
        }
        for (name, value) in &score.terms {
            output::data(&format!("  {name} {}\n", describe::term(rules, unit, name, *value)))?;
        }
        Ok(exit::DONE)
    }
}
