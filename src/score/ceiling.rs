//! What an objective can still come to while its motion is under way, by interval reasoning: nobody knows
//! where elements end, but with a pace limit it is known how far from here that can be at most.
//!
//! Only what is asked of positions at the end along the ground is bounded; all else that the future decides may
//! be anything. So a bound that follows holds, and where none follows there is none.

use grammar_lang::eval::{EvalError, Scope, Value, evaluate, quantile};
use grammar_lang::ir::{
    Attribute, Binder, ElementAttribute, Expr, ExprKind, Function, Gather, MotionWord, Operator,
    PartAttribute, RuleSet, Track, Word,
};

use super::{MotionScope, Recording};

/// A motion under way.
#[derive(Clone, Copy)]
pub struct Underway<'a> {
    /// What it is the motion of; recorded until now.
    pub recording: Recording<'a>,
    /// The time until which it is recorded, s.
    pub now: f64,
    /// How fast an element can be from here to where it ends, along the ground, m/s.
    pub pace: f64,
}

/// The least and the greatest that a task's objective can still be.
///
/// # Errors
///
/// [`EvalError`] when what is known already has no value.
pub fn limits(underway: Underway<'_>) -> Result<(f64, f64), EvalError> {
    let drive = underway.recording.drive;
    let (rules, task) = (drive.candidate().rules, drive.task());
    let scope = MotionScope::new(underway.recording)?;
    let limits = Limits { rules, scope: &scope, underway };
    Ok(limits.of(&task.objective.value, &mut Vec::new())?.range())
}

/// What is known of a value.
#[derive(Clone, Debug)]
enum Known {
    /// It itself.
    Exactly(Value),
    /// A number between these.
    Between(f64, f64),
    /// A vector whose part along the ground lies around (x, z), within a radius.
    Around([f64; 2], f64),
    /// Nothing.
    Nothing,
}

impl Known {
    /// As a number.
    fn range(&self) -> (f64, f64) {
        match self {
            Self::Exactly(Value::Number(x)) => (*x, *x),
            Self::Between(low, high) => (*low, *high),
            _ => (f64::NEG_INFINITY, f64::INFINITY),
        }
    }

    fn exactly(&self) -> Option<&Value> {
        if let Self::Exactly(value) = self { Some(value) } else { None }
    }

    fn between(low: f64, high: f64) -> Self {
        if low.is_nan() || high.is_nan() { Self::Nothing } else { Self::Between(low, high) }
    }
}

struct Limits<'a> {
    rules: &'a RuleSet,
    scope: &'a MotionScope<'a>,
    underway: Underway<'a>,
}

impl Limits<'_> {
    fn of(&self, expr: &Expr, locals: &mut Vec<Known>) -> Result<Known, EvalError> {
        if !self.asks_the_future(expr)
            && let Some(values) = values(locals)
        {
            let mut values = values;
            return Ok(Known::Exactly(evaluate(expr, self.scope, &mut values)?));
        }
        Ok(match &expr.kind {
            ExprKind::Local(slot) => locals.get(*slot).cloned().unwrap_or(Known::Nothing),
            ExprKind::Term(name) => match self.rules.terms.get(name) {
                Some(term) => self.of(&term.value, &mut Vec::new())?,
                None => Known::Nothing,
            },
            ExprKind::Bind { slot, value, body } => {
                let value = self.of(value, locals)?;
                let depth = locals.len();
                locals.resize(depth.max(slot + 1), Known::Nothing);
                let before = std::mem::replace(&mut locals[*slot], value);
                let known = self.of(body, locals);
                locals[*slot] = before;
                locals.truncate(depth);
                known?
            }
            ExprKind::At(track, time) => self.at(track, time, locals)?,
            ExprKind::Negate(x) => {
                let (low, high) = self.of(x, locals)?.range();
                Known::between(-high, -low)
            }
            ExprKind::Convert(x, unit) if *unit > 0.0 => {
                let (low, high) = self.of(x, locals)?.range();
                Known::between(low / unit, high / unit)
            }
            ExprKind::Binary(a, operator, b) => {
                let (a, b) = (self.of(a, locals)?, self.of(b, locals)?);
                binary(&a, *operator, &b)
            }
            ExprKind::If(condition, yes, no) => match self.of(condition, locals)?.exactly() {
                Some(Value::Bool(true)) => self.of(yes, locals)?,
                Some(Value::Bool(false)) => self.of(no, locals)?,
                _ => {
                    let (a, b) = (self.of(yes, locals)?.range(), self.of(no, locals)?.range());
                    Known::between(a.0.min(b.0), a.1.max(b.1))
                }
            },
            ExprKind::Call(function, arguments) => {
                let known: Result<Vec<Known>, _> = arguments.iter().map(|a| self.of(a, locals)).collect();
                call(*function, &known?)
            }
            ExprKind::Aggregate { binders, .. } => match &binders[..] {
                [binder] => self.gather(expr, binder, locals)?,
                _ => Known::Nothing,
            },
            _ => Known::Nothing,
        })
    }

    /// Whether an expression reads what is not recorded yet, or might.
    fn asks_the_future(&self, expr: &Expr) -> bool {
        let now = self.underway.now;
        expr.any(&mut |e| match &e.kind {
            ExprKind::At(_, time) => match &time.kind {
                ExprKind::Word(Word::Motion(MotionWord::Start)) => false,
                ExprKind::Number(time) => *time > now,
                _ => true,
            },
            ExprKind::Term(name) => {
                self.rules.terms.get(name).is_none_or(|term| self.asks_the_future(&term.value))
            }
            // What is added up over the whole motion.
            ExprKind::Attribute(_, attribute) => match attribute {
                Attribute::Element(attribute) => match attribute {
                    ElementAttribute::Path
                    | ElementAttribute::Slid
                    | ElementAttribute::Yaw
                    | ElementAttribute::Touching
                    | ElementAttribute::Sliding => true,
                    ElementAttribute::Size | ElementAttribute::Part | ElementAttribute::Cell => false,
                },
                attribute => *attribute == Attribute::Part(PartAttribute::Work),
            },
            _ => false,
        })
    }

    fn at(&self, track: &Expr, time: &Expr, locals: &mut Vec<Known>) -> Result<Known, EvalError> {
        let Underway { recording, now, pace } = self.underway;
        let time = self.of(time, locals)?;
        let ExprKind::Attribute(of, Attribute::Track(track)) = &track.kind else {
            return Ok(Known::Nothing);
        };
        let of = self.of(of, locals)?;
        let (Some(Value::Number(time)), Some(Value::Reference(of))) = (time.exactly(), of.exactly()) else {
            return Ok(Known::Nothing);
        };
        if *time <= now {
            return Ok(self.scope.track(*of, *track, *time).map_or(Known::Nothing, Known::Exactly));
        }
        let end = recording.motion.duration;
        if *track != Track::Position || *time < end {
            return Ok(Known::Nothing);
        }
        Ok(match self.scope.track(*of, *track, now) {
            Some(Value::Vector([x, _, z])) => Known::Around([x, z], pace * (end - now)),
            _ => Known::Nothing,
        })
    }

    fn gather(&self, expr: &Expr, binder: &Binder, locals: &mut Vec<Known>) -> Result<Known, EvalError> {
        let ExprKind::Aggregate { how, share, condition, body: Some(body), .. } = &expr.kind else {
            return Ok(Known::Nothing);
        };
        let share = share.as_ref().map(|share| self.of(share, locals)).transpose()?;
        let over = self.of(&binder.over, locals)?;
        let Some(Value::List(items)) = over.exactly() else { return Ok(Known::Nothing) };
        let depth = locals.len();
        locals.resize(depth.max(binder.slot + 1), Known::Nothing);
        let before = locals[binder.slot].clone();
        let mut ranges = Vec::with_capacity(items.len());
        let mut is_known = true;
        for item in items.iter() {
            locals[binder.slot] = Known::Exactly(item.clone());
            match condition.as_ref().map(|condition| self.of(condition, locals)).transpose()? {
                None | Some(Known::Exactly(Value::Bool(true))) => {}
                Some(Known::Exactly(Value::Bool(false))) => continue,
                Some(_) => {
                    is_known = false;
                    break;
                }
            }
            ranges.push(self.of(body, locals)?.range());
        }
        locals[binder.slot] = before;
        locals.truncate(depth);
        if !is_known || ranges.is_empty() {
            return Ok(Known::Nothing);
        }
        let count = ranges.len() as f64;
        let sums = ranges.iter().fold((0.0, 0.0), |sum, range| (sum.0 + range.0, sum.1 + range.1));
        let least = |end: fn(&(f64, f64)) -> f64| ranges.iter().map(end).fold(f64::INFINITY, f64::min);
        let most = |end: fn(&(f64, f64)) -> f64| ranges.iter().map(end).fold(f64::NEG_INFINITY, f64::max);
        Ok(match how {
            Gather::Sum => Known::between(sums.0, sums.1),
            Gather::Mean => Known::between(sums.0 / count, sums.1 / count),
            Gather::Min => Known::between(least(|r| r.0), least(|r| r.1)),
            Gather::Max => Known::between(most(|r| r.0), most(|r| r.1)),
            // A quantile grows with each of the values.
            Gather::Quantile => match share.as_ref().and_then(Known::exactly) {
                Some(Value::Number(share)) if (0.0..=1.0).contains(share) => {
                    let of = |end: fn(&(f64, f64)) -> f64| {
                        quantile(&mut ranges.iter().map(end).collect::<Vec<_>>(), *share)
                    };
                    Known::between(of(|r| r.0), of(|r| r.1))
                }
                _ => Known::Nothing,
            },
            Gather::Count | Gather::Deviation | Gather::Clusters | Gather::Forall | Gather::Exists => {
                Known::Nothing
            }
        })
    }
}

/// The locals as values, if all that are there are known.
fn values(locals: &[Known]) -> Option<Vec<Value>> {
    locals.iter().map(|local| local.exactly().cloned()).collect()
}

fn binary(a: &Known, operator: Operator, b: &Known) -> Known {
    // Differences of places along the ground.
    let place = |known: &Known| match known {
        Known::Around(centre, radius) => Some((*centre, *radius)),
        Known::Exactly(Value::Vector([x, _, z])) => Some(([*x, *z], 0.0)),
        _ => None,
    };
    if let (Some((a, r)), Some((b, s))) = (place(a), place(b)) {
        return match operator {
            Operator::Add => Known::Around([a[0] + b[0], a[1] + b[1]], r + s),
            Operator::Subtract => Known::Around([a[0] - b[0], a[1] - b[1]], r + s),
            _ => Known::Nothing,
        };
    }
    let ((a, b), (c, d)) = (a.range(), b.range());
    let corners = |values: [f64; 4]| {
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if values.iter().any(|x| x.is_nan()) { Known::Nothing } else { Known::between(low, high) }
    };
    match operator {
        Operator::Add => Known::between(a + c, b + d),
        Operator::Subtract => Known::between(a - d, b - c),
        Operator::Multiply => corners([a * c, a * d, b * c, b * d]),
        Operator::Divide if c > 0.0 || d < 0.0 => corners([a / c, a / d, b / c, b / d]),
        _ => Known::Nothing,
    }
}

fn call(function: Function, known: &[Known]) -> Known {
    let ranges: Vec<(f64, f64)> = known.iter().map(Known::range).collect();
    match (function, known, &ranges[..]) {
        (Function::Horizontal, [Known::Around([x, z], radius)], _) => {
            let centre = libm::hypot(*x, *z);
            Known::between((centre - radius).max(0.0), centre + radius)
        }
        (Function::Min, _, [first, rest @ ..]) => {
            let (low, high) = rest.iter().fold(*first, |a, b| (a.0.min(b.0), a.1.min(b.1)));
            Known::between(low, high)
        }
        (Function::Max, _, [first, rest @ ..]) => {
            let (low, high) = rest.iter().fold(*first, |a, b| (a.0.max(b.0), a.1.max(b.1)));
            Known::between(low, high)
        }
        (Function::Abs, _, [(low, high)]) => {
            let least = if *low <= 0.0 && *high >= 0.0 { 0.0 } else { low.abs().min(high.abs()) };
            Known::between(least, low.abs().max(high.abs()))
        }
        (Function::Clamp, _, [x, low, high]) => {
            Known::between(x.0.max(low.0).min(high.0), x.1.max(low.1).min(high.1))
        }
        (Function::Sqrt, _, [(low, high)]) if *low >= 0.0 => {
            Known::between(libm::sqrt(*low), libm::sqrt(*high))
        }
        _ => Known::Nothing,
    }
}
