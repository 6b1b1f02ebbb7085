//! The best design of each kind (MAP-Elites, Mouret and Clune 2015): kinds are told apart by what the
//! grammar's descriptors say of a design and of its motion. A move changes one of the designs that are kept.

use std::sync::Arc;

use grammar_lang::ir::{Archive, Descriptor};

use super::super::evaluator::Evaluator;
use super::super::state::{Best, Designs, Incumbent, Trial};
use super::super::{Bounds, Failure};
use super::{Bodies, Described, End};
use crate::derive::random::Stream;
use crate::derive::{Candidate, Derivation};

/// The cell that a value falls into; what lies beyond the ends belongs to the outermost ones.
fn cell(descriptor: &Descriptor, value: f64) -> usize {
    let share = (value - descriptor.from) / (descriptor.to - descriptor.from);
    let cell = libm::floor(share * descriptor.cells as f64).max(0.0);
    (cell as usize).min(descriptor.cells.saturating_sub(1))
}

impl Bodies<'_> {
    /// One of the designs that are kept, each with the same chance.
    pub(super) fn elite(&self, random: &mut Stream) -> Option<&Best> {
        let archive = self.state.archive();
        if archive.is_empty() {
            return None;
        }
        archive.get(random.below(archive.len())).map(|(_, best)| best)
    }

    /// What kind of design the body is that is being tried. It takes an evaluation.
    pub(super) fn describe(&mut self) -> Result<Described, Failure> {
        let Some(Archive { descriptors }) = self.rules.search.archive() else {
            return Ok(Described::Nothing);
        };
        let (Some(Trial { derivation, body, .. }), Some(task)) = (&self.state.trial, self.rules.first_task())
        else {
            return Ok(Described::Nothing);
        };
        let Some(tune) = body.tunes.first().filter(|_| body.tunes.len() == self.rules.tasks.len()) else {
            return Ok(Described::Nothing);
        };
        let candidate = Candidate::new(self.rules, Arc::clone(derivation));
        let mut evaluator = Evaluator::new(&candidate, task, self.engine, None)?;
        let described: Vec<_> = descriptors.values().map(|descriptor| &descriptor.value).collect();
        let Bounds { stop, .. } = self.bounds;
        let Some(values) = evaluator.describe(stop, &tune.parameters, &described) else {
            return Ok(Described::Stopped(self.bounds.stopped().unwrap_or(End::Interrupted)));
        };
        self.state.spent += 1;
        match values {
            Ok(values) => Ok(Described::Cell(
                descriptors.values().zip(values).map(|(d, value)| cell(d, value)).collect(),
            )),
            Err(why) => {
                // A design that nothing can be said of is of no kind.
                if let Some(Trial { body, .. }) = &mut self.state.trial {
                    body.tally.count(why);
                }
                Ok(Described::Nothing)
            }
        }
    }

    /// Keeps a design if it is the best of its kind; whether it is.
    pub(super) fn keep_of_kind(
        &mut self,
        cell: Vec<usize>,
        place: Incumbent<Arc<Derivation>>,
    ) -> Result<bool, Failure> {
        let Some(value) = place.value else { return Ok(false) };
        let direction = self.rules.objective.direction;
        let Some(Designs::Archive(archive)) = &mut self.state.designs else { return Ok(false) };
        let found = archive.binary_search_by(|(known, _)| known.cmp(&cell));
        if let Ok(known) = found
            && direction.fitness(archive[known].1.value) >= direction.fitness(value)
        {
            return Ok(false);
        }
        let Incumbent { derivation, tunes, .. } = place;
        let best = Best { derivation, tasks: tunes, value, beside: Vec::new(), found_at: self.state.moves };
        let place = match found {
            Ok(known) => {
                archive[known].1 = best;
                known
            }
            Err(free) => {
                archive.insert(free, (cell, best));
                free
            }
        };
        self.observer.kept(archive, place)?;
        Ok(true)
    }
}

#[cfg(test)]
mod tests {
    use grammar_lang::ir::{Descriptor, Expr, ExprKind, Ty};

    use super::cell;

    #[test]
    fn cells_are_even_and_the_outermost_are_open() {
        let value = Expr { kind: ExprKind::Number(0.0), ty: Ty::NUMBER, span: Default::default() };
        let descriptor = Descriptor { value, from: 2.0, to: 12.0, cells: 5 };
        let cells: Vec<usize> = [-7.0, 2.0, 3.9, 4.0, 11.9, 12.0, 99.0].map(|x| cell(&descriptor, x)).into();
        assert_eq!(cells, [0, 0, 0, 1, 4, 4, 4]);
        assert_eq!(cell(&descriptor, f64::NAN), 0);
    }
}
