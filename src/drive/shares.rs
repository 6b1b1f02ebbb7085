//! Parameters as shares of their ranges, for methods that know one scale; and parameters of one body as
//! those of another.

use grammar_lang::ir::{Ty, Variable};

use super::mutate::inside;
use super::{Drive, Holder, Parameters};
use crate::derive::random::Stream;

impl Drive<'_> {
    /// The values of all varied quantities with what is declared of each, in order.
    pub(crate) fn declared(&self) -> impl Iterator<Item = &Variable> {
        let fields = self.fields.iter().filter_map(|field| self.variable(field));
        fields.flat_map(|variable| std::iter::repeat_n(variable, variable.size.unwrap_or(1)))
    }

    /// Where values lie within their ranges: 0 at the low end, 1 at the high one.
    #[must_use]
    pub fn shares(&self, parameters: &[f64]) -> Vec<f64> {
        let share = |(variable, x): (&Variable, &f64)| {
            let (low, high) = ends(variable);
            match variable.ty {
                // In the middle of the shares that mean it.
                Ty::Bool => 0.25 + 0.5 * x,
                _ if high > low => (x - low) / (high - low),
                _ => 0.5,
            }
        };
        self.declared().zip(parameters).map(share).collect()
    }

    /// The values at shares of their ranges, and the shares at which they were taken: those beyond a range
    /// are brought back as the variable's bound says.
    #[must_use]
    pub fn at_shares(&self, shares: &[f64], random: &mut Stream) -> (Parameters, Vec<f64>) {
        let mut take = |(variable, share): (&Variable, &f64)| {
            let (low, high) = ends(variable);
            let share = inside(*share, (0.0, 1.0), variable.mutation.bound, random);
            let x = low + (high - low) * share;
            let x = match variable.ty {
                Ty::Bool => f64::from(u8::from(share >= 0.5)),
                Ty::Count => libm::round(x),
                _ => x,
            };
            // Rounding must not lead out of the range.
            (x.max(low).min(high), share)
        };
        self.declared().zip(shares).map(&mut take).unzip()
    }

    /// The values of another body's drive for the actuators that both have, and what is shared; and those
    /// given for the others.
    #[must_use]
    pub fn inherit(&self, from: &Drive<'_>, parameters: &[f64], others: Parameters) -> Parameters {
        let mut inherited = others;
        for field in &self.fields {
            let (Some(variable), Some((name, _))) =
                (self.variable(field), self.actuations.get(field.actuation))
            else {
                continue;
            };
            let same = from.fields.iter().find(|other| match field.holder {
                Holder::Policy(number) => {
                    let of = match other.holder {
                        Holder::Policy(number) => from.policies.get(number),
                        _ => None,
                    };
                    self.policies.get(number).zip(of).is_some_and(|(own, other)| own.is_alike(other))
                }
                Holder::Everyone => {
                    other.holder == field.holder
                        && from.variable(other).is_some_and(|v| v.name == variable.name)
                }
                _ => {
                    from.actuations.get(other.actuation).is_some_and(|(other, _)| other == name)
                        && (other.variable, &other.holder) == (field.variable, &field.holder)
                }
            });
            let size = variable.size.unwrap_or(1);
            let Some(known) = same.and_then(|other| parameters.get(other.start..other.start + size)) else {
                continue;
            };
            if let Some(own) = inherited.get_mut(field.start..field.start + size) {
                own.copy_from_slice(known);
            }
        }
        inherited
    }
}

fn ends(variable: &Variable) -> (f64, f64) {
    if variable.ty == Ty::Bool { (0.0, 1.0) } else { variable.domain }
}
