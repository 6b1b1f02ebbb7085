//! Checks the grammar as a whole and puts the typed rule set together.

use std::collections::BTreeSet;

use indexmap::{IndexMap, IndexSet};

use super::Checker;
use super::expr::Context;
use super::found::Found;
use super::stage::Stage;
use super::tasks::Actuated;
use crate::diagnostics::{Code, Diagnostic, did_you_mean, respell};
use crate::ir::{self, Expr, RuleSet, Ty};
use crate::names::{Declaration, LoadedModule, declared};
use crate::source::Span;
use crate::syntax::ast::{Expr as Tree, Item, ItemKind, Name, Place, Typed};

use crate::units::Dimension;

/// What rules and their neighbours come to.
struct Derived {
    rules: Vec<ir::Rule>,
    fallbacks: Vec<ir::Fallback>,
    requirements: Vec<ir::Requirement>,
    preferences: Vec<ir::Preference>,
    examples: IndexMap<String, ir::Example>,
    from: Option<String>,
}

/// Declarations of which a grammar, or a task, has one.
#[derive(Default)]
pub(super) struct Singles<'t> {
    begin: Option<Vec<ir::Placed>>,
    /// What the initial design fills.
    filled: Vec<ir::Effect>,
    /// The sides of the lattice, its cell and its place.
    lattice: Option<([usize; 3], ir::Cell, Span)>,
    /// The name of its cell.
    cell: Option<&'t Name>,
    symmetry: Option<ir::Symmetry>,
    pub(super) model: Option<ir::Model>,
    /// The target that it is simulated on.
    pub(super) on: Option<&'t Name>,
    /// Whether more is better, the value, and whether the item is damaged.
    pub(super) objective: Option<(bool, &'t Tree, bool)>,
    search: Option<ir::Search>,
    from: Option<&'t Name>,
    pub(super) actuated: Actuated,
    pub(super) tasks: Vec<(&'t Name, &'t [Item])>,
    pub(super) seen: IndexMap<&'static str, Span>,
}

impl<'a> Checker<'a> {
    /// Checks everything that the grammar says or uses.
    pub(super) fn grammar(&mut self) -> Option<RuleSet> {
        let program = self.program;
        let items: Vec<(Declaration, &Item)> =
            program.entries().filter(|(d, _)| program.own.contains(&d.module)).collect();
        for (declaration, item) in &items {
            if matches!(item.kind, ItemKind::Param(_)) {
                self.param(*declaration);
            }
        }
        let mut singles = Singles::default();
        for (_, item) in &items {
            self.single(item, &mut singles);
        }
        let rest = self.check_all();
        // Rules, requirements and preferences that are imported by name take part, too.
        let mut rules = Vec::new();
        let mut requirements = Vec::new();
        let mut preferences = Vec::new();
        for (_, item) in program.entries() {
            match &item.kind {
                ItemKind::Rule(name, clauses) => rules.extend(self.rule(name, clauses, item.damaged)),
                ItemKind::Require { .. } => requirements.extend(self.requirement(item)),
                ItemKind::Prefer { .. } => preferences.extend(self.preference(item)),
                _ => {}
            }
        }
        let examples = self.examples(&items, &rules, &requirements);
        // A module without `grammar` is only imported; it has been checked.
        let name = program.name.as_ref()?;
        let complete = self.complete(&singles, program.base.unwrap_or(name.span));
        let from = self.starting_example(&singles, &examples);
        let fallbacks = self.fallbacks(&rules);
        let assembled = self.assemble(
            name,
            singles,
            Derived { rules, fallbacks, requirements, preferences, examples, from },
        );
        self.unknown_overrides(name.span);
        self.unused(&items, &rest);
        let mut ruleset = assembled?;
        for (declaration, param) in self.params.clone() {
            let name = program.item(declaration).and_then(declared);
            if let (Some(name), super::CheckedParam::Right(param)) = (name, param) {
                ruleset.params.insert(name.text.clone(), param);
            }
        }
        ruleset.params.sort_by(|a, x, b, y| x.span.cmp(&y.span).then(a.cmp(b)));
        (complete && !self.errors.iter().any(Diagnostic::is_error)).then_some(ruleset)
    }

    fn requirement(&mut self, item: &Item) -> Option<ir::Requirement> {
        let ItemKind::Require { name, condition, because } = &item.kind else { return None };
        let name = self.name_or_text(name.as_ref(), condition);
        let mut cx = Context::new(Stage::Derivation, item.damaged);
        let condition = self.expect(condition, &mut cx, &Ty::Bool, "a requirement");
        Some(ir::Requirement { name, condition, because: because.clone(), span: item.span })
    }

    fn preference(&mut self, item: &Item) -> Option<ir::Preference> {
        let ItemKind::Prefer { name, condition, weight, because } = &item.kind else { return None };
        let name = self.name_or_text(name.as_ref(), condition);
        let mut cx = Context::new(Stage::Derivation, item.damaged);
        let condition = self.expect(condition, &mut cx, &Ty::Bool, "a preference");
        let weight = self.expect(weight, &mut cx, &Ty::NUMBER, "the weight of a preference");
        if let Some(x) = self.quiet_number(&weight)
            && x < 0.0
        {
            self.report(
                Diagnostic::new(
                    Code::OUT_OF_DOMAIN,
                    weight.span,
                    "the weight of a preference must not be below 0",
                )
                .label("negative")
                .help("prefer the opposite: `prefer not (...)`"),
            );
        }
        Some(ir::Preference { name, condition, weight, because: because.clone(), span: item.span })
    }

    /// What has no name is known by what it says.
    fn name_or_text(&self, name: Option<&Name>, condition: &Tree) -> String {
        match name {
            Some(name) => name.text.clone(),
            None => self.sources.slice(condition.span).split_whitespace().collect::<Vec<_>>().join(" "),
        }
    }

    fn examples(
        &mut self,
        items: &[(Declaration, &Item)],
        rules: &[ir::Rule],
        requirements: &[ir::Requirement],
    ) -> IndexMap<String, ir::Example> {
        let program = self.program;
        let actuators = program.items().filter_map(|(_, i)| match &i.kind {
            ItemKind::Actuator(block) => Some(block.name.text.as_str()),
            _ => None,
        });
        let actuators: BTreeSet<&str> = actuators.collect();
        let cells = program.items().filter_map(|(_, i)| match &i.kind {
            ItemKind::Cell(block) => Some(block.name.text.as_str()),
            _ => None,
        });
        let cells: BTreeSet<&str> = cells.collect();
        let member_of = |group: &ir::Group| match group {
            ir::Group::Actuator => Ty::Actuator,
            ir::Group::Cell => Ty::Cell,
            ir::Group::Kind(kind) if actuators.contains(kind.as_str()) => Ty::Actuator,
            ir::Group::Kind(kind) if cells.contains(kind.as_str()) => Ty::Cell,
            _ => Ty::Part,
        };
        let rules = super::examples::applicable(rules, &member_of);
        let reasons: IndexSet<String> = requirements.iter().map(|r| r.name.clone()).collect();
        let mut examples = IndexMap::new();
        for (_, item) in items {
            let ItemKind::Example(name, clauses) = &item.kind else { continue };
            if let Some(example) = self.example(clauses, &rules, &reasons, name, item.damaged) {
                examples.insert(name.text.clone(), example);
            }
        }
        examples
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
        let declared = self.program.lookup(from.span, &from.text);
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

    /// Checks every declaration for its own sake, whether or not anything uses
    /// it; gives what only such checks have read. The library has its own tests.
    fn check_all(&mut self) -> IndexSet<Declaration> {
        let program = self.program;
        let before = self.touched.clone();
        for (declaration, item) in program.items() {
            let library = program.modules.get(declaration.module).is_some_and(|m| m.name.starts_with("std."));
            let own = declaration.module == 0 || !library;
            if own && !program.dropped.contains_key(&declaration) {
                self.check_own(declaration, item);
            }
        }
        std::mem::replace(&mut self.touched, before)
    }

    fn check_own(&mut self, declaration: Declaration, item: &Item) {
        match &item.kind {
            ItemKind::Part(block) => drop(self.part(block, item.damaged)),
            ItemKind::Actuator(block) => drop(self.actuator(block, item.damaged)),
            ItemKind::Cell(block) => drop(self.cell(block, item.damaged)),
            ItemKind::Model(block) => drop(self.model(block, None, item.damaged)),
            ItemKind::Search(block) => drop(self.search(block, item.damaged)),
            ItemKind::Pattern(_, value) => drop(self.fixed_pattern(value, item.damaged)),
            ItemKind::Table(table) => drop(self.table(table, item.damaged)),
            ItemKind::Target { block, backend, kind } => {
                drop(self.target(block, backend, kind, item.damaged));
            }
            ItemKind::Prototype(block, backend) => drop(self.prototype(block, backend, item.damaged)),
            ItemKind::Observe(names) => drop(self.observed(names)),
            ItemKind::Novelty(name, clauses) => drop(self.novelty(name, clauses, item.damaged)),
            ItemKind::Term(_, ty, value) => drop(self.term(ty, value, item.damaged)),
            ItemKind::Actuation { name, binder, kind, clauses } => {
                drop(self.actuation(name, binder, kind, clauses, item.damaged));
            }
            ItemKind::Let(_, None, value) => drop(self.inline(declaration, value)),
            ItemKind::Let(_, Some(parameters), value) => self.own_body(declaration, parameters, value),
            ItemKind::Enum(name, values) => self.enumeration(name, values),
            ItemKind::Record(name, fields) => {
                self.distinct(fields.iter().map(|f| &f.name), "field");
                // That a record is read to be checked does not mean that something uses it.
                let used = self.touched.contains(&declaration);
                self.type_named(name);
                if !used {
                    self.touched.shift_remove(&declaration);
                }
            }
            _ => {}
        }
    }

    /// Checks the body of a function in every stage; it must fit one of them.
    fn own_body(&mut self, declaration: Declaration, parameters: &[Typed], value: &Tree) {
        self.distinct(parameters.iter().map(|p| &p.name), "parameter");
        let known = std::mem::take(&mut self.errors);
        let mut fewest: Option<Found> = None;
        for stage in [
            Stage::Declaration,
            Stage::Derivation,
            Stage::Score,
            Stage::Drive,
            Stage::Schedule,
            Stage::Weight,
        ] {
            let mut cx = Context::new(stage, false);
            for parameter in parameters {
                let ty = self.type_named(&parameter.ty);
                self.bind_parameter(&parameter.name, ty, &mut cx);
            }
            self.open_functions.push(declaration);
            self.open.push(declaration);
            self.infer(value, &mut cx);
            self.open.pop();
            self.open_functions.pop();
            let found = std::mem::take(&mut self.errors);
            if fewest.as_ref().is_none_or(|f| found.len() < f.len()) {
                fewest = Some(found);
            }
        }
        self.errors = known;
        for error in fewest.unwrap_or_default().into_vec() {
            self.report(error);
        }
    }

    fn enumeration(&mut self, name: &Name, values: &[Name]) {
        self.distinct(values.iter(), "value");
        if values.is_empty() {
            self.report(
                Diagnostic::new(Code::EMPTY_DOMAIN, name.span, format!("`{}` has no values", name.text))
                    .label("empty")
                    .help("name at least one value"),
            );
        }
    }

    fn distinct<'n>(&mut self, names: impl Iterator<Item = &'n Name>, what: &str) {
        let mut seen: IndexMap<&str, Span> = IndexMap::new();
        for name in names {
            if let Some(first) = seen.insert(&name.text, name.span) {
                self.report(
                    Diagnostic::new(
                        Code::DUPLICATE,
                        name.span,
                        format!("there are two {what}s `{}`", name.text),
                    )
                    .label("again")
                    .also(first, "the first one")
                    .help("choose another name, or keep one of them"),
                );
            }
        }
    }

    /// Warns of declarations and imports of the first text that nothing uses.
    fn unused(&mut self, items: &[(Declaration, &Item)], rest: &IndexSet<Declaration>) {
        if self.is_partial() || self.errors.iter().any(Diagnostic::is_error) {
            // What an error hides might be the use.
            return;
        }
        let program = self.program;
        let mut there = Vec::new();
        let mut idle: Vec<(&Name, String)> = Vec::new();
        let used = |d: &Declaration, c: &Self| c.touched.contains(d) || rest.contains(d);
        for (declaration, item) in items.iter().filter(|(d, _)| d.module == 0) {
            let by_itself = matches!(
                item.kind,
                ItemKind::Rule(..)
                    | ItemKind::Require { .. }
                    | ItemKind::Prefer { .. }
                    | ItemKind::Example(..)
                    | ItemKind::Task(..)
                    | ItemKind::Target { .. }
                    | ItemKind::Prototype(..)
                    | ItemKind::Novelty(..)
            );
            there.extend(declared(item).map(|n| n.span));
            if let (Some(name), false, false) = (declared(item), by_itself, used(declaration, self)) {
                idle.push((name, format!("nothing uses `{}`", name.text)));
            }
        }
        let imports =
            program.modules.first().into_iter().flat_map(|m| &m.tree.items).filter_map(|i| match &i.kind {
                ItemKind::Use { names: Some(names), .. } => Some(names),
                _ => None,
            });
        for name in imports.flatten() {
            let Some((declaration, item)) = program.lookup(name.span, &name.text) else { continue };
            let by_itself = matches!(
                item.kind,
                ItemKind::Rule(..)
                    | ItemKind::Require { .. }
                    | ItemKind::Prefer { .. }
                    | ItemKind::Target { .. }
                    | ItemKind::Prototype(..)
                    | ItemKind::Novelty(..)
            );
            there.push(name.span);
            if !by_itself && !used(&declaration, self) {
                idle.push((name, format!("`{}` is imported, but nothing uses it", name.text)));
            }
        }
        let unused = idle.into_iter().map(|(name, message)| {
            Diagnostic::new(Code::UNUSED, name.span, message).label("not used").help("use it, or take it out")
        });
        let unused: Vec<Diagnostic> = unused.collect();
        // Of several grammars in a text, each may leave to the others what it does not use.
        if program.modules.first().is_some_and(|m| crate::names::offers(&m.tree).len() > 1) {
            self.idle = super::Idle { there, unused };
            return;
        }
        unused.into_iter().for_each(|warning| self.report(warning));
    }

    fn fixed_pattern(&mut self, value: &Tree, damaged: bool) -> Expr {
        let mut cx = Context::new(Stage::Pattern, damaged);
        self.expect(value, &mut cx, &Ty::Quantity(Dimension::ANGLE), "a pattern")
    }

    fn term(&mut self, ty: &Name, value: &Tree, damaged: bool) -> (Ty, Expr) {
        let ty = self.type_named(ty);
        let mut cx = Context::new(Stage::Score, damaged);
        let value = self.expect(value, &mut cx, &ty, "this term");
        (ty, value)
    }

    /// Takes in a declaration of which there is one.
    pub(super) fn single(&mut self, item: &'a Item, singles: &mut Singles<'a>) {
        let what = match &item.kind {
            ItemKind::Grammar(_) => "grammar",
            ItemKind::Begin(..) => "begin",
            ItemKind::Lattice(..) => "lattice",
            ItemKind::Symmetry(..) => "symmetry",
            ItemKind::Simulate { .. } => "simulate",
            ItemKind::Objective { .. } => "maximize",
            ItemKind::UseSearch(..) => "search",
            ItemKind::Actuate(..) => "actuate",
            ItemKind::Task(..) => "task",
            _ => return,
        };
        if !matches!(what, "actuate" | "task")
            && let Some(first) = singles.seen.insert(what, item.span)
        {
            self.report(
                Diagnostic::new(Code::DUPLICATE, item.span, format!("a grammar has one `{what}`"))
                    .label("another one")
                    .also(first, "the first one")
                    .help("keep one of them"),
            );
            return;
        }
        match &item.kind {
            ItemKind::Begin(places, fills) if self.has_lattice() => {
                for place in places {
                    self.mixed(place.name.span, true);
                }
                singles.filled = self.begin_cells(fills, item.damaged);
                singles.begin = Some(Vec::new());
                if fills.is_empty() && places.is_empty() && !item.damaged {
                    self.report(
                        Diagnostic::new(Code::MISSING_ITEM, item.span, "the initial design is empty")
                            .label("nothing to begin with")
                            .help(
                                "write for example `fill region(middle, -2 .. 2, 0 .. 1, -2 .. 2) with soft`",
                            ),
                    );
                }
            }
            ItemKind::Begin(places, fills) => {
                for fill in fills {
                    self.mixed(fill.span, false);
                }
                singles.begin = self.begin(places, item);
            }
            ItemKind::Lattice(sides, kind) => {
                singles.lattice = self.lattice(sides, kind, item.span);
                singles.cell = Some(kind);
            }
            ItemKind::Symmetry(kind, count, plane) => {
                singles.symmetry = self.symmetry(kind, count.as_ref(), plane.as_ref());
            }
            ItemKind::Simulate { model, duration, on } => {
                singles.model = self.simulated(model, duration);
                singles.on = on.as_ref().filter(|on| {
                    self.named(on, "target", |k| matches!(k, ItemKind::Target { .. })).is_some()
                });
            }
            ItemKind::Objective { maximize, value } => {
                singles.objective = Some((*maximize, value, item.damaged));
            }
            ItemKind::UseSearch(name, from) => {
                singles.from = from.as_ref();
                if let Some(ItemKind::Search(block)) =
                    self.named(name, "search", |k| matches!(k, ItemKind::Search(_)))
                {
                    singles.search = self.search(block, false);
                }
            }
            ItemKind::Task(name, items) => singles.tasks.push((name, items)),
            ItemKind::Actuate(kind, with) => {
                let kind_ok = self
                    .named(kind, "actuator", |k| matches!(k, ItemKind::Actuator(_) | ItemKind::Cell(_)))
                    .is_some();
                let with_ok =
                    self.named(with, "actuation", |k| matches!(k, ItemKind::Actuation { .. })).is_some();
                if kind_ok && with_ok {
                    let entry = (with.text.clone(), with.span);
                    if let Some((_, first)) = singles.actuated.insert(kind.text.clone(), entry) {
                        self.report(
                            Diagnostic::new(
                                Code::DUPLICATE,
                                kind.span,
                                format!("`{}` is actuated twice", kind.text),
                            )
                            .label("again")
                            .also(first, "by this actuation already")
                            .help("an actuator follows one actuation: keep one of the two lines"),
                        );
                    }
                }
            }
            _ => {}
        }
    }

    /// The parts of the initial design: the core, and what it holds.
    fn begin(&mut self, places: &[Place], item: &Item) -> Option<Vec<ir::Placed>> {
        self.distinct(places.iter().map(|p| &p.name), "part");
        let mut placed = Vec::new();
        let mut sound = true;
        for (i, place) in places.iter().enumerate() {
            if let Some((_, other)) = self.program.lookup(place.name.span, &place.name.text) {
                let mut error = Diagnostic::new(
                    Code::DUPLICATE,
                    place.name.span,
                    format!("`{}` already means something else", place.name.text),
                )
                .label("hides another meaning")
                .help("choose another name");
                if let Some(other) = declared(other) {
                    error = error.also(other.span, "the other meaning");
                }
                self.report(error);
            }
            let mut cx = Context::new(Stage::Derivation, item.damaged);
            let what = self.expect(&place.what, &mut cx, &Ty::Kind, "what is placed");
            sound &= what.ty == Ty::Kind;
            let on = place
                .to
                .as_ref()
                .map(|port| self.holding(&what, port, place.turned.as_ref(), place.by.as_ref(), &mut cx));
            let how = place.turned.as_ref().map(|t| t.span).or(place.by.as_ref().map(|b| b.span));
            match (i, &on) {
                (0, None) if how.is_some() => self.report(
                    Diagnostic::new(
                        Code::BAD_VALUE,
                        how.unwrap_or_default(),
                        "the first part is the core: nothing holds it, so it is not turned about a port",
                    )
                    .label("about which port?")
                    .help("write it without `turned` and `by`"),
                ),
                (0, Some(on)) => self.report(
                    Diagnostic::new(
                        Code::BAD_VALUE,
                        on.port.span,
                        "the first part is the core: nothing holds it",
                    )
                    .label("held by this")
                    .help("write it without `to`"),
                ),
                (1.., None) => self.report(
                    Diagnostic::new(
                        Code::MISSING_FIELD,
                        place.name.span,
                        format!("nothing holds `{}`", place.name.text),
                    )
                    .label("a second part")
                    .help("say where it is attached, as in `to core.top`, or let rules attach it"),
                ),
                _ => {}
            }
            placed.push(ir::Placed { name: place.name.text.clone(), what, on, span: place.what.span });
        }
        if places.is_empty() && !item.damaged {
            self.report(
                Diagnostic::new(Code::MISSING_ITEM, item.span, "the initial design is empty")
                    .label("nothing to begin with")
                    .help("write for example `place core : cube`"),
            );
        }
        (sound && !placed.is_empty()).then_some(placed)
    }

    fn symmetry(&mut self, kind: &Name, count: Option<&Tree>, plane: Option<&Name>) -> Option<ir::Symmetry> {
        const HELP: &str = "write `symmetry none`, `symmetry mirror xy` or `symmetry radial 3 about y` \
                            (y is up, x is forward)";
        let (span, message) = match (kind.text.as_str(), count, plane) {
            ("none", None, None) => return Some(ir::Symmetry::None),
            ("mirror", None, Some(plane)) => {
                let normal = match plane.text.as_str() {
                    "xy" | "yx" => Some(2),
                    "yz" | "zy" => Some(0),
                    "xz" | "zx" => Some(1),
                    _ => None,
                };
                match normal {
                    Some(normal) => return Some(ir::Symmetry::Mirror(normal)),
                    None => (plane.span, format!("there is no plane `{}`", plane.text)),
                }
            }
            ("radial", Some(count), Some(axis)) => {
                let place = count.span;
                let mut cx = Context::new(Stage::Declaration, false);
                let count = self.expect(count, &mut cx, &Ty::Count, "how often the design is repeated");
                let count = self.constant_number(&count)?;
                let axis_index = ["x", "y", "z"].iter().position(|a| *a == axis.text);
                match axis_index {
                    Some(axis) if (2.0..=64.0).contains(&count) => {
                        return Some(ir::Symmetry::Radial(count as usize, axis));
                    }
                    Some(_) => {
                        self.report(
                            Diagnostic::new(
                                Code::OUT_OF_DOMAIN,
                                place,
                                "a radial symmetry repeats the design 2 to 64 times",
                            )
                            .label(format!("this is {count}"))
                            .help("write `symmetry none` for none"),
                        );
                        return None;
                    }
                    None => (axis.span, format!("there is no axis `{}`", axis.text)),
                }
            }
            ("mirror", ..) => (kind.span, "`mirror` needs a plane".to_owned()),
            ("radial", ..) => (kind.span, "`radial` needs a number and an axis".to_owned()),
            ("none", _, Some(plane)) => (plane.span, "`symmetry none` takes nothing more".to_owned()),
            (other, ..) => (kind.span, format!("there is no symmetry `{other}`")),
        };
        let label = if message.contains("needs") {
            "incomplete"
        } else if message.contains("nothing more") {
            "too much"
        } else {
            "not known"
        };
        self.report(
            Diagnostic::new(Code::BAD_VALUE, span, message).label(label).help(HELP).fix_if(
                respell(span, &kind.text, ["none", "mirror", "radial"]).filter(|_| span == kind.span),
            ),
        );
        None
    }

    /// Whether some declarations could not be read: what seems to be missing may be there.
    fn is_partial(&self) -> bool {
        let lost = |m: &LoadedModule| m.tree.headless || m.tree.broken.iter().any(|b| !b.is_empty());
        self.program.modules.iter().any(lost)
    }

    /// Reports what a grammar lacks.
    fn complete(&mut self, singles: &Singles<'_>, span: Span) -> bool {
        let tasks = !singles.tasks.is_empty();
        let wanted = [
            ("begin", "begin { place core : cube }"),
            ("simulate", "simulate hinge_model for 20 s"),
            ("maximize", "maximize travel in cm"),
            ("search", "search nested_annealing"),
        ];
        let cells = self.begins_with_cells().then_some(("lattice", "lattice 15 x 15 x 15 of KIND"));
        let missing = wanted.into_iter().chain(cells).filter(|(what, _)| {
            // Tasks say for themselves how they are simulated.
            !(*what == "simulate" && tasks || singles.seen.contains_key(what))
        });
        let (words, lines): (Vec<&str>, Vec<&str>) = missing.unzip();
        if !words.is_empty() && !self.is_partial() {
            let message = format!("this grammar has no {}", super::names::listed(&words, "or"));
            self.report(
                Diagnostic::new(Code::MISSING_ITEM, span, message)
                    .label("incomplete")
                    .help(format!("add for example {}", super::names::listed(&lines, "and"))),
            );
        }
        words.is_empty()
    }

    fn assemble(&mut self, name: &Name, singles: Singles<'a>, derived: Derived) -> Option<RuleSet> {
        let program = self.program;
        let tasks = self.tasks(&singles);
        let hardware = self.hardware();
        let observed = self.all_observed();
        let novelties = self.novelties();
        // What drives what is checked even where the tasks are not complete.
        let own_actuated = singles.tasks.is_empty().then(|| singles.actuated.clone());
        let mut terms: IndexMap<String, ir::Term> = IndexMap::new();
        let mut patterns = IndexMap::new();
        let mut parts = IndexMap::new();
        let mut actuators = IndexMap::new();
        let mut actuations = IndexMap::new();
        // Checking one declaration may touch others: the set grows while it is walked.
        let mut next = 0;
        let mut taken: IndexMap<String, Declaration> = IndexMap::new();
        let mut sound = true;
        while let Some(declaration) = self.touched.get_index(next).copied() {
            next += 1;
            let Some(item) = program.item(declaration) else { continue };
            let Some(own) = declared(item) else { continue };
            if let Some(other) = taken.insert(own.text.clone(), declaration)
                && other != declaration
            {
                self.report(
                    Diagnostic::new(
                        Code::DUPLICATE,
                        own.span,
                        format!("two modules declare `{}`, and this grammar uses both", own.text),
                    )
                    .label("one of them")
                    .help("rename one of them"),
                );
            }
            let key = own.text.clone();
            match &item.kind {
                ItemKind::Part(block) => match self.part(block, item.damaged) {
                    Some(part) => drop(parts.insert(key, part)),
                    None => sound = false,
                },
                ItemKind::Actuator(block) => match self.actuator(block, item.damaged) {
                    Some(actuator) => drop(actuators.insert(key, actuator)),
                    None => sound = false,
                },
                ItemKind::Pattern(_, value) => {
                    let value = self.fixed_pattern(value, item.damaged);
                    patterns.insert(key, value);
                }
                ItemKind::Term(_, ty, value) => {
                    let (ty, value) = self.term(ty, value, item.damaged);
                    terms.insert(key, ir::Term { ty, value, span: own.span });
                }
                ItemKind::Actuation { name, binder, kind, clauses } => {
                    match self.actuation(name, binder, kind, clauses, item.damaged) {
                        Some(actuation) => drop(actuations.insert(key, actuation)),
                        None => sound = false,
                    }
                }
                _ => {}
            }
        }
        let actuated: Vec<&Actuated> = match &tasks {
            Some((tasks, _)) => tasks.values().map(|(_, actuated)| actuated).collect(),
            None => own_actuated.iter().collect(),
        };
        let actuated_cells: Vec<Actuated> = actuated.iter().copied().cloned().collect();
        for actuated in actuated {
            self.check_actuated(actuated, &actuators, &actuations);
        }
        if let (Some(kind), Some((sides, cell, span))) = (singles.cell, &singles.lattice) {
            for (with, place) in actuated_cells.iter().filter_map(|actuated| actuated.get(&kind.text)) {
                if let Some(actuation) = actuations.get(with) {
                    self.check_attributes(&kind.text, &cell.params, actuation, *place);
                }
            }
            self.check_lattice_symmetry(*sides, singles.symmetry.unwrap_or(ir::Symmetry::None), *span);
        }
        let (tasks, objective) = tasks?;
        self.check_models(&tasks, &singles);
        let (targets, prototypes) = hardware?;
        self.check_targets(&tasks, &targets, &actuators, &actuations);
        self.check_periods(&tasks, &actuations, &terms, &observed);
        let novelties = novelties?;
        if !sound {
            return None;
        }
        Some(RuleSet {
            version: ir::VERSION,
            name: name.text.clone(),
            params: IndexMap::new(),
            enumerations: self.enumerations(),
            parts,
            actuators,
            patterns,
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
            fallbacks: derived.fallbacks,
            requirements: derived.requirements,
            preferences: derived.preferences,
            examples: derived.examples,
            actuations,
            tasks: tasks.into_iter().map(|(name, (task, _))| (name, task)).collect(),
            targets,
            prototypes,
            observed: observed.into_iter().map(|name| name.text).collect(),
            novelties,
            terms,
            objective,
            search: singles.search?,
            from: derived.from,
        })
    }

    /// The values of every enumeration that is used.
    fn enumerations(&self) -> IndexMap<String, Vec<String>> {
        let used = self.program.items().filter(|(d, _)| self.touched.contains(d));
        used.filter_map(|(_, item)| match &item.kind {
            ItemKind::Enum(name, values) => {
                Some((name.text.clone(), values.iter().map(|v| v.text.clone()).collect()))
            }
            _ => None,
        })
        .collect()
    }

    fn unknown_overrides(&mut self, span: Span) {
        let program = self.program;
        let known: Vec<&str> =
            self.params.keys().filter_map(|d| Some(declared(program.item(*d)?)?.text.as_str())).collect();
        for (name, _) in self.overrides {
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
