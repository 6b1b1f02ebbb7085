//! What a servo wants: its rate-limited target, the same for all solvers.

use crate::design::assembly::{Control, Dof, Travel};

/// The moving target of one degree of freedom: an angle in rad or a distance in m, or the speed of a motor in rad/s.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Servo {
    travel: Travel,
    control: Control,
    share: f64,
    /// Where the servo's own target stands now.
    pub(super) target: f64,
}

impl Servo {
    /// At rest.
    pub(super) fn new(dof: &Dof) -> Self {
        let target = if let Control::Passive { neutral } = dof.control { neutral } else { 0.0 };
        Self { travel: dof.travel, control: dof.control, share: dof.share, target }
    }

    /// The same servo with so many times the speed.
    pub(super) fn faster(&self, times: f64) -> Self {
        Self { control: self.control.faster(times), ..self.clone() }
    }

    /// Of an actuator that is where it is asked to be.
    pub(super) fn free(actuator: usize) -> Self {
        let rate = f64::INFINITY;
        let control = Control::Position { actuator, rate, relaxing_rate: rate, rest: 0.0 };
        Self { travel: Travel::Turn, control, share: 1.0, target: 0.0 }
    }

    /// Moves the target for `step` seconds towards what its actuator is asked for. False if that is no number at all.
    #[inline]
    pub(super) fn follow(&mut self, asked: impl Fn(usize) -> f64, step: f64) -> bool {
        match self.control {
            Control::Position { actuator, rate, relaxing_rate, rest } => {
                let wanted = asked(actuator) * self.share - rest;
                self.target = slew(self.target, wanted, rate, relaxing_rate, step);
                wanted.is_finite()
            }
            Control::Speed { actuator, times } => {
                self.target = asked(actuator) * self.share * times;
                self.target.is_finite()
            }
            Control::Passive { .. } => true,
        }
    }
}

/// Moves `from` towards `to` for a time, at one rate away from zero and at
/// another towards it.
///
/// A move through zero spends part of the time on either side, so that the
/// path is the same however finely time is cut.
fn slew(from: f64, to: f64, away: f64, back: f64, time: f64) -> f64 {
    let inward = if from * to <= 0.0 { 0.0 } else { to };
    let (mut at, mut left) = (from, time);
    if inward.abs() < from.abs() {
        let way = from.abs() - inward.abs();
        let reach = back * left;
        if reach < way {
            return from - reach * from.signum();
        }
        at = inward;
        left -= way / back;
    }
    let way = (to - at).abs();
    // A rate without limit times no time left would be no number.
    if left > 0.0 && away * left < way {
        at + away * left * (to - at).signum()
    } else if left > 0.0 {
        to
    } else {
        at
    }
}

/// Turns the positions of joints into that of each actuator: from its base to its tip.
///
/// It is the one whose shares come closest to those of the joints (least
/// squares); for equal shares that add up to one it is the sum. Of motors these are speeds.
#[derive(Clone, Debug)]
pub(super) struct Bends {
    /// Actuator and weight of each joint that something drives, and where the joint stands at rest.
    weights: Vec<Option<(usize, f64, f64)>>,
    actuators: usize,
}

impl Bends {
    /// For joints in the order in which their positions will be given.
    pub(super) fn new(dofs: &[&Dof], actuators: usize) -> Self {
        let mut squares = vec![0.0; actuators];
        for dof in dofs {
            if let Some(actuator) = dof.actuator() {
                squares[actuator] += dof.share * dof.share;
            }
        }
        let weight = |dof: &&Dof| {
            let actuator = dof.actuator()?;
            let square: f64 = squares[actuator];
            let rest = if let Control::Position { rest, .. } = dof.control { rest } else { 0.0 };
            Some((actuator, if square > 0.0 { dof.share / square } else { 1.0 }, rest))
        };
        Self { weights: dofs.iter().map(weight).collect(), actuators }
    }

    /// For numbers that are the bends, one for each actuator.
    pub(super) fn themselves(actuators: usize) -> Self {
        Self { weights: (0..actuators).map(|actuator| Some((actuator, 1.0, 0.0))).collect(), actuators }
    }

    /// How fast the bends change, by how fast the joints move.
    pub(super) fn rates(&self, joints: impl Iterator<Item = f64>) -> Vec<f64> {
        let mut rates = vec![0.0; self.actuators];
        for (weight, rate) in self.weights.iter().zip(joints) {
            if let &Some((actuator, weight, _)) = weight {
                rates[actuator] += weight * rate;
            }
        }
        rates
    }

    /// Appends the bends that belong to the positions.
    pub(super) fn append(&self, positions: impl Iterator<Item = f64>, bends: &mut Vec<f64>) {
        let start = bends.len();
        bends.resize(start + self.actuators, 0.0);
        for (weight, position) in self.weights.iter().zip(positions) {
            if let &Some((actuator, weight, rest)) = weight {
                bends[start + actuator] += weight * (position + rest);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::slew;

    /// The path does not depend on how finely time is cut, also through zero.
    #[test]
    fn slewing_is_independent_of_the_step() {
        for (from, to) in [(0.0, 1.0), (0.8, -0.7), (-0.8, 0.7), (0.9, 0.2), (0.5, 0.0), (-0.2, -0.9)] {
            let whole = slew(from, to, 3.0, 1.3, 0.4);
            let mut fine = from;
            for _ in 0..64 {
                fine = slew(fine, to, 3.0, 1.3, 0.4 / 64.0);
            }
            assert!((whole - fine).abs() < 1e-12, "{from} to {to}: {whole} and {fine}");
        }
    }

    #[test]
    fn bending_and_relaxing_have_their_own_rates() {
        assert!((slew(0.1, 1.0, 3.0, 1.0, 0.1) - 0.4).abs() < 1e-12);
        assert!((slew(0.9, 0.0, 3.0, 1.0, 0.1) - 0.8).abs() < 1e-12);
        assert!((slew(0.1, -1.0, 3.0, 1.0, 0.2) + 0.3).abs() < 1e-12);
    }

    #[test]
    fn limits_may_be_absent_or_closed() {
        let free = f64::INFINITY;
        assert_eq!(slew(0.3, -0.7, free, free, 0.01), -0.7);
        assert_eq!(slew(0.3, 0.3, free, free, 0.01), 0.3);
        assert_eq!(slew(0.3, 0.7, 0.0, 0.0, 0.01), 0.3);
        assert_eq!(slew(0.3, -0.7, 0.0, 0.0, 0.01), 0.3);
    }
}
