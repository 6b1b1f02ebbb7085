//! Typed expressions.

use serde::{Deserialize, Serialize};

use super::{Attribute, Function, Ty, Word};
use crate::source::Span;
pub use crate::syntax::ast::{Gather, Operator, Painting};

/// An expression with its type and place. Numbers are in SI units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Expr {
    /// What it computes.
    pub kind: ExprKind,
    /// The type of its value.
    pub ty: Ty,
    /// Where it stands.
    pub span: Span,
}

/// A collection of parts by kind.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Group {
    /// All parts.
    Part,
    /// All passive parts.
    Block,
    /// All actuators.
    Actuator,
    /// All cells of a lattice.
    Cell,
    /// All parts of one declared kind.
    Kind(String),
}

/// A binder of an aggregate: it fills one local slot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Binder {
    /// The local slot.
    pub slot: usize,
    /// What it runs over: a group, a list, `elements`, or a range of counts.
    pub over: Expr,
}

/// What expressions compute.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ExprKind {
    /// A number in SI units (also a count).
    Number(f64),
    /// True or false.
    Bool(bool),
    /// A text.
    Text(String),
    /// A parameter of the grammar.
    Param(String),
    /// A parameter of the grammar that rules set: what it is in this body.
    OfBody(String),
    /// A local: what a rule matched or chose, a variable of an actuation, a binder.
    Local(usize),
    /// A word that the stage gives a value to.
    Word(Word),
    /// A part of the initial design, by its name.
    Placed(String),
    /// A collection of parts.
    Group(Group),
    /// A kind of part with the parameters that are given.
    Kind(String, Vec<(String, Expr)>),
    /// A kind of part that was chosen, with more parameters.
    With(Box<Expr>, Vec<(String, Expr)>),
    /// A pattern by name.
    Pattern(String),
    /// A measured function.
    Table(super::Table),
    /// A term by name.
    Term(String),
    /// The worlds of a set of scenarios by name, the nominal one first.
    Scenarios(String),
    /// The value of a task by name.
    Task(String),
    /// The value of a shared variable of an actuation.
    Shared(String, String),
    /// What a sensor reads, or what the robot or a part remembers, by its name, and of which part where parts have one each.
    Sensor(String, Option<Box<Expr>>),
    /// A port by name, and by number where several share the name: to compare with.
    PortName(String),
    /// A port of a part, by name and by number.
    Port(Box<Expr>, String, Option<Box<Expr>>),
    /// A value in a local slot, and what is computed with it.
    Bind {
        /// The local slot.
        slot: usize,
        /// What it holds.
        value: Box<Expr>,
        /// What reads it.
        body: Box<Expr>,
    },
    /// What follows a dot.
    Attribute(Box<Expr>, Attribute),
    /// A quantity over time, at a time.
    At(Box<Expr>, Box<Expr>),
    /// `-x`
    Negate(Box<Expr>),
    /// `not x`
    Not(Box<Expr>),
    /// Two operands.
    Binary(Box<Expr>, Operator, Box<Expr>),
    /// `if a then b else c`
    If(Box<Expr>, Box<Expr>, Box<Expr>),
    /// Over the items of collections.
    Aggregate {
        /// How items are gathered.
        how: Gather,
        /// Of a quantile, how much of the items lies below it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        share: Option<Box<Expr>>,
        /// What is run over.
        binders: Vec<Binder>,
        /// Which items count.
        condition: Option<Box<Expr>>,
        /// What is gathered; absent for a count.
        body: Option<Box<Expr>>,
        /// The value over nothing.
        otherwise: Option<Box<Expr>>,
    },
    /// A built-in function.
    Call(Function, Vec<Expr>),
    /// A curve or a pattern at a place of the cycle.
    Apply(Box<Expr>, Box<Expr>),
    /// An item of a list, from 0.
    Index(Box<Expr>, Box<Expr>),
    /// A domain between two ends.
    Range(Box<Expr>, Box<Expr>),
    /// A domain of single values.
    Set(Vec<Expr>),
    /// A list.
    List(Vec<Expr>),
    /// A quantity as a number of units of this size.
    Convert(Box<Expr>, f64),
}

impl Expr {
    /// Visits what the expression is made of, but not what that is made of.
    pub fn each<'e>(&'e self, visit: &mut impl FnMut(&'e Self)) {
        match &self.kind {
            ExprKind::Attribute(a, _) | ExprKind::Negate(a) | ExprKind::Not(a) | ExprKind::Convert(a, _) => {
                visit(a)
            }
            ExprKind::Port(a, _, b) => {
                visit(a);
                b.iter().for_each(|b| visit(b));
            }
            ExprKind::Sensor(_, of) => of.iter().for_each(|of| visit(of)),
            ExprKind::Bind { value, body, .. } => [value, body].into_iter().for_each(|e| visit(e)),
            ExprKind::At(a, b)
            | ExprKind::Binary(a, _, b)
            | ExprKind::Apply(a, b)
            | ExprKind::Index(a, b)
            | ExprKind::Range(a, b) => [a, b].into_iter().for_each(|e| visit(e)),
            ExprKind::If(a, b, c) => [a, b, c].into_iter().for_each(|e| visit(e)),
            ExprKind::Call(_, items) | ExprKind::Set(items) | ExprKind::List(items) => {
                items.iter().for_each(visit)
            }
            ExprKind::Kind(_, items) => items.iter().for_each(|(_, e)| visit(e)),
            ExprKind::With(kind, items) => {
                visit(kind);
                items.iter().for_each(|(_, e)| visit(e));
            }
            ExprKind::Aggregate { share, binders, condition, body, otherwise, .. } => {
                binders.iter().for_each(|b| visit(&b.over));
                [share, condition, body, otherwise].into_iter().flatten().for_each(|e| visit(e));
            }
            _ => {}
        }
    }

    /// The first parameter that rules set, of those that it reads, and where.
    #[must_use]
    pub fn of_body(&self) -> Option<(&str, Span)> {
        if let ExprKind::OfBody(name) = &self.kind {
            return Some((name, self.span));
        }
        let mut found = None;
        self.each(&mut |e| found = found.or_else(|| e.of_body()));
        found
    }

    /// Whether the expression, or one that it is made of, satisfies `test`.
    pub fn any(&self, test: &mut impl FnMut(&Self) -> bool) -> bool {
        if test(self) {
            return true;
        }
        match &self.kind {
            ExprKind::Attribute(a, _) | ExprKind::Negate(a) | ExprKind::Not(a) | ExprKind::Convert(a, _) => {
                a.any(test)
            }
            ExprKind::Port(a, _, b) => a.any(test) || b.as_ref().is_some_and(|b| b.any(test)),
            ExprKind::Sensor(_, of) => of.as_ref().is_some_and(|of| of.any(test)),
            ExprKind::Bind { value, body, .. } => value.any(test) || body.any(test),
            ExprKind::At(a, b)
            | ExprKind::Binary(a, _, b)
            | ExprKind::Apply(a, b)
            | ExprKind::Index(a, b)
            | ExprKind::Range(a, b) => a.any(test) || b.any(test),
            ExprKind::If(a, b, c) => a.any(test) || b.any(test) || c.any(test),
            ExprKind::Call(_, items) | ExprKind::Set(items) | ExprKind::List(items) => {
                items.iter().any(|e| e.any(test))
            }
            ExprKind::Kind(_, items) => items.iter().any(|(_, e)| e.any(test)),
            ExprKind::With(kind, items) => kind.any(test) || items.iter().any(|(_, e)| e.any(test)),
            ExprKind::Aggregate { share, binders, condition, body, otherwise, .. } => {
                binders.iter().any(|b| b.over.any(test))
                    || [share, condition, body, otherwise].into_iter().flatten().any(|e| e.any(test))
            }
            _ => false,
        }
    }
}
