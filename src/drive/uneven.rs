//! Swings that a symmetry of the motion forbids.
//!
//! Where the images of a mirror run half a period later than their originals, the mirror image of the body does half a
//! period later what the body does now. An actuator on the plane of the mirror that swings across it is its own image:
//! it keeps this symmetry only if `angle(t + period / 2) = -angle(t)`. The same holds for distances and speeds.

use grammar_lang::diagnostics::{Code, Diagnostic};
use grammar_lang::eval::EvalError;
use grammar_lang::ir::{Actuation, Symmetry, Ty};
use grammar_lang::source::Span;

use super::{Drive, Driven};
use crate::derive::Candidate;
use crate::derive::random::Stream;
use crate::design::assembly::{Dof, Travel};

/// Draws of what the actuations vary, and moments of a period, at which they are compared.
const DRAWS: u64 = 4;
const MOMENTS: usize = 32;
/// Two angles or distances that differ by no more than this share of the greatest are equal.
const CLOSE: f64 = 1e-3;

pub(super) fn told(kind: &str, actuation: &Actuation, example: Option<(&str, Span)>) -> Diagnostic {
    let told = Diagnostic::new(
        Code::UNEVEN_SWING,
        actuation.drive.span,
        format!("`{kind}` lies on the mirror plane, but its drive does not change sign half a period later"),
    )
    .label("all images run half a period later, so this drive should then have the opposite sign");
    let told = match example {
        Some((name, span)) => told.also(span, format!("here in `{name}`")),
        None => told,
    };
    told.help(
        "the robot may walk in a curve; where `a.own_image` holds, drive `(x - y) / 2`, where y is x half a period later, as \
         `alternating_pac` of `std.actuation` does",
    )
}

impl<'r> Drive<'r> {
    /// An actuator that breaks the symmetry of a motion which has it otherwise: its kind, and what drives it.
    pub(super) fn uneven_swing(&self) -> Result<Option<(String, &'r Actuation)>, EvalError> {
        let swinging: Vec<_> = self.across_the_mirror().collect();
        // What reacts has no motion that is known ahead.
        if swinging.is_empty() || self.actuators.iter().any(|driven| self.reacts(driven)) {
            return Ok(None);
        }
        let mut uneven = None;
        for draw in 0..DRAWS {
            let parameters = self.draw(&mut Stream::named(draw, "swings"));
            if !self.takes_turns(&parameters)? {
                return Ok(None);
            }
            for driven in &swinging {
                let (now, later) = self.half_a_period_apart(driven, driven, &parameters)?;
                if uneven.is_none() && !are_close(&now, later.iter().map(|angle| -angle)) {
                    uneven = Some(*driven);
                }
            }
        }
        Ok(uneven.and_then(|driven| {
            let (_, actuation) = self.actuations.get(driven.actuation)?;
            Some((self.kind_of(driven)?.to_owned(), *actuation))
        }))
    }

    /// The actuators that are their own images, and turn about an axis in the plane of the mirror or slide across it.
    fn across_the_mirror(&self) -> impl Iterator<Item = &Driven> {
        let Candidate { rules, derivation, body } = &self.candidate;
        let normal = if let Symmetry::Mirror(normal) = rules.symmetry { Some(normal) } else { None };
        let crosses = move |column: usize, dof: &Dof| {
            let along = normal.and_then(|normal| dof.axis.get(normal)).map_or(1.0, |part| part.abs());
            let across = match dof.travel {
                Travel::Turn => along < CLOSE,
                Travel::Slide => along > 1.0 - CLOSE,
            };
            dof.actuator() == Some(column) && across
        };
        self.actuators.iter().enumerate().filter_map(move |(column, driven)| {
            let part = derivation.design.parts.get(&driven.id)?;
            let is_own = part.image == 0 && !part.alone && derivation.design.twin(driven.id) == driven.id;
            let mut dofs = body.assembly.joints.iter().flat_map(|joint| joint.kind.dofs());
            (is_own && !self.has_valves(driven) && dofs.any(|dof| crosses(column, dof))).then_some(driven)
        })
    }

    /// Whether there are images, and all run half a period later than their originals.
    fn takes_turns(&self, parameters: &[f64]) -> Result<bool, EvalError> {
        let design = self.candidate.design();
        let mut moves = false;
        for driven in &self.actuators {
            let Some(original) = design.parts.get(&driven.id).and_then(|part| part.image_of) else {
                continue;
            };
            let Some(original) = self.actuators.iter().find(|other| other.id == original) else { continue };
            if self.has_valves(driven) {
                return Ok(false);
            }
            let (now, later) = self.half_a_period_apart(driven, original, parameters)?;
            if !are_close(&now, later.iter().copied()) {
                return Ok(false);
            }
            let first = now.first().copied().unwrap_or_default();
            moves = moves || now.iter().any(|angle| (angle - first).abs() > CLOSE);
        }
        Ok(moves)
    }

    /// What one actuator is asked for in a period near the end, when it has settled, and another half a period later.
    fn half_a_period_apart(
        &self,
        one: &Driven,
        other: &Driven,
        parameters: &[f64],
    ) -> Result<(Vec<f64>, Vec<f64>), EvalError> {
        let period = self.period_of(|kind| Some(kind) == self.kind_of(one), parameters)?;
        let begin = ((self.task.model.duration / period).floor() - 2.0).max(1.0);
        let times = |from: f64| (0..MOMENTS).map(move |i| period * (from + i as f64 / MOMENTS as f64));
        Ok((self.bends(one, parameters, times(begin))?, self.bends(other, parameters, times(begin + 0.5))?))
    }

    fn has_valves(&self, driven: &Driven) -> bool {
        self.actuations.get(driven.actuation).is_some_and(|(_, actuation)| actuation.drive.ty == Ty::Valves)
    }
}

/// Whether two actuators are asked for the same.
fn are_close(one: &[f64], other: impl Iterator<Item = f64>) -> bool {
    let most = one.iter().fold(0.0_f64, |most, angle| most.max(angle.abs()));
    one.iter().zip(other).all(|(a, b)| (a - b).abs() <= CLOSE * most)
}
