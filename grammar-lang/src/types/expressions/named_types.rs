//! The types that a text can name: those of the language, quantities, enumerations and records.

use super::context::Context;
use super::stage::Stage;
use super::{DEEPEST, Expressions};
use crate::diagnostics::{Code, Diagnostic, did_you_mean, respell};
use crate::ir::{Expr, ExprKind, Ty};
use crate::names::Declaration;
use crate::source::Span;
use crate::syntax::ast;
use crate::syntax::ast::{Item, ItemKind, Name};
use crate::syntax::declarations::BlockKind;
use crate::units::Dimension;

/// How many fields a record may have in all when the records in it are written out.
const MOST_FIELDS: usize = 1_000;

/// Types of the language that are no quantities.
const OTHERS: &[(&str, Ty)] = &[
    ("Count", Ty::Count),
    ("Bool", Ty::Bool),
    ("Text", Ty::Text),
    ("Pattern", Ty::Pattern),
    ("Position", Ty::Vector(Dimension::LENGTH)),
    ("Rotation", Ty::Rotation),
    ("part", Ty::Part),
    ("block", Ty::Part),
    ("actuator", Ty::Actuator),
    ("cell", Ty::Cell),
    ("element", Ty::Element),
    ("port", Ty::Port),
    ("step", Ty::Step),
];

/// The type of the language that has a name; none if a grammar may declare it.
fn built_in_type(name: &str) -> Option<Ty> {
    let other = OTHERS.iter().find(|(own, _)| *own == name).map(|(_, ty)| ty.clone());
    other.or_else(|| Dimension::named(name).map(Ty::Quantity))
}

/// Whether a name is that of a type of the language.
pub(in crate::types) fn is_type(name: &str) -> bool {
    built_in_type(name).is_some()
}

impl Expressions<'_> {
    /// The type that a declaration names.
    pub(in crate::types) fn type_named(&mut self, name: &Name) -> Ty {
        if let Some(ty) = built_in_type(&name.text) {
            return ty;
        }
        let program = self.environment.program;
        match program.lookup(name.span, &name.text) {
            Some((declaration, Item { kind: ItemKind::Enum(..), .. })) => {
                self.touched.insert(declaration);
                return Ty::Enum(name.text.clone());
            }
            Some((declaration, Item { kind: ItemKind::Record(own, fields), .. })) => {
                self.touched.insert(declaration);
                return self.record_type(declaration, own, fields, name.span);
            }
            None if program.is_lost(program.module_at(name.span), &name.text) => return Ty::Unknown,
            _ => {}
        }
        let own = self
            .guessable(name.span)
            .filter(|(_, i)| matches!(i.kind, ItemKind::Enum(..) | ItemKind::Record(..)))
            .map(|(n, _)| n);
        let mut names: Vec<&str> = Dimension::names().collect();
        names.extend(OTHERS.iter().map(|(n, _)| *n));
        names.extend(own);
        let is_kind = matches!(
            program.lookup(name.span, &name.text),
            Some((_, Item { kind: ItemKind::Block(BlockKind::Part | BlockKind::Actuator, _), .. }))
        );
        let of_kind =
            is_kind.then(|| format!("`{}` is a kind of part; the type of all parts is `part`", name.text));
        let help = of_kind
            .or_else(|| did_you_mean(&name.text, names.iter().copied()))
            .unwrap_or_else(|| format!("types are: {}", names.join(", ")));
        self.report(
            Diagnostic::new(Code::UNKNOWN_TYPE, name.span, format!("unknown type `{}`", name.text))
                .label("no type of this name")
                .help(help)
                .fix_if(respell(name.span, &name.text, names)),
        );
        Ty::Unknown
    }

    /// The type of a record, which is written out with those of its fields.
    fn record_type(
        &mut self,
        declaration: Declaration,
        name: &Name,
        fields: &[ast::RecordField],
        read: Span,
    ) -> Ty {
        if let Some(known) = self.records.get(&declaration) {
            return known.clone();
        }
        if self.open_functions.contains(&declaration) {
            self.circle(declaration, read);
            return Ty::Unknown;
        }
        let mut ty = Ty::Unknown;
        if self.open_functions.len() < DEEPEST {
            self.open_functions.push(declaration);
            self.open.push(declaration);
            let fields =
                fields.iter().map(|f| (f.typed.name.text.clone(), self.type_named(&f.typed.ty))).collect();
            self.open.pop();
            self.open_functions.pop();
            ty = Ty::Record(name.text.clone(), fields);
        }
        let (size, depth) = extent(&ty);
        if ty == Ty::Unknown || size > MOST_FIELDS || depth > DEEPEST {
            let message = format!(
                "`{}` is too large when all records in it are expanded: more than {MOST_FIELDS} fields or {DEEPEST} records deep",
                name.text
            );
            self.report(
                Diagnostic::new(Code::TOO_DEEP, name.span, message)
                    .label("too many nested records")
                    .help("use fewer nested records"),
            );
            ty = Ty::Unknown;
        }
        self.records.insert(declaration, ty.clone());
        ty
    }

    /// The value of a field of a record that is not given one.
    pub(super) fn default_of(
        &mut self,
        declaration: Declaration,
        field: &ast::RecordField,
        ty: &Ty,
    ) -> Option<Expr> {
        let default = field.default.as_ref()?;
        if self.open.contains(&declaration) || self.open.len() >= DEEPEST {
            self.circle(declaration, default.span);
            return Some(Expr { kind: ExprKind::Bool(false), ty: Ty::Unknown, span: default.span });
        }
        self.open.push(declaration);
        let mut cx = Context::new(Stage::Declaration, false);
        let value = self.expect(default, &mut cx, ty, &format!("the default of `{}`", field.typed.name.text));
        self.open.pop();
        Some(value)
    }

    /// Checks the defaults of a record where it is declared.
    pub(in crate::types) fn check_defaults(&mut self, declaration: Declaration, fields: &[ast::RecordField]) {
        for field in fields.iter().filter(|field| field.default.is_some()) {
            let ty = self.type_named(&field.typed.ty);
            if let Some(value) = self.default_of(declaration, field, &ty)
                && value.ty.dimension().is_some()
            {
                self.constant_number(&value);
            }
        }
    }
}

/// How many fields a type has in all, and how many records lie within each other.
fn extent(ty: &Ty) -> (usize, usize) {
    let Ty::Record(_, fields) = ty else { return (1, 0) };
    fields
        .iter()
        .map(|(_, ty)| extent(ty))
        .fold((0, 1), |(size, depth), (own, within)| (size + own, depth.max(within + 1)))
}
