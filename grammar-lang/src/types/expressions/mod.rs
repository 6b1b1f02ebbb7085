//! Expressions: what they are of, whether that fits, and what they come to.
//!
//! This knows no declaration but those that an expression can name: constants, parameters,
//! functions, tables, types. Whoever checks another one asks here.

pub(in crate::types) mod call;
mod cases;
mod cells;
pub(super) mod context;
mod expr;
pub(super) mod fit;
mod function;
mod members;
mod mend;
mod named_types;
pub(super) mod names;
mod of_kinds;
mod own_fields;
mod shared;
mod signature;
pub(super) mod stage;
mod table;
pub(super) mod task;
mod written_out;

use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};

use indexmap::{IndexMap, IndexSet};

use super::environment::Environment;
use super::found::Found;
use crate::diagnostics::{Code, Diagnostic};
use crate::eval::{Allowance, Budget, EvalError, Scope, Value, order};
use crate::ir::{self, Expr, Ty};
use crate::names::{Declaration, declared};
use crate::source::Span;
use crate::syntax::ast;
use crate::syntax::ast::{Item, ItemKind, Name};
use crate::syntax::declarations::BlockKind;
use crate::units::{self, Dimension};
use context::Context;
pub(in crate::types) use named_types::is_type;
use stage::Stage;
use written_out::WrittenOut;

/// How many constants may build on each other.
const DEEPEST: usize = 100;

/// How many operations a function, or a constant that is no number, may have when it is written out.
const LARGEST: usize = 10_000;
/// A field of a part with more pieces than this cannot be read by others: it would be put in their place each time.
const LARGEST_FIELD: usize = 500;

/// Of how many pieces an expression is made.
fn nodes(expr: &Expr) -> usize {
    let mut count = 0;
    expr.any(&mut |_| {
        count += 1;
        false
    });
    count
}

/// What constant expressions can read: the parameters of the grammar.
#[derive(Default)]
struct Constants {
    params: IndexMap<String, Value>,
}

/// What is worked out before anything runs, with its bound.
struct Working {
    constants: Constants,
    allowance: Allowance,
    /// Whether it was told that nothing more is worked out.
    is_told: bool,
}

impl Working {
    fn value(&self, expr: &Expr, locals: &mut Vec<Value>) -> Result<Value, EvalError> {
        self.allowance.evaluate(expr, &self.constants, locals)
    }
}

impl Scope for Constants {
    fn outer(&self) -> Option<&dyn Scope> {
        None
    }
    fn param(&self, name: &str) -> Option<Value> {
        self.params.get(name).cloned()
    }
}

/// How far the check of a parameter is.
#[derive(Clone)]
enum CheckedParam {
    /// It has begun: whoever asks now goes round in a circle.
    Open,
    /// It found an error, which has been reported.
    Wrong,
    /// It is complete.
    Right(ir::Param),
}

/// Checks expressions, and what they read: constants, parameters, functions, types.
pub(super) struct Expressions<'a> {
    pub(super) environment: &'a Environment<'a>,
    /// All that was found so far.
    pub(super) errors: Found,
    /// Every parameter that some actuator of the program has, once that was asked.
    instance_params: Option<InstanceParams>,
    /// The kind of part that a local was matched as, by where the local is declared.
    pub(in crate::types) matched: BTreeMap<Span, String>,
    /// Where the names are bound of parts that rules make and that are actuators in any case.
    pub(in crate::types) actuators_made: BTreeSet<Span>,
    /// The kinds of parts that a local was chosen from, by where the local is declared.
    chosen: BTreeMap<Span, IndexMap<String, Span>>,
    /// Records whose types are known.
    records: BTreeMap<Declaration, Ty>,
    /// Declarations that something reads, in the order of reading.
    pub(super) touched: IndexSet<Declaration>,
    /// Parameters that are being checked or have been.
    params: BTreeMap<Declaration, CheckedParam>,
    /// Named constants that have been checked, and fields of models by their names; `None` while they are.
    inlined: BTreeMap<(Declaration, String), Option<Expr>>,
    /// Fields of parts that others of the same part read, by where they are written.
    own_fields: BTreeMap<Span, Expr>,
    /// The types of values that read shared variables.
    shared_types: BTreeMap<Declaration, Ty>,
    /// Whether an expression is being checked, so that what is checked now is a piece of it.
    inside: bool,
    /// Where names of rules and actuations are bound that something reads.
    pub(super) read: IndexSet<Span>,
    /// Constants, parameters and functions that are being checked, outermost first.
    open: Vec<Declaration>,
    /// How many of them are being checked.
    open_constants: usize,
    /// Functions whose bodies are being checked, outermost first.
    open_functions: Vec<Declaration>,
    /// Whether a body is tried in a stage, with no actuation around it: see [`Self::own_body`].
    tries_a_body: bool,
    written: WrittenOut,
    working: Working,
    /// How many more names misspelt ones may be compared with.
    guesses: Cell<usize>,
}

/// With how many names of some eight letters misspelt ones are compared in one check. Guessing takes as long as there are
/// names, for every error anew: a text that is wrong throughout gets no guesses at its end.
const GUESSES: usize = 1_000_000;

impl<'a> Expressions<'a> {
    /// Begins with what was found so far.
    pub(super) fn new(environment: &'a Environment<'a>, errors: Found, budget: &Budget) -> Self {
        Self {
            environment,
            errors,
            instance_params: None,
            matched: BTreeMap::new(),
            actuators_made: BTreeSet::new(),
            chosen: BTreeMap::new(),
            records: BTreeMap::new(),
            touched: IndexSet::new(),
            params: BTreeMap::new(),
            inlined: BTreeMap::new(),
            own_fields: BTreeMap::new(),
            shared_types: BTreeMap::new(),
            inside: false,
            read: IndexSet::new(),
            open: Vec::new(),
            open_constants: 0,
            open_functions: Vec::new(),
            tries_a_body: false,
            written: WrittenOut::default(),
            working: Working {
                constants: Constants::default(),
                allowance: Allowance::of_check(budget),
                is_told: false,
            },
            guesses: Cell::new(GUESSES),
        }
    }

    /// The parameters without errors by name, as they are declared.
    pub(super) fn parameters(&self) -> IndexMap<String, ir::Param> {
        let named = self.params.iter().filter_map(|(declaration, param)| {
            let name = self.environment.program.item(*declaration).and_then(declared)?;
            match param {
                CheckedParam::Right(param) => Some((name.text.clone(), param.clone())),
                CheckedParam::Open | CheckedParam::Wrong => None,
            }
        });
        let mut all: IndexMap<String, ir::Param> = named.collect();
        all.sort_by(|a, x, b, y| x.span.cmp(&y.span).then(a.cmp(b)));
        all
    }

    /// The names of all parameters.
    pub(super) fn parameter_names(&self) -> Vec<&'a str> {
        let program = self.environment.program;
        let names = self.params.keys().filter_map(|d| Some(declared(program.item(*d)?)?.text.as_str()));
        names.collect()
    }

    /// The names at a place that a misspelt one may have been meant to be.
    pub(super) fn guessable(&self, place: Span) -> impl Iterator<Item = (&str, &Item)> {
        // Comparing takes as long as the length of both words multiplied.
        let length = place.range().len() / 8;
        let each = (length * length).max(1);
        let all = self.environment.program.known_at(place).saturating_mul(each);
        let left = self.guesses.get().checked_sub(all);
        self.guesses.set(left.unwrap_or(self.guesses.get()));
        left.into_iter().flat_map(move |_| self.environment.program.scope_at(place))
    }

    /// The value of an expression that must be known before anything runs.
    pub(super) fn constant(&mut self, expr: &Expr) -> Option<Value> {
        self.constant_with(expr, &mut Vec::new())
    }

    /// The same with values for the first locals.
    pub(super) fn constant_with(&mut self, expr: &Expr, locals: &mut Vec<Value>) -> Option<Value> {
        if expr.any(&mut |e| e.ty == Ty::Unknown) {
            return None;
        }
        if let Some((name, span)) = expr.of_body() {
            let (name, span) = (name.to_owned(), span);
            self.tell_of_body(&name, span, "before there is a body");
            return None;
        }
        match self.working.value(expr, locals) {
            Ok(value) => Some(value),
            // Once is enough.
            Err(_) if self.working.is_told => None,
            Err(error) => {
                self.working.is_told = self.working.allowance.spent().is_some();
                self.report(
                    Diagnostic::new(Code::BAD_VALUE, error.span, "this has no usable value")
                        .label(error.reason)
                        .help("it is computed before the run starts: change the values that it depends on"),
                );
                None
            }
        }
    }

    pub(super) fn constant_number(&mut self, expr: &Expr) -> Option<f64> {
        self.constant(expr)?.as_number()
    }

    /// The same without a report.
    pub(super) fn quiet_number(&self, expr: &Expr) -> Option<f64> {
        if expr.any(&mut |e| e.ty == Ty::Unknown) {
            return None;
        }
        self.working.value(expr, &mut Vec::new()).ok()?.as_number()
    }

    /// The ends of a constant domain, low before high.
    pub(super) fn constant_range(&mut self, expr: &Expr) -> Option<(f64, f64)> {
        let ends = match &expr.kind {
            ir::ExprKind::Range(low, high) => (self.constant_number(low)?, self.constant_number(high)?),
            _ if expr.ty == Ty::Unknown => return None,
            ir::ExprKind::If(..) => {
                self.report(
                    Diagnostic::new(Code::WRONG_TYPE, expr.span, "a range is needed here, not a choice of ranges")
                        .label("two ranges")
                        .help("write `LEAST .. GREATEST`, and let each of them choose: `(if ... then ... else ...)`"),
                );
                return None;
            }
            _ => {
                self.report(
                    Diagnostic::new(Code::WRONG_TYPE, expr.span, "a range is needed here, not a set")
                        .label("single values")
                        .help("write `LEAST .. GREATEST`"),
                );
                return None;
            }
        };
        (ends.0 <= ends.1).then_some(ends)
    }

    /// A named constant, put in the place of its name.
    pub(super) fn inline(&mut self, declaration: Declaration, value: &ast::Expr) -> Expr {
        self.inline_field(declaration, "", value)
    }

    /// The same for a field of a model, whose name is given.
    pub(super) fn inline_field(&mut self, declaration: Declaration, field: &str, value: &ast::Expr) -> Expr {
        let unknown = Expr { kind: ir::ExprKind::Bool(false), ty: Ty::Unknown, span: value.span };
        let key = (declaration, field.to_owned());
        if let Some(done) = self.inlined.get(&key) {
            if let Some(done) = done {
                return done.clone();
            }
            self.circle(declaration, value.span);
            return unknown;
        }
        if self.open_constants >= DEEPEST {
            self.tell_too_deep(value.span);
            return unknown;
        }
        self.inlined.insert(key.clone(), None);
        self.open.push(declaration);
        self.open_constants += 1;
        let mut cx = Context::new(Stage::Declaration, false);
        let inside = std::mem::take(&mut self.inside);
        let mut expr = self.infer(value, &mut cx);
        self.inside = inside;
        self.open.pop();
        self.open_constants -= 1;
        // A constant is worked out once, or constants of constants would grow without bound.
        if expr.ty.dimension().is_some() && expr.of_body().is_none() {
            match self.constant_number(&expr) {
                Some(x) => expr.kind = ir::ExprKind::Number(x),
                None => expr = unknown.clone(),
            }
        } else if nodes(&expr) > LARGEST {
            self.report(
                Diagnostic::new(Code::TOO_DEEP, value.span, "this constant is too large")
                    .label("it has too many operations"),
            );
            expr = unknown.clone();
        }
        self.inlined.insert(key, Some(expr.clone()));
        expr
    }

    /// Reports a parameter that rules set, where there is no body that has a value of it.
    pub(super) fn tell_of_body(&mut self, name: &str, span: Span, here: &str) {
        let mut error = Diagnostic::new(
            Code::WRONG_STAGE,
            span,
            format!("`{name}` has no value {here}: rules set it, so each body has its own"),
        )
        .label("set by a rule")
        .help("fields of parts, rules, requirements, terms and drives can read it; here, read another parameter");
        let mut places = self.environment.set_by_rules.iter();
        let is_this = |declaration: &Declaration| {
            let item = self.environment.program.item(*declaration).and_then(declared);
            item.is_some_and(|declared| declared.text == name)
        };
        if let Some((_, place)) = places.find(|(declaration, _)| is_this(declaration)) {
            error = error.also(*place, "set here");
        }
        self.report(error);
    }

    fn tell_too_deep(&mut self, span: Span) {
        let message = format!("more than {DEEPEST} constants build on each other");
        self.report(
            Diagnostic::new(Code::TOO_DEEP, span, message)
                .label("too deep")
                .help("declare them in another order, or fewer of them"),
        );
    }

    /// Reports what is defined by itself, with the others that the circle goes through.
    fn circle(&mut self, declaration: Declaration, span: Span) {
        let mut error = Diagnostic::new(Code::BAD_VALUE, span, "this is defined in terms of itself")
            .label("its value depends on its own value")
            .help("a definition cannot use itself, not even indirectly: give one of them a value of its own");
        let others = self.open.iter().rev().take_while(|open| **open != declaration);
        let others: Vec<Declaration> = others.copied().collect();
        for other in others.iter().rev().filter_map(|d| self.environment.program.item(*d).and_then(declared))
        {
            error = error.also(other.span, "through this");
        }
        self.report(error);
    }

    /// A parameter of the grammar with its value in force.
    pub(super) fn param(&mut self, declaration: Declaration) -> Option<ir::Param> {
        let program = self.environment.program;
        let ItemKind::Param(param) = &program.item(declaration)?.kind else { return None };
        match self.params.get(&declaration) {
            Some(CheckedParam::Right(done)) => return Some(done.clone()),
            Some(CheckedParam::Wrong) => return None,
            Some(CheckedParam::Open) => {
                self.circle(declaration, param.name.span);
                return None;
            }
            None => {}
        }
        self.params.insert(declaration, CheckedParam::Open);
        let inside = std::mem::take(&mut self.inside);
        self.open.push(declaration);
        let mut checked = self.check_param(param);
        if let Some(checked) = &mut checked {
            checked.set_by_rules = self.environment.set_by_rules.contains_key(&declaration);
        }
        self.open.pop();
        self.inside = inside;
        let state = match &checked {
            Some(checked) => {
                self.alone(declaration, &param.name);
                self.working.constants.params.insert(param.name.text.clone(), checked.in_force());
                CheckedParam::Right(checked.clone())
            }
            None => CheckedParam::Wrong,
        };
        self.params.insert(declaration, state);
        checked
    }

    /// Reports a parameter where another has its name, in a text that is read only through what it says of others: both would be one.
    fn alone(&mut self, declaration: Declaration, name: &Name) {
        if !self.working.constants.params.contains_key(&name.text) {
            return;
        }
        let program = self.environment.program;
        // Two in one text are told anyway.
        let others = self.params.keys().filter(|other| other.module != declaration.module);
        let names = others.filter_map(|other| declared(program.item(*other)?));
        let Some(other) = names.into_iter().find(|other| other.text == name.text).map(|other| other.span)
        else {
            return;
        };
        self.report(
            Diagnostic::new(
                Code::DUPLICATE,
                name.span,
                format!("two parameters of this grammar are called `{}`", name.text),
            )
            .label("one")
            .also(other, "the other")
            .help("give one of them another name: a parameter is set and shown by its name alone"),
        );
    }

    /// Says of a parameter that is declared as a Number, with a domain or a value that has a unit, what it must be declared as.
    fn declared_as_number(&mut self, param: &ast::Param, ty: &Ty, cx: &mut Context) -> Option<Diagnostic> {
        let given = param.domain.as_ref().or(param.default.as_ref()).filter(|_| *ty == Ty::NUMBER)?;
        let known = self.errors.len();
        let found = self.infer(given, cx).ty;
        self.errors.split_off(known);
        let quantity = match found {
            Ty::Domain(of) => *of,
            other => other,
        };
        let is_quantity = quantity.dimension().is_some_and(|dimension| !dimension.is_number());
        is_quantity.then(|| {
            let what = if param.domain.is_some() { "domain" } else { "value" };
            let name = &param.name.text;
            Diagnostic::new(
                Code::WRONG_DIMENSION,
                param.ty.span,
                format!("`{name}` is declared as a Number, but its {what} is {}", fit::article(&quantity)),
            )
            .label("a Number has no unit")
            .also(given.span, fit::article(&quantity))
            .help(format!("declare it as `{name} : {quantity}`"))
        })
    }

    fn check_param(&mut self, param: &ast::Param) -> Option<ir::Param> {
        let ty = self.type_named(&param.ty);
        if ty.dimension().is_none() && !matches!(ty, Ty::Bool | Ty::Enum(_) | Ty::Unknown) {
            self.report(
                Diagnostic::new(
                    Code::WRONG_TYPE,
                    param.ty.span,
                    "a parameter must be a quantity, a Count, a Bool or a value of an enumeration",
                )
                .label(format!("this is {}", fit::article(&ty)))
                .help("declare a value of any other type with `let`"),
            );
            return None;
        }
        let mut cx = Context::new(Stage::Declaration, false);
        if let Some(error) = self.declared_as_number(param, &ty, &mut cx) {
            self.report(error);
            return None;
        }
        let domain = param.domain.as_ref().and_then(|d| {
            let domain =
                self.expect(d, &mut cx, &Ty::Domain(Box::new(ty.clone())), "the domain of a parameter");
            self.constant_range(&domain)
        });
        let what = format!("`{}`", param.name.text);
        let mut given = None;
        for (name, text) in self.environment.overrides {
            if *name == param.name.text {
                given = Some(text.clone());
            }
        }
        let is_given = given.is_some();
        let (value, span) = match (given, &param.default) {
            (Some(text), _) => (self.outside_value(&text, &ty, param)?, param.name.span),
            (None, Some(default)) => {
                let span = default.span;
                let default = self.expect(default, &mut cx, &ty, &what);
                match self.constant(&default)? {
                    Value::Number(x) => (x, span),
                    Value::Bool(x) => (f64::from(u8::from(x)), span),
                    _ => return None,
                }
            }
            (None, None) => {
                self.report(
                    Diagnostic::new(Code::MISSING_FIELD, param.name.span, format!("{what} has no value"))
                        .label("no default")
                        .help(format!(
                            "write `= VALUE` after it, or run with `-p {}=VALUE`",
                            param.name.text
                        )),
                );
                return None;
            }
        };
        if let Some((low, high)) = domain
            && !order::is_within(low, value, high)
        {
            self.report(
                Diagnostic::new(Code::OUT_OF_DOMAIN, span, format!("{what} is outside its domain"))
                    .label(format!(
                        "{} is not within {} .. {}",
                        shown(value, &ty),
                        shown(low, &ty),
                        shown(high, &ty)
                    ))
                    .help("choose a value inside, or widen the domain")
                    .also(param.domain.as_ref().map_or(param.name.span, |d| d.span), "the domain"),
            );
            return None;
        }
        Some(ir::Param { ty, domain, value, set_by_rules: false, given: is_given, span: param.name.span })
    }

    /// Reads the value of `-p NAME=VALUE`.
    fn outside_value(&mut self, text: &str, ty: &Ty, param: &ast::Param) -> Option<f64> {
        let trimmed = text.trim();
        let value = match (ty, trimmed) {
            (Ty::Bool, "true") => Some(1.0),
            (Ty::Bool, "false") => Some(0.0),
            (Ty::Bool, _) => None,
            (Ty::Enum(name), text) => {
                // As in a grammar, too: `Surface.sand`.
                let own = text.strip_prefix(name.as_str()).and_then(|rest| rest.strip_prefix('.'));
                let text = own.unwrap_or(text);
                self.variants_of(name, param.ty.span).iter().position(|v| v == text).map(|i| i as f64)
            }
            _ => {
                let split = digits(trimmed);
                let (number, unit) = trimmed.split_at(split);
                let unit = unit.trim();
                let unit = if unit.is_empty() {
                    Some((Dimension::NUMBER, 1.0))
                } else {
                    crate::units::parse(unit).ok().map(|u| (u.dimension, u.factor))
                };
                match (number.parse::<f64>(), unit) {
                    (Ok(x), Some((d, factor)))
                        if (x * factor).abs() <= units::LARGEST
                            && Some(d) == ty.dimension()
                            && (*ty != Ty::Count || x.fract() == 0.0) =>
                    {
                        Some(x * factor)
                    }
                    _ => None,
                }
            }
        };
        if value.is_none() {
            let usual = param.default.as_ref().map(|default| self.environment.sources.slice(default.span));
            let is_plain = |text: &&str| text.starts_with(|c: char| c.is_ascii_digit());
            let example = match ty {
                ty if ty.dimension().is_some() && usual.filter(is_plain).is_some() => {
                    let usual = usual.unwrap_or_default();
                    if usual.contains(' ') { format!("\"{usual}\"") } else { usual.to_owned() }
                }
                Ty::Bool => "true".to_owned(),
                Ty::Enum(name) => self.variants_of(name, param.ty.span).join("|"),
                Ty::Count => "3".to_owned(),
                ty => format!("\"1 {}\"", ty.dimension().map(crate::units::suggest).unwrap_or_default()),
            };
            self.report(
                Diagnostic::new(
                    Code::WRONG_TYPE,
                    param.name.span,
                    format!("`-p {}={text}` is not a {ty}", param.name.text),
                )
                .label("this parameter")
                .help(format!("write for example `-p {}={example}`", param.name.text)),
            );
        }
        value
    }

    /// The values of an enumeration that is known at a place.
    pub(super) fn variants_of(&self, name: &str, place: Span) -> Vec<String> {
        // Its name may be unknown where a value of it is: then it is looked for everywhere.
        let here = self.environment.program.lookup(place, name).map(|(_, i)| i);
        let anywhere = || {
            self.environment
                .program
                .items()
                .map(|(_, i)| i)
                .find(|i| matches!(&i.kind, ItemKind::Enum(n, _) if n.text == name))
        };
        match here.filter(|i| matches!(i.kind, ItemKind::Enum(..))).or_else(anywhere).map(|i| &i.kind) {
            Some(ItemKind::Enum(_, values)) => values.iter().map(|v| v.text.clone()).collect(),
            _ => Vec::new(),
        }
    }

    pub(super) fn is_actuator(&self, kind: &str, place: Span) -> bool {
        self.environment
            .program
            .lookup(place, kind)
            .is_some_and(|(_, item)| matches!(item.kind, ItemKind::Block(BlockKind::Actuator, _)))
    }

    /// Every parameter that some actuator, or some passive part, of the program has.
    fn instance_params(&mut self) -> &InstanceParams {
        let params = match self.instance_params.take() {
            Some(params) => params,
            None => self.find_instance_params(),
        };
        self.instance_params.insert(params)
    }

    fn find_instance_params(&mut self) -> InstanceParams {
        let program = self.environment.program;
        let mut params = InstanceParams::default();
        for (_, item) in program.items() {
            let (is_actuator, block) = match &item.kind {
                ItemKind::Block(BlockKind::Actuator, block) => (true, block),
                ItemKind::Block(BlockKind::Part, block) => (false, block),
                _ => continue,
            };
            for (name, ty) in self.params_of(block) {
                let known = if is_actuator { &mut params.of_actuators } else { &mut params.of_parts };
                let before = known.entry(name).or_insert_with(|| Some(ty.clone()));
                if before.as_ref() != Some(&ty) {
                    *before = None;
                }
            }
        }
        params
    }

    /// The parameters that the block of a kind declares.
    fn params_of(&mut self, block: &ast::Block) -> Vec<(String, Ty)> {
        block
            .fields
            .iter()
            .filter_map(|field| match field {
                ast::Field::Param(param) => Some((param.name.text.clone(), self.type_named(&param.ty))),
                _ => None,
            })
            .collect()
    }

    /// Whether a kind that is worked out is that of an actuator in any case. `local` says so of a local, by its slot.
    pub(in crate::types) fn is_always_actuator(&self, what: &Expr, local: &dyn Fn(usize) -> bool) -> bool {
        match &what.kind {
            ir::ExprKind::Kind(kind, _) => self.is_actuator(kind, what.span),
            ir::ExprKind::With(kind, _) => self.is_always_actuator(kind, local),
            ir::ExprKind::Bind { body, .. } => self.is_always_actuator(body, local),
            ir::ExprKind::If(_, yes, no) => {
                self.is_always_actuator(yes, local) && self.is_always_actuator(no, local)
            }
            ir::ExprKind::Local(slot) => local(*slot),
            _ => false,
        }
    }

    /// Whether all kinds of parts are actuators that a local was chosen from, by where the local is declared.
    pub(in crate::types) fn is_chosen_from_actuators(&self, local: Span) -> bool {
        let kinds = self.chosen.get(&local).filter(|kinds| !kinds.is_empty());
        kinds.is_some_and(|kinds| kinds.iter().all(|(kind, span)| self.is_actuator(kind, *span)))
    }

    /// Notes the kinds of parts that a local is chosen from.
    pub(in crate::types) fn chosen_kinds(&mut self, local: &ast::Name, domain: &Expr) {
        if domain.ty != Ty::Domain(Box::new(Ty::Kind)) {
            return;
        }
        let kinds = self.chosen.entry(local.span).or_default();
        domain.any(&mut |e| {
            if let ir::ExprKind::Kind(name, _) = &e.kind {
                kinds.entry(name.clone()).or_insert(e.span);
            }
            false
        });
    }

    /// A parameter of a part that is known beforehand must lie in its domain.
    pub(super) fn check_instance_domain(&mut self, item: &ast::Item, name: &str, value: &Expr) {
        let ItemKind::Block(BlockKind::Part | BlockKind::Actuator | BlockKind::Cell, block) = &item.kind
        else {
            return;
        };
        let Some(param) = block.fields.iter().find_map(|f| match f {
            ast::Field::Param(p) if p.name.text == name => Some(p),
            _ => None,
        }) else {
            return;
        };
        let Some(domain) = &param.domain else { return };
        let Some(value_now) = self.quiet_number(value) else { return };
        // Whole numbers fit where any number does.
        let ty = self.type_named(&param.ty);
        let mut inner = Context::new(Stage::Declaration, false);
        let domain = self.expect(domain, &mut inner, &Ty::Domain(Box::new(ty.clone())), "a domain");
        if let Some((low, high)) = self.constant_range(&domain)
            && !order::is_within(low, value_now, high)
        {
            self.report(
                Diagnostic::new(Code::OUT_OF_DOMAIN, value.span, format!("`{name}` is outside its domain"))
                    .label(format!(
                        "{} is not within {} .. {}",
                        shown(value_now, &ty),
                        shown(low, &ty),
                        shown(high, &ty)
                    ))
                    .also(param.name.span, "declared here")
                    .help(format!("choose a value within {} .. {}", shown(low, &ty), shown(high, &ty))),
            );
        }
    }
}

/// The parameters that parts have for themselves, with their types; none where kinds differ in it.
#[derive(Debug, Default)]
struct InstanceParams {
    of_actuators: IndexMap<String, Option<Ty>>,
    of_parts: IndexMap<String, Option<Ty>>,
}

/// A number of a type with the unit that people would write.
pub(super) fn shown(value: f64, ty: &Ty) -> String {
    crate::units::shown(value, ty.dimension().unwrap_or_default())
}

/// How long the number is that a text begins with: `1e-1 m` has one, and an `e` that no digit follows is of a unit.
fn digits(text: &str) -> usize {
    let plain = |text: &str, more: &[char]| {
        text.find(|c: char| !(c.is_ascii_digit() || more.contains(&c))).unwrap_or(text.len())
    };
    let mantissa = plain(text, &['.', '-', '+']);
    let rest = text.get(mantissa..).unwrap_or("");
    let Some(power) = rest.strip_prefix(['e', 'E']) else { return mantissa };
    let sign = usize::from(power.starts_with(['-', '+']));
    match power.get(sign..).map_or(0, |digits| plain(digits, &[])) {
        0 => mantissa,
        long => mantissa + 1 + sign + long,
    }
}
