//! `sgc run`: searches for a good design.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use clap::Args;
use grammar_lang::ir::{RuleSet, without_spans};

use super::live::Live;
use super::output::{self, Fault};
use super::session::Session;
use super::several::Several;
use super::work::{Work, duration};
use super::{design, interrupt, load, price};
use crate::derive::{Candidate, Derivation};
use crate::drive::Parameters;
use crate::results::folder::{Reopened, RunFolder};
use crate::results::replay::curves_of;
use crate::results::robustness;
use crate::results::run_files::{Asked, EVALUATIONS, listed};
use crate::results::saved::Grammar;
use crate::results::series::{Series, SeriesFolder};
use crate::search::{self, Jobs, State};
use crate::simulate::{self, SolverName};

/// Search for a design: bodies by the grammar's rules, gaits by its actuation
#[derive(Args)]
pub(super) struct Run {
    /// The grammar
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Set a parameter of the grammar
    #[arg(short, long = "param", value_name = "NAME=VALUE", value_parser = super::assignment)]
    params: Vec<(String, String)>,
    /// The variant to use, if the file declares several
    #[arg(long, value_name = "NAME")]
    variant: Option<String>,
    /// The seed: the same seed gives the same result
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Do K runs, with this seed and the seeds that follow it, each in its own folder, and summarise them
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u16).range(1..=1000))]
    runs: Option<u16>,
    /// End after this many simulated motions, or a few more: motions that have begun are finished. With 0, only the grammar's schedule ends the run [default: 8000,
    /// or 0 with --time and without --runs]
    #[arg(long, value_name = "N")]
    max_evals: Option<u64>,
    /// Stop after this time, such as 90s, 30m or 2h, in the same way as Ctrl-C; `sgc resume` continues the run
    #[arg(long, value_name = "TIME", value_parser = duration)]
    time: Option<(String, Duration)>,
    /// The run folder [default: runs/GRAMMAR-SEED, with --runs runs/GRAMMAR-FIRST-to-LAST]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace an existing run folder
    #[arg(long)]
    force: bool,
    /// The simulation method [default: articulated, or balls if the grammar simulates balls and springs]
    #[arg(long, value_parser = clap::builder::PossibleValuesParser::new(SolverName::ALL.map(SolverName::text)))]
    solver: Option<String>,
    /// Start from an example of the grammar [default: its initial design]
    #[arg(long, value_name = "EXAMPLE")]
    from: Option<String>,
    /// Start from a saved design, or the best design of a run: from its body and curves, as far as the grammar
    /// can make them
    #[arg(long, value_name = "DIR|DESIGN", conflicts_with = "from")]
    from_design: Option<PathBuf>,
    #[command(flatten)]
    work: Work,
}

impl Run {
    pub(super) fn run(self) -> Result<u8, Fault> {
        let flag = interrupt::listen();
        let before = interrupt::Cuttable::begin();
        let started = Instant::now();
        let (rules, sources) = load::grammar(&self.file, &self.params, self.variant.as_deref())?;
        let design = self.from_design.as_deref().map(|path| begun_with(path, &rules, &self)).transpose()?;
        let from = self.from.clone().or_else(|| rules.from.clone()).filter(|_| design.is_none());
        let (first, curves, design) = match design {
            Some(Begun { derivation, curves, named }) => (derivation, curves, Some(named)),
            None => (super::derive::start(&rules, &sources, from.as_deref())?, Vec::new(), None),
        };
        let max_evals = match (self.max_evals, &self.time) {
            (Some(0), _) => None,
            // Several would not come to their turns.
            (None, Some(_)) if self.runs.is_none() => None,
            (Some(n), _) => Some(n),
            (None, _) => Some(EVALUATIONS),
        };
        let grammar = Grammar::freeze(&rules, &sources, &self.params);
        let command =
            std::env::args_os().map(|word| word.to_string_lossy().into_owned()).collect::<Vec<_>>().join(" ");
        let asked = |seed: u64| Asked {
            command: command.clone(),
            sgc: env!("CARGO_PKG_VERSION").to_owned(),
            grammar: rules.name.clone(),
            rules: grammar.rules.clone(),
            seed,
            solver: self.solver.clone().unwrap_or_else(|| crate::search::solver(&rules).text().to_owned()),
            max_evals,
            time: self.time.as_ref().map(|(text, _)| text.clone()),
            from: from.clone(),
            design: design.clone(),
            entry: grammar.entry.clone(),
            parameters: self.params.clone(),
            sources: listed(&grammar),
        };
        if let Some(solver) = &self.solver {
            check_solver(&rules, &first, solver)?;
        }
        let deadline = self.time.as_ref().map(|(_, time)| started + *time);
        let tried = first.clone();
        let state = State::begin_with(first, curves);
        drop(before);
        let named = |name: String| self.out.clone().unwrap_or_else(|| PathBuf::from("runs").join(name));
        if let Some(runs) = self.runs {
            let last = self.seed.checked_add(u64::from(runs) - 1).ok_or_else(|| {
                Fault::usage("the last seed would be too large: use a smaller --seed or fewer --runs")
            })?;
            let series = Series {
                command: command.clone(),
                sgc: env!("CARGO_PKG_VERSION").to_owned(),
                grammar: rules.name.clone(),
                seeds: (self.seed..=last).collect(),
            };
            let path = named(format!("{}-{}-to-{last}", rules.name, self.seed));
            let begin = |seed: u64, path: &Path| {
                RunFolder::create(path, false, &asked(seed), &grammar, &rules, &state).map(|_| ())
            };
            let folder = SeriesFolder::create(&path, self.force, series, begin).map_err(Fault::usage)?;
            return Several { folder, work: self.work, max_evals: None, deadline, flag }.go();
        }
        let path = named(format!("{}-{}", rules.name, self.seed));
        let asked = asked(self.seed);
        let folder =
            RunFolder::create(&path, self.force, &asked, &grammar, &rules, &state).map_err(Fault::usage)?;
        if !folder.is_replacing() {
            interrupt::saved(&path);
        }
        if let (false, Some(model)) = (self.work.quiet, simulate::model(&asked.solver)) {
            let _cuttable = interrupt::Cuttable::begin();
            if let Some(price) = price::told(&rules, &tried, model, max_evals, flag) {
                output::note(&price);
            }
        }
        let run = Reopened { folder, asked, grammar, rules, sources, state, max_evals };
        let live = Live::begin(&self.work, run.folder.path());
        let jobs = Jobs::new(self.work.jobs());
        let session = Session { run, work: self.work, jobs, deadline, told: true, live: live.as_ref() };
        let ended = session.go(flag);
        if let Some(live) = live {
            live.end();
        }
        ended?.tell()
    }
}

/// That a solver which the grammar's models are not meant for can simulate the design that the search begins with.
fn check_solver(rules: &RuleSet, first: &Derivation, solver: &str) -> Result<(), Fault> {
    let candidate = Candidate::new(rules, Arc::new(first.clone()));
    search::unfit(&candidate, solver).map_or(Ok(()), |unfit| {
        Err(Fault::input(format!(
            "`--solver {solver}` cannot simulate the design that the search begins with: {}",
            unfit.reason
        )))
    })
}

/// A saved design that a search begins with.
struct Begun {
    derivation: Derivation,
    /// Its curves, by task; empty where they do not fit.
    curves: Vec<Parameters>,
    /// Which one that is, for the record.
    named: String,
}

/// Makes a saved design by the rules of the grammar that is to be run.
fn begun_with(path: &Path, rules: &RuleSet, run: &Run) -> Result<Begun, Fault> {
    let file = design::file(path);
    let saved = design::read(&file)?;
    design::check_enumerations(&file, &saved, rules)?;
    design::tell_other_parameters(&file, &saved, rules, &run.params);
    let derivation = Derivation::replay(rules, &saved.derivation).map_err(|why| {
        Fault::input(format!(
            "the rules of `{}` do not make the design in {}: {why}",
            rules.name,
            file.display()
        ))
    })?;
    if let Ok(theirs) = saved.grammar.compile(&saved.sgc)
        && !derive_alike(&theirs, rules)
        && let Err(why) = Derivation::follow_all(rules, &saved.derivation)
    {
        return Err(Fault::input(format!(
            "the rules of `{0}` do not make the design in {1} by its own steps: {why}; `sgc audit GRAMMAR --design {1}` tells whether they \
             make it in another way",
            rules.name,
            file.display()
        )));
    }
    design::tell_other_body(&file, &saved, rules);
    let candidate = Candidate::new(rules, Arc::new(derivation.clone()));
    let other = design::other_quantity(&saved, rules);
    let curves = if other.is_some() { Vec::new() } else { curves_of(&candidate, &saved) };
    if curves.is_empty() {
        output::note(&format!(
            "the curves of {} do not fit the actuation of `{}`: the search begins with its body and draws curves anew",
            file.display(),
            rules.name
        ));
    } else if let Some(lost) = robustness::refused_with_rods(&candidate, &saved, run.solver.as_deref()) {
        output::note(&format!(
            "the curves of {} have the value {} in the nominal world, but {} with soft rods, which is less than `keep_with_rods` requires: the search refuses them, and draws others \
             for this body",
            file.display(),
            lost.hinges,
            lost.rods
        ));
    }
    let named =
        format!("{} ({} of seed {}, body {})", file.display(), saved.grammar.name, saved.seed, saved.body);
    Ok(Begun { derivation, curves, named })
}

/// Whether two grammars make designs by the same rules from the same beginning.
fn derive_alike(one: &RuleSet, other: &RuleSet) -> bool {
    let of = |r: &RuleSet| {
        let rules: Vec<_> = r
            .rules
            .iter()
            .map(|rule| (&rule.name, &rule.matches, &rule.choices, &rule.guards, &rule.effects))
            .collect();
        let read = (&r.parts, &r.actuators, &r.params, &r.lattice);
        without_spans(&(rules, &r.fallbacks, &r.begin, &r.symmetry, read)).ok()
    };
    of(one).is_some() && of(one) == of(other)
}
