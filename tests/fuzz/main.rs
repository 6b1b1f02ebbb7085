//! Looks for texts that the compiler, the layout or the derivation cannot bear.
//!
//! `cargo run --release --example fuzz -- --seconds 60 --seed 1 --out found`
//!
//! The same seed tries the same texts. What does not hold is made as small as possible and saved in
//! the folder; the text that is being tried is always in `current.sgr` there, in case all ends.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::print_stdout, missing_docs)]
#![allow(unreachable_pub)]

mod corpus;
mod holds;
mod mutate;

use std::collections::BTreeSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use holds::Reached;
use mutate::{Random, gently, mutated};
use sgc::loader::Frozen;

/// How long one text may take.
const SLOW: Duration = Duration::from_secs(1);
/// After how long it is taken to go on forever.
const STUCK: Duration = Duration::from_secs(20);

fn main() {
    let seconds = argument("--seconds").map_or(60, |s| s.parse().unwrap());
    let seed = argument("--seed").map_or(1, |s| s.parse().unwrap());
    let out = PathBuf::from(argument("--out").unwrap_or_else(|| "target/fuzz".to_owned()));
    std::fs::create_dir_all(&out).unwrap();
    let trying = Arc::new(Mutex::new(Instant::now()));
    let watched = Arc::clone(&trying);
    std::thread::spawn(move || {
        loop {
            std::thread::sleep(Duration::from_millis(500));
            if watched.lock().unwrap().elapsed() > STUCK {
                println!("stuck: the text is in current.sgr");
                std::process::exit(1);
            }
        }
    });
    std::panic::set_hook(Box::new(|_| {}));
    // A thread of its own has the stack that tests have.
    std::thread::spawn(move || search(seconds, seed, &out, &trying)).join().unwrap();
}

fn argument(name: &str) -> Option<String> {
    let mut arguments = std::env::args().skip_while(|a| a != name);
    arguments.nth(1)
}

fn search(seconds: u64, seed: u64, out: &Path, trying: &Mutex<Instant>) {
    let corpus = corpus::texts();
    let loader = holds::loader();
    let sound: Vec<String> =
        corpus.iter().filter(|text| fault(&loader, text).is_ok_and(|r| r.sound > 0)).cloned().collect();
    let mut random = Random(seed);
    let begun = Instant::now();
    let mut known: BTreeSet<String> = BTreeSet::new();
    let (mut tried, mut slowest) = (0u64, Duration::ZERO);
    let mut reached = Reached::default();
    while begun.elapsed() < Duration::from_secs(seconds) {
        // Half of the texts are likely to be sound, so that the engine is reached.
        let text = if tried.is_multiple_of(2) {
            gently(random.pick::<String>(&sound), &mut random)
        } else {
            mutated(random.pick::<String>(&corpus), &corpus, &mut random)
        };
        std::fs::write(out.join("current.sgr"), &text).unwrap();
        *trying.lock().unwrap() = Instant::now();
        let start = Instant::now();
        let outcome = fault(&loader, &text);
        let took = start.elapsed();
        tried += 1;
        slowest = slowest.max(took);
        reached += outcome.as_ref().copied().unwrap_or_default();
        let outcome =
            outcome.err().or_else(|| (took > SLOW).then(|| format!("it takes {} s", took.as_secs())));
        if let Some(why) = outcome.filter(|why| known.insert(class(why))) {
            let small = if took > SLOW { text } else { smallest(&loader, text, &class(&why), trying) };
            let path = out.join(format!("{seed}-{}.sgr", known.len()));
            std::fs::write(&path, small).unwrap();
            println!("{}: {why}", path.display());
        }
    }
    let _ = std::fs::remove_file(out.join("current.sgr"));
    println!(
        "{tried} texts, of which {} compiled without errors and {} were derived",
        reached.sound, reached.derived
    );
    println!("{} faults, the slowest took {} ms", known.len(), slowest.as_millis());
}

/// How far a text gets, or what does not hold of it.
fn fault(loader: &Frozen, text: &str) -> Result<Reached, String> {
    match catch_unwind(AssertUnwindSafe(|| holds::reached(loader, text))) {
        Ok(held) => held,
        Err(cause) => {
            let said = cause.downcast_ref::<String>().cloned();
            let said = said.or_else(|| cause.downcast_ref::<&str>().map(|s| (*s).to_owned()));
            Err(format!("panic: {}", said.unwrap_or_default()))
        }
    }
}

/// Faults that begin alike, whatever the numbers in them, are one.
fn class(why: &str) -> String {
    why.chars().filter(|c| !c.is_ascii_digit()).take(60).collect()
}

/// The same fault in as few lines, then in as few pieces, as can be found.
fn smallest(loader: &Frozen, text: String, class_of: &str, trying: &Mutex<Instant>) -> String {
    let same = |text: &str| {
        *trying.lock().unwrap() = Instant::now();
        fault(loader, text).is_err_and(|why| class(&why) == class_of)
    };
    let by_lines = shrunk(text.split_inclusive('\n').map(str::to_owned).collect(), &same);
    shrunk(mutate::pieces(&by_lines).into_iter().map(str::to_owned).collect(), &same)
}

fn shrunk(mut pieces: Vec<String>, same: &dyn Fn(&str) -> bool) -> String {
    let mut size = pieces.len().div_ceil(2).max(1);
    loop {
        let mut at = 0;
        while at < pieces.len() {
            let mut fewer = pieces.clone();
            fewer.drain(at..(at + size).min(pieces.len()));
            if same(&fewer.concat()) {
                pieces = fewer;
            } else {
                at += size;
            }
        }
        if size == 1 {
            return pieces.concat();
        }
        size /= 2;
    }
}
