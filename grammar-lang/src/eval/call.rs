//! Calls of built-in functions.

use std::sync::Arc;

use super::{Curve, Evaluation, Result_, Value, fail, missing};
use crate::ir::{Expr, ExprKind, Function, Shape};

impl Evaluation<'_> {
    pub(super) fn call(&mut self, expr: &Expr, function: Function, arguments: &[Expr]) -> Result_ {
        use Function as F;
        if function == F::Count
            && let [Expr { kind: ExprKind::Group(group), .. }] = arguments
        {
            let group = self.scope.group(group).ok_or_else(|| missing(expr))?;
            return Ok(Value::Number(group.len() as f64));
        }
        let values = self.values(arguments)?;
        let number = |i: usize| match values.get(i) {
            Some(Value::Number(x)) => Ok(*x),
            _ => Err(missing(expr)),
        };
        let list = |i: usize| values.get(i).map(Value::items).ok_or_else(|| missing(expr));
        let times = |i: usize| number(i).map(|n| n.clamp(0.0, 10_000.0) as usize);
        Ok(match function {
            F::Abs => Value::Number(number(0)?.abs()),
            F::Min | F::Max => {
                let mut best = number(0)?;
                for i in 1..values.len() {
                    let x = number(i)?;
                    if (x < best) == (function == F::Min) {
                        best = x;
                    }
                }
                Value::Number(best)
            }
            F::Clamp => Value::Number(number(0)?.min(number(2)?).max(number(1)?)),
            F::Floor => Value::Number(libm::floor(number(0)?)),
            F::Ceil => Value::Number(libm::ceil(number(0)?)),
            F::Round => Value::Number(libm::round(number(0)?)),
            F::Fraction => Value::Number(number(0)? - libm::floor(number(0)?)),
            F::Sqrt if number(0)? < 0.0 => return fail(expr, "a negative number has no square root"),
            F::Sqrt => Value::Number(number(0)?.sqrt()),
            F::Exp => Value::Number(libm::exp(number(0)?)),
            F::Ln if number(0)? <= 0.0 => return fail(expr, "only a positive number has a logarithm"),
            F::Ln => Value::Number(libm::log(number(0)?)),
            F::Sin => Value::Number(libm::sin(number(0)?)),
            F::Cos => Value::Number(libm::cos(number(0)?)),
            F::Tan => Value::Number(libm::tan(number(0)?)),
            F::Arc => Value::Number(number(0)? * number(1)?),
            F::Length | F::Horizontal | F::Height => {
                let Some(Value::Vector([x, y, z])) = values.first() else { return Err(missing(expr)) };
                Value::Number(match function {
                    F::Length => (x * x + y * y + z * z).sqrt(),
                    F::Horizontal => (x * x + z * z).sqrt(),
                    _ => *y,
                })
            }
            F::Vector => Value::Vector([number(0)?, number(1)?, number(2)?]),
            F::Heading => {
                let Some(Value::Rotation([w, x, y, z])) = values.first() else { return Err(missing(expr)) };
                // The rotated x axis; left of forward is towards -z.
                let (ahead, right) = (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * z - w * y));
                Value::Number(libm::atan2(-right, ahead))
            }
            F::Bearing => {
                let Some(Value::Vector([x, _, z])) = values.first() else { return Err(missing(expr)) };
                Value::Number(libm::atan2(-z, *x))
            }
            F::Wrap => {
                let turn = 2.0 * std::f64::consts::PI;
                let x = number(0)?;
                Value::Number(x - turn * libm::round(x / turn))
            }
            F::Angle => {
                let (Some(Value::Rotation(a)), Some(Value::Rotation(b))) = (values.first(), values.get(1))
                else {
                    return Err(missing(expr));
                };
                let dot: f64 = a.iter().zip(b).map(|(x, y)| x * y).sum();
                Value::Number(2.0 * libm::acos(dot.abs().min(1.0)))
            }
            F::Count => Value::Number(list(0)?.len() as f64),
            F::Each => {
                let n = times(1)?;
                Value::List(list(0)?.iter().flat_map(|x| std::iter::repeat_n(x.clone(), n)).collect())
            }
            F::Repeat => {
                let item = values.first().ok_or_else(|| missing(expr))?;
                Value::List(std::iter::repeat_n(item.clone(), times(1)?).collect())
            }
            F::First | F::Last => {
                let items = list(0)?;
                let item = if function == F::First { items.first() } else { items.last() };
                match item {
                    Some(item) => item.clone(),
                    None => return fail(expr, "an empty list has no such item"),
                }
            }
            F::Bezier => {
                let points: Vec<f64> = list(0)?
                    .iter()
                    .map(|v| if let Value::Number(x) = v { Ok(*x) } else { Err(missing(expr)) })
                    .collect::<Result<_, _>>()?;
                match Curve::bezier(&points) {
                    Some(curve) => Value::Curve(Arc::new(curve)),
                    None => return fail(expr, "a Bezier curve has 2 to 64 control points"),
                }
            }
            F::Box => Value::Shape(Shape::Box([number(0)?, number(1)?, number(2)?])),
            F::Sphere => Value::Shape(Shape::Sphere(number(0)?)),
            F::Cylinder => Value::Shape(Shape::Cylinder(number(0)?, number(1)?)),
            F::Disk => Value::Shape(Shape::Disk(number(0)?, number(1)?)),
            F::Normal | F::Uniform => {
                Value::List([Value::Number(number(0)?), Value::Number(number(1)?)].into())
            }
            F::Gain | F::Neighbours | F::Images => {
                self.scope.call(function, &values).ok_or_else(|| missing(expr))?
            }
        })
    }
}
