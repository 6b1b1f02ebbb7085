//! What follows a dot: members of values, and ports of parts.

use super::Expressions;
use super::context::{Context, unknown};
use super::fit::article;
use super::stage::Stage;
use crate::diagnostics::{Code, Diagnostic, did_you_mean, respell};
use crate::ir::{Attribute, Axis, Expr, ExprKind, Ty};
use crate::source::Span;
use crate::syntax::ast;
use crate::syntax::ast::Name;

/// Things whose attributes other things do not have.
const OWNERS: &[Ty] = &[Ty::Part, Ty::Cell, Ty::Port, Ty::Joint, Ty::Step];

/// What follows a dot, and where.
pub(super) struct Asked<'n> {
    pub(super) name: &'n Name,
    /// Of the whole expression.
    pub(super) span: Span,
    pub(super) stage: Stage,
}

/// Fields of kinds of parts, which people ask parts for.
const OF_KINDS: [&str; 12] = [
    "torque",
    "effort",
    "stiffness",
    "damping",
    "density",
    "friction",
    "range",
    "bend",
    "bending_speed",
    "relaxing_speed",
    "neutral",
    "begins",
];

impl Expressions<'_> {
    /// A port by its name, if that is what an expression is.
    pub(in crate::types) fn port_name(&self, tree: &ast::Expr) -> Option<Expr> {
        let ast::ExprKind::Name(name) = &tree.kind else { return None };
        self.environment.ports.contains(name).then(|| Expr {
            kind: ExprKind::PortName(name.clone()),
            ty: Ty::Port,
            span: tree.span,
        })
    }

    pub(super) fn member(&mut self, of: &ast::Expr, name: &Name, span: Span, cx: &mut Context) -> Expr {
        if let Some(value) = self.qualified(of, name, span, cx) {
            return value;
        }
        // A part that the rule of a step of an example names. A port or an attribute of that name is meant first.
        // What a rule names, an example reads before any port of that name.
        let is_other = Attribute::of(&Ty::Part, &name.text).is_some_and(|(a, _)| !a.is_felt());
        if let ast::ExprKind::Name(head) = &of.kind
            && !is_other
        {
            let whole = format!("{head}.{}", name.text);
            if let Some((slot, local)) = cx.locals.iter().enumerate().find(|(_, l)| l.name == whole) {
                self.read.insert(local.span);
                return Expr { kind: ExprKind::Local(slot), ty: local.ty.clone(), span };
            }
        }
        let of = self.infer(of, cx);
        let asked = Asked { name, span, stage: cx.stage };
        match of.ty.clone() {
            Ty::Unknown => unknown(span),
            ty @ (Ty::Part
            | Ty::Actuator
            | Ty::Cell
            | Ty::Element
            | Ty::Port
            | Ty::Joint
            | Ty::Step
            | Ty::World) => self.of_thing(of, &ty, &asked, cx),
            Ty::Record(_, fields) => match fields.iter().position(|(n, _)| *n == name.text) {
                Some(index) => {
                    let ty = fields.get(index).map_or(Ty::Unknown, |(_, ty)| ty.clone());
                    let index = Expr { kind: ExprKind::Number(index as f64), ty: Ty::Count, span: name.span };
                    Expr { kind: ExprKind::Index(Box::new(of), Box::new(index)), ty, span }
                }
                None => {
                    self.no_member(&of, name, &fields.into_iter().map(|(n, _)| n).collect::<Vec<_>>(), span)
                }
            },
            ty @ Ty::Vector(_) => match Attribute::of(&ty, &name.text) {
                Some((axis, ty)) => Expr { kind: ExprKind::Attribute(Box::new(of), axis), ty, span },
                None => {
                    let axes: Vec<String> = Axis::ALL.iter().map(|axis| axis.text().to_owned()).collect();
                    self.no_member(&of, name, &axes, span)
                }
            },
            Ty::Track(inner) if Attribute::of(&inner, &name.text).is_some() => {
                let whole = self.environment.sources.slice(of.span);
                let help = format!("give a time first: `({whole} at end).{}`", name.text);
                self.wrong(
                    name.span,
                    "this vector changes over time: give a time before you read a component".to_owned(),
                    &help,
                )
            }
            Ty::Quantity(_) if crate::units::parse(&name.text).is_ok() => {
                let help = format!(
                    "units are multiplied with `*`: write `{}*{}`",
                    self.environment.sources.slice(of.span),
                    name.text
                );
                self.wrong(name.span, "a unit cannot contain a point".to_owned(), &help)
            }
            _ => self.no_member(&of, name, &[], span),
        }
    }

    /// What follows the dot behind a thing of a design or a motion.
    fn of_thing(&mut self, of: Expr, ty: &Ty, asked: &Asked<'_>, cx: &Context) -> Expr {
        let Asked { name, span, stage } = *asked;
        let make =
            |of: Expr, attribute, ty| Expr { kind: ExprKind::Attribute(Box::new(of), attribute), ty, span };
        let param = || Attribute::Param(name.text.clone());
        let built_in = Attribute::of(ty, &name.text);
        // What only sensors read may be the name of a port or a parameter.
        if let Some((attribute, ty)) = built_in.clone().filter(|(attribute, _)| !attribute.is_felt()) {
            if stage.sees_attribute(&attribute) {
                return make(of, attribute, ty);
            }
            let example = "terms, as in `e.position at end` for `e in elements`";
            return self.stage_error(name.span, &name.text, stage, example);
        }
        // A module on its own does not know which cells and actuators it will meet.
        match ty {
            Ty::Cell => {
                let known = self.cell_params();
                if let Some((_, ty)) = known.iter().find(|(n, _)| *n == name.text) {
                    return make(of, param(), ty.clone());
                }
                if known.is_empty() || self.is_lost(name.span, &name.text) {
                    return unknown(span);
                }
            }
            Ty::Part | Ty::Actuator => {
                if self.environment.ports.contains(&name.text) {
                    let kind = ExprKind::Port(Box::new(of), name.text.clone(), None);
                    return Expr { kind, ty: Ty::Port, span };
                }
                let is_actuator = *ty == Ty::Actuator;
                let of_kind = self.is_field_of_kind(&of, &name.text, cx);
                let known = self.instance_params();
                let has_none = is_actuator && known.of_actuators.is_empty() && built_in.is_none();
                let of_actuators = known.of_actuators.get(&name.text);
                // A part may be an actuator: its holder or twin, or what a rule matches as `part`.
                let of_parts = known.of_parts.get(&name.text).filter(|_| !is_actuator);
                let own = match (of_parts, of_actuators) {
                    (Some(one), Some(other)) if one != other => Some(&None),
                    (one, other) => one.or(other),
                };
                match own.cloned().filter(|_| !of_kind) {
                    Some(Some(ty)) => return make(of, param(), ty),
                    Some(None) => return self.of_several_types(name),
                    None if built_in.is_some() => {}
                    None => {
                        if let Some(field) = self.field_of_kind(&of, asked, cx) {
                            return field;
                        }
                        if has_none || self.is_lost(name.span, &name.text) {
                            return unknown(span);
                        }
                    }
                }
            }
            _ => {}
        }
        if let Some((attribute, ty)) = built_in {
            if stage.sees_attribute(&attribute) {
                return make(of, attribute, ty);
            }
            let example =
                format!("sensors, as in `sense {0}(a : actuator) : TYPE = a.{0} at now`", name.text);
            return self.stage_error(name.span, &name.text, stage, &example);
        }
        let candidates = self.members_of(ty, stage);
        self.no_member(&of, name, &candidates, span)
    }

    /// Everything that may follow the dot behind a thing.
    fn members_of(&mut self, ty: &Ty, stage: Stage) -> Vec<String> {
        let of_part = matches!(ty, Ty::Part | Ty::Actuator);
        let cells = if *ty == Ty::Cell { self.cell_params() } else { Vec::new() };
        let built_in = Attribute::all_of(ty).into_iter().map(|(attribute, _)| attribute);
        let built_in = built_in.filter(|a| stage.sees_attribute(a));
        let built_in = built_in.map(|attribute| attribute.text().to_owned());
        let ports = self.environment.ports.iter().filter(|_| of_part).cloned();
        let known = self.instance_params.iter().flat_map(|known| match ty {
            Ty::Actuator => known.of_actuators.keys(),
            _ => known.of_parts.keys(),
        });
        let params = known.filter(|_| of_part).cloned().chain(cells.into_iter().map(|(n, _)| n));
        built_in.chain(ports).chain(params).collect()
    }

    /// A parameter that is of one type in one kind, and of another in another.
    fn of_several_types(&mut self, name: &Name) -> Expr {
        let message = format!("kinds of parts have a `{}` of different types", name.text);
        self.wrong(name.span, message, "give these parameters names of their own")
    }

    /// Says that something has no such member, and what it has.
    fn no_member(&mut self, of: &Expr, name: &Name, candidates: &[String], span: Span) -> Expr {
        let has = |ty: &&Ty| Attribute::of(ty, &name.text).is_some_and(|(a, _)| !a.is_of_motion());
        let owner = OWNERS.iter().find(has);
        let of_part = if of.ty == Ty::Kind { self.members_of(&Ty::Part, Stage::Score) } else { Vec::new() };
        let help = did_you_mean(&name.text, candidates.iter().map(String::as_str)).or_else(|| {
            if let Ty::List(_) = of.ty {
                let (list, name) = (self.environment.sources.slice(of.span), &name.text);
                return Some(format!(
                    "this is a list: for one item, write `{list}[0].{name}` or `last({list}).{name}`; for all items, put `for x in {list}` at the end of the line"
                ));
            }
            if of.ty == Ty::Kind {
                let kind = self.environment.sources.slice(of.span);
                let is_known = of_part.contains(&name.text);
                let and_write = if is_known { format!(", and write `s.{}`", name.text) } else { String::new() };
                return Some(format!(
                    "there may be many of a kind: name one, as `s` in `match s : {kind}`, `attach {kind} to q as s` or \
                     `forall s in {kind}: ...`{and_write}"
                ));
            }
            if matches!(of.ty, Ty::Actuator | Ty::Part) && OF_KINDS.contains(&name.text.as_str()) {
                let name = &name.text;
                return Some(format!(
                    "the field `{name}` of a kind cannot be read or set from outside: give the kind a parameter that `{name}` reads, and use this parameter"
                ));
            }
            if let Some(owner) = owner.filter(|_| of.ty != Ty::Port) {
                let a = if name.text.starts_with(['a', 'e', 'i', 'o']) { "an" } else { "a" };
                return Some(format!("only {} has {a} `{}`", article(owner), name.text));
            }
            if of.ty == Ty::Actuator {
                return Some(
                    "an actuator has the ports `base` and `tip`. A part that a rule attaches gets a name by `as`; a parameter is declared by `param`".to_owned(),
                );
            }
            let built_in = Attribute::all_of(&of.ty);
            // What only sensors read may be the name of a port or a parameter.
            let is_named = |name: &str| {
                let known = self.instance_params.iter();
                self.environment.ports.contains(name)
                    || known.clone().any(|known| known.of_parts.contains_key(name))
            };
            let is_built_in = |name: &str| {
                built_in.iter().any(|(a, _)| a.text() == name && (!a.is_felt() || !is_named(name)))
            };
            let (all, own): (Vec<&str>, Vec<&str>) =
                candidates.iter().map(String::as_str).partition(|c| of.ty != Ty::Part || is_built_in(c));
            let own = match own.is_empty() {
                true => String::new(),
                false => format!("; if its kind declares them as ports or parameters, {}", own.join(", ")),
            };
            (!candidates.is_empty()).then(|| format!("{} has: {}{own}", article(&of.ty), all.join(", ")))
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

    /// What a port is compared with, if it is no name of a port.
    pub(super) fn named_port(&mut self, tree: &ast::Expr, cx: &mut Context) -> Expr {
        if let ast::ExprKind::Name(name) = &tree.kind {
            let local = cx.locals.iter().any(|l| l.name == *name);
            if !local && self.environment.program.lookup(tree.span, name).is_none() {
                self.unknown_port(&Name { text: name.clone(), span: tree.span });
                return unknown(tree.span);
            }
        }
        self.expect(tree, cx, &Ty::Port, "what a port is compared with")
    }

    pub(in crate::types) fn unknown_port(&mut self, name: &Name) {
        let names: Vec<&str> = self.environment.ports.iter().map(String::as_str).collect();
        let help = did_you_mean(&name.text, names.iter().copied());
        self.report(
            Diagnostic::new(Code::UNKNOWN_NAME, name.span, format!("no part has a port `{}`", name.text))
                .label("not a port")
                .help(help.unwrap_or_else(|| format!("ports are: {}", names.join(", ")))),
        );
    }
}
