//! Makes motions again, in finer steps, that were refused.
//!
//! A step changes the state by what forces are at its beginning, and in rare cases a contact, or the end of a range, throws a light part so far
//! that the books do not balance any more. That says that the step is too long for this motion, and nothing of the motion itself.

use crate::simulate::{Case, Invalid, Motion, Settings, Simulation, Stop, Watch};

/// Simulations of one body, each in finer steps than the one before it.
pub(super) struct Again<M> {
    first: Box<dyn Simulation>,
    /// Those in finer steps, once they are needed.
    finer: Vec<Box<dyn Simulation>>,
    /// Those of the first.
    settings: Settings,
    make: M,
}

/// How often the step is halved before a motion is refused for good.
const HALVINGS: usize = 2;

impl<M: Fn(&Settings) -> Option<Box<dyn Simulation>> + Send> Again<M> {
    pub(super) fn new(first: Box<dyn Simulation>, settings: &Settings, make: M) -> Self {
        Self { first, finer: Vec::new(), settings: settings.clone(), make }
    }

    /// A refused motion in finer steps; as it was where that does not help.
    fn again(
        &mut self,
        stop: Stop<'_>,
        case: &Case<'_>,
        refused: Invalid,
    ) -> Option<Result<Motion, Invalid>> {
        for halving in 0..HALVINGS {
            if self.finer.len() == halving {
                let step = self.settings.step / f64::from(2_u32 << halving);
                let Some(finer) = (self.make)(&Settings { step, ..self.settings.clone() }) else { break };
                self.finer.push(finer);
            }
            let made = self.finer.get_mut(halving)?.run_cases(stop, std::slice::from_ref(case))?;
            if let Some(Ok(motion)) = made.into_iter().next() {
                return Some(Ok(motion));
            }
        }
        Some(Err(refused))
    }
}

impl<M: Fn(&Settings) -> Option<Box<dyn Simulation>> + Send> Simulation for Again<M> {
    fn lanes(&self) -> usize {
        self.first.lanes()
    }

    fn run_watched(
        &mut self,
        stop: Stop<'_>,
        cases: &[Case<'_>],
        watch: &dyn Watch,
    ) -> Option<Vec<Result<Motion, Invalid>>> {
        let mut motions = self.first.run_watched(stop, cases, watch)?;
        for (motion, case) in motions.iter_mut().zip(cases) {
            // What decides on its way may remember what it has decided.
            if let (
                Err(refused @ (Invalid::EnergyFromNowhere | Invalid::TooFast | Invalid::NotFinite)),
                None,
            ) = (&*motion, case.controller)
            {
                *motion = self.again(stop, case, *refused)?;
            }
        }
        Some(motions)
    }
}
