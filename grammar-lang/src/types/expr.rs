//! Checks expressions: names, stages, types and dimensions.

use indexmap::IndexMap;

use super::{Checker, signature};
use crate::diagnostics::{Code, Diagnostic, did_you_mean, respell};
use crate::eval::Value;
use crate::ir::{Binder, Expr, ExprKind, Function, Gather, Group, Operator, Ty, Word};
use crate::source::Span;
use crate::syntax::ast;
use crate::syntax::ast::{ItemKind, Name};
use crate::types::stage::{Stage, stages_of};
use crate::units::{self, Dimension, UnitError};

/// A name that only part of a declaration can read.
#[derive(Clone, Debug)]
pub(super) struct Local {
    pub(super) name: String,
    pub(super) ty: Ty,
    pub(super) span: Span,
}

/// Where an expression stands.
#[derive(Clone, Debug)]
pub(super) struct Context {
    /// When it is evaluated.
    pub(super) stage: Stage,
    /// Names by slot.
    pub(super) locals: Vec<Local>,
    /// Whether clauses around it were lost, so that unknown names mean nothing.
    pub(super) damaged: bool,
}

impl Context {
    pub(super) fn new(stage: Stage, damaged: bool) -> Self {
        Self { stage, locals: Vec::new(), damaged }
    }
}

pub(super) fn unknown(span: Span) -> Expr {
    Expr { kind: ExprKind::Bool(false), ty: Ty::Unknown, span }
}

fn is_zero(expr: &Expr) -> bool {
    matches!(expr.kind, ExprKind::Number(x) if x == 0.0) && expr.ty == Ty::Count
}

/// A number that was written without a unit.
fn bare_number(expr: &Expr) -> Option<f64> {
    match &expr.kind {
        ExprKind::Number(x) if expr.ty.dimension().is_some_and(Dimension::is_number) => Some(*x),
        ExprKind::Negate(inner) => bare_number(inner).map(|x| -x),
        _ => None,
    }
}

impl Checker<'_> {
    pub(super) fn report(&mut self, diagnostic: Diagnostic) {
        self.errors.add(diagnostic);
    }

    /// Checks an expression that must have a type; says `what` it is for.
    pub(super) fn expect(&mut self, tree: &ast::Expr, cx: &mut Context, wanted: &Ty, what: &str) -> Expr {
        let expr = self.infer(tree, cx);
        self.fit(expr, wanted, what)
    }

    /// Makes an expression fit a type, or reports why it does not.
    pub(super) fn fit(&mut self, mut expr: Expr, wanted: &Ty, what: &str) -> Expr {
        if expr.ty.fits(wanted) {
            return expr;
        }
        if *wanted == Ty::Group
            && let Some(group) = as_group(&expr)
        {
            return group;
        }
        if let (Ty::Domain(inner), ExprKind::Range(low, high)) = (wanted, &expr.kind) {
            let (known, have) = (self.errors.len(), low.ty.clone());
            let low = self.fit((**low).clone(), inner, what);
            // Both ends in a unit of the same wrong kind are one mistake.
            let told = self.errors.len() > known && high.ty == have && bare_number(high).is_none();
            let high = if told { unknown(high.span) } else { self.fit((**high).clone(), inner, what) };
            let ok = low.ty != Ty::Unknown && high.ty != Ty::Unknown;
            expr.kind = ExprKind::Range(Box::new(low), Box::new(high));
            expr.ty = if ok { wanted.clone() } else { Ty::Unknown };
            return expr;
        }
        if let (Some(dimension), true) = (wanted.dimension(), is_zero(&expr)) {
            expr.ty = Ty::Quantity(dimension);
            return expr;
        }
        let fix =
            wanted.dimension().filter(|_| *wanted != Ty::Count).and_then(|want| match bare_number(&expr) {
                Some(x) => self.missing_unit(&expr, x, want, None),
                None => self.mended_quantity(&expr, want),
            });
        self.report(mismatch(&expr, wanted, what).fix_if(fix));
        expr.ty = Ty::Unknown;
        expr
    }

    /// Makes two operands have one type; `None` if they cannot (reported).
    pub(super) fn unify(&mut self, mut a: Expr, mut b: Expr, what: &str) -> Option<(Expr, Expr, Ty)> {
        if let (true, Ty::Quantity(d)) = (is_zero(&a), &b.ty) {
            a.ty = Ty::Quantity(*d);
        } else if let (true, Ty::Quantity(d)) = (is_zero(&b), &a.ty) {
            b.ty = Ty::Quantity(*d);
        }
        if let Some(ty) = a.ty.common(&b.ty) {
            return Some((a, b, ty));
        }
        let numbers = (a.ty.dimension(), b.ty.dimension());
        let bare = match numbers {
            (Some(_), Some(want)) if bare_number(&a).is_some() => Some((&a, &b, want)),
            (Some(want), Some(_)) if bare_number(&b).is_some() => Some((&b, &a, want)),
            _ => None,
        };
        let error = match bare {
            Some((number, other, want)) if !want.is_number() => {
                let x = bare_number(number).unwrap_or_default();
                Diagnostic::new(
                    Code::MISSING_UNIT,
                    number.span,
                    format!("this number needs a unit: {what} joins it with {}", article(&other.ty)),
                )
                .label("without a unit")
                .also(other.span, article(&other.ty))
                .help(match self.unit_beside(want, Some(other)) {
                    Some(unit) => format!("write `{x} {unit}`"),
                    None => format!("write `{x} {}`", units::suggest(want)),
                })
                .fix_if(self.missing_unit(number, x, want, Some(other)))
            }
            _ => {
                let code = if numbers.0.is_some() && numbers.1.is_some() {
                    Code::WRONG_DIMENSION
                } else {
                    Code::WRONG_TYPE
                };
                Diagnostic::new(
                    code,
                    b.span,
                    format!("{what} joins {} and {}", article(&a.ty), article(&b.ty)),
                )
                .label(article(&b.ty))
                .also(a.span, article(&a.ty))
                .help(unlike(&a.ty, &b.ty))
            }
        };
        self.report(error);
        None
    }

    /// Reads a unit.
    pub(super) fn unit(&mut self, unit: &Name) -> Option<units::Unit> {
        match units::parse(&unit.text) {
            Ok(unit) => Some(unit),
            Err(UnitError::Unknown(word)) => {
                let meant = super::mend::unit_meant(&word).map(|m| format!("did you mean `{m}`?"));
                let help = meant.or_else(|| did_you_mean(&word, units::unit_names())).unwrap_or_else(|| {
                    if unit.text.contains('*') || unit.text.contains('/') {
                        "to calculate with a name, put spaces around `*` and `/`".to_owned()
                    } else {
                        format!("units are: {}", units::unit_names().collect::<Vec<_>>().join(", "))
                    }
                });
                self.report(
                    Diagnostic::new(Code::UNKNOWN_UNIT, unit.span, format!("unknown unit `{word}`"))
                        .label("no unit of this name")
                        .help(help)
                        .fix_if(self.mended_unit(unit, &word)),
                );
                None
            }
            Err(UnitError::TooHigh) => {
                self.report(
                    Diagnostic::new(
                        Code::UNKNOWN_UNIT,
                        unit.span,
                        "the exponents of this unit are too large",
                    )
                    .label("no quantity has such a unit"),
                );
                None
            }
        }
    }

    /// Finds the type of an expression; every error in it is reported once.
    pub(super) fn infer(&mut self, tree: &ast::Expr, cx: &mut Context) -> Expr {
        let known = self.errors.len();
        let whole = !std::mem::replace(&mut self.inside, true);
        let expr = self.infer_piece(tree, cx);
        if whole {
            self.inside = false;
            self.tell_stage_once(known);
        }
        expr
    }

    /// An expression of the wrong stage often reads several things that are not known there.
    /// That is one mistake: the first of them is told.
    fn tell_stage_once(&mut self, known: usize) {
        let found = self.errors.split_off(known.min(self.errors.len()));
        let mut told = false;
        for finding in found {
            if finding.code != Code::WRONG_STAGE || !std::mem::replace(&mut told, true) {
                self.errors.add(finding);
            }
        }
    }

    fn infer_piece(&mut self, tree: &ast::Expr, cx: &mut Context) -> Expr {
        let span = tree.span;
        let make = |kind, ty| Expr { kind, ty, span };
        match &tree.kind {
            ast::ExprKind::Quantity(value, None) => {
                // `1.0` is a number, `1` a count.
                let written = self.sources.slice(span);
                let whole = value.fract() == 0.0 && value.abs() < 1e15 && !written.contains(['.', 'e', 'E']);
                make(ExprKind::Number(*value), if whole { Ty::Count } else { Ty::NUMBER })
            }
            ast::ExprKind::Quantity(value, Some(unit)) => match self.unit(unit) {
                Some(unit) => {
                    let si = value * unit.factor;
                    if !si.is_finite() {
                        self.report(
                            Diagnostic::new(Code::BAD_NUMBER, span, "this number is too large")
                                .label("in SI units"),
                        );
                        return unknown(span);
                    }
                    make(ExprKind::Number(si), Ty::Quantity(unit.dimension))
                }
                None => unknown(span),
            },
            ast::ExprKind::Text(text) => make(ExprKind::Text(text.clone()), Ty::Text),
            ast::ExprKind::Bool(value) => make(ExprKind::Bool(*value), Ty::Bool),
            ast::ExprKind::Name(name) => self.name(name, span, cx),
            ast::ExprKind::Member(of, name) => self.member(of, name, span, cx),
            ast::ExprKind::Cases(value, arms, otherwise) => {
                self.cases(value, arms, otherwise.as_deref(), span, cx)
            }
            ast::ExprKind::Narrowed(new, old) => self.narrowed(new, old, cx),
            ast::ExprKind::Exchanged(new, old) => self.exchanged(new, old, cx),
            ast::ExprKind::Call(callee, arguments) => self.call(callee, arguments, span, cx),
            ast::ExprKind::Index(list, index) => {
                let list = self.infer(list, cx);
                if let ExprKind::Port(of, name, None) = list.kind {
                    let index = self.expect(index, cx, &Ty::Count, "the number of a port");
                    return make(ExprKind::Port(of, name, Some(Box::new(index))), Ty::Port);
                }
                let index = self.expect(index, cx, &Ty::Count, "an index");
                match list.ty.clone() {
                    Ty::List(item) => make(ExprKind::Index(Box::new(list), Box::new(index)), *item),
                    Ty::Unknown => unknown(span),
                    other => self.wrong(
                        list.span,
                        format!("{} has no items", article(&other)),
                        "only a list has items",
                    ),
                }
            }
            ast::ExprKind::At(value, time) => {
                let value = self.infer(value, cx);
                let time = self.expect(time, cx, &Ty::Quantity(Dimension::TIME), "what follows `at`");
                match value.ty.clone() {
                    Ty::Track(ty) => make(ExprKind::At(Box::new(value), Box::new(time)), *ty),
                    Ty::Unknown => unknown(span),
                    other => self.wrong(
                        value.span,
                        format!("{} does not change over the motion", article(&other)),
                        "`at` asks for the position or rotation of an element at a time",
                    ),
                }
            }
            ast::ExprKind::Negate(value) => {
                let value = self.infer(value, cx);
                match &value.ty {
                    Ty::Quantity(_) | Ty::Count | Ty::Vector(_) => {
                        let ty = value.ty.clone();
                        make(ExprKind::Negate(Box::new(value)), ty)
                    }
                    Ty::Unknown => unknown(span),
                    other => {
                        self.wrong(span, format!("{} has no negative", article(other)), "`-` needs a number")
                    }
                }
            }
            ast::ExprKind::Not(value) => {
                let value = self.expect(value, cx, &Ty::Bool, "what follows `not`");
                make(ExprKind::Not(Box::new(value)), Ty::Bool)
            }
            ast::ExprKind::Binary(a, operator, b) => self.binary(a, *operator, b, span, cx),
            ast::ExprKind::If(condition, yes, no) => {
                let condition = self.expect(condition, cx, &Ty::Bool, "what follows `if`");
                let (yes, no) = (self.infer(yes, cx), self.infer(no, cx));
                match self.unify(yes, no, "`if`") {
                    Some((yes, no, ty)) => {
                        make(ExprKind::If(Box::new(condition), Box::new(yes), Box::new(no)), ty)
                    }
                    None => unknown(span),
                }
            }
            ast::ExprKind::Aggregate { .. } => self.aggregate(tree, cx),
            ast::ExprKind::Range(low, high) => {
                let (low, high) = (self.infer(low, cx), self.infer(high, cx));
                let Some((low, high, ty)) = self.unify(low, high, "this range") else { return unknown(span) };
                if ty != Ty::Unknown && ty.dimension().is_none() {
                    return self.wrong(
                        span,
                        format!("a range cannot go from {ty} to {ty}"),
                        "a range needs two numbers",
                    );
                }
                self.check_order(&low, &high, span);
                make(ExprKind::Range(Box::new(low), Box::new(high)), Ty::Domain(Box::new(ty)))
            }
            ast::ExprKind::Set(items) | ast::ExprKind::List(items) => {
                let set = matches!(tree.kind, ast::ExprKind::Set(_));
                let Some((items, ty)) = self.items(items, span, cx, set) else { return unknown(span) };
                if set {
                    make(ExprKind::Set(items), Ty::Domain(Box::new(ty)))
                } else {
                    make(ExprKind::List(items), Ty::List(Box::new(ty)))
                }
            }
            ast::ExprKind::Convert(value, unit) => {
                let value = self.infer(value, cx);
                let place = unit;
                let Some(unit) = self.unit(unit) else { return unknown(span) };
                if let Some(other) = value.ty.dimension().filter(|d| *d != unit.dimension && !d.is_number()) {
                    self.report(other_unit(&value, other, place));
                    return unknown(span);
                }
                let value = self.fit(value, &Ty::Quantity(unit.dimension), "what is turned into a number");
                make(ExprKind::Convert(Box::new(value), unit.factor), Ty::NUMBER)
            }
        }
    }

    fn wrong(&mut self, span: Span, message: String, help: &str) -> Expr {
        self.report(Diagnostic::new(Code::WRONG_TYPE, span, message).label("not possible").help(help));
        unknown(span)
    }

    /// A range whose ends are known must go upwards.
    fn check_order(&mut self, low: &Expr, high: &Expr, span: Span) {
        let known = |e: &Expr| {
            !e.any(&mut |e| {
                matches!(
                    e.kind,
                    ExprKind::Local(_) | ExprKind::Group(_) | ExprKind::Word(_) | ExprKind::Bind { .. }
                )
            })
        };
        if !known(low) || !known(high) || low.ty == Ty::Unknown || high.ty == Ty::Unknown {
            return;
        }
        let (Some(a), Some(b)) = (self.quiet_number(low), self.quiet_number(high)) else { return };
        if a > b {
            self.report(
                Diagnostic::new(Code::EMPTY_DOMAIN, span, "this range is inverted: it holds no value")
                    .label("the first end is above the second")
                    .help("write the smaller end first")
                    .fix_if(self.swapped(low.span, high.span)),
            );
        }
    }

    fn items(
        &mut self,
        items: &[ast::Expr],
        span: Span,
        cx: &mut Context,
        set: bool,
    ) -> Option<(Vec<Expr>, Ty)> {
        let mut ty = Ty::Unknown;
        let mut checked: Vec<Expr> = Vec::new();
        for item in items {
            let item = self.infer(item, cx);
            match checked.first().cloned() {
                Some(first) => {
                    let first = Expr { ty: ty.clone(), ..first };
                    let (_, item, common) =
                        self.unify(first, item, if set { "this set" } else { "this list" })?;
                    ty = common;
                    checked.push(item);
                }
                None => {
                    ty = item.ty.clone();
                    checked.push(item);
                }
            }
        }
        if checked.is_empty() {
            self.report(
                Diagnostic::new(Code::EMPTY_DOMAIN, span, "there is nothing in here")
                    .label("empty")
                    .help("name at least one value"),
            );
            return None;
        }
        Some((checked, ty))
    }

    fn name(&mut self, name: &str, span: Span, cx: &mut Context) -> Expr {
        let make = |kind, ty| Expr { kind, ty, span };
        if let Some(slot) = cx.locals.iter().rposition(|l| l.name == name) {
            let local = cx.locals.get(slot);
            self.read.extend(local.map(|l| l.span));
            return make(ExprKind::Local(slot), local.map_or(Ty::Unknown, |l| l.ty.clone()));
        }
        let declared = self.program.lookup(span, name).is_some();
        if let Some(word) = Word::named(name).filter(|w| !declared || cx.stage.sees_word(*w)) {
            if cx.stage.sees_word(word) {
                return make(ExprKind::Word(word), signature::word(word));
            }
            let places: Vec<&str> = stages_of(word).unwrap_or(&[]).iter().map(|s| s.name()).collect();
            return self.stage_error(span, name, cx.stage, &one_of(&places));
        }
        if let Some(group) = match name {
            "part" => Some(Group::Part),
            "block" => Some(Group::Block),
            "actuator" => Some(Group::Actuator),
            _ => None,
        } {
            if !cx.stage.sees_design() {
                return self.stage_error(span, name, cx.stage, "rules, requirements and terms");
            }
            return make(ExprKind::Group(group), Ty::Group);
        }
        if let Some((_, what)) = self.placed.iter().find(|(p, _)| p == name) {
            let kind = match &what.kind {
                ast::ExprKind::Call(callee, _) => &callee.kind,
                kind => kind,
            };
            let active = matches!(kind, ast::ExprKind::Name(kind) if self.is_actuator(kind, what.span));
            if !cx.stage.sees_design() {
                return self.stage_error(span, name, cx.stage, "rules and requirements");
            }
            let ty = if active { Ty::Actuator } else { Ty::Part };
            return make(ExprKind::Placed(name.to_owned()), ty);
        }
        let program = self.program;
        let Some((declaration, item)) = program.lookup(span, name) else {
            return self.unknown_name(name, span, cx);
        };
        self.touched.insert(declaration);
        let what = match &item.kind {
            ItemKind::Param(_) => {
                let ty = self.param(declaration).map_or(Ty::Unknown, |p| p.ty);
                return make(ExprKind::Param(name.to_owned()), ty);
            }
            ItemKind::Part(_) | ItemKind::Actuator(_) => {
                return make(ExprKind::Kind(name.to_owned(), Vec::new()), Ty::Kind);
            }
            ItemKind::Pattern(..) => return make(ExprKind::Pattern(name.to_owned()), Ty::Pattern),
            ItemKind::Term(_, ty, _) => {
                if !cx.stage.sees_motion() {
                    return self.stage_error(span, name, cx.stage, "terms and objectives");
                }
                let ty = self.type_named(ty);
                return make(ExprKind::Term(name.to_owned()), ty);
            }
            ItemKind::Let(_, None, value) => {
                let value = self.inline(declaration, value);
                return Expr { span, ..value };
            }
            ItemKind::Let(_, Some(parameters), _) => {
                let words: Vec<&str> = parameters.iter().map(|p| p.name.text.as_str()).collect();
                let help = format!("call it: `{name}({})`", words.join(", "));
                return self.wrong(span, format!("`{name}` is a function, not a value"), &help);
            }
            ItemKind::Enum(_, values) => {
                let ty = Ty::Enum(name.to_owned());
                let all = (0..values.len())
                    .map(|i| Expr { kind: ExprKind::Number(i as f64), ty: ty.clone(), span })
                    .collect();
                return make(ExprKind::Set(all), Ty::Domain(Box::new(ty)));
            }
            ItemKind::Task(..) => {
                return self.wrong(
                    span,
                    format!("`{name}` is a task, not a value"),
                    &format!("ask for its value: `{name}.value`"),
                );
            }
            ItemKind::Record(..) => "a record",
            ItemKind::Example(..) => "an example",
            ItemKind::Prefer { .. } => "a preference",
            ItemKind::Rule(..) => "a rule",
            ItemKind::Model(_) => "a model",
            ItemKind::Search(_) => "a search",
            ItemKind::Actuation { .. } => "an actuation",
            _ => "a requirement",
        };
        self.wrong(span, format!("`{name}` is {what}, not a value"), "only values can be calculated with")
    }

    pub(super) fn stage_error(&mut self, span: Span, name: &str, stage: Stage, where_known: &str) -> Expr {
        self.report(
            Diagnostic::new(Code::WRONG_STAGE, span, format!("`{name}` cannot be read in {}", stage.name()))
                .label("not known yet, or not any more")
                .help(format!("`{name}` is known only in {where_known}")),
        );
        unknown(span)
    }

    /// Parts of a kind are asked for where there is no design.
    pub(super) fn parts_unknown(&mut self, kind: Span, stage: Stage) -> Expr {
        let name = self.sources.slice(kind).to_owned();
        self.stage_error(kind, &name, stage, "rules, requirements and terms, as the parts of a design")
    }

    fn unknown_name(&mut self, name: &str, span: Span, cx: &Context) -> Expr {
        if cx.damaged || self.is_lost(span, name) {
            return unknown(span);
        }
        if self.report_dropped(span, name) {
            return unknown(span);
        }
        let mut fix = None;
        let help = if units::parse(name).is_ok() {
            format!("`{name}` is a unit: write a number before it")
        } else if Function::named(name).is_some() {
            format!(
                "`{name}` is a function: call it as `{}`",
                Function::named(name).map_or("", |f| signature::usage(f).0)
            )
        } else {
            let candidates = cx
                .locals
                .iter()
                .map(|l| l.name.as_str())
                // What an effect made without a name has none to guess at.
                .filter(|name| !name.is_empty())
                .chain(Word::ALL.iter().filter(|w| cx.stage.sees_word(**w)).map(|w| w.text()))
                .chain(self.guessable(span).map(|(n, _)| n))
                .chain(self.placed.iter().map(|(p, _)| p.as_str()))
                .chain(["part", "block", "actuator"]);
            let candidates: Vec<&str> = candidates.collect();
            fix = respell(span, name, candidates.iter().copied());
            did_you_mean(name, candidates).unwrap_or_else(|| not_declared(name, cx))
        };
        self.report(
            Diagnostic::new(Code::UNKNOWN_NAME, span, format!("unknown name `{name}`"))
                .label("not declared")
                .help(help)
                .fix_if(fix),
        );
        unknown(span)
    }

    /// Whether an unknown name is the echo of another error.
    pub(super) fn is_lost(&self, place: Span, name: &str) -> bool {
        self.program.is_lost(self.program.module_at(place), name)
    }

    /// Reports a name that a variant drops; false if it does not.
    pub(super) fn report_dropped(&mut self, span: Span, name: &str) -> bool {
        let Some(place) = self.program.dropped_at(span, name) else { return false };
        self.report(
            Diagnostic::new(Code::DROPPED, span, format!("`{name}` is used, but the variant drops it"))
                .label("still used here")
                .also(place, "dropped here")
                .help("drop or replace this, too"),
        );
        true
    }

    /// Names that are followed by a dot but are no values: enumerations, tasks, actuations.
    fn qualified(&mut self, of: &ast::Expr, name: &Name, span: Span, cx: &Context) -> Option<Expr> {
        let ast::ExprKind::Name(head) = &of.kind else { return None };
        if cx.locals.iter().any(|l| l.name == *head) {
            return None;
        }
        let program = self.program;
        let (declaration, item) = program.lookup(of.span, head)?;
        let (offers, what): (Vec<&str>, &str) = match &item.kind {
            ItemKind::Enum(_, values) => {
                self.touched.insert(declaration);
                if let Some(index) = values.iter().position(|v| v.text == name.text) {
                    let kind = ExprKind::Number(index as f64);
                    return Some(Expr { kind, ty: Ty::Enum(head.clone()), span });
                }
                (values.iter().map(|v| v.text.as_str()).collect(), "value")
            }
            ItemKind::Task(..) => {
                self.touched.insert(declaration);
                if cx.stage != Stage::Outcome {
                    return Some(self.stage_error(
                        of.span,
                        head,
                        cx.stage,
                        "the objective of the whole grammar",
                    ));
                }
                if name.text == "value" {
                    return Some(Expr { kind: ExprKind::Task(head.clone()), ty: Ty::NUMBER, span });
                }
                (vec!["value"], "attribute")
            }
            ItemKind::Actuation { clauses, .. } => {
                self.touched.insert(declaration);
                if !cx.stage.sees_motion() {
                    return Some(self.stage_error(of.span, head, cx.stage, "terms and objectives"));
                }
                let shared = clauses.iter().filter_map(|c| match c {
                    ast::ActuationClause::Variable(v) if v.shared => Some(&**v),
                    _ => None,
                });
                let shared: Vec<&ast::Variable> = shared.collect();
                if let Some(variable) = shared.iter().find(|v| v.name.text == name.text) {
                    let ty = self.type_named(&variable.ty);
                    let ty = if variable.size.is_some() { Ty::List(Box::new(ty)) } else { ty };
                    return Some(Expr { kind: ExprKind::Shared(head.clone(), name.text.clone()), ty, span });
                }
                (shared.iter().map(|v| v.name.text.as_str()).collect(), "shared variable")
            }
            _ => return None,
        };
        let help = did_you_mean(&name.text, offers.iter().copied())
            .unwrap_or_else(|| format!("it has: {}", offers.join(", ")));
        self.report(
            Diagnostic::new(
                Code::UNKNOWN_FIELD,
                name.span,
                format!("`{head}` has no {what} `{}`", name.text),
            )
            .label("not known")
            .help(help),
        );
        Some(unknown(span))
    }

    /// A domain that a variant makes narrower must lie within the old one.
    fn narrowed(&mut self, new: &ast::Expr, old: &ast::Expr, cx: &mut Context) -> Expr {
        let span = new.span;
        let (new, old) = (self.infer(new, cx), self.infer(old, cx));
        // The base comes first: what does not fit is told where the variant says it.
        let Some((old, new, _)) = self.unify(old, new, "`narrow`") else { return unknown(span) };
        if new.any(&mut |e| e.ty == Ty::Unknown) || old.any(&mut |e| e.ty == Ty::Unknown) {
            return new;
        }
        let value = |e: &Expr| crate::eval::evaluate(e, &self.constants, &mut Vec::new()).ok();
        let wider = match (value(&new), value(&old)) {
            (Some(Value::Domain(new)), Some(Value::Domain(old))) => !old.holds_all(&new),
            _ => false,
        };
        if wider {
            self.report(
                Diagnostic::new(
                    Code::NOT_NARROWER,
                    new.span,
                    "this is not within the domain that it narrows",
                )
                .label("reaches further")
                .also(old.span, "the domain in the base")
                .help("write `set` instead of `narrow` if it is meant to reach further"),
            );
        }
        new
    }

    /// A domain that a variant puts in the place of another must hold the same kind of quantity.
    fn exchanged(&mut self, new: &ast::Expr, old: &ast::Expr, cx: &mut Context) -> Expr {
        let new = self.infer(new, cx);
        let known = self.errors.len();
        let old = self.infer(old, cx);
        // What is wrong with the old one does not matter any more.
        self.errors.split_off(known);
        let (Some(now), Some(before)) = (quantity_in(&new.ty), quantity_in(&old.ty)) else { return new };
        if now == before {
            return new;
        }
        self.report(
            Diagnostic::new(
                Code::WRONG_DIMENSION,
                new.span,
                format!(
                    "the base chooses {} here, but this holds {}",
                    article(&chosen(&old.ty, before)),
                    article(&chosen(&new.ty, now))
                ),
            )
            .label("another kind of quantity")
            .also(old.span, "the domain in the base")
            .help("what reads the choice needs the kind of quantity of the base"),
        );
        unknown(new.span)
    }

    /// A port by its name, if that is what an expression is.
    pub(super) fn port_name(&self, tree: &ast::Expr) -> Option<Expr> {
        let ast::ExprKind::Name(name) = &tree.kind else { return None };
        self.ports.contains(name).then(|| Expr {
            kind: ExprKind::PortName(name.clone()),
            ty: Ty::Port,
            span: tree.span,
        })
    }

    fn member(&mut self, of: &ast::Expr, name: &Name, span: Span, cx: &mut Context) -> Expr {
        if let Some(value) = self.qualified(of, name, span, cx) {
            return value;
        }
        let of = self.infer(of, cx);
        let make =
            |of: Expr, ty| Expr { kind: ExprKind::Attribute(Box::new(of), name.text.clone()), ty, span };
        let candidates: Vec<String> = match of.ty.clone() {
            Ty::Unknown => return unknown(span),
            ty @ (Ty::Part | Ty::Actuator | Ty::Element | Ty::Port | Ty::Joint | Ty::Step) => {
                if let Some((_, ty)) = signature::attributes(&ty).iter().find(|(n, _)| *n == name.text) {
                    return make(of, ty.clone());
                }
                if cx.stage.sees_motion() {
                    if let Some(ty) = signature::motion_attribute(&ty, &name.text) {
                        return make(of, ty);
                    }
                } else if signature::motion_attribute(&ty, &name.text).is_some() {
                    return self.stage_error(
                        name.span,
                        &name.text,
                        cx.stage,
                        "terms, as in `e.position at end` for `e in elements`",
                    );
                }
                let of_part = matches!(ty, Ty::Part | Ty::Actuator);
                if of_part && self.ports.contains(&name.text) {
                    let kind = ExprKind::Port(Box::new(of), name.text.clone(), None);
                    return Expr { kind, ty: Ty::Port, span };
                }
                let known = if of_part { Some(self.instance_params()) } else { None };
                if ty == Ty::Actuator && known.is_some_and(IndexMap::is_empty) {
                    // A module on its own does not know which actuators it will meet.
                    return unknown(span);
                }
                let param = known.and_then(|p| p.get(&name.text)).cloned();
                if ty == Ty::Actuator {
                    if let Some(ty) = param {
                        return make(of, ty);
                    }
                } else if param.is_some() {
                    return self.wrong(
                        name.span,
                        format!("only an actuator has a `{}`", name.text),
                        "match an actuator: `match a : actuator`",
                    );
                }
                let own = signature::attributes(&ty).iter().map(|(n, _)| *n);
                let moving = signature::MOTION_ATTRIBUTES
                    .iter()
                    .copied()
                    .filter(|n| cx.stage.sees_motion() && signature::motion_attribute(&ty, n).is_some());
                let ports = self.ports.iter().filter(|_| of_part).cloned();
                let params = self.instance_params.iter().flat_map(IndexMap::keys).cloned();
                let params = params.filter(|_| ty == Ty::Actuator);
                own.chain(moving).map(str::to_owned).chain(ports).chain(params).collect()
            }
            Ty::Record(_, fields) => {
                if let Some(index) = fields.iter().position(|(n, _)| *n == name.text) {
                    let ty = fields.get(index).map_or(Ty::Unknown, |(_, ty)| ty.clone());
                    let index = Expr { kind: ExprKind::Number(index as f64), ty: Ty::Count, span: name.span };
                    return Expr { kind: ExprKind::Index(Box::new(of), Box::new(index)), ty, span };
                }
                fields.iter().map(|(n, _)| n.clone()).collect()
            }
            Ty::Vector(d) => {
                if ["x", "y", "z"].contains(&name.text.as_str()) {
                    return make(of, Ty::Quantity(d));
                }
                ["x", "y", "z"].map(str::to_owned).into()
            }
            _ => Vec::new(),
        };
        let help = did_you_mean(&name.text, candidates.iter().map(String::as_str)).or_else(|| {
            (!candidates.is_empty()).then(|| format!("{} has: {}", article(&of.ty), candidates.join(", ")))
        });
        self.report(
            Diagnostic::new(
                Code::UNKNOWN_FIELD,
                name.span,
                format!("{} has no `{}`", article(&of.ty), name.text),
            )
            .label("not an attribute")
            .help_if(help)
            .fix_if(respell(name.span, &name.text, candidates.iter().map(String::as_str))),
        );
        unknown(span)
    }

    fn binary(
        &mut self,
        a: &ast::Expr,
        operator: Operator,
        b: &ast::Expr,
        span: Span,
        cx: &mut Context,
    ) -> Expr {
        use Operator as O;
        let make = |a: Expr, b: Expr, ty| Expr {
            kind: ExprKind::Binary(Box::new(a), operator, Box::new(b)),
            ty,
            span,
        };
        let symbol = format!("`{}`", operator.symbol());
        match operator {
            O::And | O::Or => {
                let a = self.expect(a, cx, &Ty::Bool, &format!("the left side of {symbol}"));
                let b = self.expect(b, cx, &Ty::Bool, &format!("the right side of {symbol}"));
                return make(a, b, Ty::Bool);
            }
            O::Adds => {
                let a = self.expect(a, cx, &Ty::Step, "the left side of `adds`");
                let b = self.expect(b, cx, &Ty::Group, "the right side of `adds`");
                return make(a, b, Ty::Bool);
            }
            O::Is | O::IsNot => {
                let a = self.infer(a, cx);
                if a.ty == Ty::Port {
                    return match self.port_name(b) {
                        Some(port) => make(a, port, Ty::Bool),
                        None => {
                            let b = self.named_port(b, cx);
                            make(a, b, Ty::Bool)
                        }
                    };
                }
                let a = self.fit(a, &Ty::Part, &format!("the left side of {symbol}"));
                let b = self.infer(b, cx);
                let b = as_group(&b).unwrap_or(b);
                if !matches!(b.ty, Ty::Group | Ty::Part | Ty::Actuator | Ty::Unknown) {
                    return self.wrong(
                        b.span,
                        format!("a part is never {}", article(&b.ty)),
                        "compare with a part or a kind of part",
                    );
                }
                return make(a, b, Ty::Bool);
            }
            _ => {}
        }
        let (a, b) = (self.infer(a, cx), self.infer(b, cx));
        if a.ty == Ty::Unknown || b.ty == Ty::Unknown {
            let ty = if matches!(operator, O::Add | O::Subtract | O::Multiply | O::Divide) {
                Ty::Unknown
            } else {
                Ty::Bool
            };
            return make(a, b, ty);
        }
        match operator {
            O::Multiply | O::Divide => {
                let Some(ty) = product(&a.ty, operator, &b.ty) else {
                    return self.wrong(
                        span,
                        format!("{symbol} cannot join a {} and a {}", a.ty, b.ty),
                        "it needs numbers",
                    );
                };
                make(a, b, ty)
            }
            _ => {
                let Some((a, b, ty)) = self.unify(a, b, &symbol) else {
                    return if matches!(operator, O::Add | O::Subtract) {
                        unknown(span)
                    } else {
                        Expr { ty: Ty::Bool, ..unknown(span) }
                    };
                };
                let numbers = ty.dimension().is_some();
                let fine = match operator {
                    O::Add => numbers || matches!(ty, Ty::Vector(_) | Ty::List(_)),
                    O::Subtract => numbers || matches!(ty, Ty::Vector(_)),
                    O::Equal | O::NotEqual => !matches!(ty, Ty::Track(_)),
                    _ => numbers,
                };
                if !fine {
                    let help = if matches!(ty, Ty::Track(_)) {
                        "ask for it at a time: `e.position at end`"
                    } else {
                        "it needs numbers"
                    };
                    return self.wrong(span, format!("{symbol} cannot join two of {ty}"), help);
                }
                let ty = if matches!(operator, O::Add | O::Subtract) { ty } else { Ty::Bool };
                make(a, b, ty)
            }
        }
    }

    /// What a port is compared with, if it is no name of a port.
    fn named_port(&mut self, tree: &ast::Expr, cx: &mut Context) -> Expr {
        if let ast::ExprKind::Name(name) = &tree.kind {
            let local = cx.locals.iter().any(|l| l.name == *name);
            if !local && self.program.lookup(tree.span, name).is_none() {
                self.unknown_port(&Name { text: name.clone(), span: tree.span });
                return unknown(tree.span);
            }
        }
        self.expect(tree, cx, &Ty::Port, "what a port is compared with")
    }

    pub(super) fn unknown_port(&mut self, name: &Name) {
        let names: Vec<&str> = self.ports.iter().map(String::as_str).collect();
        let help = did_you_mean(&name.text, names.iter().copied());
        self.report(
            Diagnostic::new(Code::UNKNOWN_NAME, name.span, format!("no part has a port `{}`", name.text))
                .label("not a port")
                .help(help.unwrap_or_else(|| format!("ports are: {}", names.join(", ")))),
        );
    }

    /// Adds a name that must not hide another.
    pub(super) fn bind(&mut self, name: &Name, ty: Ty, cx: &mut Context) {
        let taken = cx
            .locals
            .iter()
            .find(|l| l.name == name.text)
            .map(|l| Some(l.span))
            .or_else(|| {
                let (_, item) = self.program.lookup(name.span, &name.text)?;
                Some(crate::names::declared(item).map(|n| n.span))
            })
            .or_else(|| {
                // What `begin` calls its parts is the business of the grammar that does, not of
                // the modules that it imports.
                let own = self.program.own.contains(&self.program.module_at(name.span));
                let placed = self.placed.iter().find(|(p, _)| own && *p == name.text);
                let word = Word::named(&name.text).is_some_and(|w| cx.stage.sees_word(w));
                placed.map(|(_, what)| Some(what.span)).or(word.then_some(None))
            });
        if let Some(place) = taken {
            let mut error = Diagnostic::new(
                Code::DUPLICATE,
                name.span,
                format!("`{}` already means something else here", name.text),
            )
            .label("a second meaning")
            .help("choose another name: no name hides another");
            if let Some(place) = place {
                error = error.also(place, "the other meaning");
            }
            self.report(error);
        }
        cx.locals.push(Local { name: name.text.clone(), ty, span: name.span });
    }

    /// Adds a parameter of a function; that two of them share a name is told where they stand.
    pub(super) fn bind_parameter(&mut self, name: &Name, ty: Ty, cx: &mut Context) {
        if cx.locals.iter().any(|l| l.name == name.text) {
            cx.locals.push(Local { name: name.text.clone(), ty, span: name.span });
        } else {
            self.bind(name, ty, cx);
        }
    }

    fn aggregate(&mut self, tree: &ast::Expr, cx: &mut Context) -> Expr {
        let ast::ExprKind::Aggregate { how, binders, condition, body, otherwise } = &tree.kind else {
            return unknown(tree.span);
        };
        let depth = cx.locals.len();
        let mut bound = Vec::new();
        for binder in binders {
            let over = self.infer(&binder.over, cx);
            let mut over = as_group(&over).unwrap_or(over);
            if over.ty == Ty::Group && !cx.stage.sees_design() {
                over = self.parts_unknown(over.span, cx.stage);
            }
            let item = match &over.ty {
                Ty::Group => match &over.kind {
                    ExprKind::Group(Group::Actuator) => Ty::Actuator,
                    ExprKind::Group(Group::Kind(kind)) if self.is_actuator(kind, over.span) => Ty::Actuator,
                    _ => Ty::Part,
                },
                Ty::List(item) => (**item).clone(),
                Ty::Domain(item) if **item == Ty::Count => Ty::Count,
                Ty::Domain(item) if matches!(over.kind, ExprKind::Set(_)) => (**item).clone(),
                Ty::Unknown => Ty::Unknown,
                other => {
                    let message = format!("{} is nothing to run over", article(other));
                    self.wrong(
                        over.span,
                        message,
                        "run over `part`, `actuator`, `elements`, a list or a range of whole numbers",
                    )
                    .ty
                }
            };
            let slot = cx.locals.len();
            self.bind(&binder.name, item, cx);
            bound.push(Binder { slot, over });
        }
        let condition =
            condition.as_ref().map(|c| Box::new(self.expect(c, cx, &Ty::Bool, "what follows `where`")));
        let body = body.as_ref().map(|b| match how {
            Gather::Forall | Gather::Exists => self.expect(b, cx, &Ty::Bool, "what follows `:`"),
            _ => self.infer(b, cx),
        });
        cx.locals.truncate(depth);
        let otherwise = otherwise.as_ref().map(|o| self.infer(o, cx));
        let ty = match (how, &body) {
            (Gather::Count, _) => Ty::Count,
            (Gather::Forall | Gather::Exists, _) => Ty::Bool,
            (_, None) => Ty::Unknown,
            (_, Some(body)) => match &body.ty {
                Ty::Count if *how == Gather::Mean => Ty::NUMBER,
                ty @ (Ty::Quantity(_) | Ty::Count | Ty::Unknown) => ty.clone(),
                other => {
                    self.wrong(
                        body.span,
                        format!("{} cannot be gathered", article(other)),
                        "gather numbers, as in `of p.mass`",
                    )
                    .ty
                }
            },
        };
        let otherwise = otherwise.map(|o| Box::new(self.fit(o, &ty, "what follows `otherwise`")));
        let kind =
            ExprKind::Aggregate { how: *how, binders: bound, condition, body: body.map(Box::new), otherwise };
        Expr { kind, ty, span: tree.span }
    }
}

/// What a domain of quantities holds.
fn quantity_in(domain: &Ty) -> Option<Dimension> {
    match domain {
        Ty::Domain(item) | Ty::List(item) => item.dimension(),
        _ => None,
    }
}

/// What is chosen from a domain of quantities, as people call it.
fn chosen(domain: &Ty, dimension: Dimension) -> Ty {
    match domain {
        Ty::Domain(item) | Ty::List(item) => (**item).clone(),
        _ => Ty::Quantity(dimension),
    }
}

/// A kind of part used as the collection of its parts.
pub(super) fn as_group(expr: &Expr) -> Option<Expr> {
    match &expr.kind {
        ExprKind::Kind(name, params) if params.is_empty() => {
            Some(Expr { kind: ExprKind::Group(Group::Kind(name.clone())), ty: Ty::Group, span: expr.span })
        }
        _ => None,
    }
}

/// The type of a product or quotient.
fn product(a: &Ty, operator: Operator, b: &Ty) -> Option<Ty> {
    let join =
        |a: Dimension, b: Dimension| if operator == Operator::Multiply { a.times(b) } else { a.over(b) };
    Some(match (a, b) {
        (Ty::Count, Ty::Count) if operator == Operator::Multiply => Ty::Count,
        (Ty::Vector(a), b) => Ty::Vector(join(*a, b.dimension()?)?),
        (a, Ty::Vector(b)) if operator == Operator::Multiply => Ty::Vector(join(a.dimension()?, *b)?),
        (Ty::Curve(a), b) if operator == Operator::Multiply => Ty::Curve(join(*a, b.dimension()?)?),
        (a, Ty::Curve(b)) if operator == Operator::Multiply => Ty::Curve(join(a.dimension()?, *b)?),
        (a, b) => Ty::Quantity(join(a.dimension()?, b.dimension()?)?),
    })
}

/// Says that a quantity cannot be counted in a unit of another kind.
fn other_unit(value: &Expr, dimension: Dimension, unit: &Name) -> Diagnostic {
    let have = article(&value.ty);
    Diagnostic::new(
        Code::WRONG_DIMENSION,
        unit.span,
        format!("{have} cannot be turned into a number in `{}`", unit.text),
    )
    .label("a unit of another kind")
    .also(value.span, format!("this is {have}"))
    .help(format!("write a unit that fits, such as `in {}`", units::suggest(dimension)))
}

/// What helps where two operands are of different kinds.
fn unlike(a: &Ty, b: &Ty) -> &'static str {
    let number = |ty: &Ty| ty.dimension().is_some();
    match (a, b) {
        (a, b) if number(a) && number(b) => "both must be of the same kind: is one of the units right?",
        (Ty::Enum(_), _) | (_, Ty::Enum(_)) => "a value of an enumeration is only compared with another one",
        (Ty::Bool, _) | (_, Ty::Bool) => "use `if CONDITION then a else b` to make a number of yes and no",
        _ => "both must be of the same kind",
    }
}

/// What helps where a name is not known and resembles no other.
fn not_declared(name: &str, cx: &Context) -> String {
    // Short names are those that clauses bind, longer ones are declared.
    if name.chars().count() > 2 {
        return crate::names::UNDECLARED.to_owned();
    }
    let mut bound: Vec<String> =
        cx.locals.iter().filter(|l| !l.name.is_empty()).map(|l| format!("`{}`", l.name)).collect();
    bound.dedup();
    match (bound.is_empty(), cx.stage) {
        (true, Stage::Derivation) => "bind it first, as in `match p : part with free port q`".to_owned(),
        (true, _) => crate::names::UNDECLARED.to_owned(),
        _ => format!("bound here: {}; others are declared, or imported with `use`", bound.join(", ")),
    }
}

/// `a, b or c`
fn one_of(words: &[&str]) -> String {
    match words {
        [head @ .., last] if !head.is_empty() => format!("{} or {last}", head.join(", ")),
        other => other.concat(),
    }
}

/// A type with its article.
pub(super) fn article(ty: &Ty) -> String {
    let name = ty.to_string();
    let an = name.starts_with(['A', 'E', 'a', 'e']);
    format!("{} {name}", if an { "an" } else { "a" })
}

/// Says why an expression does not fit, and how it would.
fn mismatch(expr: &Expr, wanted: &Ty, what: &str) -> Diagnostic {
    let (Some(have), Some(want)) = (expr.ty.dimension(), wanted.dimension()) else {
        let help = match (&expr.ty, wanted) {
            (Ty::Track(_), _) => Some("ask for it at a time: `e.position at end`".to_owned()),
            (Ty::Domain(_), _) => Some("a single value is needed here, not a range or set".to_owned()),
            (_, Ty::Distribution(d)) => {
                let unit = if d.is_number() { String::new() } else { format!(" {}", units::suggest(*d)) };
                Some(format!("write for example `normal(0{unit}, 1{unit})` or `uniform(-1{unit}, 1{unit})`"))
            }
            (Ty::Part | Ty::Actuator, Ty::Port) => {
                Some("name one of its ports, as in `core.top` or `a.tip`".to_owned())
            }
            (_, Ty::Kind) => Some("name a kind of part, such as `cube`".to_owned()),
            (Ty::Count, Ty::Bool) if bare_number(expr).is_some_and(|x| x == 0.0 || x == 1.0) => {
                Some(format!("write `{}`", bare_number(expr) == Some(1.0)))
            }
            (Ty::Port, Ty::Part) => Some("`.part` is the part that a port belongs to".to_owned()),
            (_, Ty::Part) => Some("name a part, such as one that the rule matches".to_owned()),
            (_, Ty::Step) => Some("match a step: `match s : step where s adds part`".to_owned()),
            (_, Ty::Group) => {
                Some("name `part`, `block`, `actuator` or a kind, as in `s adds part`".to_owned())
            }
            (_, Ty::Enum(name)) => Some(format!("write one of its values, as in `{name}.VALUE`")),
            (_, Ty::Vector(d)) => {
                let unit = units::display_unit(*d);
                let unit = if *d == Dimension::LENGTH { " cm".to_owned() } else { format!(" {unit}") };
                let unit = if d.is_number() { "" } else { &unit };
                Some(format!("write for example `vector(1{unit}, 0{unit}, 0{unit})`"))
            }
            (Ty::Count | Ty::Quantity(_), Ty::Bool) => {
                Some("compare it with something, as in `count(part) > 3`".to_owned())
            }
            (_, Ty::Domain(_)) => Some("write a range `a .. b` or a set `{ a, b }`".to_owned()),
            _ => None,
        };
        return Diagnostic::new(
            Code::WRONG_TYPE,
            expr.span,
            format!("{what} must be {}, but this is {}", article(wanted), article(&expr.ty)),
        )
        .label(format!("this is {}", article(&expr.ty)))
        .help_if(help);
    };
    if *wanted == Ty::Count {
        return Diagnostic::new(Code::WRONG_TYPE, expr.span, format!("{what} must be a whole number"))
            .label(if have.is_number() {
                "not a whole number".to_owned()
            } else {
                format!("this is {}", article(&expr.ty))
            })
            .help(if have.is_number() {
                "write a number such as 3, or use `floor` or `round`"
            } else {
                "write a whole number without a unit, such as 3"
            });
    }
    if let Some(x) = bare_number(expr) {
        return Diagnostic::new(
            Code::MISSING_UNIT,
            expr.span,
            format!("{what} must be {}, but this number has no unit", article(wanted)),
        )
        .label("without a unit")
        .help(format!("write `{x} {}`", units::suggest(want)));
    }
    let upside_down = match &expr.kind {
        ExprKind::Binary(a, Operator::Divide, b) if Dimension::NUMBER.over(want) == Some(have) => {
            bare_number(a).is_some() && matches!(b.kind, ExprKind::Number(_))
        }
        _ => false,
    };
    let per_angle =
        have.over(want).is_some_and(|d| d == Dimension::ANGLE || Some(d) == Dimension::ANGLE.power(2));
    let literal = matches!(&expr.kind, ExprKind::Number(_))
        || matches!(&expr.kind, ExprKind::Negate(x) if matches!(x.kind, ExprKind::Number(_)));
    let help = if upside_down {
        "a unit belongs to the number before it: write the unit before dividing, as in `1 s / 240`".to_owned()
    } else if want.is_number() && literal {
        "write it without a unit".to_owned()
    } else if matches!(&expr.kind, ExprKind::Word(Word::Cycle)) && want == Dimension::ANGLE {
        "`cycle` runs from 0 to 1: write `cycle * 360 deg`".to_owned()
    } else if have.is_number() && !literal {
        let unit = units::suggest(want);
        format!("give one of its numbers a unit of {want}, such as {unit}, or multiply it by `1 {unit}`")
    } else if !want.is_number() && !per_angle && !literal {
        if what == "this term" {
            format!("declare it as `: {have}`, or change what it is calculated from")
        } else {
            format!("its calculation comes out as {}: is a factor or a unit missing?", article(&expr.ty))
        }
    } else if want.is_number() {
        format!("divide it by a quantity of the same kind, or write `in {}` after it", units::suggest(have))
    } else if per_angle {
        format!("angles count as a dimension here: write it in {}", units::suggest(want))
    } else {
        format!("write it in a unit of {want}, such as {}", units::suggest(want))
    };
    Diagnostic::new(
        Code::WRONG_DIMENSION,
        expr.span,
        format!("{what} must be {}, but this is {}", article(wanted), article(&expr.ty)),
    )
    .label(format!("this is {}", article(&expr.ty)))
    .help(help)
}
