//! Actuators as elastic rods: what hinges leave out.
//!
//! A row of hinges bends about one axis and is rigid otherwise. Silicone is not: it gives way sideways as much as in the driven
//! plane, and twists. Here each row of segments that bends is a beam: rigid discs with elastic links between them, each of six
//! degrees of freedom (`discs`, `links`, `section`). The beam as a whole is as stiff in its driven plane as the row of hinges is, from which
//! its modulus follows; its section says the rest. Other joints stay what they are, with stiff springs in place of what they hold. A
//! motor, and an end of a range that a joint lies on, are in the matrix, too: which limits are active is found by solving the step again.
//!
//! A step is linearly implicit: weight, springs and dampers as they are at its end, in the geometry of its beginning. As bodies and links form a
//! tree, the matrix is factorised without fill-in (`factor`). Contacts with the ground (`ground`) and between parts (`touches`) follow by projected
//! Gauss-Seidel in the factorised space (`contacts`). Momenta, not velocities, are carried from step to step, so that free bodies keep
//! them exactly. All in double precision, and the same on every platform.

mod again;
mod block;
mod contacts;
mod discs;
mod factor;
mod ground;
mod links;
mod section;
mod solver;
#[cfg(test)]
mod tests;
mod touches;
mod turns;

use std::sync::Arc;

use nalgebra::{Isometry3, Translation3};

use self::discs::Discs;
use self::solver::Rods;
use again::Again;

use super::lowering::Lowered;
use super::motion::Placement;
use super::run::{Driven, Run};
use super::{Model, Settings, Simulation, SolverName, Unfit, World, widths};
use crate::design::assembly::{Assembly, Dof};

/// Actuators as rods.
#[derive(Clone, Copy, Debug)]
pub struct Rod {
    /// Into how many pieces the share of each hinge is cut: an even number, so that a disc is in the middle of each whole segment.
    pub discs: usize,
    /// How many times as stiff as its material a beam is, but for the bend that is driven: to ask what hinges leave out.
    pub stiffer: f64,
}

impl Rod {
    /// With so many discs that a rod sags by its weight as it should, within 3 %.
    pub const FINE: Self = Self { discs: 2, stiffer: 1.0 };

    /// A body in a world, with what drives it.
    fn made(self, body: &Assembly, settings: &Settings, world: &World) -> Result<(Rods, Driven), Unfit> {
        let whole = Lowered::new(body, settings)?;
        let discs = Discs::new(body, self.discs)?;
        let lowered = Lowered::new(&discs.assembly, settings)?;
        let segments: Vec<usize> =
            discs.beams.iter().flat_map(|beam| beam.segments.iter().copied()).collect();
        // A segment is where its slices are in the mean: it follows the bodies as one more.
        let placement = |(element, piece): (usize, &usize)| {
            let (piece, shape) = (&lowered.pieces[*piece], body.elements[element].shape);
            match segments.iter().position(|segment| *segment == element) {
                Some(place) => {
                    let local = Isometry3::from_parts(Translation3::identity(), piece.local.rotation);
                    Placement::new(lowered.bodies.len() + place, local, shape)
                }
                None => Placement::new(piece.body, piece.local, shape),
            }
        };
        let placements: Arc<[Placement]> = discs.of_element.iter().enumerate().map(placement).collect();
        let bodies = lowered.bodies.len() + segments.len();
        let dofs: Vec<&Dof> = whole.bodies.iter().filter_map(|body| body.dof.as_ref()).collect();
        let driven = Driven::joints(&dofs, &whole.servos, bodies, body.actuators, placements);
        let rods = Rods::new(&discs, (&whole, &lowered), self.stiffer, settings, world)?;
        Ok((rods, driven))
    }
}

/// Whether an actuator of a body bends: as a rod, or as one that this solver cannot simulate.
#[must_use]
pub fn bends(assembly: &Assembly) -> bool {
    !matches!(discs::beams(assembly), Ok(beams) if beams.is_empty())
}

impl Model for Rod {
    fn name(&self) -> SolverName {
        SolverName::Rod
    }

    fn prepare(&self, assembly: &Assembly, settings: &Settings) -> Result<Box<dyn Simulation>, Unfit> {
        let (rod, settings) = (*self, settings.in_whole_steps());
        let prepared = move |assembly: &Assembly, settings: &Settings| {
            widths::alone(assembly, settings, move |body, settings, world| {
                let (rods, driven) = rod.made(body, settings, world)?;
                Ok(Box::new(Run::new(rods, driven, settings, &[])))
            })
        };
        let first = prepared(assembly, &settings)?;
        let body = assembly.clone();
        Ok(Box::new(Again::new(first, &settings, move |finer: &Settings| prepared(&body, finer).ok())))
    }
}
