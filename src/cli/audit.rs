//! `sgc audit`: what a grammar makes, and what it excludes.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use grammar_lang::ir::RuleSet;
use grammar_lang::source::SourceMap;

use super::countdown::Countdown;
use super::output::{self, Fault};
use super::{derive, design, exit, load};
use crate::audit::{self, Answer, Observer, Settings};
use crate::derive::Derivation;
use crate::results::DesignError;
use crate::results::describe::Named;
use crate::results::names::Names;

/// Find out what a grammar makes and what it excludes, without simulating
#[derive(Args)]
pub(super) struct Audit {
    /// The grammar; `-` reads standard input
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Set a parameter of the grammar
    #[arg(short, long = "param", value_name = "NAME=VALUE", value_parser = super::assignment)]
    params: Vec<(String, String)>,
    /// The variant to use, if the file declares several
    #[arg(long, value_name = "NAME")]
    variant: Option<String>,
    /// The seed of the random numbers
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// How many random walks to make
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(..=1_000_000))]
    walks: u32,
    /// How many moves to make in each walk
    #[arg(long, value_name = "N", default_value_t = 20)]
    steps: usize,
    /// The temperature that weights and choices read
    #[arg(long, value_name = "T", default_value_t = 0.0, value_parser = temperature)]
    temperature: f64,
    /// The greatest number of rule applications to try when the designs are counted, and again for each body from --design or --example
    #[arg(long, value_name = "N", default_value_t = 100_000)]
    budget: usize,
    /// Report whether the grammar can make this saved design, or the best design of this run folder
    #[arg(long = "design", value_name = "PATH")]
    designs: Vec<PathBuf>,
    /// Report whether the rules can make the body of this example of the grammar
    #[arg(long = "example", value_name = "NAME")]
    examples: Vec<String>,
    /// How the report is written
    #[arg(long, value_enum, default_value = "text")]
    format: Style,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Style {
    /// In columns, for people
    Text,
    /// As one JSON object
    Json,
}

fn temperature(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|t| t.is_finite() && *t >= 0.0);
    value.ok_or_else(|| "write a number from 0".to_owned())
}

/// A body that was asked for, and what came of it.
struct Asked {
    name: String,
    answer: Answer,
}

impl Audit {
    pub(super) fn run(self) -> Result<u8, Fault> {
        let (rules, sources) = load::grammar(&self.file, &self.params, self.variant.as_deref())?;
        // A design that cannot be read is told before the work is done.
        let designs =
            self.designs.iter().map(|path| saved(path, &rules)).collect::<Result<Vec<_>, Fault>>()?;
        for name in &self.examples {
            derive::known_example(&rules, name)?;
        }
        let start = derive::start(&rules, &sources, rules.from.as_deref())?;
        let settings = self.settings();
        let fault = |e| Fault::input(load::no_value(&e, &sources));
        let mut progress = Countdown::begin();
        let found = audit::audit(&rules, &start, &settings, &mut progress).map_err(fault)?;
        for (error, times) in &found.failing {
            let refused = if *times == 1 {
                "one move was refused".to_owned()
            } else {
                format!("{times} moves were refused")
            };
            output::note(&format!("warning: {}; {refused} because of it", load::no_value(error, &sources)));
        }
        let mut asked = Vec::new();
        for name in &self.examples {
            asked.push(example(&rules, &sources, name));
        }
        for (path, design) in self.designs.iter().zip(&designs) {
            let answer = audit::can_make(&rules, &start, design, &settings, &mut progress).map_err(fault)?;
            asked.push(Asked { name: format!("design {}", path.display()), answer });
        }
        output::data(&match self.format {
            Style::Text => text(&rules, &found, &asked),
            Style::Json => json(&rules, &found, &asked),
        })?;
        let made = asked.iter().all(|a| matches!(a.answer, Answer::Yes(_)));
        Ok(if made { exit::DONE } else { exit::INPUT })
    }

    fn settings(&self) -> Settings {
        Settings {
            seed: self.seed,
            walks: self.walks as usize,
            steps: self.steps,
            temperature: self.temperature,
            budget: self.budget,
        }
    }
}

/// A saved design, made again by the grammar that it was saved with.
fn saved(path: &Path, by: &RuleSet) -> Result<Derivation, Fault> {
    let path = design::file(path);
    let design = design::read(&path)?;
    let fault = |e: DesignError| Fault::usage(format!("{}: {e}", path.display()));
    design::check_enumerations(&path, &design, by)?;
    let rules = design.grammar.compile_edited().map_err(fault)?;
    Derivation::replay(&rules, &design.derivation).map_err(|bad| fault(bad.into()))
}

/// An example is its own derivation: it can be made if all of it holds.
fn example(rules: &RuleSet, sources: &SourceMap, name: &str) -> Asked {
    let answer = match Derivation::start(rules, Some(name)) {
        Ok(derivation) => Answer::Yes(Box::new(audit::Made { derivation, own_steps: true })),
        Err(failure) => {
            let (line, _) = sources.line_column(failure.span());
            let label = failure.labels.first().map_or("", |l| l.text.as_str());
            Answer::No(vec![format!("line {line}: {}: {label}", failure.message)])
        }
    };
    Asked { name: format!("example {name}"), answer }
}

/// The steps of a derivation that was found, in words.
fn steps(rules: &RuleSet, answer: &Answer) -> Vec<String> {
    match answer {
        Answer::Yes(made) => {
            let Derivation { design, steps, .. } = &made.derivation;
            let names = &Names::through(rules, &made.derivation);
            let named = Named { rules, names, design };
            steps.iter().map(|step| named.step(step)).collect()
        }
        _ => Vec::new(),
    }
}

fn text(rules: &RuleSet, found: &audit::Audit, asked: &[Asked]) -> String {
    let answers = asked.iter().map(|a| audit::answer(&a.name, &a.answer, &steps(rules, &a.answer)));
    std::iter::once(audit::report(found)).chain(answers).collect()
}

fn json(rules: &RuleSet, found: &audit::Audit, asked: &[Asked]) -> String {
    // Plain data always serialises.
    let mut value = serde_json::to_value(found).unwrap_or_default();
    let answers = asked.iter().map(|a| {
        let (made, reasons) = match &a.answer {
            Answer::Yes(_) => ("yes", Vec::new()),
            Answer::No(reasons) => ("no", reasons.clone()),
            Answer::Open(reasons) => ("undecided", reasons.clone()),
        };
        let steps = steps(rules, &a.answer);
        serde_json::json!({ "asked": a.name, "made": made, "steps": steps, "reasons": reasons })
    });
    let answers = answers.collect();
    if let Some(fields) = value.as_object_mut() {
        fields.insert("asked".to_owned(), serde_json::Value::Array(answers));
    }
    serde_json::to_string_pretty(&value).unwrap_or_default() + "\n"
}

impl Observer for Countdown {
    fn progress(&mut self, what: &str, done: usize, of: usize) {
        self.tell(what, done, of);
    }
}
