//! Checks the grammar as a whole and puts the typed rule set together.

use indexmap::{IndexMap, IndexSet};

use super::Checked;
use super::declarations::rules::is_always;
use super::declarations::singles::{Actuated, Singles};
use super::declarations::tasks::Asked;
use super::declarations::{Declarations, Named};
use super::environment::Environment;
use crate::diagnostics::{Code, Diagnostic, did_you_mean};
use crate::ir::{self, RuleSet};
use crate::names::{Declaration, LoadedModule, Program, declared};
use crate::source::Span;
use crate::syntax::ast::{Item, ItemKind, Name};
use crate::syntax::declarations::{BlockKind, Counts};

/// What rules and their neighbours come to.
struct Derived {
    rules: Vec<ir::Rule>,
    always: Vec<ir::Rule>,
    fallbacks: Vec<ir::Fallback>,
    requirements: Vec<ir::Requirement>,
    preferences: Vec<ir::Preference>,
    examples: IndexMap<String, ir::Example>,
    from: Option<String>,
}

/// More rules than this take a minute to check, and longer for each move of a search.
const MOST_RULES: usize = 20_000;

/// Puts the rule set together.
pub(super) struct Assembly<'a> {
    environment: &'a Environment<'a>,
    declarations: Declarations<'a>,
}

impl<'a> Assembly<'a> {
    pub(super) fn new(declarations: Declarations<'a>) -> Self {
        Self { environment: declarations.environment, declarations }
    }

    /// Checks everything that the grammar says or uses.
    pub(super) fn check(mut self) -> Checked {
        let ruleset = self.grammar();
        let Declarations { expressions, idle, .. } = self.declarations;
        Checked { ruleset, found: expressions.errors.into_vec(), idle }
    }

    fn report(&mut self, found: Diagnostic) {
        self.declarations.report(found);
    }

    fn grammar(&mut self) -> Option<RuleSet> {
        let program = self.environment.program;
        let rules = || program.entries().filter(|(_, item)| matches!(item.kind, ItemKind::Rule(..)));
        if let Some((_, item)) = rules().nth(MOST_RULES) {
            let more = rules().count() - MOST_RULES;
            self.report(
                Diagnostic::new(
                    Code::OUT_OF_DOMAIN,
                    item.span,
                    format!("a grammar has at most {MOST_RULES} rules, those of its modules included"),
                )
                .label(format!("the first of {more} too many"))
                .help("rules that differ by a number only are one rule with `choose`"),
            );
            return None;
        }
        let items: Vec<(Declaration, &Item)> =
            program.entries().filter(|(d, _)| program.own.contains(&d.module)).collect();
        for (declaration, item) in &items {
            if matches!(item.kind, ItemKind::Param(_)) {
                self.declarations.expressions.param(*declaration);
            }
        }
        let mut singles = Singles::default();
        for (_, item) in &items {
            self.declarations.single(item, &mut singles);
        }
        let rest = self.declarations.check_all();
        // Rules, requirements and preferences that are imported by name take part, too.
        let (mut rules, mut always) = (Vec::new(), Vec::new());
        let mut requirements = Vec::new();
        let mut preferences = Vec::new();
        for (_, item) in program.entries() {
            match &item.kind {
                ItemKind::Rule(name, clauses) => {
                    let kept = if is_always(clauses) { &mut always } else { &mut rules };
                    kept.extend(self.declarations.rule(name, clauses, item.damaged))
                }
                ItemKind::Require { .. } => requirements.extend(self.declarations.requirement(item)),
                ItemKind::Prefer { .. } => preferences.extend(self.declarations.preference(item)),
                _ => {}
            }
        }
        let examples = self.declarations.examples(&items, &rules, &requirements);
        // A module without `grammar` is only imported; it has been checked.
        let Some(name) = program.name.as_ref() else {
            self.nameless(&items);
            return None;
        };
        let complete = self.complete(&singles, program.base.unwrap_or(name.span));
        let from = self.starting_example(&singles, &examples);
        let fallbacks = self.declarations.fallbacks(&rules);
        let assembled = self.assemble(
            name,
            singles,
            Derived { rules, always, fallbacks, requirements, preferences, examples, from },
        );
        self.unknown_overrides(name.span);
        self.unused(&items, &rest);
        let mut ruleset = assembled?;
        ruleset.params = self.declarations.expressions.parameters();
        (complete && !self.declarations.expressions.errors.iter().any(Diagnostic::is_error))
            .then_some(ruleset)
    }

    /// Reports a text that says how a grammar begins and what is wanted of its designs, and is none.
    fn nameless(&mut self, items: &[(Declaration, &Item)]) {
        let find =
            |is_it: fn(&ItemKind) -> bool| items.iter().map(|(_, item)| *item).find(|item| is_it(&item.kind));
        let begin = find(|kind| matches!(kind, ItemKind::Begin(..)));
        let objective = find(|kind| matches!(kind, ItemKind::Objective { .. }));
        let (Some(item), Some(_)) = (begin, objective) else {
            self.examples_of_module(items);
            return;
        };
        let is_module =
            self.environment.program.modules.first().is_none_or(|m| crate::names::offers(&m.tree).is_empty());
        let errors = &self.declarations.expressions.errors;
        if !is_module || self.is_partial() || errors.iter().any(Diagnostic::is_error) {
            return;
        }
        let word = item.kind.word();
        let place = Span { end: item.span.start + word.len() as u32, ..item.span };
        self.report(
            Diagnostic::new(
                Code::MISSING_ITEM,
                place,
                format!("`{word}` belongs to a grammar, but this file has no `grammar NAME`"),
            )
            .label("a module that other files import cannot have this")
            .help("write `grammar NAME` above all other declarations"),
        );
    }

    /// Warns of examples of a text that is no grammar: they are never run.
    fn examples_of_module(&mut self, items: &[(Declaration, &Item)]) {
        for (_, item) in items.iter().filter(|(declaration, _)| declaration.module == 0) {
            let ItemKind::Example(name, _) = &item.kind else { continue };
            self.report(
                Diagnostic::new(Code::UNUSED, name.span, format!("the example `{}` is never run", name.text))
                    .label("this file is not a grammar: it lacks `grammar NAME`")
                    .help("move it into a grammar that uses this module, or write `grammar NAME` above all other declarations"),
            );
        }
    }

    /// The example that the search starts from.
    fn starting_example(
        &mut self,
        singles: &Singles<'_>,
        examples: &IndexMap<String, ir::Example>,
    ) -> Option<String> {
        let from = singles.from?;
        if examples.contains_key(&from.text) {
            return Some(from.text.clone());
        }
        let declared = self.environment.program.lookup(from.span, &from.text);
        if !declared.is_some_and(|(_, i)| matches!(i.kind, ItemKind::Example(..))) {
            let help = did_you_mean(&from.text, examples.keys().map(String::as_str));
            self.report(
                Diagnostic::new(
                    Code::UNKNOWN_NAME,
                    from.span,
                    format!("there is no example `{}` to start from", from.text),
                )
                .label("not declared")
                .help(help.unwrap_or_else(|| "declare it with `example`".to_owned())),
            );
        }
        None
    }

    /// Warns of declarations and imports of the first text that nothing uses.
    fn unused(&mut self, items: &[(Declaration, &Item)], rest: &IndexSet<Declaration>) {
        if self.is_partial() || self.declarations.expressions.errors.iter().any(Diagnostic::is_error) {
            // What an error hides might be the use.
            return;
        }
        let program = self.environment.program;
        let mut there = Vec::new();
        let mut idle: Vec<(Span, String)> = Vec::new();
        let mut beside: Vec<(Span, &str, &str)> = Vec::new();
        let used =
            |d: &Declaration, c: &Self| c.declarations.expressions.touched.contains(d) || rest.contains(d);
        for (declaration, item) in items.iter().filter(|(d, _)| d.module == 0) {
            let by_itself = item.kind.kind().is_some_and(|kind| kind.counts != Counts::WhereUsed);
            there.extend(declared(item).map(|n| n.span));
            if let (Some(name), false, false) = (declared(item), by_itself, used(declaration, self)) {
                idle.push((name.span, format!("nothing uses `{}`", name.text)));
            }
        }
        if program.is_only_variant() {
            let own = program.modules.first().into_iter().flat_map(|m| &m.tree.items).enumerate();
            for (declaration, item) in own.map(|(item, it)| (Declaration { module: 0, item }, it)) {
                if program.takes_part(declaration)
                    || matches!(item.kind, ItemKind::Variant(_) | ItemKind::Use { .. })
                {
                    continue;
                }
                match declared(item) {
                    Some(name) if !takes_part_only(&item.kind) => {
                        there.push(name.span);
                        if !used(&declaration, self) {
                            idle.push((name.span, format!("nothing uses `{}`", name.text)));
                        }
                    }
                    _ if takes_part_only(&item.kind) => {
                        let word = item.kind.word();
                        let place = Span { end: item.span.start + word.len() as u32, ..item.span };
                        there.push(place);
                        beside.push((place, word, "this"));
                    }
                    _ => {}
                }
            }
        }
        if program.is_only_variant() {
            beside_in_modules(program, &mut beside);
        }
        let imports =
            program.modules.first().into_iter().flat_map(|m| &m.tree.items).filter_map(|i| match &i.kind {
                ItemKind::Use { names: Some(names), .. } => Some(names),
                _ => None,
            });
        for name in imports.flatten() {
            let Some((declaration, item)) = program.lookup(name.span, &name.text) else { continue };
            let by_itself = item.kind.kind().is_some_and(|kind| kind.counts == Counts::Everywhere);
            there.push(name.span);
            if program.is_only_variant() && takes_part_only(&item.kind) && !program.takes_part(declaration) {
                idle.push((
                    name.span,
                    format!("`{}` is imported, but is not part of the variant", name.text),
                ));
            } else if !by_itself && !used(&declaration, self) {
                idle.push((name.span, format!("`{}` is imported, but nothing uses it", name.text)));
            }
        }
        let unused = idle.into_iter().map(|(place, message)| {
            Diagnostic::new(Code::UNUSED, place, message).label("not used").help("use it, or take it out")
        });
        let mut unused: Vec<Diagnostic> = unused.collect();
        unused.extend(beside.into_iter().map(|(place, word, which)| {
            Diagnostic::new(
                Code::UNUSED,
                place,
                format!("{which} `{word}` is not part of the variant"),
            )
            .label("outside the braces of the variant")
            .help(format!(
                "write it inside the braces: `add {word} ...`, or `replace {word} ...` for what the base has"
            ))
        }));
        // What a variant in between changes, another may have put something else in the place of.
        let own = program.name.as_ref().map(|name| name.text.as_str());
        for change in program.changes.iter().filter(|change| Some(change.variant.as_str()) == own) {
            let Some((declaration, item)) = change.edited.and_then(|d| Some((d, program.item(d)?))) else {
                continue;
            };
            let by_itself = item.kind.kind().is_some_and(|kind| kind.counts != Counts::WhereUsed);
            if let (Some(name), false, false) = (declared(item), by_itself, used(&declaration, self)) {
                there.push(change.place);
                let message = format!("this changes `{}`, but nothing in this grammar uses it", name.text);
                unused.push(
                    Diagnostic::new(Code::UNUSED, change.place, message)
                        .label("changes nothing")
                        .help("take it out, or use what it changes"),
                );
            }
        }
        self.declarations.idle.there.extend(there);
        self.declarations.report_unused(unused);
    }

    /// Whether some declarations could not be read: what seems to be missing may be there.
    fn is_partial(&self) -> bool {
        let lost = |m: &LoadedModule| m.tree.headless || m.tree.broken.iter().any(|b| !b.is_empty());
        self.environment.program.modules.iter().any(lost)
    }

    /// Reports what a grammar lacks.
    fn complete(&mut self, singles: &Singles<'_>, span: Span) -> bool {
        let tasks = !singles.tasks.is_empty();
        // One that the same file declares is meant.
        let own = self.environment.known().find_map(|(_, item)| match &item.kind {
            ItemKind::Block(BlockKind::Search, block) if block.name.span.file == span.file => Some(block),
            _ => None,
        });
        let search = format!("search {}", own.map_or("nested_annealing", |block| block.name.text.as_str()));
        let wanted = [
            ("begin", "begin { place core : cube }"),
            ("simulate", "simulate hinge_model for 20 s"),
            ("maximize", "maximize travel in cm"),
            ("search", search.as_str()),
        ];
        let cells = self
            .declarations
            .environment
            .begins_with_cells
            .then_some(("lattice", "lattice 15 x 15 x 15 of KIND"));
        let missing = wanted.into_iter().chain(cells).filter(|(what, _)| {
            // Tasks say for themselves how they are simulated.
            !(*what == "simulate" && tasks
                || self.environment.program.has_unread(what)
                || *what == "maximize" && !singles.objectives.is_empty()
                || singles.seen.contains_key(what))
        });
        let (words, lines): (Vec<&str>, Vec<&str>) = missing.unzip();
        if !words.is_empty() && !self.is_partial() {
            let message = format!("this grammar lacks {}", super::expressions::names::listed(&words, "and"));
            self.report(
                Diagnostic::new(Code::MISSING_ITEM, span, message)
                    .label("incomplete")
                    .help(format!("add for example {}", super::expressions::names::listed(&lines, "and"))),
            );
        }
        words.is_empty()
    }

    /// What the grammar uses, with all that this uses in turn; whether none of it has errors.
    fn used(&mut self) -> (Named, bool) {
        let program = self.environment.program;
        let mut used = Named::default();
        let mut is_sound = true;
        // Checking one declaration may touch others: the set grows while it is walked.
        for (declaration, item) in self.environment.known() {
            // Whoever tries a design names scenarios, though nothing in the grammar need.
            let counts = item.kind.kind().map(|kind| kind.counts);
            if matches!(item.kind, ItemKind::Block(..)) && counts == Some(Counts::Everywhere) {
                self.declarations.expressions.touched.insert(declaration);
            }
        }
        let mut next = 0;
        let mut taken: IndexMap<String, Declaration> = IndexMap::new();
        while let Some(declaration) = self.declarations.expressions.touched.get_index(next).copied() {
            next += 1;
            let Some(item) = program.item(declaration) else { continue };
            let Some(own) = declared(item) else { continue };
            if let Some(other) = taken.insert(own.text.clone(), declaration)
                && other != declaration
            {
                let message = format!("two modules declare `{}`, and this grammar uses both", own.text);
                self.report(
                    Diagnostic::new(Code::DUPLICATE, own.span, message)
                        .label("one of them")
                        .help("rename one of them"),
                );
            }
            is_sound &= self.declarations.check_named(item, &mut used);
        }
        (used, is_sound)
    }

    fn assemble(&mut self, name: &Name, singles: Singles<'a>, derived: Derived) -> Option<RuleSet> {
        let tasks = self.declarations.tasks(&singles);
        let hardware = self.declarations.hardware();
        let observed = self.declarations.all_observed();
        let novelties = self.declarations.novelties();
        // What drives what is checked even where the tasks are not complete.
        let own_actuated = singles.tasks.is_empty().then(|| singles.actuated.clone());
        let (used, is_sound) = self.used();
        let actuated: Vec<&Actuated> = match &tasks {
            Some(asked) => asked.tasks.values().map(|(_, actuated)| actuated).collect(),
            None => own_actuated.iter().collect(),
        };
        let actuated_cells: Vec<Actuated> = actuated.iter().copied().cloned().collect();
        for actuated in actuated {
            self.declarations.check_actuated(actuated, &used.actuators, &used.actuations);
        }
        if let (Some(kind), Some((sides, cell, span))) = (singles.cell, &singles.lattice) {
            for (with, place) in actuated_cells.iter().filter_map(|actuated| actuated.get(&kind.text)) {
                if let Some(actuation) = used.actuations.get(with) {
                    self.declarations.check_attributes(&kind.text, &cell.params, actuation, *place);
                }
            }
            self.declarations.check_lattice_symmetry(
                *sides,
                singles.symmetry.unwrap_or(ir::Symmetry::None),
                *span,
            );
        }
        let Asked { tasks, objective, beside } = tasks?;
        self.declarations.check_models(&tasks, &singles, &used.parts, &used.actuators);
        let (targets, prototypes) = hardware?;
        self.declarations.check_targets(&tasks, &targets, &used);
        self.declarations.check_closed_loops(&tasks, &used.actuations);
        let changes_bodies = !derived.rules.is_empty()
            && singles.search.as_ref().is_some_and(|search| search.bodies.is_some());
        self.declarations.check_policies(&tasks, &used.actuations, changes_bodies);
        let search = singles.search.as_ref();
        self.declarations.check_learners(search, &tasks, &used.actuations, &used.policies);
        self.declarations.check_periods(&tasks, &used.actuations, &used.terms, &observed);
        let novelties = novelties?;
        if !is_sound {
            return None;
        }
        let is_lattice = singles.cell.is_some();
        Some(RuleSet {
            enumerations: self.enumerations(),
            symmetry: singles.symmetry.unwrap_or(ir::Symmetry::None),
            begin: singles.begin?,
            lattice: match (singles.lattice, singles.cell) {
                (Some((sides, cell, span)), Some(kind)) => {
                    let kind = kind.text.clone();
                    Some(ir::Lattice { sides, kind, cell, begin: singles.filled, span })
                }
                (None, Some(_)) => return None,
                _ => None,
            },
            rules: derived.rules,
            always: derived.always,
            fallbacks: derived.fallbacks,
            requirements: derived.requirements,
            preferences: derived.preferences,
            examples: derived.examples,
            tasks: tasks.into_iter().map(|(name, (task, _))| (name, task)).collect(),
            targets,
            prototypes,
            observed: Declarations::names_observed(observed, &used.terms, is_lattice),
            novelties,
            beside,
            from: derived.from,
            ..used.rule_set(&name.text, objective, singles.search?)
        })
    }

    /// The values of every enumeration that is used.
    fn enumerations(&self) -> IndexMap<String, Vec<String>> {
        let used = self
            .environment
            .program
            .items()
            .filter(|(d, _)| self.declarations.expressions.touched.contains(d));
        used.filter_map(|(_, item)| match &item.kind {
            ItemKind::Enum(name, values) => {
                Some((name.text.clone(), values.iter().map(|v| v.text.clone()).collect()))
            }
            _ => None,
        })
        .collect()
    }

    fn unknown_overrides(&mut self, span: Span) {
        let known = self.declarations.expressions.parameter_names();
        for (place, (name, _)) in self.environment.overrides.iter().enumerate() {
            let before = self.environment.overrides.get(..place).unwrap_or_default();
            if before.iter().any(|(other, _)| other == name) {
                self.report(
                    Diagnostic::new(Code::DUPLICATE, span, format!("`{name}` is given twice"))
                        .label("given with `-p`")
                        .help("give each parameter one value"),
                );
                continue;
            }
            if known.contains(&name.as_str()) {
                continue;
            }
            let help = did_you_mean(name, known.iter().copied()).unwrap_or_else(|| {
                if known.is_empty() {
                    "it has none".to_owned()
                } else {
                    format!("it has: {}", known.join(", "))
                }
            });
            self.report(
                Diagnostic::new(
                    Code::UNKNOWN_PARAMETER,
                    span,
                    format!("this grammar has no parameter `{name}`"),
                )
                .label("given with `-p`")
                .help(help),
            );
        }
    }
}

/// Whether a declaration does nothing but take part in the grammar: no other names it to build on it.
fn takes_part_only(kind: &ItemKind) -> bool {
    matches!(
        kind,
        ItemKind::Rule(..)
            | ItemKind::Require { .. }
            | ItemKind::Prefer { .. }
            | ItemKind::Task(..)
            | ItemKind::Example(..)
            | ItemKind::Fallback { .. }
            | ItemKind::Begin(..)
            | ItemKind::Symmetry(..)
            | ItemKind::Lattice(..)
            | ItemKind::UseSearch(..)
            | ItemKind::Observe(_)
            | ItemKind::Objective { .. }
            | ItemKind::Actuate(..)
            | ItemKind::Simulate { .. }
    )
}

/// Rules, requirements and preferences of modules that a text with variants only imports as a whole: at the import.
fn beside_in_modules<'p>(program: &'p Program, beside: &mut Vec<(Span, &'p str, &'p str)>) {
    let whole = program.modules.first().into_iter().flat_map(|m| &m.tree.items).filter_map(|item| {
        let ItemKind::Use { module, names: None } = &item.kind else { return None };
        let path = module.text.rsplit("./").next().unwrap_or_default();
        Some((module.span, path.trim_end_matches(".sgr")))
    });
    for (place, name) in whole {
        // Another file whose name only ends like this one's is another module.
        let is_it = |m: &LoadedModule| {
            let before = m.name.trim_end_matches(".sgr").strip_suffix(name);
            before.is_some_and(|before| before.is_empty() || before.ends_with(['/', '\\']))
        };
        let module = program.modules.iter().position(is_it);
        let Some((module, loaded)) = module.and_then(|at| Some((at, program.modules.get(at)?))) else {
            continue;
        };
        let lost = loaded.tree.items.iter().enumerate().find(|(item, it)| {
            let counts =
                matches!(it.kind, ItemKind::Rule(..) | ItemKind::Require { .. } | ItemKind::Prefer { .. });
            counts && !program.takes_part(Declaration { module, item: *item })
        });
        if let Some((_, item)) = lost {
            beside.push((place, item.kind.word(), "of this module, a"));
        }
    }
}
