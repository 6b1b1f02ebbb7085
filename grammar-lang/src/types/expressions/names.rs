//! What a name in an expression stands for, and where it may be read.

use super::context::{Context, Local, unknown};
use super::stage::{Stage, stages_of};
use super::{Expressions, signature, task};
use crate::diagnostics::{Code, Diagnostic, Fix, did_you_mean, respell};
use crate::ir::{DesignWord, Expr, ExprKind, Function, Group, Operator, Ty, Word};
use crate::names::Declaration;
use crate::source::Span;
use crate::syntax::ast;
use crate::syntax::ast::{Item, ItemKind, Name};
use crate::syntax::declarations::BlockKind;
use crate::units::{self, Unit};

/// What an actuation has of which there is one.
const SHARED: &str = "shared variable";

/// The fields of a model that can be read wherever a constant can: what a grammar says of its world and its times.
const OF_MODEL: [&str; 7] =
    ["gravity", "ground_friction", "step", "control", "record", "speed_limit", "pace_limit"];

impl Expressions<'_> {
    pub(in crate::types) fn name(&mut self, name: &str, span: Span, cx: &mut Context) -> Expr {
        let make = |kind, ty| Expr { kind, ty, span };
        if let Some(slot) = cx.locals.iter().rposition(|l| l.name == name) {
            let local = cx.locals.get(slot);
            self.read.extend(local.map(|l| l.span));
            return make(ExprKind::Local(slot), local.map_or(Ty::Unknown, |l| l.ty.clone()));
        }
        let declared = self.environment.program.lookup(span, name).is_some();
        let word = Word::named(name).filter(|w| !declared || cx.stage.sees_word(*w));
        // A module on its own does not know which bodies it will meet.
        let lattice = self.environment.has_lattice || self.environment.program.name.is_none();
        if let Some(word) = word.filter(|w| *w != Word::Design(DesignWord::Middle) || lattice) {
            if cx.stage.sees_word(word) {
                return make(ExprKind::Word(word), signature::word(word));
            }
            // It may be a name that a lost clause binds, or one that `begin` gives, which has been told.
            if cx.damaged || self.environment.placed.contains_key(name) {
                return unknown(span);
            }
            let places: Vec<&str> = stages_of(word).unwrap_or(&[]).iter().map(|s| s.name()).collect();
            return self.stage_error(span, name, cx.stage, &one_of(&places));
        }
        if let Some(group) = match name {
            "part" => Some(Group::Part),
            "block" => Some(Group::Block),
            "actuator" => Some(Group::Actuator),
            "cell" => Some(Group::Cell),
            _ => None,
        } {
            if !cx.stage.sees_design() {
                return self.stage_error(span, name, cx.stage, "rules, requirements and terms");
            }
            return make(ExprKind::Group(group), Ty::Group);
        }
        if let Some(ast::Place { what, .. }) = self.environment.placed.get(name) {
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
        let program = self.environment.program;
        let Some((declaration, item)) = program.lookup(span, name) else {
            return self.unknown_name(name, span, cx);
        };
        self.touched.insert(declaration);
        self.declared_name(name, declaration, item, span, cx)
    }

    /// What a name means that a text declares.
    fn declared_name(
        &mut self,
        name: &str,
        declaration: Declaration,
        item: &Item,
        span: Span,
        cx: &mut Context,
    ) -> Expr {
        let make = |kind, ty| Expr { kind, ty, span };
        let what = match &item.kind {
            ItemKind::Param(_) => {
                let ty = self.param(declaration).map_or(Ty::Unknown, |p| p.ty);
                if !self.environment.set_by_rules.contains_key(&declaration) {
                    return make(ExprKind::Param(name.to_owned()), ty);
                }
                if let Some(here) = cx.stage.sees_no_body() {
                    self.tell_of_body(name, span, here);
                    return unknown(span);
                }
                return make(ExprKind::OfBody(name.to_owned()), ty);
            }
            ItemKind::Block(BlockKind::Part | BlockKind::Actuator | BlockKind::Cell, _) => {
                return make(ExprKind::Kind(name.to_owned(), Vec::new()), Ty::Kind);
            }
            ItemKind::Table(table) => {
                let table = self.table(table, item.damaged);
                return Expr { span, ..table };
            }
            ItemKind::Pattern(..) => return make(ExprKind::Pattern(name.to_owned()), Ty::Pattern),
            ItemKind::Term(_, ty, _) => {
                if !cx.stage.sees_motion() {
                    return self.stage_error(span, name, cx.stage, "terms and objectives");
                }
                let ty = self.type_named(ty);
                return make(ExprKind::Term(name.to_owned()), ty);
            }
            ItemKind::Sense(sense) => return self.sensed(sense, &[], span, cx),
            ItemKind::State(of_body) => return self.remembered(of_body, &[], span, cx),
            ItemKind::Let(_, None, _) if self.environment.sharing.reads(declaration) => {
                return self.shared(name, declaration, item, span, cx);
            }
            ItemKind::Let(_, None, value) => {
                let value = self.inline(declaration, value);
                if let (Some(here), Some((of_body, _))) = (cx.stage.sees_no_body(), value.of_body()) {
                    let of_body = of_body.to_owned();
                    self.tell_of_body(&of_body, span, here);
                    return unknown(span);
                }
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
            ItemKind::Block(BlockKind::Scenarios, _) => {
                if !cx.stage.sees_worlds() {
                    return self.stage_error(span, name, cx.stage, "the objective of a task");
                }
                return make(ExprKind::Scenarios(name.to_owned()), Ty::List(Box::new(Ty::World)));
            }
            ItemKind::Shared(_) => return self.shared(name, declaration, item, span, cx),
            ItemKind::Task(..) => {
                return self.wrong(
                    span,
                    format!("`{name}` is a task, not a value"),
                    &format!("ask for its value: `{name}.value`"),
                );
            }
            ItemKind::Block(BlockKind::Model, _) => {
                return self.wrong(
                    span,
                    format!("`{name}` is a model, not a value"),
                    &format!("read one of its numbers, such as `{name}.gravity`"),
                );
            }
            other => other.kind().map_or("a declaration", |kind| kind.what),
        };
        self.wrong(
            span,
            format!("`{name}` is {what}, not a value"),
            "only values can be used in a calculation",
        )
    }

    pub(super) fn stage_error(&mut self, span: Span, name: &str, stage: Stage, where_known: &str) -> Expr {
        self.report(
            Diagnostic::new(Code::WRONG_STAGE, span, format!("`{name}` cannot be read in {}", stage.name()))
                .label("not known here")
                .help(format!(
                    "`{name}` can be read only in {where_known}{}",
                    stage.instead(name, where_known)
                )),
        );
        unknown(span)
    }

    /// Parts of a kind are asked for where there is no design.
    pub(super) fn parts_unknown(&mut self, kind: Span, stage: Stage) -> Expr {
        let name = self.environment.sources.slice(kind).to_owned();
        self.stage_error(kind, &name, stage, "rules, requirements and terms, as the parts of a design")
    }

    pub(super) fn unknown_name(&mut self, name: &str, span: Span, cx: &Context) -> Expr {
        if let Some(value) = self.own_field(name, span, cx) {
            return value;
        }
        if cx.damaged || self.is_lost(span, name) {
            return unknown(span);
        }
        if self.report_dropped(span, name) {
            return unknown(span);
        }
        let mut fix = None;
        // What drives an actuator may read its parameters, but only as its own.
        let driven = cx.locals.iter().find(|l| matches!(l.ty, Ty::Actuator | Ty::Cell) && !l.name.is_empty());
        let driven = driven.filter(|driven| match driven.ty {
            Ty::Cell => self.cell_params().iter().any(|(n, _)| n == name),
            _ => self.instance_params().of_actuators.contains_key(name),
        });
        let instead = |name| match name {
            "mass" => Some("density"),
            "density" => Some("mass"),
            _ => None,
        };
        let given = cx.fields.all.iter().find(|(field, _)| instead(name) == Some(field.text.as_str()));
        let help = if let Some((given, _)) = given {
            format!(
                "this part gives `{}`, so there is no `mass` to read: a field can read only fields that the part gives",
                given.text
            )
        } else if name == "core" && self.environment.has_lattice {
            "a lattice has no core: the place in its middle is `middle`".to_owned()
        } else if let Some(driven) = driven {
            format!("did you mean `{}.{name}`?", driven.name)
        } else if units::parse(name).is_ok() {
            format!(
                "`{name}` is a unit: write a number before it, and a unit without spaces, as in `1 g/cm^3`"
            )
        } else if Function::named(name).is_some() {
            format!(
                "`{name}` is a function: call it as `{}`",
                Function::named(name).map_or("", |f| signature::usage(f).0)
            )
        } else if let Some(of) = self.enumeration_with(span, name) {
            let help =
                format!("write `{of}.{name}`: write a value together with the name of its enumeration");
            fix = Some(Fix::replace(span, format!("{of}.{name}"), help.clone()));
            help
        } else if self.environment.ports.contains(name) {
            format!(
                "`{name}` is a port: ask for it with `is`, as in `q is {name}`, or say of which part, as in `p.{name}`"
            )
        } else {
            let candidates = cx
                .locals
                .iter()
                .map(|l| l.name.as_str())
                // What an effect made without a name has none to guess at.
                .filter(|name| !name.is_empty())
                .chain(cx.fields.all.iter().map(|(field, _)| field.text.as_str()))
                .chain(Word::ALL.iter().filter(|w| cx.stage.sees_word(**w)).map(|w| w.text()))
                .chain(self.guessable(span).map(|(n, _)| n))
                .chain(self.environment.placed.keys().copied())
                .chain(["part", "block", "actuator", "cell"]);
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

    /// The only enumeration that has a value of a name.
    fn enumeration_with(&self, place: Span, value: &str) -> Option<String> {
        let mut those = self.guessable(place).filter_map(|(name, item)| match &item.kind {
            ItemKind::Enum(_, values) => values.iter().any(|v| v.text == value).then_some(name),
            _ => None,
        });
        let only = those.next()?;
        those.next().is_none().then(|| only.to_owned())
    }

    /// Whether an unknown name is the echo of another error.
    pub(in crate::types) fn is_lost(&self, place: Span, name: &str) -> bool {
        self.environment.program.is_lost(self.environment.program.module_at(place), name)
    }

    /// Reports a name that a variant drops; false if it does not.
    pub(in crate::types) fn report_dropped(&mut self, span: Span, name: &str) -> bool {
        self.report_dropped_with(span, name, "drop or replace this, too")
    }

    /// The same with a help of its own.
    pub(in crate::types) fn report_dropped_with(&mut self, span: Span, name: &str, help: &str) -> bool {
        let Some(place) = self.environment.program.dropped_at(span, name) else { return false };
        self.report(
            Diagnostic::new(Code::DROPPED, span, format!("`{name}` is used, but the variant drops it"))
                .label("still used here")
                .also(place, "dropped here")
                .help(help),
        );
        true
    }

    /// Names that are followed by a dot but are no values: enumerations, tasks, actuations.
    pub(super) fn qualified(
        &mut self,
        of: &ast::Expr,
        name: &Name,
        span: Span,
        cx: &Context,
    ) -> Option<Expr> {
        let ast::ExprKind::Name(head) = &of.kind else { return None };
        if cx.locals.iter().any(|l| l.name == *head) {
            return None;
        }
        let program = self.environment.program;
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
            ItemKind::Block(BlockKind::Model, block) => {
                self.touched.insert(declaration);
                let readable = block.fields.iter().filter_map(|field| match field {
                    ast::Field::Value(own, value) if OF_MODEL.contains(&own.text.as_str()) => {
                        Some((own, value))
                    }
                    _ => None,
                });
                let readable: Vec<(&Name, &ast::Expr)> = readable.collect();
                if let Some((own, value)) = readable.iter().find(|(own, _)| own.text == name.text) {
                    let value = self.inline_field(declaration, &own.text, value);
                    return Some(Expr { span, ..value });
                }
                (readable.iter().map(|(own, _)| own.text.as_str()).collect(), "number")
            }
            ItemKind::Task(_, items) => {
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
                    let value = Expr { kind: ExprKind::Task(head.clone()), ty: Ty::NUMBER, span };
                    let unit = task::unit_of(items).and_then(|unit| units::parse(&unit.text).ok());
                    return Some(match unit {
                        Some(unit) => in_unit(value, unit),
                        // What is wanted is missing, which is told there.
                        None if !task::has_objective(items) => Expr { ty: Ty::Unknown, ..value },
                        None => value,
                    });
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
                let is_varied = clauses.iter().any(
                    |c| matches!(c, ast::ActuationClause::Variable(v) if !v.shared && v.name.text == name.text),
                );
                if is_varied {
                    self.report(
                        Diagnostic::new(
                            Code::UNKNOWN_NAME,
                            name.span,
                            format!("each actuator has a `{}` of its own", name.text),
                        )
                        .label("not one value")
                        .help(format!(
                            "only `shared {}`, of which there is one, can be read here",
                            name.text
                        )),
                    );
                    return Some(unknown(of.span));
                }
                if let Some(variable) = shared.iter().find(|v| v.name.text == name.text) {
                    let ty = self.type_named(&variable.ty);
                    let ty = if variable.size.is_some() { Ty::List(Box::new(ty)) } else { ty };
                    return Some(Expr { kind: ExprKind::Shared(head.clone(), name.text.clone()), ty, span });
                }
                (shared.iter().map(|v| v.name.text.as_str()).collect(), SHARED)
            }
            _ => return None,
        };
        let of_all = match program.lookup(name.span, &name.text) {
            Some((_, Item { kind: ItemKind::Shared(_), .. })) if what == SHARED => Some(&name.text),
            _ => None,
        };
        let help = of_all
            .map(|of_all| format!("`{of_all}` belongs to no actuation: write only `{of_all}`"))
            .or_else(|| did_you_mean(&name.text, offers.iter().copied()))
            .unwrap_or_else(|| match offers.as_slice() {
                [] => format!("it has no {what}: declare one, as in `shared {} : ...`", name.text),
                _ => format!("it has: {}", offers.join(", ")),
            });
        self.report(
            Diagnostic::new(
                Code::UNKNOWN_FIELD,
                name.span,
                format!("`{head}` has no {what} `{}`", name.text),
            )
            .label("not known")
            .help(help)
            .fix_if(of_all.map(|name| Fix::replace(span, name.clone(), format!("write `{name}`")))),
        );
        Some(unknown(span))
    }

    /// Adds a name that must not hide another.
    pub(in crate::types) fn bind(&mut self, name: &Name, ty: Ty, cx: &mut Context) {
        let taken = cx
            .locals
            .iter()
            .find(|l| l.name == name.text && !l.may_be_hidden)
            .map(|l| Some(l.span))
            .or_else(|| {
                let (_, item) = self.environment.program.lookup(name.span, &name.text)?;
                Some(crate::names::declared(item).map(|n| n.span))
            })
            .or_else(|| {
                // What `begin` calls its parts is the business of the grammar that does, not of
                // the modules that it imports.
                let own =
                    self.environment.program.own.contains(&self.environment.program.module_at(name.span));
                let placed = self.environment.placed.get(name.text.as_str()).filter(|_| own);
                // Where no lattice is, nothing has a place in its middle.
                let known = |w: &Word| *w != Word::Design(DesignWord::Middle) || self.environment.has_lattice;
                let word = Word::named(&name.text).filter(known).is_some_and(|w| cx.stage.shares_word(w));
                // Groups and the first part are read where designs are, whatever the module.
                let part = cx.stage.sees_design() && ["block", "core"].contains(&name.text.as_str());
                placed.map(|place| Some(place.name.span)).or((word || part).then_some(None))
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
        cx.locals.push(Local::new(name.text.clone(), ty, name.span));
    }

    /// Adds a parameter of a function; that two of them share a name is told where they stand.
    pub(super) fn bind_parameter(&mut self, name: &Name, ty: Ty, cx: &mut Context) {
        if cx.locals.iter().any(|l| l.name == name.text) {
            cx.locals.push(Local::new(name.text.clone(), ty, name.span));
        } else {
            self.bind(name, ty, cx);
        }
    }
}

/// What helps where a name is not known and resembles no other.
fn not_declared(name: &str, cx: &Context) -> String {
    // Short names are those that clauses bind, longer ones are declared.
    if name.chars().count() > 2 {
        return crate::names::UNDECLARED.to_owned();
    }
    let matched = |l: &super::context::Local| {
        matches!(l.ty, Ty::Part | Ty::Actuator | Ty::Port | Ty::Joint | Ty::Cell | Ty::Step)
    };
    if cx.stage == Stage::Derivation && !cx.locals.iter().any(matched) {
        return "this rule binds no part or port: bind parts and ports with a line such as \
                `match p : part with free port q`"
            .to_owned();
    }
    let mut bound: Vec<String> =
        cx.locals.iter().filter(|l| !l.name.is_empty()).map(|l| format!("`{}`", l.name)).collect();
    bound.dedup();
    match (bound.is_empty(), cx.stage) {
        (true, Stage::Derivation) => "bind it first, as in `match p : part with free port q`".to_owned(),
        (true, _) => crate::names::UNDECLARED.to_owned(),
        _ => format!(
            "the names bound here are: {}; declare other names, or import them with `use`",
            bound.join(", ")
        ),
    }
}

/// `a, b or c`
fn one_of(words: &[&str]) -> String {
    match words {
        [head @ .., last] if !head.is_empty() => format!("{} or {last}", head.join(", ")),
        other => other.concat(),
    }
}

/// Words in backquotes, with a word between the last two.
pub(in crate::types) fn listed(words: &[&str], join: &str) -> String {
    match words {
        [head @ .., last] if !head.is_empty() => format!("`{}` {join} `{last}`", head.join("`, `")),
        other => format!("`{}`", other.concat()),
    }
}

/// A number of a unit as a quantity.
fn in_unit(value: Expr, unit: Unit) -> Expr {
    let span = value.span;
    let one = Expr { kind: ExprKind::Number(unit.factor), ty: Ty::Quantity(unit.dimension), span };
    let kind = ExprKind::Binary(Box::new(value), Operator::Multiply, Box::new(one));
    Expr { kind, ty: Ty::Quantity(unit.dimension), span }
}
