//! Checks the grammar as a whole and puts the typed rule set together.

use indexmap::IndexMap;

use super::Checker;
use super::expr::Context;
use super::stage::Stage;
use crate::diagnostics::{Code, Diagnostic, did_you_mean, respell};
use crate::ir::{self, Expr, ExprKind, RuleSet, Ty};
use crate::names::{Declaration, declared};
use crate::source::Span;
use crate::syntax::ast::{Item, ItemKind, Name};
use crate::units::Dimension;

/// Declarations of which a grammar has one.
#[derive(Default)]
struct Singles<'t> {
    grammar: Option<&'t Name>,
    begin: Option<Vec<ir::Placed>>,
    symmetry: Option<ir::Symmetry>,
    model: Option<ir::Model>,
    objective: Option<ir::Objective>,
    search: Option<ir::Search>,
    actuated: IndexMap<String, (String, Span)>,
    seen: IndexMap<&'static str, Span>,
}

impl<'a> Checker<'a> {
    /// Checks everything that the first module says or uses.
    pub(super) fn grammar(&mut self) -> Option<RuleSet> {
        let program = self.program;
        let entry = program.modules.first()?;
        let items: Vec<(Declaration, &Item)> = program.items().filter(|(d, _)| d.module == 0).collect();
        for (declaration, item) in &items {
            if matches!(item.kind, ItemKind::Param(_)) {
                self.param(*declaration);
            }
        }
        let mut singles = Singles::default();
        for (declaration, item) in &items {
            self.single(item, &mut singles);
            self.check_own(*declaration, item);
        }
        // Rules and requirements that are imported by name take part, too.
        let mut rules = Vec::new();
        let mut requirements = Vec::new();
        let imported =
            entry.scope.values().filter(|d| d.module != 0).filter_map(|d| Some((*d, program.item(*d)?)));
        for (declaration, item) in imported.chain(items.iter().copied()) {
            match &item.kind {
                ItemKind::Rule(name, clauses) => {
                    rules.extend(self.rule(name, clauses, declaration.module, item.damaged));
                }
                ItemKind::Require { name, condition, because } => {
                    let mut cx = Context::new(declaration.module, Stage::Derivation, item.damaged);
                    let text_of = condition;
                    let condition = self.expect(condition, &mut cx, &Ty::Bool, "a requirement");
                    let name = match name {
                        Some(name) => name.text.clone(),
                        // Without a name it is known by what it says.
                        None => {
                            self.sources.slice(text_of.span).split_whitespace().collect::<Vec<_>>().join(" ")
                        }
                    };
                    requirements.push(ir::Requirement {
                        name,
                        condition,
                        because: because.clone(),
                        span: item.span,
                    });
                }
                _ => {}
            }
        }
        let Some(name) = singles.grammar else {
            // A module without `grammar` is only imported; it has been checked.
            return None;
        };
        let complete = self.complete(&singles, name.span);
        let assembled = self.assemble(name, singles, rules, requirements);
        self.unknown_overrides(name.span);
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

    /// Checks a declaration of the first module for its own sake.
    fn check_own(&mut self, declaration: Declaration, item: &Item) {
        let module = declaration.module;
        match &item.kind {
            ItemKind::Part(block) => {
                self.part(block, module, item.damaged);
            }
            ItemKind::Actuator(block) => {
                self.actuator(block, module, item.damaged);
            }
            ItemKind::Model(block) => {
                self.model(block, None, module, item.damaged);
            }
            ItemKind::Search(block) => {
                self.search(block, module, item.damaged);
            }
            ItemKind::Pattern(_, value) => {
                self.fixed_pattern(value, module, item.damaged);
            }
            ItemKind::Term(_, ty, value) => {
                self.term(ty, value, module, item.damaged);
            }
            ItemKind::Actuation { name, binder, kind, clauses } => {
                self.actuation(name, binder, kind, clauses, module, item.damaged);
            }
            ItemKind::Let(_, value) => {
                self.inline(declaration, value);
            }
            _ => {}
        }
    }

    fn fixed_pattern(&mut self, value: &crate::syntax::ast::Expr, module: usize, damaged: bool) -> Expr {
        let mut cx = Context::new(module, Stage::Pattern, damaged);
        self.expect(value, &mut cx, &Ty::Quantity(Dimension::ANGLE), "a pattern")
    }

    fn term(
        &mut self,
        ty: &Name,
        value: &crate::syntax::ast::Expr,
        module: usize,
        damaged: bool,
    ) -> (Ty, Expr) {
        let ty = self.type_named(ty);
        let mut cx = Context::new(module, Stage::Score, damaged);
        let value = self.expect(value, &mut cx, &ty, "this term");
        (ty, value)
    }

    /// Takes in a declaration of which there is one.
    fn single(&mut self, item: &'a Item, singles: &mut Singles<'a>) {
        let what = match &item.kind {
            ItemKind::Grammar(_) => "grammar",
            ItemKind::Begin(_) => "begin",
            ItemKind::Symmetry(..) => "symmetry",
            ItemKind::Simulate(..) => "simulate",
            ItemKind::Objective { .. } => "maximize",
            ItemKind::UseSearch(_) => "search",
            ItemKind::Actuate(..) => "actuate",
            _ => return,
        };
        if what != "actuate"
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
            ItemKind::Grammar(name) => singles.grammar = Some(name),
            ItemKind::Begin(places) => {
                let mut placed = Vec::new();
                for place in places {
                    let fine = self.program.lookup(0, &place.kind.text).is_some_and(|(d, item)| {
                        self.touched.insert(d);
                        matches!(item.kind, ItemKind::Part(_))
                    });
                    if fine {
                        let name = place.name.text.clone();
                        placed.push(ir::Placed {
                            name,
                            kind: place.kind.text.clone(),
                            span: place.kind.span,
                        });
                    } else if !self.program.is_lost(0, &place.kind.text) {
                        let scope = self.program.modules.first();
                        let parts = scope.iter().flat_map(|m| m.scope.iter()).filter(|(_, d)| {
                            self.program.item(**d).is_some_and(|i| matches!(i.kind, ItemKind::Part(_)))
                        });
                        let parts: Vec<&str> = parts.map(|(n, _)| n.as_str()).collect();
                        let help = did_you_mean(&place.kind.text, parts.iter().copied());
                        self.report(
                            Diagnostic::new(
                                Code::UNKNOWN_NAME,
                                place.kind.span,
                                format!("there is no part `{}` to place", place.kind.text),
                            )
                            .label("not a passive part")
                            .help(help.unwrap_or_else(|| {
                                "declare it with `part`, or import it with `use`".to_owned()
                            }))
                            .fix_if(respell(
                                place.kind.span,
                                &place.kind.text,
                                parts,
                            )),
                        );
                    }
                }
                if placed.len() > 1 {
                    let span = places.get(1).map_or(item.span, |p| p.name.span);
                    self.report(
                        Diagnostic::new(Code::BAD_VALUE, span, "the initial design has one part: the core")
                            .label("a second part")
                            .help("let rules attach the others"),
                    );
                }
                if places.is_empty() && !item.damaged {
                    self.report(
                        Diagnostic::new(Code::MISSING_ITEM, item.span, "the initial design is empty")
                            .label("nothing to begin with")
                            .help("write for example `place core : cube`"),
                    );
                }
                singles.begin = Some(placed);
            }
            ItemKind::Symmetry(kind, plane) => singles.symmetry = self.symmetry(kind, plane.as_ref()),
            ItemKind::Simulate(model, duration) => singles.model = self.simulated(model, duration),
            ItemKind::Objective { maximize, value } => {
                singles.objective = self.objective(*maximize, value, item.damaged)
            }
            ItemKind::UseSearch(name) => {
                if let Some(ItemKind::Search(block)) =
                    self.named(name, "search", |k| matches!(k, ItemKind::Search(_)))
                {
                    let module = self.program.lookup(0, &name.text).map_or(0, |(d, _)| d.module);
                    singles.search = self.search(block, module, false);
                }
            }
            ItemKind::Actuate(kind, with) => {
                let kind_ok = self.named(kind, "actuator", |k| matches!(k, ItemKind::Actuator(_))).is_some();
                let with_ok =
                    self.named(with, "actuation", |k| matches!(k, ItemKind::Actuation { .. })).is_some();
                if kind_ok && with_ok {
                    let entry = (with.text.clone(), with.span);
                    if singles.actuated.insert(kind.text.clone(), entry).is_some() {
                        self.report(
                            Diagnostic::new(
                                Code::DUPLICATE,
                                kind.span,
                                format!("`{}` is actuated twice", kind.text),
                            )
                            .label("again")
                            .help("an actuator follows one actuation"),
                        );
                    }
                }
            }
            _ => {}
        }
    }

    /// The declaration of a certain kind that a name means.
    fn named(&mut self, name: &Name, what: &str, fits: impl Fn(&ItemKind) -> bool) -> Option<&'a ItemKind> {
        let program = self.program;
        match program.lookup(0, &name.text) {
            Some((declaration, item)) if fits(&item.kind) => {
                self.touched.insert(declaration);
                return Some(&item.kind);
            }
            None if program.is_lost(0, &name.text) => return None,
            _ => {}
        }
        let scope = program.modules.first();
        let others = scope
            .iter()
            .flat_map(|m| m.scope.iter())
            .filter(|(_, d)| program.item(**d).is_some_and(|i| fits(&i.kind)))
            .map(|(n, _)| n.as_str());
        let others: Vec<&str> = others.collect();
        let help = did_you_mean(&name.text, others.iter().copied())
            .unwrap_or_else(|| format!("declare it with `{what}`, or import it with `use`"));
        self.report(
            Diagnostic::new(Code::UNKNOWN_NAME, name.span, format!("there is no {what} `{}`", name.text))
                .label("not declared")
                .help(help)
                .fix_if(respell(name.span, &name.text, others)),
        );
        None
    }

    fn symmetry(&mut self, kind: &Name, plane: Option<&Name>) -> Option<ir::Symmetry> {
        let (span, message) = match (kind.text.as_str(), plane) {
            ("none", None) => return Some(ir::Symmetry::None),
            ("mirror", Some(plane)) => {
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
            ("mirror", None) => (kind.span, "`mirror` needs a plane".to_owned()),
            ("none", Some(plane)) => (plane.span, "`symmetry none` takes no plane".to_owned()),
            (other, _) => (kind.span, format!("there is no symmetry `{other}`")),
        };
        self.report(
            Diagnostic::new(Code::BAD_VALUE, span, message)
                .label("not known")
                .help("write `symmetry none`, or `symmetry mirror xy` (y is up, x is forward)")
                .fix_if(respell(span, &kind.text, ["none", "mirror"]).filter(|_| span == kind.span)),
        );
        None
    }

    fn simulated(&mut self, name: &Name, duration: &crate::syntax::ast::Expr) -> Option<ir::Model> {
        let mut cx = Context::new(0, Stage::Declaration, false);
        let span = duration.span;
        let duration = self.expect(duration, &mut cx, &Ty::Quantity(Dimension::TIME), "the simulated time");
        let duration = self.constant_number(&duration);
        if let Some(d) = duration
            && !(d > 0.0 && d <= 3600.0)
        {
            self.report(
                Diagnostic::new(Code::OUT_OF_DOMAIN, span, "the simulated time must lie within 0 s .. 1 h")
                    .label("outside"),
            );
            return None;
        }
        let module = self.program.lookup(0, &name.text).map_or(0, |(d, _)| d.module);
        match self.named(name, "model", |k| matches!(k, ItemKind::Model(_))) {
            Some(ItemKind::Model(block)) => {
                let block = block.clone();
                self.model(&block, Some(duration?), module, false)
            }
            _ => None,
        }
    }

    fn objective(
        &mut self,
        maximize: bool,
        tree: &crate::syntax::ast::Expr,
        damaged: bool,
    ) -> Option<ir::Objective> {
        let mut cx = Context::new(0, Stage::Score, damaged);
        let value = self.infer(tree, &mut cx);
        let unit = match &tree.kind {
            crate::syntax::ast::ExprKind::Convert(_, unit) => unit.text.clone(),
            _ => String::new(),
        };
        match value.ty.dimension() {
            Some(d) if d.is_number() => Some(ir::Objective { maximize, value, unit }),
            Some(d) => {
                self.report(
                    Diagnostic::new(
                        Code::OBJECTIVE_UNIT,
                        value.span,
                        format!("the objective is a {d}; in which unit?"),
                    )
                    .label(format!("a {d}"))
                    .help(format!(
                        "write `in {}` after it: temperatures are numbers on this scale",
                        crate::units::suggest(d)
                    )),
                );
                None
            }
            None if value.ty == Ty::Unknown => None,
            None => {
                self.report(
                    Diagnostic::new(
                        Code::WRONG_TYPE,
                        value.span,
                        format!("the objective must be a number, but this is a {}", value.ty),
                    )
                    .label("not a number"),
                );
                None
            }
        }
    }

    /// Reports what a grammar lacks.
    fn complete(&mut self, singles: &Singles<'_>, span: Span) -> bool {
        let broken =
            self.program.modules.first().is_some_and(|m| m.tree.broken.iter().any(|b| !b.is_empty()));
        let wanted = [
            ("begin", "begin { place core : cube }"),
            ("simulate", "simulate hinge_model for 20 s"),
            ("maximize", "maximize travel in cm"),
            ("search", "search nested_annealing"),
        ];
        let mut complete = true;
        for (what, example) in wanted {
            if !singles.seen.contains_key(what) {
                complete = false;
                if !broken {
                    self.report(
                        Diagnostic::new(Code::MISSING_ITEM, span, format!("this grammar has no `{what}`"))
                            .label("incomplete")
                            .help(format!("add for example: {example}")),
                    );
                }
            }
        }
        complete
    }

    fn assemble(
        &mut self,
        name: &Name,
        singles: Singles<'_>,
        rules: Vec<ir::Rule>,
        requirements: Vec<ir::Requirement>,
    ) -> Option<RuleSet> {
        let program = self.program;
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
            let module = declaration.module;
            let key = own.text.clone();
            match &item.kind {
                ItemKind::Part(block) => match self.part(block, module, item.damaged) {
                    Some(part) => drop(parts.insert(key, part)),
                    None => sound = false,
                },
                ItemKind::Actuator(block) => match self.actuator(block, module, item.damaged) {
                    Some(actuator) => drop(actuators.insert(key, actuator)),
                    None => sound = false,
                },
                ItemKind::Pattern(_, value) => {
                    let value = self.fixed_pattern(value, module, item.damaged);
                    patterns.insert(key, value);
                }
                ItemKind::Term(_, ty, value) => {
                    let (ty, value) = self.term(ty, value, module, item.damaged);
                    terms.insert(key, ir::Term { ty, value, span: own.span });
                }
                ItemKind::Actuation { name, binder, kind, clauses } => {
                    match self.actuation(name, binder, kind, clauses, module, item.damaged) {
                        Some(actuation) => drop(actuations.insert(key, actuation)),
                        None => sound = false,
                    }
                }
                _ => {}
            }
        }
        for (kind, (with, span)) in &singles.actuated {
            let (Some(actuator), Some(actuation)) = (actuators.get(kind), actuations.get(with)) else {
                continue;
            };
            self.check_attributes(kind, actuator, actuation, *span);
        }
        let actuated: IndexMap<String, String> =
            singles.actuated.into_iter().map(|(k, (w, _))| (k, w)).collect();
        for (kind, actuator) in &actuators {
            if !actuated.contains_key(kind) {
                self.report(
                    Diagnostic::new(Code::NOT_ACTUATED, actuator.span, format!("nothing drives `{kind}`"))
                        .label("an actuator without an actuation")
                        .help(format!("write for example `actuate {kind} with bezier_pac`")),
                );
            }
        }
        if !sound {
            return None;
        }
        Some(RuleSet {
            version: ir::VERSION,
            name: name.text.clone(),
            params: IndexMap::new(),
            parts,
            actuators,
            patterns,
            symmetry: singles.symmetry.unwrap_or(ir::Symmetry::None),
            begin: singles.begin?,
            rules,
            requirements,
            actuations,
            actuated,
            model: singles.model?,
            terms,
            objective: singles.objective?,
            search: singles.search?,
        })
    }

    /// An actuation may read only what the actuator that it drives has.
    fn check_attributes(
        &mut self,
        kind: &str,
        actuator: &ir::Actuator,
        actuation: &ir::Actuation,
        span: Span,
    ) {
        let exprs = actuation.lets.iter().chain(&actuation.moving).map(|(_, e)| e).chain([&actuation.drive]);
        for expr in exprs {
            expr.any(&mut |e| {
                if let ExprKind::Attribute(of, name) = &e.kind {
                    let own = matches!(of.kind, ExprKind::Local(0));
                    if own && name != "turn" && name != "image" && !actuator.params.contains_key(name) {
                        self.report(
                            Diagnostic::new(
                                Code::UNKNOWN_FIELD,
                                span,
                                format!("this actuation reads `{name}`, which `{kind}` does not have"),
                            )
                            .label("does not fit")
                            .also(e.span, "read here"),
                        );
                    }
                }
                false
            });
        }
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
