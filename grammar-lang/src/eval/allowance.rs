//! What may be spent on many evaluations together: a check works out whatever needs no design, and must come to its end.

use std::cell::Cell;

use super::{COMBINATIONS, EvalError, Evaluation, OPERATIONS, Scope, Value};
use crate::ir::Expr;
use crate::source::Span;

/// So many times what one evaluation may spend.
const TIMES: u64 = 4;

/// The reason for a value that nobody works out any more.
const SPENT: &str = "with all that is worked out before anything runs, this takes too long; run over fewer values, here or elsewhere";

/// How many operations several evaluations may still spend together.
pub(crate) struct Allowance {
    left: Cell<u64>,
    /// Where the last was spent.
    spent_at: Cell<Option<Span>>,
}

impl Allowance {
    /// That of a check.
    pub(crate) const fn of_check() -> Self {
        Self::of(TIMES * COMBINATIONS * OPERATIONS)
    }

    /// So many operations: for what is only tried, and may be given up.
    pub(crate) const fn of(operations: u64) -> Self {
        Self { left: Cell::new(operations), spent_at: Cell::new(None) }
    }

    /// Evaluates an expression, as [`evaluate`](super::evaluate) does, as long as there is something left.
    ///
    /// # Errors
    ///
    /// [`EvalError`] where it has no value, or nothing is left: see [`Allowance::spent`].
    pub(crate) fn evaluate(
        &self,
        expr: &Expr,
        scope: &dyn Scope,
        locals: &mut Vec<Value>,
    ) -> Result<Value, EvalError> {
        if let Some(error) = self.spent() {
            return Err(error);
        }
        let before = self.left.get();
        let allowed = before.min(COMBINATIONS * OPERATIONS);
        let mut evaluation = Evaluation { scope, locals, left: allowed, sizes: Vec::new() };
        let value = evaluation.value(expr);
        let left = before - (allowed - evaluation.left);
        self.left.set(left);
        match value {
            // What alone takes too long says so itself.
            Err(error) if left == 0 && allowed < COMBINATIONS * OPERATIONS => {
                self.spent_at.set(Some(error.span));
                self.spent().map_or(Err(error), Err)
            }
            value => value,
        }
    }

    /// Once nothing is left: the error that says where it ran out.
    pub(crate) fn spent(&self) -> Option<EvalError> {
        self.spent_at.get().map(|span| EvalError { span, reason: SPENT.to_owned() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ir::{Binder, ExprKind, Gather, Ty};

    /// What knows nothing.
    struct Empty;

    impl Scope for Empty {
        fn outer(&self) -> Option<&dyn Scope> {
            None
        }
    }

    fn expr(kind: ExprKind) -> Expr {
        Expr { kind, ty: Ty::NUMBER, span: Span::default() }
    }

    /// Counts so many numbers, times so many.
    fn count(numbers: f64) -> Expr {
        let end = |x: f64| Box::new(expr(ExprKind::Number(x)));
        let binder = |slot| Binder {
            slot,
            over: Expr {
                kind: ExprKind::Range(end(1.0), end(numbers)),
                ty: Ty::Domain(Box::new(Ty::Count)),
                span: Span::default(),
            },
        };
        expr(ExprKind::Aggregate {
            how: Gather::Count,
            share: None,
            binders: vec![binder(0), binder(1)],
            condition: None,
            body: None,
            otherwise: None,
        })
    }

    #[test]
    fn what_is_left_is_shared() {
        let allowance = Allowance::of_check();
        let ask = |expr: &Expr| allowance.evaluate(expr, &Empty, &mut Vec::new());
        let large = count(3000.0);
        let values = (0..5).map(|_| ask(&large).is_ok());
        assert_eq!(values.collect::<Vec<_>>(), [true, true, true, true, false]);
        assert!(allowance.spent().is_some());
        assert_eq!(ask(&count(2.0)).map_err(|error| error.reason), Err(SPENT.to_owned()));
    }

    #[test]
    fn what_alone_takes_too_long_leaves_something_for_others() {
        let allowance = Allowance::of_check();
        let ask = |expr: &Expr| allowance.evaluate(expr, &Empty, &mut Vec::new());
        let error = ask(&count(4000.0)).unwrap_err();
        assert!(error.reason.contains("4000 x 4000 values"), "{}", error.reason);
        assert_eq!((ask(&count(2.0)), allowance.spent()), (Ok(Value::Number(4.0)), None));
    }
}
