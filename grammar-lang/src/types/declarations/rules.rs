//! Checks rules.

use std::collections::BTreeMap;
use std::slice::from_ref;

use super::Declarations;
use crate::diagnostics::{Code, Diagnostic, did_you_mean};
use crate::ir::{self, Attribute, Expr, ExprKind, Group, PartAttribute, Settable, Ty};
use crate::source::Span;
use crate::syntax::ast::{self, Name, RuleClause, RuleClauseKind};
use crate::syntax::declarations::BlockKind;
use crate::types::expressions::context::{Context, Local};
use crate::types::expressions::stage::Stage;
use crate::units::{self, Dimension};

impl Declarations<'_> {
    /// The group of parts that a kind's name stands for.
    pub(super) fn group_named(&mut self, kind: &Name, cx: &mut Context) -> Option<Group> {
        let tree = ast::Expr { kind: ast::ExprKind::Name(kind.text.clone()), span: kind.span };
        let expr = self.expressions.expect(&tree, cx, &Ty::Group, "what is matched");
        match expr.kind {
            ExprKind::Group(group) if expr.ty == Ty::Group => Some(group),
            _ => None,
        }
    }

    pub(in crate::types) fn rule(
        &mut self,
        name: &Name,
        clauses: &[RuleClause],
        damaged: bool,
    ) -> Option<ir::Rule> {
        if self.is_too_long(clauses) {
            return None;
        }
        let mut cx = Context::new(Stage::Derivation, damaged);
        let found = self.expressions.errors.len();
        let matches = self.all_matches(clauses, &mut cx);
        let choices = self.choices(clauses, &mut cx);
        self.tell_of_made_later(found, clauses);
        let late = late_values(clauses);
        let bound = cx.locals.len();
        let mut guards = Vec::new();
        let mut effects = Vec::new();
        let mut weight = None;
        for (place, clause) in clauses.iter().enumerate() {
            match &clause.kind {
                RuleClauseKind::Then => effects.push(ir::Effect::Then),
                RuleClauseKind::Always => {}
                RuleClauseKind::Guard(positive, condition) => {
                    let what = if *positive { "what follows `when`" } else { "what follows `unless`" };
                    // A guard is asked before the effects: it does not see what they make.
                    let mut before = cx.clone();
                    before.locals.truncate(bound);
                    let known = self.expressions.errors.len();
                    let condition = self.expressions.expect(condition, &mut before, &Ty::Bool, what);
                    self.tell_of_guarded(known, &cx);
                    let needs = highest_local(&condition, bound);
                    let condition = if *positive {
                        condition
                    } else {
                        Expr { ty: Ty::Bool, span: condition.span, kind: ExprKind::Not(Box::new(condition)) }
                    };
                    guards.push(ir::Guard { needs, condition });
                }
                RuleClauseKind::Weight(value) => {
                    let mut cx = Context::new(Stage::Weight, damaged);
                    let value = self.expressions.expect(value, &mut cx, &Ty::NUMBER, "a weight");
                    if let Some(first) = weight.replace(value) {
                        self.report(
                            Diagnostic::new(Code::DUPLICATE, clause.span, "a rule has one `weight`")
                                .label("another one")
                                .also(first.span, "the first one")
                                .help("keep one of them"),
                        );
                    }
                }
                RuleClauseKind::Let(name, value) if late.contains(&place) => {
                    let known = self.expressions.errors.len();
                    effects.push(self.late_value(name, value, &mut cx));
                    self.tell_of_makers(known, clauses, place);
                }
                kind => {
                    let known = self.expressions.errors.len();
                    effects.extend(self.effect(kind, &mut cx));
                    self.tell_of_makers(known, clauses, place);
                }
            }
        }
        if effects.is_empty() && !damaged && self.expressions.errors.len() == found {
            let help = if is_always(clauses) {
                "write an effect: `set s.load = 2 N for s in strut`"
            } else {
                "write an effect: `attach`, `set`, `remove`, `replace` or `revert`; `fill`, `paint` or `clear` in a lattice"
            };
            self.report(
                Diagnostic::new(Code::NO_EFFECT, name.span, format!("the rule `{}` does nothing", name.text))
                    .label("without an effect")
                    .help(help),
            );
        }
        self.check_twice(clauses);
        self.check_phases(clauses, damaged);
        self.check_always(clauses);
        self.check_reversion(clauses);
        self.check_space(clauses);
        if !damaged && self.expressions.errors.len() == found {
            self.unread(bound_within(clauses).into_iter(), "use it in this rule, or take it out");
            // Several blocks may give one name: what reads their list reads all of them.
            let products = products_of(clauses);
            let read: Vec<&Name> =
                products.iter().copied().filter(|name| self.expressions.read.contains(&name.span)).collect();
            let is_read = |name: &&Name| read.iter().any(|read| read.text == name.text);
            self.products.extend(products.into_iter().filter(|name| !is_read(name)).cloned());
        }
        if damaged || self.expressions.errors.iter().skip(found).any(Diagnostic::is_error) {
            self.faulty.insert(name.span);
        }
        let weight = weight.unwrap_or(Expr { kind: ExprKind::Number(1.0), ty: Ty::NUMBER, span: name.span });
        Some(ir::Rule {
            name: name.text.clone(),
            matches: matches?,
            choices,
            guards,
            effects,
            weight,
            locals: cx.locals.into_iter().take(bound).map(|l| l.name).collect(),
            span: name.span,
        })
    }

    /// What the clauses of a rule match.
    fn all_matches(&mut self, clauses: &[RuleClause], cx: &mut Context) -> Option<Vec<ir::Match>> {
        let mut matches = Some(Vec::new());
        let mut nothing: Option<Span> = None;
        for clause in clauses {
            let more = match &clause.kind {
                RuleClauseKind::MatchNothing => {
                    nothing = Some(clause.span);
                    continue;
                }
                RuleClauseKind::Match { links, condition } => self.matches(links, condition.as_ref(), cx),
                _ => continue,
            };
            if let Some(nothing) = nothing {
                self.report(
                    Diagnostic::new(
                        Code::DUPLICATE,
                        clause.span,
                        "a rule with `match nothing` cannot match anything else",
                    )
                    .label("another match")
                    .also(nothing, "`match nothing` is written here")
                    .help("remove one of them"),
                );
            }
            matches = matches.zip(more).map(|(mut all, more)| {
                all.extend(more);
                all
            });
        }
        matches
    }

    /// The choices of a rule, and its `let`s: choices with one value.
    fn choices(&mut self, clauses: &[RuleClause], cx: &mut Context) -> Vec<ir::Choice> {
        let late = late_values(clauses);
        let mut choices = Vec::new();
        for (place, clause) in clauses.iter().enumerate() {
            let before = std::mem::replace(&mut cx.stage, Stage::Choice);
            match &clause.kind {
                RuleClauseKind::Choose(name, domain, spread) => {
                    let domain = self.expressions.infer(domain, cx);
                    let ty = self.chosen_from(&domain);
                    let spread = match spread {
                        Some(spread) => self.spread(spread, &ty, cx),
                        None => ir::Spread::Even,
                    };
                    cx.stage = before;
                    self.expressions.bind(name, ty, cx);
                    self.expressions.chosen_kinds(name, &domain);
                    choices.push(ir::Choice { name: name.text.clone(), domain, spread });
                }
                RuleClauseKind::Let(name, value) if !late.contains(&place) => {
                    let value = self.expressions.infer(value, cx);
                    cx.stage = before;
                    let (ty, span) = (value.ty.clone(), value.span);
                    let kind = ExprKind::Set(vec![value]);
                    let domain = Expr { kind, ty: Ty::Domain(Box::new(ty.clone())), span };
                    self.expressions.bind(name, ty, cx);
                    self.expressions.chosen_kinds(name, &domain);
                    choices.push(ir::Choice { name: name.text.clone(), domain, spread: ir::Spread::Fixed });
                }
                _ => {}
            }
            cx.stage = before;
        }
        choices
    }

    fn chosen_from(&mut self, domain: &Expr) -> Ty {
        match &domain.ty {
            Ty::Domain(item) | Ty::List(item) => (**item).clone(),
            Ty::Group => match &domain.kind {
                ExprKind::Group(group) => self.expressions.member_of(group, domain.span),
                _ => Ty::Part,
            },
            Ty::Unknown => Ty::Unknown,
            other => {
                let other = other.clone();
                self.report(
                    Diagnostic::new(
                        Code::WRONG_TYPE,
                        domain.span,
                        format!("nothing can be chosen from a {other}"),
                    )
                    .label("not a domain")
                    .help("write a range `a .. b` or a set `{ a, b }`"),
                );
                Ty::Unknown
            }
        }
    }

    /// `by normal(...)`, `by uniform(...)` or `by [weights]`.
    fn spread(&mut self, tree: &ast::Expr, ty: &Ty, cx: &mut Context) -> ir::Spread {
        let spread = self.expressions.infer(tree, cx);
        let numbers = Ty::List(Box::new(Ty::NUMBER));
        if spread.ty.fits(&numbers) {
            return ir::Spread::Weights(spread);
        }
        let Some(dimension) = ty.dimension() else {
            if *ty != Ty::Unknown {
                self.expressions.fit(spread, &numbers, "what follows `by`");
            }
            return ir::Spread::Even;
        };
        let spread = self.expressions.fit(spread, &Ty::Distribution(dimension), "what follows `by`");
        match spread.kind {
            ExprKind::Call(function, arguments) if spread.ty != Ty::Unknown => {
                let Ok([a, b]) = <[Expr; 2]>::try_from(arguments) else { return ir::Spread::Even };
                if function == ir::Function::Normal {
                    ir::Spread::Normal(a, b)
                } else {
                    ir::Spread::Uniform(a, b)
                }
            }
            _ => ir::Spread::Even,
        }
    }

    /// Says of names that matches and values read, and that an effect makes only after them.
    fn tell_of_made_later(&mut self, known: usize, clauses: &[RuleClause]) {
        let made = products_of(clauses);
        self.expressions.errors.help_unknown(known, |name| {
            made.iter().any(|made| made.text == name).then(|| {
                format!("this rule makes `{name}` after its matches, choices and values are known: read `{name}` in the lines below `as {name}`, without a `let`")
            })
        });
    }

    /// Says of names that a condition of the whole rule reads, and that an effect above it makes.
    fn tell_of_guarded(&mut self, known: usize, cx: &Context) {
        self.expressions.errors.help_unknown(known, |name| {
            cx.locals.iter().any(|local| local.name == name).then(|| {
                format!("this condition is tested before the rule makes `{name}`: put what depends on it into a block, `if CONDITION {{ ... }}`")
            })
        });
    }

    /// Says of names that the clause at `place` reads and does not know which of them a line below makes.
    pub(super) fn tell_of_makers(&mut self, known: usize, clauses: &[RuleClause], place: usize) {
        let below = products_of(clauses.get(place + 1..).unwrap_or(&[]));
        self.expressions.errors.help_unknown(known, |name| {
            let is_made = below.iter().any(|made| made.text == name);
            is_made.then(|| format!("it is made further down: move `... as {name}` above this line"))
        });
    }

    pub(super) fn effect(&mut self, clause: &RuleClauseKind, cx: &mut Context) -> Option<ir::Effect> {
        match clause {
            RuleClauseKind::Attach { what, port, turned, by, alone, product } => {
                let what = self.expressions.expect(what, cx, &Ty::Kind, "what is attached");
                let on = self.holding(&what, port, turned.as_ref(), by.as_ref(), cx);
                let on = ir::Holding { alone: *alone, ..on };
                self.product(product.as_ref(), &what, cx);
                Some(ir::Effect::Attach { what, on })
            }
            RuleClauseKind::Set { target, value } => self.set(target, value, cx),
            RuleClauseKind::Remove(part) => {
                let part = self.expressions.expect(part, cx, &Ty::Part, "what is removed");
                self.check_removable(&part, "remove");
                Some(ir::Effect::Remove(part))
            }
            RuleClauseKind::Replace { part, with, between, product } => {
                let part = self.expressions.expect(part, cx, &Ty::Part, "what is replaced");
                self.check_removable(&part, "replace");
                let with = self.expressions.expect(with, cx, &Ty::Kind, "what takes its place");
                let between = between.as_ref().map(|(a, b)| {
                    let mut end = |e| self.expressions.expect(e, cx, &Ty::Part, "a neighbour");
                    (end(a), end(b))
                });
                self.product(product.as_ref(), &with, cx);
                Some(ir::Effect::Replace { part, with, between })
            }
            RuleClauseKind::Revert(step) => {
                let step = self.expressions.expect(step, cx, &Ty::Step, "what is reverted");
                Some(ir::Effect::Revert(step))
            }
            RuleClauseKind::Cells { region, .. } => self.cells(clause, region.span, cx),
            RuleClauseKind::Repeat { over, clauses } => self.repeat(over, clauses, cx),
            _ => None,
        }
    }

    /// Where and how something is held.
    pub(super) fn holding(
        &mut self,
        what: &Expr,
        port: &ast::Expr,
        turned: Option<&ast::Expr>,
        by: Option<&Name>,
        cx: &mut Context,
    ) -> ir::Holding {
        let port = self.expressions.expect(port, cx, &Ty::Port, "where it is attached");
        let angle = Ty::Quantity(Dimension::ANGLE);
        let turned = turned.map(|t| self.expressions.expect(t, cx, &angle, "what follows `turned`"));
        let by = by.and_then(|name| {
            let tree = ast::Expr { kind: ast::ExprKind::Name(name.text.clone()), span: name.span };
            if self.expressions.port_name(&tree).is_none() {
                self.expressions.unknown_port(name);
                return None;
            }
            self.check_own_port(what, name);
            Some(name.text.clone())
        });
        ir::Holding { port, turned, by, alone: false }
    }

    /// A part is held by one of its own ports.
    fn check_own_port(&mut self, what: &Expr, port: &Name) {
        let ExprKind::Kind(kind, _) = &what.kind else { return };
        let ports = self.ports_of(kind, what.span);
        if ports.is_empty() || ports.contains(&port.text) {
            return;
        }
        // A real port of another kind is no slip of the finger.
        let exists = self.environment.ports.contains(&port.text);
        let help = did_you_mean(&port.text, ports.iter().map(String::as_str)).filter(|_| !exists);
        self.report(
            Diagnostic::new(
                Code::UNKNOWN_FIELD,
                port.span,
                format!("`{kind}` has no port `{}` to be held by", port.text),
            )
            .label(if exists { "a port of another kind of part" } else { "not one of its ports" })
            .help(help.unwrap_or_else(|| format!("it has: {}", ports.join(", ")))),
        );
    }

    /// The ports of a kind of part; none if the kind is not known.
    fn ports_of(&self, kind: &str, place: Span) -> Vec<String> {
        let built_in = |ports: &[&str]| ports.iter().map(|p| (*p).to_owned()).collect();
        // What could not be read of a part may be the port that is meant.
        let found = self.environment.program.lookup(place, kind).filter(|(_, item)| !item.damaged);
        match found.map(|(_, item)| &item.kind) {
            Some(ast::ItemKind::Block(BlockKind::Actuator, _)) => built_in(ir::ACTUATOR_PORTS),
            Some(ast::ItemKind::Block(BlockKind::Part, block)) => {
                let declared = block.fields.iter().filter_map(|f| match f {
                    ast::Field::Port(port) => Some(port.name.text.clone()),
                    _ => None,
                });
                let declared: Vec<String> = declared.collect();
                if declared.is_empty() { built_in(ir::BLOCK_PORTS) } else { declared }
            }
            _ => Vec::new(),
        }
    }

    /// What `begin` places is in every design: no rule can take it away.
    fn check_removable(&mut self, part: &Expr, what: &str) {
        if let ExprKind::Placed(name) = &part.kind {
            self.report(
                Diagnostic::new(
                    Code::BAD_VALUE,
                    part.span,
                    format!("`{name}` is part of every design: a rule cannot {what} it"),
                )
                .label("placed by `begin`")
                .help("match another part, as in `match p : part where p is not core`"),
            );
        }
    }

    /// Reports an effect that changes what an earlier one of the same rule, or of the same block, has changed.
    fn check_twice(&mut self, clauses: &[RuleClause]) {
        self.check_twice_within(clauses, "", &mut BTreeMap::new());
    }

    /// The same for the clauses of a block, repeated over what is written as `over`: over another kind it is another part, whatever
    /// it is called.
    fn check_twice_within<'c>(
        &mut self,
        clauses: &'c [RuleClause],
        over: &str,
        seen: &mut BTreeMap<(&'static str, String), Span>,
    ) {
        for clause in clauses {
            let (verb, target): (&'static str, &'c ast::Expr) = match &clause.kind {
                RuleClauseKind::Then => {
                    seen.clear();
                    continue;
                }
                RuleClauseKind::Set { target, .. } => ("set", target),
                RuleClauseKind::Remove(part) => ("remove", part),
                RuleClauseKind::Replace { part, .. } => ("replace", part),
                RuleClauseKind::Revert(step) => ("revert", step),
                RuleClauseKind::Repeat { over: binders, clauses } => {
                    // What is done once has its condition in the place of what it is repeated for.
                    let place = match (binders.first(), binders.last()) {
                        (Some(first), Some(last)) => Some(first.over.span.join(last.over.span)),
                        _ => clauses.first().map(|condition| condition.span),
                    };
                    let Some(place) = place else { continue };
                    let inner = self.written(place);
                    self.check_twice_within(clauses, &format!("{over} {inner}"), seen);
                    continue;
                }
                _ => continue,
            };
            let text = self.written(target.span);
            let key = (verb, format!("{text} {over}"));
            if let Some(first) = seen.get(&key).copied() {
                self.report(
                    Diagnostic::new(
                        Code::DUPLICATE,
                        target.span,
                        format!("this rule does `{verb} {text}` twice"),
                    )
                    .label("again")
                    .also(first, "the first time")
                    .help("keep one of them"),
                );
            } else {
                seen.insert(key, target.span);
            }
        }
    }

    /// What stands at a place, without its spaces.
    fn written(&self, span: Span) -> String {
        self.environment.sources.slice(span).split_whitespace().collect()
    }

    /// Warns of names that a rule or actuation of the first text binds and never reads.
    pub(super) fn unread<'n>(&mut self, names: impl Iterator<Item = &'n Name>, help: &str) {
        let own: Vec<&Name> =
            names.filter(|name| self.environment.program.module_at(name.span) == 0).collect();
        self.idle.there.extend(own.iter().map(|name| name.span));
        let idle = own.into_iter().filter(|name| !self.expressions.read.contains(&name.span));
        let told = idle.map(|name| {
            Diagnostic::new(Code::UNUSED, name.span, format!("nothing uses `{}`", name.text))
                .label("not used")
                .help(help)
        });
        let told = told.collect();
        self.report_unused(told);
    }

    /// A part that an effect makes takes a local slot, with or without a name.
    fn product(&mut self, name: Option<&Name>, what: &Expr, cx: &mut Context) {
        let local = |slot: usize| {
            cx.locals.get(slot).is_some_and(|local| self.expressions.is_chosen_from_actuators(local.span))
        };
        let is_active = self.expressions.is_always_actuator(what, &local);
        let ty = if is_active { Ty::Actuator } else { Ty::Part };
        match name {
            Some(name) => {
                if ty == Ty::Actuator {
                    self.expressions.actuators_made.insert(name.span);
                }
                self.expressions.note_kind(name, what);
                self.expressions.bind(name, ty, cx);
            }
            None => cx.locals.push(Local::new("", ty, what.span)),
        }
    }

    /// The matches of one clause: several if it is a chain.
    fn matches(
        &mut self,
        links: &[ast::Link],
        condition: Option<&ast::Expr>,
        cx: &mut Context,
    ) -> Option<Vec<ir::Match>> {
        let mut out = Vec::new();
        let mut before: Option<usize> = None;
        let mut sound = true;
        for link in links {
            let chained = links.len() > 1;
            let slot = cx.locals.len();
            match self.matched(link, before, chained, cx) {
                Some(what) => out.push(ir::Match { what, condition: None }),
                None => sound = false,
            }
            before = chained.then_some(slot);
        }
        let condition = condition.map(|c| self.expressions.expect(c, cx, &Ty::Bool, "what follows `where`"));
        if let Some(last) = out.last_mut() {
            last.condition = condition;
        }
        sound.then_some(out)
    }

    fn matched(
        &mut self,
        link: &ast::Link,
        joined_to: Option<usize>,
        chained: bool,
        cx: &mut Context,
    ) -> Option<ir::Matched> {
        let kind = link.kind.as_ref();
        let word = kind.map_or("part", |k| k.text.as_str());
        let other = match word {
            "step" => Some((ir::Matched::Step, Ty::Step)),
            "joint" => Some((ir::Matched::Joint, Ty::Joint)),
            "port" => {
                let of = link.owner.as_ref().and_then(|owner| self.local_part(owner, cx));
                Some((ir::Matched::Port { of }, Ty::Port))
            }
            _ => None,
        };
        let stray = match (&other, &link.port, &link.owner) {
            (Some(_), Some(port), _) => Some((port.span, format!("a {word} has no ports"))),
            (Some(_), _, Some(owner)) if word != "port" => {
                Some((owner.span, format!("a {word} belongs to no part")))
            }
            (None, _, Some(owner)) => Some((owner.span, "only a port belongs to a part".to_owned())),
            (Some(_), ..) if chained => Some((link.name.span, format!("a {word} cannot be joined to parts"))),
            _ => None,
        };
        if let Some((span, message)) = stray {
            self.report(
                Diagnostic::new(Code::WRONG_TYPE, span, message).label("not possible").help("match a part"),
            );
            self.expressions.bind(&link.name, Ty::Unknown, cx);
            return None;
        }
        if let Some((matched, ty)) = other {
            self.expressions.bind(&link.name, ty, cx);
            return Some(matched);
        }
        let group = match kind {
            Some(kind) => self.group_named(kind, cx),
            None => Some(Group::Part),
        };
        let ty =
            group.as_ref().map_or(Ty::Unknown, |group| self.expressions.member_of(group, link.name.span));
        self.expressions.bind(&link.name, ty, cx);
        if let Some(Group::Kind(kind)) = &group {
            self.expressions.matched.insert(link.name.span, kind.clone());
        }
        if let Some(port) = &link.port {
            self.expressions.bind(port, Ty::Port, cx);
        }
        Some(ir::Matched::Part { kind: group?, port: link.port.is_some(), joined_to })
    }

    /// The slot of a part that was matched before.
    fn local_part(&mut self, owner: &Name, cx: &Context) -> Option<usize> {
        let slot = cx.locals.iter().position(|l| l.name == owner.text);
        let local = slot.and_then(|s| cx.locals.get(s));
        let fits = local.is_some_and(|l| l.ty.fits(&Ty::Part));
        self.expressions.read.extend(local.map(|l| l.span));
        if !fits && !cx.damaged {
            let parts = cx.locals.iter().filter(|l| l.ty.fits(&Ty::Part)).map(|l| l.name.as_str());
            self.report(
                Diagnostic::new(
                    Code::UNKNOWN_NAME,
                    owner.span,
                    format!("`{}` is not a part that this rule has matched", owner.text),
                )
                .label("not matched before")
                .help(did_you_mean(&owner.text, parts).unwrap_or_else(|| {
                    let name = Some(owner.text.as_str()).filter(|name| *name != "core");
                    let core = if name.is_none() { " where p is core" } else { "" };
                    let name = name.unwrap_or("p");
                    format!("match the part before it: `match {name} : part{core}`")
                })),
            );
            return None;
        }
        slot
    }

    fn set(&mut self, target: &ast::Expr, value: &ast::Expr, cx: &mut Context) -> Option<ir::Effect> {
        let ast::ExprKind::Member(of, attribute) = &target.kind else {
            return self.set_of_body(target, value, cx);
        };
        let whole = self.expressions.infer(target, cx);
        if whole.ty == Ty::Port {
            self.report(
                Diagnostic::new(Code::WRONG_TYPE, target.span, "a port cannot be set")
                    .label("read only")
                    .help("write for example `set p.turn = 90 deg`"),
            );
            return None;
        }
        let settable = match whole.kind {
            ExprKind::Attribute(_, Attribute::Part(PartAttribute::Turn)) => Settable::Turn,
            ExprKind::Attribute(_, Attribute::Param(name)) => Settable::Param(name),
            ExprKind::Attribute(..) => {
                let message = format!("`{}` follows from the design and cannot be set", attribute.text);
                let error = Diagnostic::new(Code::WRONG_TYPE, attribute.span, message);
                self.report(error.label("read only"));
                return None;
            }
            // Or something of which nothing is known, as what is wrong with it has been said.
            _ => Settable::Param(attribute.text.clone()),
        };
        let part = self.expressions.infer(of, cx);
        let value = self.expressions.expect(value, cx, &whole.ty, &format!("`{}`", attribute.text));
        self.check_set_domain(of, &attribute.text, &value, cx);
        Some(ir::Effect::Set { part, attribute: settable, value })
    }

    /// What sets a parameter of the grammar, for this body.
    fn set_of_body(&mut self, target: &ast::Expr, value: &ast::Expr, cx: &mut Context) -> Option<ir::Effect> {
        let known = self.expressions.errors.len();
        let name = match &target.kind {
            ast::ExprKind::Name(name) if cx.locals.iter().all(|local| local.name != *name) => Some(name),
            _ => None,
        };
        // That it is set does not count as reading it.
        let found = name.and_then(|name| Some((name, self.environment.program.lookup(target.span, name)?)));
        if let (Some(name), None) = (name, found) {
            self.expressions.name(name, target.span, cx);
            // What has a meaning of its own cannot be set, either.
            if cx.damaged || self.expressions.errors.len() > known {
                return None;
            }
        }
        let Some((name, declaration)) = found
            .filter(|(_, (_, item))| matches!(item.kind, ast::ItemKind::Param(_)))
            .map(|(n, (d, _))| (n, d))
        else {
            self.report(
                Diagnostic::new(
                    Code::WRONG_TYPE,
                    target.span,
                    "only an attribute of a part, or a parameter of the grammar, can be set",
                )
                .label("neither of them")
                .help("write for example `set p.turn = 90 deg`, or declare `param NAME : TYPE in DOMAIN = VALUE` for the whole body"),
            );
            return None;
        };
        let Some(param) = self.expressions.param(declaration) else {
            // What is wrong with it has been told.
            return Some(ir::Effect::SetOfBody {
                name: name.clone(),
                value: self.expressions.infer(value, cx),
            });
        };
        let value = self.expressions.expect(value, cx, &param.ty, &format!("`{name}`"));
        if let (Some((low, high)), Some(x)) = (param.domain, self.expressions.quiet_number(&value))
            && !(low..=high).contains(&x)
        {
            let shown = |x: f64| units::shown(x, param.ty.dimension().unwrap_or_default());
            self.report(
                Diagnostic::new(Code::OUT_OF_DOMAIN, value.span, format!("`{name}` is outside its domain"))
                    .label(format!("{} is not within {} .. {}", shown(x), shown(low), shown(high)))
                    .help("choose a value inside, or widen the domain")
                    .also(param.span, "declared here"),
            );
        }
        Some(ir::Effect::SetOfBody { name: name.clone(), value })
    }

    /// Where it is known which kind a part is, what its parameter is set to must lie in the domain: where the kind was matched, or
    /// no other has such a parameter.
    fn check_set_domain(&mut self, of: &ast::Expr, name: &str, value: &Expr, cx: &Context) {
        let local = match &of.kind {
            ast::ExprKind::Name(part) => cx.locals.iter().rfind(|local| local.name == *part),
            _ => None,
        };
        let kind = local.and_then(|local| self.expressions.matched.get(&local.span));
        let declared = kind.and_then(|kind| self.environment.program.lookup(of.span, kind));
        let alone = match self.environment.param_owners.get(name).map(Vec::as_slice) {
            Some([only]) => Some(*only),
            _ => None,
        };
        if let Some(owner) = declared.map(|(_, item)| item).or(alone) {
            self.expressions.check_instance_domain(owner, name, value);
        }
    }
}

/// The name that a clause of a rule binds for no other reason than to be read.
pub(super) fn bound_by(clause: &RuleClauseKind) -> Option<&Name> {
    match clause {
        RuleClauseKind::Choose(name, ..) | RuleClauseKind::Let(name, _) => Some(name),
        _ => None,
    }
}

/// The same of clauses and of the blocks among them.
fn bound_within(clauses: &[RuleClause]) -> Vec<&Name> {
    let names = clauses.iter().flat_map(|clause| match &clause.kind {
        RuleClauseKind::Repeat { clauses, .. } => bound_within(clauses),
        kind => bound_by(kind).into_iter().collect(),
    });
    names.collect()
}

/// Whether a rule is never drawn, but carried out after `begin` and after each step.
pub(in crate::types) fn is_always(clauses: &[RuleClause]) -> bool {
    clauses.iter().any(|clause| matches!(clause.kind, RuleClauseKind::Always))
}

/// Which clauses of a rule give a name to a value that reads what lines above them make, or stand below `then`; of a rule that is
/// carried out always, all that do.
fn late_values(clauses: &[RuleClause]) -> Vec<usize> {
    let mut made: Vec<&str> = Vec::new();
    let mut late = Vec::new();
    let mut after_others = is_always(clauses);
    for (place, clause) in clauses.iter().enumerate() {
        after_others |= matches!(clause.kind, RuleClauseKind::Then);
        if let RuleClauseKind::Let(name, value) = &clause.kind {
            let mut reads = after_others;
            value.each_name(&mut |read, _| reads |= made.contains(&read));
            if reads {
                late.push(place);
                made.push(&name.text);
            }
        } else {
            made.extend(products_of(from_ref(clause)).into_iter().map(|name| name.text.as_str()));
        }
    }
    late
}

/// What the clauses of a rule call each part that they make, in the order of the text.
pub(super) fn makers_of(clauses: &[RuleClause]) -> Vec<Option<&Name>> {
    let named = clauses.iter().flat_map(|clause| match &clause.kind {
        RuleClauseKind::Attach { product, .. } | RuleClauseKind::Replace { product, .. } => {
            vec![product.as_ref()]
        }
        RuleClauseKind::Repeat { clauses, .. } => makers_of(clauses),
        _ => Vec::new(),
    });
    named.collect()
}

/// What the clauses of a rule call the parts that they make.
fn products_of(clauses: &[RuleClause]) -> Vec<&Name> {
    makers_of(clauses).into_iter().flatten().collect()
}

/// How many of the first `bound` locals must have a value before an expression has one.
fn highest_local(expr: &Expr, bound: usize) -> usize {
    let mut needs = 0;
    expr.any(&mut |e| {
        if let ExprKind::Local(slot) = e.kind
            && slot < bound
        {
            needs = needs.max(slot + 1);
        }
        false
    });
    needs
}
