//! Checks calls: built-in functions, curves, and kinds of parts with parameters.

use super::Expressions;
use super::context::{Context, Local};
use super::stage::Stage;
use crate::diagnostics::{Code, Diagnostic, did_you_mean, nearest, respell};
use crate::ir::{Attribute, Expr, ExprKind, Function, PartAttribute, Ty, Word};
use crate::names::Declaration;
use crate::source::Span;
use crate::syntax::ast;
use crate::syntax::ast::ItemKind;
use crate::syntax::declarations::BlockKind;
use crate::units::Dimension;

/// A function that the grammar declares.
struct Declared<'t> {
    declaration: Declaration,
    name: &'t ast::Name,
    parameters: &'t [ast::Typed],
    body: &'t ast::Expr,
}

/// How many arguments there are, in words.
pub(super) fn given(arguments: &[ast::Argument]) -> String {
    if arguments.iter().any(|a| a.name.is_some()) {
        return "arguments of a function have no names".to_owned();
    }
    match arguments.len() {
        0 => "no argument is given".to_owned(),
        1 => "one argument is given".to_owned(),
        n => format!("{n} arguments are given"),
    }
}

impl Expressions<'_> {
    pub(super) fn call(
        &mut self,
        callee: &ast::Expr,
        arguments: &[ast::Argument],
        span: Span,
        cx: &mut Context,
    ) -> Expr {
        let unknown = Expr { kind: ExprKind::Bool(false), ty: Ty::Unknown, span };
        if let ast::ExprKind::Name(name) = &callee.kind {
            let local = cx.locals.iter().find(|l| l.name == *name).cloned();
            if let Some(local) = local.as_ref().filter(|local| local.ty == Ty::Kind) {
                let local = local.span;
                let kind = self.infer(callee, cx);
                return self.chosen_with(name, kind, local, arguments, span, cx);
            }
            // What is no curve cannot be called: then the function of this name is meant.
            let is_called = local.is_some_and(|local| {
                matches!(local.ty, Ty::Curve(_) | Ty::Unknown) || Function::named(name).is_none()
            });
            if !is_called {
                let program = self.environment.program;
                if let Some((declaration, item)) = program.lookup(callee.span, name) {
                    match &item.kind {
                        ItemKind::Block(BlockKind::Part | BlockKind::Actuator | BlockKind::Cell, _) => {
                            self.touched.insert(declaration);
                            return self.kind_with(name, item, arguments, span, cx);
                        }
                        ItemKind::Let(name, Some(parameters), body) => {
                            self.touched.insert(declaration);
                            let function = Declared { declaration, name, parameters, body };
                            return self.own_function(&function, arguments, span, cx);
                        }
                        ItemKind::Sense(sense) => {
                            self.touched.insert(declaration);
                            return self.sensed(sense, arguments, span, cx);
                        }
                        ItemKind::State(of_body) => {
                            self.touched.insert(declaration);
                            return self.remembered(of_body, arguments, span, cx);
                        }
                        ItemKind::Record(name, fields) => {
                            let record = (declaration, fields.as_slice());
                            return self.record((name, callee.span), record, arguments, span, cx);
                        }
                        _ => {}
                    }
                } else if let Some(function) = Function::named(name) {
                    return self.function(function, arguments, span, cx);
                } else if self.report_dropped(callee.span, name) {
                    return unknown;
                } else if !cx.damaged && !self.is_lost(callee.span, name) {
                    let callable = self.callable(callee.span);
                    let help = did_you_mean(name, callable.iter().copied()).unwrap_or_else(|| {
                        format!(
                            "functions are: {}",
                            Function::ALL.iter().map(|f| f.text()).collect::<Vec<_>>().join(", ")
                        )
                    });
                    self.report(
                        Diagnostic::new(
                            Code::UNKNOWN_NAME,
                            callee.span,
                            format!("unknown function `{name}`"),
                        )
                        .label("not declared")
                        .help(help)
                        .fix_if(respell(callee.span, name, callable)),
                    );
                    return unknown;
                } else {
                    return unknown;
                }
            }
        }
        self.applied(callee, arguments, span, cx)
    }

    /// What a sensor reads, of a part where parts have one each.
    pub(super) fn sensed(
        &mut self,
        sense: &ast::Sense,
        arguments: &[ast::Argument],
        span: Span,
        cx: &mut Context,
    ) -> Expr {
        self.felt(("sensor", &sense.name, sense.of.as_ref(), &sense.ty), arguments, span, cx)
    }

    /// What the robot remembers, or a part where parts have a state each.
    pub(super) fn remembered(
        &mut self,
        of_body: &ast::BodyState,
        arguments: &[ast::Argument],
        span: Span,
        cx: &mut Context,
    ) -> Expr {
        let ast::BodyState { of, state } = of_body;
        // What reads it is driven by the shared variables that it comes from.
        self.read.insert(state.name.span);
        self.felt(("state", &state.name, of.as_ref(), &state.ty), arguments, span, cx)
    }

    /// What a sensor or a state is, of which the robot or each part of a kind has one.
    fn felt(
        &mut self,
        (what, own, of, ty): (&str, &ast::Name, Option<&(ast::Name, ast::Name)>, &ast::Name),
        arguments: &[ast::Argument],
        span: Span,
        cx: &mut Context,
    ) -> Expr {
        let unknown = Expr { kind: ExprKind::Bool(false), ty: Ty::Unknown, span };
        let name = &own.text;
        if cx.stage != Stage::Drive {
            return self.stage_error(span, name, cx.stage, &format!("actuations and states, as a {what}"));
        }
        let ty = self.type_named(ty);
        let usage = match of {
            Some((binder, _)) => format!("{name}({})", binder.text),
            None => name.clone(),
        };
        let wanted = usize::from(of.is_some());
        if arguments.len() != wanted || arguments.iter().any(|a| a.name.is_some()) {
            self.report(
                Diagnostic::new(
                    Code::WRONG_ARGUMENTS,
                    span,
                    format!("the {what} `{name}` is read as `{usage}`"),
                )
                .label(given(arguments))
                .also(own.span, "declared here")
                .help(match wanted {
                    0 => "the robot has only one: write its name alone",
                    _ => "each part of its kind has one: name the part, as in `(a)`",
                }),
            );
            return unknown;
        }
        let of = arguments
            .first()
            .map(|argument| self.expect(&argument.value, cx, &Ty::Part, &format!("whose `{name}` is read")));
        if of.as_ref().is_some_and(|of| of.ty == Ty::Unknown) || ty == Ty::Unknown {
            return unknown;
        }
        Expr { kind: ExprKind::Sensor(name.clone(), of.map(Box::new)), ty, span }
    }

    /// A curve, pattern or table that is asked for a value.
    fn applied(
        &mut self,
        callee: &ast::Expr,
        arguments: &[ast::Argument],
        span: Span,
        cx: &mut Context,
    ) -> Expr {
        let unknown = Expr { kind: ExprKind::Bool(false), ty: Ty::Unknown, span };
        let curve = self.infer(callee, cx);
        let mut asked = Dimension::NUMBER;
        let ty = match &curve.ty {
            Ty::Table(from, to) => {
                asked = *from;
                Ty::Quantity(*to)
            }
            Ty::Curve(d) => Ty::Quantity(*d),
            Ty::Pattern => Ty::Quantity(Dimension::ANGLE),
            Ty::Unknown => {
                // What it is given is read all the same.
                for argument in arguments {
                    self.infer(&argument.value, cx);
                }
                return unknown;
            }
            other => {
                let message = format!("{} cannot be called", super::fit::article(other));
                let help = match other {
                    Ty::List(_) => {
                        "write the number of the item in square brackets, counted from 0: `points[1]`"
                    }
                    Ty::Port => "write the number of the port in square brackets: `core.site[1]`",
                    Ty::Track(_) => {
                        "give a time with `at`, in brackets where more follows: `(core.position at end).z`"
                    }
                    _ => "to multiply, write `*`",
                };
                self.report(
                    Diagnostic::new(Code::WRONG_TYPE, callee.span, message)
                        .label("not a function, curve, pattern or table")
                        .help(help),
                );
                return unknown;
            }
        };
        let [ast::Argument { name: None, value }] = arguments else {
            self.report(
                Diagnostic::new(
                    Code::WRONG_ARGUMENTS,
                    span,
                    if matches!(curve.ty, Ty::Table(..)) {
                        "a table takes one argument: the value to look up"
                    } else {
                        "a curve takes one argument: the place in its cycle, from 0 to 1"
                    },
                )
                .label("not one argument"),
            );
            return unknown;
        };
        let what = if matches!(curve.ty, Ty::Table(..)) {
            "the argument of a table"
        } else {
            "the place in a cycle"
        };
        let place = self.expect(value, cx, &Ty::Quantity(asked), what);
        Expr { kind: ExprKind::Apply(Box::new(curve), Box::new(place)), ty, span }
    }

    /// Everything that can be called: functions, and the parts and patterns of the module.
    fn callable(&self, place: Span) -> Vec<&str> {
        use ItemKind as K;
        let own = self.guessable(place).filter(|(_, i)| {
            let function = matches!(i.kind, K::Let(_, Some(_), _) | K::Record(..));
            function
                || matches!(
                    i.kind,
                    K::Block(BlockKind::Part | BlockKind::Actuator | BlockKind::Cell, _) | K::Pattern(..)
                )
        });
        Function::ALL.iter().map(|f| f.text()).chain(own.map(|(n, _)| n)).collect()
    }

    /// `bender(segments = n)`: a kind with parameters.
    fn kind_with(
        &mut self,
        name: &str,
        item: &ast::Item,
        arguments: &[ast::Argument],
        span: Span,
        cx: &mut Context,
    ) -> Expr {
        let params = match &item.kind {
            ItemKind::Block(BlockKind::Part | BlockKind::Actuator | BlockKind::Cell, block) => {
                self.params_of(block)
            }
            _ => Vec::new(),
        };
        let given = self.params_given(name, &params, &[item], arguments, cx);
        Expr { kind: ExprKind::Kind(name.to_owned(), given), ty: Ty::Kind, span }
    }

    /// `what(level = 2)`: a kind that was chosen, with the parameters that all that it may be share.
    fn chosen_with(
        &mut self,
        name: &str,
        kind: Expr,
        local: Span,
        arguments: &[ast::Argument],
        span: Span,
        cx: &mut Context,
    ) -> Expr {
        let kinds = self.chosen.get(&local).cloned().unwrap_or_default();
        let program = self.environment.program;
        let items: Vec<&ast::Item> =
            kinds.iter().filter_map(|(kind, place)| Some(program.lookup(*place, kind)?.1)).collect();
        let mut shared: Option<Vec<(String, Ty)>> = None;
        for item in &items {
            let ItemKind::Block(_, block) = &item.kind else { continue };
            let params = self.params_of(block);
            shared = Some(match shared {
                Some(shared) => shared.into_iter().filter(|param| params.contains(param)).collect(),
                None => params,
            });
        }
        let given = self.params_given(name, &shared.unwrap_or_default(), &items, arguments, cx);
        Expr { kind: ExprKind::With(Box::new(kind), given), ty: Ty::Kind, span }
    }

    /// The parameters that are given to a kind of part, or to what `items` have in common.
    fn params_given(
        &mut self,
        name: &str,
        params: &[(String, Ty)],
        items: &[&ast::Item],
        arguments: &[ast::Argument],
        cx: &mut Context,
    ) -> Vec<(String, Expr)> {
        let mut given: Vec<(String, Expr)> = Vec::new();
        for argument in arguments {
            let Some(key) = &argument.name else {
                self.report(
                    Diagnostic::new(
                        Code::WRONG_ARGUMENTS,
                        argument.value.span,
                        "parameters of a part are given by name",
                    )
                    .label("which parameter?")
                    .help_if(params.first().map(|(n, _)| format!("write `{name}({n} = ...)`"))),
                );
                continue;
            };
            let Some((_, ty)) = params.iter().find(|(n, _)| *n == key.text) else {
                // A declaration that misspells it is told there.
                let is_told = key.text == "segments" && params.iter().any(|(n, _)| misspells_segments(n));
                if is_told || self.is_lost(key.span, &key.text) {
                    continue;
                }
                let help = did_you_mean(&key.text, params.iter().map(|(n, _)| n.as_str())).or_else(|| {
                    let names: Vec<&str> = params.iter().map(|(n, _)| n.as_str()).collect();
                    Some(if names.is_empty() && items.len() > 1 {
                        "its possible kinds have no parameter in common: choose among kinds that do, or leave the parameter out"
                            .to_owned()
                    } else if names.is_empty() {
                        format!("it has no parameters: write `{name}` alone")
                    } else {
                        format!("it has: {}", names.join(", "))
                    })
                });
                self.report(
                    Diagnostic::new(
                        Code::UNKNOWN_FIELD,
                        key.span,
                        format!("`{name}` has no parameter `{}`", key.text),
                    )
                    .label("not a parameter")
                    .help_if(help)
                    .fix_if(respell(
                        key.span,
                        &key.text,
                        params.iter().map(|(n, _)| n.as_str()),
                    )),
                );
                continue;
            };
            if given.iter().any(|(n, _)| *n == key.text) {
                self.given_twice(arguments, key);
                continue;
            }
            let value = self.expect(&argument.value, cx, &ty.clone(), &format!("`{}`", key.text));
            items.iter().for_each(|item| self.check_instance_domain(item, &key.text, &value));
            given.push((key.text.clone(), value));
        }
        given
    }

    /// Where one argument lacks a unit and another has one, that is the unit to write.
    pub(super) fn unit_of_others(&mut self, known: usize, arguments: &[Expr]) {
        for mut error in self.errors.split_off(known) {
            if error.code == Code::MISSING_UNIT && error.fix.is_none() {
                let others = arguments.iter().filter(|a| a.span != error.span());
                let unit = others.filter_map(|a| self.unit_beside(a.ty.dimension()?, Some(a))).next();
                if let Some(unit) = unit.filter(|u| !u.is_empty()) {
                    error.help =
                        Some(format!("write `{} {unit}`", self.environment.sources.slice(error.span())));
                }
            }
            self.errors.add(error);
        }
    }

    /// A second value under one name.
    pub(in crate::types) fn given_twice(&mut self, arguments: &[ast::Argument], key: &ast::Name) {
        let mut names = arguments.iter().filter_map(|a| a.name.as_ref());
        let first = names.find(|n| n.text == key.text).map_or(key.span, |n| n.span);
        self.report(
            Diagnostic::new(Code::DUPLICATE, key.span, format!("`{}` is given twice", key.text))
                .label("again")
                .also(first, "first given here")
                .help("keep one of them"),
        );
    }

    /// `limit(3 cm)`: a function that the grammar declares. Its body is checked
    /// where it is called, because what it may read depends on the stage there.
    fn own_function(
        &mut self,
        function: &Declared<'_>,
        arguments: &[ast::Argument],
        span: Span,
        cx: &mut Context,
    ) -> Expr {
        let unknown = Expr { kind: ExprKind::Bool(false), ty: Ty::Unknown, span };
        let usage = || {
            let words: Vec<&str> = function.parameters.iter().map(|p| p.name.text.as_str()).collect();
            format!("{}({})", function.name.text, words.join(", "))
        };
        if arguments.len() != function.parameters.len() || arguments.iter().any(|a| a.name.is_some()) {
            let message = format!("wrong arguments: `{}` is called as `{}`", function.name.text, usage());
            self.report(
                Diagnostic::new(Code::WRONG_ARGUMENTS, span, message)
                    .label(given(arguments))
                    .also(function.name.span, "declared here")
                    .help("give one value for each parameter, in their order and without names"),
            );
            return unknown;
        }
        if self.open_functions.contains(&function.declaration) {
            self.circle(function.declaration, span);
            return unknown;
        }
        // The body sees its parameters and the names of its own text, not the locals of the caller.
        let mut inner = Context::new(cx.stage, cx.damaged);
        inner.locals = cx.locals.iter().map(Local::hidden).collect();
        let mut bound = Vec::new();
        for (parameter, argument) in function.parameters.iter().zip(arguments) {
            let ty = self.type_named(&parameter.ty);
            let what = format!("`{}` of `{}`", parameter.name.text, function.name.text);
            let mut outside = cx.clone();
            // Earlier arguments take slots of their own.
            outside.locals.extend(inner.locals.iter().skip(cx.locals.len()).map(Local::hidden));
            let value = self.expect(&argument.value, &mut outside, &ty, &what);
            bound.push((inner.locals.len(), value));
            self.bind_parameter(&parameter.name, ty, &mut inner);
        }
        // After its arguments: what is called in these is no part of it.
        if self.open_functions.is_empty() {
            self.written.begin(None);
        }
        if !self.written.call(function.declaration, &function.name.text, span) {
            self.tell_too_large();
            return unknown;
        }
        let known = self.errors.len();
        self.open_functions.push(function.declaration);
        self.open.push(function.declaration);
        let body = self.infer(function.body, &mut inner);
        self.open.pop();
        self.open_functions.pop();
        let fits = self.written.end(&function.name.text, span, super::nodes(&body));
        if self.open_functions.is_empty() {
            self.blame_the_call(known, &function.name.text, span);
            self.tell_too_large();
        }
        if !fits {
            return unknown;
        }
        if let Some((_, value)) = bound.iter().find(|(_, value)| reads_motion(value))
            && body.any(&mut |e| matches!(e.kind, ExprKind::Scenarios(_)))
        {
            self.report(
                Diagnostic::new(
                    Code::OTHER_WORLDS,
                    value.span,
                    format!(
                        "`{}` runs over worlds, but this argument belongs to the nominal world",
                        function.name.text
                    ),
                )
                .label("it would have the same value in each world")
                .help("write the body of the function here, or let the function read the term itself"),
            );
            return unknown;
        }
        let ty = body.ty.clone();
        let whole = bound.into_iter().rev().fold(body, |body, (slot, value)| Expr {
            ty: ty.clone(),
            span,
            kind: ExprKind::Bind { slot, value: Box::new(value), body: Box::new(body) },
        });
        Expr { span, ..whole }
    }

    /// A function may read what only some stages know: a call in another one is what is wrong.
    fn blame_the_call(&mut self, known: usize, name: &str, call: Span) {
        for error in self.errors.split_off(known) {
            if error.code != Code::WRONG_STAGE {
                self.errors.add(error);
                continue;
            }
            let message = format!("`{name}` cannot be called here: in its definition, {}", error.message);
            let blamed = Diagnostic::new(Code::WRONG_STAGE, call, message)
                .label("called here")
                .also(error.span(), "read here")
                .help_if(error.help);
            self.errors.add(blamed);
        }
    }

    /// Reports what is too large, unless a function's body is only tried in a stage: see [`Self::own_body`].
    pub(super) fn tell_too_large(&mut self) {
        if self.open_functions.is_empty() {
            for found in self.written.found() {
                self.report(found);
            }
        }
    }

    /// `grip(force = 2 N, width = 3 mm)`: a record with a value for each field that has no default.
    fn record(
        &mut self,
        (name, place): (&ast::Name, Span),
        (declaration, declared): (Declaration, &[ast::RecordField]),
        arguments: &[ast::Argument],
        span: Span,
        cx: &mut Context,
    ) -> Expr {
        let unknown = Expr { kind: ExprKind::Bool(false), ty: Ty::Unknown, span };
        let ty = self.type_named(&ast::Name { text: name.text.clone(), span: place });
        let Ty::Record(_, fields) = &ty else { return unknown };
        let mut values: Vec<Option<Expr>> = vec![None; fields.len()];
        for argument in arguments {
            let key = argument.name.as_ref();
            let index = key.and_then(|k| fields.iter().position(|(n, _)| *n == k.text));
            let (Some(key), Some(index)) = (key, index) else {
                let place = key.map_or(argument.value.span, |k| k.span);
                let names: Vec<&str> = fields.iter().map(|(n, _)| n.as_str()).collect();
                let help = key.and_then(|k| did_you_mean(&k.text, names.iter().copied()));
                let what = key.map_or("a field without a name".to_owned(), |k| format!("`{}`", k.text));
                self.report(
                    Diagnostic::new(Code::UNKNOWN_FIELD, place, format!("`{}` has no {what}", name.text))
                        .label("not a field")
                        .help(help.unwrap_or_else(|| format!("it has: {}", names.join(", ")))),
                );
                continue;
            };
            let Some((_, wanted)) = fields.get(index) else { continue };
            let value = self.expect(&argument.value, cx, wanted, &format!("`{}`", key.text));
            let Some(slot) = values.get_mut(index) else { continue };
            if slot.replace(value).is_some() {
                self.given_twice(arguments, key);
            }
        }
        // A field that is there under another name is not missing, too.
        if arguments
            .iter()
            .any(|a| !a.name.as_ref().is_some_and(|k| fields.iter().any(|(n, _)| *n == k.text)))
        {
            return unknown;
        }
        let mut complete = Vec::new();
        for (i, (value, (field, ty))) in values.into_iter().zip(fields).enumerate() {
            let default = |own: &mut Self| own.default_of(declaration, declared.get(i)?, ty);
            match value.or_else(|| default(self)) {
                Some(value) => complete.push(value),
                None => {
                    self.report(
                        Diagnostic::new(
                            Code::MISSING_FIELD,
                            span,
                            format!("`{}` lacks `{field}`", name.text),
                        )
                        .label("incomplete")
                        .help(format!("add `{field} = ...`")),
                    );
                    return unknown;
                }
            }
        }
        Expr { kind: ExprKind::List(complete), ty, span }
    }

    /// `3,5 cm` among arguments, which reads as two of them.
    pub(super) fn decimal_comma(&self, arguments: &[ast::Argument]) -> Option<String> {
        let numbers = arguments.windows(2).find_map(|pair| match pair {
            [a, b] if b.value.span.start == a.value.span.end + 1 => {
                let (a, b) = (
                    self.environment.sources.slice(a.value.span),
                    self.environment.sources.slice(b.value.span),
                );
                let digits =
                    a.bytes().all(|c| c.is_ascii_digit()) && b.starts_with(|c: char| c.is_ascii_digit());
                digits.then_some((a, b))
            }
            _ => None,
        });
        numbers.map(|(a, b)| format!("a decimal number is written with a point: `{a}.{b}`"))
    }
}

/// Whether an expression reads a motion: in another world it may have another value.
fn reads_motion(expr: &Expr) -> bool {
    expr.any(&mut |e| match &e.kind {
        ExprKind::Term(_) | ExprKind::At(..) | ExprKind::Word(Word::Motion(_)) => true,
        ExprKind::Attribute(_, attribute) => matches!(
            attribute,
            Attribute::Element(_) | Attribute::Track(_) | Attribute::Part(PartAttribute::Work)
        ),
        _ => false,
    })
}

/// Whether a parameter is meant to be the number of segments.
pub(in crate::types) fn misspells_segments(name: &str) -> bool {
    name != "segments" && nearest(name, ["segments"]).is_some()
}
