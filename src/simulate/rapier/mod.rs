//! The second opinion: rapier3d, maximal coordinates, impulse joints.
//!
//! Bodies are those of the articulated solver (rigidly joined elements merged,
//! as compound colliders), and so are targets, rates, torque limits and
//! friction; joints, contacts and the rest are rapier's. Its chains of joints
//! converge slowly, and until they do their servos are too soft: each step is
//! cut into substeps of at most 1/7680 s with as many sweeps each as the
//! settings have iterations. With eight, one hinge sags by what it should and a
//! chain of five by twice that, at two hundred times the cost of the
//! articulated solver (joint warm starting, which ought to help, changes
//! nothing in this version). A disagreement is thus a warning, not a verdict. Balls and springs are
//! bodies that do not rotate and spring joints, whose lengths at rest and radii change. The
//! world is in cm, g and s, as rapier's tolerances are meant for bodies of
//! about unit size.

mod hinges;
mod springs;

use self::hinges::Hinges;
use self::springs::Springs;
use super::lattice::Lattice;
use super::lowering::Lowered;
use super::run::Run;
use super::{Model, Settings, Simulation, SolverName, Unfit, widths};
use crate::design::assembly::Assembly;

/// rapier3d with impulse joints.
#[derive(Clone, Copy, Debug)]
pub struct Rapier {
    /// Longest substep in s.
    pub substep: f64,
}

impl Rapier {
    /// With substeps so short that a chain of hinges is about twice as soft as it should be.
    pub const FINE: Self = Self { substep: 1.0 / 7680.0 };
}

impl Model for Rapier {
    fn name(&self) -> SolverName {
        SolverName::Rapier
    }

    fn prepare(&self, assembly: &Assembly, settings: &Settings) -> Result<Box<dyn Simulation>, Unfit> {
        let substep = self.substep;
        widths::alone(assembly, &settings.in_whole_steps(), move |body, settings, world| {
            if !body.springs.is_empty() {
                let lattice = Lattice::new(body, settings)?.sloping(world, settings);
                let springs = Springs::new(&lattice, settings, substep);
                return Ok(Box::new(Run::new(springs, lattice.driven(), settings, &[])));
            }
            let lowered = Lowered::new(body, settings)?;
            if has_chained_sockets(&lowered) {
                let reason =
                    "rapier is far too soft where one socket is attached to another: use the solver `articulated`"
                        .to_owned();
                return Err(Unfit { reason });
            }
            let hinges = Hinges::new(&lowered, settings, world.gravity(settings), substep);
            Ok(Box::new(Run::new(hinges, lowered.driven(), settings, &[])))
        })
    }
}

/// Whether what hangs on a socket holds another one. Rings that have next to no mass then carry all that follows.
fn has_chained_sockets(lowered: &Lowered) -> bool {
    let hangs_in_socket = |body: usize| body > 0 && lowered.bodies[lowered.bodies[body].parent].is_massless();
    (1..lowered.bodies.len())
        .filter(|body| !lowered.bodies[*body].is_massless() && hangs_in_socket(*body))
        .any(|body| {
            let mut holder = lowered.bodies[body].parent;
            while lowered.bodies[holder].is_massless() {
                holder = lowered.bodies[holder].parent;
            }
            hangs_in_socket(holder)
        })
}
