//! How much CPU time lanes save a search, and other methods than one annealing chain. For each body of
//! `benches/bodies/` and each seed, one thread anneals curves one evaluation after the other, until so many are
//! spent. Then the same search fills the lanes of the solver, and other searches run until they
//! have found as good a value: all in the same process, in turns.
//!
//! `cargo bench --bench search -- 1000 10` (evaluations, seeds)

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::print_stdout, missing_docs)]

use std::sync::atomic::{AtomicBool, Ordering};

use cpu_time::ProcessTime;
use grammar_lang::ir::RuleSet;
use sgc::derive::Derivation;
use sgc::search::{Best, Limits, Observer, Row, run};
use sgc::simulate;
use sgc::world::Files;

const BODIES: [&str; 3] = ["two", "four", "eight"];
/// What is compared: the search, how many lanes, and whether it stops at the value.
const OTHERS: [(&str, &str); 3] =
    [("the same, in lanes", "gait_annealing"), ("CMA-ES", "gait_evolution"), ("16 chains", "gait_tempering")];
/// A method that has spent so many times as many evaluations is given up.
const PATIENCE: u64 = 4;

/// Ends a search once it has found a value.
struct Until<'a> {
    value: f64,
    found: bool,
    flag: &'a AtomicBool,
}

impl Observer for Until<'_> {
    fn evaluated(&mut self, _: u64, body: Option<f64>, _: f64) {
        if body.is_some_and(|value| value >= self.value) {
            self.found = true;
            self.flag.store(true, Ordering::Relaxed);
        }
    }
    fn moved(&mut self, _: &Row) -> Result<(), String> {
        Ok(())
    }
    fn improved(&mut self, best: &Best) -> Result<(), String> {
        self.found |= best.value >= self.value;
        Ok(())
    }
}

/// The seconds that a search takes to find a value, if it does; its best value, and evaluations.
fn time(rules: &RuleSet, seed: u64, lanes: Option<usize>, most: u64, value: f64) -> (Option<f64>, f64, u64) {
    let flag = AtomicBool::new(false);
    let mut until = Until { value, found: false, flag: &flag };
    let limits = Limits { seed, jobs: 1, max_evaluations: Some(most), lanes, gives_up: true, deadline: None };
    let model = simulate::model("articulated").unwrap();
    let first = Derivation::start(rules, rules.from.as_deref()).unwrap();
    let begun = ProcessTime::now();
    let outcome = run(rules, first, model, &limits, &flag, &mut until).unwrap();
    let took = begun.elapsed().as_secs_f64();
    let best = outcome.best.map_or(f64::NEG_INFINITY, |best| best.value);
    (until.found.then_some(took), best, outcome.evaluations)
}

/// `bodies` with one of its bodies and a search.
fn rules(body: &str, search: &str) -> RuleSet {
    let text = format!(
        "use std.search {{ {search} }}\nvariant timed of \"{}/benches/bodies/bodies.sgr\" {{\n  \
         replace search {search} from {body}\n}}\n",
        env!("CARGO_MANIFEST_DIR")
    );
    let mut sources = grammar_lang::source::SourceMap::default();
    let entry = sources.add(concat!(env!("CARGO_MANIFEST_DIR"), "/benches/timed.sgr"), text);
    let compiled = grammar_lang::compile(&Files, &mut sources, entry, &[], None);
    compiled.ruleset.expect("the grammar of the bodies is sound")
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    if values.len() % 2 == 1 { values[middle] } else { (values[middle - 1] + values[middle]) / 2.0 }
}

fn main() {
    let mut numbers = std::env::args().filter_map(|a| a.parse::<u64>().ok());
    let (most, seeds) = (numbers.next().unwrap_or(1000), numbers.next().unwrap_or(10));
    println!(
        "one chain, one evaluation after the other, {most} evaluations; then the share of its CPU time that"
    );
    println!("others take to find as good a value (inf: not within {PATIENCE} times as many evaluations)");
    let mut all = vec![Vec::new(); OTHERS.len()];
    for body in BODIES {
        let plain = rules(body, "gait_annealing");
        let others = OTHERS.map(|(_, search)| rules(body, search));
        let mut shares = vec![Vec::new(); OTHERS.len()];
        for seed in 1..=seeds {
            let begun = ProcessTime::now();
            let (_, value, spent) = time(&plain, seed, Some(1), most, f64::INFINITY);
            let alone = begun.elapsed().as_secs_f64();
            let mut told = format!("{body:6} seed {seed:2}: {value:7.2} cm, {alone:6.2} s");
            for (number, ((name, search), rules)) in OTHERS.iter().zip(&others).enumerate() {
                let is_same = *search == "gait_annealing";
                let (took, found, _) = if is_same {
                    // To its end, as it finds the same at the same evaluation.
                    let begun = ProcessTime::now();
                    let (_, found, again) = time(rules, seed, None, most, f64::INFINITY);
                    assert_eq!((found.to_bits(), again), (value.to_bits(), spent), "the same search");
                    (Some(begun.elapsed().as_secs_f64()), found, again)
                } else {
                    time(rules, seed, None, PATIENCE * most, value)
                };
                let share = took.map_or(f64::INFINITY, |took| took / alone);
                told += &format!("   {name} {share:5.2} ({found:.2})");
                shares[number].push(share);
                all[number].push(share);
            }
            println!("{told}");
        }
        let medians: Vec<String> = OTHERS
            .iter()
            .zip(&shares)
            .map(|((name, _), shares)| format!("{name} {:.2}", median(shares.clone())))
            .collect();
        println!("{body:6} medians: {}", medians.join(", "));
    }
    for ((name, _), shares) in OTHERS.iter().zip(all) {
        println!("{name}: median of all {:.2}", median(shares));
    }
}
