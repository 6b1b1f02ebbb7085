//! Calls of built-in functions.

use std::sync::Arc;

use super::{
    Curve, EvalError, Evaluation, MOST, NoCycle, Result_, Value, Valve, Valves, fail, missing, order,
};
use crate::ir::{DesignFunction, DesignWord, Expr, ExprKind, Function, Word};

impl Function {
    /// Whether it makes a number out of numbers alone.
    pub(super) fn is_numeric(self) -> bool {
        use Function as F;
        matches!(
            self,
            F::Abs
                | F::Min
                | F::Max
                | F::Clamp
                | F::Floor
                | F::Ceil
                | F::Round
                | F::Fraction
                | F::Sqrt
                | F::Exp
                | F::Ln
                | F::Sin
                | F::Cos
                | F::Tan
                | F::Asin
                | F::Acos
                | F::Atan2
                | F::Arc
                | F::Wrap
        )
    }
}

impl Evaluation<'_> {
    /// A function that [is numeric](Function::is_numeric).
    pub(super) fn numeric(
        &mut self,
        expr: &Expr,
        function: Function,
        arguments: &[Expr],
    ) -> Result<f64, EvalError> {
        use Function as F;
        let Some((first, rest)) = arguments.split_first() else { return Err(missing(expr)) };
        let x = self.number(first)?;
        Ok(match function {
            F::Abs => x.abs(),
            F::Min | F::Max => {
                let mut best = x;
                for other in rest {
                    let x = self.number(other)?;
                    if (x < best) == (function == F::Min) {
                        best = x;
                    }
                }
                best
            }
            F::Clamp => {
                let [low, high] = rest else { return Err(missing(expr)) };
                let low = self.number(low)?;
                x.min(self.number(high)?).max(low)
            }
            F::Floor => order::floor(x),
            F::Ceil => order::ceil(x),
            F::Round => libm::round(x),
            F::Fraction => order::fraction(x),
            F::Sqrt if x < 0.0 => return fail(expr, "a negative number has no square root"),
            F::Sqrt => x.sqrt(),
            F::Exp => libm::exp(x),
            F::Ln if x <= 0.0 => return fail(expr, "only a positive number has a logarithm"),
            F::Ln => libm::log(x),
            F::Sin => libm::sin(x),
            F::Cos => libm::cos(x),
            F::Tan => libm::tan(x),
            F::Asin | F::Acos if !order::is_within(-1.0, x, 1.0) => {
                return fail(expr, "`asin` and `acos` need a number within -1 .. 1");
            }
            F::Asin => libm::asin(x.clamp(-1.0, 1.0)),
            F::Acos => libm::acos(x.clamp(-1.0, 1.0)),
            // Half a turn is positive, as of `wrap`: rounding makes zeros with either sign.
            F::Atan2 => libm::atan2(x + 0.0, self.number(rest.first().ok_or_else(|| missing(expr))?)? + 0.0),
            F::Arc => x * self.number(rest.first().ok_or_else(|| missing(expr))?)?,
            F::Wrap => {
                let turn = 2.0 * std::f64::consts::PI;
                // Half a turn is positive, whichever way it was made.
                x - turn * order::ceil(x / turn - 0.5)
            }
            _ => return Err(missing(expr)),
        })
    }

    /// Counts the items of a list that is to be made.
    fn list_of(&mut self, expr: &Expr, items: usize) -> Result<(), EvalError> {
        if items > MOST {
            return fail(expr, format!("this makes a list of {items} items, and a list has at most {MOST}"));
        }
        self.spend(expr, items as u64)
    }

    pub(super) fn call(&mut self, expr: &Expr, function: Function, arguments: &[Expr]) -> Result_ {
        use Function as F;
        if function == F::Count
            && let [Expr { kind: ExprKind::Group(group), .. }] = arguments
        {
            let group = self.scope.group(group).ok_or_else(|| missing(expr))?;
            return Ok(Value::Number(group.len() as f64));
        }
        if function.is_numeric() {
            return Ok(Value::Number(self.numeric(expr, function, arguments)?));
        }
        let values = self.values(arguments)?;
        let number = |i: usize| match values.get(i) {
            Some(Value::Number(x)) => Ok(*x),
            _ => Err(missing(expr)),
        };
        let list = |i: usize| values.get(i).map(Value::items).ok_or_else(|| missing(expr));
        let times = |i: usize| number(i).map(|n| n.clamp(0.0, 1e15) as usize);
        Ok(match function {
            F::Length
            | F::Horizontal
            | F::Height
            | F::Vector
            | F::Heading
            | F::Bearing
            | F::Inclination
            | F::Rotated
            | F::Inverse
            | F::Angle => geometric(function, &values).ok_or_else(|| missing(expr))?,
            F::Count => Value::Number(list(0)?.len() as f64),
            F::Each => {
                let n = times(1)?;
                self.list_of(expr, list(0)?.len().saturating_mul(n))?;
                Value::List(list(0)?.iter().flat_map(|x| std::iter::repeat_n(x.clone(), n)).collect())
            }
            F::Repeat => {
                let item = values.first().ok_or_else(|| missing(expr))?;
                let n = times(1)?;
                self.list_of(expr, n)?;
                Value::List(std::iter::repeat_n(item.clone(), n).collect())
            }
            F::First | F::Last => {
                let items = list(0)?;
                let item = if function == F::First { items.first() } else { items.last() };
                match item {
                    Some(item) => item.clone(),
                    None => return fail(expr, "an empty list has no first or last item"),
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
            F::Cycle => {
                let turns = turns(&values).ok_or_else(|| missing(expr))?;
                match turns {
                    Ok(valves) => Value::Valves(Arc::new(valves)),
                    Err(reason) => return fail(expr, reason.to_string()),
                }
            }
            F::Normal | F::Uniform => {
                Value::List([Value::Number(number(0)?), Value::Number(number(1)?)].into())
            }
            F::Design(DesignFunction::Cell) => match self.scope.call(DesignFunction::Cell, &values) {
                Some(cell) => cell,
                None if self.scope.word(Word::Design(DesignWord::Middle)).is_some() => {
                    return fail(expr, "the lattice has no such place");
                }
                None => return Err(missing(expr)),
            },
            F::Solid(solid) => {
                let lengths: Vec<f64> = (0..solid.lengths()).map(number).collect::<Result<_, _>>()?;
                match solid.form(&lengths) {
                    Ok(form) => Value::Shape(form),
                    Err(reason) => return fail(expr, reason),
                }
            }
            F::Design(function) => self.scope.call(function, &values).ok_or_else(|| missing(expr))?,
            F::Gain => {
                let gain = self.scope.gain(number(0)?.max(0.0) as usize);
                Value::Number(gain.ok_or_else(|| missing(expr))?)
            }
            // The numeric ones.
            _ => return Err(missing(expr)),
        })
    }
}

/// A function of vectors and rotations.
fn geometric(function: Function, values: &[Value]) -> Option<Value> {
    use Function as F;
    Some(match (function, values) {
        (F::Length, [Value::Vector([x, y, z])]) => Value::Number((x * x + y * y + z * z).sqrt()),
        (F::Horizontal, [Value::Vector([x, _, z])]) => Value::Number((x * x + z * z).sqrt()),
        (F::Height, [Value::Vector([_, y, _])]) => Value::Number(*y),
        (F::Vector, [Value::Number(x), Value::Number(y), Value::Number(z)]) => Value::Vector([*x, *y, *z]),
        (F::Heading, [Value::Rotation([w, x, y, z])]) => {
            // The rotated x axis; left of forward is towards -z.
            let (ahead, right) = (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * z - w * y));
            // A zero is positive: half a turn is, too.
            Value::Number(libm::atan2(0.0 - right, ahead))
        }
        // The height of the rotated y axis.
        (F::Inclination, [Value::Rotation([_, x, _, z])]) => {
            Value::Number(libm::acos((1.0 - 2.0 * (x * x + z * z)).clamp(-1.0, 1.0)))
        }
        (F::Bearing, [Value::Vector([x, _, z])]) => Value::Number(libm::atan2(0.0 - z, *x)),
        (F::Rotated, [Value::Vector(v), Value::Rotation(q)]) => Value::Vector(rotated(*v, *q)),
        (F::Inverse, [Value::Rotation([w, x, y, z])]) => Value::Rotation([*w, -x, -y, -z]),
        (F::Angle, [Value::Rotation(a), Value::Rotation(b)]) => {
            let dot: f64 = a.iter().zip(b).map(|(x, y)| x * y).sum();
            Value::Number(2.0 * libm::acos(dot.abs().min(1.0)))
        }
        _ => return None,
    })
}

/// A vector after a rotation that is given by a unit quaternion (w, x, y, z): `v + 2 w (q x v) + 2 q x (q x v)`.
fn rotated([x, y, z]: [f64; 3], [w, a, b, c]: [f64; 4]) -> [f64; 3] {
    // Twice the cross product of the quaternion's vector with v, and that vector crossed with it.
    let [t, u, v] = [2.0 * (b * z - c * y), 2.0 * (c * x - a * z), 2.0 * (a * y - b * x)];
    [x + w * t + b * v - c * u, y + w * u + c * t - a * v, z + w * v + a * u - b * t]
}

/// The states of valves that take turns: `cycle(period, shares, states, phase)`.
fn turns(values: &[Value]) -> Option<Result<Valves, NoCycle>> {
    let [Value::Number(period), shares, states, Value::Number(phase)] = values else { return None };
    let shares: Vec<f64> = shares.items().iter().map(Value::as_number).collect::<Option<_>>()?;
    let state = |value: &Value| match value {
        Value::Valve(state) => Some(*state),
        _ => None,
    };
    let states: Vec<Valve> = states.items().iter().map(state).collect::<Option<_>>()?;
    Some(Valves::cycle(*period, &shares, &states, *phase))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(value: Option<Value>, wanted: [f64; 3]) -> bool {
        let Some(Value::Vector(value)) = value else { return false };
        value.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-12)
    }

    /// The rotation by an angle about an axis of length 1.
    fn about([x, y, z]: [f64; 3], angle: f64) -> Value {
        let (sin, cos) = (libm::sin(angle / 2.0), libm::cos(angle / 2.0));
        Value::Rotation([cos, x * sin, y * sin, z * sin])
    }

    /// What knows nothing.
    struct Nothing;

    impl crate::eval::Scope for Nothing {
        fn outer(&self) -> Option<&dyn crate::eval::Scope> {
            None
        }
    }

    #[test]
    fn angles_of_sines_cosines_and_tangents() {
        let degrees = |function, arguments: &[f64]| {
            let expr = |kind| Expr { kind, ty: crate::ir::Ty::NUMBER, span: crate::source::Span::default() };
            let arguments = arguments.iter().map(|x| expr(ExprKind::Number(*x))).collect();
            let call = expr(ExprKind::Call(function, arguments));
            crate::eval::evaluate_number(&call, &Nothing, &mut Vec::new()).map(f64::to_degrees)
        };
        let near = |found: Result<f64, EvalError>, due: f64| (found.unwrap() - due).abs() < 1e-9;
        assert!(near(degrees(Function::Asin, &[0.5]), 30.0) && near(degrees(Function::Acos, &[-0.5]), 120.0));
        // Rounding may go a little beyond the ends; what lies further out has no angle.
        assert!(near(degrees(Function::Asin, &[1.0 + 1e-15]), 90.0));
        assert!(degrees(Function::Asin, &[1.1]).is_err() && degrees(Function::Acos, &[-2.0]).is_err());
        for (y, x, due) in [(1.0, 0.0, 90.0), (1.0, -1.0, 135.0), (-1.0, -1.0, -135.0), (-0.0, -1.0, 180.0)] {
            assert!(near(degrees(Function::Atan2, &[y, x]), due), "{y}, {x}");
        }
        // Half a turn is positive, whatever the sign of a zero.
        for z in [0.0, -0.0] {
            let back = geometric(Function::Bearing, &[Value::Vector([-1.0, 0.0, z])]);
            assert!(near(Ok(back.unwrap().as_number().unwrap().to_degrees()), 180.0));
        }
    }

    #[test]
    fn a_vector_is_rotated_and_back() {
        let quarter = about([0.0, 0.0, 1.0], std::f64::consts::FRAC_PI_2);
        let rotated = |v: [f64; 3], by: &Value| geometric(Function::Rotated, &[Value::Vector(v), by.clone()]);
        assert!(near(rotated([2.0, 0.0, 0.0], &quarter), [0.0, 2.0, 0.0]));
        assert!(near(rotated([0.0, 2.0, 0.0], &quarter), [-2.0, 0.0, 0.0]));
        let odd = about([0.48, -0.6, 0.64], 2.1);
        let back = geometric(Function::Inverse, std::slice::from_ref(&odd)).unwrap();
        let Some(Value::Vector(there)) = rotated([0.3, -1.2, 0.7], &odd) else { panic!("no vector") };
        assert!(near(rotated(there, &back), [0.3, -1.2, 0.7]));
        // What the other functions say of a rotation follows from where it turns the axes to.
        let ahead = rotated([1.0, 0.0, 0.0], &odd).unwrap();
        let Some(Value::Vector([_, up, _])) = rotated([0.0, 1.0, 0.0], &odd) else { panic!("no vector") };
        let asked =
            |function, of: Value| geometric(function, &[of]).and_then(|value| value.as_number()).unwrap();
        let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
        assert!(near(asked(Function::Heading, odd.clone()), asked(Function::Bearing, ahead)));
        assert!(near(asked(Function::Inclination, odd), libm::acos(up)));
    }
}
