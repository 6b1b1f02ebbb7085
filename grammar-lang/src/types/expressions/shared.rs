//! Shared variables, and values outside of actuations that read what only actuations know: what they are where something reads them.

use super::Expressions;
use super::context::{Context, unknown};
use super::stage::Stage;
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Expr, ExprKind, Ty};
use crate::names::{Declaration, declared};
use crate::source::Span;
use crate::syntax::ast::{self, Item, ItemKind};

impl Expressions<'_> {
    /// A shared variable, or a value that reads some: one of the locals of the actuation around it.
    pub(super) fn shared(
        &mut self,
        name: &str,
        declaration: Declaration,
        item: &Item,
        span: Span,
        cx: &mut Context,
    ) -> Expr {
        let place = declared(item).map(|name| name.span);
        let slot = cx.locals.iter().position(|local| Some(local.span) == place);
        if let Some((slot, local)) = slot.and_then(|slot| Some((slot, cx.locals.get(slot)?))) {
            self.read.extend(place);
            return Expr { kind: ExprKind::Local(slot), ty: local.ty.clone(), span };
        }
        match &item.kind {
            // No actuation is around a body that is tried: only its type is asked for.
            ItemKind::Shared(variable) if cx.stage == Stage::Drive && self.tries_a_body => {
                let kind = ExprKind::Shared(String::new(), name.to_owned());
                Expr { kind, ty: self.shared_type(variable), span }
            }
            ItemKind::Let(_, None, value) if cx.stage == Stage::Drive && self.tries_a_body => {
                self.tried(declaration, value, span, cx)
            }
            _ if cx.damaged || !self.environment.sharing.is_known_in_the_end(declaration) => unknown(span),
            ItemKind::Shared(_) if cx.stage == Stage::Drive => {
                let message = format!("`{name}` is not known here");
                let help = format!(
                    "`let`, `next` and `drive` of an actuation read it, unless this calls something else `{name}`"
                );
                self.report(
                    Diagnostic::new(Code::WRONG_STAGE, span, message).label("a shared variable").help(help),
                );
                unknown(span)
            }
            ItemKind::Shared(_) => {
                self.stage_error(span, name, cx.stage, "the actuations, as one variable of all of them")
            }
            _ => {
                let mut error = Diagnostic::new(
                    Code::WRONG_STAGE,
                    span,
                    format!("`{name}` reads shared variables, sensors or states, which are not known here"),
                )
                .label("can be read only where these can")
                .help("only `let`, `next` and `drive` of an actuation and `next` of a state can read it; for use elsewhere, write a function: `let name() = ...`");
                if let Some(place) = place {
                    error = error.also(place, "reads them");
                }
                self.report(error);
                unknown(span)
            }
        }
    }

    /// The type of a shared variable.
    fn shared_type(&mut self, variable: &ast::Variable) -> Ty {
        let ty = self.type_named(&variable.ty);
        if variable.size.is_some() { Ty::List(Box::new(ty)) } else { ty }
    }

    /// The type of a value that reads shared variables, where no actuation is around it.
    fn tried(&mut self, declaration: Declaration, value: &ast::Expr, span: Span, cx: &mut Context) -> Expr {
        if let Some(ty) = self.shared_types.get(&declaration) {
            let kind = ExprKind::Shared(String::new(), String::new());
            return Expr { kind, ty: ty.clone(), span };
        }
        if self.open.contains(&declaration) {
            self.circle(declaration, span);
            return unknown(span);
        }
        if self.open_constants >= super::DEEPEST {
            self.tell_too_deep(span);
            return unknown(span);
        }
        self.open.push(declaration);
        self.open_constants += 1;
        let found = self.infer(value, &mut Context::new(cx.stage, cx.damaged));
        self.open.pop();
        self.open_constants -= 1;
        self.shared_types.insert(declaration, found.ty.clone());
        // A value is known once: what reads it is not made of its pieces.
        Expr { kind: ExprKind::Shared(String::new(), String::new()), ty: found.ty, span }
    }
}
