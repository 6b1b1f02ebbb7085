//! What requirements say of how many parts there are, as linear inequalities.
//!
//! The variables are the numbers of parts of each declared kind, and of cells: those
//! of a group are sums of them. Whatever else a requirement compares is a variable of its
//! own, of which only its least and greatest value are known.

use std::collections::{BTreeMap, BTreeSet};

use indexmap::{IndexMap, IndexSet};

use crate::bounds::linear::Row;
use crate::bounds::{Interval, Kinds};
use crate::eval::Value;
use crate::ir::{Expr, ExprKind, Function, Gather, Group, Operator, Ty, without_spans};

use super::known::Known;

/// A sum of variables, each times a coefficient, and a constant.
#[derive(Clone, Debug, Default)]
struct Sum {
    coefficients: BTreeMap<usize, f64>,
    constant: f64,
}

impl Sum {
    fn constant(constant: f64) -> Self {
        Self { coefficients: BTreeMap::new(), constant }
    }

    fn variable(variable: usize) -> Self {
        Self { coefficients: BTreeMap::from([(variable, 1.0)]), constant: 0.0 }
    }

    fn plus(mut self, other: &Self, times: f64) -> Self {
        for (variable, theirs) in &other.coefficients {
            *self.coefficients.entry(*variable).or_default() += theirs * times;
        }
        self.constant += other.constant * times;
        self
    }

    fn times(&self, factor: f64) -> Self {
        Self::default().plus(self, factor)
    }

    fn is_whole(&self) -> bool {
        self.coefficients.values().chain([&self.constant]).all(|c| c.fract() == 0.0)
    }
}

/// Everything that is counted and compared.
pub(super) struct Counts<'k, 'r> {
    known: &'k Known<'r>,
    /// The declared kinds: the first variables.
    kinds: IndexSet<&'r str>,
    /// What else is compared: the text of the expression without places, and whether it is whole.
    others: IndexMap<String, bool>,
    /// What always holds.
    base: Vec<Row>,
}

impl<'k, 'r> Counts<'k, 'r> {
    /// Knows the kinds of a grammar. No count is below zero. There are never more of a part that nothing
    /// makes than in the initial design, and never more cells than places in the lattice.
    pub(super) fn new(known: &'k Known<'r>) -> Self {
        let rules = known.ruleset;
        let parts = rules.parts.keys().chain(rules.actuators.keys());
        let cells = rules.lattice.as_ref().map(|lattice| &lattice.kind);
        let kinds: IndexSet<&str> = parts.chain(cells).map(String::as_str).collect();
        let mut counts = Self { known, kinds, others: IndexMap::new(), base: Vec::new() };
        for i in 0..counts.kinds.len() {
            let group = counts.kind(i);
            // Cells are filled, not placed.
            if counts.is_cell(i) {
                counts.limit(i, known.facts.count(&group));
                continue;
            }
            counts.limit(i, Interval::NOT_NEGATIVE);
            if !known.made.contains(&group) {
                let most = known.facts.placed(&group) * known.facts.images();
                counts.limit(i, Interval::new(0.0, most as f64));
            }
        }
        counts
    }

    /// Whether a variable is the number of cells.
    fn is_cell(&self, variable: usize) -> bool {
        self.kinds.get_index(variable).is_some_and(|kind| self.known.ruleset.is_cell(kind))
    }

    fn kind(&self, variable: usize) -> Group {
        Group::Kind(self.kinds.get_index(variable).map_or(String::new(), |kind| (*kind).to_owned()))
    }

    fn limit(&mut self, variable: usize, within: Interval) {
        if within.low.is_finite() {
            self.base.push(Row::new([(variable, -1.0)], -within.low));
        }
        if within.high.is_finite() {
            self.base.push(Row::new([(variable, 1.0)], within.high));
        }
    }

    /// What always holds.
    pub(super) fn base(&self) -> &[Row] {
        &self.base
    }

    /// That the initial design stays.
    pub(super) fn begun(&self) -> Vec<Row> {
        let at_least = |i: usize| Row::new([(i, -1.0)], -(self.known.facts.placed(&self.kind(i)) as f64));
        (0..self.kinds.len()).map(at_least).collect()
    }

    /// That there are at least so many parts.
    pub(super) fn parts_at_least(&self, number: f64) -> Row {
        let parts = (0..self.kinds.len()).filter(|kind| !self.is_cell(*kind));
        Row::new(parts.map(|kind| (kind, -1.0)), -number)
    }

    /// That there are at least so many parts of a kind; none for a kind that is not declared.
    pub(super) fn kind_at_least(&self, kind: &str, number: f64) -> Option<Row> {
        self.kinds.get_index_of(kind).map(|kind| Row::new([(kind, -1.0)], -number))
    }

    /// For each kind of which some rows allow no part more than the initial design has, the first
    /// such rows by their number.
    pub(super) fn full<'a>(&self, all: impl Iterator<Item = &'a [Row]>) -> IndexMap<&'r str, usize> {
        let least: Vec<f64> =
            (0..self.kinds.len()).map(|i| self.known.facts.placed(&self.kind(i)) as f64).collect();
        let mut full = IndexMap::new();
        for (number, rows) in all.enumerate() {
            for (room, takes) in rows.iter().filter_map(|row| row.room(&least)) {
                let more = takes.iter().filter(|(_, takes)| *takes > room + 1e-6);
                for kind in more.filter_map(|(kind, _)| self.kinds.get_index(*kind)) {
                    full.entry(*kind).or_insert(number);
                }
            }
        }
        full
    }

    /// The kinds of which some row says how many there can be at most.
    pub(super) fn bounded(&self, rows: &[Row]) -> BTreeSet<&'r str> {
        let least = vec![0.0; self.kinds.len()];
        let takes = rows.iter().filter_map(|row| row.room(&least)).flat_map(|(_, takes)| takes);
        takes.filter_map(|(kind, _)| self.kinds.get_index(*kind).copied()).collect()
    }

    /// Whether only counts of parts are compared, and all of it is in the rows.
    pub(super) fn only_counts(&self) -> bool {
        self.others.is_empty()
    }

    /// What each alternative of a condition that holds says.
    pub(super) fn alternatives(&mut self, condition: &Expr) -> Vec<Vec<Row>> {
        match &condition.kind {
            ExprKind::Binary(a, Operator::Or, b) => [self.alternatives(a), self.alternatives(b)].concat(),
            _ => vec![self.rows(condition)],
        }
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
        let used = sum.coefficients.iter().filter(|(_, c)| **c != 0.0).map(|(variable, _)| *variable);
        let mut others = used.filter_map(|variable| variable.checked_sub(self.kinds.len()));
        others.all(|other| self.others.get_index(other).is_some_and(|(_, whole)| *whole))
    }

    fn sum(&mut self, expr: &Expr) -> Sum {
        // Parameters count with the values that they are set to.
        if let Ok(Value::Number(x)) = self.known.value(expr) {
            return Sum::constant(x);
        }
        let known = self.known;
        let number = |e: &Expr| known.value(e).ok().and_then(|v| v.as_number());
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
        let kinds = Kinds::of(group.clone());
        let kinds =
            self.known.facts.names(&kinds).into_iter().filter_map(|kind| self.kinds.get_index_of(kind));
        Sum { coefficients: kinds.map(|kind| (kind, 1.0)).collect(), constant: 0.0 }
    }

    /// Something that is no sum of counts: the same expression is the same variable.
    fn other(&mut self, expr: &Expr) -> Sum {
        let name = without_spans(expr).unwrap_or_default().to_string();
        let (place, before) = self.others.insert_full(name, expr.ty == Ty::Count);
        let variable = self.kinds.len() + place;
        if before.is_none() {
            self.limit(variable, self.known.numbers(expr));
            self.no_more_than_its_group(variable, expr);
        }
        Sum::variable(variable)
    }

    /// `count over p in part where ...` is at most `count(part)`.
    fn no_more_than_its_group(&mut self, variable: usize, expr: &Expr) {
        if let ExprKind::Aggregate { how: Gather::Count, binders, .. } = &expr.kind
            && let [binder] = binders.as_slice()
            && let ExprKind::Group(group) = &binder.over.kind
        {
            let sum = Sum::variable(variable).plus(&self.group(group), -1.0);
            self.base.push(at_most(&sum, 0.0));
        }
    }
}

/// `sum <= most`
fn at_most(sum: &Sum, most: f64) -> Row {
    Row::new(sum.coefficients.iter().map(|(variable, c)| (*variable, *c)), most - sum.constant)
}
