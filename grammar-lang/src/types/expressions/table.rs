//! Measured functions: tables of numbers between which a straight line goes.

use super::Expressions;
use super::context::Context;
use super::fit::article;
use super::stage::Stage;
use crate::diagnostics::{Code, Diagnostic, Fix};
use crate::ir::{self, Expr, ExprKind, Ty};
use crate::source::Span;
use crate::syntax::ast;
use crate::units;

impl Expressions<'_> {
    /// A measured function: its rows in SI units.
    pub(in crate::types) fn table(&mut self, table: &ast::Table, damaged: bool) -> Expr {
        let unknown = Expr { kind: ExprKind::Bool(false), ty: Ty::Unknown, span: table.name.span };
        let (from, to) = (self.type_named(&table.from), self.type_named(&table.to));
        for (ty, name) in [(&from, &table.from), (&to, &table.to)] {
            if !matches!(ty, Ty::Quantity(_) | Ty::Unknown) {
                self.report(
                    Diagnostic::new(Code::WRONG_TYPE, name.span, "a table must map a quantity to a quantity")
                        .label(format!("this is {}", article(ty)))
                        .help("write for example `table lengths : Angle -> Length { ... }`"),
                );
            }
        }
        let (Ty::Quantity(asked), Ty::Quantity(answer)) = (&from, &to) else { return unknown };
        if from != to && self.is_other_way_round(table, &from, &to, damaged) {
            let place = table.from.span.join(table.to.span);
            let help = format!("write `{} -> {}`", table.to.text, table.from.text);
            self.report(
                Diagnostic::new(
                    Code::WRONG_TYPE,
                    place,
                    format!("the rows of this table map {} to {}", article(&to), article(&from)),
                )
                .label("declared the other way round here")
                .help(help.clone())
                .fix(Fix::replace(
                    place,
                    format!("{} -> {}", table.to.text, table.from.text),
                    help,
                )),
            );
            return unknown;
        }
        let mut rows: Vec<([f64; 2], Span)> = Vec::new();
        let mut sound = true;
        for (x, y) in &table.rows {
            let mut cx = Context::new(Stage::Declaration, damaged);
            let x = self.expect(x, &mut cx, &from, "the value on the left of `->`");
            let y = self.expect(y, &mut cx, &to, "the value on the right of `->`");
            match (self.constant_number(&x), self.constant_number(&y)) {
                (Some(a), Some(b)) => rows.push(([a, b], x.span)),
                _ => sound = false,
            }
        }
        if table.rows.is_empty() && !damaged {
            self.report(
                Diagnostic::new(Code::MISSING_FIELD, table.name.span, "this table has no rows")
                    .label("without rows")
                    .help("write rows such as `0 deg -> 0 mm, 90 deg -> 21 mm`"),
            );
        }
        for pair in rows.windows(2) {
            let ([before, _], first) = pair[0];
            let ([x, _], span) = pair[1];
            if x <= before {
                let (x, before) = (units::shown(x, *asked), units::shown(before, *asked));
                self.report(
                    Diagnostic::new(
                        Code::TABLE_ORDER,
                        span,
                        "the rows of a table must be in ascending order",
                    )
                    .label(format!("{x} comes after {before}"))
                    .also(first, "the row before")
                    .help("put the rows in order, and average rows with the same input"),
                );
                return unknown;
            }
        }
        if !sound || rows.is_empty() {
            return unknown;
        }
        let rows = rows.into_iter().map(|(row, _)| row).collect();
        let ty = Ty::Table(*asked, *answer);
        Expr { kind: ExprKind::Table(ir::Table { rows }), ty, span: table.name.span }
    }

    /// Whether each row leads from what the table should lead to, to what it should lead from.
    fn is_other_way_round(&mut self, table: &ast::Table, from: &Ty, to: &Ty, damaged: bool) -> bool {
        let known = self.errors.len();
        let mut is =
            |tree, ty: &Ty| self.infer(tree, &mut Context::new(Stage::Declaration, damaged)).ty == *ty;
        let all = table.rows.iter().all(|(x, y)| is(x, to) && is(y, from));
        // What is wrong within a row is told where it is read for good.
        self.errors.split_off(known);
        all && !table.rows.is_empty()
    }
}
