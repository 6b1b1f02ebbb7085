//! `sgc run`: searches for a good design.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use clap::Args;
use grammar_lang::ir::RuleSet;

use super::output::{self, Fault};
use super::progress::{Progress, span};
use super::{exit, load};
use crate::results::folder::{Asked, RunFolder};
use crate::results::judge;
use crate::results::saved::Grammar;
use crate::search::{self, Best, End, Failure, Limits, Observer, Row};
use crate::simulate;

/// Evaluations of a run that was not told how many: about two minutes on two cores.
const DEFAULT_EVALUATIONS: u64 = 8000;

/// Whether a best design is on the disk.
static SAVED: AtomicBool = AtomicBool::new(false);

/// Search for a design: bodies by the grammar's rules, gaits by its actuation
#[derive(Args)]
pub(super) struct Run {
    /// The grammar
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Set a parameter of the grammar
    #[arg(short, long = "param", value_name = "NAME=VALUE", value_parser = super::assignment)]
    params: Vec<(String, String)>,
    /// The variant, where the file declares several
    #[arg(long, value_name = "NAME")]
    variant: Option<String>,
    /// The seed: the same seed gives the same result
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Threads to use; the result does not depend on it [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
    /// End after this many simulated motions; 0 leaves it to the grammar's schedule [default: 8000, or 0 with --time]
    #[arg(long, value_name = "N")]
    max_evals: Option<u64>,
    /// End after this time, such as 90s, 30m or 2h; such a run is not repeatable
    #[arg(long, value_name = "TIME", value_parser = duration)]
    time: Option<(String, Duration)>,
    /// The run folder [default: runs/GRAMMAR-SEED]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace an existing run folder
    #[arg(long)]
    force: bool,
    /// The simulation method
    #[arg(long, default_value = "articulated", value_parser = clap::builder::PossibleValuesParser::new(simulate::MODELS))]
    solver: String,
    /// Start from an example of the grammar [default: its initial design]
    #[arg(long, value_name = "EXAMPLE")]
    from: Option<String>,
    /// No progress, only the result
    #[arg(short, long)]
    quiet: bool,
}

/// Reads a time such as `90s`, `30m`, `1h`.
fn duration(text: &str) -> Result<(String, Duration), String> {
    let wrong = || "write a time such as 90s, 30m or 2h".to_owned();
    let text = text.trim();
    let (number, unit) = text.split_at(text.len() - text.chars().last().map_or(0, char::len_utf8));
    let seconds = match unit {
        "s" => 1.0,
        "m" => 60.0,
        "h" => 3600.0,
        _ => return Err(wrong()),
    };
    match number.trim().parse::<f64>() {
        Ok(x) if x > 0.0 && x * seconds < 1e8 => Ok((text.to_owned(), Duration::from_secs_f64(x * seconds))),
        _ => Err(wrong()),
    }
}

impl Run {
    pub(super) fn run(self) -> Result<u8, Fault> {
        let (rules, sources) = load::grammar(&self.file, &self.params, self.variant.as_deref())?;
        let from = self.from.clone().or_else(|| rules.from.clone());
        let first = super::derive::start(&rules, &sources, from.as_deref())?;
        let model = simulate::model(&self.solver).ok_or_else(|| Fault::usage("unknown solver"))?;
        let max = match (self.max_evals, &self.time) {
            (Some(0), _) | (None, Some(_)) => None,
            (Some(n), _) => Some(n),
            (None, None) => Some(DEFAULT_EVALUATIONS),
        };
        let grammar = Grammar::freeze(&rules, &sources, &self.params);
        let asked = Asked {
            command: std::env::args().collect::<Vec<_>>().join(" "),
            sgc: env!("CARGO_PKG_VERSION").to_owned(),
            grammar: rules.name.clone(),
            rules: grammar.rules.clone(),
            seed: self.seed,
            solver: self.solver.clone(),
            max_evals: max,
            time: self.time.as_ref().map(|(text, _)| text.clone()),
            parameters: self.params.iter().cloned().collect(),
        };
        let path =
            self.out.unwrap_or_else(|| PathBuf::from("runs").join(format!("{}-{}", rules.name, self.seed)));
        let stop = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&stop);
        // Where no handler can be set, an interrupt ends the program at once; what was saved stays.
        let _ = ctrlc::set_handler(move || {
            // The second one means it.
            if flag.swap(true, Ordering::SeqCst) {
                let code = if SAVED.load(Ordering::SeqCst) { exit::STOPPED } else { exit::INTERRUPTED };
                std::process::exit(i32::from(code));
            }
        });
        let folder = RunFolder::create(&path, self.force, &asked, &grammar).map_err(Fault::usage)?;
        let started = Instant::now();
        let jobs = self
            .jobs
            .map_or_else(|| std::thread::available_parallelism().map_or(1, usize::from), usize::from);
        let deadline = self.time.as_ref().map(|(_, time)| started + *time);
        let limits = Limits { seed: self.seed, jobs, max_evaluations: max, deadline };
        let unit = rules.objective.unit.clone();
        let progress = Progress::new(max, deadline, &unit, self.quiet);
        let mut keeper =
            Keeper { rules: &rules, grammar, folder, progress, seed: self.seed, solver: &self.solver };
        let outcome = search::run(&rules, first, model, &limits, &stop, &mut keeper);
        keeper.progress.finish();
        if outcome.is_err() && SAVED.load(Ordering::SeqCst) {
            output::note(&format!("the best so far is saved in {}", keeper.folder.path().display()));
        }
        let outcome = outcome.map_err(|failure| match failure {
            Failure::Expression(error) => Fault::input(load::no_value(&error, &sources)),
            Failure::Unfit(unfit) => Fault::input(unfit.reason),
            other => Fault::usage(other.to_string()),
        })?;
        let spent = format!(
            "{} evaluations, bodies: {}, in {}: {}",
            outcome.evaluations,
            outcome.bodies,
            span(started.elapsed()),
            outcome.end.text()
        );
        output::note(&spent);
        let tally = &outcome.tally;
        if tally.invalid() > 0 {
            output::note(&format!("{} evaluations had no value: {}", tally.invalid(), tally.reasons()));
        }
        if tally.unstable > 0 {
            let many = tally.unstable;
            output::note(&format!(
                "{many} would-be best gaits lost their value at half the step and were refused"
            ));
        }
        let Some(best) = &outcome.best else {
            if outcome.end == End::Interrupted {
                return Err(Fault {
                    code: exit::INTERRUPTED,
                    message: "interrupted before anything was found".to_owned(),
                });
            }
            return Err(Fault::input("no evaluation was valid: no feasible design was found"));
        };
        if outcome.bodies == 1 && outcome.moves > 0 && from.is_none() && !rules.rules.is_empty() {
            return Err(Fault::input(format!(
                "no rule could ever be applied to the initial design; {} says what blocked each",
                keeper.folder.path().join("evals.csv").display()
            )));
        }
        let mut design = keeper.saved(best).map_err(Fault::usage)?;
        if outcome.end != End::Interrupted {
            // The second opinion on the final best is kept beside the value; it takes some seconds.
            if !self.quiet {
                output::note("cross-checking the best design: rapier, other friction, masses and motors ...");
            }
            design =
                judge::final_check(&rules, &design, crate::simulate::Stop::NEVER).map_err(Fault::input)?;
            keeper.folder.best(&design).map_err(Fault::usage)?;
        }
        let early = matches!(outcome.end, End::Interrupted | End::Time);
        if early {
            output::note("stopped early; the best so far is saved");
        } else {
            keeper.folder.finish(&asked, &unit, &outcome).map_err(Fault::usage)?;
        }
        output::data(&judge::report(&rules, &design))?;
        output::note(&format!("look at it: sgc view {}", keeper.folder.path().display()));
        Ok(if early { exit::STOPPED } else { exit::DONE })
    }
}

/// Keeps what a search finds.
struct Keeper<'a> {
    rules: &'a RuleSet,
    grammar: Grammar,
    folder: RunFolder,
    progress: Progress,
    seed: u64,
    solver: &'a str,
}

impl Keeper<'_> {
    fn saved(&self, best: &Best) -> Result<crate::results::saved::SavedDesign, String> {
        judge::save(self.rules, self.grammar.clone(), self.seed, self.solver, best)
    }
}

impl Observer for Keeper<'_> {
    fn evaluated(&mut self, spent: u64, body: Option<f64>, _: f64) {
        self.progress.evaluated(spent, body);
    }

    fn moved(&mut self, row: &Row) -> Result<(), String> {
        self.progress.moved(row.number, row.best, row.temperature);
        self.folder.row(row)
    }

    fn improved(&mut self, best: &Best) -> Result<(), String> {
        self.folder.best(&self.saved(best)?)?;
        SAVED.store(true, Ordering::SeqCst);
        Ok(())
    }
}
