//! Checks `match` expressions.

use std::collections::BTreeSet;

use indexmap::IndexMap;

use super::Expressions;
use super::context::{Context, Local, as_group, unknown};
use super::fit::article;
use crate::diagnostics::{Code, Diagnostic, did_you_mean};
use crate::ir::{Expr, ExprKind, Operator, Ty};
use crate::source::Span;
use crate::syntax::ast;

/// The values of an enumeration, in order, each with its number; none of another type.
type Values = IndexMap<String, u32>;

/// More cases than this are nested too deeply for what evaluates them.
const MOST_CASES: usize = 2_000;

impl Expressions<'_> {
    /// `match x { a -> b, else -> c }` becomes a chain of `if`s over one value.
    pub(super) fn cases(
        &mut self,
        value: &ast::Expr,
        arms: &[(ast::Expr, ast::Expr)],
        otherwise: Option<&ast::Expr>,
        span: Span,
        cx: &mut Context,
    ) -> Expr {
        let value = self.infer(value, cx);
        if let Some((case, _)) = arms.get(MOST_CASES) {
            let message =
                format!("a `match` has at most {MOST_CASES} cases, and this one has {}", arms.len());
            self.report(
                Diagnostic::new(Code::OUT_OF_DOMAIN, case.span, message)
                    .label("one too many")
                    .help("write the values as a `table`, or let `else` cover the rest"),
            );
            return unknown(span);
        }
        let slot = cx.locals.len();
        let subject = Expr { kind: ExprKind::Local(slot), ty: value.ty.clone(), span: value.span };
        cx.locals.push(Local::new("", value.ty.clone(), value.span));
        let mut checked: Vec<(Expr, Expr)> = Vec::new();
        let mut covered: BTreeSet<String> = BTreeSet::new();
        let values: Values = match &value.ty {
            Ty::Enum(name) => self.variants_of(name, value.span).into_iter().zip(0..).collect(),
            _ => Values::new(),
        };
        for (case, result) in arms {
            if let (Ty::Enum(_), ast::ExprKind::Name(name)) = (&value.ty, &case.kind) {
                if covered.contains(name) {
                    self.report(
                        Diagnostic::new(Code::DUPLICATE, case.span, format!("`{name}` has two cases"))
                            .label("again")
                            .help("keep one of them"),
                    );
                }
                covered.insert(name.clone());
            }
            let condition = self.case(&subject, &values, case, cx);
            checked.push((condition, self.infer(result, cx)));
        }
        let missing: Vec<&str> =
            values.keys().map(String::as_str).filter(|value| !covered.contains(*value)).collect();
        let mut rest = otherwise.map(|o| self.infer(o, cx));
        if rest.is_none() && (!missing.is_empty() || !matches!(value.ty, Ty::Enum(_) | Ty::Unknown)) {
            let message = if missing.is_empty() {
                "not every case is covered".to_owned()
            } else {
                format!("there is no case for `{}`", missing.join("`, `"))
            };
            self.report(
                Diagnostic::new(Code::MISSING_CASE, span, message)
                    .label("incomplete")
                    .help("add the missing cases, or `else -> ...` for all others"),
            );
        }
        cx.locals.truncate(slot);
        if rest.is_none() {
            // With every case covered the last one needs no question.
            rest = checked.pop().map(|(_, result)| result);
        }
        let Some(mut whole) = rest else { return unknown(span) };
        for (condition, result) in checked.into_iter().rev() {
            let Some((yes, no, ty)) = self.unify(result, whole, "`match`") else { return unknown(span) };
            whole = Expr { kind: ExprKind::If(Box::new(condition), Box::new(yes), Box::new(no)), ty, span };
        }
        let ty = whole.ty.clone();
        Expr { kind: ExprKind::Bind { slot, value: Box::new(value), body: Box::new(whole) }, ty, span }
    }

    /// Whether the subject is a case.
    fn case(&mut self, subject: &Expr, values: &Values, case: &ast::Expr, cx: &mut Context) -> Expr {
        let ask = |operator, right: Expr| Expr {
            span: right.span,
            kind: ExprKind::Binary(Box::new(subject.clone()), operator, Box::new(right)),
            ty: Ty::Bool,
        };
        if let (Ty::Enum(name), ast::ExprKind::Name(word)) = (&subject.ty, &case.kind) {
            if let Some(index) = values.get(word) {
                let kind = ExprKind::Number(f64::from(*index));
                return ask(Operator::Equal, Expr { kind, ty: subject.ty.clone(), span: case.span });
            }
            let help = did_you_mean(word, values.keys().map(String::as_str));
            self.report(
                Diagnostic::new(Code::UNKNOWN_NAME, case.span, format!("`{name}` has no value `{word}`"))
                    .label("not one of its values")
                    .help(help.unwrap_or_else(|| {
                        format!("it has: {}", values.keys().cloned().collect::<Vec<_>>().join(", "))
                    })),
            );
            return Expr { ty: Ty::Bool, ..unknown(case.span) };
        }
        if subject.ty == Ty::Port
            && let Some(port) = self.port_name(case)
        {
            return ask(Operator::Is, port);
        }
        let right = self.infer(case, cx);
        if let (Ty::Part | Ty::Actuator, Some(group)) = (&subject.ty, as_group(&right)) {
            return ask(Operator::Is, group);
        }
        if matches!((&subject.ty, &right.ty), (Ty::Part | Ty::Actuator, Ty::Group)) {
            return ask(Operator::Is, right);
        }
        let right = self.fit(right, &subject.ty, &format!("a case of {}", article(&subject.ty)));
        ask(Operator::Equal, right)
    }
}
