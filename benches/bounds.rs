//! What should happen to a mutated value beyond its domain? Tunes the curves of two bodies of
//! `benches/bodies/` with each of the three answers, from the same seeds, and prints the best values.
//!
//! `cargo bench --bench bounds -- 2000` (evaluations for each search)

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::print_stdout, missing_docs)]

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use grammar_lang::source::SourceMap;
use rayon::prelude::*;
use sgc::derive::Derivation;
use sgc::loader::Files;
use sgc::results::saved::Grammar;
use sgc::search::{Jobs, Limits, tune_body};
use sgc::simulate;

const BODIES: [&str; 2] = ["two", "four"];
const BOUNDS: [&str; 3] = ["reflect", "clamp", "resample"];
const SEEDS: u64 = 3;

fn main() {
    let most = std::env::args().filter_map(|a| a.parse().ok()).next().unwrap_or(2000);
    let grammar = grammar();
    let cases: Vec<_> = BODIES
        .iter()
        .flat_map(|body| {
            BOUNDS.iter().flat_map(move |bound| (1..=SEEDS).map(move |seed| (*body, *bound, seed)))
        })
        .collect();
    let values: Vec<f64> = cases
        .par_iter()
        .map(|(body, bound, seed)| {
            let mut grammar = grammar.clone();
            let text = grammar.sources.get_mut("std.actuation").unwrap();
            *text = text.replace("bound clamp", &format!("bound {bound}"));
            let rules = grammar.compile_edited().unwrap();
            let derivation = Arc::new(Derivation::start(&rules, Some(body)).unwrap());
            let limits = Limits {
                seed: *seed,
                jobs: Jobs::new(1),
                max_evaluations: Some(most),
                lanes: None,
                gives_up: true,
                deadline: None,
            };
            let model = simulate::model("articulated").unwrap();
            let outcome = tune_body(&rules, model, &derivation, &limits, &AtomicBool::new(false)).unwrap();
            outcome.best.map_or(f64::NAN, |best| best.value)
        })
        .collect();
    println!("best value in cm after at most {most} evaluations, seeds 1 to {SEEDS}");
    for (cases, values) in cases.chunks(SEEDS as usize).zip(values.chunks(SEEDS as usize)) {
        let (body, bound, _) = cases[0];
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let all: Vec<String> = values.iter().map(|v| format!("{v:6.1}")).collect();
        println!("{body} {bound:9} {}   mean {mean:6.1}", all.join(" "));
    }
}

/// The grammar of the bodies, with all texts that it is made of.
fn grammar() -> Grammar {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/bodies/bodies.sgr");
    let mut sources = SourceMap::default();
    let entry = sources.add(path, std::fs::read_to_string(path).unwrap());
    let rules = grammar_lang::compile(&Files, &mut sources, entry, &[], None).ruleset.unwrap();
    Grammar::freeze(&rules, &sources, &[])
}
