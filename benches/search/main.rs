//! How much CPU time lanes save a search, and other methods than one annealing chain. For each body of
//! `benches/bodies/` and each seed, one thread anneals curves one evaluation after the other, until so many are
//! spent: its CPU time is the measure. Then the same search fills the lanes of the solver, and other searches
//! run until they have found as good a value: all in the same process, in turns.
//!
//! `cargo bench --bench search -- 750 10` (evaluations, seeds; names of bodies after them leave out the others,
//! and `lanes` the other searches)
//!
//! `cargo bench --bench search -- threads 4000 3` (evaluations, seeds) tells how much sooner searches end with a second
//! thread, by the clock: for bodies and curves together, and for the curves of one body; words such as `CMA-ES` after
//! them leave out the searches without one.
//!
//! `cargo bench --bench search -- worlds 15 10` (seconds of CPU time, seeds; after them the first seed, if it is not 1, and
//! names of bodies and methods, to leave out the others) compares gaits that are searched for in one world and in many.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::print_stdout, missing_docs)]

mod worlds;

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use cpu_time::ProcessTime;
use grammar_lang::ir::RuleSet;
use grammar_lang::source::SourceMap;
use sgc::derive::Derivation;
use sgc::loader::Files;
use sgc::search::{Best, Jobs, Limits, Observer, Row, Unkept, run};
use sgc::simulate;

const BODIES: [&str; 3] = ["two", "four", "eight"];
/// What is compared.
const OTHERS: [(&str, &str); 3] =
    [("lanes", "gait_annealing"), ("CMA-ES", "gait_evolution"), ("16 chains", "gait_tempering")];
/// A method that has spent so many times as many evaluations is given up.
const PATIENCE: u64 = 2;

/// Looks when a search has found a value.
struct Until<'a> {
    value: f64,
    begun: ProcessTime,
    /// CPU seconds until it was found.
    found: Option<f64>,
    /// Ends the search then.
    flag: Option<&'a AtomicBool>,
}

impl Until<'_> {
    fn see(&mut self, value: f64) {
        if value >= self.value && self.found.is_none() {
            self.found = Some(self.begun.elapsed().as_secs_f64());
            self.flag.iter().for_each(|flag| flag.store(true, Ordering::Relaxed));
        }
    }
}

impl Observer for Until<'_> {
    fn evaluated(&mut self, _: u64, body: Option<f64>, _: f64) {
        body.into_iter().for_each(|value| self.see(value));
    }
    fn moved(&mut self, _: &Row) -> Result<(), Unkept> {
        Ok(())
    }
    fn improved(&mut self, best: &Best) -> Result<(), Unkept> {
        self.see(best.value);
        Ok(())
    }
}

/// A search that has ended: CPU seconds until it found what was wanted, and until its end.
struct Timed {
    found: Option<f64>,
    whole: f64,
    best: f64,
    evaluations: u64,
}

/// Searches, with so many lanes and evaluations at most, for a value; `on` says whether it goes on when that is found.
fn time(rules: &RuleSet, seed: u64, lanes: Option<usize>, most: u64, (value, on): (f64, bool)) -> Timed {
    let flag = AtomicBool::new(false);
    let begun = ProcessTime::now();
    let mut until = Until { value, begun, found: None, flag: (!on).then_some(&flag) };
    let limits = Limits {
        seed,
        jobs: Jobs::new(1),
        max_evaluations: Some(most),
        lanes,
        gives_up: true,
        deadline: None,
    };
    let model = simulate::model("articulated").unwrap();
    let first = Derivation::start(rules, rules.from.as_deref()).unwrap();
    let outcome = run(rules, first, model, &limits, &flag, &mut until).unwrap();
    let best = outcome.best.map_or(f64::NEG_INFINITY, |best| best.value);
    let whole = begun.elapsed().as_secs_f64();
    Timed { found: until.found, whole, best, evaluations: outcome.evaluations }
}

/// `bodies` with one of its bodies and a search.
fn rules(body: &str, search: &str) -> RuleSet {
    variant("benches/bodies/bodies.sgr", search, &format!(" from {body}"))
}

/// A grammar with another search.
fn variant(of: &str, search: &str, from: &str) -> RuleSet {
    let text = format!(
        "use std.search {{ {search} }}\nvariant timed of \"{}/{of}\" {{\n  replace search {search}{from}\n}}\n",
        env!("CARGO_MANIFEST_DIR")
    );
    compiled(&text).0
}

/// The rule set of a grammar, and its text.
fn compiled(text: &str) -> (RuleSet, SourceMap) {
    let mut sources = SourceMap::default();
    let entry = sources.add(concat!(env!("CARGO_MANIFEST_DIR"), "/benches/timed.sgr"), text.to_owned());
    let compiled = grammar_lang::compile(&Files, &mut sources, entry, &[], None);
    (compiled.ruleset.expect("the grammar is sound"), sources)
}

/// How long a search takes by the clock with so many threads, in s, and what it finds.
fn wall(rules: &RuleSet, seed: u64, jobs: usize, most: u64) -> (f64, Option<u64>, u64) {
    let flag = AtomicBool::new(false);
    let mut until = Until { value: f64::INFINITY, begun: ProcessTime::now(), found: None, flag: None };
    let jobs = Jobs::new(jobs);
    let limits =
        Limits { seed, jobs, max_evaluations: Some(most), lanes: None, gives_up: true, deadline: None };
    let first = Derivation::start(rules, rules.from.as_deref()).unwrap();
    let begun = Instant::now();
    let outcome =
        run(rules, first, simulate::model("articulated").unwrap(), &limits, &flag, &mut until).unwrap();
    (begun.elapsed().as_secs_f64(), outcome.best.map(|best| best.value.to_bits()), outcome.evaluations)
}

/// One thread against two, in turns.
fn threads(most: u64, seeds: u64, words: &[String]) {
    let codesign = "grammars/experiments/codesign_thesis.sgr";
    let searches = [
        ("bodies and curves, annealing", variant(codesign, "nested_annealing", "")),
        ("bodies and curves, CMA-ES", variant(codesign, "nested_evolution", "")),
        (
            "bodies alone, annealing",
            variant("grammars/experiments/morphology_only.sgr", "plain_annealing", ""),
        ),
        ("curves of four actuators, annealing", rules("four", "gait_annealing")),
        ("curves of four actuators, CMA-ES", rules("four", "gait_evolution")),
    ];
    println!("seconds with one thread, with two, and how much sooner two are; {most} evaluations");
    let named = |what: &str| words.iter().any(|word| what.contains(word.as_str()));
    let all = !searches.iter().any(|(what, _)| named(what));
    for (what, rules) in searches.iter().filter(|(what, _)| all || named(what)) {
        let gains = (1..=seeds).map(|seed| {
            let (one, two) = (wall(rules, seed, 1, most), wall(rules, seed, 2, most));
            assert_eq!((one.1, one.2), (two.1, two.2), "the same search");
            println!("{what}, seed {seed}: {:6.1} {:6.1}  {:.2}", one.0, two.0, one.0 / two.0);
            one.0 / two.0
        });
        let gains: Vec<f64> = gains.collect();
        let mean = libm::exp(gains.iter().map(|gain| libm::log(*gain)).sum::<f64>() / gains.len() as f64);
        println!("{what}: {mean:.2} (geometric mean), {:.2} (median)", median(gains));
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    if values.len() % 2 == 1 { values[middle] } else { (values[middle - 1] + values[middle]) / 2.0 }
}

fn main() {
    let mut numbers = std::env::args().filter_map(|a| a.parse::<u64>().ok());
    let words: Vec<String> = std::env::args().skip(1).collect();
    if words.iter().any(|word| word == "threads") {
        return threads(numbers.next().unwrap_or(4000), numbers.next().unwrap_or(3), &words);
    }
    if words.iter().any(|word| word == "worlds") {
        let mut number = |usual| numbers.next().unwrap_or(usual);
        let (seconds, seeds, first) = (number(15), number(10), number(1));
        return worlds::compare(seconds, seeds, first, &words);
    }
    let bodies: Vec<&str> = BODIES.into_iter().filter(|body| words.iter().any(|word| word == body)).collect();
    let bodies = if bodies.is_empty() { BODIES.to_vec() } else { bodies };
    let methods = if words.iter().any(|word| word == OTHERS[0].0) { &OTHERS[..1] } else { &OTHERS[..] };
    let (most, seeds) = (numbers.next().unwrap_or(750), numbers.next().unwrap_or(10));
    println!(
        "one chain, one evaluation after the other, {most} evaluations; then the share of its CPU time that"
    );
    println!("others take to find as good a value (inf: not within {PATIENCE} times as many evaluations)");
    let mut columns: Vec<String> = methods.iter().map(|(name, _)| (*name).to_owned()).collect();
    columns.push("lanes, all of the evaluations".into());
    let mut all = vec![Vec::new(); columns.len()];
    for body in bodies {
        let plain = rules(body, "gait_annealing");
        let others: Vec<_> = methods.iter().map(|(_, search)| rules(body, search)).collect();
        let mut shares = vec![Vec::new(); columns.len()];
        for seed in 1..=seeds {
            let alone = time(&plain, seed, Some(1), most, (f64::INFINITY, true));
            let value = alone.best;
            let mut told = format!("{body:6} seed {seed:2}: {value:7.2} cm, {:6.2} s", alone.whole);
            let share = |seconds: Option<f64>| seconds.map_or(f64::INFINITY, |took| took / alone.whole);
            for (number, ((name, search), rules)) in methods.iter().zip(&others).enumerate() {
                let is_same = *search == "gait_annealing";
                let evaluations = if is_same { most } else { PATIENCE * most };
                let other = time(rules, seed, None, evaluations, (value, is_same));
                shares[number].push(share(other.found));
                told += &format!("   {name} {:5.2} ({:.2})", share(other.found), other.best);
                if is_same {
                    let (found, again) = (other.best, other.evaluations);
                    assert_eq!(
                        (found.to_bits(), again),
                        (value.to_bits(), alone.evaluations),
                        "the same search"
                    );
                    shares[methods.len()].push(share(Some(other.whole)));
                    told += &format!(", all of it {:.2}", share(Some(other.whole)));
                }
            }
            println!("{told}");
        }
        tell(&format!("{body:6} medians"), &columns, &shares);
        all.iter_mut().zip(shares).for_each(|(all, shares)| all.extend(shares));
    }
    tell("medians of all", &columns, &all);
}

fn tell(what: &str, columns: &[String], shares: &[Vec<f64>]) {
    let medians =
        columns.iter().zip(shares).map(|(name, shares)| format!("{name} {:.2}", median(shares.clone())));
    println!("{what}: {}", medians.collect::<Vec<_>>().join("; "));
}
