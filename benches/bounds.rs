//! What should happen to a mutated value beyond its domain? Tunes the curves of two saved
//! bodies with each of the three answers, from the same seeds, and prints the best values.
//!
//! `cargo bench --bench bounds -- 2000` (evaluations for each search)

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::print_stdout, missing_docs)]

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use rayon::prelude::*;
use sgc::derive::Derivation;
use sgc::results::saved::SavedDesign;
use sgc::search::{Limits, tune_body};
use sgc::simulate;

const BOUNDS: [&str; 3] = ["reflect", "clamp", "resample"];
const SEEDS: u64 = 3;

fn main() {
    let most = std::env::args().filter_map(|a| a.parse().ok()).next().unwrap_or(2000);
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/designs");
    let designs = ["seed1", "seed2"];
    let cases: Vec<_> = designs
        .iter()
        .flat_map(|design| {
            BOUNDS.iter().flat_map(move |bound| (1..=SEEDS).map(move |seed| (*design, *bound, seed)))
        })
        .collect();
    let values: Vec<f64> = cases
        .par_iter()
        .map(|(design, bound, seed)| {
            let mut saved =
                SavedDesign::read(std::path::Path::new(&format!("{folder}/{design}.design.json"))).unwrap();
            let text = saved.grammar.sources.get_mut("std.actuation").unwrap();
            *text = text.replace("bound reflect", &format!("bound {bound}"));
            let rules = saved.grammar.compile_edited().unwrap();
            let derivation = Arc::new(Derivation::replay(&rules, &saved.derivation).unwrap());
            let limits = Limits { seed: *seed, jobs: 1, max_evaluations: Some(most), deadline: None };
            let model = simulate::model("articulated").unwrap();
            let outcome = tune_body(&rules, model, &derivation, &limits, &AtomicBool::new(false)).unwrap();
            outcome.best.map_or(f64::NAN, |best| best.value)
        })
        .collect();
    println!("best value in cm after at most {most} evaluations, seeds 1 to {SEEDS}");
    for (cases, values) in cases.chunks(SEEDS as usize).zip(values.chunks(SEEDS as usize)) {
        let (design, bound, _) = cases[0];
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let all: Vec<String> = values.iter().map(|v| format!("{v:6.1}")).collect();
        println!("{design} {bound:9} {}   mean {mean:6.1}", all.join(" "));
    }
}
