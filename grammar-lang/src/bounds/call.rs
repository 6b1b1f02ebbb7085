//! Built-in functions over intervals.

use super::{Abstract, Interval, Kinds, Reasoning};
use crate::eval::order;
use crate::ir::{DesignFunction, Expr, Function};

impl Reasoning<'_> {
    pub(super) fn call(&mut self, expr: &Expr, function: Function, arguments: &[Expr]) -> Abstract {
        use Function as F;
        let values: Vec<Abstract> = arguments.iter().map(|a| self.value(a)).collect();
        let number = |i: usize| values.get(i).map_or(Interval::ALL, Abstract::numbers);
        let first = values.first().cloned().unwrap_or(Abstract::Any);
        let pi = std::f64::consts::PI;
        let is_doubtful = match function {
            F::Sqrt => number(0).low < 0.0,
            F::Ln => number(0).low <= 0.0,
            F::Asin | F::Acos => order::is_less(number(0).low, -1.0) || order::is_less(1.0, number(0).high),
            F::First | F::Last => first.length().low < 1.0,
            _ => false,
        };
        if is_doubtful {
            self.may_fail();
        }
        Abstract::Number(match function {
            F::Abs => number(0).abs(),
            F::Min | F::Max => {
                let pick = |a: f64, b: f64| if function == F::Min { a.min(b) } else { a.max(b) };
                let all = (0..values.len()).map(number);
                all.reduce(|a, b| Interval::new(pick(a.low, b.low), pick(a.high, b.high)))
                    .unwrap_or(Interval::ALL)
            }
            F::Clamp => {
                let (x, low, high) = (number(0), number(1), number(2));
                Interval::new(x.low.min(high.low).max(low.low), x.high.min(high.high).max(low.high))
            }
            F::Floor => number(0).rising(order::floor),
            F::Ceil => number(0).rising(order::ceil),
            F::Round => number(0).rising(libm::round),
            F::Fraction => Interval::new(0.0, 1.0),
            F::Sqrt if number(0).high < 0.0 => {
                return self.fails(expr, "a negative number has no square root");
            }
            F::Sqrt => number(0).rising(|x| x.max(0.0).sqrt()),
            F::Exp => number(0).rising(libm::exp).widened(),
            F::Ln if number(0).high <= 0.0 => {
                return self.fails(expr, "only a positive number has a logarithm");
            }
            F::Ln => number(0).rising(|x| libm::log(x.max(0.0))).widened(),
            F::Sin | F::Cos => match (number(0).single(), function) {
                (Some(x), F::Sin) => Interval::point(libm::sin(x)),
                (Some(x), _) => Interval::point(libm::cos(x)),
                _ => Interval::new(-1.0, 1.0),
            },
            F::Asin | F::Acos
                if order::is_less(1.0, number(0).low) || order::is_less(number(0).high, -1.0) =>
            {
                return self.fails(expr, "`asin` and `acos` need a number within -1 .. 1");
            }
            F::Asin => number(0).rising(|x| libm::asin(x.clamp(-1.0, 1.0))).widened(),
            F::Acos => Interval::new(0.0, pi).widened(),
            F::Arc => number(0).times(number(1)),
            F::Length | F::Horizontal => Interval::NOT_NEGATIVE,
            F::Angle => Interval::new(0.0, 2.0 * pi),
            F::Inclination => Interval::new(0.0, pi).widened(),
            F::Heading | F::Bearing | F::Wrap | F::Atan2 => Interval::new(-pi, pi).widened(),
            F::Count => first.length(),
            F::Each => {
                let times = number(1).rising(|n| libm::floor(n.max(0.0)));
                return Abstract::Many(Box::new(first.item()), first.length().times(times));
            }
            F::Repeat => {
                let times = number(1).rising(|n| libm::floor(n.max(0.0)));
                return Abstract::Many(Box::new(first), times);
            }
            F::First | F::Last if first.length().high <= 0.0 => {
                return self.fails(expr, "an empty list has no first or last item");
            }
            // To rounding, a curve stays within what its control points span.
            F::Bezier => first.item().numbers().widened(),
            F::First | F::Last => return first.item(),
            F::Design(DesignFunction::Neighbours | DesignFunction::HangingOn) => {
                let parts = Abstract::Part(Kinds::all());
                return Abstract::Many(Box::new(parts), Interval::NOT_NEGATIVE);
            }
            F::Design(DesignFunction::Region | DesignFunction::Cell) => return Abstract::Any,
            F::Design(DesignFunction::Images) => {
                let most = self.facts.images() as f64 - 1.0;
                return Abstract::Many(Box::new(first), Interval::new(0.0, most));
            }
            F::Tan
            | F::Height
            | F::Gain
            | F::Vector
            | F::Rotated
            | F::Inverse
            | F::Cycle
            | F::Solid(_)
            | F::Normal
            | F::Uniform => return Abstract::Any,
        })
    }
}
