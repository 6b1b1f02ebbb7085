//! The nested search: repeatable, whatever the number of threads.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use grammar_lang::ir::RuleSet;
use sgc::derive::{Candidate, Derivation, Steps};
use sgc::drive::Drive;
use sgc::score::{self, Recording};
use sgc::search::{Best, End, Jobs, Limits, Observer, Outcome, Row, State, Unkept, go_on, run};
use sgc::simulate::{self, Stop, World};

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
    fn moved(&mut self, row: &Row) -> Result<(), Unkept> {
        self.0.push(format!("{row:?}"));
        Ok(())
    }
    fn improved(&mut self, best: &Best) -> Result<(), Unkept> {
        self.0.push(format!("best {:x} {:?}", best.value.to_bits(), best.tasks));
        Ok(())
    }
}

pub(crate) fn search(rules: &RuleSet, seed: u64, jobs: usize, max: u64) -> (Outcome, Vec<String>) {
    search_from(rules, State::begin(Derivation::begin(rules)), seed, jobs, max)
}

/// A search that goes on from a state.
pub(crate) fn search_from(
    rules: &RuleSet,
    state: State,
    seed: u64,
    jobs: usize,
    max: u64,
) -> (Outcome, Vec<String>) {
    let limits = Limits {
        seed,
        jobs: Jobs::new(jobs),
        max_evaluations: Some(max),
        lanes: None,
        gives_up: true,
        deadline: None,
    };
    let mut log = Log::default();
    let model = simulate::model("articulated").unwrap();
    let outcome = go_on(rules, state, model, &limits, &AtomicBool::new(false), &mut log).unwrap();
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
fn a_body_without_actuators_costs_one_evaluation_and_one_more_where_it_is_better_than_at_rest() {
    let mut texts = texts();
    let text = texts["grammars/codesign.sgr"]
        .replace("for 20 s", "for 2 s")
        .replace("param max_actuators : Count in 1 .. 16 = 8", "param max_actuators : Count in 0 .. 16 = 0");
    texts.insert("grammars/codesign.sgr".into(), text);
    let rules = compile_texts(&texts, "grammars/codesign.sgr").unwrap();
    let (outcome, log) = search(&rules, 1, 1, 30);
    let bodies = log.iter().filter(|row| row.contains("value: Some")).count();
    let checked = outcome.evaluations as usize - bodies;
    assert!(checked >= 1 && 4 * checked < bodies, "{checked} of {bodies}");
}

#[test]
fn the_inner_loop_stops_also_where_the_best_is_not_positive() {
    // An objective that is never positive: the stopping rule must still apply.
    let mut texts = texts();
    let text = texts["grammars/codesign.sgr"]
        .replace("for 20 s", "for 0.5 s")
        .replace("maximize travel - fall in cm", "maximize 0 cm - travel - fall in cm");
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
    assert!(most < 300 * 5, "a loop over curves took {most} evaluations");
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
        rules.tasks[0].objective.direction,
        0.0,
        rules.search.keep,
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
    fn moved(&mut self, row: &Row) -> Result<(), Unkept> {
        self.rows.push(format!("{row:?}"));
        Ok(())
    }
    fn improved(&mut self, _: &Best) -> Result<(), Unkept> {
        Ok(())
    }
    fn checkpoint(&mut self, state: &State, last: bool) -> Result<(), Unkept> {
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

/// Searches in as many processes as it takes: how it ended, the rows, and the number of processes.
fn in_processes(
    rules: &RuleSet,
    seed: u64,
    every: usize,
    process: Option<Duration>,
) -> (Outcome, Vec<String>, usize) {
    let flag = AtomicBool::new(false);
    let mut stopper = Stopper { rows: Vec::new(), flag: &flag, every, seen: 0, kept: None };
    let model = simulate::model("articulated").unwrap();
    let mut state = State::begin(Derivation::begin(rules));
    for processes in 1.. {
        flag.store(false, Ordering::Relaxed);
        let deadline = process.map(|time| Instant::now() + time);
        let limits = Limits {
            seed,
            jobs: Jobs::new(1 + processes % 3),
            max_evaluations: Some(200),
            lanes: None,
            gives_up: true,
            deadline,
        };
        let outcome = go_on(rules, state, model, &limits, &flag, &mut stopper).unwrap();
        if !outcome.end.is_early() {
            return (outcome, stopper.rows, processes);
        }
        let text = stopper.kept.take().expect("the state is kept when a search is stopped");
        let kept: State<Steps> = serde_json::from_str(&text).unwrap();
        assert_eq!(serde_json::to_string(&kept).unwrap(), text, "numbers are read back exactly");
        state = kept.restore(rules).unwrap();
    }
    unreachable!()
}

pub(crate) fn same_end(rules: &RuleSet, seed: u64, every: usize, process: Option<Duration>) -> usize {
    let (whole, rows, processes) = in_processes(rules, seed, usize::MAX, None);
    assert_eq!(processes, 1);
    let (pieces, again, processes) = in_processes(rules, seed, every, process);
    assert_eq!(again, rows, "every {every}");
    assert_eq!(pieces.best, whole.best);
    let counts = |o: &Outcome| (o.evaluations, o.moves, o.bodies, o.tally.clone(), o.end);
    assert_eq!(counts(&pieces), counts(&whole));
    assert!(whole.best.is_some());
    processes
}

#[test]
fn a_search_in_pieces_is_the_same_search() {
    let rules = short();
    // How many batches there are depends on the lanes of the processor.
    for (every, least) in [(1, 30), (4, 8), (15, 2)] {
        let processes = same_end(&rules, 2, every, None);
        assert!(processes >= least, "{processes} processes, every {every}");
    }
    let (whole, rows, _) = in_processes(&rules, 2, usize::MAX, None);
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
    let tally = in_processes(&rules, 2, usize::MAX, None).0.tally;
    assert!(!tally.no_value.is_empty() && !tally.refused.is_empty(), "{tally:?}");
}

/// The curves of a body of four actuators, with a pace limit.
fn paced(limit: &str) -> RuleSet {
    let mut texts = texts();
    texts.insert("grammars/bodies.sgr".into(), {
        let text = crate::support::read("benches/bodies/bodies.sgr");
        text.replace("../../grammars/experiments/codesign_thesis.sgr", "./codesign.sgr")
            .replace("from two", "from four")
    });
    let text = texts["grammars/codesign.sgr"].replace("for 20 s", "for 12 s");
    texts.insert("grammars/codesign.sgr".into(), text);
    let text = texts["std.models"]
        .replace("speed_limit     = 10 m/s", &format!("pace_limit = {limit}\n  speed_limit     = 10 m/s"));
    assert_ne!(text, texts["std.models"]);
    texts.insert("std.models".into(), text);
    let text = texts["std.search"].replace("cauchy(9, 0.1, iteration)", "1");
    texts.insert("std.search".into(), text);
    compile_texts(&texts, "grammars/bodies.sgr").unwrap()
}

#[test]
fn giving_up_what_cannot_come_to_enough_changes_nothing() {
    // At 5 cm/s some motions are too fast, so that what is given up might have been invalid, too.
    for (limit, are_invalid) in [("20 cm/s", false), ("5 cm/s", true)] {
        let rules = paced(limit);
        let go = |gives_up, jobs| {
            let limits = Limits {
                seed: 2,
                jobs: Jobs::new(jobs),
                max_evaluations: Some(200),
                lanes: None,
                gives_up,
                deadline: None,
            };
            let mut log = Log::default();
            let model = simulate::model("articulated").unwrap();
            let flag = AtomicBool::new(false);
            let first = Derivation::start(&rules, rules.from.as_deref()).unwrap();
            let outcome = run(&rules, first, model, &limits, &flag, &mut log).unwrap();
            (outcome.best, outcome.tally, outcome.evaluations, log.0)
        };
        let without = go(false, 1);
        assert!(without.1.hopeless > 10, "{:?}", without.1);
        assert_eq!(without.1.invalid() > 0, are_invalid, "{:?}", without.1);
        assert_eq!(go(true, 3), without);
    }
}

/// `codesign` with a short motion and another search, whose fields stand two spaces apart.
fn with_search(search: &str) -> RuleSet {
    let search = search.replace("  ", "\n");
    let mut texts = texts();
    let text = texts["grammars/codesign.sgr"]
        .replace("for 20 s", "for 1 s")
        .replace("use std.search     { nested_annealing }", "use std.search { cauchy, reheated, geometric }")
        .replace(
            "search   nested_annealing",
            &format!("search quick\nsearch quick {{ keep = 80 %\n{search} }}"),
        );
    texts.insert("grammars/codesign.sgr".into(), text);
    compile_texts(&texts, "grammars/codesign.sgr").unwrap()
}

const BODIES: &str = "bodies annealing { iterations = 50  moves = 3  temperature = 9  stop = false }";

/// It goes the same way with any number of threads, in one process or in many.
fn is_repeatable(rules: &RuleSet) -> (Outcome, Vec<String>) {
    assert!(same_end(rules, 2, 3, None) > 2);
    let (one, log) = search(rules, 2, 1, 300);
    let (three, log_three) = search(rules, 2, 3, 300);
    assert_eq!(log, log_three);
    assert_eq!((one.evaluations, &one.best), (three.evaluations, &three.best));
    assert!(one.best.as_ref().is_some_and(|best| best.value > 0.0), "{:?}", one.best);
    (one, log)
}

#[test]
fn chains_of_curves_take_turns_and_change_places() {
    let rules = with_search(&format!(
        "{BODIES} curves annealing {{ iterations = 5  moves = 3  stop = false  walk = 7  chains = 5  exchange = true
           temperature = geometric(deviation, 1.5, chain) }}"
    ));
    is_repeatable(&rules);
    // A walk of seven, five starts, and fifteen rounds of five, but for checks at half the step.
    let apart = with_search(&format!(
        "{BODIES} curves annealing {{ iterations = 5  moves = 3  stop = false  walk = 7  chains = 5
           temperature = geometric(deviation, 1.5, chain) }}"
    ));
    assert_ne!(search(&rules, 2, 2, 300).1, search(&apart, 2, 2, 300).1, "exchanges change what is found");
}

#[test]
fn what_was_foreseen_wrongly_changes_nothing() {
    // Two moves an iteration, so that most futures lie in iterations to come, whose temperatures depend on what is
    // accepted until then; and what stops depends on it, too.
    let rules = with_search(&format!(
        "{BODIES} curves annealing {{ iterations = 40  moves = 2  stop = stagnant >= 3  
           temperature = if refused >= 2 then 9 + temperature else 0.1 + best / 10 }}"
    ));
    let go = |lanes, jobs| {
        let limits = Limits {
            seed: 4,
            jobs: Jobs::new(jobs),
            max_evaluations: Some(500),
            lanes,
            gives_up: true,
            deadline: None,
        };
        let mut log = Log::default();
        let model = simulate::model("articulated").unwrap();
        let flag = AtomicBool::new(false);
        let outcome = run(&rules, Derivation::begin(&rules), model, &limits, &flag, &mut log).unwrap();
        (outcome.best, outcome.tally, outcome.evaluations, log.0)
    };
    let plain = go(Some(1), 1);
    assert!(plain.0.as_ref().is_some_and(|best| best.value > 0.0), "{:?}", plain.0);
    assert_eq!(go(None, 1), plain);
    assert_eq!(go(None, 3), plain);
}

#[test]
fn chains_of_bodies_take_turns_after_a_random_walk() {
    let rules = with_search(
        "bodies annealing { iterations = 50  moves = 2  stop = false  walk = 6  chains = 3  exchange = iteration > 1
                 temperature = reheated(cauchy(deviation, 0.2, iteration), 3, deviation, 9) }
         curves annealing { iterations = 2  moves = 2  temperature = 1  stop = false }",
    );
    let (_, log) = is_repeatable(&rules);
    let chain = |row: &String| row.split("chain: ").nth(1)?.split(',').next()?.parse::<usize>().ok();
    let chains: Vec<usize> = log.iter().filter_map(chain).collect();
    let turns = chains.iter().position(|chain| *chain == 1).expect("a second chain") - 1;
    assert!(chains[..turns].iter().all(|chain| *chain == 0), "the walk is one of the first chain");
    assert!(chains[turns..].iter().zip((0..3).cycle()).all(|(a, b)| *a == b), "{chains:?}");
    let temperature =
        |row: &String| row.split("temperature: ").nth(1)?.split(',').next()?.parse::<f64>().ok();
    let temperatures: Vec<f64> = log.iter().filter_map(temperature).collect();
    assert!(temperatures[..turns].iter().all(|t| *t == 0.0) && temperatures[turns] > 0.0, "{temperatures:?}");
}

#[test]
fn a_walk_among_equals_says_that_no_temperature_follows() {
    let rules = with_search(
        "bodies annealing { iterations = 50  moves = 2  stop = false  walk = 3  temperature = deviation }",
    );
    let mut equal = rules.clone();
    let zero = &mut equal.tasks[0].objective.value;
    zero.kind = grammar_lang::ir::ExprKind::Number(0.0);
    let limits = Limits {
        seed: 1,
        jobs: Jobs::new(1),
        max_evaluations: Some(50),
        lanes: None,
        gives_up: true,
        deadline: None,
    };
    let model = simulate::model("articulated").unwrap();
    let flag = AtomicBool::new(false);
    let failure = run(&equal, Derivation::begin(&equal), model, &limits, &flag, &mut Log::default());
    assert!(failure.unwrap_err().to_string().contains("the random walk found 3 designs of the same value"));
}

#[test]
fn curves_evolve_and_begin_warm() {
    let inner =
        "curves cma_es { iterations = 6  moves = 8  stop = false  spread = 30 %   restart = iteration == 3";
    let cold = with_search(&format!("{BODIES} {inner} }}"));
    let warm = with_search(&format!("{BODIES} {inner}  warm = true }}"));
    let (_, log_cold) = is_repeatable(&cold);
    let (_, log_warm) = is_repeatable(&warm);
    assert_ne!(log_cold, log_warm, "warm starts change what is found");
}

#[test]
fn the_best_of_each_kind_is_kept() {
    let rules = with_search(
        "bodies archive { iterations = 50  moves = 3  stop = false
                 descriptors { size { value = count(part)  from = 1  to = 11  cells = 5 }
                           sinks { value = fall  from = 0 cm  to = 2 cm  cells = 2 } } }
         curves cma_es { iterations = 2  moves = 6  stop = false  warm = true  spread = 30 % }",
    );
    let (_, log) = is_repeatable(&rules);
    // What is kept is a new kind or better than what was of its kind.
    let accepted = log.iter().filter(|row| row.contains("accepted: true")).count();
    assert!(accepted > 3, "{log:#?}");
}

const POPULATION: &str = "bodies population { iterations = 500  moves = 3  stop = false  size = 5  tournament = 2  further = 40 % }";

#[test]
fn the_best_bodies_are_kept_and_tuned_further() {
    let rules = with_search(&format!(
        "{POPULATION} curves cma_es {{ iterations = if tuned == 0 then 1 else 3  moves = 6  stop = false
           warm = true  spread = 15 % }}"
    ));
    let (_, log) = is_repeatable(&rules);
    let rows: Vec<&String> = log.iter().filter(|row| row.starts_with("Row")).collect();
    let of = |row: &str, field: &str| row.split(&format!(" {field}: ")).nth(1).map(str::to_owned);
    let further: Vec<&&String> =
        rows.iter().filter(|row| !of(row, "tuned").is_some_and(|times| times.starts_with('0'))).collect();
    assert!(further.len() > 3, "{log:#?}");
    for row in &further {
        assert!(row.contains("rule: None"), "what is tuned further is not changed: {row}");
    }
    assert!(further.iter().any(|row| row.contains("tuned: 2")), "it goes on from where it stands: {log:#?}");
    // Three generations of six, and checks at half the step of what would be better.
    let spent = |row: &str| of(row, "evaluations")?.split(',').next()?.parse::<u64>().ok();
    for pair in rows.windows(2) {
        let costs = spent(pair[1]).unwrap() - spent(pair[0]).unwrap();
        let is_last = pair[1] == rows[rows.len() - 1];
        if pair[1].contains("rule: None") && !pair[1].contains("tuned: 0") && !is_last {
            assert!((18..=30).contains(&costs), "{costs} evaluations: {}", pair[1]);
        }
    }
}

/// The parent of each move, by the number of the move.
fn parents(rules: &RuleSet) -> Vec<(usize, usize)> {
    let (one, log) = search(rules, 5, 1, 400);
    for jobs in [2, 5] {
        let (other, rows) = search(rules, 5, jobs, 400);
        assert_eq!(log, rows, "{jobs} threads");
        assert_eq!(one.best.as_ref().map(|best| best.value), other.best.map(|best| best.value));
    }
    let number =
        |row: &str, field: &str| row.split(field).nth(1)?.split([',', ')']).next()?.parse::<usize>().ok();
    log.iter()
        .filter_map(|row| Some((number(row, "Row { number: ")?, number(row, "parent: Some(")?)))
        .collect()
}

/// Moves that go on side by side do not know what became of each other.
#[test]
fn a_move_begins_with_what_was_kept_before_those_beside_it() {
    for side_by_side in [1, 4] {
        let own = format!("further = 40 %  side_by_side = {side_by_side}");
        let moves = POPULATION.replace("further = 40 %", &own);
        let rules = with_search(&format!(
            "{moves} curves cma_es {{ iterations = 1  moves = 4  stop = false  warm = true  spread = 15 % }}"
        ));
        let parents = parents(&rules);
        assert!(parents.len() > 30, "{parents:?}");
        for (number, parent) in &parents {
            assert!(*parent == 0 || parent + side_by_side <= *number, "move {number} begins with {parent}");
        }
        let found = parents.iter().filter(|(_, parent)| *parent > 0);
        let nearest = found.map(|(number, parent)| number - parent).min();
        assert_eq!(nearest, Some(side_by_side), "{parents:?}");
    }
}

/// `iteration`, `best`, `gain` and `idle` count anew with the population; the best of the run is kept.
#[test]
fn a_population_begins_anew_with_the_initial_design() {
    let anew = POPULATION.replace("further = 40 %", "further = 40 %  restart = iteration == 3");
    let rules = with_search(&format!(
        "{anew} curves cma_es {{ iterations = 1  moves = 4  stop = false  warm = true  spread = 15 % }}"
    ));
    let (_, log) = is_repeatable(&rules);
    let rows: Vec<&String> = log.iter().filter(|row| row.starts_with("Row")).collect();
    assert!(rows.len() > 20, "{log:#?}");
    for (number, row) in rows.iter().enumerate().skip(2) {
        let is_first = number % 9 == 1;
        assert!(!is_first || row.contains("parent: Some(0)"), "nothing else is there: {row}");
        assert!(number % 9 > 6 || !is_first || row.contains("tuned: 0"), "{row}");
    }
    let best = |row: &str| row.split(" best: Some(").nth(1)?.split(')').next()?.parse::<f64>().ok();
    let bests: Vec<f64> = rows.iter().filter_map(|row| best(row)).collect();
    assert!(bests.windows(2).all(|pair| pair[0] <= pair[1]), "{bests:?}");
}

#[test]
fn annealed_curves_of_a_population_go_on_too() {
    let rules = with_search(&format!(
        "{POPULATION} curves annealing {{ iterations = if tuned == 0 then 2 else 4  moves = 3  stop = false
           warm = true  temperature = 1 }}"
    ));
    let (_, log) = is_repeatable(&rules);
    assert!(log.iter().any(|row| row.contains("tuned: 2")), "{log:#?}");
}

#[test]
fn a_population_of_bodies_with_fixed_curves_changes_bodies_only() {
    let mut texts = texts();
    let text = texts["grammars/morphology.sgr"].replace("for 20 s", "for 2 s");
    let line = text.lines().find(|line| line.starts_with("search ")).expect("a search").to_owned();
    let population = POPULATION.replace("40 %", "0 %").replace("  ", "\n  ");
    let text =
        text.replace(&line, &format!("search own\n\nsearch own {{\n  keep = 80 %\n  {population}\n}}"));
    let text: String = text
        .lines()
        .filter(|line| !line.starts_with("use std.search"))
        .map(|line| format!("{line}\n"))
        .collect();
    texts.insert("grammars/morphology.sgr".into(), text);
    let rules = compile_texts(&texts, "grammars/morphology.sgr").unwrap();
    let (one, log) = search(&rules, 1, 1, 120);
    assert_eq!(log, search(&rules, 1, 3, 120).1);
    assert!(one.best.is_some_and(|best| best.value > 0.0), "{log:#?}");
}

/// Evaluations and best value after each move, and the move's value.
#[derive(Default)]
struct Spent(Vec<(u64, Option<f64>, Option<f64>)>);

impl Observer for Spent {
    fn evaluated(&mut self, _: u64, _: Option<f64>, _: f64) {}
    fn moved(&mut self, row: &Row) -> Result<(), Unkept> {
        self.0.push((row.evaluations, row.best, row.value));
        Ok(())
    }
    fn improved(&mut self, _: &Best) -> Result<(), Unkept> {
        Ok(())
    }
}

#[test]
fn bodies_with_fixed_curves_are_checked_only_if_they_would_be_the_best() {
    let mut texts = texts();
    let text = texts["grammars/morphology.sgr"].replace("for 20 s", "for 2 s");
    texts.insert("grammars/morphology.sgr".into(), text);
    let rules = compile_texts(&texts, "grammars/morphology.sgr").unwrap();
    let limits = Limits {
        seed: 1,
        jobs: Jobs::new(1),
        max_evaluations: Some(120),
        lanes: None,
        gives_up: true,
        deadline: None,
    };
    let model = simulate::model("articulated").unwrap();
    let (flag, mut spent) = (AtomicBool::new(false), Spent::default());
    run(&rules, Derivation::begin(&rules), model, &limits, &flag, &mut spent).unwrap();
    let (mut checked, mut others) = (0, 0);
    for pair in spent.0.windows(2) {
        let [(before, best, _), (after, new_best, value)] = pair else { unreachable!() };
        if new_best > best {
            assert_eq!(after - before, 2, "a new best is simulated twice: {pair:?}");
            checked += 1;
        } else if value.is_some_and(|value| value > 0.0) {
            assert_eq!(after - before, 1, "what is no best is simulated once: {pair:?}");
            others += 1;
        }
    }
    assert!(checked > 1 && others > 15, "{checked} bests and {others} others");
}

#[test]
fn a_batch_that_was_given_up_leaves_no_trace() {
    // Processes end in the middle of simulations.
    assert!(same_end(&short(), 2, usize::MAX, Some(Duration::from_millis(25))) > 5);
}

/// Where the size changes while a body is being tried, the move goes on with what it began with, stopped or not.
#[test]
fn a_size_that_changes_within_a_move_is_the_same_in_pieces() {
    let changing = POPULATION.replace("size = 5", "size = if fraction(spent * 20) < 1 / 2 then 12 else 2");
    let rules = with_search(&format!(
        "{changing} curves cma_es {{ iterations = 3  moves = 4  stop = false  warm = true  spread = 15 % }}"
    ));
    for seed in 1..4 {
        assert!(same_end(&rules, seed, 1, None) > 10);
    }
}

/// What a population keeps may depend on how much is spent: many bodies first, then the best of them (successive halving).
#[test]
fn a_population_shrinks_as_evaluations_are_spent() {
    let shrinking = POPULATION
        .replace("size = 5", "size = if spent < 50 % then 12 else 2")
        .replace("further = 40 %", "further = if spent < 50 % then 0 % else 100 %");
    let rules = with_search(&format!(
        "{shrinking} curves cma_es {{ iterations = if best > parent then 2 else 1  moves = 4  stop = false  warm = true
           spread = 15 % }}"
    ));
    let (_, log) = is_repeatable(&rules);
    let rows: Vec<&String> = log.iter().filter(|row| row.starts_with("Row")).collect();
    let spent = |row: &str| row.split(" evaluations: ").nth(1)?.split(',').next()?.parse::<u64>().ok();
    let parent = |row: &str| row.split(" parent: Some(").nth(1)?.split(')').next()?.parse::<u64>().ok();
    // A move that is drawn after half of the 300 evaluations tunes one of two bodies further.
    let late: Vec<&&String> = rows
        .windows(2)
        .filter(|pair| spent(pair[0]).is_some_and(|spent| spent >= 150))
        .map(|pair| &pair[1])
        .collect();
    assert!(late.len() > 4, "{log:#?}");
    assert!(late.iter().all(|row| row.contains("rule: None") && !row.contains("tuned: 0")), "{late:#?}");
    let bodies: std::collections::BTreeSet<u64> = late.iter().filter_map(|row| parent(row)).collect();
    assert!(bodies.len() > 1, "{bodies:?}");
}

/// A search that asks for it finds no best that only hinges can do, and counts what it refuses, on any number of threads.
#[test]
fn a_best_keeps_its_value_with_rods_where_the_search_asks_for_that() {
    let with = |keep: &str| {
        let mut texts = texts();
        let text = crate::support::read("grammars/codesign.sgr").replace("for 20 s in workshop", "for 2 s");
        let text = text.replace("min over w in workshop of travel - fall", "travel - fall");
        texts.insert("grammars/codesign.sgr".into(), text);
        let own = texts["std.search"].lines().find(|line| line.contains("keep_with_rods = 50 %")).unwrap();
        let text = texts["std.search"].replace(own, keep);
        texts.insert("std.search".into(), text);
        compile_texts(&texts, "grammars/codesign.sgr").unwrap()
    };
    let with_rods = |rules: &RuleSet, best: &Best| {
        let candidate = Candidate::new(rules, Arc::clone(&best.derivation));
        let task = rules.first_task().unwrap();
        let drive = Drive::new(&candidate, task).unwrap();
        let model = simulate::SolverName::Rod.model();
        let settings = sgc::search::settings(&task.model);
        let mut simulation = model.prepare(&candidate.body.assembly, &settings).unwrap();
        let parameters = &best.tasks[0].parameters;
        let law = drive.control_law(parameters).unwrap();
        let motion =
            simulation.run_cases(Stop::NEVER, &[law.case(&World::NOMINAL)]).unwrap().remove(0).unwrap();
        score::objective(Recording::nominal(&drive, parameters, &motion)).unwrap()
    };
    let share = |rules: &RuleSet, best: &Best| with_rods(rules, best) / best.value;
    // A seed whose best would lose its value.
    let free = with("");
    let loses = |seed: &u64| {
        let (outcome, _) = search(&free, *seed, 2, 400);
        assert_eq!(outcome.tally.with_rods, 0);
        share(&free, outcome.best.as_ref().unwrap()) < 0.95
    };
    let seed = (1..=8).find(loses).unwrap();
    let asked = with("  keep_with_rods = 95 %");
    let (one, log_one) = search(&asked, seed, 1, 400);
    let (three, log_three) = search(&asked, seed, 3, 400);
    assert_eq!(log_one, log_three);
    assert_eq!(one.tally, three.tally);
    assert!(one.tally.with_rods > 0, "{:?}", one.tally);
    assert!(share(&asked, one.best.as_ref().unwrap()) >= 0.95);
}

/// A constant in the objective hides no loss: what a value must keep is a share of what it is beyond the constant.
#[test]
fn a_constant_in_the_objective_hides_no_loss() {
    let with = |objective: &str| {
        let text = crate::support::read("grammars/codesign.sgr");
        let own = "maximize min over w in workshop of travel - fall in cm";
        assert!(text.contains(own));
        crate::joints::compiled(&text.replace(own, objective))
    };
    for (objective, offset) in [
        ("maximize travel - fall in cm", 0.0),
        ("maximize travel + 10 m in cm", 1000.0),
        ("maximize 3 * (min over w in workshop of travel - 10 m in cm)", 0.0),
        ("maximize min over w in workshop of travel - 10 m in cm", -1000.0),
        ("minimize 90 cm - travel in cm", 90.0),
    ] {
        let rules = with(objective);
        let task = rules.first_task().unwrap();
        assert!((task.objective.offset(&rules) - offset).abs() < 1e-9, "{objective}");
        let sign = task.objective.direction.fitness(1.0);
        let other = |share: f64| offset + sign * 20.0 * share;
        let keeps = |share: f64| {
            sgc::search::keeps(task.objective.direction, offset, rules.search.keep, other(1.0), other(share))
        };
        assert!(keeps(0.9) && keeps(1.5) && !keeps(0.5), "{objective}");
    }
}
