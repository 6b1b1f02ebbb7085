//! Reads the file of a study, checks all of it, and writes its folder.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use grammar_lang::diagnostics::Diagnostic;
use grammar_lang::diagnostics::render::{Format, render};
use grammar_lang::ir::RuleSet;

use super::Place;
use crate::cli::load::{self, Text};
use crate::cli::output::{self, Fault};
use crate::cli::price;
use crate::derive::Derivation;
use crate::loader::{Folder, tidy};
use crate::reading;
use crate::results::saved::Grammar;
use crate::simulate;
use crate::study::StudyError;
use crate::study::file::StudyFile;
use crate::study::folder::{Cell, Change, Study};
use crate::study::plan::{Wanted, cells};
use crate::study::standing::{Standing, standing};

/// Where the studies are whose folder is not named.
const STUDIES: &str = "studies";

/// How often a line tells how many cells are checked.
const EVERY: Duration = Duration::from_secs(5);

/// A study with all that its folder needs.
pub(super) struct Planned {
    pub(super) study: Study,
    file: PathBuf,
    text: String,
    cells: Vec<(Cell, Grammar)>,
    change: Change,
}

/// The study of a file, in its folder, which is made or brought up to the file.
pub(super) fn begin(file: &Path, place: &Place) -> Result<Study, Fault> {
    let planned = plan(file, place)?;
    planned.study.write(&planned.text, &planned.cells).map_err(Fault::usage)?;
    planned.tell_change();
    Ok(planned.study)
}

/// The same, and nothing is written.
pub(super) fn plan(file: &Path, place: &Place) -> Result<Planned, Fault> {
    let text =
        reading::named(file).map_err(|why| Fault::usage(format!("cannot read {}: {why}", file.display())))?;
    let text =
        String::from_utf8(text).map_err(|_| Fault::usage(format!("{} is not UTF-8 text", file.display())))?;
    let asked = StudyFile::parse(file, &text).map_err(Fault::usage)?;
    let seeds = asked.seeds().map_err(Fault::usage)?;
    let base = file.parent().unwrap_or(Path::new(""));
    let checked = check_all(&asked, &cells(&asked), base)?;
    comparable(&checked).map_err(Fault::usage)?;
    all_differ(file, &checked).map_err(Fault::usage)?;
    let name = file.file_stem().unwrap_or_default();
    let out = place.out.clone().unwrap_or_else(|| PathBuf::from(STUDIES).join(name));
    let factors = asked.factors().iter().map(|factor| factor.of.name().to_owned()).collect();
    let planned = Study::planned(&out, (file, &text), &asked.question, factors, &checked, seeds);
    let (study, change) = planned.map_err(Fault::usage)?;
    Ok(Planned { study, file: file.to_owned(), text, cells: checked, change })
}

impl Planned {
    /// The rules of its first cell.
    pub(super) fn first_rules(&self) -> Option<RuleSet> {
        self.cells.first()?.1.compile(env!("CARGO_PKG_VERSION")).ok()
    }

    /// Tells what a changed file changes.
    pub(super) fn tell_change(&self) {
        let Self { file, change, .. } = self;
        if change.new + change.left > 0 {
            output::note(&format!(
                "{} was changed: new runs: {}, removed runs: {} (their folders stay, and are not counted)",
                file.display(),
                change.new,
                change.left
            ));
        }
    }
}

/// Checks the grammar of every cell, and tells each finding once.
fn check_all(asked: &StudyFile, wanted: &[Wanted], base: &Path) -> Result<Vec<(Cell, Grammar)>, Fault> {
    let mut texts: Vec<Text> = Vec::new();
    // Texts are named from where the study's file is: a study is the same from wherever it is begun.
    let loader = Folder { path: base.to_owned() };
    let (mut told, mut wrong) = (BTreeSet::new(), 0);
    let mut found = Vec::with_capacity(wanted.len());
    let mut last = Instant::now();
    for (checked, one) in wanted.iter().enumerate() {
        if last.elapsed() > EVERY {
            last = Instant::now();
            output::note(&format!("checked {checked} of {} cells", wanted.len()));
        }
        let path = base.join(&one.grammar);
        if !texts.iter().any(|text| text.path == path) {
            texts.push(load::read(&path)?);
        }
        let Some(text) = texts.iter().find(|text| text.path == path) else { continue };
        let name = tidy(&one.grammar);
        let checked = load::check(
            &loader,
            &name.to_string_lossy(),
            &text.text,
            &one.parameters,
            one.variant.as_deref(),
        );
        let new = |finding: &&Diagnostic| told.insert(format!("{finding:?}"));
        let new = checked.diagnostics.iter().filter(new).cloned();
        let new: Vec<Diagnostic> = new.map(|finding| in_study(finding, &one.parameters)).collect();
        if !new.is_empty() {
            output::note(&format!("in `{}`:", one.name));
            output::note(render(&new, &checked.sources, Format::Full, output::colour_err()).trim_end());
        }
        let Some(rules) = checked.rules else {
            if checked.diagnostics.is_empty() {
                let module = "is a module for other grammars to use: it has no `grammar NAME` line";
                output::note(&format!("{} {module}", path.display()));
            }
            wrong += 1;
            continue;
        };
        let start = crate::cli::derive::start(&rules, &checked.sources, asked.from.as_deref());
        match start {
            Ok(_) => {}
            Err(fault) => {
                if !fault.message.is_empty() && told.insert(fault.message.clone()) {
                    output::note(&format!("in `{}`: {}", one.name, fault.message));
                }
                wrong += 1;
                continue;
            }
        }
        let grammar = Grammar::freeze(&rules, &checked.sources, &one.parameters);
        let from = asked.from.clone().or_else(|| rules.from.clone());
        let cell = Cell::new(one, &grammar, &rules, command(one, &path, asked.from.as_deref()), from);
        found.push((cell, grammar));
    }
    match wrong {
        0 => Ok(found),
        wrong => Err(Fault::input(format!(
            "{wrong} of the {} cells of this study have errors; nothing was run",
            wanted.len()
        ))),
    }
}

/// The command that does one run of a cell by itself, without its seed.
fn command(wanted: &Wanted, path: &Path, from: Option<&str>) -> String {
    let mut words = vec!["sgc run".to_owned(), output::typed(path)];
    words.extend(wanted.variant.iter().map(|name| format!("--variant {}", output::typed(Path::new(name)))));
    let set = |(name, value): &(String, String)| {
        format!("-p {}", output::typed(Path::new(&format!("{name}={value}"))))
    };
    words.extend(wanted.parameters.iter().map(set));
    words.extend(from.map(|name| format!("--from {}", output::typed(Path::new(name)))));
    words.push(format!("--max-evals {}", wanted.max_evals.unwrap_or(0)));
    words.join(" ")
}

/// Refuses cells whose values cannot be told together.
fn comparable(cells: &[(Cell, Grammar)]) -> Result<(), StudyError> {
    let how = |cell: &Cell| {
        let verb = if cell.minimizes { "minimises" } else { "maximises" };
        let unit = if cell.unit.is_empty() { "no unit" } else { &cell.unit };
        format!("{verb} in {unit}")
    };
    let Some(((first, _), others)) = cells.split_first() else { return Ok(()) };
    match others.iter().find(|(other, _)| how(other) != how(first)) {
        Some((other, _)) => Err(StudyError::Incomparable {
            one: first.name.clone(),
            how: how(first),
            other: other.name.clone(),
            otherwise: how(other),
        }),
        None => Ok(()),
    }
}

/// Refuses two names for the same runs, such as `60 g` and `0.06 kg`.
fn all_differ(file: &Path, cells: &[(Cell, Grammar)]) -> Result<(), StudyError> {
    let mut known: BTreeMap<(&str, Option<u64>), &str> = BTreeMap::new();
    for (cell, _) in cells {
        if let Some(one) = known.insert((&cell.rules, cell.max_evals), &cell.name) {
            let (path, one, other) = (file.to_owned(), one.to_owned(), cell.name.clone());
            return Err(StudyError::Alike { path, one, other });
        }
    }
    Ok(())
}

/// What a finding of a grammar says where a study sets its parameters, not the command line.
fn in_study(mut finding: Diagnostic, set: &[(String, String)]) -> Diagnostic {
    let told = |text: &str| {
        let text = text.replace("given with `-p`", "given by the study");
        set.iter().fold(text, |text, (name, _)| text.replace(&format!("`-p {name}="), &format!("`{name} = ")))
    };
    finding.message = told(&finding.message);
    finding.help = finding.help.as_deref().map(told);
    for label in &mut finding.labels {
        label.text = told(&label.text);
    }
    finding
}

/// Tells what a study comes to.
pub(super) fn tell(study: &Study) {
    let levels = |factor: usize| {
        let all: BTreeSet<&str> = study.cells().iter().map(|cell| cell.levels[factor].as_str()).collect();
        all.len()
    };
    let counts: Vec<String> = study
        .factors()
        .iter()
        .enumerate()
        .map(|(place, name)| (levels(place), name))
        .filter(|(many, _)| *many > 1)
        .map(|(many, name)| format!("{many} of {name}"))
        .chain([format!("{} seeds", study.seeds().len())])
        .collect();
    output::note(&format!(
        "{}: {} runs ({})",
        study.path().display(),
        study.cells().len() * study.seeds().len(),
        counts.join(" x ")
    ));
}

/// Tells what the runs cost that are not complete, by a body of the first cell, which has these rules.
pub(super) fn price(study: &Study, rules: &RuleSet, flag: &AtomicBool) {
    let Some(cell) = study.cells().first() else { return };
    let open = study.runs().filter(|run| standing(study, *run) != Standing::Complete);
    let all = open
        .map(|run| study.cell(run).max_evals)
        .try_fold(0, |sum: u64, of_run| Some(sum.saturating_add(of_run?)));
    if all == Some(0) {
        return;
    }
    let told = || -> Option<String> {
        let first = Derivation::start(rules, cell.from.as_deref()).ok()?;
        price::told(rules, &first, simulate::model(&cell.solver)?, all, flag)
    };
    if let Some(price) = told() {
        output::note(&price);
    }
}
