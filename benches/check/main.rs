//! How long checking takes, by the length of a grammar: it should be linear.
//!
//! `cargo bench --bench check` prints the milliseconds of each layer, the least of several runs;
//! the second line of each length is what a thousand lines cost. Add `-- 5000` for one length alone.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::print_stdout, missing_docs)]

mod grown;

use std::time::{Duration, Instant};

use grammar_lang::eval::Budget;
use grammar_lang::format::format;
use grammar_lang::source::{FileId, SourceMap};
use grammar_lang::{compile, lint, names, syntax, types};
use grown::{Flaw, grammar};
use sgc::loader::Files;

const LENGTHS: [usize; 5] = [1_000, 2_000, 5_000, 10_000, 20_000];
/// `parse` is the text alone, `load` also those that it imports, and what their names mean.
const COLUMNS: [&str; 7] = ["parse", "load", "types", "lint", "whole", "format", "variant"];

fn main() {
    let asked: Vec<usize> = std::env::args().filter_map(|a| a.parse().ok()).collect();
    let lengths = if asked.is_empty() { &LENGTHS } else { asked.as_slice() };
    println!("a grammar without an error");
    table(Flaw::None, lengths);
    println!("\nan error in every rule: found by the parser");
    table(Flaw::Form, lengths);
    println!("\nan error in every rule: found by the checker");
    table(Flaw::Meaning, lengths);
}

fn table(flaw: Flaw, lengths: &[usize]) {
    let heads: String = COLUMNS.iter().map(|c| format!("{c:>9}")).collect();
    println!("{:>7}{heads}  findings", "lines");
    let mut before: Option<(usize, Vec<f64>)> = None;
    for &length in lengths {
        let text = grammar(length, flaw);
        let lines = text.lines().count();
        let (times, findings) = measure(&text, flaw);
        let row = |values: &[f64]| values.iter().map(|v| format!("{v:9.2}")).collect::<String>();
        println!("{lines:>7}{}  {findings}", row(&times));
        println!(
            "{:>7}{}",
            "/1000",
            row(&times.iter().map(|t| t * 1000.0 / lines as f64).collect::<Vec<_>>())
        );
        if let Some((fewer, less)) = before {
            // 1 is linear, 2 is quadratic.
            let growth = libm::log(lines as f64 / fewer as f64);
            let slopes: Vec<f64> = times.iter().zip(&less).map(|(t, l)| libm::log(t / l) / growth).collect();
            println!("{:>7}{}", "slope", row(&slopes));
        }
        before = Some((lines, times));
    }
}

/// Milliseconds of each layer, and how much is found.
fn measure(text: &str, flaw: Flaw) -> (Vec<f64>, usize) {
    let fresh = || {
        let mut sources = SourceMap::default();
        let file = sources.add("grown.sgr", text);
        (sources, file)
    };
    let (mut sources, file) = fresh();
    let compiled = compile(&Files, &mut sources, file, &[], None);
    assert_eq!(compiled.has_errors(), flaw != Flaw::None, "{:#?}", compiled.diagnostics.first());
    let whole = |wanted: Option<&'static str>| {
        least(fresh, move |(sources, file)| compile(&Files, sources, *file, &[], wanted))
    };
    let parse = least(fresh, |(sources, file)| syntax::parse(sources, *file));
    let load = least(fresh, |(sources, file)| names::load(&Files, sources, *file, None));
    let loaded = || {
        let (mut sources, file) = fresh();
        let (program, _) = names::load(&Files, &mut sources, file, None);
        (sources, program)
    };
    let check = least(loaded, |(sources, program)| types::check(program, sources, &[], &Budget::of_file()));
    // Only what has no errors is checked as a whole.
    let own = lint::Own { entry: file, is_varied: false };
    let lint = compiled.ruleset.as_ref().map_or(f64::NAN, |rules| {
        least(|| (), |()| lint::run(rules, None, own, &Budget::of_file(), &mut Vec::new()))
    });
    let lay_out = least(fresh, |(sources, file): &mut (SourceMap, FileId)| format(sources, *file));
    let times = vec![parse, load, check, lint, whole(None), lay_out, whole(Some("workshop"))];
    (times, compiled.diagnostics.len())
}

/// The least time of several runs: what others do on the machine only adds to it.
fn least<T, R>(prepare: impl Fn() -> T, run: impl Fn(&mut T) -> R) -> f64 {
    let mut best = Duration::MAX;
    let begun = Instant::now();
    for round in 0..15 {
        let mut input = prepare();
        let start = Instant::now();
        let result = run(&mut input);
        best = best.min(start.elapsed());
        drop(result);
        if round > 1 && begun.elapsed() > Duration::from_secs(3) {
            break;
        }
    }
    best.as_secs_f64() * 1000.0
}
