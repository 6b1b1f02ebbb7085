//! The saved design: one JSON file that holds all that is needed to see it move again.

use std::collections::BTreeMap;
use std::path::Path;

use grammar_lang::ir::{Direction, RuleSet, without_spans};
use grammar_lang::source::SourceMap;
use indexmap::IndexMap;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::names::Names;
use super::unambiguous::Unambiguous;
use super::{DesignError, FileError, Unfit};
use crate::derive::{Derivation, Step};
use crate::loader::Frozen;
use crate::reading;
use crate::score::Observed;

/// The version of the file format.
pub const VERSION: u32 = 2;
const FORMAT: &str = "sgc design";

/// Texts of a grammar, frozen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Grammar {
    /// The grammar's name.
    pub name: String,
    /// Hash of the typed rule set.
    pub rules: String,
    /// The text that declares the grammar.
    pub entry: String,
    /// Parameters that were set from outside.
    pub parameters: Vec<(String, String)>,
    /// Every text by name.
    pub sources: BTreeMap<String, String>,
}

/// A cross-check of a value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Check {
    /// What was changed.
    pub name: String,
    /// What was measured then; none if the evaluation was invalid.
    pub value: Option<f64>,
    /// What that is.
    #[serde(default, skip_serializing_if = "Measured::is_value")]
    pub measured: Measured,
    /// Why the evaluation was invalid, in words, if it was.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub why: Option<String>,
}

impl Check {
    /// What a measurement came to.
    pub(super) fn new(name: &str, measured: Measured, found: Result<f64, DesignError>) -> Self {
        let why = found.as_ref().err().map(ToString::to_string);
        Self { name: name.to_owned(), value: found.ok(), measured, why }
    }
}

/// What several tasks come to together and each objective of a front, with the cross-checks of that.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OfAll {
    /// What each objective of the grammar is where nothing moves; what has no value there is 0.
    pub at_rest: Vec<f64>,
    /// The cross-checks.
    pub checks: Vec<CheckOfAll>,
}

/// A cross-check of all objectives of a grammar.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CheckOfAll {
    /// What was changed.
    pub name: String,
    /// What each objective comes to then, in their order; empty if a motion is not valid.
    pub values: Vec<f64>,
    /// Why it is not, in words.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub why: Option<String>,
}

/// What a cross-check measures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Measured {
    /// The value of the task, in its unit.
    #[default]
    Value,
    /// The same over all worlds that it depends on.
    InWorlds,
    /// The value with all actuators held where they begin: what comes of itself.
    Held,
    /// How far the centre of mass gets from where it began, along the ground, m.
    Drift,
    /// By how much angular momentum turns the body about the vertical, rad, where nothing can give it any.
    Spin,
    /// The work of all actuators, as a share of what it is in steps of the model.
    Work,
    /// Nothing: the solver cannot simulate such a body.
    Unable,
    /// How far the centre of an element sinks below the floor, m: what comes of such a motion says nothing.
    Sunk,
    /// The same of an element that gets inside another one.
    Interlocked,
}

impl Measured {
    fn is_value(&self) -> bool {
        *self == Self::Value
    }
}

/// A design with its drive, derivation and score.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SavedDesign {
    format: String,
    version: u32,
    /// The version of sgc that wrote it.
    pub sgc: String,
    /// The grammar that made it.
    pub grammar: Grammar,
    /// The seed of the run.
    pub seed: u64,
    /// The solver that gave the value.
    pub solver: String,
    /// The number of the move that found it.
    pub found_at: usize,
    /// The value of the objective.
    pub value: f64,
    /// The unit of the value; empty if it has none.
    pub unit: String,
    /// What it comes to in the objectives beside the first, where a front was searched for.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub beside: Vec<Beside>,
    /// What it loses by preferences that it does not fulfil.
    pub penalties: Vec<(String, f64)>,
    /// What was observed of its motion in the first task, in SI units.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub observed: IndexMap<String, Option<Observed>>,
    /// What people call its parts: see [`SavedDesign::names`]. Designs of earlier versions say nothing.
    #[serde(default, rename = "names", skip_serializing_if = "Names::is_empty")]
    pub own_names: Names,
    /// What it does in each task.
    pub tasks: Vec<SavedTask>,
    /// What they come to together, and in each objective of a front, where that was cross-checked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub of_all: Option<OfAll>,
    /// Hash of the body, whatever its derivation.
    pub body: String,
    /// The steps that made the body.
    pub derivation: Vec<Step>,
}

/// What a design comes to in an objective beside the first.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Beside {
    /// What the objective is of.
    pub objective: String,
    /// The value.
    pub value: f64,
    /// Its unit; empty if it has none.
    pub unit: String,
}

impl Beside {
    /// Whether it says the same, to the bit.
    pub(super) fn is_same(&self, other: &Self) -> bool {
        let Self { objective, value, unit } = other;
        (&self.objective, self.value.to_bits(), &self.unit) == (objective, value.to_bits(), unit)
    }
}

/// What a design does in one task.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SavedTask {
    /// The task's name; empty in a grammar that names no tasks.
    pub name: String,
    /// The value of its objective.
    pub value: f64,
    /// What the objective is of its motion in the nominal world alone, where it runs over others, too.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nominal: Option<f64>,
    /// What it is where nothing moves, if that is more than a constant in the text of the objective: what the motion is worth lies
    /// beyond that.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at_rest: Option<f64>,
    /// The unit of the value; empty if it has none.
    pub unit: String,
    /// The terms in SI units.
    pub terms: Vec<(String, f64)>,
    /// Cross-checks of the value.
    pub checks: Vec<Check>,
    /// What it comes to in worlds that the search never saw, where the task names scenarios.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tests: Vec<InWorld>,
    /// Its value over those worlds and the nominal one, where the worlds one by one do not tell it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tested: Option<f64>,
    /// The varied quantities of the drive in SI units, with what they are.
    pub drive: Vec<(String, f64)>,
}

/// What a task comes to in one world.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InWorld {
    /// What the world is called.
    pub name: String,
    /// In words what differs there.
    pub differs: String,
    /// The value there; none if the motion is not valid.
    pub value: Option<f64>,
}

impl SavedDesign {
    /// A value of its only task as the whole objective has it: less what the design gives up by preferences that it does not
    /// fulfil. Where there are several tasks, as it is: what they come to together is the grammar's to say.
    #[must_use]
    pub fn less_penalties(&self, direction: Direction, value: f64) -> f64 {
        match self.tasks.as_slice() {
            [_] => self.penalties.iter().fold(value, |value, (_, weight)| direction.worse_by(value, *weight)),
            _ => value,
        }
    }
}

impl SavedTask {
    /// The value in the nominal world: what cross-checks are compared with.
    #[must_use]
    pub fn in_nominal(&self) -> f64 {
        self.nominal.unwrap_or(self.value)
    }

    /// The varied quantities without their names.
    #[must_use]
    pub fn parameters(&self) -> Vec<f64> {
        self.drive.iter().map(|(_, x)| *x).collect()
    }
}

/// The hash of a typed rule set, whatever the places and comments in its texts.
#[must_use]
pub fn rules_hash(rules: &RuleSet) -> String {
    // A rule set always serialises: its maps have text keys.
    let text = without_spans(rules).unwrap_or_default().to_string();
    hex(&Sha256::digest(text.as_bytes()))
}

/// A hash as text.
pub(crate) fn hex(hash: &[u8]) -> String {
    hash.iter().map(|b| format!("{b:02x}")).collect()
}

impl Grammar {
    /// Freezes the texts of a grammar.
    #[must_use]
    pub fn freeze(rules: &RuleSet, sources: &SourceMap, overrides: &[(String, String)]) -> Self {
        let entry = sources.iter().next().map_or(String::new(), |(_, s)| s.name.clone());
        Self {
            name: rules.name.clone(),
            rules: rules_hash(rules),
            entry,
            parameters: overrides.to_vec(),
            sources: sources.iter().map(|(_, s)| (s.name.clone(), s.text.clone())).collect(),
        }
    }

    /// Compiles the texts again that a version of sgc froze. Another version may read them differently: whether a design
    /// is then what it was, its body and its values tell.
    ///
    /// # Errors
    ///
    /// A sentence that says what does not fit.
    pub fn compile(&self, sgc: &str) -> Result<RuleSet, DesignError> {
        Ok(self.compile_with_sources(sgc)?.0)
    }

    /// The same, with the texts, to show places in them.
    ///
    /// # Errors
    ///
    /// A sentence that says what does not fit.
    pub fn compile_with_sources(&self, sgc: &str) -> Result<(RuleSet, SourceMap), DesignError> {
        let (rules, sources) = self.compiled()?;
        if sgc == env!("CARGO_PKG_VERSION") && rules_hash(&rules) != self.rules {
            return Err(DesignError::OtherRules);
        }
        Ok((rules, sources))
    }

    /// Compiles the texts as they are, also where they were edited since.
    ///
    /// # Errors
    ///
    /// A sentence that says what is missing or wrong.
    pub fn compile_edited(&self) -> Result<RuleSet, DesignError> {
        Ok(self.compiled()?.0)
    }

    fn compiled(&self) -> Result<(RuleSet, SourceMap), DesignError> {
        let loader = Frozen { texts: self.sources.clone() };
        let text = self.sources.get(&self.entry).ok_or(DesignError::NoText)?;
        let mut sources = SourceMap::default();
        let entry = sources.add(self.entry.clone(), text.clone());
        let compiled =
            grammar_lang::compile(&loader, &mut sources, entry, &self.parameters, Some(&self.name));
        Ok((compiled.ruleset.ok_or(DesignError::Unreadable)?, sources))
    }
}

/// A hash of what a design says, whatever its layout.
fn checksum(value: &serde_json::Value) -> String {
    hex(&Sha256::digest(value.to_string()))
}

impl SavedDesign {
    /// Fills in the constant fields.
    #[must_use]
    #[allow(clippy::too_many_arguments)]
    pub fn new(
        grammar: Grammar,
        seed: u64,
        solver: &str,
        found_at: usize,
        (value, unit): (f64, &str),
        (derivation, body): (&Derivation, String),
    ) -> Self {
        Self {
            format: FORMAT.to_owned(),
            version: VERSION,
            sgc: env!("CARGO_PKG_VERSION").to_owned(),
            grammar,
            seed,
            solver: solver.to_owned(),
            found_at,
            value,
            unit: unit.to_owned(),
            beside: Vec::new(),
            penalties: Vec::new(),
            observed: IndexMap::new(),
            own_names: Names::default(),
            tasks: Vec::new(),
            of_all: None,
            body,
            derivation: derivation.recorded(),
        }
    }

    /// Says why something of it does not come out again: the program is another one, or else for the reason `own`.
    #[must_use]
    pub fn differs(&self, own: DesignError) -> DesignError {
        let what = match &own {
            DesignError::OtherValue => "it has another value".to_owned(),
            DesignError::OtherBody => "its steps lead to another body".to_owned(),
            DesignError::Other { what } => format!("{what} is different"),
            _ => return own,
        };
        match self.sgc == env!("CARGO_PKG_VERSION") {
            true => own,
            false => DesignError::OtherProgram { theirs: self.sgc.clone(), what },
        }
    }

    /// The task of a name; the first, if none is named.
    ///
    /// # Errors
    ///
    /// A sentence that tells the names of its tasks.
    pub fn task(&self, name: Option<&str>) -> Result<&SavedTask, DesignError> {
        let Some(name) = name else { return self.tasks.first().ok_or(DesignError::NoTask) };
        self.tasks.iter().find(|task| task.name == name).ok_or_else(|| DesignError::UnknownTask {
            name: name.to_owned(),
            there: self.tasks.iter().map(|task| task.name.clone()).collect(),
        })
    }

    /// What people call its parts, also those that are gone in the end: as it says, and what it says nothing of as
    /// [`Names`] have it. `derivation` is the one that its steps lead to.
    #[must_use]
    pub fn names(&self, rules: &RuleSet, derivation: &Derivation) -> Names {
        let names = match &rules.lattice {
            Some(_) => Names::of(rules, &derivation.design),
            None => Names::through(rules, derivation),
        };
        names.but(&self.own_names)
    }

    /// Reads a file.
    ///
    /// # Errors
    ///
    /// A sentence that says what is wrong with it.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        Self::of_bytes(path, &reading::named(path).map_err(FileError::read(path))?)
    }

    /// Reads a file of a run's folder.
    ///
    /// # Errors
    ///
    /// A sentence that says what is wrong with it.
    pub fn read_own(path: &Path) -> Result<Self, FileError> {
        Self::of_bytes(path, &reading::own(path).map_err(FileError::read(path))?)
    }

    /// Refuses to be written over a file that is no design of the same run: somebody has put it there, or edited it.
    ///
    /// # Errors
    ///
    /// [`Unfit::NotOwn`] with the file.
    pub(super) fn check_replaces(&self, file: &Path) -> Result<(), FileError> {
        if !file.exists() {
            return Ok(());
        }
        let why = match Self::read_own(file) {
            Ok(there) if (there.seed, &there.grammar.rules) == (self.seed, &self.grammar.rules) => {
                return Ok(());
            }
            Ok(_) => "it is a design of another run".to_owned(),
            Err(why) => why.to_string(),
        };
        Err(FileError::unfit(file, Unfit::NotOwn { why }))
    }

    fn of_bytes(path: &Path, bytes: &[u8]) -> Result<Self, FileError> {
        let unfit = |why| Err(FileError::unfit(path, why));
        if path.extension().is_some_and(|extension| extension == "sgr") {
            return unfit(Unfit::Grammar);
        }
        let value = serde_json::from_slice(bytes);
        let Unambiguous(mut value) = value.map_err(|e| FileError::unfit(path, Unfit::NotJson(e)))?;
        if value.get("format").and_then(|f| f.as_str()) != Some(FORMAT) {
            return unfit(Unfit::NoDesign { format: FORMAT });
        }
        match value.get("version").and_then(serde_json::Value::as_u64) {
            Some(version) if version == u64::from(VERSION) => {}
            version => {
                let theirs = version.map_or("an unknown version".to_owned(), |v| format!("version {v}"));
                return unfit(Unfit::OtherVersion { theirs, own: VERSION });
            }
        }
        let sum = value.as_object_mut().and_then(|fields| fields.remove("sum"));
        let is_same = sum.is_some_and(|sum| sum.as_str() == Some(&checksum(&value)));
        let design = serde_json::from_value(value).map_err(FileError::damaged(path))?;
        if !is_same {
            return unfit(Unfit::Edited);
        }
        Ok(design)
    }

    /// The text of the file, with a checksum of all that it says.
    #[must_use]
    pub fn text(&self) -> String {
        // Plain data always serialises.
        let text = serde_json::to_string_pretty(self).unwrap_or_default();
        let sum = checksum(&serde_json::to_value(self).unwrap_or_default());
        format!("{},\n  \"sum\": \"{sum}\"\n}}\n", text.strip_suffix("\n}").unwrap_or_default())
    }
}
