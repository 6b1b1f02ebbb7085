//! Conditions that each may hold, and never together: `q is left and q is right`, `n > 4 and n < 3`.

use super::locals::conjuncts;
use super::{Interval, Reasoning};
use crate::eval::order;
use crate::ir::{Expr, ExprKind, Operator, Ty};

/// The numbers that a comparison leaves: the ends, and whether they are left out themselves.
#[derive(Clone, Copy)]
struct Left {
    low: (f64, bool),
    high: (f64, bool),
}

impl Left {
    /// Whether no number is in both.
    fn excludes(self, other: Self) -> bool {
        let above = |(low, low_open): (f64, bool), (high, high_open): (f64, bool)| {
            low > high || low == high && (low_open || high_open)
        };
        above(self.low, other.high) || above(other.low, self.high)
    }
}

impl Reasoning<'_> {
    /// Whether conditions that are joined by `and` exclude each other.
    pub(super) fn exclude(&mut self, a: &Expr, b: &Expr) -> bool {
        let (first, second) = (conjuncts(a), conjuncts(b));
        second.iter().any(|y| first.iter().any(|x| self.excludes(x, y)))
    }

    /// Whether one of two conditions that are joined by `or` holds whatever there is: what they refuse excludes each other.
    pub(super) fn cover(&mut self, a: &Expr, b: &Expr) -> bool {
        let refused = |e| disjuncts(e).into_iter().filter_map(negated).collect::<Vec<_>>();
        let (first, second) = (refused(a), refused(b));
        second.iter().any(|y| first.iter().any(|x| self.excludes(x, y)))
    }

    fn excludes(&mut self, x: &Expr, y: &Expr) -> bool {
        if let (ExprKind::Binary(a, first, what), ExprKind::Binary(b, second, other)) = (&x.kind, &y.kind) {
            use Operator::{Is, IsNot};
            match (first, second) {
                (Is, Is) => return is_one(a, b) && are_apart(what, other),
                (Is, IsNot) | (IsNot, Is) => return is_one(a, b) && is_named_alike(what, other),
                _ => {}
            }
        }
        match (self.left(x), self.left(y)) {
            (Some((a, first)), Some((b, second))) => is_one(a, b) && first.excludes(second),
            _ => false,
        }
    }

    /// What a comparison of something with a number leaves of it.
    fn left<'e>(&mut self, condition: &'e Expr) -> Option<(&'e Expr, Left)> {
        let ExprKind::Binary(a, operator, b) = &condition.kind else { return None };
        let (subject, operator, number) = match (subject(a), subject(b)) {
            (true, false) => (&**a, *operator, b),
            (false, true) => (&**b, operator.turned_round()?, a),
            _ => return None,
        };
        let Interval { low, high } = self.numbers(number);
        if low != high || !low.is_finite() {
            return None;
        }
        let all = (f64::NEG_INFINITY, false);
        let none = (f64::INFINITY, false);
        // What counts has no value between whole numbers.
        let counts = subject.ty == Ty::Count;
        let above = if counts { (order::floor(low) + 1.0, false) } else { (low, true) };
        let below = if counts { (order::ceil(low) - 1.0, false) } else { (low, true) };
        let left = match operator {
            Operator::Less => Left { low: all, high: below },
            Operator::LessEqual => Left { low: all, high: (low, false) },
            Operator::Greater => Left { low: above, high: none },
            Operator::GreaterEqual => Left { low: (low, false), high: none },
            Operator::Equal => Left { low: (low, false), high: (low, false) },
            _ => return None,
        };
        Some((subject, left))
    }
}

/// The conditions that are joined by `or`.
fn disjuncts(condition: &Expr) -> Vec<&Expr> {
    match &condition.kind {
        ExprKind::Binary(a, Operator::Or, b) => [disjuncts(a), disjuncts(b)].concat(),
        _ => vec![condition],
    }
}

/// The opposite of a comparison.
fn negated(condition: &Expr) -> Option<Expr> {
    use Operator as O;
    let ExprKind::Binary(a, operator, b) = &condition.kind else { return None };
    let operator = match operator {
        O::Is => O::IsNot,
        O::IsNot => O::Is,
        O::Less => O::GreaterEqual,
        O::LessEqual => O::Greater,
        O::Greater => O::LessEqual,
        O::GreaterEqual => O::Less,
        O::NotEqual => O::Equal,
        _ => return None,
    };
    Some(Expr { kind: ExprKind::Binary(a.clone(), operator, b.clone()), ..condition.clone() })
}

/// Whether an expression is a local, or an attribute of one: what has one value wherever it is read.
fn subject(expr: &Expr) -> bool {
    match &expr.kind {
        ExprKind::Local(_) => true,
        ExprKind::Attribute(of, _) => matches!(of.kind, ExprKind::Local(_)),
        _ => false,
    }
}

/// Whether two expressions are the same local, or the same attribute of it.
fn is_one(a: &Expr, b: &Expr) -> bool {
    match (&a.kind, &b.kind) {
        (ExprKind::Local(a), ExprKind::Local(b)) => a == b,
        (ExprKind::Attribute(a, of_a), ExprKind::Attribute(b, of_b)) => of_a == of_b && is_one(a, b),
        _ => false,
    }
}

/// Whether what is one of them is not the other: two names of ports, or two placed parts.
fn are_apart(a: &Expr, b: &Expr) -> bool {
    match (&a.kind, &b.kind) {
        (ExprKind::PortName(a), ExprKind::PortName(b)) | (ExprKind::Placed(a), ExprKind::Placed(b)) => a != b,
        _ => false,
    }
}

/// Whether two expressions name the same: a port, a placed part, a group.
fn is_named_alike(a: &Expr, b: &Expr) -> bool {
    match (&a.kind, &b.kind) {
        (ExprKind::PortName(a), ExprKind::PortName(b)) | (ExprKind::Placed(a), ExprKind::Placed(b)) => a == b,
        (ExprKind::Group(a), ExprKind::Group(b)) => a == b,
        _ => false,
    }
}
