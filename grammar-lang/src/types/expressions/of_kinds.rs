//! Fields of kinds that are read of their parts: `f.torque`, `s.stiffness`. What such a field is of depends on the joint of the kind.

use super::members::Asked;
use super::{Context, Expressions};
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Attribute, Expr, ExprKind, Group, JointKind, KindField, PartAttribute, Ty};
use crate::syntax::ast::{self, Field, Item, ItemKind};
use crate::syntax::declarations::BlockKind;
use crate::units::Dimension;

impl Expressions<'_> {
    /// A field of the kind that a part has, if it is one that can be read.
    pub(super) fn field_of_kind(&mut self, of: &Expr, asked: &Asked<'_>, cx: &Context) -> Option<Expr> {
        let field = KindField::named(&asked.name.text).filter(|_| asked.stage.sees_design())?;
        let program = self.environment.program;
        let own = self.kind_of(of, cx).and_then(|kind| program.lookup(of.span, kind));
        let types: Vec<Ty> = match own {
            Some((_, item)) => match field_type(item, field) {
                Some(ty) => vec![ty],
                None => return self.has_no_field(item, asked),
            },
            None => {
                // An actuator is no block.
                let fits = |item: &Item| of.ty != Ty::Actuator || is_actuator(item);
                let kinds = program.items().map(|(_, item)| item).filter(|item| fits(item));
                kinds.filter_map(|item| field_type(item, field)).collect()
            }
        };
        let first = types.first()?.clone();
        if types.iter().any(|ty| *ty != first) {
            let name = &asked.name.text;
            let message =
                format!("`{name}` has different units for a joint that turns and for one that slides");
            self.report(
                Diagnostic::new(Code::WRONG_TYPE, asked.name.span, message)
                    .label("the kind of this part is not known")
                    .help(format!(
                        "name the kind, as in `match a : finger` or `for a in finger`, and read `a.{name}`"
                    )),
            );
            return Some(super::context::unknown(asked.span));
        }
        let kind = ExprKind::Attribute(Box::new(of.clone()), Attribute::Field(field));
        Some(Expr { kind, ty: first, span: asked.span })
    }

    /// Says that parts of a kind have no such field, and what they have.
    fn has_no_field(&mut self, item: &Item, asked: &Asked<'_>) -> Option<Expr> {
        let ItemKind::Block(_, block) = &item.kind else { return None };
        let has = KindField::ALL.iter().filter(|field| field_type(item, **field).is_some());
        let has: Vec<String> = has.map(|field| format!("`{}`", field.text())).collect();
        let (kind, name) = (&block.name.text, &asked.name.text);
        self.report(
            Diagnostic::new(Code::UNKNOWN_FIELD, asked.name.span, format!("`{kind}` has no `{name}`"))
                .label("not a field of this kind")
                .also(block.name.span, "this kind")
                .help(format!("its fields that can be read: {}", has.join(", "))),
        );
        Some(super::context::unknown(asked.span))
    }

    /// The kind of a part, where the text says it: as it is matched, run over or placed.
    fn kind_of(&self, of: &Expr, cx: &Context) -> Option<&str> {
        match &of.kind {
            // An image is what its original is.
            ExprKind::Attribute(of, Attribute::Part(PartAttribute::Twin)) => self.kind_of(of, cx),
            ExprKind::Local(slot) => self.matched.get(&cx.locals.get(*slot)?.span).map(String::as_str),
            ExprKind::Placed(name) => match &self.environment.placed.get(name.as_str())?.what.kind {
                ast::ExprKind::Name(kind) => Some(kind),
                ast::ExprKind::Call(callee, _) => match &callee.kind {
                    ast::ExprKind::Name(kind) => Some(kind),
                    _ => None,
                },
                _ => None,
            },
            _ => None,
        }
    }

    /// Whether the kind of a part is known, and has no parameter of a name, but a field.
    pub(super) fn is_field_of_kind(&self, of: &Expr, name: &str, cx: &Context) -> bool {
        let item = self.kind_of(of, cx).and_then(|kind| self.environment.program.lookup(of.span, kind));
        let Some((_, Item { kind: ItemKind::Block(_, block), .. })) = item else { return false };
        let has = |field: &Field| matches!(field, Field::Param(param) if param.name.text == name);
        KindField::named(name).is_some() && !block.fields.iter().any(has)
    }

    /// Notes the kind of what a name stands for, if all that it can be is of one.
    pub(in crate::types) fn note_kind(&mut self, name: &ast::Name, over: &Expr) {
        match &over.kind {
            ExprKind::Group(group) => self.note_group(name, group),
            ExprKind::Kind(kind, _) => drop(self.matched.insert(name.span, kind.clone())),
            _ => {}
        }
    }

    /// The same for a group of parts.
    pub(in crate::types) fn note_group(&mut self, name: &ast::Name, group: &Group) {
        if let Group::Kind(kind) = group {
            self.matched.insert(name.span, kind.clone());
        }
    }
}

fn is_actuator(item: &Item) -> bool {
    matches!(item.kind, ItemKind::Block(BlockKind::Actuator, _))
}

/// What a field of a kind is of; none if the kind has no such field.
fn field_type(item: &Item, field: KindField) -> Option<Ty> {
    let ItemKind::Block(BlockKind::Actuator | BlockKind::Part, block) = &item.kind else { return None };
    if field == KindField::Friction {
        return Some(Ty::Quantity(Dimension::NUMBER));
    }
    let written = block.fields.iter().find_map(|field| match field {
        Field::Joint(joint) => Some((JointKind::named(&joint.kind.text), joint.passive.is_some())),
        _ => None,
    });
    let (kind, passive) = match written {
        Some((kind, passive)) => (kind?, passive),
        // A row bends where it says nothing else; a part has no joint.
        None if is_actuator(item) => (JointKind::Bend, false),
        None => return None,
    };
    let spins = kind == JointKind::Spin;
    let dimension = match field {
        KindField::Friction => Dimension::NUMBER,
        KindField::Stiffness if !spins => kind.stiffness(),
        KindField::Damping => kind.damping(),
        KindField::Torque | KindField::Effort if !passive && kind.effort_field() == field.text() => {
            kind.effort()
        }
        KindField::Stiffness | KindField::Torque | KindField::Effort => return None,
    };
    Some(Ty::Quantity(dimension))
}
