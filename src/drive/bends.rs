//! What each actuator is asked for, and what its hardware lets it do: over the whole motion, from rest.

use grammar_lang::eval::EvalError;
use grammar_lang::ir::{JointKind, Tendon, Ty};

use super::hardware::follow;
use super::{Asked, Conditions, Cycle, Drive};
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
        self.followed(parameters, self.asked(parameters, &Conditions::NOMINAL)?)
    }

    /// The same where the actuators of a cycle are asked for its points, and in between for what lies straight between
    /// them: as a board plays it. Servos turn straight from one point to the next, whatever bends that comes to.
    ///
    /// # Errors
    ///
    /// [`EvalError`] when an expression of the actuation has no value.
    pub fn bends_by_points(&self, parameters: &[f64], cycle: &Cycle) -> Result<Bends, EvalError> {
        let mut asked = self.asked(parameters, &Conditions::NOMINAL)?;
        for (id, points) in &cycle.actuators {
            let column = self.actuators.iter().position(|driven| driven.id == *id);
            let (Some(column), Asked::Bends(points)) = (column, points) else { continue };
            let threads = self.actuators.get(column).and_then(|driven| self.threads(driven));
            let played = played(points, threads);
            for sample in 0..asked.samples() {
                let place = sample as f64 * asked.interval / cycle.period;
                if let Some(cell) = asked.cell(sample, column) {
                    *cell = played(place);
                }
            }
        }
        self.followed(parameters, asked)
    }

    fn followed(&self, parameters: &[f64], mut asked: Targets) -> Result<Bends, EvalError> {
        let mut followed = asked.clone();
        self.on_hardware(parameters, &Conditions::NOMINAL, &mut followed)?;
        for (column, driven) in self.actuators.iter().enumerate() {
            let actuator = self.kind_of(driven).and_then(|kind| self.candidate.rules.actuators.get(kind));
            // A spin is asked for a speed, which nothing limits but its motor.
            let stands = actuator.filter(|actuator| actuator.joint.kind != JointKind::Spin);
            let made = stands.and_then(|_| self.made(driven));
            if let Some(motor) = made.and_then(|made| made.motor.as_ref()) {
                follow([&motor.speed, &motor.relaxing_speed], 1.0, &mut followed, column);
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

/// The bend at a place in cycles where a board plays these points.
fn played(points: &[f64], threads: Option<&Tendon>) -> impl Fn(f64) -> f64 {
    let turned: Vec<f64> =
        points.iter().map(|bend| threads.map_or(*bend, |threads| threads.turned(*bend))).collect();
    move |place| {
        let turned = between(&turned, place);
        threads.map_or(turned, |threads| threads.bend(turned))
    }
}

/// What lies straight between points at equal distances over a cycle, at a place in cycles.
fn between(points: &[f64], place: f64) -> f64 {
    let count = points.len();
    let at = (place - libm::floor(place)) * count as f64;
    let (row, part) = (libm::floor(at) as usize, at - libm::floor(at));
    let point = |row: usize| points.get(row % count.max(1)).copied().unwrap_or(0.0);
    point(row) + part * (point(row + 1) - point(row))
}

#[cfg(test)]
mod tests {
    use grammar_lang::ir::{Table, Tendon};

    use super::{between, played};

    /// A thread that takes twice as much to one side: half way between the ends of the servo is no half way between the
    /// bends.
    #[test]
    fn servos_turn_straight_from_point_to_point() {
        let threads = Tendon {
            servo: vec!["D3".to_owned()],
            opposite: Vec::new(),
            thread: Table { rows: vec![[-1.0, -0.01], [0.0, 0.0], [1.0, 0.02]] },
            wheel: 0.01,
            turn: (-2.0, 2.0),
            speed: 2.0,
            pulse: (1e-3, 2e-3),
            rests: true,
        };
        let points = [-1.0, 1.0];
        let (bent, wound) = (played(&points, None), played(&points, Some(&threads)));
        for (place, straight, by_thread) in [(0.0, -1.0, -1.0), (0.25, 0.0, 0.25), (0.5, 1.0, 1.0)] {
            assert!(
                (bent(place) - straight).abs() < 1e-12 && (wound(place) - by_thread).abs() < 1e-12,
                "{place}"
            );
        }
    }

    #[test]
    fn points_are_joined_by_straight_lines_and_the_last_with_the_first() {
        let points = [0.0, 2.0, 1.0, -1.0];
        for (place, bend) in [(0.0, 0.0), (0.125, 1.0), (0.5, 1.0), (0.875, -0.5), (2.25, 2.0), (-0.25, -1.0)]
        {
            assert!((between(&points, place) - bend).abs() < 1e-12, "{place}");
        }
        assert_eq!(between(&[], 0.3), 0.0);
    }
}
