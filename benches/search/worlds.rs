//! Whether an objective over many worlds finds better gaits than one in a single world, in the same CPU time.
//!
//! For each body of `benches/bodies/`, method and seed, two searches of the curves take turns on one thread: one for a
//! gait that is good in the nominal world, one for a gait whose worst of 16 worlds is good. Each ends when it has
//! used so many seconds of CPU time. What they found is judged in the 64 worlds of
//! `grammars/experiments/acceptance.sgr`, which no search uses.

use std::sync::atomic::{AtomicBool, Ordering};

use cpu_time::ProcessTime;
use grammar_lang::ir::{Direction, RuleSet};
use grammar_lang::source::SourceMap;
use sgc::derive::Derivation;
use sgc::results::elsewhere::{judge, together};
use sgc::results::replay::{How, Precision};
use sgc::results::saved::Grammar;
use sgc::results::saving::save;
use sgc::scenarios::{Scenario, worlds};
use sgc::search::{Best, Jobs, Limits, Observer, Row, Unkept, run};
use sgc::simulate::{self, Stop};

use super::{BODIES, compiled};

/// The methods, and the searches of `std.search` that use them.
const METHODS: [(&str, &str); 2] = [("annealing", "gait_annealing"), ("CMA-ES", "gait_evolution")];

/// Ends a search that has used so many seconds of CPU time.
struct Budget<'a> {
    begun: ProcessTime,
    seconds: f64,
    flag: &'a AtomicBool,
}

impl Observer for Budget<'_> {
    fn evaluated(&mut self, _: u64, _: Option<f64>, _: f64) {
        if self.begun.elapsed().as_secs_f64() >= self.seconds {
            self.flag.store(true, Ordering::Relaxed);
        }
    }
    fn moved(&mut self, _: &Row) -> Result<(), Unkept> {
        Ok(())
    }
    fn improved(&mut self, _: &Best) -> Result<(), Unkept> {
        Ok(())
    }
}

/// What a search found.
struct Found {
    /// CPU seconds, and motions simulated.
    spent: (f64, u64),
    /// The value that was searched for, in cm.
    value: f64,
    /// The value in the nominal world, what nine of ten worlds of the acceptance set are better than, and the worst, in cm.
    bench: [f64; 3],
}

/// Bodies with a search, for a gait in one world or in many.
fn grammar(body: &str, search: &str, in_many: bool) -> (RuleSet, SourceMap) {
    let objective = match in_many {
        true => {
            "  replace simulate hinge_model for 20 s in workshop\n  \
             replace maximize min over w in workshop of travel - fall in cm\n"
        }
        false => "",
    };
    compiled(&format!(
        "use std.models {{ hinge_model }}\nuse std.search {{ {search} }}\nuse std.scenarios {{ workshop }}\n\
         variant timed of \"{}/benches/bodies/bodies.sgr\" {{\n  replace search {search} from {body}\n{objective}}}\n",
        env!("CARGO_MANIFEST_DIR")
    ))
}

/// The worlds that no search uses.
fn acceptance() -> Vec<Scenario> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/grammars/experiments/acceptance.sgr");
    let (rules, _) = compiled(
        &std::fs::read_to_string(path)
            .unwrap()
            .replace("../codesign.sgr", concat!(env!("CARGO_MANIFEST_DIR"), "/grammars/codesign.sgr")),
    );
    worlds("bench", &rules.scenarios["bench"])
}

fn search((rules, sources): &(RuleSet, SourceMap), seed: u64, seconds: f64, worlds: &[Scenario]) -> Found {
    let flag = AtomicBool::new(false);
    let begun = ProcessTime::now();
    let limits = Limits {
        seed,
        jobs: Jobs::new(1),
        max_evaluations: None,
        lanes: None,
        gives_up: true,
        deadline: None,
    };
    let model = simulate::model("articulated").unwrap();
    let first = Derivation::start(rules, rules.from.as_deref()).unwrap();
    let outcome =
        run(rules, first, model, &limits, &flag, &mut Budget { begun, seconds, flag: &flag }).unwrap();
    let spent = (begun.elapsed().as_secs_f64(), outcome.evaluations);
    // In that time nothing may have been judged in all worlds: a body without a gait stays where it is.
    let Some(best) = outcome.best else { return Found { spent, value: 0.0, bench: [0.0; 3] } };
    let design = save(rules, Grammar::freeze(rules, sources, &[]), seed, "articulated", &best).unwrap();
    let how = How { solver: "articulated", precision: Precision::Model, stop: Stop::NEVER };
    let (judged, _) = judge(rules, &design, worlds.to_vec(), how).unwrap();
    let values: Vec<Option<f64>> = judged.iter().map(|judged| judged.value.ok()).collect();
    let all = together(Direction::Maximize, &values).unwrap();
    // A world without a value counts as worse than any.
    let or_worst = |value: Option<f64>| value.unwrap_or(f64::NEG_INFINITY);
    let bench = [or_worst(values[0]), or_worst(all.tenth), or_worst(values[all.worst])];
    Found { spent, value: best.value, bench }
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    values.sum::<f64>() / count
}

/// Searches for so many CPU seconds with each of so many seeds, the first of them as given.
pub(super) fn compare(seconds: u64, seeds: u64, first: u64, words: &[String]) {
    let named = |name: &str| words.iter().any(|word| word == name);
    let bodies = BODIES.into_iter().filter(|body| !BODIES.iter().any(|body| named(body)) || named(body));
    let worlds = acceptance();
    println!(
        "{seconds} s of CPU time for each search; in cm: the value that was searched for, and in the acceptance set"
    );
    println!("the value in the nominal world, what nine of ten worlds are better than, and the worst");
    for body in bodies {
        for (method, name) in METHODS {
            if METHODS.iter().any(|(method, _)| named(method)) && !named(method) {
                continue;
            }
            let grammars = [false, true].map(|in_many| grammar(body, name, in_many));
            let mut pairs: Vec<[Found; 2]> = Vec::new();
            for seed in first..first + seeds {
                let pair = [0, 1].map(|which| search(&grammars[which], seed, seconds as f64, &worlds));
                let told = pair.iter().map(|found| {
                    let ([nominal, tenth, worst], (cpu, motions)) = (found.bench, found.spent);
                    let value = found.value;
                    format!("{value:6.1} | {nominal:6.1} {tenth:6.1} {worst:6.1} ({cpu:.1} s, {motions})")
                });
                let [one, many]: [String; 2] = told.collect::<Vec<_>>().try_into().unwrap();
                println!("{body:5} {method:9} seed {seed:3}: one world {one}   sixteen {many}");
                pairs.push(pair);
            }
            let tenth = |which: usize| pairs.iter().map(move |pair| pair[which].bench[1]);
            let (one, many) = (mean(tenth(0)), mean(tenth(1)));
            let wins = pairs.iter().filter(|[one, many]| many.bench[1] > one.bench[1]).count();
            println!(
                "{body:5} {method:9} nine of ten worlds, mean of {seeds} seeds: one world {one:.1}, sixteen {many:.1}: \
                 {:.2} times, {:.1} cm more; better with {wins} seeds",
                many / one,
                many - one
            );
        }
    }
}
