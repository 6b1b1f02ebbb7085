//! What requirements say of how many parts there are, as linear inequalities.
//!
//! The variables are the numbers of parts of each declared kind: those of a group
//! are sums of them. Whatever else a requirement compares is a variable of its
//! own, of which only its least and greatest value are known.

use crate::bounds::linear::Row;
use crate::bounds::{Facts, Interval, Reasoning};
use crate::eval::{Value, evaluate};
use crate::ir::{Expr, ExprKind, Function, Gather, Group, Operator, RuleSet, Ty};

use super::kinds::{can_hold, possible_kinds};

/// A sum of variables, each times a coefficient, and a constant.
#[derive(Clone, Debug, Default)]
struct Sum {
    coefficients: Vec<f64>,
    constant: f64,
}

impl Sum {
    fn constant(constant: f64) -> Self {
        Self { coefficients: Vec::new(), constant }
    }

    fn plus(mut self, other: &Self, times: f64) -> Self {
        if self.coefficients.len() < other.coefficients.len() {
            self.coefficients.resize(other.coefficients.len(), 0.0);
        }
        for (mine, theirs) in self.coefficients.iter_mut().zip(&other.coefficients) {
            *mine += theirs * times;
        }
        self.constant += other.constant * times;
        self
    }

    fn times(&self, factor: f64) -> Self {
        Self::default().plus(self, factor)
    }

    fn is_whole(&self) -> bool {
        self.coefficients.iter().chain([&self.constant]).all(|c| c.fract() == 0.0)
    }
}

/// Everything that is counted and compared.
pub(super) struct Counts<'r> {
    ruleset: &'r RuleSet,
    kinds: Vec<String>,
    /// What else is compared: the text of the expression without places, and whether it is whole.
    others: Vec<(String, bool)>,
    /// What always holds.
    base: Vec<Row>,
}

impl<'r> Counts<'r> {
    /// Knows the kinds of a grammar: none has less than no parts, and what nothing
    /// makes stays as the initial design has it.
    pub(super) fn new(ruleset: &'r RuleSet) -> Self {
        let facts = Facts::new(ruleset);
        let kinds = facts.kinds();
        let mut counts = Self { ruleset, kinds, others: Vec::new(), base: Vec::new() };
        let possible = possible_kinds(ruleset);
        for (i, kind) in counts.kinds.clone().iter().enumerate() {
            counts.limit(i, Interval::NOT_NEGATIVE);
            if !can_hold(&Group::Kind(kind.clone()), &possible, ruleset) {
                counts.limit(i, Interval::new(0.0, (facts.placed(kind) * facts.images()) as f64));
            }
        }
        counts
    }

    fn limit(&mut self, variable: usize, within: Interval) {
        let row = |sign: f64, bound: f64| {
            let mut coefficients = vec![0.0; variable + 1];
            if let Some(last) = coefficients.last_mut() {
                *last = sign;
            }
            Row { coefficients, bound }
        };
        if within.low.is_finite() {
            self.base.push(row(-1.0, -within.low));
        }
        if within.high.is_finite() {
            self.base.push(row(1.0, within.high));
        }
    }

    /// What always holds.
    pub(super) fn base(&self) -> Vec<Row> {
        self.base.clone()
    }

    /// That the initial design stays.
    pub(super) fn begun(&self) -> Vec<Row> {
        let facts = Facts::new(self.ruleset);
        let at_least = |(i, kind): (usize, &String)| {
            let mut coefficients = vec![0.0; i];
            coefficients.push(-1.0);
            Row { coefficients, bound: -(facts.placed(kind) as f64) }
        };
        self.kinds.iter().enumerate().map(at_least).collect()
    }

    /// That there are at least so many parts.
    pub(super) fn parts_at_least(&self, number: f64) -> Row {
        Row { coefficients: vec![-1.0; self.kinds.len()], bound: -number }
    }

    /// Whether only counts of parts are compared, and all of it is in the rows.
    pub(super) fn only_counts(&self) -> bool {
        self.others.is_empty()
    }

    /// What a condition that holds says; conditions that say nothing linear are left out.
    pub(super) fn rows(&mut self, condition: &Expr) -> Vec<Row> {
        let mut rows = Vec::new();
        self.gather(condition, true, &mut rows);
        rows
    }

    fn gather(&mut self, condition: &Expr, holds: bool, rows: &mut Vec<Row>) {
        match &condition.kind {
            ExprKind::Binary(a, Operator::And, b) if holds => {
                self.gather(a, true, rows);
                self.gather(b, true, rows);
            }
            ExprKind::Binary(a, Operator::Or, b) if !holds => {
                self.gather(a, false, rows);
                self.gather(b, false, rows);
            }
            ExprKind::Not(inner) => self.gather(inner, !holds, rows),
            ExprKind::Binary(a, operator, b) if a.ty.dimension().is_some() && b.ty.dimension().is_some() => {
                self.compare(a, *operator, b, holds, rows);
            }
            ExprKind::Aggregate { how: Gather::Exists, binders, .. } if holds => {
                if let [binder] = binders.as_slice()
                    && let ExprKind::Group(group) = &binder.over.kind
                {
                    let some = Sum::constant(1.0).plus(&self.group(group), -1.0);
                    rows.push(at_most(&some, 0.0));
                }
            }
            _ => {}
        }
    }

    fn compare(&mut self, a: &Expr, operator: Operator, b: &Expr, holds: bool, rows: &mut Vec<Row>) {
        use Operator as O;
        let operator = match (operator, holds) {
            (O::Less, false) => O::GreaterEqual,
            (O::LessEqual, false) => O::Greater,
            (O::Greater, false) => O::LessEqual,
            (O::GreaterEqual, false) => O::Less,
            (O::NotEqual, false) => O::Equal,
            (O::Equal, false) => O::NotEqual,
            (operator, true) => operator,
            _ => return,
        };
        let (left, right) = (self.sum(a), self.sum(b));
        let (up, down) = (left.clone().plus(&right, -1.0), right.plus(&left, -1.0));
        // Of whole numbers, less than is at most one less.
        let apart = if up.is_whole() && self.is_whole(&up) { 1.0 } else { 0.0 };
        match operator {
            O::Less => rows.push(at_most(&up, -apart)),
            O::LessEqual => rows.push(at_most(&up, 0.0)),
            O::Greater => rows.push(at_most(&down, -apart)),
            O::GreaterEqual => rows.push(at_most(&down, 0.0)),
            O::Equal => rows.extend([at_most(&up, 0.0), at_most(&down, 0.0)]),
            _ => {}
        }
    }

    /// Whether every variable of a sum is a whole number.
    fn is_whole(&self, sum: &Sum) -> bool {
        let used = sum.coefficients.iter().enumerate().filter(|(_, c)| **c != 0.0);
        used.skip_while(|(i, _)| *i < self.kinds.len())
            .all(|(i, _)| self.others.get(i - self.kinds.len()).is_some_and(|(_, whole)| *whole))
    }

    fn sum(&mut self, expr: &Expr) -> Sum {
        // Parameters count with the values that they are set to.
        if let Ok(Value::Number(x)) = evaluate(expr, self.ruleset, &mut Vec::new()) {
            return Sum::constant(x);
        }
        let number = |e: &Expr| evaluate(e, self.ruleset, &mut Vec::new()).ok().and_then(|v| v.as_number());
        match &expr.kind {
            ExprKind::Call(Function::Count, arguments) => match arguments.as_slice() {
                [Expr { kind: ExprKind::Group(group), .. }] => self.group(group),
                _ => self.other(expr),
            },
            ExprKind::Aggregate { how: Gather::Count, binders, condition: None, .. } => {
                match binders.as_slice() {
                    [binder] => match &binder.over.kind {
                        ExprKind::Group(group) => self.group(group),
                        _ => self.other(expr),
                    },
                    _ => self.other(expr),
                }
            }
            ExprKind::Binary(a, Operator::Add, b) => {
                let right = self.sum(b);
                self.sum(a).plus(&right, 1.0)
            }
            ExprKind::Binary(a, Operator::Subtract, b) => {
                let right = self.sum(b);
                self.sum(a).plus(&right, -1.0)
            }
            ExprKind::Negate(a) => self.sum(a).times(-1.0),
            ExprKind::Binary(a, Operator::Multiply, b) => match (number(a), number(b)) {
                (Some(factor), _) => self.sum(b).times(factor),
                (_, Some(factor)) => self.sum(a).times(factor),
                _ => self.other(expr),
            },
            ExprKind::Binary(a, Operator::Divide, b) => match number(b).filter(|x| *x != 0.0) {
                Some(divisor) => self.sum(a).times(1.0 / divisor),
                None => self.other(expr),
            },
            ExprKind::Convert(a, factor) if *factor != 0.0 => self.sum(a).times(1.0 / factor),
            _ => self.other(expr),
        }
    }

    fn group(&self, group: &Group) -> Sum {
        let facts = Facts::new(self.ruleset);
        let one = |kind: &String| f64::from(u8::from(facts.belongs(kind, group)));
        Sum { coefficients: self.kinds.iter().map(one).collect(), constant: 0.0 }
    }

    /// Something that is no sum of counts: the same expression is the same variable.
    fn other(&mut self, expr: &Expr) -> Sum {
        let name = without_places(expr);
        let known = self.others.iter().position(|(n, _)| *n == name);
        let index = known.unwrap_or(self.others.len()) + self.kinds.len();
        if known.is_none() {
            self.others.push((name, expr.ty == Ty::Count));
            let within = Reasoning::new(&Facts::new(self.ruleset), Vec::new()).numbers(expr);
            self.limit(index, within);
            self.no_more_than_its_group(index, expr);
        }
        let mut coefficients = vec![0.0; index];
        coefficients.push(1.0);
        Sum { coefficients, constant: 0.0 }
    }

    /// `count over p in part where ...` is at most `count(part)`.
    fn no_more_than_its_group(&mut self, index: usize, expr: &Expr) {
        if let ExprKind::Aggregate { how: Gather::Count, binders, .. } = &expr.kind
            && let [binder] = binders.as_slice()
            && let ExprKind::Group(group) = &binder.over.kind
        {
            let mut coefficients = self.group(group).times(-1.0).coefficients;
            coefficients.resize(index, 0.0);
            coefficients.push(1.0);
            self.base.push(Row { coefficients, bound: 0.0 });
        }
    }
}

/// `sum <= most`
fn at_most(sum: &Sum, most: f64) -> Row {
    Row { coefficients: sum.coefficients.clone(), bound: most - sum.constant }
}

/// The text of an expression, the same wherever it stands.
fn without_places(expr: &Expr) -> String {
    fn strip(value: &mut serde_json::Value) {
        match value {
            serde_json::Value::Object(fields) => {
                fields.remove("span");
                fields.values_mut().for_each(strip);
            }
            serde_json::Value::Array(items) => items.iter_mut().for_each(strip),
            _ => {}
        }
    }
    let mut value = serde_json::to_value(expr).unwrap_or_default();
    strip(&mut value);
    value.to_string()
}
