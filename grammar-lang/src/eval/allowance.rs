//! What may be spent on many evaluations together: a check works out whatever needs no design, and must come to its end.

use std::cell::Cell;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::{EvalError, Evaluation, MOST_OPERATIONS, Scope, Value};
use crate::ir::Expr;
use crate::source::Span;

/// A check of one grammar may spend so many times what one evaluation may.
const TIMES: u64 = 4;

/// The checks of all grammars and variants of a file may spend so many times what that of one may.
const TOGETHER: u64 = 16;

/// The reason for a value that nobody works out any more.
const SPENT: &str = "this takes too long, together with the other calculations before the run; run over fewer values, here or elsewhere";

/// The same where it is what several grammars and variants come to.
const SPENT_TOGETHER: &str = "this takes too long, together with the other calculations for the grammars and variants of this file; run over fewer \
                              values, here or elsewhere, or declare fewer variants in one file";

/// How many operations the checks of all grammars and variants of a file may still spend together.
#[derive(Clone, Debug)]
pub struct Budget(Arc<AtomicU64>);

impl Budget {
    /// That of a file.
    #[must_use]
    pub fn of_file() -> Self {
        Self(Arc::new(AtomicU64::new(TOGETHER * TIMES * MOST_OPERATIONS)))
    }

    fn left(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }

    fn spend(&self, operations: u64) {
        self.0.store(self.left().saturating_sub(operations), Ordering::Relaxed);
    }
}

/// How many operations several evaluations may still spend together.
pub(crate) struct Allowance {
    left: Cell<u64>,
    /// What they share with others.
    budget: Option<Budget>,
    /// Where the last was spent.
    spent_at: Cell<Option<Span>>,
}

impl Allowance {
    /// That of a check of one of the grammars of a file.
    pub(crate) fn of_check(budget: &Budget) -> Self {
        Self { budget: Some(budget.clone()), ..Self::of(TIMES * MOST_OPERATIONS) }
    }

    /// So many operations: for what is only tried, and may be given up.
    pub(crate) const fn of(operations: u64) -> Self {
        Self { left: Cell::new(operations), budget: None, spent_at: Cell::new(None) }
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
        let before = self.left.get().min(self.budget.as_ref().map_or(u64::MAX, Budget::left));
        let allowed = before.min(MOST_OPERATIONS);
        let mut evaluation = Evaluation { scope, locals, left: allowed, sizes: Vec::new() };
        let value = evaluation.value(expr);
        let left = before - (allowed - evaluation.left);
        self.left.set(left);
        if let Some(budget) = &self.budget {
            budget.spend(before - left);
        }
        match value {
            // What alone takes too long says so itself.
            Err(error) if left == 0 && allowed < MOST_OPERATIONS => {
                self.spent_at.set(Some(error.span));
                self.spent().map_or(Err(error), Err)
            }
            value => value,
        }
    }

    /// Once nothing is left: the error that says where it ran out.
    pub(crate) fn spent(&self) -> Option<EvalError> {
        let together = self.budget.as_ref().is_some_and(|budget| budget.left() == 0);
        let reason = if together { SPENT_TOGETHER } else { SPENT };
        self.spent_at.get().map(|span| EvalError { span, reason: reason.to_owned() })
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
    fn variants_of_a_file_share_what_it_may_spend() {
        let budget = Budget::of_file();
        let large = count(3000.0);
        let (before, first) = (budget.left(), Allowance::of_check(&budget));
        assert!(first.evaluate(&large, &Empty, &mut Vec::new()).is_ok());
        // Enough for five more.
        let one = before - budget.left();
        budget.spend(budget.left() - 5 * one - one / 2);
        let variant = || {
            let allowance = Allowance::of_check(&budget);
            let values = (0..3).map(|_| allowance.evaluate(&large, &Empty, &mut Vec::new()));
            let fine = values.filter(Result::is_ok).count();
            (fine, allowance.spent().map(|error| error.reason))
        };
        assert_eq!(variant(), (3, None));
        assert_eq!(variant(), (2, Some(SPENT_TOGETHER.to_owned())));
        assert_eq!(variant(), (0, Some(SPENT_TOGETHER.to_owned())));
    }

    #[test]
    fn what_is_left_is_shared() {
        let allowance = Allowance::of_check(&Budget::of_file());
        let ask = |expr: &Expr| allowance.evaluate(expr, &Empty, &mut Vec::new());
        let large = count(3000.0);
        let values = (0..5).map(|_| ask(&large).is_ok());
        assert_eq!(values.collect::<Vec<_>>(), [true, true, true, true, false]);
        assert!(allowance.spent().is_some());
        assert_eq!(ask(&count(2.0)).map_err(|error| error.reason), Err(SPENT.to_owned()));
    }

    #[test]
    fn what_alone_takes_too_long_leaves_something_for_others() {
        let allowance = Allowance::of_check(&Budget::of_file());
        let ask = |expr: &Expr| allowance.evaluate(expr, &Empty, &mut Vec::new());
        let error = ask(&count(4000.0)).unwrap_err();
        assert!(error.reason.contains("4000 x 4000 values"), "{}", error.reason);
        assert_eq!((ask(&count(2.0)), allowance.spent()), (Ok(Value::Number(4.0)), None));
    }
}
