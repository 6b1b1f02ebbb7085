//! Saved designs that somebody names on the command line.

use crate::results::place;
use crate::results::run_files;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::path::{Path, PathBuf};

use grammar_lang::ir::{ActionSpace, RuleSet, Ty};
use grammar_lang::source::SourceMap;
use grammar_lang::units;

use super::exit;
use super::load;
use super::output::{self, Fault};
use crate::derive::Derivation;
use crate::design::Body;
use crate::results::DesignError;
use crate::results::genuine;
use crate::results::replay::{Precision, replay};
use crate::results::saved::SavedDesign;
use crate::results::saving;

/// The file that a design or run folder means.
pub(super) fn file(path: &Path) -> PathBuf {
    if path.is_dir() { run_files::best(path) } else { path.to_owned() }
}

/// Reads the design that a file or run folder means; `path` is the file, as [`file`] gives it.
pub(super) fn read(path: &Path) -> Result<SavedDesign, Fault> {
    let is_best = path.file_name() == run_files::best(Path::new("")).file_name();
    if let Some(folder) = path.parent().filter(|_| is_best && !path.exists()) {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let typed = output::typed(folder);
        if place::is_series(folder) {
            let seeds = folder.join("seed-N");
            return Err(Fault::usage(format!(
                "{typed} holds several runs: name one of them, {}; `sgc report {typed}` compares them",
                seeds.display()
            )));
        }
        if let Ok(Some(finished)) = run_files::finished(folder) {
            return Err(Fault::usage(match finished.value {
                Some(_) => format!(
                    "the run in {typed} is complete, but its best design is not there: {} was moved or removed",
                    path.display()
                ),
                None => format!("the run in {typed} is complete, but found no design"),
            }));
        }
        if run_files::is_run(folder) {
            return Err(Fault::usage(format!(
                "the run in {typed} has found no design yet; it goes on with: sgc resume {typed}"
            )));
        }
    }
    // What a run keeps is a file, whatever stands there; what somebody names may be a pipe.
    let Some(folder) = path.parent().filter(|folder| is_best && run_files::is_run(folder)) else {
        return SavedDesign::read(path).map_err(Fault::usage);
    };
    let design = SavedDesign::read_own(path).map_err(Fault::usage)?;
    genuine::check_best(folder, &design).map_err(Fault::usage)?;
    Ok(design)
}

/// A saved design, and the rule set of the grammar that made it, with its texts.
pub(super) struct Opened {
    pub(super) design: SavedDesign,
    pub(super) rules: RuleSet,
    pub(super) sources: SourceMap,
}

/// Opens a design that leads to the body that it says; what else it says is for its simulation to tell.
pub(super) fn open(path: &Path) -> Result<Opened, Fault> {
    let design = read(path)?;
    let fault = |reason: DesignError| Fault::usage(format!("{}: {reason}", path.display()));
    let (rules, sources) = design.grammar.compile_with_sources(&design.sgc).map_err(fault)?;
    genuine::check_body(&rules, &design).map_err(fault)?;
    Ok(Opened { design, rules, sources })
}

/// Checks that a design says of itself what its simulation says. One of another version of sgc that simulates
/// otherwise is told, and then has the values of this one: its body and curves are what they were.
pub(super) fn as_simulated(path: &Path, rules: &RuleSet, design: SavedDesign) -> Result<SavedDesign, Fault> {
    let told = |e: DesignError| fault(path, &e);
    let replayed = replay(rules, &design, &design.solver, Precision::Model).map_err(told)?;
    match genuine::check_values(rules, &design, &replayed) {
        Err(other @ DesignError::OtherProgram { .. }) => {
            let Ok(now) = saving::as_simulated(rules, &design, &replayed) else { return Err(told(other)) };
            output::note(&format!("{}: {other}; the results below are from this version", path.display()));
            Ok(now)
        }
        Err(changed) => Err(told(changed)),
        Ok(()) => Ok(design),
    }
}

/// The same, to be judged by another grammar, if one is named: then the design may be of an older text of it.
pub(super) fn open_by(
    path: &Path,
    grammar: Option<&Path>,
    params: &[(String, String)],
    variant: Option<&str>,
) -> Result<Opened, Fault> {
    let Some(file) = grammar else { return open(path) };
    let design = read(path)?;
    let (rules, sources) = load::grammar(file, params, variant)?;
    check_enumerations(path, &design, &rules)?;
    if let Some(other) = other_quantity(&design, &rules) {
        return Err(Fault::input(format!(
            "{}: {other}, so its saved number would have another meaning; give the variable its earlier type, or another name",
            path.display()
        )));
    }
    tell_other_parameters(path, &design, &rules, params);
    tell_other_body(path, &design, &rules);
    Ok(Opened { design, rules, sources })
}

/// A variable that is another quantity in a grammar than where a design was made: its saved number would mean something else.
pub(super) fn other_quantity(design: &SavedDesign, rules: &RuleSet) -> Option<String> {
    let theirs = design.grammar.compile(&design.sgc).ok()?;
    rules.tasks.keys().find_map(|task| {
        let (now, before) = (quantities(rules, task), quantities(&theirs, task));
        let differs = |(name, is): (&String, &Quantity)| {
            let was = before.get(name).filter(|was| *was != is)?;
            Some(format!(
                "`{name}` is {was} in the grammar that made the design, but {is} in `{}`",
                rules.name
            ))
        };
        now.iter().find_map(differs)
    })
}

/// What saved numbers of one name are.
#[derive(PartialEq)]
enum Quantity {
    Value(Ty),
    /// The weights of a policy: its own inputs, of which some may be mirrored, and hidden layers, and what it decides, each with its type, how many values it is one of, and
    /// how many inputs it adds.
    Weights((usize, Option<usize>), Vec<usize>, Vec<(String, Ty, Option<usize>, usize)>),
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Value(ty) => write!(f, "of type {ty}"),
            Self::Weights((inputs, mirrored), hidden, decided) => {
                let mirrored = mirrored.map_or(String::new(), |count| format!("mirrored: {count}, "));
                write!(f, "a network (inputs: {inputs}, {mirrored}hidden: {hidden:?}) that decides ")?;
                for (place, (name, ty, values, inputs)) in decided.iter().enumerate() {
                    let comma = if place == 0 { "" } else { ", " };
                    let values = values.map_or(String::new(), |count| format!(", values: {count}"));
                    write!(f, "{comma}`{name}` ({ty}{values}, inputs: {inputs})")?;
                }
                Ok(())
            }
        }
    }
}

/// What the saved numbers of a task are, by their names.
fn quantities(rules: &RuleSet, task: &str) -> BTreeMap<String, Quantity> {
    let actuated = rules.tasks.get(task).into_iter().flat_map(|task| task.actuated.values());
    let mut all = BTreeMap::new();
    for actuation in actuated.filter_map(|name| rules.actuations.get(name)) {
        all.extend(actuation.variables.iter().map(|v| (v.name.clone(), Quantity::Value(v.ty.clone()))));
        for action in &actuation.actions {
            let Some(policy) = rules.policies.get(&action.policy) else { continue };
            let inputs = (policy.inputs.len(), policy.mirrored.as_ref().map(Vec::len));
            let empty = || Quantity::Weights(inputs, policy.hidden.clone(), Vec::new());
            if let Quantity::Weights(.., decided) = all.entry(action.policy.clone()).or_insert_with(empty) {
                let values = match &action.space {
                    ActionSpace::Continuous(..) => None,
                    ActionSpace::Discrete(values) => Some(values.len()),
                };
                decided.push((action.name.clone(), action.ty.clone(), values, action.inputs.len()));
            }
        }
    }
    all
}

/// Refuses a design whose values of enumerations mean others in a grammar: they are saved by their place.
pub(super) fn check_enumerations(path: &Path, design: &SavedDesign, rules: &RuleSet) -> Result<(), Fault> {
    let Ok(theirs) = design.grammar.compile(&design.sgc) else { return Ok(()) };
    let kept = kept_enumerations(&theirs);
    // Under another name it may be another one: nobody knows.
    let mut those = theirs.enumerations.iter().filter(|(name, _)| kept.contains(name.as_str()));
    let other = those.find(|(name, values)| match rules.enumerations.get(*name) {
        Some(now) => !now.starts_with(values),
        None => !rules.enumerations.is_empty(),
    });
    match other {
        None => Ok(()),
        Some((name, values)) => Err(Fault::input(format!(
            "{}: a design saves a value of `enum {name}` as its place in the list, and the list was {} when the design was made: begin `enum {name}` of `{}` with these values, and add others after them",
            path.display(),
            values.join(", "),
            rules.name,
        ))),
    }
}

/// The enumerations whose values a design keeps: those of parameters of parts and cells, and of choices of rules.
fn kept_enumerations(rules: &RuleSet) -> BTreeSet<&str> {
    let parts = rules.parts.values().map(|part| &part.params);
    let actuators = rules.actuators.values().map(|actuator| &actuator.params);
    let cells = rules.lattice.iter().map(|lattice| &lattice.cell.params);
    let params = parts.chain(actuators).chain(cells).flat_map(|params| params.values());
    let choices = rules.rules.iter().flat_map(|rule| &rule.choices);
    let named = |ty: &'_ Ty| match ty {
        Ty::Enum(name) => Some(name.clone()),
        Ty::Domain(inner) => match &**inner {
            Ty::Enum(name) => Some(name.clone()),
            _ => None,
        },
        _ => None,
    };
    let found: BTreeSet<String> = params
        .map(|param| &param.ty)
        .chain(choices.map(|choice| &choice.domain.ty))
        .filter_map(named)
        .collect();
    rules.enumerations.keys().map(String::as_str).filter(|name| found.contains(*name)).collect()
}

/// Tells where the rules make another body of a design's steps than the one that was saved.
pub(super) fn tell_other_body(path: &Path, design: &SavedDesign, rules: &RuleSet) {
    let Ok(now) = Derivation::replay(rules, &design.derivation) else { return };
    let theirs = design.grammar.compile(&design.sgc).ok();
    let before = theirs.and_then(|theirs| {
        let made = Derivation::replay(&theirs, &design.derivation).ok()?;
        let assembly = Body::new(&made.design, &theirs).assembly;
        Some((kinds(&made), assembly))
    });
    if now.design.is_body(&design.body) {
        // The same parts in the same places, which may be made otherwise.
        if before.is_some_and(|(_, before)| Body::new(&now.design, rules).assembly != before) {
            output::note(&format!(
                "`{}` declares the parts of {} differently from the grammar that made it (sizes, masses, friction or joints): the results below are for the parts that `{}` declares",
                rules.name,
                path.display(),
                rules.name
            ));
        }
        return;
    }
    let (now, before) = (kinds(&now), before.map(|(kinds, _)| kinds).unwrap_or_default());
    let how = if now.len() != before.len() {
        format!("of {} parts instead of {}", now.len(), before.len())
    } else if now != before {
        format!("with {} in place of {}", listed(&now, &before), listed(&before, &now))
    } else {
        "of the same kinds of parts, but with other parameters, sizes or places".to_owned()
    };
    output::note(&format!(
        "by the rules of `{}`, the steps of {} make another body, {how}: the results below are for this other body",
        rules.name,
        path.display()
    ));
}

/// The kinds of the parts of a design, sorted.
fn kinds(derivation: &Derivation) -> Vec<String> {
    let mut kinds: Vec<String> = derivation.design.parts.values().map(|part| part.kind.clone()).collect();
    kinds.sort_unstable();
    kinds
}

/// The kinds that are more often in one list than in another: `2 ball, 1 cube`.
fn listed(kinds: &[String], than: &[String]) -> String {
    let count = |all: &[String], kind: &String| all.iter().filter(|other| *other == kind).count();
    let mut names: Vec<&String> = kinds.iter().collect();
    names.dedup();
    let more = names.into_iter().filter_map(|kind| {
        let many = count(kinds, kind).saturating_sub(count(than, kind));
        (many > 0).then(|| format!("{many} {kind}"))
    });
    more.collect::<Vec<_>>().join(", ")
}

/// Tells of parameters that were set from outside when a design was made, and are not set now.
pub(super) fn tell_other_parameters(
    path: &Path,
    design: &SavedDesign,
    rules: &RuleSet,
    params: &[(String, String)],
) {
    let Ok(theirs) = design.grammar.compile(&design.sgc) else { return };
    let differs = |name: &String| {
        let value = |rules: &RuleSet| rules.params.get(name).map(|param| param.value);
        value(rules).zip(value(&theirs)).is_some_and(|(now, before)| now != before)
    };
    let set = design.grammar.parameters.iter().chain(params).filter(|(name, _)| differs(name));
    let mut before: Vec<String> = set
        .filter_map(|(name, _)| {
            let param = theirs.params.get(name)?;
            let value = match (&param.ty, param.ty.dimension()) {
                (Ty::Bool, _) => (param.value != 0.0).to_string(),
                (Ty::Enum(of), _) => theirs.value_of(of, param.value)?.to_owned(),
                (_, dimension) => units::shown(param.value, dimension.unwrap_or_default()),
            };
            Some(format!("{name} = {value}"))
        })
        .collect();
    before.sort_unstable();
    before.dedup();
    if !before.is_empty() {
        let (before, named) = (before.join(", "), path.display());
        output::note(&format!("{named} was made with {before}, but this command uses other values"));
    }
}

/// What is wrong with a design, or with the task that was asked for: a name that it does not have is a matter
/// of usage.
pub(super) fn fault(path: &Path, error: &DesignError) -> Fault {
    let code = if matches!(error, DesignError::UnknownTask { .. }) { exit::USAGE } else { exit::INPUT };
    Fault { code, message: format!("{}: {error}", path.display()) }
}
