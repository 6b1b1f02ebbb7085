//! The sides of a robot for which a policy decides by the same weights.

use grammar_lang::ir::Policy;

use super::Drive;
use crate::design::PartId;

/// A side of the robot, or all of it.
#[derive(Clone, Debug, Default)]
pub(super) struct Side {
    /// The actuators for which is decided, by their places.
    pub(super) own: Vec<usize>,
    /// The images of these, in the same order.
    others: Vec<usize>,
}

impl Side {
    /// The actuators of which something is known, in this order.
    pub(super) fn known(&self) -> impl Iterator<Item = usize> {
        self.own.iter().chain(&self.others).copied()
    }
}

impl Drive<'_> {
    /// The sides of the robot for which a policy decides: all of it, or the originals and their images in the mirror.
    pub(super) fn sides(&self, name: &str, policy: &Policy) -> Vec<Side> {
        let is_decided = |place: &usize| self.actions_of(*place, name).next().is_some();
        let all = || (0..self.actuators.len()).filter(is_decided);
        if policy.mirrored.is_none() {
            return vec![Side { own: all().collect(), others: Vec::new() }];
        }
        let mut side = Side::default();
        for place in all().filter(|place| self.original(*place).is_none()) {
            let images =
                all().filter(|other| self.original(*other) == self.actuators.get(place).map(|own| own.id));
            if let [image] = images.collect::<Vec<_>>()[..] {
                side.own.push(place);
                side.others.push(image);
            }
        }
        let other = Side { own: side.others.clone(), others: side.own.clone() };
        vec![side, other]
    }

    /// What an actuator is an image of.
    fn original(&self, place: usize) -> Option<PartId> {
        self.candidate.derivation.design.parts.get(&self.actuators.get(place)?.id)?.image_of
    }
}
