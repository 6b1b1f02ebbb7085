//! What each actuator is asked for, and what its hardware lets it do: over the whole motion, from rest.

use grammar_lang::eval::EvalError;
use grammar_lang::ir::Ty;

use super::Drive;
use super::hardware::follow;
use crate::design::PartId;
use crate::simulate::Targets;

/// The bends of the actuators of one drive, rad, at the interval of the model's control.
#[derive(Clone, Debug, PartialEq)]
pub struct Bends {
    /// The actuators, by column.
    pub actuators: Vec<PartId>,
    /// What they are asked for. Valves are asked for no bend: there it is what they come to.
    pub asked: Targets,
    /// What the hardware and the actuators' own speeds make of it.
    pub followed: Targets,
}

impl Drive<'_> {
    /// What the actuators are asked for and do, without any body: as if nothing weighed anything.
    ///
    /// # Errors
    ///
    /// [`EvalError`] when an expression of the actuation has no value.
    pub fn bends_over_time(&self, parameters: &[f64]) -> Result<Bends, EvalError> {
        let mut asked = self.asked(parameters)?;
        let mut followed = self.targets(parameters)?;
        for (column, driven) in self.actuators.iter().enumerate() {
            let actuator = self.kind_of(driven).and_then(|kind| self.rules.actuators.get(kind));
            if let Some(actuator) = actuator {
                follow([&actuator.bending_speed, &actuator.relaxing_speed], &mut followed, column);
            }
            let drives = self.actuations.get(driven.actuation).map(|(_, actuation)| &actuation.drive.ty);
            if drives == Some(&Ty::Valves) {
                for sample in 0..asked.samples() {
                    let bend = followed.cell(sample, column).copied();
                    if let (Some(cell), Some(bend)) = (asked.cell(sample, column), bend) {
                        *cell = bend;
                    }
                }
            }
        }
        let actuators = self.actuators.iter().map(|driven| driven.id).collect();
        Ok(Bends { actuators, asked, followed })
    }
}
