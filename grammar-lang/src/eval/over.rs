//! Numbers over many moments at once: what drives a motion is asked for at each of them.

use super::{Scope, Value, order};
use crate::ir::{Expr, ExprKind, Function, Operator, Word};

/// A number at each of several moments.
enum Course {
    /// The same at all.
    Same(f64),
    /// One for each.
    Each(Vec<f64>),
}

/// The value of a number at each of several times, if all is plain arithmetic, waves and curves, and has a value at each: the
/// bits that [`evaluate_number`](super::evaluate_number) gives. Otherwise none, and one by one they may have values.
#[must_use]
pub fn evaluate_over(expr: &Expr, scope: &dyn Scope, locals: &[Value], times: &[f64]) -> Option<Vec<f64>> {
    Some(match over(expr, scope, locals, times)? {
        Course::Same(x) => vec![x; times.len()],
        Course::Each(values) => values,
    })
}

fn over(expr: &Expr, scope: &dyn Scope, locals: &[Value], times: &[f64]) -> Option<Course> {
    let course = match &expr.kind {
        ExprKind::Number(x) => Course::Same(*x),
        ExprKind::Local(slot) => Course::Same(locals.get(*slot)?.as_number()?),
        ExprKind::Word(Word::Time) => Course::Each(times.to_vec()),
        ExprKind::Word(Word::Pi) => Course::Same(std::f64::consts::PI),
        ExprKind::Param(name) => Course::Same(scope.param(name)?.as_number()?),
        ExprKind::OfBody(name) => Course::Same(scope.of_body(name)?.as_number()?),
        ExprKind::Negate(x) => over(x, scope, locals, times)?.map(|x| -x),
        ExprKind::Binary(a, operator, b) => {
            let (a, b) = (over(a, scope, locals, times)?, over(b, scope, locals, times)?);
            match operator {
                Operator::Add => a.join(b, |x, y| x + y),
                Operator::Subtract => a.join(b, |x, y| x - y),
                Operator::Multiply => a.join(b, |x, y| x * y),
                // By zero it is not finite.
                Operator::Divide => a.join(b, |x, y| x / y),
                _ => return None,
            }
        }
        ExprKind::Call(function, arguments) => {
            let [argument] = arguments.as_slice() else { return None };
            let argument = over(argument, scope, locals, times)?;
            match function {
                Function::Fraction => argument.map(order::fraction),
                Function::Sin => argument.map(libm::sin),
                Function::Cos => argument.map(libm::cos),
                _ => return None,
            }
        }
        ExprKind::Apply(curve, place) => {
            let ExprKind::Local(slot) = &curve.kind else { return None };
            let Value::Curve(curve) = locals.get(*slot)? else { return None };
            match over(place, scope, locals, times)? {
                Course::Same(place) => Course::Same(curve.at(place)),
                Course::Each(mut places) => {
                    curve.over(&mut places);
                    Course::Each(places)
                }
            }
        }
        _ => return None,
    };
    course.is_finite().then_some(course)
}

impl Course {
    fn map(self, change: impl Fn(f64) -> f64) -> Self {
        match self {
            Self::Same(x) => Self::Same(change(x)),
            Self::Each(mut values) => {
                values.iter_mut().for_each(|x| *x = change(*x));
                Self::Each(values)
            }
        }
    }

    fn join(self, other: Self, join: impl Fn(f64, f64) -> f64) -> Self {
        match (self, other) {
            (Self::Same(x), Self::Same(y)) => Self::Same(join(x, y)),
            (each, Self::Same(y)) => each.map(|x| join(x, y)),
            (Self::Same(x), each) => each.map(|y| join(x, y)),
            (Self::Each(mut values), Self::Each(others)) => {
                values.iter_mut().zip(others).for_each(|(x, y)| *x = join(*x, y));
                Self::Each(values)
            }
        }
    }

    fn is_finite(&self) -> bool {
        match self {
            Self::Same(x) => x.is_finite(),
            Self::Each(values) => values.iter().all(|x| x.is_finite()),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::{Curve, evaluate_number};
    use super::*;
    use crate::ir::Ty;
    use crate::source::Span;

    /// What knows only the time.
    struct At(f64);

    impl Scope for At {
        fn outer(&self) -> Option<&dyn Scope> {
            None
        }
        fn word(&self, word: Word) -> Option<Value> {
            (word == Word::Time).then_some(Value::Number(self.0))
        }
    }

    fn expr(kind: ExprKind) -> Expr {
        Expr { kind, ty: Ty::NUMBER, span: Span::default() }
    }

    fn time() -> Expr {
        expr(ExprKind::Word(Word::Time))
    }

    fn binary(a: Expr, operator: Operator, b: Expr) -> Expr {
        expr(ExprKind::Binary(Box::new(a), operator, Box::new(b)))
    }

    fn call(function: Function, argument: Expr) -> Expr {
        expr(ExprKind::Call(function, vec![argument]))
    }

    #[test]
    fn all_moments_at_once_are_as_one_by_one() {
        let curve = Curve::bezier(&[0.3, -1.2, 2.0, 0.9, 0.3]).unwrap();
        let locals = vec![Value::Number(3.7), Value::Curve(Arc::new(curve))];
        let local = |slot| expr(ExprKind::Local(slot));
        let place = || call(Function::Fraction, binary(time(), Operator::Divide, local(0)));
        let swing = expr(ExprKind::Apply(Box::new(local(1)), Box::new(place())));
        let wave = binary(local(0), Operator::Multiply, call(Function::Sin, place()));
        let other = expr(ExprKind::Negate(Box::new(call(Function::Cos, time()))));
        let sum = binary(binary(swing, Operator::Add, wave), Operator::Subtract, other);
        let times: Vec<f64> = (0..101).map(|n| f64::from(n) / 7.0).collect();
        for expr in [sum, local(0), place()] {
            let all = evaluate_over(&expr, &At(0.0), &locals, &times).expect("plain arithmetic");
            assert_eq!(all.len(), times.len());
            for (value, time) in all.iter().zip(&times) {
                let one = evaluate_number(&expr, &At(*time), &mut locals.clone()).unwrap();
                assert_eq!(value.to_bits(), one.to_bits());
            }
        }
    }

    #[test]
    fn what_has_no_value_somewhere_is_left_to_one_by_one() {
        let one = || expr(ExprKind::Number(1.0));
        let divided = binary(one(), Operator::Divide, binary(time(), Operator::Subtract, one()));
        assert!(evaluate_over(&divided, &At(0.0), &[], &[0.0, 2.0]).is_some());
        assert!(evaluate_over(&divided, &At(0.0), &[], &[0.0, 1.0]).is_none());
        assert!(evaluate_over(&call(Function::Ln, time()), &At(0.0), &[], &[1.0]).is_none());
    }
}
