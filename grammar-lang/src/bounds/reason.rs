//! Evaluates expressions over everything that they may read.

use super::{Abstract, Facts, Interval, Kinds, Truth};
use crate::eval::order::{self, is_less, is_same};
use crate::ir::{
    Attribute, Axis, Binder, Expr, ExprKind, Gather, Group, JointAttribute, Operator, PartAttribute,
    PortAttribute, StepAttribute, Ty,
};
use crate::source::Span;

/// A place that never has a value, and why.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Never {
    /// Where.
    pub span: Span,
    /// Why, in words.
    pub reason: &'static str,
}

/// A port that is asked of a part.
#[derive(Clone, Debug, PartialEq)]
pub struct Asked {
    /// Where.
    pub span: Span,
    /// The port's name.
    pub name: String,
    /// Its number, where several share the name, and where that is said.
    pub number: Option<(Span, Interval)>,
    /// What kinds of parts it is asked of.
    pub kinds: Kinds,
}

/// A parameter that is asked of parts none of which has it.
#[derive(Clone, Debug, PartialEq)]
pub struct Lacking {
    /// Where.
    pub span: Span,
    /// The parameter's name.
    pub name: String,
    /// What kinds of parts it is asked of.
    pub kinds: Kinds,
}

/// An evaluation over everything that an expression may read. It also gathers
/// what it meets on the way: places without a value, and constant conditions.
#[derive(Debug)]
pub struct Reasoning<'f> {
    /// What is known.
    pub facts: &'f Facts<'f>,
    /// What is known of local slots.
    pub locals: Vec<Abstract>,
    /// Places that never have a value, although they are evaluated.
    pub never: Vec<Never>,
    /// The conditions of every `if`, and what is known of them.
    pub conditions: Vec<(Span, Truth)>,
    /// The ports of parts that are asked for.
    pub ports: Vec<Asked>,
    /// The parameters that are asked of parts none of which has them.
    pub lacking: Vec<Lacking>,
    /// How many places were met that may have no value for some design: a condition with one of them may refuse a move.
    doubts: usize,
}

impl<'f> Reasoning<'f> {
    /// Knows these facts and locals.
    #[must_use]
    pub fn new(facts: &'f Facts<'f>, locals: Vec<Abstract>) -> Self {
        let (never, conditions, ports, lacking) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Self { facts, locals, never, conditions, ports, lacking, doubts: 0 }
    }

    /// Whether a condition holds: always only if it always has a value, too.
    pub fn truth(&mut self, expr: &Expr) -> Truth {
        let before = self.doubts;
        match self.value(expr).truth() {
            Truth::Always if self.doubts > before => Truth::Sometimes,
            truth => truth,
        }
    }

    /// The numbers that an expression may have.
    pub fn numbers(&mut self, expr: &Expr) -> Interval {
        self.value(expr).numbers()
    }

    /// Everything that an expression may be.
    pub fn value(&mut self, expr: &Expr) -> Abstract {
        match &expr.kind {
            ExprKind::Number(x) => Abstract::Number(Interval::point(*x)),
            ExprKind::Bool(x) => Abstract::Bool(Truth::known(*x)),
            ExprKind::Param(name) | ExprKind::OfBody(name) => self.facts.param(name),
            ExprKind::Local(slot) => self.locals.get(*slot).cloned().unwrap_or(Abstract::Any),
            ExprKind::Word(word) => self.facts.word(*word),
            ExprKind::Placed(name) => Abstract::Part(self.facts.kinds_of_placed(name)),
            ExprKind::Group(group) => {
                let kinds = Kinds::of(group.clone());
                Abstract::Many(Box::new(Abstract::Part(kinds)), self.facts.count(group))
            }
            ExprKind::Kind(name, params) => {
                for (_, value) in params {
                    self.value(value);
                }
                Abstract::Kind(Kinds::of(Group::Kind(name.clone())))
            }
            ExprKind::With(kind, params) => {
                for (_, value) in params {
                    self.value(value);
                }
                self.value(kind)
            }
            ExprKind::Term(name) => self.facts.term(name),
            // The nominal world is among them.
            ExprKind::Scenarios(_) => {
                Abstract::Many(Box::new(Abstract::Any), Interval::new(1.0, f64::INFINITY))
            }
            ExprKind::Port(of, name, number) => {
                let of = self.value(of);
                let number = number.as_ref().map(|number| (number.span, self.numbers(number)));
                match of {
                    Abstract::Part(kinds) => {
                        let (span, name) = (expr.span, name.clone());
                        self.ports.push(Asked { span, name, number, kinds: kinds.clone() });
                        Abstract::Port(kinds)
                    }
                    _ => Abstract::Any,
                }
            }
            ExprKind::Bind { slot, value, body } => self.bind(*slot, value, body),
            ExprKind::Attribute(of, attribute) => self.attribute(expr.span, of, attribute),
            ExprKind::At(track, time) => {
                self.value(track);
                self.value(time);
                Abstract::Any
            }
            ExprKind::Negate(x) => match self.value(x) {
                Abstract::Number(x) => Abstract::Number(x.negated()),
                _ => Abstract::Any,
            },
            ExprKind::Not(x) => Abstract::Bool(self.truth(x).negated()),
            ExprKind::Binary(a, operator, b) => self.binary(expr, a, *operator, b),
            ExprKind::If(condition, yes, no) => self.branch(condition, yes, no),
            ExprKind::Aggregate { .. } => self.aggregate(expr),
            ExprKind::Call(function, arguments) => self.call(expr, *function, arguments),
            ExprKind::Apply(curve, place) => {
                let curve = self.value(curve);
                self.value(place);
                // A curve stays within what its control points span.
                curve
            }
            ExprKind::Index(list, index) => self.index(expr, list, index),
            ExprKind::Range(low, high) => self.range(expr, low, high),
            ExprKind::Set(items) | ExprKind::List(items) => self.many(items),
            ExprKind::Convert(x, factor) => {
                let quotients = self.numbers(x).over(Interval::point(*factor));
                Abstract::Number(quotients.unwrap_or(Interval::ALL))
            }
            ExprKind::Sensor(_, of) => {
                of.iter().for_each(|of| drop(self.value(of)));
                match expr.ty {
                    Ty::Bool => Abstract::Bool(Truth::Sometimes),
                    _ => Abstract::Any,
                }
            }
            ExprKind::Text(_)
            | ExprKind::Pattern(_)
            | ExprKind::Table(_)
            | ExprKind::Task(_)
            | ExprKind::Shared(..)
            | ExprKind::PortName(_) => Abstract::Any,
        }
    }

    /// Notes a place that has no value for some designs, as far as is known.
    pub(super) fn may_fail(&mut self) {
        self.doubts += 1;
    }

    pub(super) fn fails(&mut self, expr: &Expr, reason: &'static str) -> Abstract {
        self.never.push(Never { span: expr.span, reason });
        Abstract::Any
    }

    /// What a function is called with may be constant here and not elsewhere: inside
    /// it, nothing is known of its argument.
    fn bind(&mut self, slot: usize, value: &Expr, body: &Expr) -> Abstract {
        self.value(value);
        self.within(slot, Abstract::Any, |inner| inner.value(body))
    }

    /// Fills a local slot for as long as `inside` runs.
    fn within<T>(&mut self, slot: usize, value: Abstract, inside: impl FnOnce(&mut Self) -> T) -> T {
        let kept = self.set_aside(slot);
        self.locals.push(value);
        let result = inside(self);
        self.restore(kept);
        result
    }

    /// Takes the locals from a slot on away, and makes as many as come before it.
    fn set_aside(&mut self, slot: usize) -> (usize, Vec<Abstract>) {
        let length = self.locals.len();
        let kept = if slot < length { self.locals.split_off(slot) } else { Vec::new() };
        self.locals.resize(slot, Abstract::Any);
        (length, kept)
    }

    /// The locals as they were before some were set aside.
    fn restore(&mut self, (length, kept): (usize, Vec<Abstract>)) {
        self.locals.truncate(length - kept.len());
        self.locals.extend(kept);
    }

    fn attribute(&mut self, span: Span, of: &Expr, attribute: &Attribute) -> Abstract {
        if let Some(number) = self.of_core(of, attribute) {
            return Abstract::Number(Interval::point(number));
        }
        match (attribute, self.value(of)) {
            (Attribute::Part(attribute), Abstract::Part(kinds)) => {
                if attribute.is_of_some() {
                    self.may_fail();
                }
                self.facts.part_attribute(&kinds, *attribute)
            }
            // Some kinds lack it.
            (Attribute::Field(_), _) => {
                self.may_fail();
                Abstract::Any
            }
            (Attribute::Param(name), Abstract::Part(kinds)) => match self.facts.param_of(&kinds, name) {
                Some(known) => {
                    // Of a wider group some kinds may lack it.
                    let has = |group: &Group| {
                        let known = || self.facts.param_of(&Kinds::of(group.clone()), name).is_some();
                        matches!(group, Group::Kind(_)) && known()
                    };
                    if !kinds.groups().all(has) {
                        self.may_fail();
                    }
                    known
                }
                None => {
                    if !self.facts.is_empty(&kinds) {
                        let (name, kinds) = (name.clone(), kinds.clone());
                        self.lacking.push(Lacking { span, name, kinds });
                        self.never.push(Never { span, reason: "these parts have no such parameter" });
                    }
                    Abstract::Any
                }
            },
            (Attribute::Port(attribute), Abstract::Port(kinds)) => match attribute {
                PortAttribute::Part => Abstract::Part(kinds),
                PortAttribute::Free => Abstract::Bool(Truth::Sometimes),
                PortAttribute::Index
                | PortAttribute::Place
                | PortAttribute::Facing
                | PortAttribute::PlaceAtRest
                | PortAttribute::FacingAtRest => Abstract::Any,
            },
            (Attribute::Step(StepAttribute::Number), _) => {
                Abstract::Number(Interval::new(1.0, f64::INFINITY))
            }
            (Attribute::Joint(JointAttribute::Port), _) => Abstract::Port(Kinds::all()),
            (Attribute::Joint(JointAttribute::Holder | JointAttribute::Held), _) => {
                Abstract::Part(Kinds::all())
            }
            _ => Abstract::Any,
        }
    }

    /// What is the same of the core of every design: nothing turns or moves it as a design grows.
    fn of_core(&self, of: &Expr, attribute: &Attribute) -> Option<f64> {
        let is_core =
            |e: &Expr| matches!(&e.kind, ExprKind::Placed(name) if self.facts.core() == Some(name.as_str()));
        let (axis, own) = match (attribute, &of.kind) {
            (Attribute::Part(PartAttribute::Depth), _) if is_core(of) => return Some(0.0),
            (Attribute::Axis(axis), ExprKind::Attribute(part, Attribute::Part(own))) if is_core(part) => {
                (*axis, *own)
            }
            _ => return None,
        };
        let along = match own {
            PartAttribute::Facing => Axis::X,
            PartAttribute::Upward => Axis::Y,
            PartAttribute::Sideways => Axis::Z,
            _ => return None,
        };
        Some(f64::from(u8::from(along == axis)))
    }

    fn branch(&mut self, condition: &Expr, yes: &Expr, no: &Expr) -> Abstract {
        let truth = self.truth(condition);
        self.conditions.push((condition.span, truth));
        match truth {
            Truth::Always => self.value(yes),
            Truth::Never => self.value(no),
            Truth::Sometimes => {
                // A branch that may be left out is not always evaluated: what has no value
                // in it may have been kept apart by the condition.
                let before = self.never.len();
                let (yes, no) = (self.value(yes), self.value(no));
                self.never.truncate(before);
                yes.hull(no)
            }
        }
    }

    fn many(&mut self, items: &[Expr]) -> Abstract {
        let item = items.iter().map(|item| self.value(item)).reduce(Abstract::hull);
        Abstract::Many(Box::new(item.unwrap_or(Abstract::Any)), Interval::point(items.len() as f64))
    }

    fn range(&mut self, expr: &Expr, low: &Expr, high: &Expr) -> Abstract {
        let (low, high) = (self.numbers(low), self.numbers(high));
        let whole = expr.ty == Ty::Domain(Box::new(Ty::Count));
        let ends = Interval::new(low.low, high.high);
        if !whole {
            return Abstract::Many(Box::new(Abstract::Number(ends)), Interval::NOT_NEGATIVE);
        }
        let ends = Interval::new(order::ceil(ends.low), order::floor(ends.high));
        let count = |high: f64, low: f64| (order::floor(high) - order::ceil(low) + 1.0).max(0.0);
        let length = Interval::new(count(high.low, low.high), count(high.high, low.low));
        let length =
            if length.low.is_nan() || length.high.is_nan() { Interval::NOT_NEGATIVE } else { length };
        Abstract::Many(Box::new(Abstract::Number(ends)), length)
    }

    fn index(&mut self, expr: &Expr, list: &Expr, index: &Expr) -> Abstract {
        let (list, index) = (self.value(list), self.numbers(index));
        if index.high < 0.0 || index.low >= list.length().high {
            return self.fails(expr, "the list has no item with this number");
        }
        if index.low < 0.0 || index.high >= list.length().low {
            self.may_fail();
        }
        list.item()
    }

    fn binary(&mut self, expr: &Expr, a: &Expr, operator: Operator, b: &Expr) -> Abstract {
        use Operator as O;
        match operator {
            O::And | O::Or => return self.junction(a, operator, b),
            O::Is | O::IsNot | O::Adds => {
                let truth = self.is(a, operator, b);
                return Abstract::Bool(if operator == O::IsNot { truth.negated() } else { truth });
            }
            _ => {}
        }
        let (left, right) = (self.value(a), self.value(b));
        match (&left, operator, &right) {
            (Abstract::Number(x), O::Add, Abstract::Number(y)) => Abstract::Number(x.plus(*y)),
            (Abstract::Number(x), O::Subtract, Abstract::Number(y)) => Abstract::Number(x.minus(*y)),
            (Abstract::Number(x), O::Multiply, Abstract::Number(y)) => Abstract::Number(x.times(*y)),
            (_, O::Divide, Abstract::Number(y)) if *y == Interval::point(0.0) => {
                self.fails(expr, "this divides by zero")
            }
            (Abstract::Number(x), O::Divide, Abstract::Number(y)) => {
                if y.low <= 0.0 && y.high >= 0.0 {
                    self.may_fail();
                }
                Abstract::Number(x.over(*y).unwrap_or(Interval::ALL))
            }
            (_, O::Divide, _) => {
                self.may_fail();
                Abstract::Any
            }
            (Abstract::Many(x, n), O::Add, Abstract::Many(y, m)) => {
                Abstract::Many(Box::new(x.as_ref().clone().hull(y.as_ref().clone())), n.plus(*m))
            }
            (Abstract::Number(x), _, Abstract::Number(y)) => Abstract::Bool(compare(*x, operator, *y)),
            (_, O::Add | O::Subtract | O::Multiply, _) => Abstract::Any,
            _ => Abstract::Bool(Truth::Sometimes),
        }
    }

    /// The second operand is only asked where the first does not decide.
    fn junction(&mut self, a: &Expr, operator: Operator, b: &Expr) -> Abstract {
        let first = self.truth(a);
        let before = self.never.len();
        let second = self.truth(b);
        let decided = if operator == Operator::And { Truth::Always } else { Truth::Never };
        if first != decided {
            self.never.truncate(before);
        }
        if operator == Operator::And && first == Truth::Sometimes && self.exclude(a, b) {
            return Abstract::Bool(Truth::Never);
        }
        if operator == Operator::Or && first == Truth::Sometimes && self.cover(a, b) {
            return Abstract::Bool(Truth::Always);
        }
        Abstract::Bool(if operator == Operator::And { first.and(second) } else { first.or(second) })
    }

    /// `p is ball`, `q is tip`: what `is not` asks is the opposite.
    fn is(&mut self, a: &Expr, operator: Operator, b: &Expr) -> Truth {
        let left = self.value(a);
        match (&left, &b.kind) {
            _ if operator == Operator::Adds => Truth::Sometimes,
            (Abstract::Part(kinds), ExprKind::Group(group)) => self.facts.member(kinds, group),
            (Abstract::Port(kinds), ExprKind::PortName(name)) => self.facts.are_ports(kinds, name),
            (Abstract::Part(kinds), ExprKind::Placed(name)) => {
                let of = self.facts.kinds_of_placed(name);
                let apart = of.groups().all(|group| self.facts.member(kinds, group) == Truth::Never);
                Truth::of(false, apart)
            }
            (_, ExprKind::Port(..)) => {
                self.value(b);
                Truth::Sometimes
            }
            _ => Truth::Sometimes,
        }
    }

    fn aggregate(&mut self, expr: &Expr) -> Abstract {
        let ExprKind::Aggregate { how, share, binders, condition, body, otherwise } = &expr.kind else {
            return Abstract::Any;
        };
        if let Some(share) = share {
            self.value(share);
        }
        let before = self.never.len();
        // A binder fills a slot beyond those of the binders before it.
        let first = binders.iter().map(|b| b.slot).min().unwrap_or(self.locals.len());
        let kept = self.set_aside(first);
        let mut count = self.run_over(binders);
        match condition.as_ref().map_or(Truth::Always, |c| self.truth(c)) {
            Truth::Always => {}
            Truth::Never => count = Interval::point(0.0),
            Truth::Sometimes => count.low = 0.0,
        }
        let body = body.as_ref().map(|body| self.value(body));
        self.restore(kept);
        if count.low <= 0.0 {
            self.never.truncate(before);
        }
        if matches!(expr.ty, Ty::Vector(_)) {
            otherwise.iter().for_each(|value| drop(self.value(value)));
            return Abstract::Any;
        }
        let needs_one =
            !matches!(how, Gather::Count | Gather::Clusters | Gather::Forall | Gather::Exists | Gather::Sum);
        if needs_one && otherwise.is_none() && count.low < 1.0 {
            self.may_fail();
        }
        gathered(*how, count, body, || otherwise.as_ref().map(|value| self.value(value)))
    }

    /// Fills the slots of binders; gives how many combinations there are.
    pub(super) fn run_over(&mut self, binders: &[Binder]) -> Interval {
        let mut count = Interval::point(1.0);
        for binder in binders {
            let over = self.value(&binder.over);
            self.locals.resize(binder.slot.max(self.locals.len()), Abstract::Any);
            self.locals.truncate(binder.slot);
            self.locals.push(over.item());
            count = count.times(over.length());
        }
        count
    }
}

/// What is gathered from so many values of a body.
fn gathered(
    how: Gather,
    count: Interval,
    body: Option<Abstract>,
    otherwise: impl FnOnce() -> Option<Abstract>,
) -> Abstract {
    let truth = body.as_ref().map_or(Truth::Sometimes, Abstract::truth);
    let (none, some) = (count.high <= 0.0, count.low >= 1.0);
    match how {
        Gather::Count => Abstract::Number(count),
        Gather::Clusters => Abstract::Number(Interval::new(0.0, count.high)),
        Gather::Forall => {
            Abstract::Bool(Truth::of(none || truth == Truth::Always, some && truth == Truth::Never))
        }
        Gather::Exists => {
            Abstract::Bool(Truth::of(some && truth == Truth::Always, none || truth == Truth::Never))
        }
        Gather::Sum => {
            let each = body.map_or(Interval::ALL, |b| b.numbers());
            Abstract::Number(count.times(each).widened())
        }
        Gather::Mean | Gather::Min | Gather::Max | Gather::Quantile | Gather::Deviation => {
            let each = body.map_or(Interval::ALL, |b| b.numbers());
            // Half of them at either end differ the most.
            let spread = Interval::new(0.0, (each.high - each.low) / 2.0);
            let each = if how == Gather::Deviation { spread } else { each };
            let gathered = Abstract::Number(each.widened());
            match otherwise() {
                _ if some => gathered,
                Some(otherwise) => gathered.hull(otherwise),
                // Without it there is no value over nothing.
                None => gathered,
            }
        }
    }
}

/// Compares numbers of two intervals.
fn compare(x: Interval, operator: Operator, y: Interval) -> Truth {
    use Operator as O;
    let same = matches!((x.single(), y.single()), (Some(a), Some(b)) if is_same(a, b));
    let (below, above) = (is_less(x.high, y.low), is_less(y.high, x.low));
    let apart = below || above;
    match operator {
        O::Less => Truth::of(below, !is_less(x.low, y.high)),
        O::LessEqual => Truth::of(!is_less(y.low, x.high), above),
        O::Greater => Truth::of(above, !is_less(y.low, x.high)),
        O::GreaterEqual => Truth::of(!is_less(x.low, y.high), below),
        O::Equal => Truth::of(same, apart),
        O::NotEqual => Truth::of(apart, same),
        _ => Truth::Sometimes,
    }
}
