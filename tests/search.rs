//! The nested search: repeatable, whatever the number of threads.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use grammar_lang::ir::RuleSet;
use sgc::derive::{Derivation, Steps};
use sgc::search::{Best, End, Limits, Observer, Outcome, Row, State, go_on, run};
use sgc::simulate;

use crate::support::{compile_texts, texts};

/// `codesign` with a short motion, so that evaluations are cheap.
fn short() -> RuleSet {
    let mut texts = texts();
    let text = texts["grammars/codesign.sgr"].replace("for 20 s", "for 2 s");
    texts.insert("grammars/codesign.sgr".into(), text);
    compile_texts(&texts, "grammars/codesign.sgr").unwrap()
}

#[derive(Default)]
struct Log(Vec<String>);

impl Observer for Log {
    fn evaluated(&mut self, _: u64, _: Option<f64>, _: f64) {}
    fn moved(&mut self, row: &Row) -> Result<(), String> {
        self.0.push(format!("{row:?}"));
        Ok(())
    }
    fn improved(&mut self, best: &Best) -> Result<(), String> {
        self.0.push(format!("best {:x} {:?}", best.value.to_bits(), best.tasks));
        Ok(())
    }
}

fn search(rules: &RuleSet, seed: u64, jobs: usize, max: u64) -> (Outcome, Vec<String>) {
    let limits = Limits { seed, jobs, max_evaluations: Some(max), deadline: None };
    let mut log = Log::default();
    let model = simulate::model("articulated").unwrap();
    let outcome =
        run(rules, Derivation::begin(rules), model, &limits, &AtomicBool::new(false), &mut log).unwrap();
    (outcome, log.0)
}

#[test]
fn one_thread_and_three_give_the_same_bits() {
    let rules = short();
    let (one, log_one) = search(&rules, 2, 1, 300);
    let (three, log_three) = search(&rules, 2, 3, 300);
    assert_eq!(log_one, log_three);
    assert_eq!(one.evaluations, three.evaluations);
    let best = one.best.expect("a best design");
    assert!(
        best.value > 0.0 && !best.tasks[0].parameters.is_empty(),
        "the search got to tuning curves: {best:?}"
    );
    let other = search(&rules, 3, 1, 300);
    assert_ne!(log_one, other.1, "another seed is another search");
}

#[test]
fn a_best_keeps_its_value_at_half_the_step() {
    let rules = short();
    for seed in 1..5 {
        let best = search(&rules, seed, 2, 200).0.best.expect("a best design");
        if best.value > 0.0 && !best.tasks[0].parameters.is_empty() {
            let half = best.tasks[0].half_step.expect("was checked");
            assert!(half >= rules.search.keep * best.value, "{best:?}");
        }
    }
}

#[test]
fn the_budget_is_kept_and_told() {
    let (outcome, _) = search(&short(), 1, 2, 50);
    assert_eq!(outcome.end, End::Budget);
    // A check at half the step may come after the last evaluation.
    assert!((50..=51).contains(&outcome.evaluations), "{}", outcome.evaluations);
}

#[test]
fn a_body_without_actuators_costs_one_evaluation() {
    let mut texts = texts();
    let text = texts["grammars/codesign.sgr"]
        .replace("for 20 s", "for 2 s")
        .replace("param max_actuators : Count in 1 .. 16 = 8", "param max_actuators : Count in 0 .. 16 = 0");
    texts.insert("grammars/codesign.sgr".into(), text);
    let rules = compile_texts(&texts, "grammars/codesign.sgr").unwrap();
    let (outcome, log) = search(&rules, 1, 1, 30);
    let bodies = log.iter().filter(|row| row.contains("value: Some")).count();
    assert_eq!(outcome.evaluations as usize, bodies);
}

#[test]
fn the_inner_loop_stops_also_where_the_best_is_not_positive() {
    // An objective that is never positive: the stopping rule must still apply.
    let mut texts = texts();
    let text = texts["grammars/codesign.sgr"]
        .replace("for 20 s", "for 0.1 s")
        .replace("maximize travel - fall in cm", "maximize 0 cm - 100 * travel - fall in cm");
    texts.insert("grammars/codesign.sgr".into(), text);
    let rules = compile_texts(&texts, "grammars/codesign.sgr").unwrap();
    let (outcome, log) = search(&rules, 2, 2, 6000);
    let most = log
        .iter()
        .filter_map(|l| l.split("evaluations: ").nth(1)?.split(',').next()?.parse::<u64>().ok())
        .collect::<Vec<_>>()
        .windows(2)
        .map(|w| w[1] - w[0])
        .max()
        .unwrap();
    assert!(outcome.evaluations > 800, "{}", outcome.evaluations);
    // 150 iterations of at most 15 moves and a few more, not 300.
    assert!(most < 300 * 5, "an inner loop took {most} evaluations");
}

#[test]
fn minimising_the_negative_is_maximising() {
    let mut texts = texts();
    let text = texts["grammars/codesign.sgr"]
        .replace("for 20 s", "for 2 s")
        .replace("maximize travel - fall in cm", "minimize fall - travel in cm");
    texts.insert("grammars/codesign.sgr".into(), text);
    let rules = compile_texts(&texts, "grammars/codesign.sgr").unwrap();
    let best = search(&rules, 2, 2, 300).0.best.expect("a best design");
    assert!(best.value < -0.1, "{}", best.value);
    assert!(best.tasks[0].half_step.is_some_and(|half| sgc::search::keeps(
        &rules,
        &rules.tasks[0],
        best.value,
        half
    )));
}

#[test]
fn evaluations_without_a_value_are_counted_by_reason() {
    let mut texts = texts();
    let text = texts["std.models"].replace("speed_limit     = 10 m/s", "speed_limit     = 0.2 m/s");
    assert_ne!(text, texts["std.models"]);
    texts.insert("std.models".into(), text);
    let text = texts["grammars/codesign.sgr"].replace("for 20 s", "for 2 s");
    texts.insert("grammars/codesign.sgr".into(), text);
    let rules = compile_texts(&texts, "grammars/codesign.sgr").unwrap();
    let (outcome, log) = search(&rules, 2, 2, 150);
    let (tally, reasons) = (&outcome.tally, outcome.tally.reasons());
    assert!(tally.invalid() > 0, "a fifth of a metre a second is soon passed");
    assert_eq!(reasons, format!("{} too fast", tally.invalid()));
    assert!(log.iter().any(|row| row.contains("TooFast")));
}

/// Stops a search after every so many points that it could go on from, and keeps its state as text.
struct Stopper<'a> {
    rows: Vec<String>,
    flag: &'a AtomicBool,
    every: usize,
    seen: usize,
    kept: Option<String>,
}

impl Observer for Stopper<'_> {
    fn evaluated(&mut self, _: u64, _: Option<f64>, _: f64) {}
    fn moved(&mut self, row: &Row) -> Result<(), String> {
        self.rows.push(format!("{row:?}"));
        Ok(())
    }
    fn improved(&mut self, _: &Best) -> Result<(), String> {
        Ok(())
    }
    fn checkpoint(&mut self, state: &State, last: bool) -> Result<(), String> {
        if last {
            self.kept = Some(serde_json::to_string(&state.kept()).unwrap());
        }
        self.seen += 1;
        if self.seen.is_multiple_of(self.every) {
            self.flag.store(true, Ordering::Relaxed);
        }
        Ok(())
    }
}

/// Searches in as many sittings as it takes: how it ended, the rows, and the number of sittings.
fn in_sittings(
    rules: &RuleSet,
    seed: u64,
    every: usize,
    sitting: Option<Duration>,
) -> (Outcome, Vec<String>, usize) {
    let flag = AtomicBool::new(false);
    let mut stopper = Stopper { rows: Vec::new(), flag: &flag, every, seen: 0, kept: None };
    let model = simulate::model("articulated").unwrap();
    let mut state = State::begin(Derivation::begin(rules));
    for sittings in 1.. {
        flag.store(false, Ordering::Relaxed);
        let deadline = sitting.map(|time| Instant::now() + time);
        let limits = Limits { seed, jobs: 1 + sittings % 3, max_evaluations: Some(200), deadline };
        let outcome = go_on(rules, state, model, &limits, &flag, &mut stopper).unwrap();
        if !outcome.end.is_early() {
            return (outcome, stopper.rows, sittings);
        }
        let text = stopper.kept.take().expect("the state is kept when a search is stopped");
        let kept: State<Steps> = serde_json::from_str(&text).unwrap();
        assert_eq!(serde_json::to_string(&kept).unwrap(), text, "numbers are read back exactly");
        state = kept.restore(rules).unwrap();
    }
    unreachable!()
}

fn same_end(rules: &RuleSet, seed: u64, every: usize, sitting: Option<Duration>) -> usize {
    let (whole, rows, sittings) = in_sittings(rules, seed, usize::MAX, None);
    assert_eq!(sittings, 1);
    let (pieces, again, sittings) = in_sittings(rules, seed, every, sitting);
    assert_eq!(again, rows, "every {every}");
    assert_eq!(pieces.best, whole.best);
    let counts = |o: &Outcome| (o.evaluations, o.moves, o.bodies, o.tally.clone(), o.end);
    assert_eq!(counts(&pieces), counts(&whole));
    assert!(whole.best.is_some());
    sittings
}

#[test]
fn a_search_in_pieces_is_the_same_search() {
    let rules = short();
    // How many batches there are depends on the lanes of the processor.
    for (every, least) in [(1, 30), (4, 8), (15, 2)] {
        let sittings = same_end(&rules, 2, every, None);
        assert!(sittings >= least, "{sittings} sittings, every {every}");
    }
    let (whole, rows, _) = in_sittings(&rules, 2, usize::MAX, None);
    assert!(whole.best.is_some_and(|best| best.value > 0.0), "the search got to tuning curves");
    assert!(rows.iter().any(|row| row.contains("\"undo\"")), "steps were taken back, too");
}

#[test]
fn several_tasks_in_pieces_are_the_same_search() {
    let mut texts = texts();
    let text = texts["grammars/steering.sgr"].replace("for 20 s", "for 1 s");
    texts.insert("grammars/steering.sgr".into(), text);
    let rules = compile_texts(&texts, "grammars/steering.sgr").unwrap();
    assert!(rules.tasks.len() > 1);
    assert!(same_end(&rules, 3, 9, None) > 2);
}

#[test]
fn what_has_no_value_is_counted_on_in_pieces() {
    let mut texts = texts();
    let text = texts["grammars/codesign.sgr"]
        .replace("for 20 s", "for 1 s")
        .replace("maximize travel - fall in cm", "maximize travel / (count(part) - 3) in cm")
        .replace("require whole          : connected", "require whole : 1 / (count(part) - 4) < 2");
    texts.insert("grammars/codesign.sgr".into(), text);
    let rules = compile_texts(&texts, "grammars/codesign.sgr").unwrap();
    assert!(same_end(&rules, 2, 5, None) > 2);
    let tally = in_sittings(&rules, 2, usize::MAX, None).0.tally;
    assert!(!tally.no_value.is_empty() && !tally.refused.is_empty(), "{tally:?}");
}

#[test]
fn a_batch_that_was_given_up_leaves_no_trace() {
    // Sittings end in the middle of simulations.
    assert!(same_end(&short(), 2, usize::MAX, Some(Duration::from_millis(25))) > 5);
}
