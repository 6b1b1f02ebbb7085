//! A design that is to be simulated and scored, with all that it is a design of.

use std::sync::Arc;

use grammar_lang::eval::Unmade;
use grammar_lang::ir::RuleSet;
use nalgebra::UnitQuaternion;

use super::Derivation;
use crate::design::assembly::Shape;
use crate::design::{Body, Design, Part};

/// A design with the rules that made it, how they made it, and the body that it is. Copies share all of it.
#[derive(Clone, Debug)]
pub struct Candidate<'r> {
    /// The rules.
    pub rules: &'r RuleSet,
    /// How they made the design.
    pub derivation: Arc<Derivation>,
    /// Its elements and joints.
    pub body: Arc<Body>,
}

impl<'r> Candidate<'r> {
    /// The body of a derivation.
    #[must_use]
    pub fn new(rules: &'r RuleSet, derivation: Arc<Derivation>) -> Self {
        let body = Arc::new(Body::new(&derivation.design, rules));
        Self { rules, derivation, body }
    }

    /// The same body under rules that say otherwise only what drives it.
    ///
    /// # Errors
    ///
    /// An actuator that these rules leave without a range or a speed.
    pub fn under<'s>(&self, rules: &'s RuleSet) -> Result<Candidate<'s>, Unmade> {
        let mut derivation = Derivation::clone(&self.derivation);
        derivation.design.remake(rules)?;
        Ok(Candidate { rules, derivation: derivation.into(), body: Arc::clone(&self.body) })
    }

    /// The same, but actuators move as far and as fast as other rules say ([`Design::move_as`]).
    ///
    /// # Errors
    ///
    /// An actuator that they leave without a range or a speed.
    pub fn moving_as(self, rules: &RuleSet, there: Option<&Design>) -> Result<Self, Unmade> {
        let mut derivation = Derivation::clone(&self.derivation);
        derivation.design.move_as(rules, there)?;
        Ok(Candidate { derivation: derivation.into(), ..self })
    }

    /// How an element lies in the frame of its part. Balls that fill a part have none of their own.
    #[must_use]
    pub fn lies(&self, element: usize) -> Option<UnitQuaternion<f64>> {
        let is_filled = matches!(self.body.assembly.elements.get(element)?.shape, Shape::Ball { .. });
        let part = self.body.parts_of_elements.get(element)?;
        let part = self.design().parts.get(part).filter(|_| !is_filled);
        Some(part.map_or_else(UnitQuaternion::identity, Part::rotation_of_element))
    }

    /// The design.
    #[must_use]
    pub fn design(&self) -> &Design {
        &self.derivation.design
    }
}
