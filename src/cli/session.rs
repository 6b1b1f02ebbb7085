//! One run, from where it stands to its end or until it is stopped.

use super::work::Work;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use grammar_lang::ir::RuleSet;
use grammar_lang::source::SourceMap;

use super::live::Live;
use super::output::{self, Fault};
use super::progress::{Progress, span};
use super::{exit, interrupt, load};
use crate::results::DesignError;
use crate::results::folder::{Reopened, RunFolder};
use crate::results::processes::Processes;
use crate::results::saved::{Grammar, SavedDesign};
use crate::results::verdict::stands_still;
use crate::results::{archive, front, leftovers, robustness, saving, summary};
use crate::search::{self, Best, End, Failure, Jobs, Limits, Observer, Outcome, Row, State, Unkept};
use crate::simulate::{self, Stop};

/// A run that is to go on.
pub(super) struct Session<'a> {
    pub(super) run: Reopened,
    pub(super) work: Work,
    pub(super) jobs: Jobs,
    pub(super) deadline: Option<Instant>,
    /// Whether it tells people what it does.
    pub(super) told: bool,
    /// The page that follows it, if one is wanted.
    pub(super) live: Option<&'a Live>,
}

/// How a session ended.
pub(super) struct Ended {
    pub(super) rules: RuleSet,
    pub(super) path: PathBuf,
    pub(super) outcome: Outcome,
    /// The best design; none only if the session was stopped before there was one.
    pub(super) design: Option<SavedDesign>,
    /// Whether it was stopped, with a checkpoint.
    pub(super) is_early: bool,
}

impl Session<'_> {
    pub(super) fn go(self, flag: &AtomicBool) -> Result<Ended, Fault> {
        let Self { run, work, jobs, deadline, told, live } = self;
        let Reopened { folder, asked, grammar, rules, sources, state, max_evals } = run;
        let started = Instant::now();
        let model = simulate::model(&asked.solver).ok_or_else(|| Fault::usage("unknown solver"))?;
        if !folder.is_replacing() {
            interrupt::saved(folder.path());
        }
        deadline.into_iter().for_each(interrupt::cut_after);
        let threads = jobs.now();
        let limits = Limits {
            seed: asked.seed,
            jobs,
            max_evaluations: max_evals,
            lanes: None,
            gives_up: true,
            deadline,
        };
        let unit = rules.objective.unit.clone();
        let quiet = work.quiet || !told;
        let before = state.spent();
        let mut progress = Progress::new(before, max_evals, deadline, &unit, quiet);
        progress.moved(state.moves(), state.best().map(|best| best.value), 0.0);
        let processes = Processes::begin(folder.path(), before, threads);
        let mut keeper = Keeper {
            rules: &rules,
            grammar,
            folder,
            progress,
            seed: asked.seed,
            solver: &asked.solver,
            max_evals,
            every: work.checkpoint.1,
            kept: Instant::now(),
            processes,
            live,
        };
        if let Some(best) = state.best()
            && !keeper.folder.best_path().exists()
        {
            keeper.improved(best).map_err(Fault::usage)?;
        }
        keeper.archive_again(state.archive())?;
        keeper.front_again(&state.front().cloned().collect::<Vec<_>>())?;
        let cuttable = interrupt::Cuttable::begin();
        let outcome = search::go_on(&rules, state, model, &limits, flag, &mut keeper);
        drop(cuttable);
        keeper.progress.finish();
        let path = keeper.folder.path().to_owned();
        let outcome = outcome.map_err(|failure| keeper.failed(failure, &sources))?;
        // A run that found nothing gives its place back to the older one.
        if !keeper.folder.is_replacing() {
            keeper.folder.check_here().map_err(Fault::usage)?;
            keeper.processes.note(outcome.evaluations).map_err(Fault::usage)?;
        }
        if told {
            account(&outcome, before, started.elapsed(), &sources);
        }
        if outcome.end.is_early() {
            if keeper.folder.is_replacing() {
                return Err(Fault {
                    code: exit::INTERRUPTED,
                    message: "stopped before anything was found; the older run is back".to_owned(),
                });
            }
            return keeper.stopped(outcome);
        }
        let nothing = match &outcome.best {
            // The gaits of one task may have taken all of the evaluations.
            None if rules.tasks.len() > 1
                && outcome.end == End::Budget
                && outcome.tally.invalid() + outcome.tally.unstable == 0 =>
            {
                Some(format!(
                "the evaluations were spent before each of the {} tasks had a gait: begin anew with more (--max-evals), or with a search that tries fewer curves for each task",
                rules.tasks.len()
            ))
            }
            None if outcome.tally.invalid() == 0 => Some(
                "no gait kept its value in a finer simulation: no feasible design was found. A robot that hardly moves \
                 has a value that is only rounding error"
                    .to_owned(),
            ),
            None if outcome.tally.unstable > 0 => Some(
                "no feasible design was found: every design that had a value lost it in a finer simulation".to_owned(),
            ),
            None => Some("no evaluation was valid: no feasible design was found".to_owned()),
            Some(_)
                if is_stuck_at_the_start(
                    &rules,
                    &outcome,
                    asked.from.as_deref().or(asked.design.as_deref()),
                ) =>
            {
                Some(format!(
                    "no rule could ever be applied to the initial design; {} says what blocked each rule",
                    path.join("evals.csv").display()
                ))
            }
            Some(_) => None,
        };
        if let Some(nothing) = nothing {
            keeper.folder.finish(&asked, &rules, &outcome, (max_evals, None)).map_err(Fault::usage)?;
            return Err(Fault::input(nothing));
        }
        let stop = Stop::new(flag, deadline);
        let Some(design) = keeper.checked(&outcome, (stop, &limits.jobs), quiet)? else {
            let end = if stop.is_interrupted() { End::Interrupted } else { End::Time };
            return keeper.stopped(Outcome { end, ..outcome });
        };
        keeper.folder.best(&design).map_err(Fault::usage)?;
        keeper.archive_again(&outcome.archive)?;
        keeper.front_again(&outcome.front)?;
        keeper.folder.finish(&asked, &rules, &outcome, (max_evals, Some(&design))).map_err(Fault::usage)?;
        drop(keeper);
        Ok(Ended { rules, path, outcome, design: Some(design), is_early: false })
    }
}

/// What is said of a best that does not move.
pub(super) const NOTHING_FOUND: &str = "this robot does no better than one that stands still: docs/search.md says what to try when a run finds nothing";

/// Tells people what a search did since it had spent so many evaluations.
fn account(outcome: &Outcome, before: u64, took: Duration, sources: &SourceMap) {
    let all = outcome.evaluations;
    let some = all.saturating_sub(before);
    let now = if some < all { format!(" ({some} now)") } else { String::new() };
    output::note(&format!(
        "{}{now}, bodies: {}, in {}: {}",
        output::counted(all as usize, "evaluation"),
        outcome.bodies,
        span(took),
        outcome.end.text()
    ));
    let tally = &outcome.tally;
    if tally.invalid() > 0 {
        let many = output::counted(tally.invalid() as usize, "evaluation");
        output::note(&format!("{many} had no value: {}", tally.reasons()));
    }
    if !tally.elsewhere.is_empty() {
        output::note(&format!("worlds without a value: {}", tally.worlds().join(", ")));
    }
    if let Some((many, reason)) = &tally.unfit {
        output::note(&format!("warning: {many} bodies could not be simulated; the first: {reason}"));
    }
    for (error, many) in &tally.no_value {
        let place = load::no_value(error, sources);
        output::note(&format!("warning: {place}, in {many} evaluations"));
    }
    for (error, many) in &tally.refused {
        let place = load::no_value(error, sources);
        output::note(&format!("warning: {place}; {many} moves were refused because of it"));
    }
    if tally.hopeless > 0 {
        let many = tally.hopeless;
        output::note(&format!(
            "{many} evaluations could not reach a value that would be accepted, as was clear before they ended"
        ));
    }
    if tally.unstable > 0 {
        let many = tally.unstable;
        output::note(&format!(
            "{} looked like a new best, lost {} value in a finer simulation, and {} refused",
            output::counted(many as usize, "gait"),
            if many == 1 { "its" } else { "their" },
            if many == 1 { "was" } else { "were" },
        ));
        if let Some(first) = &tally.first_unstable {
            output::note(&format!("the first of them: {first}"));
        }
    }
}

/// Whether nothing but the initial design was ever there, though rules were drawn.
fn is_stuck_at_the_start(rules: &RuleSet, outcome: &Outcome, from: Option<&str>) -> bool {
    // Where designs are kept, a move may tune one of them further and draw no rule.
    let draws = rules.search.population().is_none() && rules.search.front().is_none();
    let drawn = outcome.end == End::Stuck || draws && outcome.moves > 0;
    outcome.bodies == 1 && drawn && from.is_none() && !rules.rules.is_empty()
}

impl Ended {
    /// Tells people how it ended; the exit code.
    pub(super) fn tell(&self) -> Result<u8, Fault> {
        let path = &self.path;
        let report = self.design.as_ref().map(|design| summary::report(&self.rules, design));
        if self.is_early {
            // Whether anybody still reads makes no difference: all is saved.
            let _ = output::data(&report.unwrap_or_default());
            output::note(&format!("stopped; go on with: sgc resume {}", output::typed(path)));
            return Ok(exit::STOPPED);
        }
        output::data(&report.unwrap_or_default())?;
        if let Some(table) = archive::told(path) {
            output::note(&table);
        }
        if !self.outcome.front.is_empty() {
            output::note(&front::told(path, &self.rules, &self.outcome.front));
        }
        let is_still = |design: &SavedDesign| stands_still(&self.rules, design);
        if self.design.as_ref().is_some_and(is_still) {
            output::note(NOTHING_FOUND);
        }
        output::note(&format!("look at it: sgc view {}", output::typed(path)));
        for older in leftovers::left(path) {
            let older = older.display();
            output::note(&format!(
                "{older} is an older run that was to be replaced; remove it if you do not need it"
            ));
        }
        Ok(exit::DONE)
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
    max_evals: Option<u64>,
    /// How often a checkpoint is saved, and when the last one was.
    every: Duration,
    kept: Instant,
    processes: Processes,
    live: Option<&'a Live>,
}

impl Keeper<'_> {
    fn saved(&self, best: &Best) -> Result<SavedDesign, DesignError> {
        saving::save(self.rules, self.grammar.clone(), self.seed, self.solver, best)
    }

    /// Why a search failed, with what is left of it.
    fn failed(&self, failure: Failure, sources: &SourceMap) -> Fault {
        let path = self.folder.path();
        let lost = matches!(failure, Failure::Output(_));
        if lost && self.folder.check_here().is_err() {
            // Nobody knows where it is now: the failure itself tells.
        } else if lost && !self.folder.is_replacing() {
            let path = output::typed(path);
            output::note(&format!(
                "the last saved state is intact; when files can be written again, go on with: sgc resume {path}"
            ));
        } else if self.folder.best_path().exists() && !self.folder.is_replacing() {
            output::note(&format!("the best so far is saved in {}", path.display()));
        }
        match failure {
            Failure::Expression(error) => Fault::input(load::no_value(&error, sources)),
            Failure::Unfit(unfit) => Fault::input(unfit.reason),
            Failure::NoDeviation(_) => Fault::input(failure.to_string()),
            other => Fault::usage(other.to_string()),
        }
    }

    /// The final best with its cross-checks; none if they were stopped.
    fn checked(
        &mut self,
        outcome: &Outcome,
        (stop, jobs): (Stop<'_>, &Jobs),
        quiet: bool,
    ) -> Result<Option<SavedDesign>, Fault> {
        let best = outcome.best.as_ref().ok_or_else(|| Fault::input("no feasible design was found"))?;
        let design = self.saved(best).map_err(Fault::usage)?;
        // The second opinion on the final best is kept beside the value; it takes some seconds.
        if !quiet {
            output::note(
                "cross-checking the best design: finer steps, ice, another solver, other worlds ...",
            );
        }
        let cuttable = interrupt::Cuttable::begin();
        let checked = jobs.run(|| robustness::final_check(self.rules, &design, stop));
        drop(cuttable);
        match checked.map_err(|failure| Fault::usage(failure.to_string()))? {
            Ok(design) => Ok(Some(design)),
            // The checkpoint is of before the end of the search.
            Err(_) if stop.is_asked() => Ok(None),
            Err(reason) => Err(Fault::input(reason)),
        }
    }

    /// Writes the designs of an archive that are not in the folder as the search left them.
    fn archive_again(&mut self, archive: &[(Vec<usize>, Best)]) -> Result<(), Fault> {
        for lost in self.folder.lost(self.rules, archive) {
            self.kept(archive, lost).map_err(Fault::usage)?;
        }
        Ok(())
    }

    /// Writes the designs of a front that are not in the folder as the search left them.
    fn front_again(&mut self, designs: &[Best]) -> Result<(), Fault> {
        let Some(lost) = self.folder.lost_of_front(self.rules, designs) else { return Ok(()) };
        for best in lost.into_iter().filter_map(|place| designs.get(place)) {
            let design = self.saved(best).map_err(Fault::usage)?;
            self.folder.on_front(best, &design).map_err(Fault::usage)?;
        }
        self.folder.front(self.rules, designs, (self.seed, &self.grammar.rules)).map_err(Fault::usage)
    }

    /// The end of a session that can be gone on with.
    fn stopped(self, outcome: Outcome) -> Result<Ended, Fault> {
        let design = match &outcome.best {
            Some(_) => Some(SavedDesign::read(&self.folder.best_path()).map_err(Fault::usage)?),
            None => None,
        };
        let path = self.folder.path().to_owned();
        Ok(Ended { rules: self.rules.clone(), path, outcome, design, is_early: true })
    }
}

impl Observer for Keeper<'_> {
    fn evaluated(&mut self, spent: u64, body: Option<f64>, _: f64) {
        self.progress.evaluated(spent, body);
    }

    fn moved(&mut self, row: &Row) -> Result<(), Unkept> {
        self.progress.moved(row.number, row.best, row.temperature);
        self.folder.row(row)?;
        if let Some(live) = self.live {
            live.follow();
        }
        Ok(())
    }

    fn improved(&mut self, best: &Best) -> Result<(), Unkept> {
        self.folder.best(&self.saved(best)?)?;
        interrupt::saved(self.folder.path());
        Ok(())
    }

    fn kept(&mut self, archive: &[(Vec<usize>, Best)], new: usize) -> Result<(), Unkept> {
        let Some((cell, best)) = archive.get(new) else { return Ok(()) };
        let design = self.saved(best)?;
        Ok(self.folder.kept(self.rules, archive, cell, &design)?)
    }

    fn on_front(&mut self, designs: &[Best]) -> Result<(), Unkept> {
        for best in designs {
            if !self.folder.has_on_front(best) {
                let design = self.saved(best)?;
                self.folder.on_front(best, &design)?;
            }
        }
        Ok(self.folder.front(self.rules, designs, (self.seed, &self.grammar.rules))?)
    }

    fn checkpoint(&mut self, state: &State, last: bool) -> Result<(), Unkept> {
        if last || self.kept.elapsed() >= self.every {
            self.folder.checkpoint(self.rules, state, self.max_evals)?;
            self.processes.note(state.spent())?;
            self.kept = Instant::now();
        }
        Ok(())
    }
}
