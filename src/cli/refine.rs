//! `sgc refine`: looks more closely at what searches have found, and ranks it anew.

use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use clap::Args;
use rayon::prelude::*;

use super::countdown::Countdown;
use super::design::{self, Opened};
use super::exit;
use super::output::{self, Fault};
use crate::results::closely::{Closely, closely};
use crate::results::{archive, describe, front, place, run_files, series};

/// Simulate the designs of runs more closely, at half the step and with soft actuators, and rank them anew
#[derive(Args)]
pub(super) struct Refine {
    /// Runs, folders of several runs, or saved designs. For a run with an archive or a front, all of its designs are refined
    #[arg(value_name = "RUN|DESIGN", required = true)]
    of: Vec<PathBuf>,
}

/// A design, and what it comes to.
struct Ranked {
    path: PathBuf,
    opened: Opened,
    closely: Closely,
}

impl Refine {
    pub(super) fn run(self) -> Result<u8, Fault> {
        let mut paths: Vec<PathBuf> = Vec::new();
        for path in &self.of {
            for design in designs(path)? {
                if !paths.contains(&design) {
                    paths.push(design);
                }
            }
        }
        let mut opened = Vec::with_capacity(paths.len());
        for path in &paths {
            opened.push(design::open(path)?);
        }
        check_comparable(&paths, &opened)?;
        let (countdown, done, all) = (Mutex::new(Countdown::begin()), AtomicUsize::new(0), paths.len());
        let ranked: Result<Vec<Ranked>, Fault> = paths
            .into_par_iter()
            .zip(opened)
            .map(|(path, opened)| {
                let closely = closely(&opened.rules, &opened.design).map_err(|e| design::fault(&path, &e))?;
                let done = done.fetch_add(1, Ordering::Relaxed) + 1;
                if let Ok(mut countdown) = countdown.lock() {
                    countdown.tell("designs simulated", done, all);
                }
                Ok(Ranked { path, opened, closely })
            })
            .collect();
        output::data(&table(&mut ranked?))?;
        Ok(exit::DONE)
    }
}

/// The files of designs that a path means.
fn designs(path: &Path) -> Result<Vec<PathBuf>, Fault> {
    if place::is_series(path) {
        let mut all = Vec::new();
        // A run that has found nothing has nothing to rank.
        for run in series::runs(path).map_err(Fault::usage)? {
            if run_files::best(&run).exists() {
                all.extend(designs(&run)?);
            }
        }
        return Ok(all);
    }
    let several = [front::designs(path), archive::designs(path)].concat();
    Ok(if several.is_empty() { vec![design::file(path)] } else { several })
}

/// Values of another unit or direction cannot be ranked among these.
fn check_comparable(paths: &[PathBuf], opened: &[Opened]) -> Result<(), Fault> {
    let Some((first, rest)) = opened.split_first() else { return Ok(()) };
    let objective = |one: &Opened| (one.rules.objective.unit.clone(), one.rules.objective.direction);
    for (one, path) in rest.iter().zip(paths.iter().skip(1)) {
        if objective(one) != objective(first) {
            return Err(Fault::usage(format!(
                "the objective of {} has another unit or direction than that of {}: rank the two separately",
                path.display(),
                paths.first().map_or(Path::new(""), PathBuf::as_path).display()
            )));
        }
    }
    Ok(())
}

/// The designs, the best first, as text.
fn table(ranked: &mut [Ranked]) -> String {
    let Some(direction) = ranked.first().map(|one| one.opened.rules.objective.direction) else {
        return String::new();
    };
    let fitness = |one: &Ranked| one.closely.counts().map_or(f64::NEG_INFINITY, |x| direction.fitness(x));
    ranked.sort_by(|a, b| fitness(b).total_cmp(&fitness(a)));
    let mut text = format!("{:>14}{:>14}{:>14}   design\n", "soft rods", "half the step", "as found");
    for Ranked { path, opened, closely } in &*ranked {
        let cell = |value: &Result<f64, String>| match value {
            Ok(value) => describe::quantity(*value, &opened.rules.objective.unit),
            Err(_) => "-".to_owned(),
        };
        let rods = closely.rods.as_ref().map_or("-".to_owned(), cell);
        let found = describe::quantity(opened.design.value, &opened.design.unit);
        text += &format!("{rods:>14}{:>14}{found:>14}   {}\n", cell(&closely.half_step), path.display());
    }
    for Ranked { path, closely, .. } in &*ranked {
        let rods = closely.rods.as_ref().map(|rods| ("with soft rods", rods));
        let looks = [("at half the step", &closely.half_step)].into_iter().chain(rods);
        for (how, why) in looks.filter_map(|(how, value)| Some((how, value.as_ref().err()?))) {
            text += &format!("{}: no value {how}: {why}\n", path.display());
        }
    }
    text
}
