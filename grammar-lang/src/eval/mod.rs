//! Evaluates typed expressions. What a stage knows comes from a [`Scope`].

mod aggregate;
mod allowance;
mod call;
mod curve;
mod made;
mod making;
pub mod order;
mod over;
mod scope;
mod value;
mod valves;

use std::sync::Arc;
use std::sync::atomic::Ordering;

pub use aggregate::quantile;
pub(crate) use allowance::Allowance;
pub use allowance::Budget;
pub use curve::Curve;
pub use made::{
    Made, MadeActuator, MadeBlock, MadeCell, MadeJoint, MadeMotor, MadePort, SHORTER, SOCKET, Unmade,
    is_across, is_colour, shortens, unit,
};
pub use over::evaluate_over;
use scope::InCycle;
pub use scope::{BodyValues, Bounded, Scope, WithValues};
pub use value::{Domain, KindValue, PartId, Reference, Value};
pub use valves::{NoCycle, Valve, Valves};

use serde::{Deserialize, Serialize};

use crate::ir::{Attribute, Axis, Expr, ExprKind, MotionWord, Operator, PartAttribute, Word};
use crate::source::Span;
use crate::units;

/// Why an expression has no value.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct EvalError {
    /// Where.
    pub span: Span,
    /// Why, in words.
    pub reason: String,
}

/// The reason for a value that the stage does not know.
pub const UNKNOWN_HERE: &str = "this is not known at this stage";

/// A time this little outside a motion, s, is rounding.
const SLACK: f64 = 1e-6;

/// How many values a binder may run over, and a list may have.
const MOST: usize = 100_000;
/// So many combinations of values are gone through in one evaluation, of all its aggregates together.
const COMBINATIONS: u64 = 10_000_000;
/// And so many operations, for each combination that may be gone through.
const OPERATIONS: u64 = 20;

/// Evaluates an expression. `locals` holds the values of local slots; binders
/// of aggregates extend it while they run.
///
/// # Errors
///
/// [`EvalError`] where a value does not exist: an aggregate over nothing, an
/// index beyond a list, a number that is not finite.
pub fn evaluate(expr: &Expr, scope: &dyn Scope, locals: &mut Vec<Value>) -> Result<Value, EvalError> {
    within(scope, locals, |evaluation| evaluation.value(expr))
}

/// The same for what is kept and compared: a number beyond [`units::LARGEST`] is no value.
///
/// # Errors
///
/// [`EvalError`] where the value does not exist, or is too large.
pub fn evaluate_result(expr: &Expr, scope: &dyn Scope) -> Result<Value, EvalError> {
    bounded(evaluate(expr, scope, &mut Vec::new())?, expr)
}

/// What an expression comes to, if it is to be kept and compared.
///
/// # Errors
///
/// [`EvalError`] where it is a number beyond [`units::LARGEST`].
pub fn bounded(value: Value, expr: &Expr) -> Result<Value, EvalError> {
    match value {
        Value::Number(x) if x.abs() > units::LARGEST => fail(expr, "this number is beyond 1e100"),
        value => Ok(value),
    }
}

/// The same for an expression that is a number, SI.
///
/// # Errors
///
/// [`EvalError`] where the value does not exist, or is no number.
pub fn evaluate_number(expr: &Expr, scope: &dyn Scope, locals: &mut Vec<Value>) -> Result<f64, EvalError> {
    within(scope, locals, |evaluation| evaluation.number(expr))
}

/// How many operations one evaluation may take.
pub const MOST_OPERATIONS: u64 = COMBINATIONS * OPERATIONS;

/// Evaluates with as many operations as one evaluation may take, and as are left for all that the scope knows.
fn within<T>(scope: &dyn Scope, locals: &mut Vec<Value>, act: impl FnOnce(&mut Evaluation<'_>) -> T) -> T {
    let all = scope.left();
    let allowed = all.map_or(u64::MAX, |all| all.load(Ordering::Relaxed)).min(MOST_OPERATIONS);
    let mut evaluation = Evaluation { scope, locals, left: allowed, sizes: Vec::new() };
    let value = act(&mut evaluation);
    let spent = allowed - evaluation.left;
    if let Some(all) = all {
        all.store(all.load(Ordering::Relaxed).saturating_sub(spent), Ordering::Relaxed);
    }
    value
}

struct Evaluation<'a> {
    scope: &'a dyn Scope,
    locals: &'a mut Vec<Value>,
    /// How many operations may still be done: no expression is worked out for ever.
    left: u64,
    /// Once they are spent: over how many values the aggregates that were under way run, outermost first.
    sizes: Vec<usize>,
}

type Result_ = Result<Value, EvalError>;

fn fail<T>(expr: &Expr, reason: impl Into<String>) -> Result<T, EvalError> {
    Err(EvalError { span: expr.span, reason: reason.into() })
}

fn missing(expr: &Expr) -> EvalError {
    EvalError { span: expr.span, reason: UNKNOWN_HERE.to_owned() }
}

/// Whether an attribute of a cell is asked for.
fn reads_cell(expr: &Expr) -> bool {
    matches!(&expr.kind, ExprKind::Attribute(of, _) if of.ty == crate::ir::Ty::Cell)
}

/// Adds, subtracts, multiplies or divides.
fn calculate(expr: &Expr, x: f64, operator: Operator, y: f64) -> Result<f64, EvalError> {
    match operator {
        Operator::Add => Ok(x + y),
        Operator::Subtract => Ok(x - y),
        Operator::Multiply => Ok(x * y),
        Operator::Divide if y == 0.0 => fail(expr, "this divides by zero"),
        Operator::Divide => Ok(x / y),
        _ => Err(missing(expr)),
    }
}

impl Evaluation<'_> {
    /// Counts operations.
    fn spend(&mut self, expr: &Expr, operations: u64) -> Result<(), EvalError> {
        match self.left.checked_sub(operations) {
            Some(left) => {
                self.left = left;
                Ok(())
            }
            None => {
                self.left = 0;
                Err(self.spent(expr))
            }
        }
    }

    /// The error of an expression that takes too long; of the aggregates that are under way it names the outermost.
    fn spent(&self, expr: &Expr) -> EvalError {
        let runs = match self.sizes.as_slice() {
            [] => String::new(),
            sizes => {
                let sizes: Vec<String> = sizes.iter().map(usize::to_string).collect();
                format!("this runs over {} values: ", sizes.join(" x "))
            }
        };
        let reason = format!(
            "{runs}the calculation takes more than {COMBINATIONS} combinations of values, or {} operations; run over fewer values",
            MOST_OPERATIONS
        );
        EvalError { span: expr.span, reason }
    }

    /// A number. Curves are evaluated at every moment of a motion, and most of them are arithmetic: it is done
    /// here without values in between.
    fn number(&mut self, expr: &Expr) -> Result<f64, EvalError> {
        self.spend(expr, 1)?;
        let x = match &expr.kind {
            ExprKind::Number(x) => *x,
            ExprKind::Local(slot) => match self.locals.get(*slot) {
                Some(Value::Number(x)) => *x,
                _ => return Err(missing(expr)),
            },
            ExprKind::Binary(a, operator, b) if operator.is_arithmetic() => {
                let (x, y) = (self.number(a)?, self.number(b)?);
                calculate(expr, x, *operator, y)?
            }
            ExprKind::Negate(x) => -self.number(x)?,
            ExprKind::Apply(curve, place) => self.apply(expr, curve, place)?,
            ExprKind::Call(function, arguments) if function.is_numeric() => {
                self.numeric(expr, *function, arguments)?
            }
            _ => match self.raw(expr)? {
                Value::Number(x) => x,
                _ => return Err(missing(expr)),
            },
        };
        if x.is_finite() { Ok(x) } else { fail(expr, "this is not a finite number") }
    }

    fn bool(&mut self, expr: &Expr) -> Result<bool, EvalError> {
        match self.value(expr)? {
            Value::Bool(x) => Ok(x),
            _ => Err(missing(expr)),
        }
    }

    fn value(&mut self, expr: &Expr) -> Result_ {
        let value = self.raw(expr)?;
        match value {
            Value::Number(x) if !x.is_finite() => fail(expr, "this is not a finite number"),
            value => Ok(value),
        }
    }

    fn raw(&mut self, expr: &Expr) -> Result_ {
        self.spend(expr, 1)?;
        let known = |value: Option<Value>| value.ok_or_else(|| missing(expr));
        Ok(match &expr.kind {
            ExprKind::Number(x) => Value::Number(*x),
            ExprKind::Bool(x) => Value::Bool(*x),
            ExprKind::Text(x) => Value::Text(x.as_str().into()),
            ExprKind::Param(name) => known(self.scope.param(name))?,
            ExprKind::OfBody(name) => known(self.scope.of_body(name))?,
            ExprKind::Local(slot) => {
                known(self.locals.get(*slot).filter(|value| **value != Value::Unknown).cloned())?
            }
            ExprKind::Word(Word::Pi) => Value::Number(std::f64::consts::PI),
            ExprKind::Word(Word::Closed) => Value::Valve(Valve::Closed),
            ExprKind::Word(Word::Inflate) => Value::Valve(Valve::Inflate),
            ExprKind::Word(Word::Vent) => Value::Valve(Valve::Vent),
            ExprKind::Word(word) => known(self.scope.word(*word))?,
            ExprKind::Placed(name) => known(self.scope.placed(name))?,
            ExprKind::Group(group) => {
                let members = self.scope.group(group).ok_or_else(|| missing(expr))?;
                self.spend(expr, members.len() as u64)?;
                Value::List(members.into())
            }
            ExprKind::Kind(name, params) => {
                let params = params.iter().map(|(n, e)| Ok((n.clone(), self.value(e)?))).collect::<Result<
                    Vec<_>,
                    EvalError,
                >>(
                )?;
                Value::Kind(Arc::new(KindValue { name: name.clone(), params }))
            }
            ExprKind::With(kind, given) => {
                let Value::Kind(kind) = self.value(kind)? else { return Err(missing(expr)) };
                let mut params = kind.params.clone();
                for (name, value) in given {
                    let value = self.value(value)?;
                    params.retain(|(known, _)| known != name);
                    params.push((name.clone(), value));
                }
                Value::Kind(Arc::new(KindValue { name: kind.name.clone(), params }))
            }
            ExprKind::Pattern(name) => Value::Pattern(name.as_str().into()),
            ExprKind::Table(table) => Value::Table(Arc::new(table.clone())),

            ExprKind::Term(name) => self.term(expr, name)?,
            ExprKind::Task(name) => known(self.scope.task(name))?,
            ExprKind::Shared(actuation, variable) => known(self.scope.shared(actuation, variable))?,
            ExprKind::Sensor(name, of) => {
                let of = of.as_ref().map(|of| self.value(of)).transpose()?;
                match self.scope.sensed(name, of.as_ref()) {
                    Some(reading) => reading,
                    None if of.is_some() => {
                        return fail(
                            expr,
                            format!(
                                "this part has no `{name}`: it is not of that kind, or the sensor has nothing to read"
                            ),
                        );
                    }
                    None => return Err(missing(expr)),
                }
            }
            ExprKind::PortName(_) => return Err(missing(expr)),
            ExprKind::Port(of, name, number) => {
                let part = self.value(of)?;
                let number = number.as_ref().map(|n| self.number(n)).transpose()?;
                match self.scope.port(&part, name, number) {
                    Some(port) => port,
                    None => {
                        let number = number.map_or(String::new(), |number| format!("[{number}]"));
                        return fail(expr, format!("this part has no port `{name}{number}`"));
                    }
                }
            }
            ExprKind::Bind { slot, value, body } => self.bind(*slot, value, body)?,
            ExprKind::Attribute(of, attribute) => self.attribute(expr, of, attribute)?,
            ExprKind::At(track, time) => self.at(expr, track, time)?,
            ExprKind::Negate(x) => match self.value(x)? {
                Value::Number(x) => Value::Number(-x),
                Value::Vector(v) => Value::Vector(v.map(|x| -x)),
                _ => return Err(missing(expr)),
            },
            ExprKind::Not(x) => Value::Bool(!self.bool(x)?),
            ExprKind::Binary(a, operator, b) => self.binary(expr, a, *operator, b)?,
            ExprKind::If(condition, yes, no) => {
                let branch = if self.bool(condition)? { yes } else { no };
                self.value(branch)?
            }
            ExprKind::Scenarios(_) => {
                let worlds = self.scope.worlds().ok_or_else(|| missing(expr))?;
                Value::List((0..worlds).map(|i| Value::Reference(Reference::World(i))).collect())
            }
            ExprKind::Aggregate { .. } => self.aggregate(expr)?,
            ExprKind::Call(function, arguments) => self.call(expr, *function, arguments)?,
            ExprKind::Apply(curve, place) => Value::Number(self.apply(expr, curve, place)?),
            ExprKind::Index(list, index) => self.item(expr, list, index)?,
            ExprKind::Range(low, high) => Value::Domain(Arc::new(Domain::Range {
                low: self.number(low)?,
                high: self.number(high)?,
                whole: expr.ty == crate::ir::Ty::Domain(Box::new(crate::ir::Ty::Count)),
            })),
            ExprKind::Set(items) => Value::Domain(Arc::new(Domain::Items(self.values(items)?))),
            ExprKind::List(items) => Value::List(self.values(items)?.into()),
            ExprKind::Convert(x, factor) => Value::Number(self.number(x)? / factor),
        })
    }

    /// The value of a term, worked out once where the scope remembers it.
    fn term(&mut self, expr: &Expr, name: &str) -> Result_ {
        let scope = self.scope;
        if let Some(known) = scope.remembered(name) {
            return Ok(known);
        }
        let term = scope.term(name).ok_or_else(|| missing(expr))?;
        let value = self.elsewhere(scope, |inner| inner.value(term))?;
        scope.remember(name, &value);
        Ok(value)
    }

    /// What reads a local slot that is filled for it alone.
    fn bind(&mut self, slot: usize, value: &Expr, body: &Expr) -> Result_ {
        let value = self.value(value)?;
        let kept = slot.min(self.locals.len());
        let hidden: Vec<Value> = self.locals.drain(kept..).collect();
        self.put(slot, value);
        let result = self.value(body);
        self.locals.truncate(kept);
        self.locals.extend(hidden);
        result
    }

    fn attribute(&mut self, expr: &Expr, of: &Expr, attribute: &Attribute) -> Result_ {
        match (self.value(of)?, attribute) {
            (Value::Vector([x, y, z]), Attribute::Axis(axis)) => Ok(Value::Number(match axis {
                Axis::X => x,
                Axis::Y => y,
                Axis::Z => z,
            })),
            (Value::Reference(of), attribute) => match self.scope.attribute(of, attribute) {
                Some(value) => Ok(value),
                None if reads_cell(expr) => fail(expr, "there is no cell at this place"),
                None => match attribute {
                    Attribute::Param(name) => {
                        fail(expr, format!("this part is of a kind that has no `{name}`"))
                    }
                    Attribute::Field(field) => {
                        fail(expr, format!("this part is of a kind that has no `{}`", field.text()))
                    }
                    Attribute::Part(PartAttribute::Port) => fail(expr, "the core is not attached to a port"),
                    _ => Err(missing(expr)),
                },
            },
            _ => Err(missing(expr)),
        }
    }

    /// Where something is at a time of the motion.
    fn at(&mut self, expr: &Expr, track: &Expr, time: &Expr) -> Result_ {
        let ExprKind::Attribute(of, Attribute::Track(track)) = &track.kind else { return Err(missing(expr)) };
        let Value::Reference(of) = self.value(of)? else { return Err(missing(expr)) };
        let time = self.number(time)?;
        let end = self.scope.word(Word::Motion(MotionWord::End)).and_then(|end| end.as_number());
        if let Some(end) = end.filter(|end| !(-SLACK..=end + SLACK).contains(&time)) {
            let reason =
                format!("this is asked for at {time:.3} s, but the motion lasts from 0 to {end:.3} s");
            return fail(expr, reason);
        }
        self.scope.track(of, *track, time).ok_or_else(|| missing(expr))
    }

    fn item(&mut self, expr: &Expr, list: &Expr, index: &Expr) -> Result_ {
        let list = self.value(list)?;
        let index = self.number(index)?;
        let items = list.items();
        match (index >= 0.0).then(|| items.get(index as usize)).flatten() {
            Some(item) => Ok(item.clone()),
            None => fail(expr, format!("there is no item {index} in a list of {}", items.len())),
        }
    }

    /// Works something out in another scope, without the locals of this one.
    fn elsewhere<T>(
        &mut self,
        scope: &dyn Scope,
        work: impl FnOnce(&mut Evaluation<'_>) -> Result<T, EvalError>,
    ) -> Result<T, EvalError> {
        let mut inner = Evaluation { scope, locals: &mut Vec::new(), left: self.left, sizes: Vec::new() };
        let result = work(&mut inner);
        (self.left, self.sizes) = (inner.left, inner.sizes);
        result
    }

    fn apply(&mut self, expr: &Expr, curve: &Expr, place: &Expr) -> Result<f64, EvalError> {
        let place = self.number(place)?;
        if let ExprKind::Table(table) = &curve.kind {
            return Ok(table.at(place));
        }
        if let ExprKind::Local(slot) = &curve.kind
            && let Some(Value::Curve(curve)) = self.locals.get(*slot)
        {
            return Ok(curve.at(place));
        }
        match self.value(curve)? {
            Value::Curve(curve) => Ok(curve.at(place)),
            Value::Table(table) => Ok(table.at(place)),
            Value::Pattern(name) => {
                let scope = self.scope;
                let pattern = scope.pattern(&name).ok_or_else(|| missing(expr))?;
                let inside = InCycle { outer: scope, cycle: place - libm::floor(place) };
                self.elsewhere(&inside, |inner| inner.number(pattern))
            }
            _ => Err(missing(expr)),
        }
    }

    /// Fills a local slot; slots before it that have no value yet stay unknown.
    fn put(&mut self, slot: usize, value: Value) {
        self.locals.resize(slot, Value::Unknown);
        self.locals.push(value);
    }

    fn values(&mut self, items: &[Expr]) -> Result<Vec<Value>, EvalError> {
        items.iter().map(|e| self.value(e)).collect()
    }

    fn binary(&mut self, expr: &Expr, a: &Expr, operator: Operator, b: &Expr) -> Result_ {
        use Operator as O;
        match operator {
            O::And => return Ok(Value::Bool(self.bool(a)? && self.bool(b)?)),
            O::Or => return Ok(Value::Bool(self.bool(a)? || self.bool(b)?)),
            O::Is | O::IsNot | O::Adds => {
                let left = self.value(a)?;
                let answer = match &b.kind {
                    ExprKind::PortName(name) => {
                        self.scope.is_port(&left, name).ok_or_else(|| missing(expr))?
                    }
                    ExprKind::Group(group) if operator == O::Adds => {
                        self.scope.adds(&left, group).ok_or_else(|| missing(expr))?
                    }
                    ExprKind::Group(group) => {
                        self.scope.belongs(&left, group).ok_or_else(|| missing(expr))?
                    }
                    _ => left.is_same(&self.value(b)?),
                };
                return Ok(Value::Bool(answer != (operator == O::IsNot)));
            }
            _ => {}
        }
        let (left, right) = (self.value(a)?, self.value(b)?);
        Ok(match (left, operator, right) {
            (Value::Number(x), _, Value::Number(y)) => match operator {
                O::Add | O::Subtract | O::Multiply | O::Divide => {
                    Value::Number(calculate(expr, x, operator, y)?)
                }
                // What has no order, NaN, never comes here: it is no value.
                O::Less => Value::Bool(order::is_less(x, y)),
                O::LessEqual => Value::Bool(!order::is_less(y, x)),
                O::Greater => Value::Bool(order::is_less(y, x)),
                O::GreaterEqual => Value::Bool(!order::is_less(x, y)),
                O::Equal => Value::Bool(order::is_same(x, y)),
                _ => Value::Bool(!order::is_same(x, y)),
            },
            (Value::Vector(x), O::Add, Value::Vector(y)) => {
                Value::Vector([x[0] + y[0], x[1] + y[1], x[2] + y[2]])
            }
            (Value::Vector(x), O::Subtract, Value::Vector(y)) => {
                Value::Vector([x[0] - y[0], x[1] - y[1], x[2] - y[2]])
            }
            (Value::Vector(x), O::Multiply, Value::Number(y))
            | (Value::Number(y), O::Multiply, Value::Vector(x)) => Value::Vector(x.map(|x| x * y)),
            (Value::Vector(_), O::Divide, Value::Number(0.0)) => return fail(expr, "this divides by zero"),
            (Value::Vector(x), O::Divide, Value::Number(y)) if y != 0.0 => Value::Vector(x.map(|x| x / y)),
            (Value::Number(y), O::Multiply, Value::Curve(c))
            | (Value::Curve(c), O::Multiply, Value::Number(y)) => Value::Curve(Arc::new(c.scaled(y))),
            (Value::List(x), O::Add, Value::List(y)) => {
                Value::List(x.iter().chain(y.iter()).cloned().collect())
            }
            (x, O::Equal, y) => Value::Bool(x.is_same(&y)),
            (x, O::NotEqual, y) => Value::Bool(!x.is_same(&y)),
            _ => return Err(missing(expr)),
        })
    }
}
