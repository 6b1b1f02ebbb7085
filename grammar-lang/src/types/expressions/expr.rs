//! Checks expressions: names, stages, types and dimensions.

use super::Expressions;
use super::context::{Context, as_group, unknown};
use super::fit::{LEAST_NOT_COUNTED, article, is_zero, other_unit};
use super::stage::Stage;
use crate::diagnostics::{Code, Diagnostic, did_you_mean};
use crate::eval::Value;
use crate::ir::{Binder, Expr, ExprKind, Gather, Operator, Ty, Word};
use crate::source::Span;
use crate::syntax::ast;
use crate::units::{self, Dimension};

impl Expressions<'_> {
    pub(in crate::types) fn report(&mut self, diagnostic: Diagnostic) {
        self.errors.add(diagnostic);
    }

    /// Finds the type of an expression; every error in it is reported once.
    pub(in crate::types) fn infer(&mut self, tree: &ast::Expr, cx: &mut Context) -> Expr {
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
                let written = self.environment.sources.slice(span);
                let whole = value.fract() == 0.0
                    && value.abs() < LEAST_NOT_COUNTED
                    && !written.contains(['.', 'e', 'E']);
                make(ExprKind::Number(*value), if whole { Ty::Count } else { Ty::NUMBER })
            }
            ast::ExprKind::Quantity(value, Some(unit)) => self.quantity(*value, unit, span),
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
            ast::ExprKind::Index(list, index) => self.indexed(list, index, span, cx),
            ast::ExprKind::At(value, time) => self.at(value, time, span, cx),
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
            ast::ExprKind::Range(low, high) => self.range(low, high, span, cx),
            ast::ExprKind::Set(items) | ast::ExprKind::List(items) => {
                let set = matches!(tree.kind, ast::ExprKind::Set(_));
                let Some((items, ty)) = self.items(items, span, cx, set) else { return unknown(span) };
                if set {
                    make(ExprKind::Set(items), Ty::Domain(Box::new(ty)))
                } else {
                    make(ExprKind::List(items), Ty::List(Box::new(ty)))
                }
            }
            ast::ExprKind::Convert(value, unit) => self.converted(value, unit, span, cx),
        }
    }

    fn quantity(&mut self, value: f64, unit: &ast::Name, span: Span) -> Expr {
        let Some(unit) = self.unit(unit) else { return unknown(span) };
        let si = value * unit.factor;
        if si > units::LARGEST {
            let error = Diagnostic::new(Code::BAD_NUMBER, span, "this number is too large");
            self.report(error.label("larger than 1e100 in SI units"));
            return unknown(span);
        }
        Expr { kind: ExprKind::Number(si), ty: Ty::Quantity(unit.dimension), span }
    }

    /// An item of a list, or one of several ports of a name.
    fn indexed(&mut self, list: &ast::Expr, index: &ast::Expr, span: Span, cx: &mut Context) -> Expr {
        let list = self.infer(list, cx);
        if let ExprKind::Port(of, name, None) = list.kind {
            let index = self.expect(index, cx, &Ty::Count, "the number of a port");
            return Expr { kind: ExprKind::Port(of, name, Some(Box::new(index))), ty: Ty::Port, span };
        }
        let index = self.expect(index, cx, &Ty::Count, "an index");
        match list.ty.clone() {
            Ty::List(item) => {
                Expr { kind: ExprKind::Index(Box::new(list), Box::new(index)), ty: *item, span }
            }
            Ty::Unknown => unknown(span),
            other => {
                self.wrong(list.span, format!("{} has no items", article(&other)), "only a list has items")
            }
        }
    }

    fn at(&mut self, value: &ast::Expr, time: &ast::Expr, span: Span, cx: &mut Context) -> Expr {
        let value = self.infer(value, cx);
        let time = self.expect(time, cx, &Ty::Quantity(Dimension::TIME), "what follows `at`");
        match value.ty.clone() {
            // A sensor remembers nothing: what it read before, a `state` of an actuation can keep.
            Ty::Track(_)
                if cx.stage == Stage::Sense
                    && time.ty != Ty::Unknown
                    && time.kind != ExprKind::Word(Word::Now) =>
            {
                self.report(
                    Diagnostic::new(
                        Code::WRONG_STAGE,
                        time.span,
                        "a sensor can read only the present (`at now`)",
                    )
                    .label("another time")
                    .help("write `at now`; for a reading that is late, add `delay 20 ms` at the end"),
                );
                unknown(span)
            }
            Ty::Track(_)
                if cx.stage == Stage::Reward
                    && time.ty != Ty::Unknown
                    && !matches!(time.kind, ExprKind::Word(Word::Now | Word::Before)) =>
            {
                self.report(
                    Diagnostic::new(
                        Code::WRONG_STAGE,
                        time.span,
                        "a reward can read only the present (`now`) and the previous decision (`before`)",
                    )
                    .label("another time")
                    .help("write `at now` or `at before`"),
                );
                unknown(span)
            }
            Ty::Track(ty) => Expr { kind: ExprKind::At(Box::new(value), Box::new(time)), ty: *ty, span },
            Ty::Unknown => unknown(span),
            other => self.wrong(
                value.span,
                format!("{} does not change over the motion", article(&other)),
                "`at` asks for the position or rotation of an element at a time",
            ),
        }
    }

    fn range(&mut self, low: &ast::Expr, high: &ast::Expr, span: Span, cx: &mut Context) -> Expr {
        let (low, high) = (self.infer(low, cx), self.infer(high, cx));
        let Some((low, high, ty)) = self.unify(low, high, "this range") else { return unknown(span) };
        if ty != Ty::Unknown && ty.dimension().is_none() {
            let message = format!("a range cannot go from {ty} to {ty}");
            return self.wrong(span, message, "a range needs two numbers");
        }
        self.check_order(&low, &high, span);
        let kind = ExprKind::Range(Box::new(low), Box::new(high));
        Expr { kind, ty: Ty::Domain(Box::new(ty)), span }
    }

    /// A quantity as a number of units.
    fn converted(&mut self, value: &ast::Expr, place: &ast::Name, span: Span, cx: &mut Context) -> Expr {
        let value = self.infer(value, cx);
        let Some(unit) = self.unit(place) else { return unknown(span) };
        if let Some(other) = value.ty.dimension().filter(|d| *d != unit.dimension && !d.is_number()) {
            self.report(other_unit(&value, other, place));
            return unknown(span);
        }
        let value = self.fit(value, &Ty::Quantity(unit.dimension), "what is turned into a number");
        Expr { kind: ExprKind::Convert(Box::new(value), unit.factor), ty: Ty::NUMBER, span }
    }

    pub(super) fn wrong(&mut self, span: Span, message: String, help: &str) -> Expr {
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
            if item.ty == Ty::List(Box::new(Ty::World)) {
                self.report(
                    Diagnostic::new(Code::WRONG_TYPE, item.span, "this is a set of worlds already")
                        .label("the name of a set of scenarios is needed here")
                        .help("remove the braces: `over w in NAME`"),
                );
                return None;
            }
            // What all have in common is that of an item that is no zero, which fits any.
            match checked.iter().find(|item| !is_zero(item)).or(checked.first()).cloned() {
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
                Diagnostic::new(Code::EMPTY_DOMAIN, span, "this set or list is empty")
                    .label("empty")
                    .help("name at least one value"),
            );
            return None;
        }
        Some((checked, ty))
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
        let value = |e: &Expr| self.working.value(e, &mut Vec::new()).ok();
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
                .label("goes beyond this range")
                .also(old.span, "the domain in the base")
                .help("for a wider domain, write `set NAME = ...` instead of `narrow NAME in ...`; what takes the value must allow it"),
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
                    "the base chooses {} here, but this contains {}",
                    article(&chosen(&old.ty, before)),
                    article(&chosen(&new.ty, now))
                ),
            )
            .label("another kind of quantity")
            .also(old.span, "the domain in the base")
            .help("expressions that read the choice need the same kind of quantity as in the base"),
        );
        unknown(new.span)
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
                let compared = match &a.kind {
                    ast::ExprKind::Binary(left, O::Equal | O::NotEqual | O::Is | O::IsNot, _) => {
                        Some(left.span)
                    }
                    _ => None,
                };
                let sign = self.environment.sources.slice(a.span).to_owned();
                let a = self.expect(a, cx, &Ty::Bool, &format!("the left side of {symbol}"));
                let known = self.errors.len();
                let right = b.span;
                let b = self.expect(b, cx, &Ty::Bool, &format!("the right side of {symbol}"));
                // `x == 1 or 2`
                if let Some(left) = compared {
                    let (left, right) =
                        (self.environment.sources.slice(left), self.environment.sources.slice(right));
                    let rest = sign.get(left.len()..).unwrap_or("").trim_start();
                    let compares =
                        ["==", "!=", "is not", "is"].into_iter().find(|sign| rest.starts_with(sign));
                    let help = compares
                        .map(|compares| format!("write the comparison again: `{left} {compares} {right}`"));
                    for mut error in self.errors.split_off(known) {
                        if error.code == Code::WRONG_TYPE && error.span() == b.span && help.is_some() {
                            error.help.clone_from(&help);
                        }
                        self.errors.add(error);
                    }
                }
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
            let ty = if operator.is_arithmetic() { Ty::Unknown } else { Ty::Bool };
            return make(a, b, ty);
        }
        match operator {
            O::Multiply | O::Divide => {
                let Some(ty) = product(&a.ty, operator, &b.ty) else {
                    // `at` binds tighter than `*`: the time after it is not what was meant.
                    let help = match (&a.kind, b.ty.dimension()) {
                        (ExprKind::At(..), Some(_)) => {
                            "`at` comes before `*` and `/`: put the time in brackets, as in `at (i * duration / 20)`"
                        }
                        _ => "it needs numbers",
                    };
                    return self.wrong(span, format!("{symbol} cannot join a {} and a {}", a.ty, b.ty), help);
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
                self.check_rule_name(&a, &b);
                if !fine {
                    let help = if matches!(ty, Ty::Track(_)) {
                        "ask for it at a time: `e.position at end`"
                    } else {
                        "it needs numbers"
                    };
                    return self.wrong(span, format!("{symbol} cannot join two values of type {ty}"), help);
                }
                let ty = if matches!(operator, O::Add | O::Subtract) { ty } else { Ty::Bool };
                make(a, b, ty)
            }
        }
    }

    /// `s.rule == "grwo"` holds for no step.
    fn check_rule_name(&mut self, a: &Expr, b: &Expr) {
        let (ExprKind::Attribute(step, _), ExprKind::Text(name)) = (&a.kind, &b.kind) else { return };
        // A module on its own does not know which rules it will meet.
        if step.ty != Ty::Step || self.environment.program.name.is_none() {
            return;
        }
        let program = self.environment.program;
        let rules = || {
            program.entries().filter_map(|(_, item)| match &item.kind {
                ast::ItemKind::Rule(name, _) => Some(name.text.as_str()),
                _ => None,
            })
        };
        // What a variant drops made no step, and nothing is wrong with that.
        let dropped = program.dropped_at(b.span, name).is_some();
        if rules().any(|rule| rule == name) || dropped || self.is_lost(b.span, name) {
            return;
        }
        let help = did_you_mean(name, rules())
            .unwrap_or_else(|| format!("the rules are: {}", rules().collect::<Vec<_>>().join(", ")));
        self.report(
            Diagnostic::new(Code::UNKNOWN_NAME, b.span, format!("there is no rule `{name}`"))
                .label("no rule has this name")
                .help(help),
        );
    }

    /// What aggregates and effects run over: each binder takes the next local slot.
    pub(in crate::types) fn binders(&mut self, binders: &[ast::Binder], cx: &mut Context) -> Vec<Binder> {
        let mut bound = Vec::new();
        for binder in binders {
            let over = self.infer(&binder.over, cx);
            let mut over = as_group(&over).unwrap_or(over);
            if over.ty == Ty::Group && !cx.stage.sees_design() {
                over = self.parts_unknown(over.span, cx.stage);
            }
            let item = match &over.ty {
                Ty::Group => match &over.kind {
                    ExprKind::Group(group) => self.member_of(group, over.span),
                    _ => Ty::Part,
                },
                Ty::List(item) => (**item).clone(),
                Ty::Domain(item) if **item == Ty::Count => Ty::Count,
                Ty::Domain(item) if matches!(over.kind, ExprKind::Set(_)) => (**item).clone(),
                Ty::Unknown => Ty::Unknown,
                other => {
                    let message = format!("{} cannot be run over", article(other));
                    self.wrong(
                        over.span,
                        message,
                        "run over `part`, `actuator`, `cell`, `elements`, a list or a range of whole numbers",
                    )
                    .ty
                }
            };
            let slot = cx.locals.len();
            self.note_kind(&binder.name, &over);
            self.bind(&binder.name, item, cx);
            bound.push(Binder { slot, over });
        }
        bound
    }

    /// `clusters over c in cell where CONDITION of VALUE`
    fn clusters(&mut self, tree: &ast::Expr, bound: Vec<Binder>, depth: usize, cx: &mut Context) -> Expr {
        let ast::ExprKind::Aggregate { condition, body, otherwise, .. } = &tree.kind else {
            return unknown(tree.span);
        };
        let over_cells = matches!(cx.locals.get(depth..), Some([cell]) if cell.ty.fits(&Ty::Cell));
        if !over_cells || otherwise.is_some() {
            cx.locals.truncate(depth);
            let message = "`clusters` runs over the cells of a lattice, and needs no `otherwise`: without cells, it is 0";
            return self.wrong(
                tree.span,
                message.to_owned(),
                "write for example `clusters over c in cell where c.pattern > 0 of c.pattern`",
            );
        }
        let condition =
            condition.as_ref().map(|c| Box::new(self.expect(c, cx, &Ty::Bool, "what follows `where`")));
        let body = body.as_ref().map(|b| Box::new(self.infer(b, cx)));
        cx.locals.truncate(depth);
        let kind = ExprKind::Aggregate {
            how: Gather::Clusters,
            share: None,
            binders: bound,
            condition,
            body,
            otherwise: None,
        };
        Expr { kind, ty: Ty::Count, span: tree.span }
    }

    /// The share of a quantile.
    fn share(&mut self, tree: &ast::Expr, cx: &mut Context) -> Expr {
        let share = self.expect(tree, cx, &Ty::NUMBER, "the share of a quantile");
        let literal = if let ExprKind::Number(share) = share.kind { Some(share) } else { None };
        if literal.is_some_and(|share| !(0.0..=1.0).contains(&share)) {
            self.report(
                Diagnostic::new(
                    Code::OUT_OF_DOMAIN,
                    tree.span,
                    "the share of a quantile must lie within 0 % .. 100 %",
                )
                .label("not a share")
                .help("write for example `quantile 10 % over`: nine of ten are above that"),
            );
        }
        share
    }

    fn aggregate(&mut self, tree: &ast::Expr, cx: &mut Context) -> Expr {
        let ast::ExprKind::Aggregate { how, share, binders, condition, body, otherwise } = &tree.kind else {
            return unknown(tree.span);
        };
        let share = share.as_ref().map(|share| Box::new(self.share(share, cx)));
        let depth = cx.locals.len();
        let bound = self.binders(binders, cx);
        if *how == Gather::Clusters {
            return self.clusters(tree, bound, depth, cx);
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
            (Gather::Count | Gather::Clusters, _) => Ty::Count,
            (Gather::Forall | Gather::Exists, _) => Ty::Bool,
            (_, None) => Ty::Unknown,
            (_, Some(body)) => match &body.ty {
                Ty::Count if matches!(how, Gather::Mean | Gather::Deviation | Gather::Quantile) => Ty::NUMBER,
                ty @ (Ty::Quantity(_) | Ty::Count | Ty::Unknown) => ty.clone(),
                ty @ Ty::Vector(_) if matches!(how, Gather::Sum | Gather::Mean) => ty.clone(),
                other => {
                    self.wrong(
                        body.span,
                        format!("{} cannot be aggregated", article(other)),
                        "aggregate numbers, as in `of p.mass`",
                    )
                    .ty
                }
            },
        };
        let otherwise = otherwise.map(|o| Box::new(self.fit(o, &ty, "what follows `otherwise`")));
        let kind = ExprKind::Aggregate {
            how: *how,
            share,
            binders: bound,
            condition,
            body: body.map(Box::new),
            otherwise,
        };
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
