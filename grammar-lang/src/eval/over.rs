//! Numbers over many moments at once: what drives a motion is asked for at each of them.

use super::{Scope, Value};
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
                Function::Fraction => argument.map(|x| x - libm::floor(x)),
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
