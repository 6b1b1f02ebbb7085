//! Checks rules and actuations.

use super::Checker;
use super::expr::Context;
use super::stage::Stage;
use crate::diagnostics::{Code, Diagnostic, did_you_mean, respell};
use crate::ir::{self, Expr, ExprKind, Group, Ty};
use crate::syntax::ast::{self, ActuationClause, Name, RuleClause, RuleClauseKind};
use crate::units::Dimension;

impl Checker<'_> {
    /// The group of parts that a kind's name stands for.
    fn group_named(&mut self, kind: &Name, cx: &mut Context) -> Option<Group> {
        let tree = ast::Expr { kind: ast::ExprKind::Name(kind.text.clone()), span: kind.span };
        let expr = self.expect(&tree, cx, &Ty::Group, "what is matched");
        match expr.kind {
            ExprKind::Group(group) if expr.ty == Ty::Group => Some(group),
            _ => None,
        }
    }

    pub(super) fn rule(
        &mut self,
        name: &Name,
        clauses: &[RuleClause],
        module: usize,
        damaged: bool,
    ) -> Option<ir::Rule> {
        let mut cx = Context::new(module, Stage::Derivation, damaged);
        let found = self.errors.len();
        let mut matched = None;
        for clause in clauses {
            let pattern = match &clause.kind {
                RuleClauseKind::MatchNothing => Some(ir::Pattern::Nothing),
                RuleClauseKind::Match { name, kind, port, condition } => {
                    self.pattern(name, kind, port.as_ref(), condition.as_ref(), &mut cx)
                }
                _ => continue,
            };
            match matched {
                None => matched = Some((pattern, clause.span)),
                Some((_, first)) => self.report(
                    Diagnostic::new(Code::DUPLICATE, clause.span, "a rule has one `match`")
                        .label("another match")
                        .also(first, "the first one")
                        .help("split the rule in two"),
                ),
            }
        }
        let pattern = matched.map_or(Some(ir::Pattern::Nothing), |(pattern, _)| pattern);
        let mut choices = Vec::new();
        for clause in clauses {
            let RuleClauseKind::Choose(name, domain) = &clause.kind else { continue };
            let domain = self.infer(domain, &mut cx);
            let ty = match &domain.ty {
                Ty::Domain(item) => (**item).clone(),
                Ty::List(item) => (**item).clone(),
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
            };
            self.bind(name, ty, &mut cx);
            choices.push(ir::Choice { name: name.text.clone(), domain });
        }
        let bound = cx.locals.len();
        let mut guards = Vec::new();
        let mut effects = Vec::new();
        let mut weight = None;
        for clause in clauses {
            match &clause.kind {
                RuleClauseKind::Guard(positive, condition) => {
                    let what = if *positive { "what follows `when`" } else { "what follows `unless`" };
                    let condition = self.expect(condition, &mut cx, &Ty::Bool, what);
                    let needs = highest_local(&condition, bound);
                    let condition = if *positive {
                        condition
                    } else {
                        Expr { ty: Ty::Bool, span: condition.span, kind: ExprKind::Not(Box::new(condition)) }
                    };
                    guards.push(ir::Guard { needs, condition });
                }
                RuleClauseKind::Attach { what, port, turned } => {
                    let what = self.expect(what, &mut cx, &Ty::Kind, "what is attached");
                    let port = self.expect(port, &mut cx, &Ty::Port, "where it is attached");
                    let turned = turned.as_ref().map(|t| {
                        self.expect(t, &mut cx, &Ty::Quantity(Dimension::ANGLE), "what follows `turned`")
                    });
                    effects.push(ir::Effect::Attach { what, port, turned });
                }
                RuleClauseKind::Set(target, value) => effects.extend(self.set(target, value, &mut cx)),
                RuleClauseKind::Revert(step) => {
                    let step = self.expect(step, &mut cx, &Ty::Step, "what is reverted");
                    effects.push(ir::Effect::Revert(step));
                }
                RuleClauseKind::Weight(value) => {
                    let mut cx = Context::new(module, Stage::Weight, damaged);
                    let value = self.expect(value, &mut cx, &Ty::NUMBER, "a weight");
                    if weight.replace(value).is_some() {
                        self.report(
                            Diagnostic::new(Code::DUPLICATE, clause.span, "a rule has one `weight`")
                                .label("another one")
                                .help("keep one of them"),
                        );
                    }
                }
                _ => {}
            }
        }
        if effects.is_empty() && !damaged && self.errors.len() == found {
            self.report(
                Diagnostic::new(Code::NO_EFFECT, name.span, format!("the rule `{}` does nothing", name.text))
                    .label("without an effect")
                    .help("say what it does: `attach`, `set` or `revert`"),
            );
        }
        let weight = weight.unwrap_or(Expr { kind: ExprKind::Number(1.0), ty: Ty::NUMBER, span: name.span });
        Some(ir::Rule {
            name: name.text.clone(),
            pattern: pattern?,
            choices,
            guards,
            effects,
            weight,
            locals: cx.locals.into_iter().map(|l| l.name).collect(),
            span: name.span,
        })
    }

    fn pattern(
        &mut self,
        name: &Name,
        kind: &Name,
        port: Option<&Name>,
        condition: Option<&ast::Expr>,
        cx: &mut Context,
    ) -> Option<ir::Pattern> {
        let step = kind.text == "step";
        let group = if step { None } else { self.group_named(kind, cx) };
        let ty = match &group {
            _ if step => Ty::Step,
            Some(Group::Actuator) => Ty::Actuator,
            Some(Group::Kind(kind)) if self.is_actuator(kind, cx.module) => Ty::Actuator,
            Some(_) => Ty::Part,
            None => Ty::Unknown,
        };
        self.bind(name, ty, cx);
        if let Some(port) = port {
            if step {
                self.report(
                    Diagnostic::new(Code::WRONG_TYPE, port.span, "a step has no ports")
                        .label("not possible")
                        .help("match a part"),
                );
                return None;
            }
            self.bind(port, Ty::Port, cx);
        }
        let condition = condition.map(|c| self.expect(c, cx, &Ty::Bool, "what follows `where`"));
        if step {
            return Some(ir::Pattern::Step { condition });
        }
        Some(ir::Pattern::Part { kind: group?, port: port.is_some(), condition })
    }

    fn set(&mut self, target: &ast::Expr, value: &ast::Expr, cx: &mut Context) -> Option<ir::Effect> {
        let ast::ExprKind::Member(of, attribute) = &target.kind else {
            self.report(
                Diagnostic::new(Code::WRONG_TYPE, target.span, "only an attribute of a part can be set")
                    .label("not an attribute")
                    .help("write for example `set p.turn = 90 deg`"),
            );
            return None;
        };
        if attribute.text == "image" {
            self.report(
                Diagnostic::new(
                    Code::WRONG_TYPE,
                    attribute.span,
                    "`image` follows from the symmetry and cannot be set",
                )
                .label("read only"),
            );
            return None;
        }
        let whole = self.infer(target, cx);
        let part = self.infer(of, cx);
        let value = self.expect(value, cx, &whole.ty.clone(), &format!("`{}`", attribute.text));
        Some(ir::Effect::Set { part, attribute: attribute.text.clone(), value })
    }

    pub(super) fn actuation(
        &mut self,
        name: &Name,
        binder: &Name,
        kind: &Name,
        clauses: &[ActuationClause],
        module: usize,
        damaged: bool,
    ) -> Option<ir::Actuation> {
        let mut cx = Context::new(module, Stage::Drive, damaged);
        let group = self.group_named(kind, &mut cx);
        let fine = match &group {
            Some(Group::Actuator) | None => true,
            Some(Group::Kind(kind)) => self.is_actuator(kind, module),
            _ => false,
        };
        if !fine {
            self.report(
                Diagnostic::new(Code::WRONG_TYPE, kind.span, format!("`{}` cannot be driven", kind.text))
                    .label("not an actuator")
                    .help("write `for a : actuator`"),
            );
        }
        self.bind(binder, Ty::Actuator, &mut cx);
        let mut variables = Vec::new();
        for clause in clauses {
            let ActuationClause::Variable(variable) = clause else { continue };
            let checked = self.variable(variable, &cx);
            let item = checked.as_ref().map_or(Ty::Unknown, |v| v.ty.clone());
            let ty = if variable.size.is_some() { Ty::List(Box::new(item)) } else { item };
            self.bind(&variable.name, ty, &mut cx);
            variables.extend(checked);
        }
        let complete = variables.len() + 1 == cx.locals.len();
        // Values without the time come first, so that they are found once for a motion.
        let mut lets: Vec<(String, Expr)> = Vec::new();
        let mut moving: Vec<(String, Expr)> = Vec::new();
        let mut drive = None;
        for clause in clauses {
            match clause {
                ActuationClause::Let(name, value) => {
                    let value = self.infer(value, &mut cx);
                    let timed = value.any(&mut |e| matches!(e.kind, ExprKind::Word(ir::Word::Time)));
                    let first_moving = 1 + variables.len() + lets.len();
                    let follows = value.any(&mut |e| matches!(e.kind, ExprKind::Local(slot) if slot >= first_moving && !moving.is_empty()));
                    self.bind(name, value.ty.clone(), &mut cx);
                    // Slots are in the order of the text: once one value moves, those after it do too.
                    if timed || follows || !moving.is_empty() {
                        moving.push((name.text.clone(), value));
                    } else {
                        lets.push((name.text.clone(), value));
                    }
                }
                ActuationClause::Drive(what, value) => {
                    if what.text != "angle" {
                        self.report(
                            Diagnostic::new(
                                Code::UNKNOWN_FIELD,
                                what.span,
                                format!("an actuator has no `{}` to drive", what.text),
                            )
                            .label("not known")
                            .help("write `drive angle = ...`")
                            .fix_if(respell(what.span, &what.text, ["angle"])),
                        );
                    }
                    let value =
                        self.expect(value, &mut cx, &Ty::Quantity(Dimension::ANGLE), "the driven angle");
                    if drive.replace(value).is_some() {
                        self.report(
                            Diagnostic::new(Code::DUPLICATE, what.span, "an actuation has one `drive`")
                                .label("another one"),
                        );
                    }
                }
                ActuationClause::Variable(_) => {}
            }
        }
        if drive.is_none() && !damaged {
            self.report(
                Diagnostic::new(
                    Code::MISSING_FIELD,
                    name.span,
                    format!("the actuation `{}` drives nothing", name.text),
                )
                .label("without `drive`")
                .help("add a line such as `drive angle = 30 deg * sin(t / period * 360 deg)`"),
            );
        }
        if !complete {
            return None;
        }
        Some(ir::Actuation { variables, lets, moving, drive: drive?, span: name.span })
    }

    fn variable(&mut self, variable: &ast::Variable, cx: &Context) -> Option<ir::Variable> {
        let name = &variable.name;
        let mut constant = Context::new(cx.module, Stage::Declaration, cx.damaged);
        let ty = self.type_named(&variable.ty);
        let size = match &variable.size {
            None => None,
            Some(size) => {
                let span = size.span;
                let size = self.expect(size, &mut constant, &Ty::Count, "the length of a list");
                let n = self.constant_number(&size)?;
                if !(1.0..=64.0).contains(&n) {
                    self.report(
                        Diagnostic::new(
                            Code::OUT_OF_DOMAIN,
                            span,
                            "the length of a list must lie within 1 .. 64",
                        )
                        .label("too short or too long"),
                    );
                    return None;
                }
                Some(n as usize)
            }
        };
        let domain = match (&ty, &variable.domain) {
            (Ty::Unknown, _) => return None,
            (Ty::Bool, _) => (0.0, 1.0),
            (Ty::Quantity(_) | Ty::Count, Some(domain)) => {
                let what = format!("the domain of `{}`", name.text);
                let domain = self.expect(domain, &mut constant, &Ty::Domain(Box::new(ty.clone())), &what);
                self.constant_range(&domain)?
            }
            (Ty::Quantity(_) | Ty::Count, None) => {
                self.report(
                    Diagnostic::new(Code::MISSING_FIELD, name.span, format!("`{}` has no domain", name.text))
                        .label("between which values?")
                        .help("write `in LEAST .. GREATEST` after its type"),
                );
                return None;
            }
            _ => {
                self.report(
                    Diagnostic::new(
                        Code::WRONG_TYPE,
                        variable.ty.span,
                        "the search varies quantities, Counts and Bools",
                    )
                    .label("not one of these"),
                );
                return None;
            }
        };
        let mut mutating = Context::new(cx.module, Stage::Mutation, cx.damaged);
        let chance = |checker: &mut Self, tree: &ast::Expr, cx: &mut Context| {
            let expr = checker.expect(tree, cx, &Ty::NUMBER, "a probability");
            if let Some(p) = checker.quiet_number(&expr)
                && !(0.0..=1.0).contains(&p)
            {
                checker.report(
                    Diagnostic::new(Code::OUT_OF_DOMAIN, expr.span, "a probability lies within 0 .. 1")
                        .label("outside"),
                );
            }
            expr
        };
        let (probability, kernel) = match (&ty, &variable.mutate, &variable.flip) {
            (Ty::Bool, None, Some(p)) => (chance(self, p, &mut mutating), ir::Kernel::Flip),
            (Ty::Bool, ..) => {
                self.report(
                    Diagnostic::new(
                        Code::MISSING_FIELD,
                        name.span,
                        format!("`{}` is never varied", name.text),
                    )
                    .label("how often does it change?")
                    .help("write `flip 0.1` after its type"),
                );
                return None;
            }
            (_, Some((p, kernel)), None) => {
                let p = chance(self, p, &mut mutating);
                let wanted = match &ty {
                    Ty::Count => Dimension::NUMBER,
                    ty => ty.dimension()?,
                };
                let kernel =
                    self.expect(kernel, &mut mutating, &Ty::Distribution(wanted), "what follows `by`");
                let ExprKind::Call(function, arguments) = kernel.kind else { return None };
                let [a, b] = <[Expr; 2]>::try_from(arguments).ok()?;
                let normal = function == ir::Function::Normal;
                (p, if normal { ir::Kernel::Normal(a, b) } else { ir::Kernel::Uniform(a, b) })
            }
            _ => {
                self.report(
                    Diagnostic::new(
                        Code::MISSING_FIELD,
                        name.span,
                        format!("`{}` is never varied", name.text),
                    )
                    .label("how does it change?")
                    .help("write `mutate 0.5 by normal(0, ...)` after its domain"),
                );
                return None;
            }
        };
        let bound = match variable.bound.as_ref().map(|b| (b.text.as_str(), b.span)) {
            Some(("reflect", _)) => ir::Bound::Reflect,
            None | Some(("clamp", _)) => ir::Bound::Clamp,
            Some(("resample", _)) => ir::Bound::Resample,
            Some((other, span)) => {
                self.report(
                    Diagnostic::new(
                        Code::UNKNOWN_FIELD,
                        span,
                        format!("`{other}` is nothing that can happen at a bound"),
                    )
                    .label("not known")
                    .help(
                        did_you_mean(other, ["clamp", "reflect", "resample"])
                            .unwrap_or_else(|| "write `clamp`, `reflect` or `resample`".to_owned()),
                    )
                    .fix_if(respell(span, other, ["clamp", "reflect", "resample"])),
                );
                ir::Bound::Reflect
            }
        };
        Some(ir::Variable {
            name: name.text.clone(),
            shared: variable.shared,
            size,
            ty,
            domain,
            mutation: ir::Mutation { probability, kernel, bound },
        })
    }
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
