//! `sgc check --fix`: mends what can be mended for certain.
//!
//! All is tried on copies first. A round applies every fix that is offered and checks again; if that
//! gives more errors, or a line that was mended still cannot be read, half of the fixes is tried, and so on, and those that do
//! harm are left out for good. Only then is each file written, once and whole.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use thiserror::Error;

use grammar_lang::diagnostics::{Code, Diagnostic, Edit, Together, apply};
use grammar_lang::source::{FileId, SourceMap};
use similar::TextDiff;

use super::load::{self, STDIN, Text};
use super::output::{self, Fault};
use crate::loader::{Edited, LIBRARY, read_text};
use crate::results::whole::{is_open_already, rewrite};
use crate::results::{FileError, Unwritable};

/// How often the texts are mended and checked again: one fix may uncover the next.
const ROUNDS: usize = 100;
/// So often some of the fixes are tried, where all together do harm: each trial is a check of all texts.
const TRIALS: usize = 100;

/// The texts that a check has read, each once: many fixes may be of one of them.
type Read = BTreeMap<FileId, Rc<str>>;

/// A fix that a check offers.
#[derive(Clone)]
struct Offer {
    /// Which text, whatever the check called it.
    key: PathBuf,
    /// The text as it is.
    text: Rc<str>,
    edits: Vec<Edit>,
    /// The lines that it changes, as they are counted afterwards; other fixes add no lines before them.
    lines: Vec<usize>,
    /// What is told about it: place and message.
    told: String,
    /// The same fix is known by this in the next round, when places have moved.
    mark: String,
}

impl Offer {
    /// Whether two offers change the same text in the same way.
    fn is_same(&self, other: &Self) -> bool {
        let edits = |offer: &Self| -> Vec<(std::ops::Range<usize>, String)> {
            offer.edits.iter().map(|edit| (edit.span.range(), edit.replacement.clone())).collect()
        };
        self.key == other.key && edits(self) == edits(other)
    }
}

/// What a check of all texts gave.
struct State {
    errors: usize,
    offers: Vec<Offer>,
    /// The lines that cannot be read, by text, counted from 1.
    unread: BTreeSet<(PathBuf, usize)>,
}

impl State {
    /// Whether fixes that led here did no harm: no more errors than there were, and each of their lines can be read.
    fn is_sound(&self, errors: usize, offers: &[&Offer]) -> bool {
        let mut lines =
            offers.iter().flat_map(|offer| offer.lines.iter().map(|line| (offer.key.clone(), *line)));
        self.errors <= errors && lines.all(|line| !self.unread.contains(&line))
    }
}

struct Session<'a> {
    texts: &'a [Text],
    overrides: &'a [(String, String)],
    loader: Edited,
    /// The texts that were changed, as they were.
    originals: BTreeMap<PathBuf, String>,
    /// What was done to which text.
    done: Vec<(PathBuf, String)>,
    /// The marks of fixes that do harm.
    refused: BTreeSet<String>,
    /// How often some of the fixes may still be tried.
    left: usize,
}

/// What becomes of what was mended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outcome {
    /// The files are written.
    Written,
    /// The differences are printed, and nothing is written.
    Shown,
}

/// Mends texts, writes the files that changed or shows what would change, and says so. Gives the files as they
/// are then.
pub(super) fn mend(
    texts: &[Text],
    overrides: &[(String, String)],
    outcome: Outcome,
) -> Result<Edited, Fault> {
    let mut session = Session {
        texts,
        overrides,
        loader: Edited::default(),
        originals: BTreeMap::new(),
        done: Vec::new(),
        refused: BTreeSet::new(),
        left: TRIALS,
    };
    let mut state = session.look(&session.loader);
    for _ in 0..ROUNDS {
        let Some(next) = session.round(state) else { break };
        state = next;
    }
    match outcome {
        Outcome::Written => session.write()?,
        Outcome::Shown => {
            session.show()?;
            return Ok(Edited::default());
        }
    }
    Ok(session.loader)
}

impl Session<'_> {
    /// Checks all texts in a loader.
    fn look(&self, loader: &Edited) -> State {
        let mut state = State { errors: 0, offers: Vec::new(), unread: BTreeSet::new() };
        for Text { name, text, .. } in self.texts {
            let text = loader.get(name).unwrap_or(text);
            for checked in load::check_all(loader, name, text, self.overrides, &mut |_| {}) {
                state.errors += checked.diagnostics.iter().filter(|d| Diagnostic::is_error(d)).count();
                let mut read = Read::new();
                let offers = checked.diagnostics.iter().filter_map(|d| offer(d, &checked.sources, &mut read));
                state.offers.extend(offers.filter(|o| !self.refused.contains(&o.mark)));
                let syntax = [Code::SYNTAX.id, Code::UNCLOSED.id, Code::UNKNOWN_KEYWORD.id];
                for error in checked.diagnostics.iter().filter(|d| syntax.contains(&d.code.id)) {
                    let source = checked.sources.get(error.span().file);
                    let key = source.map_or_else(PathBuf::new, |source| Edited::key(&source.name));
                    state.unread.insert((key, checked.sources.line_column(error.span()).0));
                }
            }
        }
        self.keep_own(loader, &mut state.offers);
        state
    }

    /// Leaves out the edits of files that nobody named where the file on its own gives no reason for them:
    /// what a variant changes may make its base look wrong, which is as it should be.
    fn keep_own(&self, loader: &Edited, offers: &mut Vec<Offer>) {
        let named: BTreeSet<PathBuf> = self.texts.iter().map(|text| Edited::key(&text.name)).collect();
        let mut alone: BTreeMap<PathBuf, Vec<Offer>> = BTreeMap::new();
        offers.retain(|offered| {
            if named.contains(&offered.key) {
                return true;
            }
            let own = alone.entry(offered.key.clone()).or_insert_with(|| alone_of(loader, offered));
            own.iter().any(|own| own.is_same(offered))
        });
    }

    /// Applies what can be applied; `None` if nothing can.
    fn round(&mut self, state: State) -> Option<State> {
        let together = compatible(&state.offers);
        if together.is_empty() {
            return None;
        }
        if let Some(next) = self.attempt(&together, state.errors) {
            return Some(next);
        }
        if self.left == 0 {
            output::note(&format!("the rest is left as it is: sgc tried fixes {TRIALS} times"));
            return None;
        }
        let (mut good, mut bad) = (Vec::new(), Vec::new());
        self.sort_out(&together, state.errors, &mut good, &mut bad);
        for offer in bad {
            let why = "more errors would be found afterwards, or the line could still not be read";
            output::note(&format!("not mended {}: {why}", offer.told));
            self.refused.insert(offer.mark.clone());
        }
        self.attempt(&good, state.errors).or_else(|| Some(self.look(&self.loader)))
    }

    /// Sorts fixes that do harm together: into those that do none with those before them, and others. Halves
    /// are tried, and
    /// halves of these, as most fixes do no harm. Gives how many errors are left with the good ones.
    fn sort_out<'o>(
        &mut self,
        offers: &[&'o Offer],
        errors: usize,
        good: &mut Vec<&'o Offer>,
        bad: &mut Vec<&'o Offer>,
    ) -> usize {
        let mut errors = errors;
        let halves = offers.split_at(offers.len().div_ceil(2));
        for half in [halves.0, halves.1] {
            if half.is_empty() || self.left == 0 {
                continue;
            }
            self.left -= 1;
            let with: Vec<&Offer> = good.iter().chain(half).copied().collect();
            let state = self.trial(&with).1;
            match half {
                _ if state.is_sound(errors, &with) => {
                    errors = state.errors;
                    good.extend(half);
                }
                [alone] => bad.push(alone),
                _ => errors = self.sort_out(half, errors, good, bad),
            }
        }
        errors
    }

    /// The files after some fixes, and what a check of it gives.
    fn trial(&self, offers: &[&Offer]) -> (Edited, State) {
        let mut loader = self.loader.clone();
        for (key, (text, edits)) in by_text(offers) {
            if let Some(mended) = apply(text, edits) {
                loader.set(key, mended);
            }
        }
        let state = self.look(&loader);
        (loader, state)
    }

    /// Keeps some fixes if they do no harm.
    fn attempt(&mut self, offers: &[&Offer], errors: usize) -> Option<State> {
        if offers.is_empty() {
            return None;
        }
        let (loader, state) = self.trial(offers);
        if !state.is_sound(errors, offers) {
            return None;
        }
        for offer in offers {
            self.originals.entry(offer.key.clone()).or_insert_with(|| offer.text.to_string());
            self.done.push((offer.key.clone(), offer.told.clone()));
        }
        self.loader = loader;
        Some(state)
    }

    /// Prints what would change, as a difference that `patch` reads.
    fn show(&self) -> Result<(), Fault> {
        for (key, original) in &self.originals {
            let mended = self.loader.at(key).unwrap_or(original);
            let name = self.texts.iter().find(|text| Edited::key(&text.name) == *key);
            let name = name.map_or_else(|| key.display().to_string(), |text| text.name.clone());
            let difference = TextDiff::from_lines(original.as_str(), mended);
            output::data(&difference.unified_diff().header(&name, &name).to_string())?;
        }
        if self.done.is_empty() {
            output::note("nothing would be mended: no finding has a certain fix");
        }
        Ok(())
    }

    /// Writes what has changed, each file once and whole.
    fn write(&self) -> Result<(), Fault> {
        for (key, original) in &self.originals {
            let mended = self.loader.at(key).unwrap_or(original);
            if key.as_os_str() != STDIN {
                // By the name that the user gave: `/dev/stdin` is no name of the file that it leads to.
                let named = self.texts.iter().find(|text| Edited::key(&text.name) == *key);
                let path = named.map_or(key.as_path(), |text| Path::new(&text.name));
                replace(path, original, mended)
                    .map_err(|e| Fault::usage(format!("cannot mend {}: {e}", path.display())))?;
            }
            for (_, told) in self.done.iter().filter(|(of, _)| of == key) {
                output::note(&format!("mended {told}"));
            }
        }
        if self.done.is_empty() {
            output::note("nothing was mended: no finding has a certain fix");
        }
        // A text from standard input is printed, mended or not.
        for text in self.texts.iter().filter(|t| t.name == STDIN) {
            output::data(self.loader.get(STDIN).unwrap_or(&text.text))?;
        }
        Ok(())
    }
}

/// The fix of a finding, if it changes a text that is the user's own.
fn offer(diagnostic: &Diagnostic, sources: &SourceMap, read: &mut Read) -> Option<Offer> {
    let fix = diagnostic.fix.as_ref()?;
    let first = fix.edits.first()?;
    let source = sources.get(first.span.file)?;
    let library = LIBRARY.iter().any(|(name, _)| *name == source.name);
    if library || fix.edits.iter().any(|e| e.span.file != first.span.file) {
        return None;
    }
    let (line, column) = sources.line_column(first.span);
    let (before, after) = source.text.split_at_checked(first.span.range().start)?;
    let begin = before.rfind('\n').map_or(0, |end| end + 1);
    let end = before.len() + after.find('\n').unwrap_or(after.len());
    let around = source.text.get(begin..end).unwrap_or("").trim();
    let text = read.entry(first.span.file).or_insert_with(|| source.text.as_str().into());
    Some(Offer {
        key: Edited::key(&source.name),
        text: Rc::clone(text),
        edits: fix.edits.clone(),
        lines: fix.edits.iter().map(|edit| sources.line_column(edit.span).0).collect(),
        told: format!("{}:{line}:{column}: {}", source.name, fix.message),
        mark: format!("{}\n{}\n{around}", source.name, fix.message),
    })
}

/// What a check offers of a text by itself.
fn alone_of(loader: &Edited, offered: &Offer) -> Vec<Offer> {
    let checked = load::check_all(loader, &offered.key.to_string_lossy(), &offered.text, &[], &mut |_| {});
    let of = |checked: &load::Checked| {
        let mut read = Read::new();
        let offers = checked.diagnostics.iter().filter_map(|d| offer(d, &checked.sources, &mut read));
        offers.collect::<Vec<_>>()
    };
    checked.iter().flat_map(of).collect()
}

/// The offers that can be taken together, first come, first served.
fn compatible(offers: &[Offer]) -> Vec<&Offer> {
    let mut taken: BTreeMap<&Path, Together> = BTreeMap::new();
    offers.iter().filter(|o| taken.entry(&o.key).or_default().add(&o.text, &o.edits)).collect()
}

type Edits<'o> = (&'o str, Vec<&'o Edit>);

/// The edits of some offers by text.
fn by_text<'o>(offers: &[&'o Offer]) -> BTreeMap<&'o Path, Edits<'o>> {
    let mut texts: BTreeMap<&Path, Edits<'_>> = BTreeMap::new();
    for offer in offers {
        let (_, edits) = texts.entry(&offer.key).or_insert((&offer.text, Vec::new()));
        edits.extend(&offer.edits);
    }
    texts
}

/// Why a file keeps the text that it has.
#[derive(Debug, Error)]
pub(super) enum Unmended {
    #[error("it was changed by another program in the meantime")]
    Changed,
    #[error("it is read-only")]
    ReadOnly,
    #[error("{}", Unwritable::Open)]
    Open,
    #[error(transparent)]
    System(#[from] std::io::Error),
    #[error(transparent)]
    Unwritten(#[from] FileError),
}

/// Replaces the content of a file that still is as it was read.
pub(super) fn replace(path: &Path, original: &str, mended: &str) -> Result<(), Unmended> {
    if is_open_already(path) {
        return Err(Unmended::Open);
    }
    if read_text(path)? != original {
        return Err(Unmended::Changed);
    }
    if std::fs::metadata(path)?.permissions().readonly() {
        return Err(Unmended::ReadOnly);
    }
    Ok(rewrite(path, mended)?)
}
