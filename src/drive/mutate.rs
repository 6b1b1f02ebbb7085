//! Mutation of parameters, as the grammar's kernels say.

use grammar_lang::eval::{EvalError, evaluate};
use grammar_lang::ir::{Bound, Expr, Kernel, Ty};

use super::{Drive, Parameters};
use crate::derive::random::Stream;

/// A kernel whose numbers are known.
enum Change {
    Flip,
    Normal(f64, f64),
    Uniform(f64, f64),
}

impl Drive<'_> {
    /// Changes some values at random; items and actuators independently.
    ///
    /// # Errors
    ///
    /// [`EvalError`] when a probability or a kernel has no value.
    pub fn mutate(
        &self,
        parameters: &[f64],
        temperature: f64,
        iteration: usize,
        random: &mut Stream,
    ) -> Result<Parameters, EvalError> {
        let mut scope = self.scope();
        scope.temperature = temperature;
        scope.iteration = iteration as f64;
        let number = |e: &Expr| evaluate(e, &scope, &mut Vec::new()).map(|v| v.as_number().unwrap_or(0.0));
        let mut out = parameters.to_vec();
        for field in &self.fields {
            let Some(variable) = self.variable(field) else { continue };
            let probability = number(&variable.mutation.probability)?;
            let change = match &variable.mutation.kernel {
                Kernel::Flip => Change::Flip,
                Kernel::Normal(mean, deviation) => Change::Normal(number(mean)?, number(deviation)?),
                Kernel::Uniform(low, high) => Change::Uniform(number(low)?, number(high)?),
            };
            for value in out.iter_mut().skip(field.start).take(variable.size.unwrap_or(1)) {
                if random.unit() >= probability {
                    continue;
                }
                let moved = match change {
                    Change::Flip => {
                        *value = 1.0 - *value;
                        continue;
                    }
                    Change::Normal(mean, deviation) => *value + random.normal(mean, deviation),
                    Change::Uniform(low, high) => *value + low + (high - low) * random.unit(),
                };
                let moved = if variable.ty == Ty::Count { libm::round(moved) } else { moved };
                *value = inside(moved, variable.domain, variable.mutation.bound, random);
                if variable.ty == Ty::Count {
                    *value = libm::round(*value);
                }
            }
        }
        Ok(out)
    }
}

/// Brings a value back into its domain.
pub(super) fn inside(x: f64, (low, high): (f64, f64), bound: Bound, random: &mut Stream) -> f64 {
    if (low..=high).contains(&x) {
        return x;
    }
    let width = high - low;
    match bound {
        _ if width <= 0.0 || !x.is_finite() => low,
        Bound::Clamp => x.max(low).min(high),
        Bound::Resample => low + width * random.unit(),
        Bound::Reflect => {
            // A mirror at each end: the value walks to and fro with the period of twice the width.
            let phase = (x - low) / (2.0 * width);
            let phase = (phase - libm::floor(phase)) * 2.0;
            let folded = if phase > 1.0 { 2.0 - phase } else { phase };
            (low + width * folded).max(low).min(high)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_bring_values_back() {
        let mut random = Stream::named(1, "bounds");
        assert_eq!(inside(3.0, (-2.0, 2.0), Bound::Clamp, &mut random), 2.0);
        assert!((inside(3.0, (-2.0, 2.0), Bound::Reflect, &mut random) - 1.0).abs() < 1e-12);
        assert!((inside(-7.5, (-2.0, 2.0), Bound::Reflect, &mut random) - 0.5).abs() < 1e-12);
        for i in 0..1000 {
            let x = (f64::from(i) - 500.0) * 0.37;
            for bound in [Bound::Clamp, Bound::Reflect, Bound::Resample] {
                let y = inside(x, (-2.0, 2.0), bound, &mut random);
                assert!((-2.0..=2.0).contains(&y), "{x} {bound:?} {y}");
            }
        }
    }
}
