//! Soft material as balls held together by springs: explicit dynamics.
//!
//! Each ball is a lump of material that moves but does not rotate: its neighbours hold it. A step
//! takes the forces of all springs (`springs`), kicks the velocities, lets balls touch each other
//! (`touch`, whose candidates `near` finds) and the `ground`, and moves the balls. As masses are points
//! and forces explicit, a contact with the ground is solved exactly, ball by ball, without sweeps, and
//! what stands still stands as the springs' stiffness says, whatever the step. The price is a
//! longest step, which `stable` knows. `swell` turns targets into strains, `order` puts springs so that
//! four at a time go through the vectors of the processor, and `ledger` keeps the books.
//!
//! Nothing depends on the platform: additions, multiplications, divisions and roots in 32 bits, never
//! fused, in one order.

mod ground;
mod ledger;
mod near;
mod order;
mod solver;
mod springs;
mod stable;
mod swell;
#[cfg(test)]
mod tests;
mod touch;
mod vector;

use fearless_simd::{Level, Simd};

use self::solver::Solver;
use super::lattice::Lattice;
use super::run::{Row, Run};
use super::{Model, Settings, Simulation, SolverName, Unfit, widths};
use crate::design::assembly::Assembly;

/// Balls and springs, in single precision.
#[derive(Clone, Copy, Debug, Default)]
pub struct Balls;

impl Model for Balls {
    fn name(&self) -> SolverName {
        SolverName::Balls
    }

    fn prepare(&self, assembly: &Assembly, settings: &Settings) -> Result<Box<dyn Simulation>, Unfit> {
        widths::alone(assembly, &settings.in_whole_steps(), |body, settings, world| {
            let lattice = Lattice::new(body, settings)?.sloping(world, settings);
            stable::check(&lattice, settings)?;
            let unfit = || Unfit { reason: "this processor cannot simulate this number of balls".to_owned() };
            widest(&lattice, settings).ok_or_else(unfit)
        })
    }
}

/// With the widest instructions that this processor has; all give the same bits.
fn widest(lattice: &Lattice, settings: &Settings) -> Option<Box<dyn Row>> {
    let level = Level::new();
    #[cfg(target_arch = "x86_64")]
    {
        if let Some(kit) = level.as_avx2() {
            return make(kit, lattice, settings);
        }
        if let Some(kit) = level.as_sse2() {
            return make(kit, lattice, settings);
        }
    }
    #[cfg(target_arch = "aarch64")]
    if let Some(kit) = level.as_neon() {
        return make(kit, lattice, settings);
    }
    fearless_simd::dispatch!(level, kit => make(kit, lattice, settings))
}

fn make<K: Simd>(kit: K, lattice: &Lattice, settings: &Settings) -> Option<Box<dyn Row>> {
    let solver = Solver::new(kit, lattice, settings)?;
    Some(Box::new(Run::new(solver, lattice.driven(), settings, &[])))
}
